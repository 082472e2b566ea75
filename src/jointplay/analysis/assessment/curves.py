"""Largest forces and impact speeds of a linkage over one parameter, and where its grade changes.

At values in even steps of the logarithm the motion is settled from the given start, side by side; what soon
repeats closely every turn is not followed further. It is recorded over one period where it repeats, and a
little longer, for what happens at its bounds; over `turns` where not. Where the present motion settles
slowly, its orbit is followed to each value that has not settled. Ideal joints' forces are those of the same
value. Where the grade first differs from the present one, on each side, the step is halved. Where it does
nowhere on a side, it is looked for farther out, by doubling. Where the present motion has not settled, a turn
costs much and the time may not do for all: a few values far apart come first, and those between them later.
Validity: of the motion that is reached from the start; where several coexist another one may be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from jointplay.analysis.assessment.branch_walk import Branch, Walk
from jointplay.analysis.assessment.forces import columns, forces
from jointplay.analysis.assessment.page import BY, grade, largest, other, over_ideal
from jointplay.analysis.assessment.settled import SLOW, Settled, Unsettled, approached, on_orbit, reached
from jointplay.analysis.cells import guarded
from jointplay.analysis.period import REPEATS
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import moved, placed
from jointplay.analysis.sweeps.attractor import Plan, settle_together
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism, Section
from jointplay.solver.motion.progress import OutOfTime, stands

VALUES = 49  # the present one in the middle
SPANS = {"clearance": 10.0}  # reach of a curve by the parameter's last word, as a factor
SPAN = 3.0
SOON = {"transient": 8, "turns": REPEATS}  # turns dropped and looked at
LATER = {"transient": 18, "turns": 8}  # and then of what does not repeat yet
CLOSELY = 2e-5  # of a clearance, or of a scale: spread of section points of what soon repeats
REPEATED = 1 + 1 / 64  # periods recorded where the motion repeats
PER_TURN, SMOOTH = 2048, 512  # samples of a turn; of ideal joints
HALVED = 5  # steps to a change of the grade
FARTHER = 10.0  # times the reach of a curve: as far a change of the grade is looked for, by doubling
BRIEFLY = 0.3  # of the turns over which the present motion's exponent is averaged
STEP = 0.005  # of the logarithm, the shortest with which an orbit is followed
FIRST = (12, 6, 3, 1)  # steps from value to value, one after another, where time may not do for all
NOT_RUN = STATUS.index("not_run")
# of a place: force and ratio are those of the joint, by its place, whose ratio is the largest
END = ("ratio", "grade", "joint", "force", "force_ratio", "impact_speed", "by")
Spot = tuple[float, dict[str, Any]]  # a ratio, and what is known there


def ratios(key: str) -> np.ndarray:
    """Values of a curve over the present one."""
    span = SPANS.get(key.rsplit(".", 1)[-1], SPAN)
    return np.geomspace(1 / span, span, VALUES)


def curve(
    here: Settled, key: str, start: Any, turns: int, how: Plan, known: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Forces over a parameter, about the present motion; others begin at the start.

    Returns
    -------
    dict
        ``status``, 0, or ``not_run`` where its time was used up: then what is known so far, and that as
        ``known``, with which another call goes on. ``names`` of the joints, those with clearance first; over
        values ``ratio``, ``statuses``, ``period`` (0: none seen), ``lost`` and ``grade`` (NaN: not known, as
        where a motion that settles slowly has not settled); over these and
        joints ``peak`` and ``ideal`` (N), over those with clearance ``impact_speed`` (m/s). ``change``: over
        the sides, below and above, and the places before and after the first change of the grade, numbers as
        `END`; the latter NaN where it is not met.
    """
    scene = Scene(here, key, start, turns, how)
    where, name = ratios(key), f"forces over the {Parameter(here.mechanism, key).noun}"
    rows, middle = {int(i): scene.read(where[int(i)], row) for i, row in (known or {}).items()}, VALUES // 2
    stands(len(rows) / VALUES, name)
    status, changes = 0, []
    try:
        rows[middle] = scene.of(here)
        for group in _groups(where, key, here):
            if left := [i for i in group if i not in rows]:
                rows |= zip(left, scene.rows(where[left]), strict=True)
            stands(0.8 * len(rows) / VALUES, name)
        for sense in (-1, 1):
            stands(0.85 + 0.05 * sense, name)
            changes.append(scene.change(_all(rows), where, sense))
    except OutOfTime:
        if middle not in rows or len(rows) < 2:
            raise
        status = NOT_RUN
        changes = [scene.change(_all(rows), where, sense, refined=False) for sense in (-1, 1)]
    answer = columns(_all(rows), ("status", "period", "lost", "grade", "peak", "ideal", "impact_speed"))
    answer |= {"statuses": answer.pop("status"), "status": status}
    answer |= {"known": {i: scene.plain(row) for i, row in rows.items() if i != middle}} if status else {}
    return answer | {"ratio": where, "change": np.array(changes)}


def _groups(where: np.ndarray, key: str, here: Settled) -> Iterator[list[int]]:
    """Values, by their numbers, that are looked at together, one group after another."""
    middle = VALUES // 2
    if here.period or here.traits["chaos"]:
        yield [*range(middle + 1, VALUES)]
        yield [*range(middle)][::-1]
        return
    tried = int(np.argmin(np.abs(np.log(where / other(key)[0]))))
    for step in FIRST:
        yield sorted({*range(0, VALUES, step), tried}, key=lambda i: abs(i - middle))


def _all(rows: Mapping[int, dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of all values; those that were not looked at have the status ``not_run``."""
    return [rows.get(i, {"status": NOT_RUN}) for i in range(VALUES)]


class Scene:
    """A linkage over one parameter, and settings."""

    def __init__(self, here: Settled, key: str, start: Any, turns: int, how: Plan):
        self.mechanism, self.key = here.mechanism, key
        self.start, self.turns, self.how = start, turns, replace(how, **LATER)
        self.longer = replace(how, exponents=1, lyapunov_turns=max(round(BRIEFLY * how.lyapunov_turns), 1))
        self.present = float(Parameter(self.mechanism, key).value)
        self.branch = Branch(self.mechanism, key, max(here.period, 1), how.max_steps)
        self.slow, self.ideal = here.radius > SLOW, {}
        over_clearance = key.rsplit(".", 1)[-1] == "clearance"
        self.smooth = self.mechanism.replace(clearance=0.0) if over_clearance else None
        first = None if here.orbit is None else self.branch.first(self.present, here.orbit)
        self.walks = {sense: first and Walk(self.branch, [first], sense, math.inf, STEP) for sense in (-1, 1)}

    def rows(self, where: np.ndarray) -> list[dict[str, Any]]:
        """Rows of a curve at values over the present one, which lie outward from it."""
        values = [float(value) for value in where * self.present]
        found = self._settled(self.start, [(self.mechanism, {self.key: value}) for value in values])
        return [self._row(*each) for each in zip(values, found, self._ideal(found), strict=True)]

    def _settled(self, start: Any, changed: Sequence[tuple[Mechanism, Any]]) -> list[dict[str, Any]]:
        """Motions from a start of mechanisms with changes, each with its status and the model at its end."""
        given = {"start": start, "section": self.how.section}
        found = [guarded(_begun, given | {"mechanism": each, "changes": other}) for each, other in changed]
        for how in (replace(self.how, **SOON, tolerance=CLOSELY), self.how):
            ready = [each for each in found if each["status"] == 0]
            left = [each for each in ready if each["motion"] is None or each["motion"].period != 1]
            points = [(each["mechanism"], each["model"]) for each in left]
            for each, answer in zip(left, settle_together(points, how), strict=True):
                each["status"] = answer["status"]
                if not answer["status"]:
                    each["motion"] = Settled(each["mechanism"], answer["end"], answer["values"])
                    each["model"] = moved(each["model"], answer["end"].state)
        return found

    def _ideal(self, found: Sequence[dict[str, Any]]) -> list[dict[str, float]]:
        """Largest forces of ideal joints by name; where only a clearance differs they are the same."""
        places = [None if each["status"] else each["mechanism"] for each in found]
        ideals = [place and (self.smooth or place.replace(clearance=0.0)) for place in places]
        new = [each for each in dict.fromkeys(ideals) if each is not None and each not in self.ideal]
        answers = self._settled(None, [(each, {}) for each in new])
        self.ideal |= {each: self._peaks(answer) for each, answer in zip(new, answers, strict=True)}
        return [self.ideal.get(each, {}) for each in ideals]

    def _peaks(self, answer: dict[str, Any]) -> dict[str, float]:
        if answer["status"]:
            return {}
        found = self._forces(answer["motion"], answer["model"], SMOOTH)
        return dict(zip(found["names"], map(float, found["peak"]), strict=True))

    def _forces(self, motion: Settled, model: Model | None, per_turn: int = PER_TURN) -> dict[str, Any]:
        turns = REPEATED * motion.period or self.turns
        return forces(motion, turns, self.how, per_turn, brief=True, model=model)

    def plain(self, row: dict[str, Any]) -> dict[str, Any]:
        """A row as part of a cell's answer: without the mechanism."""
        return row | ({"motion": row["motion"].plain()} if "motion" in row else {})

    def read(self, ratio: float, plain: dict[str, Any]) -> dict[str, Any]:
        """The row of a value over the present one, from a cell's answer."""
        if "motion" not in plain:
            return plain
        mechanism = self.mechanism.varied({self.key: float(ratio * self.present)})
        return plain | {"motion": Settled.of(mechanism, plain["motion"])}

    def of(self, motion: Settled) -> dict[str, Any]:
        """The row of a motion that has been followed."""
        answer = {"status": 0, "mechanism": motion.mechanism, "motion": motion, "model": None}
        value = float(Parameter(motion.mechanism, self.key).value)
        return self._row(value, answer, self._ideal([answer])[0])

    def _row(self, value: float, answer: dict[str, Any], ideal: dict[str, float]) -> dict[str, Any]:
        if answer["status"]:
            return {"status": answer["status"]}
        motion, model = answer["motion"], answer["model"]
        try:
            if not motion.period and self.slow and (orbit := self._on_orbit(value, motion)):
                motion, model = orbit, None
            found = self._forces(motion, model)
        except Unsettled as error:
            return {"status": error.status}
        like = np.array([ideal.get(name, np.nan) for name in found["names"]])
        lost = motion.traits["contact_loss"] or bool(np.any(found["separations"] > 0))
        row = {name: found[name] for name in ("names", "peak", "period", "impact_speed")}
        hardest = float(np.max(found["impact_speed"]))
        mark = float(grade(lost, largest(over_ideal(found["peak"], like)), hardest))
        mark = math.nan if self.slow and not motion.period else mark  # it may still swing
        row |= {"status": 0, "lost": lost, "ideal": like, "grade": mark, "motion": motion}
        return row | {"settled": bool(motion.period or motion.traits["chaos"])}

    def _on_orbit(self, value: float, motion: Settled) -> Settled | None:
        """The present orbit followed to a value, if a motion approaches it there however slowly."""
        known = self.walks[1 if abs(value) > abs(self.present) else -1]
        if known is None or (far := known.distance(value)) >= known.limit:
            return None
        before = [place for place in known.places if known.distance(place.value) <= far]
        walk = replace(known, places=[*before], limit=far)
        while (place := walk.onward()) and place.stable:
            pass
        known.places[: len(before)] = [each for each in walk.places if each.stable]
        if place or walk.ended is not None:
            known.limit = known.distance(place.value if place else walk.ended)  # as far as it is stable
            return None
        there = walk.places[-1].orbit
        near = approached(there, self.branch.map(value, there.map.rtol), motion.end.state)
        return on_orbit(motion.mechanism, there, self.how) if near else None

    def change(
        self, rows: list[dict[str, Any]], where: np.ndarray, sense: int, refined: bool = True
    ) -> np.ndarray:
        """The last place with the present grade on a side, and the first with another one, as `END`.

        The second one is NaN where it is not met. Where the change seems to be to a motion that has not
        settled, those are followed longer; so is that of the row, which may be as before then. Unless it is
        to be `refined`, it is that of the rows.
        """
        known = [*zip(map(float, where), rows, strict=True)][len(where) // 2 :: sense]
        known = [(ratio, row) for ratio, row in known if row.get("status") != NOT_RUN]
        inner, end = known[0], known[-1][0]
        farther = (end * 2.0 ** (sense * n) for n in range(1, round(math.log2(FARTHER)) + 1) if refined)
        for ratio, row in chain(known[1:], ((ratio, self._row_at(ratio)) for ratio in farther)):
            if refined and not _graded(row):
                self._longer(row)
            if not (_graded(row) and _graded(inner[1])):
                break
            if row["grade"] != inner[1]["grade"]:
                if not refined:
                    return np.array([_end(*inner), _end(ratio, row)])
                found = self._halved(inner, (ratio, row))
                if not found[1][1]["settled"]:
                    self._longer(row)
                    found = self._halved(inner, (ratio, row), longer=True)
                if row["grade"] != inner[1]["grade"]:
                    return np.array([_end(*place) for place in found])
            inner = ratio, row
        return np.array([_end(*inner), np.full(len(END), np.nan)])

    def _longer(self, row: dict[str, Any]) -> None:
        """Replace a row that has not settled by the motion that it becomes."""
        if not row.get("settled", True):
            with suppress(Unsettled):
                row |= self.of(reached(row["motion"].mechanism, row["motion"].end, self.longer))

    def _halved(self, inner: Spot, outer: Spot, longer: bool = False) -> tuple[Spot, Spot]:
        for _ in range(HALVED):
            between = math.sqrt(inner[0] * outer[0])
            row = self._row_at(between)
            if longer:
                self._longer(row)
            if not _graded(row):
                break
            same = row["grade"] == inner[1]["grade"]
            inner, outer = ((between, row), outer) if same else (inner, (between, row))
        return inner, outer

    def _row_at(self, ratio: float) -> dict[str, Any]:
        return self.rows(np.array([ratio]))[0]


def _graded(row: dict[str, Any]) -> bool:
    return not math.isnan(row.get("grade", math.nan))


def _begun(mechanism: Mechanism, changes: Any, start: Any, section: Section) -> dict[str, Any]:
    """A mechanism with changes, and its model at a start, of whose motion nothing is known."""
    place = mechanism.varied(changes)
    return {"status": 0, "mechanism": place, "model": placed(place, start, section), "motion": None}


def either_side(scene: Scene, edge: float, step: float) -> np.ndarray:
    """An edge as a change of the grade, with motions a step before and after it, as far as there is time."""
    found, away = np.full((2, len(END)), np.nan), math.log(edge)
    with suppress(OutOfTime):
        rows = scene.rows(np.exp(np.sign(away) * np.maximum(abs(away) + step * np.array([-1, 1]), 0.0)))
        found = np.array([_end(edge, row) for row in rows])
    found[:, [END.index("ratio"), END.index("by")]] = edge, BY.index("edge")
    return found


def _end(ratio: float, row: dict[str, Any]) -> np.ndarray:
    """Numbers of a place, in the order of `END`."""
    if "grade" not in row:
        return np.array([ratio, *np.full(len(END) - 1, np.nan)])
    ratios = over_ideal(row["peak"], row["ideal"])
    i = int(np.nanargmax(ratios)) if np.isfinite(ratios).any() else 0
    by = BY.index("values" if row["settled"] else "unsettled")
    return np.array([ratio, row["grade"], i, row["peak"][i], ratios[i], np.max(row["impact_speed"]), by])
