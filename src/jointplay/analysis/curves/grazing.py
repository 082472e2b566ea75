"""The condition of grazing: somewhere on an orbit a guard comes just short of firing.

With m(t) the margin of that guard along the orbit, m = 0 and m' = 0 there: g = min m, over its own size. With
M the tangents up to the minimum, dg = grad m M dx + dm/dp dp, since m' = 0. A curve is followed on that side
on which the guard does not fire: there the map is smooth up to the curve, also where an impact beyond it has
a square-root singularity. Its points lie SHORT of the curve; iterates that pass it are drawn back.
References: Nordmark, J. Sound Vib. 145 (1991) 279-297; di Bernardo et al., Piecewise-smooth Dynamical Systems
(2008), chapter 6.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.curves.half_map import HalfMap
from jointplay.analysis.curves.margins import SAMPLES, Guards
from jointplay.analysis.orbits.branch_points import doubling, unit
from jointplay.analysis.orbits.family import Family, Point, Trial
from jointplay.analysis.orbits.section_map import Image, SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.tangents import Bundle
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.directions import Directions
from jointplay.solver.mechanism.model import Model

SHORT = 1e-10  # of the margin's size
NEAR = 3e-3  # of a multiplier from +1 or -1 where a curve of folds or doublings is met
EARLIER = 1e-4  # of the time between samples: a run to the minimum itself may fire the guard by rounding
PART = 1e-7  # of the scales, small beside a clearance: differences of a margin


class Meeting:
    """Meetings of a curve on which an event vanishes with curves of folds and doublings."""

    def tests(self, one: Point) -> Mapping[str, Callable[[Point], float]]:
        """Zeros where the orbit that grazes also folds or doubles."""
        return {"fold_grazing": unit, "doubling_grazing": doubling}

    def genuine(self, kind: str, point: Point) -> bool:
        """Whether the zero of a test is a genuine point of its kind."""
        wanted = 1.0 if kind == "fold_grazing" else -1.0
        return bool(np.any(np.abs(np.asarray(point.multipliers) - wanted) < NEAR))


@dataclass(frozen=True)
class Grazing(Meeting):
    """A guard that nearly fires.

    Parameters
    ----------
    guard : int
        Its number.
    size : float
        Of its margin, by which it is divided.
    event : tuple of int
        Contact and kind of the event that begins beyond the curve.
    """

    guard: int
    size: float
    event: tuple[int, int] = (-1, -1)
    sided = True

    def value(self, trial: Trial, like: Point) -> float:
        """The least margin over its size, less `SHORT`; NaN where the guard fires once more, or less."""
        found = self._least(trial, like)
        return np.nan if found is None else found[0] / self.size - SHORT

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Its derivatives in the coordinates x/c and the fractions of the ranges."""
        found = self._least(trial, like)
        if found is not None:
            found = slopes(family, trial, like, found[1], self._margin)
        if found is None:
            return np.full(len(trial.section.free) + family.count, np.nan)
        return found[1][0] / self.size

    def _margin(self, model: Model, rows: np.ndarray) -> np.ndarray:
        return Guards(model).margins(rows)[:, [self.guard]]

    def _least(self, trial: Trial, like: Point) -> tuple[float, float] | None:
        guards, image = Guards(trial.section.model), trial.image
        before = guards.count(self.guard, like.orbit.image.events)
        if image.status or guards.count(self.guard, image.events) != before:
            return None
        found = guards.nearest(trial.section, trial.state, image.time, image.events)
        if found is None or not np.isfinite(found[0][self.guard]):
            return None
        near, apart = found[1][self.guard], spacing(trial.section, image)
        return guards.minimum(trial.section, trial.state, self.guard, near, apart, image.time)


def spacing(section: SectionMap, image: Image) -> float:
    """Time between the samples of an orbit, s."""
    return image.time / (SAMPLES * section.turns)


def slopes(
    family: Family, trial: Trial, like: Point, time: float, of: Callable[[Model, np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Numbers of a state at a time of an orbit, their derivatives, their rates; None if it fails.

    `of`: the numbers, by a model and rows of time, state, modes. Derivatives are rows: in the coordinates x/c
    and the fractions of the ranges. Extrapolated from two times just before.
    """
    later, section = EARLIER * spacing(trial.section, trial.image), trial.section
    run = trial.state, section.request(time - later), np.eye(len(trial.state)), trial.directions
    bundle, _, status = section.run(*run, until=time - 2 * later)
    if status:
        return None
    far = _slopes(family, trial, like, bundle, later, of)
    if bundle.advance():
        return None
    near = _slopes(family, trial, like, bundle, later, of)
    return tuple(2 * one - other for one, other in zip(near, far, strict=True))


def _slopes(family: Family, trial: Trial, like: Point, bundle: Bundle, later: float, of: Callable):
    section, state, directions = trial.section, trial.state, trial.directions
    here = np.concatenate([[bundle.time], bundle.state, bundle.motion.modes])
    steps = np.zeros((2 * len(state), len(here)))
    for i, part in enumerate(PART * section.scale):
        steps[2 * i, 1 + i], steps[2 * i + 1, 1 + i] = part, -part
    values = of(section.model, here + steps)
    gradients = (values[::2] - values[1::2]).T / (2 * PART * section.scale)
    rows = gradients @ bundle.vectors.T
    own = [
        np.diff([of(moved, here[None])[0] for moved in sides], axis=0)[0] / (2 * PART * size)
        for sides, size in zip(_varied_models(section.model, directions), directions.units, strict=True)
    ]
    ahead = later * np.concatenate([[1.0], bundle.rate(), 0.0 * bundle.motion.modes])
    after, ago = of(section.model, np.stack([here + ahead, here - ahead]))
    coordinates = like.unit * (rows[:, : len(state)] * section.scale)[:, section.free]
    ranges = (rows[:, len(state) :] + np.transpose(own)) * (family.high - family.low)
    return of(section.model, here[None])[0], np.hstack([coordinates, ranges]), (after - ago) / (2 * later)


def _varied_models(model: Model, directions: Directions) -> Iterator[tuple[Model, Model]]:
    """The model with its numbers a little before and after, in each direction."""
    places = {name: i for i, name in enumerate(cache.structure_module(model.structure).PARAMETERS)}
    for names, rates, size in zip(directions.names, directions.rates_of, directions.units, strict=True):
        change = np.zeros(len(model.numbers))
        change[[places[name] for name in names]] = PART * size * rates
        yield replace(model, numbers=model.numbers - change), replace(model, numbers=model.numbers + change)


def grazed(orbit: Orbit, event: tuple[int, int]) -> tuple[float, Grazing] | None:
    """The guard of an event's contact that nearly fires on an orbit, and its margin over its size.

    None where none comes near. On half a symmetric orbit it may be the mirror image's.
    """
    section, guards = orbit.map, Guards(orbit.map.model)
    found = guards.nearest(section, orbit.state, orbit.image.time, orbit.image.events)
    if found is None:
        return None
    least, _, sizes = found
    fits = (guards.owner(g) == event[0] or isinstance(section, HalfMap) for g in range(len(least)))
    owned = [g for g, fit in enumerate(fits) if fit and event[1] in guards.kinds(g) and np.isfinite(least[g])]
    if not owned:
        return None
    guard = min(owned, key=lambda g: least[g] / sizes[g])
    return float(least[guard] / sizes[guard]), Grazing(guard, float(sizes[guard]), event)
