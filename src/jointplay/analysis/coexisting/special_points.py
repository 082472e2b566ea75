"""Bifurcations on the motions of a sweep: each periodic one is followed as an orbit, stable or not.

An identity is followed (`analysis.orbits.continuation`) once for every period that it has, from the middle of
the values where it has it, to one value beyond them on either side. Beginnings and ends of identities
are set beside what is found between the same two values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from jointplay.analysis.coexisting.identity import Change
from jointplay.analysis.labels import Out
from jointplay.analysis.orbits.branch_points import KINDS
from jointplay.analysis.orbits.continuation import continuation
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.vary import Axis
from jointplay.jobs.job import Entry

TRANSIENT, STEP, MOST = 20, 0.05, 200  # turns to the orbit; longest step, and points of a branch
NONE = len(KINDS)
# seen from a branch that ends at a branch point, that is a fold too
TOLD = ("branch_point", "period_doubling", "neimark_sacker", "fold", "grazing")


def stretches(
    axis: Axis, motions: Sequence[Sequence[Mapping[str, Any]]], numbers: Sequence[Sequence[int]]
) -> list[dict[str, Any]]:
    """Branches to follow: identity, period, value and state to start from, and the range of the parameter."""
    rows = [
        (n, each["period"], i, each)
        for i, row in enumerate(numbers)
        for n, each in zip(row, motions[i], strict=True)
    ]
    rows = sorted((row for row in rows if row[1]), key=lambda row: row[:3])
    found, last = [], len(axis.values) - 1
    for (number, period), some in groupby(rows, key=lambda row: row[:2]):
        those = list(some)
        places = [i for _, _, i, _ in those]
        low, high = axis.values[max(places[0] - 1, 0)], axis.values[min(places[-1] + 1, last)]
        _, _, middle, motion = those[len(those) // 2]
        if low < high:
            start = {"value": axis.values[middle], "state": motion["states"][-1].tolist()}
            found.append({"identity": number, "period": period, "range": (low, high)} | start)
    return found


def followed(
    mechanism, parameter: str, identity: int, period: int, range: tuple[float, float], value: float,
    state: list[float], section: Any, max_steps: int | None,
) -> Entry:  # fmt: skip
    """Special points of the branch of a periodic motion."""
    branch = continuation(
        mechanism,
        section,
        parameter=parameter,
        range=tuple(range),
        start=value,
        period=period,
        initial=state,
        transient=TRANSIENT,
        step=STEP,
        max_points=MOST,
        branch_switching=False,
        record=(),
        max_steps=max_steps,
    )
    kinds = branch["special_kind"].values.astype(int)
    return {"status": int(branch["status"]), "kind": kinds, "parameter": branch["special_parameter"].values}


OUTS = {
    "special_parameter": Out("special", "parameter at a special point", "{units}", "with `bifurcations`"),
    "special_identity": Out("special", "motion on whose branch it lies"),
    "special_period": Out("special", "period of the orbit that was followed"),
    "branch_identity": Out("branch", "motion that was followed as an orbit"),
    "branch_period": Out("branch", "its period"),
    "branch_status": Out("branch", "how the search for the orbit ended", flags=STATUS),
    "special_kind": Out("special", "what changes there", flags=KINDS),
    "change_bifurcation": Out("change", "bifurcation found there", flags=(*KINDS, "none")),
}


def values(
    axis: Axis, cells: Sequence[Mapping[str, Any]], answers: Sequence[Entry], events: Sequence[Change]
) -> dict[str, Any]:
    """Special points by identity, and the kind of any between the values of a beginning or an end."""
    rows = [
        (int(kind), float(value), cell["identity"], cell["period"])
        for cell, answer in zip(cells, answers, strict=True)
        for kind, value in zip(answer.get("kind", ()), answer.get("parameter", ()), strict=True)
    ]
    rows = sorted(rows, key=lambda row: (row[2], row[1], row[3], row[0]))
    kind, value, identity, period = np.array(rows, dtype=float).reshape(-1, 4).T
    whole = {name: np.array([cell[name] for cell in cells], dtype=int) for name in ("identity", "period")}
    return {
        "special_parameter": value,
        "special_identity": identity.astype(int),
        "special_period": period.astype(int),
        "branch_identity": whole["identity"],
        "branch_period": whole["period"],
        "branch_status": [answer["status"] for answer in answers],
        "special_kind": kind,
        "change_bifurcation": [_between(axis, each, rows) for each in events],
    }


def _between(axis: Axis, change: Change, rows: Sequence[tuple[int, float, int, int]]) -> int:
    """Kind of the bifurcation between the values of a change, the first in the order of `TOLD`."""
    low, high = (axis.values[i] for i in change.between)
    those = (change.identity, change.other) if change.kind in ("split", "merger") else (change.identity,)
    found = [kind for kind, value, identity, _ in rows if identity in those and low <= value <= high]
    return min(found, key=lambda kind: TOLD.index(KINDS[kind]), default=NONE)
