"""Whether a system of somebody's own equations can be followed: every problem, its place and its reason.

Among these: whether it has numbers at its start, and where its jumps lead from near there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from jointplay.display.errors import NOTHING, InputError, Problem, join, problems_of, strangers, unknown
from jointplay.solver.equations.own.grammar import (
    CONSTANTS,
    FUNCTIONS,
    ZERO,
    Tree,
    flat,
    is_name,
    number,
    parse,
    plainly_real,
    size,
    too_large,
)

System = Any  # one of `own.own`, whose record asks here
PARTS = ("contacts", "friction", "switches", "impacts", "jumps")
IN_LAWS = {"force": ("depth", "speed"), "coefficient": ("speed",), "static": ()}  # names that parts give
NAMED = "a name of letters a to z, digits and _ is accepted, a letter first"
GUARDS = ("on", "off", "depth", "speed", "gap", "guard")  # of events, whose slopes have slopes
KINKED, KINKS = {"abs", "sign", "max", "min"}, 50
MOST = 1000  # systems whose equations are remembered to be right
_right: set[str] = set()
EVEN = 1e-9  # relative difference of rates a period apart, beyond which they do not repeat
NUDGE = 1e-6


def problems(system: System) -> list[Problem]:
    """Everything that is wrong with a system whose tables have the right form."""
    others = {"name", "parameters", "states", "system", "as_meant"}
    parts = system.flags, [*system.parameters], system.states, system.model_dump_json(exclude=others)
    equations = repr(parts)
    found = [*_of_modes(system)] if system.modes else []
    for i, each in enumerate(system.switches):
        if each.name in system.rates:
            found.append(
                Problem(f"switches[{i}].name", each.name, "another name is accepted: this one is a state's")
            )
    if found or equations not in _right:  # else it differs by numbers alone, as the cells of a sweep do
        flat = system.flat(masked=False)
        found += [_under_modes(system, each) for each in _of_the_equations(flat)]
        if found:
            return found
        if len(_right) == MOST:
            _right.clear()
        _right.add(equations)
    return [*values(system)] or [*at_the_start(system)]


def _of_modes(system: System) -> Iterator[Problem]:
    """Modes without a way out or in, jumps that lead nowhere, names of two things, a start in no mode."""
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
    jumps |= {f"modes.{m}[{i}].jump": each.jump for m, exits in modes.items() for i, each in enumerate(exits)}
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
    while more := {transition.to for m in reached for transition in modes[m]} & modes.keys() - reached:
        reached |= more
    for mode in modes.keys() - reached:
        yield Problem(
            f"modes.{mode}", mode, "a mode to which some way leads is accepted: none leads to this one"
        )


def in_one_mode(modes: Collection[str], state: Mapping[str, float]) -> bool:
    """Whether one mode of a state is 1, and the others are 0."""
    return sorted(state[mode] for mode in modes) == [0.0] * (len(modes) - 1) + [1.0]


def one_mode(modes: Collection[str]) -> str:
    """Message on the accepted starts: in one mode."""
    return f"a start in one mode is accepted: one of {', '.join(modes)} is 1, the others are 0"


def _under_modes(system: System, problem: Problem) -> Problem:
    """A problem of the flat system, with the key that its modes and switches are given by."""
    key, own = problem.key, len(system.jumps)
    latches = [i for i, each in enumerate(system.switches) if each in system.latches]
    others = [i for i in range(len(system.switches)) if i not in latches]
    places = [f"modes.{mode}[{i}]" for mode, exits in system.modes.items() for i in range(len(exits))]
    if found := re.match(r"switches\[(\d+)\]", key):
        key = f"switches[{others[int(found[1])]}]{key[found.end() :]}"
    elif (found := re.match(r"jumps\[(\d+)\](\.name$)?", key)) and int(found[1]) >= own:
        at = int(found[1]) - own
        which, threshold = divmod(at - len(places), 2)
        key = (
            f"switches[{latches[which]}].{('on', 'off')[threshold]}"
            if which >= 0
            else places[at] + key[found.end() :]
        )
    elif key in {f"states.{mode}" for mode in system.modes}:
        key = key.replace("states", "modes")
    return replace(problem, key=key)


def _of_the_equations(system: System) -> list[Problem]:
    """Problems of the equations at any values of the parameters."""
    found = [*_names(system), *_missing(system)]
    texts, switches = [] if found else [*_texts(system)], {each.name for each in system.switches}
    for key, text, known in texts:
        found += wrong_text(key, text, known, switches)
    if not found:
        found += _kinks(texts)
    return found or [*_forced(system, texts), *_parts(system)] or [*_sliding(system)]


def _names(system: System) -> Iterator[Problem]:
    """Names that cannot be, or are given twice."""
    taken = {
        "t": "the time",
        **dict.fromkeys(CONSTANTS, "a number"),
        **dict.fromkeys(FUNCTIONS, "a function"),
    }
    taken |= {"depth": "a contact's", "speed": "a contact's"} if system.contacts or system.friction else {}
    tables = {"states": "a state", "parameters": "a parameter", "outputs": "an output"}
    places = [
        (join(table, name), name, what) for table, what in tables.items() for name in getattr(system, table)
    ]
    places += [(f"switches[{i}].name", switch.name, "a switch") for i, switch in enumerate(system.switches)]
    for key, name, what in places:
        if not is_name(name):
            yield Problem(key, name, NAMED)
        elif name in taken:
            yield Problem(key, name, f"another name is accepted: this one is {taken[name]} already")
        taken[name] = what
    parts: dict[str, str] = {"phase": "the forcing"}
    for table in PARTS:
        for i, part in enumerate(getattr(system, table)):
            key = f"{table}[{i}].name"
            if not is_name(part.name):
                yield Problem(key, part.name, NAMED)
            elif part.name in parts:
                yield Problem(key, part.name, f"another name is accepted: this one is {parts[part.name]}'s")
            parts[part.name] = f"{table}[{i}]"


def _missing(system: System) -> Iterator[Problem]:
    """States without a rate, and entries of tables that are of no state."""
    if not system.states:
        yield Problem("states", {}, "at least one state is needed")
    for name in system.states.keys() - system.rates.keys():
        yield Problem(f"rates.{name}", NOTHING, "the rate of this state is needed")
    tables: dict[str, Any] = {"rates": system.states, "mass": system.states}
    tables |= {"scales": {**system.states, "t": 0}, "units": {**system.states, **system.parameters}}
    for table, known in tables.items():
        named = ((join(table, name), name) for name in getattr(system, table))
        yield from strangers(named, known, "state" if table != "units" else "name")


def _texts(system: System) -> Iterator[tuple[str, str, Collection[str]]]:
    """Key, text and known names of every expression."""
    numbers, flags = system.numbers, system.flags
    moving = {*system.states, *numbers, "t"}
    modes = moving | {each.name for each in system.switches}
    located = modes - {each.name for each in system.switches if each.slides}
    for name, text in system.states.items():
        yield f"states.{name}", text, numbers
    if system.forcing is not None:
        yield "forcing", system.forcing, numbers
    for table in ("rates", "outputs"):
        for name, text in getattr(system, table).items():
            yield f"{table}.{name}", text, modes
    for name, row in system.mass.items():
        for other, text in row.items():
            yield f"mass.{name}.{other}", text, moving
    for table in PARTS:
        for i, part in enumerate(getattr(system, table)):
            for key, value in part:
                place, known = f"{table}[{i}].{key}", moving if table in ("impacts", "jumps") else located
                if key == "tension" and isinstance(value, str) and value not in flags:
                    yield place, value, flags
                elif key == "jump":
                    yield from ((f"{place}.{state}", text, known) for state, text in value.items())
                elif key not in ("name", "tension", "slides") and value is not None:
                    yield place, value, {*known, *IN_LAWS.get(key, ())}


def wrong_text(
    key: str, text: str, known: Collection[str], switches: Collection[str] = (), kinks: bool = True
) -> Iterator[Problem]:
    """Yield the problems of an expression of known names, some of switches; whether it may have `kinks`."""
    try:
        tree = parse(text)
    except InputError as error:
        yield from error.under(key).problems
        return
    for name in sorted(tree.names - {*known}):
        yield unknown(key, text, name, sorted(known), f"name as {name!r}")
    for kinked in sorted(_operations(tree) & KINKED) if not kinks else ():
        yield Problem(key, text, f"an expression without kinks is accepted, and {kinked} has one")
    part, _, last = key.rpartition(".")
    tells = part.endswith("]") and last in GUARDS
    if large := too_large(text, bends=tells):
        yield Problem(key, text, large)
    elif (tells or size(text).kinks) and flat(text, tells, switches):
        yield Problem(key, text, ZERO)
    elif not plainly_real(tree):
        from jointplay.solver.equations.own.own import checked

        try:
            checked(text, kinks)
        except InputError as error:
            yield from error.under(key).problems


def _operations(tree: Tree) -> set[str]:
    return {tree.operation}.union(*map(_operations, tree.parts))


def _kinks(texts: list[tuple[str, str, Any]]) -> Iterator[Problem]:
    """The expression with which kinks, each of them an event, are more than can be watched."""
    count = 0
    for key, text, _ in texts:
        count += size(text).kinks
        if count > KINKS:
            accepted = f"at most {KINKS} kinks (abs, sign, max, min) are accepted in all expressions together"
            yield Problem(key, text, accepted)
            return


def _forced(system: System, texts: list[tuple[str, str, Any]]) -> Iterator[Problem]:
    """Problems of terms that vary with time without a period, or of a period without such terms."""
    timed = [(key, text) for key, text, _ in texts if "t" in names_in(text)]
    if timed and system.forcing is None:
        key, text = timed[0]
        yield Problem("forcing", NOTHING, f"the period is needed, since {key} depends on t ({text})")
    if not timed and system.forcing is not None:
        yield Problem("forcing", system.forcing, "nothing is accepted: no equation depends on t")


def _parts(system: System) -> Iterator[Problem]:
    """Problems of guards that no motion can change, and of jumps of states that cannot jump."""
    positions, speeds = system.order
    moving = {*positions, *speeds, "t"}
    for i, each in enumerate(system.switches):
        guards = {"on": each.on} | ({"off": each.off} if each.off is not None else {})
        for key, text in guards.items():
            yield from _fixed(f"switches[{i}].{key}", text, moving, "a state or on t")
        if each.slides and each.off is not None:
            yield Problem(f"switches[{i}].off", each.off, "nothing is accepted beside slides")
        if each.slides:
            yield from _fixed(f"switches[{i}].on", each.on, speeds, f"one of {', '.join(speeds)}")
    for i, each in enumerate(system.contacts):
        yield from _fixed(f"contacts[{i}].depth", each.depth, positions, _of(positions))
    for i, each in enumerate(system.friction):
        yield from _fixed(f"friction[{i}].speed", each.speed, speeds, f"one of {', '.join(speeds)}")
    for i, each in enumerate(system.impacts):
        place = f"impacts[{i}]"
        yield from _fixed(f"{place}.gap", each.gap, positions, _of(positions))
        if wrong := names_in(each.gap) & {*speeds}:
            accepted = f"a gap of positions alone is accepted ({', '.join(positions) or 'there is none'})"
            yield Problem(f"{place}.gap", each.gap, f"{accepted}, not of {', '.join(sorted(wrong))}")
        if (each.restitution is None) == (not each.jump):
            yield Problem(place, each.name, "either restitution or jump is needed, and not both")
        yield from _unjumping(f"{place}.jump", each.jump, speeds, "a speed")
    for i, each in enumerate(system.jumps):
        yield from _fixed(f"jumps[{i}].guard", each.guard, moving, "a state or on t")
        yield from _unjumping(f"jumps[{i}].jump", each.jump, system.states, "state")
        if not each.jump:
            yield Problem(f"jumps[{i}].jump", {}, "a table of new values of at least one state is accepted")
    for name, row in system.mass.items():
        own = ((f"mass.{name}", key) for key in (name, *row))
        yield from strangers(own, speeds, "state that is no position")
        for key in row.keys() & {*system.mass} - {name}:
            if name in system.mass[key]:
                accepted = f"this entry stands in mass.{key}.{name} too: one of them is accepted"
                yield Problem(f"mass.{name}.{key}", row[key], accepted)


def _sliding(system: System) -> Iterator[Problem]:
    """Problems of switches that slide, which only the written equations show."""
    if any(each.slides for each in system.switches):
        from jointplay.solver.equations.own.own import system as equations

        yield from problems_of(lambda: equations(system.structure()))


def _of(positions: Collection[str]) -> str:
    return (
        f"a position ({', '.join(positions)})"
        if positions
        else "a position, a state whose rate is another state,"
    )


def _fixed(key: str, text: str, moving: Collection[str], what: str) -> Iterator[Problem]:
    if not names_in(text) & {*moving}:
        yield Problem(key, text, f"an expression that depends on {what} is accepted: this one does not")


def _unjumping(key: str, jump: Mapping[str, str], known: Collection[str], what: str) -> Iterator[Problem]:
    return strangers(((join(key, name), name) for name in jump), known, what)


@lru_cache(maxsize=1000)
def names_in(text: str) -> frozenset[str]:
    """Names in an expression."""
    return frozenset(parse(text).names)


def values(system: System) -> Iterator[Problem]:
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

    def __init__(self, system: System) -> None:
        names = [name for group in system.order for name in group]
        self.names = dict(zip(names, system.initial, strict=True))
        self.names |= {each.name: 0.0 for each in system.switches} | self.names | {**system.numbers, "t": 0.0}
        for i, each in enumerate(system.switches):
            try:
                if each not in system.latches:
                    self.names[each.name] = float(self(each.on) > 0)
            except InputError as error:
                raise error.under(f"switches[{i}].on") from None

    def __call__(self, text: str, **changed: float) -> float:
        return number(text, self.names | changed)


def at_the_start(system: System) -> Iterator[Problem]:
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
            yield from _comes_back(place, each, here, sum(system.order, ()))
    except InputError:
        return  # it has no number at the start alone


def _singular(system: System, here: _Here) -> Iterator[Problem]:
    if not system.mass:
        return
    given = system.structure()
    matrix = np.zeros((len(given.speeds),) * 2)
    for i, j, text in given.mass:
        matrix[i, j] = matrix[j, i] = here(text)
    values = np.linalg.eigvalsh(matrix)
    if not values[0] > 1e-12 * max(abs(values[-1]), 1e-300):
        accepted = f"a positive definite matrix is accepted; its least eigenvalue is {values[0]:.3g}"
        yield Problem("mass", system.mass, accepted)


def _restitution(key: str, text: str | None, here: _Here) -> Iterator[Problem]:
    if text is not None and not 0 <= (value := here(text)) <= 1:
        yield Problem(key, text, f"a restitution of 0 to 1 is accepted, not {value:g}")


def _comes_back(place: str, each: Any, here: _Here, order: Collection[str]) -> Iterator[Problem]:
    """Problem of a jump that ends on its guard or beyond, from where the guard is zero near the start."""
    states = [name for name in order if name in names_in(each.guard)]
    if not states:
        accepted = "a guard is accepted that the jump leads away from 0, by a state in it; one of time alone "
        accepted += "leads from one of two `modes` to the other, and another one back"
        yield Problem(f"{place}.guard", each.guard, accepted)
        return

    def slope(name: str) -> float:
        up, down = (here(each.guard, **at | {name: at[name] + step}) for step in (NUDGE, -NUDGE))
        return (up - down) / (2 * NUDGE)

    at = {name: here.names[name] for name in states}
    for _ in range(50):  # Newton's method, down the guard's slope
        value = here(each.guard, **at)
        slopes = np.array(list(map(slope, states)))
        if not slopes.any() or abs(value) < 1e-12:
            break
        at = {
            n: float(x - value * s / (slopes @ slopes)) for (n, x), s in zip(at.items(), slopes, strict=True)
        }
    if not abs(value) < 1e-9:
        return
    new = {name: here(text, **at) for name, text in each.jump.items()}
    after = here(each.guard, **at | new)
    if not after > 1e-9 * max(1.0, *map(abs, at.values())) and math.isfinite(after):
        accepted = "a jump to where the guard is above zero is accepted"
        yield Problem(
            f"{place}.jump", dict(each.jump), f"{accepted}: from {at} the guard is {after:.3g} after it"
        )
