"""Modes of a system of somebody's own equations, in one of which it is at a time, and the ways between them.

Each mode is a state, 1 in the mode and 0 in the others, that nothing changes but jumps: the way from mode m
to n is a jump where m g + 1 - m falls through zero, g being its guard. So a state of the motion says in which
mode it is, wherever that is continued, and saltation at a change of modes is that of a jump.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from jointplay.equations.grammar import number
from jointplay.errors import InputError, Problem, unknown
from jointplay.mechanism.own_parts import Exit, Jump

if TYPE_CHECKING:
    from jointplay.mechanism.own import System


def flat(system: System, masked: bool = True) -> System:
    """The system with states and jumps in the place of modes; `masked` False: guards as they were given."""
    modes, changes = system.modes, [*system.jumps]
    for name, mode, each in ways(system):
        guard = f"{mode}*({each.guard}) + 1 - {mode}" if masked else each.guard
        target = {each.to: "1"} if each.to in modes else {}
        changes.append(Jump(name=name, guard=guard, jump={**each.jump, mode: "0", **target}))
    given = {mode: text for mode, text in system.states.items() if mode in modes}
    begun = given or {next(iter(modes)): "1"}
    states = {name: text for name, text in system.states.items() if name not in modes}
    update = {
        "modes": {},
        "states": states | {mode: begun.get(mode, "0") for mode in modes},
        "rates": {**system.rates, **dict.fromkeys(modes, "0")},
        "jumps": tuple(changes),
    }
    return system.model_copy(update=update)


def ways(system: System) -> Iterator[tuple[str, str, Exit]]:
    """Every way: a name for it, the mode that it leaves, and itself."""
    for mode, exits in system.modes.items():
        for i, each in enumerate(exits):
            again = sum(other.to == each.to for other in exits[:i])
            yield f"{mode}_{each.to}" + (f"_{again + 1}" if again else ""), mode, each


def in_one_mode(modes: Mapping[str, object], state: Mapping[str, float]) -> bool:
    """Whether one mode of a state is 1, and the others are 0."""
    return sorted(state[mode] for mode in modes) == [0.0] * (len(modes) - 1) + [1.0]


def one_mode(modes: Mapping[str, object]) -> str:
    """What is accepted of a start."""
    return f"a start in one mode is accepted: one of {', '.join(modes)} is 1, the others are 0"


def problems(system: System) -> Iterator[Problem]:
    """Modes without a way out or in, ways that lead nowhere, names of two things, a start in no mode."""
    modes = system.modes
    for mode, exits in modes.items():
        if mode in system.rates:
            yield Problem(f"modes.{mode}", mode, "another name is accepted: this one is a state already")
        if not exits:
            yield Problem(f"modes.{mode}", [], "a mode with at least one way out is accepted")
        for i, each in enumerate(exits):
            key = f"modes.{mode}[{i}]"
            if each.to not in modes:
                yield unknown(f"{key}.to", each.to, each.to, modes, "mode")
            elif each.to == mode and not each.jump:
                yield Problem(f"{key}.to", mode, "another mode is accepted, or a jump beside it")
    jumps = {f"jumps[{i}].jump": each.jump for i, each in enumerate(system.jumps)}
    jumps |= {f"modes.{m}[{i}].jump": each.jump for m, ways in modes.items() for i, each in enumerate(ways)}
    for key, jump in jumps.items():
        for mode in jump.keys() & modes.keys():
            accepted = "no mode is accepted: the way to it says which mode follows"
            yield Problem(f"{key}.{mode}", jump[mode], accepted)
    found = flat(system).states
    try:
        state = {mode: number(found[mode], system.numbers) for mode in modes}
    except InputError as error:
        yield from error.under("states").problems
        return
    if not in_one_mode(modes, state):
        yield Problem("states", state, one_mode(modes))
        return
    reached = {mode for mode in modes if state[mode]}
    while more := {way.to for m in reached for way in modes[m]} & modes.keys() - reached:
        reached |= more
    for mode in modes.keys() - reached:
        yield Problem(f"modes.{mode}", mode, "a mode that some way leads to is accepted: none does")


def under_modes(system: System, problem: Problem) -> Problem:
    """A problem of the flat system, with the key that its modes are given by."""
    key, own = problem.key, len(system.jumps)
    places = [f"modes.{mode}[{i}]" for mode, exits in system.modes.items() for i in range(len(exits))]
    if (found := re.match(r"jumps\[(\d+)\](\.name$)?", key)) and int(found[1]) >= own:
        key = places[int(found[1]) - own] + key[found.end() :]
    elif key in {f"states.{mode}" for mode in system.modes}:
        key = key.replace("states", "modes")
    return replace(problem, key=key)
