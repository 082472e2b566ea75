"""Signals of a motion: 0-1 test, spectrum, dimension."""
