"""Motions over parameters: bifurcation diagrams and maps."""
