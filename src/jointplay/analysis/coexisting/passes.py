"""Jobs of `attractors` for workers: find the motions of one value, carry motions there, describe one.

All that is given and given back is plain: lists, numbers, arrays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from jointplay.analysis.coexisting.lasting import FAILED, NO_START, UNSETTLED, Lasting, Motions
from jointplay.analysis.coexisting.region import drawn
from jointplay.analysis.rules import section_of, varied
from jointplay.analysis.starts import End, end_of, placed, state_names
from jointplay.analysis.states.ends import Observation, sort_key
from jointplay.analysis.states.start_plane import Starts
from jointplay.analysis.sweeps.attractor import Plan, labelled, settle
from jointplay.display.errors import InputError
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, TestSystem

PILOTS = 192  # starts that are followed until they have arrived
CLOUD = 4  # points of a motion without a period from which it is carried on
Given = Mechanism | TestSystem


def found(
    mechanism: Given,
    changes: Mapping[str, float],
    region: Mapping[str, Sequence[float]],
    joint: str | None,
    initial: Any,
    starts: int,
    seed: int,
    observation: Observation,
) -> Entry:
    """Motions that last, of starts drawn in a region; counts of starts by where they end."""
    place = Starts(varied(mechanism, changes), initial, tuple(region), joint)
    value = next(iter(changes.values()), 0.0)
    motions = Motions(place.model, observation)
    labels = motions.sort(place.all(drawn(region, starts, seed, value)), PILOTS)
    tolerance = observation.tolerance
    lasting = sorted(
        (n for n in range(len(motions.known)) if np.any(labels == n)),
        key=lambda n: sort_key(motions.known[n].period, motions.known[n].points, tolerance),
    )
    ends = {"unsettled": UNSETTLED, "failed": FAILED, "no_start": NO_START}
    counts = {name: int(np.sum(labels == label)) for name, label in ends.items()}
    each = [plain(motions.known[n], int(np.sum(labels == n))) for n in lasting]
    return {"status": 0, "motions": each, "names": list(state_names(place.model))} | counts


def plain(motion: Lasting, count: int = 0) -> dict[str, Any]:
    """A motion with the number of starts that reach it."""
    return {
        "period": motion.period,
        "states": motion.states,
        "points": motion.points,
        "watched": motion.watched,
        "count": count,
    }


def carried(
    mechanism: Given,
    changes: Mapping[str, float],
    initial: Any,
    known: Sequence[Mapping[str, Any]],
    sources: Sequence[Mapping[str, Any]],
    observation: Observation,
) -> Entry:
    """Carry motions of neighbouring values here: each ends as a known motion, by number, or a `new` one."""
    here = varied(mechanism, changes)
    base = assemble(here, initial, section_of(here))
    lasting = [Lasting(each["period"], each["states"], each["points"]) for each in known]
    motions = Motions(base, observation, lasting)
    before = [mechanism.varied(each["changes"]) for each in sources]
    groups = [
        _starts(here, base, assemble(there, initial, section_of(there)), each)
        for there, each in zip(before, sources, strict=True)
    ]
    labels = iter(motions.sort([start for group in groups for start in group]).tolist())
    lands = [[next(labels) for _ in group] for group in groups]
    kept = sorted({n for group in lands for n in group if n >= len(known)})
    number = {n: len(known) + i for i, n in enumerate(kept)}
    lands = [[number.get(n, n) for n in group] for group in lands]
    return {"status": 0, "lands": lands, "new": [plain(motions.known[n]) for n in kept]}


def _spread(source: Mapping[str, Any]) -> np.ndarray:
    """States from which a motion is carried on: one of a periodic one, several of another."""
    states = source["states"]
    count = 1 if source["period"] else min(CLOUD, len(states))
    return states[np.linspace(len(states) - 1, 0, count).astype(int)]


def _starts(here: Given, base: Model, before: Model, source: Mapping[str, Any]) -> list[Model | None]:
    """States of another value's motion, of its model before, as starts here; None where it is none."""
    if tuple(source["names"]) != state_names(base):
        return [None for _ in _spread(source)]
    return [_start(here, end_of(before, state)) for state in _spread(source)]


def _start(here: Given, end: End) -> Model | None:
    try:
        return placed(here, end, None if section_of(here) is None else CrankAngle())
    except InputError:
        return None


def section_at(mechanism: Given, initial: Any) -> CrankAngle | None:
    """The section at which motions are cut; None where nothing turns."""
    if section_of(mechanism) is None:
        return None
    return CrankAngle(angle=assemble(mechanism, initial, section_of(mechanism)).crank_angle)


def described(
    mechanism: Given, changes: Mapping[str, float], initial: Any, motion: Mapping[str, Any], plan: Plan
) -> Entry:
    """Section points, contacts and exponents of a motion, as a point of a sweep has them."""
    here = varied(mechanism, changes)
    base = assemble(here, initial, section_of(here))
    plan = replace(plan, section=section_at(here, initial))
    end = End(state_names(base), motion["states"][-1], base.crank_angle)
    answer, shown = settle(here, end, plan), motion["period"] or plan.keep
    answer.pop("end", None)
    points = answer.get("points", {})
    answer["points"] = {name: (dims, rows[-shown:], own) for name, (dims, rows, own) in points.items()}
    return labelled(answer, plan.keep)
