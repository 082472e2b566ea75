"""Tables that describe a system of somebody's own equations, and the consequences of their form.

A system with modes is in one of them at a time. Each mode is a state, 1 in the mode and 0 in the others, that
nothing changes but jumps: the way from mode m to n is a jump where m g + 1 - m falls through zero, g being
its guard. So a state of the motion says in which mode it is, wherever that is continued, and saltation at a
change of modes is that of a jump.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any, Self

from pydantic import Field, model_validator

from jointplay.display.errors import InputError, join, raise_any
from jointplay.solver.equations.own import written
from jointplay.solver.equations.own.grammar import number, parse
from jointplay.solver.mechanism.base import Few, Flag, Name, Number, Positive, Record
from jointplay.solver.mechanism.measures import coherent
from jointplay.solver.mechanism.own.own_parts import Exit, Impact, Jump, Rubbing, Switch, Text, Touch

_VALUE = {
    "accepts": "a table of finite numbers, with their units as '0.3 mm', or true and false for switches,"
}
Modes = Mapping[str, tuple[Exit, ...]]


class Equations(Record):
    """Equations as text with the values of their parameters; fields as of `mechanism.own.own.System`."""

    name: Name = Field(default="system", description="name", json_schema_extra={"noun": True})
    states: dict[Name, Text] = Field(json_schema_extra={"accepts": "a table of initial values"})
    parameters: dict[Name, Flag | Number] = Field(default={}, json_schema_extra=_VALUE)
    rates: dict[Name, Text]
    mass: dict[Name, dict[Name, Text]] = Field(default={})
    forcing: Text | None = None
    contacts: Few[Touch] = ()
    friction: Few[Rubbing] = ()
    switches: Few[Switch] = ()
    modes: dict[Name, Few[Exit]] = Field(default={}, json_schema_extra={"accepts": "a table of modes"})
    impacts: Few[Impact] = ()
    jumps: Few[Jump] = ()
    outputs: dict[Name, Text] = Field(default={})
    units: dict[Name, str] = Field(default={})
    scales: dict[Name, Positive] = Field(default={})
    system: Name | None = None
    as_meant: Flag = False

    @model_validator(mode="before")
    @classmethod
    def _values_with_units(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        found, problems, units = dict(data), [], {}
        for table in ("states", "parameters"):
            values = data.get(table)
            for key, value in values.items() if isinstance(values, Mapping) else ():
                try:
                    value, unit = coherent(value)
                except InputError as error:
                    problems += error.under(join(table, str(key))).problems
                    continue
                if unit:
                    units[key] = unit
                    found[table] = {**found[table], key: value}
        raise_any(problems)
        own = data.get("units", {})
        return found | ({"units": units | dict(own)} if units and isinstance(own, Mapping) else {})

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        known, names = (
            each if isinstance(each, Mapping) else {} for each in map(data.get, ("units", "scales"))
        )
        return {"scales": {name: "s" if name == "t" else known.get(name, "1") for name in names}}

    @property
    def flags(self) -> dict[str, bool]:
        """Parameters that are true or false."""
        return {key: value for key, value in self.parameters.items() if isinstance(value, bool)}

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters that are numbers."""
        return {key: float(value) for key, value in self.parameters.items() if not isinstance(value, bool)}

    def flat(self, masked: bool = True) -> Self:
        """The system with states and jumps in the place of modes; `masked` False: with guards as given."""
        if not self.modes:
            return self
        tables = flat(self.modes, self.states, self.rates, masked)
        return self.model_copy(update=tables | {"jumps": self.jumps + tables["jumps"]})

    @property
    def order(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Positions, and speeds, the first of them theirs: states as results and lists have them."""
        flat = self.flat()
        moved, found = {state for each in flat.jumps for state in each.jump}, {}
        for state in flat.states:
            tree = parse(flat.rates[state])
            free = tree.value not in {state, *found, *found.values()} and state not in found.values()
            if tree.operation == "name" and tree.value in flat.states and free and state not in moved:
                found[state] = tree.value
        positions, speeds = tuple(found), tuple(found.values())
        return positions, (*speeds, *(s for s in flat.states if s not in positions + speeds))

    @property
    def time_scale(self) -> float:
        """Period of the forcing; without one the scale of time, 1 s if none is given."""
        return self.period or self.scales.get("t", 1.0)

    @property
    def observed(self) -> tuple[str, ...]:
        """Names of states and outputs, as results have them."""
        return (*(name for names in self.order for name in names), *self.outputs)

    @property
    def initial(self) -> tuple[float, ...]:
        """State at time 0, in `order`."""
        states = self.flat().states
        return tuple(number(states[name], self.numbers) for names in self.order for name in names)

    @property
    def period(self) -> float | None:
        """Period of the forcing, which a negative one goes through backwards; None if there is none."""
        return None if self.forcing is None else abs(number(self.forcing, self.numbers))

    def structure(self, section: str | None = None) -> written.Oscillator:
        """The equations without their numbers."""
        (positions, speeds), flags, flat = self.order, self.flags, self.flat()
        free = [name for name in speeds if name not in self.mass] if self.mass else ()
        mass = {name: {name: "1"} for name in free} | self.mass
        entries = (
            (speeds.index(a), speeds.index(b), text) for a, row in mass.items() for b, text in row.items()
        )
        return written.Oscillator(
            positions=positions,
            speeds=speeds,
            parameters=tuple(self.numbers),
            rates=tuple(flat.rates[name] for name in speeds),
            mass=tuple((max(i, j), min(i, j), text) for i, j, text in entries),
            period=self.forcing or "",
            contacts=tuple(
                written.Touch(each.name, each.depth, each.force, flags.get(each.tension, each.tension))
                for each in self.contacts
            ),
            friction=tuple(
                written.Rubbing(each.name, each.speed, each.normal, each.coefficient, each.static or "")
                for each in self.friction
            ),
            switches=tuple(
                written.Switch(each.name, each.on, each.off or "", each.slides) for each in self.switches
            ),
            impacts=tuple(
                written.Wall(each.name, each.gap, each.restitution or "", tuple(each.jump.items()))
                for each in self.impacts
            ),
            jumps=tuple(
                written.Trigger(each.name, each.guard, tuple(each.jump.items())) for each in flat.jumps
            ),
            outputs=tuple(self.outputs.items()),
            section=section,
        )


def flat(modes: Modes, states: Mapping[str, str], rates: Mapping[str, str], masked: bool) -> dict[str, Any]:
    """States and rates with the modes', and jumps between modes; `masked`: guards act in their mode alone."""
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
    """Message on the accepted starts: in one mode."""
    return f"a start in one mode is accepted: one of {', '.join(modes)} is 1, the others are 0"
