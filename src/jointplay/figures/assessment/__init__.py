"""Figures of assessments."""
