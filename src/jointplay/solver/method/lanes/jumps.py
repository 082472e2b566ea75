"""Jumps of the state in a lane of an ensemble, compiled only for structures that have some.

As at a wall (method.walls.walls); where a body may rest, or meets two walls at once, its lane steps aside.
"""

from ..interface import inner
from ..modes import GAP, IMPACT, look
from ..walls.walls import low, move, throw_off
from . import layout as rows
from .attempts import aside
from .exchange import begin_event, end_event, settings
from .memory import PART


@inner
def _met_too(k, o, c):
    """Whether another wall was met at the instant at which the state has left wall c."""
    for at in range(len(k.flags), len(k.modes)):
        near = k.contact[6 * at] <= abs(k.contact[6 * at + 2]) * o.near
        if at != c and near and k.contact[6 * at + 1] >= 0.0:
            return True
    return False


@inner
def jump(f, k, j, i):
    """The state of a lane jumps."""
    c, o = k.whole[8 * rows.AT + i] // 4, settings(j.real[k.whole[8 * rows.JOB + i]])
    w, number, fired = k.w, c - len(k.flags), 1.0
    begin_event(f, k, j, i)
    look(f.contacts, k.modes, k.m, k.s, k.p, k.contact)
    if k.contact[6 * c + 1] < 0.0:
        move(f, number, k, k, o)
        fired = 0.0
    elif k.contact[6 * c + 2] < 0.0:
        f.reset(number, k.s, k.p)
        look(f.contacts, k.modes, k.m, k.s, k.p, k.contact)
        throw_off(k, k, o)
        if low(k.contact[6 * c + 2], k.contact[6 * c + 5], o) or _met_too(k, o, c):
            aside(k, j, i)
    else:
        aside(k, j, i)
    w[8 * (rows.FIRED + 4 * c + GAP) + i] = fired
    for r in range(k.n_q):
        w[8 * (rows.POSITION + k.phases + r) + i] = k.s[1 + r]
    for r in range(k.n - k.phases):
        w[8 * (rows.SPEED + k.phases + r) + i] = k.s[1 + k.n_q + r]
    end_event(k, j, i, c, IMPACT + 0 * c)


UNIT = {"jump": PART}
