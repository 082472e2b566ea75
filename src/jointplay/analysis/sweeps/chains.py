"""The points of a sweep in their order: continuation chains from neighbour to neighbour, or single points.

A chain runs one point after another, and chains run side by side. The result does not depend on where or in
which order they run.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from jointplay.analysis.cells import Work, guarded
from jointplay.analysis.starts import End, same_states
from jointplay.analysis.sweeps.attractor import Plan, settle, settle_together
from jointplay.analysis.sweeps.points import labelled
from jointplay.analysis.vary import Axis, changed
from jointplay.jobs.job import Entry, Kept, Notes, key_of
from jointplay.mechanism.records import Mechanism, TestSystem

DIRECTIONS = ("up", "down", "reset")
BLOCK, TOGETHER = 8, 32  # points of a reset sweep in one cell, one by one or as an ensemble


def numbered(dim: str, count: int, name: str, first: int = 0) -> dict[str, Any]:
    """A coordinate of consecutive numbers."""
    return {dim: (dim, np.arange(first, first + count), {"units": "1", "long_name": name})}


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
        """Numbers of points along the dimensions."""
        return (*(len(axis.values) for axis in self.axes), len(self.directions), len(self.starts))

    @property
    def coordinates(self) -> dict[str, Any]:
        """Coordinates of the grid."""
        directions = ("direction", np.array(self.directions), {"long_name": "direction of the sweep"})
        varied = {each.name: (each.name, np.array(each.values), each.attributes) for each in self.axes}
        return varied | {"direction": directions} | numbered("start", len(self.starts), "number of the start")

    @cached_property
    def chains(self) -> list[tuple[Chain, list[tuple[int, ...]]]]:
        """The chains, each with the grid indices of its points."""
        chains = []
        *others, last = (range(n) for n in self.shape[: len(self.axes)])
        for *other, (d, way), s in product(*others, enumerate(self.directions), range(len(self.starts))):
            indices = [(*other, n, d, s) for n in (reversed(last) if way == "down" else last)]
            block = TOGETHER if self.plan.ensemble else BLOCK
            size = block if way == "reset" else len(indices)
            for at in range(0, len(indices), size):
                some = indices[at : at + size]
                chains.append((self._chain(some, self.starts[s], way != "reset"), some))
        return chains

    def _chain(self, indices: Sequence[tuple[int, ...]], start: Any, carried: bool) -> Chain:
        """A chain; the key of a carried point holds all points before it, on which it depends."""
        plan = asdict(self.plan) | {"section": self.plan.section}
        origin = before = key_of("bifurcation", plan, self.mechanism, start, carried)
        changes, keys = tuple(map(self._changes, indices)), []
        for change in changes:
            keys.append(before := key_of(before if carried else origin, change))
        return Chain(tuple(keys), self.mechanism, changes, start, self.plan, carried)

    def _changes(self, index: tuple[int, ...]) -> dict[str, float]:
        """Changes of the mechanism at a point."""
        return {axis.key: axis.values[i] for axis, i in zip(self.axes, index, strict=False)}

    def work(self, progress: Callable[[float], None] | None) -> Work:
        """The chains as work to hand out."""
        shape = dict(zip(self.dims, self.shape, strict=True))
        return Work([each for each, _ in self.chains], shape, progress, self.warm)

    @property
    def keys(self) -> list[str]:
        """Keys of the points, the last dimension fastest."""
        keys = {at: key for chain, some in self.chains for at, key in zip(some, chain.keys, strict=True)}
        return [keys[at] for at in np.ndindex(self.shape)]

    def warm(self) -> None:
        """Compile what the first and the last point need, so that workers find it on the disk."""
        brief = replace(self.plan, turns=1, transient=0, lyapunov_turns=1)
        for corner in (0, -1):
            change = {axis.key: axis.values[corner] for axis in self.axes}
            Chain(("",), self.mechanism, (change,), self.starts[0], brief, False).run(Kept())


@dataclass(frozen=True)
class Chain:
    """Points of a sweep that run one after another, each from the last good end if they are carried.

    Parameters
    ----------
    keys : tuple of str
        Of the points.
    mechanism, changes
        As in `vary.changed`, with changes for each point.
    start : optional
        Of the first point; of every point that is not carried, or has other states than the last good end.
    plan : Plan
        Settings of the sweep.
    carried : bool
        Whether points start from ends.
    end : sequence, optional
        Where the motion of the point before the first stands, as in `End`, of a chain that goes on.
    """

    keys: tuple[str, ...]
    mechanism: Mechanism | TestSystem
    changes: tuple[dict[str, float], ...]
    start: Any
    plan: Plan
    carried: bool
    end: Sequence[Any] | None = None

    @property
    def _at_once(self) -> bool:
        return self.plan.ensemble and not self.carried

    def run(self, notes: Notes) -> None:
        """Settle at one point after another, or as an ensemble at all of them."""
        end = self.end
        if self._at_once:
            notes.begin(self.keys[0])
            for key, answer in zip(self.keys, self._together(), strict=True):
                notes.put(key, labelled(answer, self.plan.keep))
            return
        for key, change in zip(self.keys, self.changes, strict=True):
            notes.begin(key)
            answer = guarded(self._point, {"change": change, "end": end})
            end = answer.get("end", end) if self.carried else None
            notes.put(key, labelled(answer, self.plan.keep))

    def _point(self, change: dict[str, float], end: Sequence[Any] | None) -> Entry:
        here, last = changed(self.mechanism, change), end
        if end is not None and not isinstance(end, End):  # from a journal
            last = End(*end)
        return settle(here, last if last is not None and same_states(here, last) else self.start, self.plan)

    def _together(self) -> list[Entry]:
        made = [guarded(self._changed, {"change": change}) for change in self.changes]
        starts = [(each["made"], self.start) for each in made if "made" in each]
        settled = iter(settle_together(starts, self.plan))
        return [next(settled) if "made" in each else each for each in made]

    def _changed(self, change: dict[str, float]) -> Entry:
        return {"made": changed(self.mechanism, change)}

    def only(self, key: str) -> Chain:
        """Give the chain up to a point; the point alone where none depends on another."""
        last = self.keys.index(key)
        return self._at(range(last + 1) if self.carried else [last])

    def sample(self) -> Chain:
        """Give the first point; of an ensemble all, since they run at once."""
        return self if self.plan.ensemble else self._at([0])

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Chain | None:
        """Give what is to run still: a carried point depends on those before it."""
        missing = [i for i, key in enumerate(self.keys) if key not in done]
        if not missing or not self.carried:
            return self._at(missing) if missing else None
        first = missing[0]
        ends = [answers[key]["end"] for key in self.keys[:first] if "end" in answers.get(key, ())]
        rest = self._at(range(first, len(self.keys)))
        return replace(rest, end=ends[-1]) if ends else rest

    def _at(self, places: Sequence[int]) -> Chain:
        keys, changes = (tuple(each[i] for i in places) for each in (self.keys, self.changes))
        return replace(self, keys=keys, changes=changes)
