"""Modes of a system of somebody's own equations, in one of which it is at a time, and the ways between them.

Each mode is a state, 1 in the mode and 0 in the others, that nothing changes but jumps: the way from mode m
to n is a jump where m g + 1 - m falls through zero, g being its guard. So a state of the motion says in which
mode it is, wherever that is continued, and saltation at a change of modes is that of a jump.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from jointplay.solver.equations.own.grammar import parse
from jointplay.solver.mechanism.own.own_parts import Exit, Jump

Modes = Mapping[str, tuple[Exit, ...]]


def flat(modes: Modes, states: Mapping[str, str], rates: Mapping[str, str], masked: bool) -> dict[str, Any]:
    """States and rates with those of modes, and the jumps that are their ways; `masked`: with g as above."""
    begun = {mode: text for mode, text in states.items() if mode in modes} or {next(iter(modes)): "1"}
    own = {name: text for name, text in states.items() if name not in modes}
    return {
        "modes": {},
        "states": own | {mode: begun.get(mode, "0") for mode in modes},
        "rates": {name: _moving(text, modes) for name, text in rates.items()} | dict.fromkeys(modes, "0"),
        "jumps": tuple(_jumps(modes, masked)),
    }


def _moving(rate: str, modes: Modes) -> str:
    """A rate as it stands; of a mode's bare name a product, since a mode is no position's speed."""
    return f"1*{rate}" if parse(rate).value in modes else rate


def _jumps(modes: Modes, masked: bool) -> Iterator[Jump]:
    for mode, exits in modes.items():
        for i, each in enumerate(exits):
            again = sum(other.to == each.to for other in exits[:i])
            name = f"{mode}_{each.to}" + (f"_{again + 1}" if again else "")
            guard = f"{mode}*({each.guard}) + 1 - {mode}" if masked else each.guard
            target = {each.to: "1"} if each.to in modes else {}
            yield Jump(name=name, guard=guard, jump={**each.jump, mode: "0", **target})


def in_one_mode(modes: Collection[str], state: Mapping[str, float]) -> bool:
    """Whether one mode of a state is 1, and the others are 0."""
    return sorted(state[mode] for mode in modes) == [0.0] * (len(modes) - 1) + [1.0]


def one_mode(modes: Collection[str]) -> str:
    """What is accepted of a start."""
    return f"a start in one mode is accepted: one of {', '.join(modes)} is 1, the others are 0"
