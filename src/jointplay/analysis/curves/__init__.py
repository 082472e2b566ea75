"""Curves in the plane of two parameters along which periodic orbits change."""
