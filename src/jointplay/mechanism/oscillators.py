"""Assembly of test systems: their generated equations name the states, parameters and walls."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np

from jointplay.codegen import cache, outputs
from jointplay.equations.structure import Oscillator
from jointplay.errors import NOTHING, InputError, Problem, refuse, unknown
from jointplay.mechanism.model import SPEED_FLOOR, Model
from jointplay.mechanism.records import TestSystem

PLAY = 1e-9  # by how much the state of a body at rest on a wall may be recorded beyond it
TURN = 0.7  # rad of the forcing's phase that a step may span: within where the generated polynomials hold


def model(system: TestSystem, initial: Any = None, section: str | None = None) -> Model:
    """Assemble a test system.

    Parameters
    ----------
    system : TestSystem
        What moves.
    initial : sequence of float, optional
        State at time 0; the system's own if left out.
    section : str, optional
        State whose level is to be watched, or ``phase``.

    Raises
    ------
    InputError
        If parameters, start or section do not belong to the system's equations.
    """
    switches = {name: value for name, value in system.parameters.items() if isinstance(value, bool)}
    structure = Oscillator(system.system, tuple(sorted(switches.items())), section)
    module = cache.structure_module(structure)
    numbers = _numbers({k: v for k, v in system.parameters.items() if k not in switches}, module)
    states = tuple(module.STATE[1:])
    state = _state(system.initial if initial is None else initial, states)
    _check_gaps(module, numbers | {"t": 0.0} | dict(zip(states, state, strict=True)))
    state, rate = inside(module, numbers, state), _phase_rate(module, numbers)
    return Model(
        structure=structure,
        numbers=np.array(list(numbers.values()), dtype=float),
        state=state,
        absolute=np.full(len(states), SPEED_FLOOR),
        relative=np.ones(len(states)),
        turning=np.zeros(module.SIZES["positions"]),
        fold=np.zeros(module.SIZES["positions"]),
        period=system.period or 1.0,
        h_max=TURN / abs(rate) if rate else math.inf,
        creep=SPEED_FLOOR,
        joints=tuple(module.CONTACTS),
        states=states,
        crank_speed=rate,
        forward=1 if rate >= 0 else -1,
        resets=tuple(module.RESETS),
    )


def _numbers(given: dict[str, float], module: ModuleType) -> dict[str, float]:
    """The parameters in the order of the equations."""
    names = module.PARAMETERS
    extra = {name: value for name, value in given.items() if name not in names}
    problems = [unknown(f"parameters.{k}", value, k, names, "parameter") for k, value in extra.items()]
    problems += [Problem(f"parameters.{k}", NOTHING, "a number is needed") for k in names if k not in given]
    if problems:
        raise InputError(problems)
    return {name: given[name] for name in names}


def _state(initial: Any, names: tuple[str, ...]) -> np.ndarray:
    expected = f"{len(names)} finite numbers ({', '.join(names)}) are accepted"
    try:
        state = np.array(initial, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise refuse(initial, expected, "initial") from None
    if state.shape != (len(names),) or not np.all(np.isfinite(state)):
        raise refuse(initial, expected, "initial")
    return state


def _check_gaps(module: ModuleType, given: dict[str, float]) -> None:
    """Refuse a start beyond a wall: walls with restitution let nothing in."""
    problems = [
        Problem("initial", given["y"], f"a position on the inner side of the {name} wall is accepted")
        for name, gap in _gaps(module, given).items()
        if gap < -PLAY
    ]
    if problems:
        raise InputError(problems)


def _gaps(module: ModuleType, given: dict[str, float]) -> dict[str, float]:
    gaps = outputs.evaluate(module, [f"gap:{name}" for name in module.RESETS], given)
    return {name.removeprefix("gap:"): float(gap) for name, gap in gaps.items()}


def inside(module: ModuleType, numbers: dict[str, float], state: np.ndarray) -> np.ndarray:
    """The state, its position moved back to where a rigid wall stands at time 0, if beyond that."""
    state = state.copy()
    for name in module.RESETS:
        given = numbers | {"t": 0.0} | dict(zip(module.STATE[1:], state, strict=True))
        here, there = (_gaps(module, given | {"y": given["y"] + shift})[name] for shift in (0.0, 1.0))
        if here < 0:
            state[0] -= here / (there - here)  # gaps are linear in the position
    return state


def _phase_rate(module: ModuleType, numbers: dict[str, float]) -> float:
    """Angular frequency of the forcing; 0 where there is none."""
    if "phase" not in module.OUTPUTS:
        return 0.0
    phase = outputs.evaluate(module, ["phase"], numbers | {"t": np.array([0.0, 1.0])})["phase"]
    return float(phase[1] - phase[0])
