"""Values with a unit in keywords whose unit the mechanism decides: parameters, starts, sections' levels."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from jointplay.analysis.quantities import WORDS
from jointplay.display.accepted import Refused
from jointplay.display.errors import InputError, refuse
from jointplay.solver.mechanism.measures import ANY, in_si
from jointplay.solver.mechanism.parameters import declared_units
from jointplay.solver.mechanism.records import Mechanism, TestSystem

FOLLOWED = "clearance"  # the parameter along which a continuation goes if none is named


def in_own_units(mechanism: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values with units in keywords into SI units; a wrong one becomes a `Refused`.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        Whose parameters they are; of anything else, and of names that it has not, each number is brought
        into SI by its own unit: what is wrong there is said elsewhere.
    given : mapping of str to object
        Keywords of an analysis, as they were given.
    """
    converters = dict.fromkeys(("over", "by", "plane", "region"), _named)
    converters |= {"initial": _start, "starts": _starts, "section": _section}
    converters |= {"spreads": _spreads, "limits": _limits, "subject": _limits}
    plane = given.get("plane")
    followed = next(iter(plane), FOLLOWED) if isinstance(plane, Mapping) else FOLLOWED
    parameter = given.get("parameter", followed)
    if {"range", "plane"} & given.keys() and isinstance(parameter, str):
        converters |= dict.fromkeys(
            ("range", "start"), lambda mechanism, value: in_si(value, declared_units(mechanism, parameter))
        )
    return {key: _tried(converters.get(key), mechanism, value) for key, value in given.items()}


def _tried(converter: Callable[[Any, Any], Any] | None, mechanism: Any, value: Any) -> Any:
    try:
        return value if converter is None else converter(mechanism, value)
    except InputError as error:
        return Refused(error)


def _named(mechanism: Any, table: Any) -> Any:
    """A table of parameters, or of coordinates of starts."""
    units = {name: _units(mechanism, name) for name in table} if isinstance(table, Mapping) else None
    return in_si(table, units)


def _units(mechanism: Any, name: Any) -> str:
    from jointplay.analysis.states.start_plane import CRANK, JOURNAL, UNITS

    if (own := declared_units(mechanism, name)) != ANY:
        return own
    if isinstance(mechanism, TestSystem):
        return mechanism.units.get(name, "1") if name in mechanism.states else ANY
    named = {coordinate: units for coordinate, (units, _) in (CRANK | JOURNAL).items()}
    found = named.get(name) or UNITS.get(str(name).split("_")[0])
    return _plain(found or ANY)


def _start(mechanism: Any, initial: Any) -> Any:
    """The state of a system, as a list in its order; a linkage's table has its units in its fields."""
    names = [name for group in mechanism.order for name in group] if isinstance(mechanism, TestSystem) else []
    if names and isinstance(initial, Mapping):
        raise refuse(dict(initial), f"a list of the states {', '.join(names)} is accepted")
    if isinstance(mechanism, Mechanism) or type(initial) not in (list, tuple):
        return initial
    if not names:
        return in_si(initial, ANY)
    return in_si(initial, tuple(mechanism.units.get(name, "1") for name in names))


def _starts(mechanism: Any, starts: Any) -> Any:
    return [_start(mechanism, each) for each in starts] if type(starts) in (list, tuple) else starts


def _spreads(mechanism: Any, table: Any) -> Any:
    from jointplay.analysis.tolerances.spreads import in_own_units

    return in_own_units(mechanism, table)


def _limits(mechanism: Any, table: Any) -> Any:
    """A table of quantities of motions, as of `gradient` or of samples of `tolerances`."""
    units = {name: _limited(mechanism, str(name)) for name in table} if isinstance(table, Mapping) else None
    return in_si(table, units)


def _limited(mechanism: Any, name: str) -> str:
    """Units of a quantity: of ``largest:normal_force:B`` those of the middle word."""
    from jointplay.analysis.tolerances.spreads import COUNTED, OF_JOINT, PLAIN

    head, word, label = (*name.split(":", 2), "", "")[:3]
    if word == "state" and isinstance(mechanism, TestSystem):
        return mechanism.units.get(label, "1")
    own = dict.fromkeys(COUNTED, "1") | {key: units for key, (_, units) in (OF_JOINT | PLAIN).items()}
    found = (own | {"time": "s", "work": "J"}).get(head) or (WORDS[word].units if word in WORDS else None)
    return _plain(found or ANY)


def _section(mechanism: Any, section: Any) -> Any:
    name = section.get("quantity") if isinstance(section, Mapping) else None
    known = isinstance(name, str) and name in WORDS
    units = _plain(WORDS[name].units) if known else ANY
    if isinstance(mechanism, TestSystem) and isinstance(name, str):
        units = mechanism.units.get(name, "1")
    return in_si(section, {"value": units})


def _plain(units: str) -> str:
    """Units of datasets (``rad s-1``) as units are written (``rad s^-1``)."""
    return re.sub(r"(?<=[a-z])-", "^-", units)
