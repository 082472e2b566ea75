"""Timings against other solvers."""
