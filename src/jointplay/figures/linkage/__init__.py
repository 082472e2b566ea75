"""Figures of mechanisms: the linkage with its parts, standing still or moving."""
