"""Systems of somebody's own equations: their record. Test systems of the catalog are such systems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Self

from pydantic import model_validator

from jointplay.display.errors import raise_any, refuse, strangers, unknown
from jointplay.display.number_text import plain
from jointplay.solver.extensions import Table
from jointplay.solver.mechanism.measures import in_si
from jointplay.solver.mechanism.own.own_equations import Equations
from jointplay.solver.mechanism.own.well_posed import problems
from jointplay.solver.mechanism.paths import one_by_one
from jointplay.solver.mechanism.signature import Preset, checked


class System(Equations):
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


CATALOG: Table[Callable[..., Any]] = Table("jointplay.mechanisms", Preset)  # filled by `mechanism.catalog`
