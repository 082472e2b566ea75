"""Springs and loads in the equations: their structure, and the numbers that go into it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jointplay.solver.equations import structure
from jointplay.solver.mechanism.loops.kinematic_chains import Forest, place_of
from jointplay.solver.mechanism.parts.joints import Pin
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


def _ends(pins: Mapping[str, Pin], forest: Forest) -> list[tuple[Any, int]]:
    """Places of the pins, and the signs with which the vector between them counts."""
    return [(place_of(forest.places, pin), {"to": -1}.get(key, 1)) for key, pin in pins.items()]


def _span(name: str, part: Part, forest: Forest) -> structure.Span:
    ends = _ends(part.pins, forest)
    chains = [place.chain for place, _ in ends]
    bases = tuple((place.chain, sign) for place, sign in ends if place.chain is not None)
    same = len(chains) == 2 and chains[0] == chains[1]
    return structure.Span(name, tuple(_arms(ends)), () if same else bases)


def _arms(ends: list[tuple[Any, int]]) -> dict[str, float]:
    arms: dict[str, float] = {}
    for place, sign in ends:
        for k, arm in place.arms.items():
            arms[k] = arms.get(k, 0.0) + sign * arm
    return arms


def _places(name: str, part: Part, forest: Forest) -> dict[str, float]:
    ends = _ends(part.pins, forest)
    fixed = {f"{axis}0_{name}": sum(sign * p.fixed[i] for p, sign in ends) for i, axis in enumerate("xy")}
    return fixed | {f"D_{name}_{k}": arm for k, arm in _arms(ends).items()}
