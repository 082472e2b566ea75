"""Figures of periodic orbits."""
