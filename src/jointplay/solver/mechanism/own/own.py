"""Systems of somebody's own equations: their record, as text with the values of parameters.

Test systems of the catalog are such systems.

A system with modes is in one of them at a time. Each mode is a state, 1 in the mode and 0 in the others, that
nothing changes but jumps: the way from mode m to n is a jump where m g + 1 - m falls through zero, g being
its guard. So a state of the motion says in which mode it is, wherever that is continued, and saltation at a
change of modes is that of a jump. A switch s with two thresholds, which remembers, is such a state too: it
jumps to 1 where s - (1 - s) g falls through zero, g being its `on`, and to 0 where 1 - s - s h does, h its
`off`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any, Self, TypeVar

from pydantic import Field, model_validator

from jointplay.display.errors import InputError, join, raise_any, refuse, strangers, unknown
from jointplay.display.number_text import plain
from jointplay.solver.equations.own import written
from jointplay.solver.equations.own.grammar import number, parse
from jointplay.solver.extensions import Table
from jointplay.solver.mechanism.base import Few, Flag, Name, Number, Positive, Record
from jointplay.solver.mechanism.measures import coherent, in_si
from jointplay.solver.mechanism.own.own_parts import Exit, Impact, Jump, Rubbing, Switch, Text, Touch
from jointplay.solver.mechanism.own.well_posed import problems
from jointplay.solver.mechanism.paths import one_by_one
from jointplay.solver.mechanism.signature import Preset, checked

_VALUE = {
    "accepts": "a table of finite numbers, with their units as '0.3 mm', or true and false for switches,"
}
Modes = Mapping[str, tuple[Exit, ...]]
T = TypeVar("T")


class System(Record):
    """A system of somebody's own equations.

    Parameters
    ----------
    name : str
        Name, for titles.
    states : dict of str to str
        Their values at time 0: numbers, or expressions of parameters.
    parameters : dict of str to float
        By name; those that are true or false are switches of the structure.
    rates : dict of str to str
        Rate of each state; with a mass matrix, the force that it balances.
    mass : dict of str to dict of str to str
        Entries of a mass matrix of states that are no positions; the unit matrix where not named.
    forcing : str, optional
        Period of what depends on the time ``t``.
    contacts : tuple of Touch
        Compliant contacts.
    friction : tuple of Rubbing
        Dry friction.
    switches : tuple of Switch
        Numbers 0 or 1 in the equations, by the sign of a guard.
    modes : dict of str to tuple of Exit
        Modes, of which the system is in one at a time, with the ways out of each; the first one at time 0.
        Each is a state too: 1 in the mode, else 0.
    impacts : tuple of Impact
        Rigid walls.
    jumps : tuple of Jump
        Jumps of the state.
    outputs : dict of str to str
        Quantities to be recorded beside the states.
    units : dict of str to str
        Units of parameters and states; 1 where none is stated.
    scales : dict of str to float
        Size of a state beside which its error counts as absolute, and a time in which something happens,
        ``t``, where nothing forces; 1 where not stated.
    system : str, optional
        Of an entry of the catalog its name there.
    as_meant : bool
        Whether it is as meant, however strange: nothing is doubted.
    """

    __test__ = False  # of a name that begins with Test, and pytest would collect it

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
        """The system with states and jumps in the place of modes, and of switches that remember.

        With guards as given where `masked` is False; else they act in their mode alone.
        """
        if not (kept := self.kept):
            return self
        modes, states = self.modes, {name: text for name, text in self.states.items() if name not in kept}
        begun = dict.fromkeys(modes, "0") | (
            {} if modes.keys() & self.states else dict.fromkeys([*modes][:1], "1")
        )
        begun |= {each.name: _start(each, self) for each in self.latches}
        rates = {name: _moving(text, kept) for name, text in self.rates.items()}
        tables = {
            "modes": {},
            "states": states | begun | {name: self.states[name] for name in kept if name in self.states},
            "rates": rates | dict.fromkeys(kept, "0"),
            "switches": tuple(each for each in self.switches if each not in self.latches),
            "jumps": (*self.jumps, *_exits(modes, masked), *_turns(self.latches, masked)),
        }
        return self.model_copy(update=tables)

    @property
    def latches(self) -> tuple[Switch, ...]:
        """Switches that remember, with two thresholds."""
        return tuple(each for each in self.switches if each.off is not None and not each.slides)

    @property
    def kept(self) -> tuple[str, ...]:
        """Names of states that events alone change: modes, and switches that remember."""
        return (*self.modes, *(each.name for each in self.latches))

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
        contacts = (
            each.model_copy(update={"tension": flags.get(each.tension, each.tension)})
            for each in self.contacts
        )
        return written.Oscillator(
            positions=positions,
            speeds=speeds,
            parameters=tuple(self.numbers),
            rates=tuple(flat.rates[name] for name in speeds),
            mass=tuple((max(i, j), min(i, j), text) for i, j, text in entries),
            period=self.forcing or "",
            contacts=_written(written.Touch, contacts),
            friction=_written(written.Rubbing, self.friction),
            switches=tuple(written.Switch(each.name, each.on, each.slides) for each in flat.switches),
            impacts=_written(written.Wall, self.impacts),
            jumps=_written(written.Trigger, flat.jumps),
            outputs=tuple(self.outputs.items()),
            section=section,
        )

    @model_validator(mode="after")
    def _well_posed(self) -> Self:
        raise_any(problems(self))
        return self

    @checked()
    def replace(self, **changes: Any) -> System:
        """Give a copy with other parameters, or another `initial` state.

        Parameters
        ----------
        **changes
            Parameters by name, and `initial`, a list in the order of `order`; what the initial state and the
            period are said by follows the parameters.

        Raises
        ------
        InputError
            Listing every parameter that does not exist or cannot have its value.
        """
        initial = changes.pop("initial", None)
        if self.system is not None:
            record = self._of_the_catalog(changes)
        else:
            known = self.parameters
            raise_any(unknown(k, v, k, known, "parameter") for k, v in changes.items() if k not in known)
            values = in_si(changes, {key: self.units.get(key, "1") for key in changes})
            record = System(**dict(self) | {"parameters": self.parameters | values})
        return record if initial is None else System(**dict(record) | {"states": record._started(initial)})

    def varied(self, changes: Mapping[str, Any]) -> System:
        """Give a copy as sweeps vary it, by the keys of `mechanism.parameters`."""
        return self.replace(**one_by_one(changes, self.parameters.get)) if changes else self

    def known_by(self, numbers: Mapping[str, float]) -> System:
        """Give a copy with other parameters for a hash alone: it is not checked, as `replace` does.

        An entry of the catalog is without its states, which follow from its parameters.
        """
        single = one_by_one(numbers, self.parameters.get)
        parameters = self.parameters | {key: float(value) for key, value in single.items()}
        states = {} if self.system else self.states
        return self.model_copy(update={"parameters": parameters, "states": states})

    def _of_the_catalog(self, changes: dict[str, Any]) -> System:
        raise_any(strangers([("system", self.system)], CATALOG, "system of the catalog"))
        return CATALOG[self.system](**self.parameters | changes)

    def _started(self, initial: Any) -> dict[str, Any]:
        names = [name for names in self.order for name in names]
        if not isinstance(initial, list | tuple) or len(initial) != len(names):
            raise refuse(initial, f"{len(names)} finite numbers ({', '.join(names)}) are accepted", "initial")
        return dict(zip(names, initial, strict=True))

    def summary(self) -> str:
        """Describe the system in one line of text."""
        units = {name: f" {unit}" for name, unit in self.units.items()}
        values = ", ".join(f"{name} = {plain(x)}{units.get(name, '')}" for name, x in self.parameters.items())
        cycle = f"; period {plain(self.period)}" if self.period else ""
        return f"{self.name}: {values or 'no parameters'}{cycle}"

    def __repr__(self) -> str:
        return f"<System {self.summary()}>"

    __str__ = __repr__

    def __hash__(self) -> int:
        return hash(
            (self.name, self.system, *self.parameters.items(), *self.states.items(), self.structure())
        )


def _moving(rate: str, kept: Collection[str]) -> str:
    """A rate as it stands; of a mode's bare name a product, since a mode is no position's speed."""
    return f"1*{rate}" if parse(rate).value in kept else rate


def _exits(modes: Modes, masked: bool) -> Iterator[Jump]:
    for mode, exits in modes.items():
        for i, each in enumerate(exits):
            again = sum(other.to == each.to for other in exits[:i])
            name = f"{mode}_{each.to}" + (f"_{again + 1}" if again else "")
            guard = f"{mode}*({each.guard}) + 1 - {mode}" if masked else each.guard
            target = {each.to: "1"} if each.to in modes else {}
            yield Jump(name=name, guard=guard, jump={**each.jump, mode: "0", **target})


def _turns(latches: Iterable[Switch], masked: bool) -> Iterator[Jump]:
    """Jumps of switches that remember, two of each."""
    for each in latches:
        s, on, off = each.name, f"-({each.on})", f"-({each.off})"
        on, off = (f"{s} + (1 - {s})*({on})", f"1 - {s} + {s}*({off})") if masked else (on, off)
        yield Jump(name=f"{s}_on", guard=on, jump={s: "1"})
        yield Jump(name=f"{s}_off", guard=off, jump={s: "0"})


def _start(latch: Switch, system: System) -> str:
    """A switch that remembers at time 0: 1 but where it is to be off, by what is known then."""
    known = {**system.states, "t": "0"}
    begun = {
        each.name: f"0.5 + 0.5*sign({each.on if each.off is None else f'-({each.off})'})"
        for each in system.switches
    }
    known = begun | known
    text = latch.off
    for _ in range(3):  # of switches that hang on others
        text = re.sub(
            r"[A-Za-z]\w*",
            lambda name: f"({known[name[0]]})" if name[0] in known else name[0],
            text,
        )
    return f"0.5 - 0.5*sign({text})"


def _written(kind: Callable[..., T], parts: Iterable[Record]) -> tuple[T, ...]:
    """Parts as the equations have them, field by field; what is left out is an empty text."""

    def stated(value: Any) -> Any:
        return tuple(value.items()) if isinstance(value, dict) else "" if value is None else value

    return tuple(kind(*(stated(value) for _, value in each)) for each in parts)


CATALOG: Table[Callable[..., Any]] = Table("jointplay.mechanisms", Preset)  # filled by `mechanism.catalog`
