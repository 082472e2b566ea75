"""Closure of ideal loops: vectors, dyads and larger groups."""
