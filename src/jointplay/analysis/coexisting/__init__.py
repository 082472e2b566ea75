"""Coexisting motions: their search, and knocks that throw one into another."""
