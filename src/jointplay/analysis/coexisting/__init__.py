"""Motions that exist beside each other: which there are, and what throws one into another."""
