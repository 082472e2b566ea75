"""Saltation: how tangents jump at an event.

The guard's gradient says how much earlier or later a neighbour meets it, and for that time it moves at the
other side's rate:

    d+ = d- + (F+ - F-) (grad h . d-) / h',                 h' = dh/dt + grad h . F-
    d+ = D d- + (F+ - D F- - dR/dt) (grad h . d-) / h'      where the state is reset by R, D = dR/dx.

Several mode changes at one event are one jump from F- to F+. Onset of sticking loses a dimension. References:
Leine and Nijmeijer (2004), chapter 7; Kong et al., arXiv 2306.06862.
"""

from math import log

import numpy as np

from .frame import determinant, orthonormalise
from .interface import inner
from .modes import STICK, mask, variant_of
from .tangent import GRAZING, HELD, JUMPS, ONSET, SALTATION, VOLUME


@inner
def _rates(f, variant, x, o, y, out):
    """Rate of the state at the base point."""
    first, n_x = o.first, o.n_q + o.n
    for i in range(8 * first, 8 * (first + 1 + n_x)):
        y.w[i] = 0.0
    mask(x.modes, x.m)
    f.rate(variant, y.w, x.s, x.p, x.m)
    for r in range(o.n_q):
        out[r] = x.s[1 + o.n_q + r]
    for r in range(o.n):
        out[o.n_q + r] = y.w[8 * (first + 1 + n_x + r) + 7]


@inner
def _stuck(modes):
    held = 0
    for mode in modes:
        held += mode == STICK
    return held


@inner
def meet(f, g, variant, x, o, y, guard):
    """Note what the jump at an event needs of the side before it."""
    f.trig(x.s, x.p)
    _rates(f, variant, x, o, y, y.before)
    g.gradient(guard, x.s, x.p, x.m, y.gradient)
    if guard >= 4 * len(x.modes):
        g.turned(guard - 4 * len(x.modes), x.s, x.p, y.D)
    y.real[ONSET] = _stuck(x.modes)


@inner
def leap(f, g, x, o, y, guard):
    """Take the tangents through an event that has just been handled."""
    n_x, reset, real = o.n_q + o.n, guard >= 4 * len(x.modes), y.real
    width = 1 + n_x
    _rates(f, variant_of(x.modes), x, o, y, y.after)
    slope, size, later = y.gradient[0], abs(y.gradient[0]), y.gradient[0]
    for r in range(n_x):
        term = y.gradient[1 + r] * y.before[r]
        slope += term
        size += abs(term)
        later += y.gradient[1 + r] * y.after[r]
    real[GRAZING] = min(real[GRAZING], abs(slope) / size if size > 0.0 else 0.0)
    if slope == 0.0:
        return
    lossy = _stuck(x.modes) > real[ONSET]
    y.count[JUMPS] += 1
    real[VOLUME] += _volume(y, o.n_q, n_x, slope, later, reset, lossy)
    for i in range(len(y.alive)):
        if y.alive[i]:
            _through(y, y.d[i * width : (i + 1) * width], o.n_q, n_x, slope, reset, y.count[SALTATION])
    if y.count[HELD] == 0:
        orthonormalise(y.d, width, y.weight, y.alive, y.norms, y.logs, lossy)


@inner
def _through(y, d, n_q, n_x, slope, reset, saltation):
    """Replace a tangent by what the jump makes of it."""
    width, delay = 1 + n_x, 0.0
    if saltation:
        for r in range(n_x):
            delay += y.gradient[1 + r] * d[1 + r]
        delay /= slope
    if not reset:
        for r in range(n_q, n_x):
            d[1 + r] += (y.after[r] - y.before[r]) * delay
        return
    new = y.S[n_x * n_x :]
    for r in range(n_x - n_q):
        turned, swept = 0.0, y.D[r * width]
        for i in range(n_x):
            turned += y.D[r * width + 1 + i] * d[1 + i]
            swept += y.D[r * width + 1 + i] * y.before[i]
        new[r] = turned + (y.after[n_q + r] - swept) * delay
    for r in range(n_q):
        d[1 + r] += (y.after[r] - y.before[r]) * delay
    for r in range(n_x - n_q):
        d[1 + n_q + r] = new[r]


@inner
def _volume(y, n_q, n_x, slope, later, reset, lossy):
    """ln |det S| of the jump."""
    if lossy:
        return -np.inf
    if not reset:
        return log(abs(later / slope)) if later != 0.0 else -np.inf
    for i in range(n_x):  # columns of S are the jumps of unit vectors
        for r in range(1 + n_x):
            y.unit[r] = 1.0 if r == 1 + i else 0.0
        _through(y, y.unit, n_q, n_x, slope, True, True)
        for r in range(n_x):
            y.S[r * n_x + i] = y.unit[1 + r]
    found = abs(determinant(y.S, n_x))
    return log(found) if found > 0.0 else -np.inf
