"""Direct runs of two oscillators, by integrators of their own, that share nothing with the program's.

The linear oscillator x'' + 2 d x' + x = f cos(w t) that meets a stop at x = distance: exact between impacts,
as the sum of the steady and the free motion; impacts where the gap, looked at `STEPS` times a period and at
the top between, changes its sign, halved to 1e-12 of a period.

Duffing's x'' + d x' + x + b x^3 = f cos(w t) by the classical Runge-Kutta method.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

STEPS = 48


@njit(cache=True)
def _free(x, v, d, t):
    """Free motion after a time: position and speed."""
    w = math.sqrt(1.0 - d * d)
    e, c, s = math.exp(-d * t), math.cos(w * t), math.sin(w * t)
    return e * (x * c + (v + d * x) / w * s), e * (v * c - (x + d * v) / w * s)


@njit(cache=True)
def impacts(distance, restitution, d, f, w, dropped, watched):
    """Number of impacts in the watched periods, from the steady motion without a stop."""
    a, b = 1.0 - w * w, 2.0 * d * w
    size = a * a + b * b
    p, q = f * a / size, f * b / size  # steady motion p cos + q sin
    period, count, stop = 2.0 * math.pi / w, 0, (dropped + watched) * STEPS
    x, v, t, n = 0.0, 0.0, 0.0, 0  # free part
    dt = period / STEPS
    while n < stop:
        target = (n + 1) * dt
        ended = False
        while not ended:
            span = target - t
            y, u = _free(x, v, d, span)
            here = y + p * math.cos(w * target) + q * math.sin(w * target)
            speed = u + w * (q * math.cos(w * target) - p * math.sin(w * target))
            before = v + w * (q * math.cos(w * t) - p * math.sin(w * t))
            high = span
            if here <= distance and before > 0.0 and speed < 0.0:  # it may have been beyond between
                low_, high_ = 0.0, span
                for _ in range(50):
                    middle = 0.5 * (low_ + high_)
                    y, u = _free(x, v, d, middle)
                    at = t + middle
                    if u + w * (q * math.cos(w * at) - p * math.sin(w * at)) > 0.0:
                        low_ = middle
                    else:
                        high_ = middle
                y, u = _free(x, v, d, low_)
                here = y + p * math.cos(w * (t + low_)) + q * math.sin(w * (t + low_))
                high = low_
            if here > distance:
                low = 0.0
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    y, u = _free(x, v, d, middle)
                    if y + p * math.cos(w * (t + middle)) + q * math.sin(w * (t + middle)) > distance:
                        high = middle
                    else:
                        low = middle
                y, u = _free(x, v, d, low)
                t += low
                whole = u + w * (q * math.cos(w * t) - p * math.sin(w * t))
                x = y
                v = u - (1.0 + restitution) * whole
                if n >= dropped * STEPS:
                    count += 1
                if low == 0.0 and whole <= 0.0:
                    return -1
            else:
                x, v = _free(x, v, d, span)
                t, ended = target, True
        n += 1
        if n % (STEPS * 16) == 0:  # times stay small, and whole periods change nothing
            t -= target
            stop -= n
            if dropped * STEPS >= n:
                dropped -= n // STEPS
            else:
                dropped = 0
            n = 0
    return count


@njit(cache=True)
def all_impacts(distance, restitution, d, f, w, dropped, watched):
    """The same of many."""
    found = np.empty(len(distance), dtype=np.int64)
    for i in range(len(distance)):
        found[i] = impacts(distance[i], restitution[i], d, f, w, dropped, watched)
    return found


@njit(cache=True)
def all_largest(x0, v0, f, w, d, b, dropped, watched):
    """Largest positions of Duffing oscillators in the watched periods."""
    found, steps = np.empty(len(x0)), 64
    for i in range(len(x0)):
        x, v, h, most = x0[i], v0[i], 2.0 * math.pi / w[i] / steps, -1e300
        for n in range((dropped + watched) * steps):
            phase = 2.0 * math.pi * (n % steps) / steps
            c0, c1 = math.cos(phase), math.cos(phase + math.pi / steps)
            c2 = math.cos(phase + 2.0 * math.pi / steps)
            k1, l1 = v, f[i] * c0 - d * v - x - b * x**3
            y, u = x + h / 2 * k1, v + h / 2 * l1
            k2, l2 = u, f[i] * c1 - d * u - y - b * y**3
            y, u = x + h / 2 * k2, v + h / 2 * l2
            k3, l3 = u, f[i] * c1 - d * u - y - b * y**3
            y, u = x + h * k3, v + h * l3
            k4, l4 = u, f[i] * c2 - d * u - y - b * y**3
            x, v = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), v + h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
            if n >= dropped * steps and x > most:
                most = x
        found[i] = most
    return found
