"""Whether modes of a system of somebody's own equations lead to each other, and a start is in one of them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from jointplay.equations.grammar import number
from jointplay.errors import InputError, Problem, unknown
from jointplay.mechanism.own_equations import Equations
from jointplay.mechanism.own_modes import in_one_mode, one_mode


def problems(system: Equations) -> Iterator[Problem]:
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
    found = system.flat().states
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


def under_modes(system: Equations, problem: Problem) -> Problem:
    """A problem of the flat system, with the key that its modes are given by."""
    key, own = problem.key, len(system.jumps)
    places = [f"modes.{mode}[{i}]" for mode, exits in system.modes.items() for i in range(len(exits))]
    if (found := re.match(r"jumps\[(\d+)\](\.name$)?", key)) and int(found[1]) >= own:
        key = places[int(found[1]) - own] + key[found.end() :]
    elif key in {f"states.{mode}" for mode in system.modes}:
        key = key.replace("states", "modes")
    return replace(problem, key=key)
