"""Where motions end: from each of some starts, the section points that are left when the transient has gone.

A start is followed for the transient's turns and then for the turns that are looked at. A record that shows
no period is followed further, a few times as long, before it counts as having none: a slow approach to a
periodic motion is told from chaos so. Points are compared in units that make tolerances mean the same for all
mechanisms: journals' centres over their clearances, links' speeds over the nominal speed; a test system's
states as they are. A system that nothing forces is cut at equal times, its nominal periods.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jointplay.analysis import rules as asked
from jointplay.analysis.ensemble_runs import follow_ensemble
from jointplay.analysis.exponents.growth import STATE
from jointplay.analysis.period import period
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place
from jointplay.analysis.states.journal_position import Journals
from jointplay.analysis.states.start_plane import Starts
from jointplay.analysis.trajectory import Records, Request, follow
from jointplay.codegen import cache
from jointplay.mechanism.model import Model
from jointplay.mechanism.records import CrankAngle

STRICTER = 10  # a period is found at a tolerance so many times smaller than that by which ends are matched
POINTS = 128  # kept of an end without a period, over all tries; more only where more turns are looked at
BAD, STOPPED = STATUS.index("bad_parameters"), STATUS.index("not_converged")


@dataclass(frozen=True)
class Watch:
    """How long ends are looked for: turns of transient, turns looked at, further tries; tolerances.

    `ensemble`: eight motions at once (analysis.ensemble_runs).
    """

    transient: int
    turns: int
    patience: int
    tolerance: float
    rtol: float
    max_steps: int | None = None
    ensemble: bool = False


def ends(mechanism, initial, joint, names, values, watch: Watch) -> dict[str, Any]:
    """Follow some nodes to their ends.

    Returns
    -------
    dict
        ``node_status`` and ``period`` (0: none), an entry a node; ``states``, a list of arrays: the states at
        the section, one period of them or the last that were looked at; ``status``.
    """
    starts = Starts(mechanism, initial, names, joint)
    found = reached(starts.model, [starts(value) for value in values], watch)
    status, periods, states = zip(*found, strict=True)
    return {"status": 0, "node_status": np.array(status), "period": np.array(periods), "states": list(states)}


def reached(base: Model, starts: list[Model | None], watch: Watch) -> list[tuple[int, int, np.ndarray]]:
    """Status, period and section states of the ends of motions.

    Parameters
    ----------
    base : Model
        With the crank angle at which all motions are cut.
    starts : list of Model or None
        Where each starts, with its own crank angle.
    watch : Watch
        For how long.
    """
    nothing = np.zeros((0, len(base.state)))
    found = {n: (BAD, 0, nothing) for n, start in enumerate(starts) if start is None}
    left = {n: (start, nothing) for n, start in enumerate(starts) if start is not None}
    for again in range(1 + watch.patience):
        cuts = cut(base, [model for model, _ in left.values()], 0 if again else watch.transient, watch)
        for (n, (_, seen)), (states, status) in zip([*left.items()], cuts, strict=True):
            repeats = 0 if status else _period(base, states, watch)
            if status or repeats:
                found[n] = (status, repeats, nothing if status else states[-repeats:])
                del left[n]
            else:
                seen = np.concatenate([seen, states])[-max(POINTS, watch.turns) :]
                left[n] = replace(base, state=states[-1]), seen
    found |= {n: (0, 0, seen) for n, (_, seen) in left.items()}
    return [found[n] for n in range(len(starts))]


def _period(base: Model, states: np.ndarray, watch: Watch) -> int:
    points = features(base, states)
    return reduced(points, period(points, watch.tolerance / STRICTER), watch.tolerance)


def reduced(points: np.ndarray, found: int, tolerance: float) -> int:
    """The smallest divisor of a period by which its points still repeat within a wider tolerance.

    A motion that spirals in may repeat best after several turns, though all its points are one by now.
    """
    last = points[-found:]
    for q in range(1, found):
        if found % q == 0 and max(np.ptp(last[rest::q], axis=0).max() for rest in range(q)) <= tolerance:
            return q
    return found


def cut(base: Model, starts: list[Model], drop: int, watch: Watch) -> list[tuple[np.ndarray, int]]:
    """Of each start, states at the section after `drop` turns, shape (turns, states), and the status."""
    requests = [_request(base, start, drop, watch) for start in starts]
    if watch.ensemble:
        records = follow_ensemble(starts, requests)
    else:
        records = [follow(*pair) for pair in zip(starts, requests, strict=True)]
    return [_states(base, each, watch) for each in records]


def _request(base: Model, start: Model, drop: int, watch: Watch) -> Request:
    turns = drop + watch.turns
    limit = {"rtol": watch.rtol, "max_steps": asked.steps(watch.max_steps)}
    if base.structure.section is None:
        at = base.period * np.arange(drop + 1, turns + 1)
        return Request(at[-1], at=at, **limit)
    fields = asked.section_fields(CrankAngle(angle=base.crank_angle), start, drop)
    return Request(asked.SLACK * turns * base.period, stop_after=turns, **fields, **limit)


def _states(base: Model, records: Records, watch: Watch) -> tuple[np.ndarray, int]:
    states = _rows(records, base.structure.section is not None, len(base.state))
    if records.status or len(states) < watch.turns:
        return states, records.status or STOPPED
    return _wrapped(base, states), 0


def _rows(records: Records, by_angle: bool, count: int) -> np.ndarray:
    if by_angle:
        return records.sections[:, STATE : STATE + count]
    return records.samples[:, 1 : 1 + count]


def _wrapped(base: Model, states: np.ndarray) -> np.ndarray:
    """States with angles within half a turn of 0, the crank's at the section's angle."""
    found, crank = states.copy(), crank_place(base)
    for i in np.flatnonzero(base.turning):
        found[:, i] = (found[:, i] + math.pi) % math.tau - math.pi
    if crank is not None:
        found[:, crank] = base.crank_angle
    return found


def features(model: Model, states: np.ndarray) -> np.ndarray:
    """What section points are compared by, shape (points, coordinates)."""
    if not model.links:
        return states
    names, n_q = cache.structure_module(model.structure).STATE[1:], len(model.turning)
    speeds = [n_q + i for i in range(n_q) if model.turning[i]]
    found = states[:, speeds] * model.period / math.tau
    if model.joints:
        journals = Journals(model)
        found = np.concatenate([journals.places(states) / journals.clearances, found], axis=1)
    bent = [i for i in range(n_q) if names[i].startswith("eta_")]
    return np.concatenate([found, states[:, bent] / model.absolute[bent]], axis=1)
