"""Motions over initial states: divergence of neighbours, fields, basins."""
