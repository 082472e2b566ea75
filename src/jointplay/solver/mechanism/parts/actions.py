"""Springs and loads in the equations: their structure, and the numbers that go into it."""

from __future__ import annotations

from typing import Any

from jointplay.solver.equations import structure
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from jointplay.solver.mechanism.parts.loads import Force, Spring, Torque, TorsionSpring

Part = Spring | TorsionSpring | Force | Torque


def springs(mechanism: Any, forest: Forest) -> tuple[structure.Spring, ...]:
    """Give the structure of a mechanism's springs."""
    return tuple(
        structure.Spring(_span(f"spring{i}", spring, forest), spring.links, spring.twists, spring.damping > 0)
        for i, spring in enumerate(mechanism.springs)
    )


def loads(mechanism: Any, forest: Forest) -> tuple[structure.Load, ...]:
    """Give the structure of a mechanism's loads."""
    names = [f"load{i}" for i in range(len(mechanism.loads))]
    return tuple(
        load.structure(name, None if load.twists else _span(name, load, forest))
        for name, load in zip(names, mechanism.loads, strict=True)
    )


def numbers(mechanism: Any, forest: Forest) -> dict[str, float]:
    """Give the parameters of springs and loads by name, SI units."""
    values: dict[str, float] = {}
    for i, spring in enumerate(mechanism.springs):
        own = {"k": spring.stiffness, "c": spring.damping, "rest": spring.rest}
        values |= {f"{word}_spring{i}": value for word, value in own.items()}
        values |= _places(f"spring{i}", spring, forest)
    for i, load in enumerate(mechanism.loads):
        values |= {f"{word}_load{i}": value for word, value in load.numbers.items()}
        values |= load.course_numbers(f"load{i}") | _places(f"load{i}", load, forest)
    return values


def _span(name: str, part: Part, forest: Forest) -> structure.Span:
    vector = forest.vector(*part.pins.values())
    return structure.Span(name, tuple(vector.arms), vector.bases)


def _places(name: str, part: Part, forest: Forest) -> dict[str, float]:
    vector = forest.vector(*part.pins.values())
    x, y = vector.fixed
    return {f"x0_{name}": x, f"y0_{name}": y} | {f"D_{name}_{k}": arm for k, arm in vector.arms.items()}
