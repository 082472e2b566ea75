"""Motions of closed form from event to event, in complex numbers: derivatives by the complex step are exact.

Impact pair (free flight between impacts) and soft impact pair (flight, then one wall's Kelvin-Voigt contact,
where the right-hand side jumps), both driven by y'' = sin t from time 0.
"""

from __future__ import annotations

import cmath

import numpy as np

STEP = 1e-30


def derivatives(function, *values):
    """Rows: the derivative of a vector function in each of its numbers."""
    shifted = np.array(values, dtype=complex) + 1j * STEP * np.eye(len(values))
    return np.array([np.imag(function(*row)) / STEP for row in shifted])


def _root(gap, guess):
    """Complex Newton from a real guess; `gap` gives a value and its rate."""
    t = complex(guess)
    for _ in range(60):
        value, rate = gap(t)
        t -= value / rate
    return t


def _flight(t0, y0, v0, t):
    v = v0 + cmath.cos(t0) - cmath.cos(t)
    return y0 + (v0 + cmath.cos(t0)) * (t - t0) - cmath.sin(t) + cmath.sin(t0), v


def _first(path, level, t0, until):
    """Time from t0 on at which a path first reaches a level to either side; None if it does not."""
    times = np.linspace(t0.real + 1e-9, until, 4001)
    beyond = [abs(path(t)[0].real) - level.real for t in times]
    i = next((i for i, gap in enumerate(beyond) if gap > 0), None)
    if i is None:
        return None
    side = np.sign(path(times[i])[0].real)
    return _root(lambda t: (side * path(t)[0] - level, side * path(t)[1]), times[i]), side


def impacts(until):
    """State of the impact pair at a time, over gap, restitution, start (y, v)."""

    def state(gap, restitution, y, v):
        t0 = 0j
        while True:
            start = (t0, y, v)
            met = _first(lambda t, start=start: _flight(*start, t), gap / 2, t0, until)
            if met is None:
                return np.array(_flight(*start, until))
            t, side = met
            y, v = side * gap / 2, -restitution * _flight(*start, t)[1]
            t0 = t

    return state


def one_entry(until):
    """State of the soft impact pair, in contact for the first time, over gap, stiffness, damping, y, v."""

    def state(gap, K, C, y, v):
        t0, side = _first(lambda t: _flight(0, y, v, t), gap / 2, 0j, until)
        y, v = (side * each for each in _flight(0, y, v, t0))
        # u'' + C u' + K u = side sin t, u = side y - gap/2: forced part a sin t + b cos t
        a, b = side * (K - 1) / ((K - 1) ** 2 + C**2), -side * C / ((K - 1) ** 2 + C**2)
        u, w = y - gap / 2 - a * cmath.sin(t0) - b * cmath.cos(t0), v - a * cmath.cos(t0) + b * cmath.sin(t0)
        root, s = cmath.sqrt(K - C**2 / 4), until - t0
        q, fall = (w + C * u / 2) / root, cmath.exp(-C * s / 2)
        cos, sin = fall * cmath.cos(root * s), fall * cmath.sin(root * s)
        u, w = u * cos + q * sin, (q * root - C * u / 2) * cos - (u * root + C * q / 2) * sin
        u += a * cmath.sin(until) + b * cmath.cos(until)
        w += a * cmath.cos(until) - b * cmath.sin(until)
        return side * np.array([u + gap / 2, w])

    return state
