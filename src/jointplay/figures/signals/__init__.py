"""Figures of signals."""
