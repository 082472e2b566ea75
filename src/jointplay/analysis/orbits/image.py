"""What a section map makes of a state, and the rate of the state where a run stands."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from jointplay.analysis.tangents import Bundle
from jointplay.codegen import cache


@dataclass(frozen=True)
class Image:
    """What a section map makes of a state.

    Parameters
    ----------
    status : int
        Index into `STATUS`; all else is meaningless unless it is 0.
    state : ndarray
        State at the end, angles brought back by whole turns to near the start's.
    time : float
        Duration, s.
    derivative : ndarray
        Of the free coordinates with respect to themselves, in units of their scales.
    events : ndarray
        Rows: contact, kind, time since the start over the duration, time, positions, speeds, modes.
    grazing : float
        Smallest approach speed of a guard at an event, relative to the terms that it is a sum of.
    """

    status: int
    state: np.ndarray
    time: float = math.nan
    derivative: np.ndarray | None = None
    events: np.ndarray | None = None
    grazing: float = math.inf


def end_rate(bundle: Bundle) -> np.ndarray:
    """Rate of the state where a run stands."""
    from jointplay.numerics.modes import mask, variant_of

    scene, x, o = bundle.scene, bundle.x, bundle.o
    module = cache.structure_module(scene.structure)
    w = np.zeros_like(bundle.k.w)
    module.trig(x.s, x.p)
    mask(x.modes, x.m)
    module.rate(variant_of(x.modes), w, x.s, x.p, x.m)
    n_x = o.n_q + o.n
    speeds = x.s[1 + o.n_q : 1 + o.n_q + o.n_q]
    accelerations = w[8 * (o.first + 1 + n_x) :].reshape(-1, 8)[: o.n, 7]
    return np.concatenate([speeds, accelerations])
