"""Assembly of systems of somebody's own equations: their text becomes the structure."""

from __future__ import annotations

import math
from collections.abc import Container
from types import ModuleType
from typing import Any

import numpy as np

from jointplay.display.errors import Problem, raise_any, refuse
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.equations.own.written import Oscillator
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.mechanism.own.own import System
from jointplay.solver.mechanism.own.well_posed import in_one_mode, one_mode

BEYOND = 1e-9  # by how much the state of a body at rest on a wall may be recorded beyond it
TURN = 0.7  # rad of a phase that a step may span: within where the generated polynomials hold
ROUNDS = 8  # of putting a body back on a wall whose gap bends


def model(system: System, initial: Any = None, section: str | None = None) -> Model:
    """Assemble a system.

    Parameters
    ----------
    system : System
        What moves.
    initial : sequence of float, optional
        State at time 0, in the order of `System.order`; the system's own if left out.
    section : str, optional
        State or output whose level is to be watched, or ``phase``.

    Raises
    ------
    InputError
        If start or section do not belong to the system's equations.
    """
    structure = system.structure(section)
    module, numbers = cache.structure_module(structure), system.numbers
    names = (*structure.positions, *structure.speeds)
    expected = f"{len(names)} finite numbers ({', '.join(names)}) are accepted"
    state = finite_numbers(system.initial if initial is None else initial, [len(names)], expected)
    given = _given(module, numbers, state)
    state = standing(structure, given, state)
    given = _given(module, numbers, state)
    if system.modes and not in_one_mode(system.modes, dict(zip(names, state, strict=True))):
        raise refuse(state.tolist(), one_mode(system.modes), "initial")
    _check_gaps(structure, module, given, state)
    state, rates = inside(structure, given, state), _phase_rates(module, given)
    rate = rates.get("phase", 0.0)
    usual = module.SIZES["bends"] * math.tau / system.time_scale  # a guard may bend within
    fastest = max(map(abs, rates.values()), default=usual)
    return Model(
        structure=structure,
        numbers=np.array(list(numbers.values()), dtype=float),
        state=state,
        absolute=np.array([SPEED_FLOOR * system.scales.get(name, 1.0) for name in names]),
        relative=np.ones(len(names)),
        turning=np.zeros(module.SIZES["positions"]),
        fold=np.zeros(module.SIZES["positions"]),
        period=system.time_scale,
        h_max=TURN / fastest if fastest else math.inf,
        creep=SPEED_FLOOR,
        joints=tuple(module.CONTACTS),
        states=(*names, *(name for name, _ in structure.outputs)),
        crank_speed=rate,
        forward=1 if rate >= 0 else -1,
        resets=tuple(module.RESETS),
        modes=system.kept,
    )


def _given(module: ModuleType, numbers: dict[str, float], state: np.ndarray) -> dict[str, float]:
    """Parameters and state by the names that the equations have for them."""
    values = dict(zip(module.PARAMETERS, numbers.values(), strict=True))
    return values | {"t": 0.0} | dict(zip(module.STATE[1:], state, strict=True))


def finite_numbers(initial: Any, counts: Container[int], expected: str) -> np.ndarray:
    """A start as a vector of one of these lengths; refused where it is none of finite numbers."""
    try:
        state = np.array(initial, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise refuse(initial, expected, "initial") from None
    if state.ndim != 1 or len(state) not in counts or not np.all(np.isfinite(state)):
        raise refuse(initial, expected, "initial")
    return state


def _check_gaps(
    structure: Oscillator, module: ModuleType, given: dict[str, float], state: np.ndarray
) -> None:
    """Refuse a start beyond a wall, which lets nothing in, or where a jump should have been."""
    walls = [each.name for each in structure.impacts]
    accepted = {
        True: "a position on the inner side of the {} wall",
        False: "a state with the guard of {} above 0",
    }
    raise_any(
        Problem("initial", state.tolist(), f"{accepted[name in walls].format(name)} is accepted")
        for name, gap in _gaps(module, given).items()
        if gap < -BEYOND
    )


def _gaps(module: ModuleType, given: dict[str, float]) -> dict[str, float]:
    gaps = outputs.evaluate(module, [f"gap:{name}" for name in module.RESETS], given)
    return {name.removeprefix("gap:"): float(gap) for name, gap in gaps.items()}


def standing(structure: Oscillator, numbers: dict[str, float], state: np.ndarray) -> np.ndarray:
    """The state with modes, and switches that remember, as guards say that are below zero there.

    `numbers` are the parameters, by the names that the equations have for them.
    """
    module, names = cache.structure_module(structure), [*structure.positions, *structure.speeds]
    kept = {name for name, rate in zip(structure.speeds, structure.rates, strict=True) if rate == "0"}
    jumps = [
        each
        for each in structure.jumps
        if kept >= {*dict(each.jump)} and {*dict(each.jump).values()} <= {"0", "1"}
    ]
    for _ in jumps:
        given = numbers | {"t": 0.0} | dict(zip(module.STATE[1:], state, strict=True))
        gaps = _gaps(module, given)
        jump = next((each for each in jumps if gaps[each.name] < 0), None)
        if jump is None:
            break
        state = state.copy()
        for name, text in jump.jump:
            state[names.index(name)] = float(text)
    return state


def inside(structure: Oscillator, numbers: dict[str, float], state: np.ndarray) -> np.ndarray:
    """The state, its positions moved back to where a rigid wall stands, if beyond that."""
    module, state = cache.structure_module(structure), state.copy()
    count = module.SIZES["positions"]
    for name in (each.name for each in structure.impacts):
        for _ in range(ROUNDS):
            given = numbers | {"t": 0.0} | dict(zip(module.STATE[1:], state, strict=True))
            here = _gaps(module, given)[name]
            if not here < 0:
                break
            moved = [_gaps(module, given | {q: given[q] + 1.0})[name] for q in module.STATE[1 : 1 + count]]
            slopes = np.array(moved) - here
            if not slopes.any():
                break
            state[:count] -= here * slopes / (slopes @ slopes)
    return state


def _phase_rates(module: ModuleType, given: dict[str, float]) -> dict[str, float]:
    """Angular frequency of each phase; that of the forcing is ``phase``."""
    names = [name for name in module.OUTPUTS if name.startswith("phase")]
    phases = outputs.evaluate(module, names, given | {"t": np.array([0.0, 1.0])})
    return {name: float(phase[1] - phase[0]) for name, phase in phases.items()}
