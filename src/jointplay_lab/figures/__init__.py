"""Figures of the laboratory's results."""
