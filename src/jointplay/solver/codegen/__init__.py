"""Equations to derivatives, common subexpressions and straight-line numba source."""
