"""Systems of somebody's own equations: their record. Test systems of the catalog are such systems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import Field, model_validator

from jointplay.equations import written
from jointplay.equations.grammar import number, parse
from jointplay.errors import InputError, join, refuse, unknown
from jointplay.mechanism import own_modes
from jointplay.mechanism.base import Few, Flag, Name, Number, Positive, Record
from jointplay.mechanism.measures import coherent, in_si
from jointplay.mechanism.own_parts import Exit, Impact, Jump, Rubbing, Switch, Text, Touch
from jointplay.mechanism.signature import checked

_VALUE = {
    "accepts": "a table of finite numbers, with their units as '0.3 mm', or true and false for switches,"
}


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
    """

    __test__ = False  # of a name that begins with Test, and pytest would collect it

    name: Name = Field("system", description="name", json_schema_extra={"noun": True})
    states: dict[Name, Text] = Field(json_schema_extra={"accepts": "a table of initial values"})
    parameters: dict[Name, Flag | Number] = Field({}, json_schema_extra=_VALUE)
    rates: dict[Name, Text]
    mass: dict[Name, dict[Name, Text]] = Field({})
    forcing: Text | None = None
    contacts: Few[Touch] = ()
    friction: Few[Rubbing] = ()
    switches: Few[Switch] = ()
    modes: dict[Name, Few[Exit]] = Field({}, json_schema_extra={"accepts": "a table of modes"})
    impacts: Few[Impact] = ()
    jumps: Few[Jump] = ()
    outputs: dict[Name, Text] = Field({})
    units: dict[Name, str] = Field({})
    scales: dict[Name, Positive] = Field({})
    system: Name | None = None

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
        if problems:
            raise InputError(problems)
        own = data.get("units", {})
        return found | ({"units": units | dict(own)} if units and isinstance(own, Mapping) else {})

    @model_validator(mode="after")
    def _well_posed(self) -> Self:
        from jointplay.mechanism.well_posed import problems

        if found := problems(self):
            raise InputError(found)
        return self

    @property
    def flags(self) -> dict[str, bool]:
        """Parameters that are true or false."""
        return {key: value for key, value in self.parameters.items() if isinstance(value, bool)}

    @property
    def numbers(self) -> dict[str, float]:
        """Parameters that are numbers."""
        return {key: float(value) for key, value in self.parameters.items() if not isinstance(value, bool)}

    @property
    def order(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Positions, and speeds, the first of them theirs: states as results and lists have them."""
        flat = self.flat
        moved, found = {state for each in flat.jumps for state in each.jump}, {}
        for state in flat.states:
            tree = parse(flat.rates[state])
            free = tree.value not in {state, *found, *found.values()} and state not in found.values()
            if tree.operation == "name" and tree.value in flat.states and free and state not in moved:
                found[state] = tree.value
        positions, speeds = tuple(found), tuple(found.values())
        return positions, (*speeds, *(s for s in flat.states if s not in positions + speeds))

    @property
    def flat(self) -> System:
        """The system with its modes as states and jumps."""
        return own_modes.flat(self) if self.modes else self

    @property
    def initial(self) -> tuple[float, ...]:
        """State at time 0, in `order`."""
        states = self.flat.states
        return tuple(number(states[name], self.numbers) for names in self.order for name in names)

    @property
    def period(self) -> float | None:
        """Period of the forcing, which a negative one goes through backwards; None if there is none."""
        return None if self.forcing is None else abs(number(self.forcing, self.numbers))

    def structure(self, section: str | None = None) -> written.Oscillator:
        """The equations without their numbers."""
        (positions, speeds), flags, flat = self.order, self.flags, self.flat
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
            if wrong := [unknown(k, v, k, known, "parameter") for k, v in changes.items() if k not in known]:
                raise InputError(wrong)
            values = in_si(changes, {key: self.units.get(key, "1") for key in changes})
            record = System(**dict(self) | {"parameters": self.parameters | values})
        return record if initial is None else System(**dict(record) | {"states": record._started(initial)})

    def _of_the_catalog(self, changes: dict[str, Any]) -> System:
        from jointplay.mechanism.systems import SYSTEMS

        if self.system not in SYSTEMS:
            accepted = f"a system of the catalog is accepted: {', '.join(SYSTEMS)}"
            raise refuse(self.system, accepted, "system")
        return SYSTEMS[self.system](**self.parameters | changes)

    def _started(self, initial: Any) -> dict[str, Any]:
        names = [name for names in self.order for name in names]
        if not isinstance(initial, list | tuple) or len(initial) != len(names):
            raise refuse(initial, f"{len(names)} finite numbers ({', '.join(names)}) are accepted", "initial")
        return dict(zip(names, initial, strict=True))

    def summary(self) -> str:
        """Describe the system in one line of text."""
        units = {name: f" {unit}" for name, unit in self.units.items()}
        values = ", ".join(
            f"{name} = {value:g}{units.get(name, '')}" for name, value in self.parameters.items()
        )
        cycle = f"; period {self.period:.6g}" if self.period else ""
        return f"{self.name}: {values or 'no parameters'}{cycle}"

    def __repr__(self) -> str:
        return f"<System {self.summary()}>"

    __str__ = __repr__

    def __hash__(self) -> int:
        return hash(
            (self.name, self.system, *self.parameters.items(), *self.states.items(), self.structure())
        )
