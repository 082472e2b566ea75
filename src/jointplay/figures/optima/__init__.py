"""Figures of optimisations."""
