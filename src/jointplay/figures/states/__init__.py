"""Figures over initial states."""
