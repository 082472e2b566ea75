"""Slow independent answers that the tests compare with."""
