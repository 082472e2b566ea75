"""Whether a system of own equations has numbers at its start, and where its jumps lead from near there."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from jointplay.display.errors import InputError, Problem
from jointplay.solver.equations.own.grammar import number, parse
from jointplay.solver.mechanism.own.own_equations import Equations

EVEN = 1e-9  # relative difference of rates a period apart, beyond which they do not repeat
NUDGE = 1e-6


@lru_cache(maxsize=1000)
def names_in(text: str) -> frozenset[str]:
    """Names in an expression."""
    return frozenset(parse(text).names)


def values(system: Equations) -> Iterator[Problem]:
    """Problems of initial values and of the period as numbers."""
    texts = {f"states.{name}": text for name, text in system.states.items()}
    texts |= {"forcing": system.forcing} if system.forcing is not None else {}
    for key, text in texts.items():
        try:
            value = number(text, system.numbers)
        except InputError as error:
            yield from error.under(key).problems
        else:
            if key == "forcing" and value == 0:
                yield Problem(key, text, "a period other than 0 is accepted")


class _Here:
    """Expressions as numbers at the initial state, with some of the names changed."""

    def __init__(self, system: Equations) -> None:
        names = [name for group in system.order for name in group]
        self.system, self.names = system, dict(zip(names, system.initial, strict=True))
        self.names |= {**system.numbers, "t": 0.0} | {each.name: 0.0 for each in system.switches}
        for i, each in enumerate(system.switches):
            try:
                self.names[each.name] = float(self(each.on) > 0)
            except InputError as error:
                raise error.under(f"switches[{i}].on") from None

    def __call__(self, text: str, **changed: float) -> float:
        return number(text, self.names | changed)

    def slopes(self, text: str, names: Collection[str]) -> np.ndarray:
        """Slopes by names, from differences."""
        up, down = ([self(text, **{n: self.names[n] + step}) for n in names] for step in (NUDGE, -NUDGE))
        return (np.array(up) - down) / (2 * NUDGE)


def at_the_start(system: Equations) -> Iterator[Problem]:
    """Numbers that are not finite at the start, a singular mass matrix, jumps that lead nowhere."""
    try:
        here = _Here(system)
    except InputError as error:
        yield from error.problems
        return
    for name, text in system.rates.items():
        try:
            value = here(text)
            later = here(text, t=system.period or 0.0)
        except InputError as error:
            yield from (
                Problem(f"rates.{name}", p.given, f"at the initial state, {p.expected}")
                for p in error.problems
            )
            continue
        if not abs(later - value) <= EVEN * max(1.0, abs(value)):
            accepted = f"a rate that repeats after the period {system.period:g} is accepted"
            yield Problem(f"rates.{name}", text, f"{accepted}: it is {value:g} at t = 0, and {later:g} then")
    try:
        yield from _singular(system, here)
        for i, each in enumerate(system.impacts):
            yield from _restitution(f"impacts[{i}].restitution", each.restitution, here)
        jumps = {f"jumps[{i}]": each for i, each in enumerate(system.jumps)}
        for mode, exits in system.modes.items():
            jumps |= {f"modes.{mode}[{i}]": each for i, each in enumerate(exits) if each.to == mode}
        for place, each in jumps.items():
            yield from _comes_back(place, each, here)
    except InputError:
        return  # it has no number at the start alone


def _singular(system: Equations, here: _Here) -> Iterator[Problem]:
    if not system.mass:
        return
    given = system.structure()
    matrix = np.zeros((len(given.speeds),) * 2)
    for i, j, text in given.mass:
        matrix[i, j] = matrix[j, i] = here(text)
    values = np.linalg.eigvalsh(matrix)
    if not values[0] > 1e-12 * max(abs(values[-1]), 1e-300):
        yield Problem(
            "mass",
            system.mass,
            f"a positive definite matrix is accepted; its least eigenvalue is {values[0]:.3g}",
        )


def _restitution(key: str, text: str | None, here: _Here) -> Iterator[Problem]:
    if text is not None and not 0 <= (value := here(text)) <= 1:
        yield Problem(key, text, f"a restitution of 0 to 1 is accepted, not {value:g}")


def _comes_back(place: str, each: Any, here: _Here) -> Iterator[Problem]:
    """Problem of a jump that ends on its guard or beyond, from where the guard is zero near the start."""
    states = [name for group in here.system.order for name in group if name in names_in(each.guard)]
    at = {name: here.names[name] for name in states}
    for _ in range(50):  # Newton's method, down the guard's slope
        value = here(each.guard, **at)
        point = _Here.__new__(_Here)
        point.system, point.names = here.system, here.names | at
        slopes = point.slopes(each.guard, states)
        if not slopes.any() or abs(value) < 1e-12:
            break
        at = {
            n: float(x - value * s / (slopes @ slopes)) for (n, x), s in zip(at.items(), slopes, strict=True)
        }
    if not states or not abs(value) < 1e-9:
        return
    new = {name: here(text, **at) for name, text in each.jump.items()}
    after = here(each.guard, **at | new)
    if not after > 1e-9 * max(1.0, *map(abs, at.values())) and math.isfinite(after):
        accepted = "a jump to where the guard is above zero is accepted"
        yield Problem(
            f"{place}.jump", dict(each.jump), f"{accepted}: from {at} the guard is {after:.3g} after it"
        )
