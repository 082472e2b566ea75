"""The points of a sweep in their order: continuation chains from neighbour to neighbour, or single points.

A chain runs one point after another, and chains run side by side: in workers, and in the lanes of an
ensemble. The result does not depend on where or in which order they run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import product, zip_longest
from typing import Any

import numpy as np

from jointplay.analysis.cells import Batch, Work, guarded
from jointplay.analysis.labels import Out
from jointplay.analysis.rules import varied
from jointplay.analysis.starts import End, continued
from jointplay.analysis.sweeps.attractor import Plan, labelled, settle, settle_together
from jointplay.analysis.vary import Axis, largest
from jointplay.jobs.job import Entry, Kept, Notes, key_of
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.ensemble_runs import FEWEST, in_lanes

DIRECTIONS = ("up", "down", "reset")
DIRECTION = Out("direction", "direction of the sweep", "")
START = Out("start", "number of the start")
BLOCK, TOGETHER = 8, 32  # points of a reset sweep in one cell, one by one or as an ensemble
ABREAST = 16  # chains that share the lanes of an ensemble, at most


@dataclass(frozen=True)
class Sweep:
    """Motions of a sweep: the grid of parameters, the directions and the starts."""

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
        varied = {each.name: (each.name, np.array(each.values), each.attributes) for each in self.axes}
        own = {"direction": DIRECTION.variable(np.array(self.directions))}
        return varied | own | {"start": START.variable(np.arange(len(self.starts)))}

    @cached_property
    def chains(self) -> list[tuple[Chain, list[tuple[int, ...]]]]:
        """The chains, each with the grid indices of its points."""
        chains = []
        *others, last = (range(n) for n in self.shape[: len(self.axes)])
        for *rest, (d, direction), s in product(*others, enumerate(self.directions), range(len(self.starts))):
            indices = [(*rest, n, d, s) for n in (reversed(last) if direction == "down" else last)]
            block = -(-len(last) // groups(len(last), TOGETHER)) if self._plans[False].ensemble else BLOCK
            size = block if direction == "reset" else len(indices)
            for at in range(0, len(indices), size):
                some = indices[at : at + size]
                chains.append((self._chain(some, self.starts[s], direction != "reset"), some))
        return chains

    @cached_property
    def _plans(self) -> dict[bool, Plan]:
        """Settings by whether points are carried: with lanes where they are wanted, or filled by these."""
        *others, last = self.shape[: len(self.axes)]
        varied = largest(self.mechanism, {axis.key: axis.values for axis in self.axes})
        side, plans = math.prod(others) * len(self.starts), {}
        for carried in (False, True):
            sweeps = sum((direction != "reset") == carried for direction in self.directions)
            count = side * sweeps * (1 if carried else last)
            together = in_lanes(self.plan.ensemble, varied, self.plan.rtol, count)
            plans[carried] = replace(self.plan, ensemble=together)
        return plans

    def _chain(self, indices: Sequence[tuple[int, ...]], start: Any, carried: bool) -> Chain:
        """A chain; the key of a carried point holds all points before it, on which it depends."""
        settings = self._plans[carried]
        plan = asdict(settings) | {"section": settings.section}
        origin = before = key_of("bifurcation", plan, self.mechanism, start, carried)
        changes = tuple(map(self._changes, indices))
        keys = tuple(before := key_of(before if carried else origin, each) for each in changes)
        return Chain(keys, self.mechanism, changes, start, settings, carried)

    def _changes(self, index: tuple[int, ...]) -> dict[str, float]:
        """Changes of the mechanism at a point."""
        return {axis.key: axis.values[i] for axis, i in zip(self.axes, index, strict=False)}

    def work(self, progress: Callable[[float], None] | None) -> Work:
        """The chains as work to hand out."""
        shape = dict(zip(self.dims, self.shape, strict=True))
        return Work(batched_chains([each for each, _ in self.chains]), shape, progress, self.warm)

    @property
    def keys(self) -> list[str]:
        """Keys of the points, the last dimension fastest."""
        keys = {at: key for chain, some in self.chains for at, key in zip(some, chain.keys, strict=True)}
        return [keys[at] for at in np.ndindex(self.shape)]

    def warm(self) -> None:
        """Compile the code that the first and the last point need, so that workers find it on the disk."""
        for corner, carried in product((0, -1), {direction != "reset" for direction in self.directions}):
            brief = replace(self._plans[carried], turns=1, transient=0, lyapunov_turns=1)
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
    def chains(self) -> tuple[tuple[str, ...], ...]:
        """Keys of points that start from ends."""
        return (self.keys,) if self.carried else ()

    def run(self, notes: Notes) -> None:
        """Settle at one point after another, or as an ensemble at all of them."""
        if self.plan.ensemble:
            _in_rows([[(self, n) for n in range(len(self.keys))]], self.plan, notes)
            return
        end = self.end
        for n, key in enumerate(self.keys):
            notes.begin(key)
            answer = guarded(self._point, {"n": n, "end": end})
            end = answer.get("end", end) if self.carried else None
            notes.put(key, labelled(answer, self.plan.keep))

    def _point(self, n: int, end: Sequence[Any] | None) -> Entry:
        return settle(*self.begun(n, end)["begun"], self.plan)

    def begun(self, n: int, end: Sequence[Any] | None) -> Entry:
        """Mechanism and model of the n-th point, after one that ended so."""
        here, last = varied(self.mechanism, self.changes[n]), None if end is None else End.read(end)
        return {"begun": (here, continued(here, last, self.start, self.plan.section))}

    def only(self, key: str) -> Chain:
        """Give the chain up to a point; the point alone where none depends on another."""
        last = self.keys.index(key)
        return self._at(range(last + 1) if self.carried else [last])

    def sample(self) -> Chain:
        """Give the first point; of an ensemble all that run at once."""
        return self if self.plan.ensemble and not self.carried else self._at([0])

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Chain | None:
        """Give the unfinished points: a carried point depends on the points before it."""
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


class ChainBatch(Batch):
    """Chains whose points are followed side by side as an ensemble, the first of all, then the second, …"""

    def run(self, notes: Notes) -> None:
        """Settle at one row of points after another."""
        rows = zip_longest(*([(chain, n) for n in range(len(chain.keys))] for chain in self.own))
        _in_rows([[each for each in row if each] for row in rows], self.own[0].plan, notes)


def batched_chains(chains: Sequence[Chain]) -> list[Chain | ChainBatch]:
    """Put carried chains side by side where they go in lanes, in groups of nearly one size."""
    side = [chain for chain in chains if chain.carried and chain.plan.ensemble]
    single = [chain for chain in chains if not (chain.carried and chain.plan.ensemble)]
    count = groups(len(side), ABREAST)
    return [ChainBatch(tuple(side[n::count])) for n in range(count)] + single


def groups(count: int, most: int) -> int:
    """Number of groups of at most so many motions; two at least, where these fill two workers."""
    return max(-(-count // most), 2 if count >= FEWEST else 0)


def _in_rows(rows: Sequence[Sequence[tuple[Chain, int]]], plan: Plan, notes: Notes) -> None:
    """Settle at the points of each row at once, each given as a chain and its number there."""
    ends: dict[int, Any] = {}
    for row in rows:
        notes.begin(row[0][0].keys[row[0][1]])
        begun = [guarded(one.begun, {"n": n, "end": ends.get(id(one), one.end)}) for one, n in row]
        settled = iter(settle_together([each["begun"] for each in begun if "begun" in each], plan))
        for (chain, n), each in zip(row, begun, strict=True):
            answer = next(settled) if "begun" in each else each
            if chain.carried and "end" in answer:
                ends[id(chain)] = answer["end"]
            notes.put(chain.keys[n], labelled(answer, plan.keep))
