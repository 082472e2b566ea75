"""Periodic orbits, their multipliers, and their branches over a parameter."""
