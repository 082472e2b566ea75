"""Tests of derivatives in parameters."""
