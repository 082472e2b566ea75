"""What a sweep consists of: cells by their keys, in strands that run one cell after another.

A cell of most kinds of study is that kind's analysis on a changed mechanism, a strand of one. The points of a
bifurcation diagram make strands of several: chains, where each point starts from where its neighbour stands.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import islice
from math import prod
from typing import Any, Protocol

import xarray as xr

from jointplay.analysis.cells import guarded, warm
from jointplay.analysis.request import quantity
from jointplay.analysis.starts import End
from jointplay.analysis.sweeps.bifurcation import assembled, planned
from jointplay.analysis.sweeps.sweep import Sweep, chain
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.vary import changed
from jointplay.errors import InputError
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import Mechanism, TestSystem
from jointplay.study import gather
from jointplay.study.journal import CRASHED, Entry, key_of, refuse_lost
from jointplay.study.kinds import Study
from jointplay.study.points import points
from jointplay.study.run import analysed

TANGENT = ("lyapunov", "sensitivity", "periodic_orbit", "continuation")  # kinds that follow tangents
LOOKED = 32  # cells that are looked through for structures to compile


class Notes(Protocol):
    """Where a strand writes."""

    def begin(self, key: str) -> None:
        """Say that a cell is begun."""

    def put(self, key: str, answer: Entry) -> None:
        """Keep the answer of a finished cell."""


class Strand(Protocol):
    """Cells that run one after another."""

    keys: tuple[str, ...]

    def run(self, notes: Notes) -> None:
        """Run them."""

    def only(self, key: str) -> Strand:
        """Give the strand that ends with the cell of this key."""

    def sample(self) -> Strand:
        """Give what is run to tell what a cell costs."""

    def left(self, done: Container[str], answers: Mapping[str, Entry]) -> Strand | None:
        """Give what is left to run, where the cells in `done` are finished; None if nothing is."""


@dataclass(frozen=True)
class Cell:
    """One call of a function that workers import by name."""

    function: Callable[..., Entry]
    keywords: dict[str, Any]
    key: str

    @property
    def keys(self) -> tuple[str, ...]:
        """Its key alone."""
        return (self.key,)

    def run(self, notes: Notes) -> None:
        """Call the function; an error is an answer too."""
        notes.begin(self.key)
        notes.put(self.key, guarded(self.function, self.keywords))

    def only(self, _: str) -> Cell:
        """Give itself."""
        return self

    def sample(self) -> Cell:
        """Give itself."""
        return self

    def left(self, done: Container[str], _: Mapping[str, Entry]) -> Cell | None:
        """Give itself, if it is not finished."""
        return None if self.key in done else self


@dataclass(frozen=True)
class Chain:
    """Points of a bifurcation diagram, each from where the last one stands if they are carried."""

    keys: tuple[str, ...]
    mechanism: Mechanism | TestSystem
    changes: tuple[dict[str, float], ...]
    start: Any
    plan: Any
    carried: bool
    end: End | None = None

    def run(self, notes: Notes) -> None:
        """Settle at one point after another."""
        keys = iter(self.keys)
        at = [next(keys)]
        notes.begin(at[0])

        def told(answer: Entry) -> None:
            notes.put(at[0], answer)
            at[0] = next(keys, "")
            if not (self.plan.ensemble and at[0]):  # of an ensemble all are computed when the first is told
                notes.begin(at[0])

        chain(self.mechanism, self.changes, self.start, self.plan, self.carried, self.end, told)

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


def _answer(record: Study, changes: Mapping[str, float]) -> Entry:
    dataset = analysed(record.model_copy(update={"mechanism": changed(record.mechanism, changes)}), jobs=1)
    return {"status": int(dataset.variables["status"]), "dataset": gather.plain(dataset)}


class CellSweep:
    """A study whose cells are analyses by themselves."""

    def __init__(self, record: Study) -> None:
        self.record, self.points = record, points(record.mechanism, record.vary)
        alone = record.model_copy(update={"vary": {}, "figure": {}})
        self.strands = [
            Cell(_answer, {"record": alone, "changes": change}, self._key(change))
            for change in self.points.changes
        ]

    def _key(self, change: dict[str, float]) -> str:
        told: tuple[Any, ...] = (self.record.kind, self.record.integrator, self.record.analysis)
        try:
            return key_of(*told, changed(self.record.mechanism, change))
        except InputError:  # the cell will say so
            return key_of(*told, self.record.mechanism, change)

    @property
    def shape(self) -> dict[str, int]:
        """Numbers of cells along each dimension."""
        return dict(zip(self.points.dims, self.points.shape, strict=True))

    def warm(self) -> None:
        """Compile what cells need, so that workers find it on the disk."""
        changes = self.points.changes
        for change in (*changes[:: max(1, len(changes) // LOOKED)], changes[-1]):
            try:
                model = changed(self.record.mechanism, change)
                section = getattr(self.record.analysis, "section", None)
                scene = assemble(model, None, quantity(section, model))
            except InputError:
                continue
            warm([scene])
            if self.record.kind in TANGENT:
                warm_tangents(scene)

    def assemble(self, read: gather.Read) -> xr.Dataset:
        """Put the answers together; `read` goes through them."""
        return gather.dataset(self.record.kind, self.points, [cell.key for cell in self.strands], read)


class ChainSweep:
    """A bifurcation study."""

    def __init__(self, record: Study) -> None:
        self.sweep: Sweep = planned(record.mechanism, **record.keywords())
        self.strands: list[Chain] = []
        self.places: dict[tuple[int, ...], str] = {}
        for carried, s, indices in self.sweep.chains():
            changes = tuple(self.sweep.changes(index) for index in indices)
            keys = tuple(self._keys(carried, s, changes))
            start = self.sweep.starts[s]
            made = Chain(keys, self.sweep.mechanism, changes, start, self.sweep.plan, carried)
            self.strands.append(made)
            self.places |= dict(zip(indices, keys, strict=True))

    def _keys(self, carried: bool, s: int, changes: Sequence[dict[str, float]]) -> Iterator[str]:
        """A carried point is what all points before it in its chain have made of it."""
        plan = asdict(self.sweep.plan) | {"section": self.sweep.plan.section}
        origin = before = key_of("bifurcation", plan, self.sweep.mechanism, self.sweep.starts[s], carried)
        for change in changes:
            before = key_of(before if carried else origin, change)
            yield before

    @property
    def shape(self) -> dict[str, int]:
        """Numbers of points along each dimension."""
        return dict(zip(self.sweep.dims, self.sweep.shape, strict=True))

    def warm(self) -> None:
        """Compile what points need, so that workers find it on the disk."""
        self.sweep.warm()

    def assemble(self, read: gather.Read) -> xr.Dataset:
        """Put the answers together; `read` goes through them."""
        answers = dict(read())
        refuse_lost(len(set(self.places.values()) - answers.keys()))
        return assembled(self.sweep, {index: answers[key] for index, key in self.places.items()})


def swept(record: Study) -> CellSweep | ChainSweep | None:
    """Say what a study consists of; None where it is a single analysis."""
    if record.kind == "bifurcation":
        return ChainSweep(record)
    return CellSweep(record) if record.vary else None


def redone(strands: Sequence[Strand], index: Mapping[str, int]) -> set[str]:
    """Keys of the cells that are to run again: those that crashed, and what follows them in a chain."""
    done = {key for key, status in index.items() if status != CRASHED}
    found = {key for key in index if key not in done}
    for strand in strands:
        n = next((i for i, key in enumerate(strand.keys) if key not in done), len(strand.keys))
        if getattr(strand, "carried", False):
            found |= {key for key in strand.keys[n:] if key in done}
    return found


def remaining(strands: Iterable[Strand], done: Container[str], answers: Mapping[str, Entry]) -> list[Strand]:
    """What is left to run of some strands, where the cells in `done` are finished."""
    return [rest for strand in strands if (rest := strand.left(done, answers)) is not None]


def part(strands: Sequence[Strand], share: tuple[int, int] | None) -> list[Strand]:
    """The strands of one of several parts, as (number from 1, how many); all if None."""
    return list(strands) if share is None else list(islice(strands, share[0] - 1, None, share[1]))


def total(shape: Mapping[str, int]) -> int:
    """How many cells."""
    return prod(shape.values())
