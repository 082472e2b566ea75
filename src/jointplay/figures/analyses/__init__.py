"""Figures of analyses, but of single motions."""
