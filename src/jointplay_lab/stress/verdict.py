"""Verdict on a run of a scene, from a second run with a tighter tolerance.

``ok``: both reached the end, their energy balances closed, their states and contacts agree. ``sensitive``:
likewise, but the states differ by more, as errors of the size of the tolerance grow to in this motion
(`growth`): it is chaotic, or stiff, or at a dead centre. ``stopped``: both ended early with a status that
names the reason. ``unconfirmed``: one of them did. ``suspect``: energy is unaccounted for, or states or
contacts differ by more than that; nothing told so but this comparison. Runs that stopped are held to the
same, as far as both came.

Slipping and sticking are not compared as events: where they matter the states tell.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from jointplay.analysis.quantities import EVENTS
from jointplay_lab.stress.motion import OK, Motion

VERDICTS = ("ok", "sensitive", "stopped", "unconfirmed", "suspect")
CAUSES = ("none", "states", "energy", "contacts")
AGREE = 1e2  # disagreement of states that needs no explanation, in units of the tolerance
GROWN = 1.0  # error that grows, in units of the tolerance: some 0.01 of it is what steps are found to make
CLOSED = 1e2  # energy residual, relative to what flowed, in units of the tolerance
SLIGHT = 100.0  # speed of a contact that only one run has met, in units of the states' disagreement; or the
# square root of that: where a force or gap just touches zero, contacts appear with such a speed
# Of the growth: whether of the tighter run, which alone may show what the other steps over; and how many
# times shorter its blocks are, as is needed for growth that an event soon ends. Where bodies come to rest on
# rigid walls, derivatives lose what the motion keeps: what a twin of the tighter run shows (0) comes last
LOOKS = (*((tighter, closer) for tighter in (False, True) for closer in (1, 4, 16)), (True, 0))
SATURATED = 0.1  # grown errors beyond which the runs are two motions, with contacts of their own
LEVELS = np.concatenate([[0.0], np.logspace(-12, 0, 49)])  # of speeds
COMPARED = tuple(EVENTS.index(name) for name in ("contact", "separation"))  # reopenings are rounding's


@dataclass(frozen=True)
class Verdict:
    """A verdict on a scene.

    Parameters
    ----------
    verdict : str
        Of `VERDICTS`.
    cause : str
        Of `CAUSES`: what was farthest from what can be explained; ``none`` where that is within its bound.
    excess : float
        How far, in units of that bound.
    disagreement : float
        Largest difference of the states at equal times, in units of their sizes.
    growth : float
        Largest growth of a small difference; NaN where it was not needed.
    """

    verdict: str
    cause: str
    excess: float
    disagreement: float
    growth: float


def judge(
    loose: Motion,
    tight: Motion,
    unit: np.ndarray,
    tolerances: tuple[float, float],
    growth: Callable[[bool, int], float],
) -> Verdict:
    """Judge a run by one at a tighter tolerance; `unit` holds the size of each state.

    Where the states differ, `growth` is called for the largest growth of small differences, along this run
    or the tighter one, in blocks so many times shorter; again where that does not explain the difference,
    at last for that of a twin (see `LOOKS`).
    """
    rtol = tolerances[0]
    apart, grown, allowed = disagreement(loose, tight, unit), np.nan, AGREE * rtol
    for look in LOOKS:
        if apart <= allowed or not np.isfinite(apart):
            break
        grown = float(np.fmax(grown, growth(*look)))
        allowed = max(allowed, GROWN * rtol * np.nan_to_num(grown, nan=1.0))
    energy = max(m.residual / (CLOSED * t) for m, t in zip((loose, tight), tolerances, strict=True))
    found = {"states": apart / allowed, "energy": energy, "contacts": 0.0}
    whole = loose.status == tight.status == OK
    if whole and allowed < SATURATED:
        slight = max(SLIGHT * max(apart, AGREE * rtol), math.sqrt(apart))
        found["contacts"] = unmatched(loose, tight) / slight
    cause = max(found, key=lambda name: np.nan_to_num(found[name], nan=np.inf))
    excess = float(found[cause])
    suspect = not excess <= 1.0
    word = "suspect" if suspect else _calm(loose, tight, apart <= AGREE * rtol)
    return Verdict(word, cause if suspect else "none", excess, apart, float(grown))


def _calm(loose: Motion, tight: Motion, agreeing: bool) -> str:
    """The verdict where no difference is suspect."""
    if loose.status != OK and tight.status != OK:
        return "stopped"
    if loose.status != OK or tight.status != OK:
        return "unconfirmed"
    return "ok" if agreeing else "sensitive"


def disagreement(one: Motion, other: Motion, unit: np.ndarray) -> float:
    """Largest difference of the states at the samples that both reached, in units of their sizes.

    Of positions alone where only one run has met an impact on a rigid wall yet, which makes the speeds jump.
    """
    n = min(len(one.states), len(other.states))
    apart = np.abs(one.states[:n] - other.states[:n]) / unit
    between = np.any(one.met[:n] != other.met[:n], axis=1)
    return float(max(np.max(apart[:, : one.positions], initial=0.0), np.max(apart[~between], initial=0.0)))


def unmatched(one: Motion, other: Motion) -> float:
    """Normal speed up to which beginnings and ends of contact must be left out for two runs to have the same.

    In units of the largest met, or of the journal's surface speed if that is larger; 0 where none must. Each
    contact by itself: which of two comes first, where they touch together, is rounding's.
    """
    chosen = [motion.events[np.argsort(motion.events[:, 0], kind="stable")] for motion in (one, other)]
    chosen = [events[np.isin(events[:, 1], COMPARED)] for events in chosen]
    largest = max(1.0, float(np.max(np.abs(np.concatenate(chosen)[:, 2]), initial=0.0)))
    for level in LEVELS:
        kept = [events[np.abs(events[:, 2]) >= level * largest, :2] for events in chosen]
        if np.array_equal(*kept):
            return float(level)
    return 1.0
