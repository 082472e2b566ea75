"""Starts of the motions of a sweep: given states, or the end of a neighbour's motion.

Positions of journals in their bearings, and the angles and speeds of links that give them others.

The vector from bearing to journal is r = const + sum_k D_k e_k (+ bases). With the crank held, other links'
angles that give every journal its position solve r(q) = r* by Newton's method, and their speeds then
A q' = r*' - A_crank q'_crank with A = dr/dq. A is exact without derivatives, by complex steps: r(q + i h) has
the imaginary part h dr/dq, and no difference is taken. Where journals leave more links free than they
determine, the smallest change is taken. Bending moves no journal (beams are pinned at both ends). Units: m,
rad, s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.evaluate import of_states
from jointplay.display.errors import InputError, Problem, refuse
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import ANGLE, FAR
from jointplay.solver.mechanism.model import DEEP, Model
from jointplay.solver.mechanism.own.oscillators import finite_numbers, inside, standing
from jointplay.solver.mechanism.records import Mechanism, Section, TestSystem

BEYOND = 1e-6  # of the clearance: rounding of a body that rests on a rigid face

ITERATIONS = 30
STEP = 1e-30  # of the imaginary part, rad or m
TOLERANCE = 1e-10  # of a journal's position, relative to the smallest clearance


class End(NamedTuple):
    """End of a motion: names and values of its positions and speeds, and the crank's angle.

    Also, where known, x and y of each journal in its bearing (m), and below these their velocities (m/s).
    """

    names: tuple[str, ...]
    state: np.ndarray
    crank_angle: float
    journals: np.ndarray | None = None

    @classmethod
    def read(cls, given: Sequence[Any]) -> End:
        """An end as a journal gives it back."""
        names, *rest = given
        return cls(tuple(names), *rest)


def end_of(model: Model, state: np.ndarray) -> End:
    """The end of a motion of a model, by its state at the model's crank angle."""
    names, journals = state_names(model), Journals(model) if model.links and model.joints else None
    if journals is None:
        return End(names, state, model.crank_angle)
    places = journals.positions(state[None, :]), journals.velocities(state[None, :])
    return End(names, state, model.crank_angle, np.concatenate(places))


def placed(
    mechanism: Mechanism | TestSystem, start: Any, section: Section | None = None, powers: bool = False
) -> Model:
    """Assemble a mechanism at a start, with the quantity of a section, and integrals of powers if wanted.

    The start is as in `assemble`; a state vector of a linkage too, which with a constant speed may have the
    crank's angle at its end (`whole_names`), else 0; or an `End` of a mechanism with the same states: where
    links or places of joints are other ones, journals stay where they were in their bearings, and a position
    beyond a wall is moved back to the wall.

    Raises
    ------
    InputError
        If the start, or the section, does not fit the mechanism.
    """
    watched = rules.quantity(section, mechanism)
    if isinstance(start, End):
        return _ended(mechanism, assemble(mechanism, None, watched, powers), start)
    if isinstance(mechanism, TestSystem) or start is None or isinstance(start, Mapping):
        return assemble(mechanism, start, watched, powers)
    model = assemble(mechanism, None, watched, powers)
    vector, n = _vector(model, start), len(model.state)
    if len(vector) > n:
        model = assemble(mechanism, {"crank_angle": float(vector[n])}, watched, powers)
    model = moved(model, vector[:n])
    _check_speed(model, start, mechanism.drive.imposed_speed if mechanism.drive else None)
    _check_journals(model, start)
    return model


def continued(
    mechanism: Mechanism | TestSystem, end: End | None, start: Any, section: Section | None
) -> Model:
    """Assemble a mechanism where another motion ended; at a start if none did, or it has other states."""
    if end is not None:
        model = assemble(mechanism, None, rules.quantity(section, mechanism))
        if state_names(model) == tuple(end.names):
            return _ended(mechanism, model, end)
    return placed(mechanism, start, section)


def _ended(mechanism: Mechanism | TestSystem, model: Model, end: End) -> Model:
    """The model of the mechanism, moved to an end."""
    if model.links and crank_place(model) is None:
        watched, powers = model.structure.section, model.structure.powers
        model = assemble(mechanism, {"crank_angle": end.crank_angle}, watched, powers)
    return _inside(_kept(moved(model, end.state), end))


def _kept(model: Model, end: End) -> Model:
    """The model with its journals where they were in their bearings; as it is where links cannot reach."""
    if end.journals is None:
        return model
    journals, states, (places, speeds) = Journals(model), model.state[None, :], np.array(end.journals)
    if np.abs(journals.positions(states)[0] - places).max() <= BEYOND * journals.clearances.min():
        return model
    (state,) = journals.put(states, places[None, :], speeds[None, :])
    return model if np.isnan(state).any() else replace(model, state=state)


def _check_speed(model: Model, start: Any, imposed: float | None) -> None:
    """Refuse a state in which the crank has another speed than the one that its drive imposes."""
    names, own = state_names(model), f"w_{model.crank}"
    if imposed is not None and own in names and model.state[names.index(own)] != imposed:
        raise refuse(start, f"{own} = {imposed!r}, at which the drive starts, is accepted", "initial")


def _check_journals(model: Model, start: Any) -> None:
    """Refuse a state whose journals are nowhere near their bearings."""
    if not model.joints:
        return
    ratios = Journals(model).eccentricity_ratios(model.state[None, :])[0]
    if np.any(ratios > DEEP):
        far = ", ".join(f"{name} {ratio:.3g}" for name, ratio in zip(model.joints, ratios, strict=True))
        expected = f"journals at most {DEEP} clearances from their bearings' centres are accepted, here {far}"
        raise refuse(start, expected, "initial")


def _vector(model: Model, start: Any) -> np.ndarray:
    names = ", ".join(whole_names(model))
    expected = f"a table of crank_angle and crank_speed, or a finite number for each of {names}, is accepted"
    values = finite_numbers(start, (len(model.state), len(whole_names(model))), expected)
    turning = [*np.flatnonzero(model.turning), *range(len(model.state), len(values))]
    if np.any(np.abs(values[turning]) > FAR):
        raise refuse(start, f"{ANGLE} ({', '.join(whole_names(model)[i] for i in turning)})", "initial")
    return values


def state_names(model: Model) -> tuple[str, ...]:
    """Names of positions and speeds: of a linkage as the equations call them, else as they were given."""
    if not model.links:
        return (*model.structure.positions, *model.structure.speeds)
    return tuple(cache.structure_module(model.structure).STATE[1:])


def whole_names(model: Model) -> tuple[str, ...]:
    """Names of a whole start: the states, and of a linkage the crank's angle where that is none of them."""
    turned = model.links and crank_place(model) is None
    return (*state_names(model), f"theta_{model.crank}") if turned else state_names(model)


def free_states(model: Model) -> tuple[str, ...]:
    """Names of the states that can differ by a little: all but the modes of a system."""
    return tuple(name for name in state_names(model) if name not in model.modes)


def crank_place(model: Model) -> int | None:
    """Index of the crank's angle in the state; None where its motion is prescribed, or there is no crank."""
    names, own = state_names(model), f"theta_{model.crank}"
    return names.index(own) if own in names else None


def moved(model: Model, state: np.ndarray) -> Model:
    """The model with another initial state."""
    crank = crank_place(model)
    angle = model.crank_angle if crank is None else float(state[crank])
    return replace(model, state=np.array(state, dtype=float), crank_angle=angle)


def stood(model: Model) -> Model:
    """The model with the modes and switches of a system as their guards at the start say."""
    if not model.modes:
        return model
    module = cache.structure_module(model.structure)
    numbers = dict(zip(module.PARAMETERS, model.numbers, strict=True))
    return replace(model, state=standing(model.structure, numbers, model.state))


def _inside(model: Model) -> Model:
    """The model, with a position beyond a rigid wall moved back to the wall."""
    module = cache.structure_module(model.structure)
    if not module.RESETS:
        return model
    if not model.links:
        model, numbers = stood(model), dict(zip(module.PARAMETERS, model.numbers, strict=True))
        return replace(model, state=inside(model.structure, numbers, model.state))
    states = model.state[None, :]
    shares = of_states(model, [f"eccentricity_ratio:{name}" for name in module.RESETS], states)
    sizes = {name.partition(":")[2]: float(abs(share[0])) for name, share in shares.items()}
    out = {name: size for name, size in sizes.items() if size > 1 + BEYOND}
    if not out:
        return model
    journals = Journals(model)
    nearer = 1 / np.repeat([out.get(name, 1.0) for name in model.joints], 2)
    (state,) = journals.put(states, nearer * journals.positions(states), journals.velocities(states))
    if np.isnan(state).any():
        expected = (
            "a start that links can bring inside rigid faces is accepted; it is {:.6g} clearances out at {}"
        )
        problems = (expected.format(share, name) for name, share in out.items())
        raise InputError(Problem("initial", "the end of another motion", each) for each in problems)
    return replace(model, state=state)


class Journals:
    """The journals of a linkage's joints with clearance.

    Parameters
    ----------
    model : Model
        The linkage; its state plays no part.
    """

    def __init__(self, model: Model):
        self.model, self.module = model, cache.structure_module(model.structure)
        names = self.module.STATE[1:]
        angles = [i for i in range(len(model.turning)) if not names[i].startswith("eta_")]
        self.crank = next((i for i in angles if names[i] == f"theta_{model.crank}"), None)
        self.free = [i for i in angles if i != self.crank]

    @property
    def clearances(self) -> np.ndarray:
        """Clearance of each journal's two coordinates, m."""
        return np.repeat(self.model.clearances, 2)

    def positions(self, states: np.ndarray, crank: complex | np.ndarray = 0.0) -> np.ndarray:
        """Journal centres relative to their bearings, m: (x, y) of each joint in turn.

        Parameters
        ----------
        states : ndarray, shape (rows, states)
            Positions and speeds.
        crank : complex or ndarray
            Angle by which a crank whose motion is prescribed is turned further, rad; of each row, or of all.
        """
        own = self._numbers
        turned = {"theta_0": own["theta_0"] + crank} if "theta_0" in own else {}
        keys = [f"journal_{axis}:{name}" for name in self.model.joints for axis in "xy"]
        return np.stack([*of_states(self.model, keys, states, **turned).values()], -1)

    def eccentricity_ratios(self, states: np.ndarray) -> np.ndarray:
        """Distances of journal and bearing centres over the clearances, shape (rows, joints)."""
        ratios = self.positions(states) / self.clearances
        return np.hypot(ratios[:, ::2], ratios[:, 1::2])

    def linear(self, states: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, derivatives by the free coordinates, velocities by the crank: of each state (row)."""
        rows, last = len(states), len(self.free)
        turned, steps = np.zeros(last + 1, complex), np.zeros((last + 1, states.shape[1]), complex)
        steps[np.arange(last), self.free] = 1j * STEP
        speed = np.full(rows, self._numbers.get("Omega", 0.0))
        if self.crank is None:
            turned[last] = 1j * STEP
        else:
            steps[last, self.crank], speed = 1j * STEP, states[:, len(self.model.turning) + self.crank]
        stepped = (states[:, None, :] + steps).reshape(-1, states.shape[1])
        values = self.positions(stepped, np.tile(turned, rows)).reshape(rows, last + 1, -1)
        slopes = values.imag.swapaxes(1, 2) / STEP
        return values[:, last].real, slopes[:, :, :last], slopes[:, :, last] * speed[:, None]

    def velocities(self, states: np.ndarray) -> np.ndarray:
        """Velocities of the journal centres relative to their bearings, m/s: (x, y) of each joint in turn."""
        _, A, by_crank = self.linear(states)
        return _times(A, states[:, len(self.model.turning) :][:, self.free]) + by_crank

    @property
    def _numbers(self) -> dict[str, float]:
        return dict(zip(self.module.PARAMETERS, self.model.numbers, strict=True))

    def put(self, states: np.ndarray, positions: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Give states with the same crank in which every journal has its position (m) and velocity (m/s).

        All have a row a state; NaN where the links cannot reach.
        """
        result, left = states.copy(), np.arange(len(states))
        speeds = [len(self.model.turning) + i for i in self.free]
        for _ in range(ITERATIONS):
            here, A, by_crank = self.linear(result[left])
            error, inverse = positions[left] - here, np.linalg.pinv(A)
            there = np.abs(error).max(axis=1) <= TOLERANCE * self.clearances.min()
            needed = velocities[left] - by_crank - _times(A, result[left][:, speeds])
            result[np.ix_(left[there], speeds)] += _times(inverse, needed)[there]
            result[np.ix_(left[~there], self.free)] += _times(inverse, error)[~there]
            left = left[~there]
            if not len(left):
                break
        result[left] = np.nan
        return result


def _times(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return (matrices @ vectors[:, :, None])[:, :, 0]
