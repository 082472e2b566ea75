"""A plane of initial states: two coordinates by name, and the start at each node.

Of a test system any two states. Of a linkage: ``crank_angle`` (rad) and ``crank_speed`` (rad/s) of the ideal
mechanism; ``journal_x`` and ``journal_y`` (m), the journal's centre in its bearing, or the same over the
clearance, ``eccentricity_ratio_x`` and ``eccentricity_ratio_y``; ``journal_velocity_x``,
``journal_velocity_y`` (m/s), the other links following so that crank and other journals keep theirs; or any
state by its name (``theta_coupler``, ``w_coupler``, ...). A start beyond a rigid wall, outside a bearing, or
where the linkage does not close is no start: its node gets a status.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import of_states
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import on_section
from jointplay.analysis.starts import Journals, free_states, state_names, stood
from jointplay.display.errors import NOTHING, InputError, Problem, strangers, unknown
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import ConstantSpeed, Mechanism, TestSystem

CRANK = {"crank_angle": ("rad", "crank angle"), "crank_speed": ("rad s-1", "crank speed")}
JOURNAL = {
    "journal_x": ("m", "journal centre, x"),
    "journal_y": ("m", "journal centre, y"),
    "eccentricity_ratio_x": ("1", "journal centre over clearance, x"),
    "eccentricity_ratio_y": ("1", "journal centre over clearance, y"),
    "journal_velocity_x": ("m s-1", "journal velocity x"),
    "journal_velocity_y": ("m s-1", "journal velocity y"),
}
UNITS = {"theta": "rad", "w": "rad s-1", "x": "m", "y": "m", "vx": "m s-1", "vy": "m s-1"}
UNITS |= {"slide": "m", "vslide": "m s-1"}
MOST_NODES = 1_000_000
TOGETHER = 1024  # starts that are made at once, for the memory that takes
INSIDE = 1 + 1e-9  # of the clearance
PLACES = {
    "journal_": "eccentricity_ratio_",
    "eccentricity_ratio_": "journal_",
}  # in m, and over the clearance
FARTHEST = 10.0  # clearances from the bearing's centre: farther out another unit is meant
CRASHED = STATUS.index("crashed")


def axis_values(plane: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Values along each axis of a plane that has been checked."""
    return {
        name: np.linspace(given["start"], given["stop"], int(given["num"]))
        if isinstance(given, Mapping)
        else np.asarray(given, dtype=float)
        for name, given in plane.items()
    }


def grid(axes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Coordinates of every node, shape (nodes, 2); the second axis runs fastest."""
    first, second = axes.values()
    return np.stack([np.repeat(first, len(second)), np.tile(second, len(first))], -1)


def plane_fits(mechanism: Any, plane: Any, joint: Any, initial: Any, model: Any = None) -> list[Problem]:
    """List the problems of a plane; none where the start that it is laid through cannot be assembled."""
    if plane is None:
        return []
    if len(plane) != 2:
        return [Problem("plane", plane, "a table of two coordinates, each with its values, is accepted")]
    problems = coordinate_problems("plane", mechanism, plane, joint, initial, model)
    problems += [each for name, given in plane.items() for each in _wrong_values(name, given)]
    counts = [given["num"] if isinstance(given, Mapping) else len(given) for given in plane.values()]
    if not problems and (nodes := math.prod(counts)) > MOST_NODES:
        problems.append(Problem("plane", f"{nodes:,} nodes", f"at most {MOST_NODES:,} are accepted"))
    return problems


def coordinate_problems(
    key: str, mechanism: Any, given: Mapping[str, Any], joint: Any, initial: Any, model: Model | None
) -> list[Problem]:
    """List the problems of coordinates named under a key; none where their start cannot be assembled."""
    if model is None:
        return []
    known = coordinates(mechanism, model)
    problems = list(strangers(((f"{key}.{name}", name) for name in given), known, "coordinate"))
    problems += _incompatible(key, mechanism, model, tuple(given), initial)
    loose = _bearings(model)
    if loose and joint in (None, *loose):
        clearance = model.clearances[model.joints.index(joint or loose[0])]
        problems += [each for name in given for each in _wrong_unit(key, name, given[name], clearance)]
    if joint is not None and joint not in loose:
        problems.append(unknown("joint", joint, joint, loose, "joint with clearance"))
    elif joint is None and len(loose) > 1 and set(given) & set(JOURNAL):
        accepted = f"the joint whose journal is meant is needed: one of {', '.join(loose)}"
        problems.append(Problem("joint", NOTHING, accepted))
    return problems


def _wrong_unit(key: str, name: str, given: Any, clearance: float) -> Iterator[Problem]:
    """Yield the problem of a journal's place that is given in the unit of the other word for it."""
    word, axis = name[:-1], name[-1]
    if name not in JOURNAL or word not in PLACES:
        return
    ends = (given["start"], given["stop"]) if isinstance(given, Mapping) else given
    far, scale = max((abs(end) for end in ends), default=0.0), clearance if word == "journal_" else 1.0
    other, meant = f"{PLACES[word]}{axis}", far <= clearance and word != "journal_"
    if far > FARTHEST * scale or (meant and far > 0):
        unit = {"journal_": "in m", "eccentricity_ratio_": "over the clearance"}
        yield Problem(
            f"{key}.{name}",
            given,
            f"the journal's place {unit[word]} is accepted, up to the clearance of {clearance:g} m; "
            f"{unit[PLACES[word]]} it is {other}",
        )


def coordinates(mechanism: Mechanism | TestSystem, model: Model) -> dict[str, dict[str, str]]:
    """Coordinates that a plane of starts can have, with the attributes of each."""
    linkage = isinstance(mechanism, Mechanism)
    named = (CRANK if linkage and mechanism.crank else {}) | (JOURNAL if linkage and _bearings(model) else {})
    units = UNITS if model.links else {}
    named |= {name: (units.get(name.split("_")[0], "1"), f"state {name}") for name in free_states(model)}
    return {name: {"units": unit, "long_name": text} for name, (unit, text) in named.items()}


def _bearings(model: Model) -> tuple[str, ...]:
    """Names of joints whose journal can be put anywhere in its bearing; a slider's corner cannot."""
    return tuple(joint.name for joint in model.structure.joints if not joint.corner) if model.links else ()


def _wrong_values(name: str, given: Any) -> Iterator[Problem]:
    if isinstance(given, Mapping):
        if not given["start"] < given["stop"]:
            yield Problem(f"plane.{name}", given, "a finite start less than a finite stop is accepted")
    elif len(given) < 2 or not all(a < b for a, b in pairwise(given)):
        accepted = "a list of at least two rising numbers, or a table of start, stop and num, is accepted"
        yield Problem(f"plane.{name}", given, accepted)


def _incompatible(
    key: str, mechanism, model: Model, names: tuple[str, ...], initial: Any
) -> Iterator[Problem]:
    """Yield the problems of coordinates that do not fit one another, the drive or the start."""
    if not isinstance(mechanism, Mechanism):
        return
    journals = [name for name in names if name in JOURNAL]
    states = [name for name in names if name in state_names(model)]
    for name in journals:
        if (twin := f"{PLACES.get(name[:-1], '')}{name[-1]}") in journals and name < twin:
            yield Problem(
                f"{key}.{twin}", twin, f"a coordinate other than {name}, which is the same, is accepted"
            )
    if journals and states:
        accepted = f"beside {journals[0]}, a coordinate of a journal or of the crank is accepted"
        yield Problem(f"{key}.{states[0]}", states[0], accepted)
    if "crank_speed" in names and isinstance(mechanism.drive, ConstantSpeed):
        accepted = "another coordinate is accepted: the drive prescribes this one"
        yield Problem(f"{key}.crank_speed", "crank_speed", accepted)
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
    names : sequence of str
        The coordinates.
    joint : str, optional
        Whose journal; the first joint with clearance if left out.
    model : Model, optional
        The mechanism at that start, on its section, where it has been assembled.
    """

    def __init__(self, mechanism, initial: Any, names: Sequence[str], joint: str | None = None, model=None):
        self.mechanism, self.initial, self.names = mechanism, initial, tuple(names)
        self.model = on_section(mechanism, initial) if model is None else model
        self.states = state_names(self.model)
        bearings = (joint,) if joint is not None else _bearings(self.model)
        self.joint = 2 * self.model.joints.index(bearings[0]) if bearings else 0

    def __call__(self, values: Sequence[float]) -> Model | None:
        """The model that starts at a node; None where there is no such start."""
        return self.all(np.array([values]))[0]

    def all(self, nodes: np.ndarray) -> list[Model | None]:
        """The models that start at nodes, shape (nodes, coordinates); None where there is no such start."""
        crank = [i for i, name in enumerate(self.names) if name in CRANK]
        if crank:
            groups = [(self._turned(node[crank]), node[None]) for node in nodes]
        else:
            groups = [(self.model, nodes[i : i + TOGETHER]) for i in range(0, len(nodes), TOGETHER)]
        return [start for group in groups for start in self._starting(*group)]

    def _turned(self, values: np.ndarray) -> Model | None:
        """The model with another crank; None where it cannot be assembled."""
        given = dict(zip([name for name in self.names if name in CRANK], map(float, values), strict=True))
        try:
            return assemble(self.mechanism, {**(self.initial or {}), **given}, self.model.structure.section)
        except InputError:
            return None

    def _starting(self, model: Model | None, nodes: np.ndarray) -> list[Model | None]:
        """The models that start at nodes with the crank of a model."""
        if model is None:
            return [None] * len(nodes)
        given, states = dict(zip(self.names, nodes.T, strict=True)), np.tile(model.state, (len(nodes), 1))
        for name in given.keys() & set(self.states):
            states[:, self.states.index(name)] = given[name]
        good = np.ones(len(nodes), dtype=bool)
        if model.links and model.joints:
            journals = Journals(model)
            if given.keys() & set(JOURNAL):
                states = self._with_journal(journals, states, given)
            good = (journals.eccentricity_ratios(states) <= INSIDE).all(axis=1)
        starts = [stood(replace(model, state=state)) for state in states]
        return [
            start if ok and not beyond_a_wall(start) else None for start, ok in zip(starts, good, strict=True)
        ]

    def _with_journal(self, journals: Journals, states: np.ndarray, given: Mapping[str, Any]) -> np.ndarray:
        """States with the journal at the values given; NaN where the links cannot reach."""
        positions, speeds = journals.positions(states).copy(), journals.velocities(states)
        for i, axis in enumerate("xy", self.joint):
            positions[:, i] = given.get(f"journal_{axis}", positions[:, i])
            if (name := f"eccentricity_ratio_{axis}") in given:
                positions[:, i] = given[name] * journals.clearances[i]
            speeds[:, i] = given.get(f"journal_velocity_{axis}", speeds[:, i])
        return journals.put(states, positions, speeds)

    def projected(self, states: np.ndarray) -> np.ndarray:
        """The plane's coordinates of states at the section, shape (rows, 2)."""
        return np.stack([self._coordinate(name, states) for name in self.names], -1)

    def _coordinate(self, name: str, states: np.ndarray) -> np.ndarray:
        if name in self.states:
            return states[:, self.states.index(name)]
        if name in CRANK:
            own = f"{'theta' if name == 'crank_angle' else 'w'}_{self.model.crank}"
            held = self.model.crank_angle if name == "crank_angle" else self.model.crank_speed
            return states[:, self.states.index(own)] if own in self.states else np.full(len(states), held)
        journals, i = Journals(self.model), self.joint + "xy".index(name[-1])
        if "velocity" in name:
            return journals.velocities(states)[:, i]
        scale = journals.clearances[i] if name.startswith("eccentricity") else 1.0
        return journals.positions(states)[:, i] / scale

    def axes(self, values: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Values along the plane's axes as coordinates of a dataset."""
        known = coordinates(self.mechanism, self.model)
        return {name: (name, values[name], known[name]) for name in self.names}

    def cells(self, nodes: np.ndarray, size: int, **more: Any) -> list[dict[str, Any]]:
        """Keywords of a cell function for blocks of nodes."""
        return [{"starts": self, "nodes": nodes[i : i + size]} | more for i in range(0, len(nodes), size)]


def with_crashed(answers: list[dict[str, Any]], cells: list[dict[str, Any]], **missing: Any) -> list[dict]:
    """Answers of cells; of one that crashed its status, and the `missing` values, at every node."""

    def at_nodes(answer: dict[str, Any], count: int) -> dict[str, Any]:
        values = missing | {"node_status": answer["status"]}
        return {name: [value] * count for name, value in values.items()}

    return [at_nodes(each, len(cell["nodes"])) | each for each, cell in zip(answers, cells, strict=True)]


def plane_status(status: np.ndarray) -> int:
    """Status of a plane: crashed if any node is, the least where no node ended well; else ok."""
    if np.any(status == CRASHED):
        return CRASHED
    return int(status.min()) if status.size else 0


def beyond_a_wall(model: Model) -> bool:
    """Whether a start is beyond a rigid wall."""
    keys = [f"gap:{name}" for name in model.resets]
    return bool(keys) and any(gap[0] < 0 for gap in of_states(model, keys, model.state[None, :]).values())
