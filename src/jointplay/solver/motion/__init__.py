"""Motions of models: one by one, in lanes, beside others; how far they are, and their clean end."""
