"""Positions of a mechanism: chains cut at its clearances, ideal loops and their closure."""
