"""Rigid walls: impacts, rest, sliding and release."""
