"""Optimisation over exact derivatives: the mechanism whose motion is best within bounds."""
