"""The points of a sweep in their order: chains from neighbour to neighbour, or each point by itself.

A chain runs one point after another, and chains run side by side. What is found does not depend on where or
in which order they run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count, product
from typing import Any

from jointplay.analysis.cells import guarded, run_cells
from jointplay.analysis.starts import End, same_states
from jointplay.analysis.sweeps.attractor import Plan, settle, settle_together
from jointplay.analysis.vary import Axis, changed
from jointplay.mechanism.records import Mechanism, TestSystem

DIRECTIONS = ("up", "down", "reset")
BLOCK, TOGETHER = 8, 32  # points of a reset sweep in one cell, one by one or as an ensemble


@dataclass(frozen=True)
class Sweep:
    """Which motions are followed, in which order, and from where."""

    mechanism: Mechanism | TestSystem
    axes: tuple[Axis, ...]
    directions: tuple[str, ...]
    starts: tuple[Any, ...]
    plan: Plan

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of the grid."""
        return (*(axis.name for axis in self.axes), "direction", "start")

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers along them."""
        return (*(len(axis.values) for axis in self.axes), len(self.directions), len(self.starts))

    def chains(self) -> Iterator[tuple[bool, int, list[tuple[int, ...]]]]:
        """Whether points start from neighbours' ends, the number of the start, and the points' indices."""
        *others, last = (range(n) for n in self.shape[: len(self.axes)])
        for *other, (d, way), s in product(*others, enumerate(self.directions), range(len(self.starts))):
            indices = [(*other, n, d, s) for n in (reversed(last) if way == "down" else last)]
            block = TOGETHER if self.plan.ensemble else BLOCK
            size = block if way == "reset" else len(indices)
            for at in range(0, len(indices), size):
                yield way != "reset", s, indices[at : at + size]

    def changes(self, index: tuple[int, ...]) -> dict[str, float]:
        """What is changed at a point."""
        return {axis.key: axis.values[i] for axis, i in zip(self.axes, index, strict=False)}

    def run(self, n_jobs: int | None, progress: Callable[[float], None] | None) -> dict[Any, dict[str, Any]]:
        """Follow every motion; what was found, by the point's index."""
        chains = list(self.chains())
        cells = [
            {"mechanism": self.mechanism, "changes": [self.changes(i) for i in indices], "carried": carried}
            | {"start": self.starts[s], "plan": self.plan}
            for carried, s, indices in chains
        ]
        if n_jobs == 1 or len(cells) == 1:
            answers = _one_by_one(cells, progress)
        else:
            self.warm()
            answers = run_cells(chain, cells, n_jobs, progress)
        found: dict[Any, dict[str, Any]] = {}
        for answer, (_, _, indices) in zip(answers, chains, strict=True):
            lost = {"status": answer["status"], "trouble": answer.get("trouble", "")}
            found |= dict(zip(indices, answer.get("answers", [lost] * len(indices)), strict=True))
        return found

    def warm(self) -> None:
        """Compile what the first and the last point need, so that workers find it on the disk."""
        brief = replace(self.plan, turns=1, transient=0, lyapunov_turns=1)
        for corner in (0, -1):
            change = {axis.key: axis.values[corner] for axis in self.axes}
            chain(self.mechanism, [change], self.starts[0], brief, False)


def _one_by_one(cells: list[dict[str, Any]], progress) -> list[dict[str, Any]]:
    """The same as in a pool, here, with progress point by point."""
    total, found, done = sum(len(cell["changes"]) for cell in cells), [], 0
    for cell in cells:
        counted = count(done + 1)
        told = None if progress is None else partial(_tell, progress, counted, total)
        found.append(chain(**cell, told=told))
        done += len(cell["changes"])
    return found


def _tell(progress: Callable[[float], None], counted: Iterator[int], total: int, _: Any) -> None:
    progress(next(counted) / total)


def chain(
    mechanism: Mechanism | TestSystem,
    changes: Sequence[Mapping[str, float]],
    start: Any,
    plan: Plan,
    carried: bool,
    end: End | None = None,
    told: Callable[[dict[str, Any]], None] | None = None,
) -> dict[str, Any]:
    """Settle at one value after another: a cell.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What is changed.
    changes : sequence of mapping
        As in `vary.changed`, one a point.
    start : optional
        Of the first point.
    plan : Plan
        What is asked.
    carried : bool
        Whether each further point starts from the last good end, where it has the same states; else from
        `start` too.
    end : End, optional
        Where the motion of the point before the first stands, of a chain that goes on.
    told : callable, optional
        Called with what was found at each point, as soon as it is.

    Returns
    -------
    dict
        ``status`` 0 and ``answers``, one a point as `settle` gives them.
    """
    if plan.ensemble and not carried:
        return {"status": 0, "answers": _together(mechanism, changes, start, plan, told)}
    answers = []
    for change in changes:
        answer = guarded(
            _point, {"mechanism": mechanism, "change": change, "start": start, "end": end, "plan": plan}
        )
        end = answer.get("end", end) if carried else None
        answers.append(answer)
        if told is not None:
            told(answer)
    return {"status": 0, "answers": answers}


def _point(mechanism, change: Mapping[str, float], start: Any, end: End | None, plan: Plan) -> dict[str, Any]:
    here = changed(mechanism, change)
    return settle(here, end if end is not None and same_states(here, end) else start, plan)


def _together(mechanism, changes, start: Any, plan: Plan, told) -> list[dict[str, Any]]:
    """All points of a reset sweep's cell, eight at once."""
    made = [guarded(_changed, {"mechanism": mechanism, "change": change}) for change in changes]
    settled = iter(settle_together([(each["made"], start) for each in made if "made" in each], plan))
    answers = [next(settled) if "made" in each else each for each in made]
    for answer in answers if told is not None else ():
        told(answer)
    return answers


def _changed(mechanism, change: Mapping[str, float]) -> dict[str, Any]:
    return {"made": changed(mechanism, change)}
