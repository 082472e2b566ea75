"""Harmonics of a table of values over one period, and how far to trust what lies between the values.

Method: the trigonometric polynomial through N evenly spaced values (its coefficients are their discrete
Fourier transform), cut after the fewest harmonics that do. Its error is measured as the largest difference to
another smooth curve, the periodic cubic spline through all of the values, between them and at them: where two
such curves differ, the values do not say what lies between. Source: Trefethen, Approximation Theory and
Approximation Practice (2013); de Boor, A Practical Guide to Splines (1978).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

MOST_ORDERS = 24
_FINER = 16  # points at which the two curves are compared, for each value


class Series(NamedTuple):
    """A mean, harmonics as (order, cosine, sine), and the error as a share of the values' range."""

    mean: float
    harmonics: tuple[tuple[int, float, float], ...]
    error: float


@lru_cache(maxsize=256)
def series(table: tuple[float, ...], tolerance: float) -> Series:
    """Give the shortest series whose error is within a tolerance; the best one where none is.

    Parameters
    ----------
    table : tuple of float
        At least three values, the first at phase 0, the last a step before the period's end; not all alike.
    tolerance : float
        Of the error, as a share of the values' range.
    """
    from scipy.interpolate import CubicSpline

    values = np.array(table)
    count = len(values)
    places = 2 * np.pi * np.arange(count + 1) / count
    fine = 2 * np.pi * np.arange(count * _FINER) / (count * _FINER)
    spline = CubicSpline(places, np.append(values, values[0]), bc_type="periodic")(fine)
    spectrum = np.fft.rfft(values) / count
    best, curve, terms = None, np.full(len(fine), spectrum[0].real), []
    for n in range(1, min(MOST_ORDERS, count // 2) + 1):
        twice = 1 if 2 * n == count else 2
        a, b = twice * spectrum[n].real, -twice * spectrum[n].imag
        terms.append((n, float(a), float(b)))
        curve = curve + a * np.cos(n * fine) + b * np.sin(n * fine)
        error = float(np.abs(curve - spline).max() / np.ptp(values))
        if best is None or error < best.error:
            best = Series(float(spectrum[0].real), tuple(terms), error)
        if error <= tolerance:
            break
    return best
