"""Tests, as a package so that they share references and helpers."""
