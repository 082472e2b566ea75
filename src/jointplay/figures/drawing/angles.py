"""Angles in degrees: wrapped, unwrapped, on the principal branch; and lines interrupted at jumps."""

import numpy as np


def wrapped(degrees: np.ndarray) -> np.ndarray:
    """Return the angle from -180 up to 180 deg."""
    return _within(degrees, 360.0)


def principal(degrees: np.ndarray) -> np.ndarray:
    """Return the principal branch of the arctangent, from -90 up to 90 deg: opposite directions are one."""
    return _within(degrees, 180.0)


def unwrapped(degrees: np.ndarray) -> np.ndarray:
    """Return the angle followed beyond half a turn, from the first sample on; gaps stay gaps."""
    followed, there = degrees.astype(float), np.isfinite(degrees)
    followed[there] = np.unwrap(degrees[there], period=360.0)
    return followed


def broken(degrees: np.ndarray, span: float, *arrays: np.ndarray) -> list[np.ndarray]:
    """Interrupt a line where an angle jumps by more than half its range `span`.

    Each of `arrays` gets a sample more at every jump: NaN in those that are the angle itself, else what the
    sample after the jump has.
    """
    jumps = np.flatnonzero(np.abs(np.diff(degrees)) > span / 2) + 1
    return [np.insert(array, jumps, np.nan if array is degrees else array[jumps]) for array in arrays]


def _within(degrees: np.ndarray, span: float) -> np.ndarray:
    return (degrees + span / 2) % span - span / 2
