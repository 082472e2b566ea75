"""Derivatives of the numbers of the equations, the start and the period in a parameter.

A number that a person names, such as a length, enters several numbers of the equations (mechanism.assemble),
the start of the ideal mechanism, and the period. All of them are smooth algebra, without a motion: they are
differentiated by central differences of sixth order,

    f' = [45 (f_1 - f_-1) - 9 (f_2 - f_-2) + (f_3 - f_-3)] / 60 h,

at two steps h, whose results' distance is the error that is told. With h a thousandth of the parameter it is
of the order of 1e-13. At the end of what a parameter can be, the six values lie to one side of it. What they
drive along a motion is carried exactly (method.tangents.tangent).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from jointplay.display.errors import InputError, refuse
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model

STEP = 2e-3  # of the parameter
AT_ZERO = 1e-4  # in the parameter's SI unit, where it is 0
SIDES = (
    (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0),
    (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
    (-6.0, -5.0, -4.0, -3.0, -2.0, -1.0),
)
NOISE = 1e-13  # of a number: changes up to it, over a step, are rounding


@dataclass(frozen=True)
class Directions:
    """Changes with parameters, one direction each.

    Parameters
    ----------
    names : tuple of tuple of str
        Numbers of the equations that change along each.
    rates : ndarray
        Of these, one direction after the other.
    starts : ndarray
        Derivatives of the state at the start, shape (directions, states).
    begins, periods : ndarray
        Derivatives of the time at which a run begins, and of the period; shape (directions,).
    units : ndarray
        Sizes of the parameters themselves, 1 of one that is 0.
    errors : ndarray
        Largest error of each direction's differences, relative to the largest of the same number's.
    """

    names: tuple[tuple[str, ...], ...]
    rates: np.ndarray
    starts: np.ndarray
    begins: np.ndarray
    periods: np.ndarray
    units: np.ndarray
    errors: np.ndarray

    def __len__(self) -> int:
        return len(self.names)

    @property
    def rates_of(self) -> list[np.ndarray]:
        """Rates of the numbers that change, by direction."""
        return np.split(self.rates, np.cumsum([len(each) for each in self.names])[:-1])


def stacked(parts: Sequence[Directions]) -> Directions:
    """Several directions as one."""
    each = zip(*((d.rates, d.starts, d.begins, d.periods, d.units, d.errors) for d in parts), strict=True)
    return Directions(sum((d.names for d in parts), ()), *map(np.concatenate, each))


def along(
    models: Callable[[float], Model],
    value: float,
    key: str = "parameter",
    begin: Callable | None = None,
    precise: bool = True,
) -> Directions:
    """The direction of one parameter.

    Parameters
    ----------
    models : callable
        The model at a value of the parameter, and its start.
    value : float
        Where.
    key : str
        Name of the parameter in messages.
    begin : callable, optional
        Time at which a run of a model begins; 0 if left out.
    precise : bool
        Whether the error is estimated, by as many models again, and both sides have to exist. Else it is 0,
        and one side is enough.

    Raises
    ------
    InputError
        If the parameter cannot change to both sides, or changes more than numbers.
    """
    centre = models(value)

    def listed(at: float) -> np.ndarray:
        model = models(at)
        if model.structure != centre.structure or len(model.state) != len(centre.state):
            raise refuse(value, f"{key} changes which equations hold here: it has no derivative", key)
        return np.concatenate([model.numbers, model.state, [begin(model) if begin else 0.0, model.period]])

    here, step = listed(value), STEP * abs(value) or AT_ZERO
    sides = SIDES[:1] if precise else SIDES
    finer = slope(listed, value, step / 2, here, sides)
    found = slope(listed, value, step, here, sides) if precise else finer
    size = np.maximum(np.abs(finer), NOISE * np.abs(here) / step)
    changes = np.abs(finer) * step > NOISE * np.abs(here)
    error = np.max(np.where(changes, np.abs(found - finer) / np.where(size > 0, size, 1.0), 0.0))
    slopes, n = np.where(changes, finer, 0.0), len(centre.numbers)
    parameters = cache.structure_module(centre.structure).PARAMETERS
    names = tuple(name for name, moves in zip(parameters, changes[:n], strict=True) if moves)
    own, unit = slopes[:n][changes[:n]], np.array([abs(value) or 1.0])
    times = slopes[-2:-1], slopes[-1:]
    return Directions((names,), own, slopes[None, n:-2], *times, unit, np.array([error]))


def of_start(model: Model, place: int) -> Directions:
    """The direction of the initial value of the state at a place."""
    none = np.zeros(1)
    return Directions(((),), np.zeros(0), np.eye(len(model.state))[[place]], none, none, np.ones(1), none)


def slope(
    function: Callable[[float], np.ndarray], value: float, step: float, here: np.ndarray, sides: Sequence
) -> np.ndarray:
    """Derivative of a function that is `here` at a value, from nearby places at which it exists."""
    refused = None
    for places in sides:
        try:
            changes = [function(value + place * step) - here for place in places]
        except InputError as error:
            refused = refused or error
            continue
        return np.linalg.solve(np.vander(places, 7, increasing=True).T[1:], np.eye(6)[0]) @ changes / step
    raise refused
