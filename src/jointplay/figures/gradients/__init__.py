"""Figures of derivatives in parameters."""
