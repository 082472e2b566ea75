"""Accelerations of recorded states, also where the motion's own steps are too coarse for them.

An acceleration amplifies the error of a state by the fastest rate of the equations: by 10^6 per second at the
motor's line. Where friction turns over, that line answers within microseconds; a step of the motion passes
over this, and its polynomial keeps a part of it that is nothing for a speed and much for an acceleration. The
flow notes such steps (method.coarse_steps). What they recorded is here followed anew, from the beginning of
each step, by two steps or more and with a thousandth of the tolerance; only accelerations, and what depends
on them, are taken from there. The motion and all else that is recorded stay as they are.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.progress import ticked
from jointplay.solver.motion.trajectory import Records, Request, functions, memory

CLOSER = 1e-3  # of the tolerance
LEAST = 1e-13  # tolerance at which rounding begins
ATTEMPTS = 10_000  # in one step of the motion
TOGETHER = 256  # coarse in a compiled call, which no interrupt ends
END, TIME = 1, 2  # columns of a coarse step


def needed(model: Model, names: Iterable[str]) -> bool:
    """Whether any of these quantities depends on accelerations, or on forces that answer a speed so."""
    abrupt = cache.structure_module(model.structure).ABRUPT
    return not {*names}.isdisjoint(key.partition(":")[0] for key in abrupt)


def quantities(model: Model, rtol: float, records: Records, rows: np.ndarray) -> Quantities:
    """Quantities of some rows of the records of a run with `Request.rates`, accelerations and all."""
    return together(model, rtol, records, rows)[0]


def together(model: Model, rtol: float, records: Records, *parts: np.ndarray) -> list[Quantities]:
    """Quantities of several parts of the records, for which steps in doubt are followed once."""
    sharp = resolved(model, rtol, records.coarse, *parts)
    return [Quantities(model, rows, records.start, each) for rows, each in zip(parts, sharp, strict=True)]


def resolved(model: Model, rtol: float, coarse: np.ndarray, *parts: np.ndarray) -> list[np.ndarray]:
    """Parts of the records of a run with `Request.rates`, with states whose accelerations are right.

    Rows outside the steps in doubt stay as they are, and so do states that come out in other contact modes,
    which lie within an event's uncertainty.
    """
    held = [_held(coarse, rows) for rows in parts]
    wanted = np.concatenate([rows[each] for rows, each in zip(parts, held, strict=True)])
    if not len(wanted):
        return [*parts]
    order = np.argsort(wanted[:, 0], kind="stable")
    wanted[order] = _right(model, rtol, coarse, wanted[order])
    result = [rows.copy() if len(each) else rows for rows, each in zip(parts, held, strict=True)]
    ends = np.cumsum([len(each) for each in held])
    for rows, each, right in zip(result, held, np.split(wanted, ends[:-1]), strict=True):
        rows[each] = right
    return result


def _held(coarse: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Places of the rows that lie in a coarse step; a beginning is its own state."""
    places = np.searchsorted(coarse[:, TIME], rows[:, 0], side="left") - 1
    held = np.flatnonzero(places >= 0)
    return held[rows[held, 0] <= coarse[places[held], END]]


def _right(model: Model, rtol: float, coarse: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows in coarse steps, by time, with states whose accelerations are right, or as they are."""
    places = np.searchsorted(coarse[:, TIME], rows[:, 0], side="left") - 1
    anew = _anew(model, rtol, coarse, places, rows)
    same = (anew[:, 0] == rows[:, 0]) & np.all(_modes(model, anew) == _modes(model, rows), axis=1)
    first = np.searchsorted(places, places)  # of the same step
    other = np.cumsum(~same)  # up to a row; none between the first of its step and itself
    same &= other == np.where(same[first], other[first], -1)
    return np.where(same[:, None], anew, rows)


def _anew(model: Model, rtol: float, coarse: np.ndarray, places: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Rows at the times of `rows`, each from the beginning of its coarse step; 0 where none came."""
    flow, retake = cache.method("flow").flow, cache.method("retake").retake
    closer = max(CLOSER, min(LEAST / rtol, 1.0))
    work, motion, options = memory(model, Request(np.inf, rtol, rows[:, 0], max_steps=ATTEMPTS))
    motion = motion._replace(absolute=closer * motion.absolute, relative=closer * motion.relative)
    used, first = np.unique(places, return_index=True)
    compiled = functions(model.structure)
    for i in ticked(range(0, len(used), TOGETHER)):
        retake(flow, compiled, work, motion, options, coarse[used[i : i + TOGETHER]], first[i : i + TOGETHER])
    return motion.samples


def _modes(model: Model, rows: np.ndarray) -> np.ndarray:
    """Contact modes of rows."""
    sizes, first = cache.structure_module(model.structure).SIZES, 1 + len(model.state)
    return rows[:, first : first + sizes["contacts"] + sizes["resets"]]
