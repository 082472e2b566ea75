"""Motions of models: one by one, or with others in lanes; their progress, and their clean end."""
