"""Adaptive maps of settled motions: points of a reset sweep that are computed where their neighbours differ.

Two points differ where one failed, where their periods differ, where only one has an exponent, or where their
leading exponents per turn are apart by more than `contrast` and by more than three standard errors of the
difference; `subdivision` says what follows from that. Points have the keys that they have in the whole
sweep: a journal of the one is of use to the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain, combinations
from math import hypot, isfinite
from typing import Any, NamedTuple

import numpy as np

from jointplay.analysis.cells import Read, Work, answered
from jointplay.analysis.sweeps.chains import BLOCK, TOGETHER, Chain, Sweep
from jointplay.analysis.sweeps.subdivision import OUTS, Point, refined, representatives, variables
from jointplay.display.errors import Problem
from jointplay.jobs.job import Entry

ERRORS = 3.0  # standard errors beyond which exponents differ
EXPONENTS = ("section_exponent_per_turn", "lyapunov_exponent_per_turn")  # the first that a point has


class Features(NamedTuple):
    """Status and period of a motion; its leading exponent per turn with its error, NaN where unknown."""

    status: int
    period: int
    exponent: float
    error: float


def refine_fits(refine: int, direction: tuple[str, ...]) -> Iterator[Problem]:
    """Yield a problem where points depend on their neighbours' ends, so that none can be left out."""
    if refine and {*direction} != {"reset"}:
        yield Problem("refine", refine, "0 is accepted unless the only direction is reset")
    if refine > 20:
        yield Problem("refine", refine, "at most 20 is accepted: boxes of 2^20 values")


def features_of(answer: Entry) -> Features:
    """Features of a point's answer that decide whether others are like it."""
    values = answer["dataset"].values if "dataset" in answer else []
    fields = answer["dataset"].layout.fields if "dataset" in answer else []
    found = {field.name: np.ravel(value) for field, value in zip(fields, values, strict=True)}
    numbers = [np.nan, np.nan]
    if name := next((each for each in EXPONENTS if each in found and found[each].size), None):
        numbers = [float(found[each][0]) for each in (name, name.replace("exponent", "standard_error"))]
    period = int(found["period"][0]) if "period" in found else -1
    return Features(int(answer["status"]), period, *numbers)


def alike(contrast: float) -> Callable[[list[tuple[Features, ...]]], bool]:
    """Whether motions with these features, one of each start, may stand for each other."""

    def same(one: Features, other: Features) -> bool:
        if one[:2] != other[:2] or isfinite(one.exponent) != isfinite(other.exponent):
            return False
        apart, error = abs(one.exponent - other.exponent), hypot(one.error, other.error)
        return not apart > contrast or apart <= ERRORS * error

    def equal(looks: list[tuple[Features, ...]]) -> bool:
        pairs = combinations(dict.fromkeys(looks), 2)
        return all(same(a, b) for one, other in pairs for a, b in zip(one, other, strict=True))

    return equal


def adaptive(
    sweep: Sweep, levels: int, contrast: float, progress: Callable[[float], None] | None, n_jobs: int | None
) -> tuple[list[str], Read, dict[str, Any]]:
    """Hand out the points of an adaptive map.

    Returns
    -------
    keys, read, variables
        Key of the computed point that stands for each point, the last dimension fastest; all answers; what
        the dataset says of the map.
    """
    shape, keys, reads = sweep.shape[: len(sweep.axes)], np.reshape(sweep.keys, sweep.shape), []

    def evaluated(
        points: list[Point], tell: Callable[[float], None] | None
    ) -> dict[Point, tuple[Features, ...]]:
        wanted = {key for point in points for key in keys[point].flat}
        size = {"of the grid, in this round": len(wanted)}
        work = Work(_jobs(sweep, wanted), size, tell, sweep.warm, possible=sweep.keys)
        reads.append(answered(work, n_jobs))
        seen = {key: features_of(answer) for key, answer in reads[-1]()}
        return {point: tuple(seen[key] for key in keys[point].flat) for point in points}

    boxes, computed = refined(shape, levels, alike(contrast), evaluated, progress)
    place, level = representatives(shape, boxes, computed)
    own = keys.reshape(-1, *keys.shape[len(shape) :])[place]
    dims = tuple(axis.name for axis in sweep.axes)
    found = {name: OUTS[name].variable(each, plane=dims) for name, each in variables(computed, level).items()}
    return list(own.flat), lambda: chain.from_iterable(read() for read in reads), found


def _jobs(sweep: Sweep, wanted: set[str]) -> list[Chain]:
    """Points with these keys, as many together as in the whole sweep."""
    known, jobs = {*sweep.keys} - wanted, []
    left = [rest for each, _ in sweep.chains if (rest := each.left(known, {})) is not None]
    size = TOGETHER if sweep.plan.ensemble else BLOCK
    for start in dict.fromkeys(id(each.start) for each in left):
        own = [each for each in left if id(each.start) == start]
        keys = [key for each in own for key in each.keys]
        changes = [change for each in own for change in each.changes]
        jobs += [
            replace(own[0], keys=tuple(keys[at : at + size]), changes=tuple(changes[at : at + size]))
            for at in range(0, len(keys), size)
        ]
    return jobs
