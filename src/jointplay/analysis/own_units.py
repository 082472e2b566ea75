"""Values with a unit in keywords whose unit the mechanism decides: what varies, levels of sections."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from jointplay.accepted import Refused
from jointplay.analysis.quantities import WORDS
from jointplay.analysis.vary import units_of
from jointplay.errors import InputError
from jointplay.mechanism.measures import in_si
from jointplay.mechanism.records import Mechanism, TestSystem

FOLLOWED = "clearance"  # the parameter along which a continuation goes if none is named


def in_own_units(mechanism: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """Give keywords with such texts in SI units; what is wrong with one stands in its place, as `Refused`.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        Whose parameters they are; of anything else they stay as given.
    given : mapping of str to object
        Keywords of an analysis, as they were given.
    """
    if not isinstance(mechanism, Mechanism | TestSystem):
        return dict(given)
    ways = {"over": _over, "plane": _plane, "section": _section}
    parameter = given.get("parameter", FOLLOWED)
    if "range" in given and isinstance(parameter, str):
        ways |= dict.fromkeys(
            ("range", "start"), lambda mechanism, value: in_si(value, units_of(mechanism, parameter))
        )
    return {key: _tried(ways.get(key), mechanism, value) for key, value in given.items()}


def _tried(way: Callable[[Any, Any], Any] | None, mechanism: Any, value: Any) -> Any:
    try:
        return value if way is None else way(mechanism, value)
    except InputError as error:
        return Refused(error)


def _over(mechanism: Any, over: Any) -> Any:
    if not isinstance(over, Mapping):
        return over
    return in_si(over, {key: units_of(mechanism, key) for key in over})


def _plane(mechanism: Any, plane: Any) -> Any:
    from jointplay.analysis.states.start_plane import CRANK, JOURNAL, UNITS

    if not isinstance(plane, Mapping) or not isinstance(mechanism, Mechanism):
        return plane
    named = {name: units for name, (units, _) in (CRANK | JOURNAL).items()}
    units = {key: named.get(key, UNITS.get(str(key).split("_")[0])) for key in plane}
    return in_si(plane, {key: each and _plain(each) for key, each in units.items()})


def _section(_: Any, section: Any) -> Any:
    word = WORDS.get(section["quantity"]) if isinstance(section, Mapping) and "quantity" in section else None
    return in_si(section, {"value": _plain(word.units)}) if word else section


def _plain(units: str) -> str:
    """Units of datasets (``rad s-1``) as units are written (``rad s^-1``)."""
    return re.sub(r"(?<=[a-z])-", "^-", units)
