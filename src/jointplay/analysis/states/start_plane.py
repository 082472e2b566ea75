"""A plane of initial states: two coordinates, each named as a user knows it, and the start at each node.

Of a test system any two states. Of a linkage: ``crank_angle`` (rad) and ``crank_speed`` (rad/s) of the ideal
mechanism; ``journal_x`` and ``journal_y``, the journal's centre in its bearing over the clearance, and
``journal_velocity_x``, ``journal_velocity_y`` (m/s), the other links following so that crank and other
journals keep theirs; or any state by its name (``theta_coupler``, ``w_coupler``, ...). A start beyond a rigid
wall, outside a bearing, or where the linkage does not close is none: its node gets a status.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from jointplay.analysis.rules import quantity
from jointplay.analysis.states.journal_position import Journals
from jointplay.codegen import cache, outputs
from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.model import Model
from jointplay.mechanism.records import ConstantSpeed, CrankAngle, Mechanism, TestSystem

CRANK = {"crank_angle": ("rad", "crank angle"), "crank_speed": ("rad s-1", "crank speed")}
JOURNAL = {
    "journal_x": ("1", "journal x over clearance"),
    "journal_y": ("1", "journal y over clearance"),
    "journal_velocity_x": ("m s-1", "journal velocity x"),
    "journal_velocity_y": ("m s-1", "journal velocity y"),
}
UNITS = {"theta": "rad", "w": "rad s-1", "x": "m", "y": "m", "vx": "m s-1", "vy": "m s-1"}
NODES = 1_000_000  # nodes of a plane
INSIDE = 1 + 1e-9  # of the clearance


def section_of(mechanism: Mechanism | TestSystem) -> str | None:
    """The quantity that cuts a motion once a turn (or forcing period); None where nothing turns."""
    if isinstance(mechanism, TestSystem) and mechanism.period is None:
        return None
    return quantity(CrankAngle(), mechanism)


def axes(plane: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Values along each axis of a plane that has been checked."""
    return {name: _values(given) for name, given in plane.items()}


def _values(given: Any) -> np.ndarray:
    if isinstance(given, Mapping):
        return np.linspace(given["start"], given["stop"], int(given["num"]))
    return np.asarray(given, dtype=float)


def nodes(plane: Mapping[str, np.ndarray]) -> np.ndarray:
    """Coordinates of every node, shape (nodes, 2); the second axis runs fastest."""
    first, second = plane.values()
    return np.stack([np.repeat(first, len(second)), np.tile(second, len(first))], -1)


def check(mechanism: Any, plane: Any, joint: Any, initial: Any) -> list[Problem]:
    """List what is wrong with a plane; none where the start that it is laid through makes no motion."""
    if plane is None:
        return []
    if len(plane) != 2:
        return [Problem("plane", plane, "a table of two coordinates, each with its values, is accepted")]
    try:
        model = assemble(mechanism, initial, section_of(mechanism))
    except InputError:
        return []
    known = coordinates(mechanism, model)
    found = [unknown(f"plane.{name}", name, name, known, "coordinate") for name in plane if name not in known]
    found += [problem for name, given in plane.items() for problem in _wrong_values(name, given)]
    found += _strangers(mechanism, model, tuple(plane), initial)
    loose = model.joints if model.links else ()
    if joint is not None and joint not in loose:
        found.append(unknown("joint", joint, joint, loose, "joint with clearance"))
    elif joint is None and len(loose) > 1 and set(plane) & set(JOURNAL):
        accepted = f"the joint whose journal is meant is needed: one of {', '.join(loose)}"
        found.append(Problem("joint", NOTHING, accepted))
    if not found and (nodes := math.prod(map(_count, plane.values()))) > NODES:
        found.append(Problem("plane", f"{nodes:,} nodes", f"at most {NODES:,} are accepted"))
    return found


def _count(given: Any) -> int:
    return given["num"] if isinstance(given, Mapping) else len(given)


def coordinates(mechanism: Mechanism | TestSystem, model: Model) -> dict[str, dict[str, str]]:
    """What a plane's axes can be, with the attributes of each."""
    found = {}
    if isinstance(mechanism, Mechanism):
        named = {} if mechanism.crank is None else CRANK
        named = named | (JOURNAL if model.joints else {})
        found = {name: {"units": units, "long_name": text} for name, (units, text) in named.items()}
    for name in cache.structure_module(model.structure).STATE[1:]:
        units = UNITS.get(name.split("_")[0], "1") if model.links else "1"
        found[name] = {"units": units, "long_name": f"state {name}"}
    return found


def _wrong_values(name: str, given: Any) -> Iterator[Problem]:
    if isinstance(given, Mapping):
        if not given["start"] < given["stop"]:
            yield Problem(f"plane.{name}", given, "a finite start less than a finite stop is accepted")
    elif len(given) < 2 or not all(a < b for a, b in pairwise(given)):
        accepted = "a list of at least two rising numbers, or a table of start, stop and num, is accepted"
        yield Problem(f"plane.{name}", given, accepted)


def _strangers(mechanism, model: Model, names: tuple[str, ...], initial: Any) -> Iterator[Problem]:
    """Coordinates that do not go together, or not with this start."""
    if not isinstance(mechanism, Mechanism):
        return
    journals = [name for name in names if name in JOURNAL]
    states = [name for name in names if name in cache.structure_module(model.structure).STATE]
    if journals and states:
        accepted = f"beside {journals[0]}, a coordinate of a journal or of the crank is accepted"
        yield Problem(f"plane.{states[0]}", states[0], accepted)
    if "crank_speed" in names and isinstance(mechanism.drive, ConstantSpeed):
        yield Problem("plane.crank_speed", "crank_speed", "the drive prescribes it: another is accepted")
    if isinstance(initial, Mapping) and "angle" in initial and set(names) & set(CRANK):
        accepted = "a start by crank_angle and crank_speed is accepted with these coordinates"
        yield Problem("initial", dict(initial), accepted)


class Starts:
    """The starts of a plane.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    initial : optional
        Start through which the plane is laid, as in `simulate`.
    names : tuple of str
        The coordinates.
    joint : str, optional
        Whose journal; the first joint with clearance if left out.
    """

    def __init__(self, mechanism, initial: Any, names: Sequence[str], joint: str | None = None):
        self.mechanism, self.initial, self.names = mechanism, initial, tuple(names)
        self.model = assemble(mechanism, initial, section_of(mechanism))
        self.states = cache.structure_module(self.model.structure).STATE[1:]
        self.loose = bool(self.model.links and self.model.joints)
        self.at = 2 * self.model.joints.index(joint) if joint is not None else 0

    def __call__(self, values: Sequence[float]) -> Model | None:
        """The model that starts at a node; None where there is no such start."""
        asked = dict(zip(self.names, map(float, values), strict=True))
        try:
            model = self._cranked({name: asked[name] for name in asked if name in CRANK})
        except InputError:
            return None
        state = model.state.copy()
        for name in asked.keys() & set(self.states):
            state[self.states.index(name)] = asked[name]
        model = replace(model, state=state)
        if asked.keys() & set(JOURNAL):
            model = self._journals(model, asked)
        if model is None or outside(model):
            return None
        if self.loose and np.any(Journals(model).eccentricity_ratios(model.state[None, :]) > INSIDE):
            return None
        return model

    def _cranked(self, asked: dict[str, float]) -> Model:
        if not asked:
            return self.model
        return assemble(self.mechanism, {**(self.initial or {}), **asked}, self.model.structure.section)

    def _journals(self, model: Model, asked: Mapping[str, float]) -> Model | None:
        journals = Journals(model)
        places = journals.places(model.state[None, :])[0]
        speeds = journals.velocities(model.state)
        for i, axis in enumerate("xy"):
            at = self.at + i
            places[at] = asked.get(f"journal_{axis}", places[at] / journals.clearances[at])
            places[at] *= journals.clearances[at]
            speeds[at] = asked.get(f"journal_velocity_{axis}", speeds[at])
        state = journals.put(model.state, places, speeds)
        return None if state is None else replace(model, state=state)

    def seen(self, states: np.ndarray) -> np.ndarray:
        """The plane's coordinates of states at the section, shape (rows, 2)."""
        return np.stack([self._seen(name, states) for name in self.names], -1)

    def _seen(self, name: str, states: np.ndarray) -> np.ndarray:
        if name in self.states:
            return states[:, self.states.index(name)]
        if name in CRANK:
            own = f"{'theta' if name == 'crank_angle' else 'w'}_{self.model.crank}"
            held = self.model.crank_angle if name == "crank_angle" else self.model.crank_speed
            return states[:, self.states.index(own)] if own in self.states else np.full(len(states), held)
        journals, at = Journals(self.model), self.at + "xy".index(name[-1])
        if "velocity" in name:
            return np.array([journals.velocities(state)[at] for state in states])
        return journals.places(states)[:, at] / journals.clearances[at]


def outside(model: Model) -> bool:
    """Whether a start is beyond a rigid wall."""
    if not model.resets:
        return False
    module = cache.structure_module(model.structure)
    given = dict(zip(module.PARAMETERS, model.numbers, strict=True))
    given |= dict(zip(module.STATE, [0.0, *model.state], strict=True))
    gaps = outputs.evaluate(module, [f"gap:{name}" for name in model.resets], given)
    return any(gap < 0 for gap in gaps.values())


def axis_coordinates(starts: Starts, axes: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """The axes as coordinates of a dataset."""
    known = coordinates(starts.mechanism, starts.model)
    return {name: (name, values, known[name]) for name, values in axes.items()}


def cells(mechanism, initial: Any, joint: str | None, names, values: np.ndarray, size: int, **more) -> list:
    """Keywords of a cell function for blocks of nodes."""
    shared = {"mechanism": mechanism, "initial": initial, "joint": joint, "names": tuple(names)} | more
    return [shared | {"values": values[i : i + size]} for i in range(0, len(values), size)]
