"""Tests of optimisation."""
