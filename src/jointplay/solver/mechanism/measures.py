"""Values written with their unit, such as ``"0.29 mm"``, brought into the unit that a field declares.

Units and prefixes are those of the library pint, which is loaded when the first such text appears. Numbers
are decimal until the last step, so that ``"0.29 mm"`` is the same float as 2.9e-4. Radians count as a unit,
and not as 1: neither 50 Hz nor 50 1/s is an angular velocity, since they do not say whether turns or radians
are meant.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from decimal import Decimal
from functools import cache
from itertools import chain, repeat
from typing import Any

from jointplay.display.errors import InputError, raise_any, refuse
from jointplay.display.number_text import typed

SMALLEST = 1e-50  # SI; a handful of such numbers can still be multiplied
LONGEST = 60  # characters of a text with a unit
ANY = "any"  # units of what nothing says the unit of: those of SI, whatever it measures
# as editors check it, too
PATTERN = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?(\s*|\s+1/)[A-Za-zµμ°%][^,;_]*$"
_WRITTEN = re.compile(PATTERN)
_NUMBER = re.compile(r"\s*[+-]?[\d.]+([eE][+-]?\d+)?")


def in_si(given: Any, units: str | Mapping[str, Any] | tuple[str | None, ...] | None) -> Any:
    """Bring texts with a unit into the field's unit, also inside a list or a table; all else stays as it is.

    Parameters
    ----------
    given : object
        A value, or a list or table of them.
    units : str, mapping of str to str, tuple of str, or None
        What the field declares, as ``kg m²``; ``1`` of a pure number, None where it holds no quantity, `ANY`
        where that is not known. Of a table, or a list of tables, also units of its entries by name, and of
        a list those of each.

    Raises
    ------
    InputError
        Where a unit is not known or measures something else, with keys relative to the value.
    """
    if units is None:
        return given
    if isinstance(given, Mapping):
        own = units.get if isinstance(units, Mapping) else lambda _: units
        return dict(zip(given, _each((key, item, own(key)) for key, item in given.items()), strict=True))
    if type(given) in (list, tuple):
        each = chain(units, repeat(None)) if isinstance(units, tuple) else repeat(units)
        return type(given)(_each((f"[{i}]", *pair) for i, pair in enumerate(zip(given, each, strict=False))))
    if units == ANY:
        return coherent(given)[0]
    if isinstance(given, str) and isinstance(units, str):
        return _converted(given, units) if len(given) <= LONGEST and _WRITTEN.match(given) else given
    return given


def _each(items: Iterable[tuple[Any, Any, Any]]) -> list[Any]:
    values, problems = [], []
    for key, item, units in items:
        try:
            values.append(in_si(item, units))
        except InputError as error:
            problems += error.under(str(key)).problems
    raise_any(problems)
    return values


def _converted(given: str, units: str) -> float:
    number = _NUMBER.match(given)[0]
    unit = given[len(number) :].strip()
    (factor, found), (scale, wanted) = _base(unit), _base("" if units == "1" else units)
    accepted = (
        "a pure number, or a share in %,"
        if units == "1"
        else f"a number, or one with a unit such as {units},"
    )
    if found is None:
        raise refuse(given, f"{accepted} is accepted; {unit!r} is not a known unit")
    if found != wanted:
        what = "a pure number" if units == "1" else units
        raise refuse(given, f"{accepted} is accepted; {unit} does not convert to {what}")
    value = float(Decimal(number.strip()) * factor / scale)
    if value and not SMALLEST <= abs(value) <= 1 / SMALLEST:
        size = f"between {typed(SMALLEST)} and {typed(1 / SMALLEST)} {units} in size"
        raise refuse(given, f"a number {size} is accepted")
    return value


@cache
def _registry() -> Any:
    from pint import UnitRegistry

    registry = UnitRegistry(cache_folder=None, non_int_type=Decimal)
    registry.define("newton_meter = newton * meter = Nm")
    return registry


@cache
def _base(unit: str) -> tuple[Decimal, Any]:
    """Factor of a unit to SI base units (rad among them), and these; None for them where not known."""
    known = _registry()
    try:
        return known.get_base_units(known.parse_units(unit))
    except Exception:  # pint's parser fails in many ways on what is no unit
        return Decimal(1), None


def coherent(given: Any) -> tuple[Any, str]:
    """Bring a text with any unit into SI: its number, and the unit; all else as it is, without one.

    Raises
    ------
    InputError
        Where the unit is not known.
    """
    text = isinstance(given, str) and len(given) <= LONGEST and _WRITTEN.match(given)
    unit = given[len(_NUMBER.match(given)[0]) :].strip() if text else ""
    if not unit:
        return given, ""
    factor, base = _base(unit)
    if base is None:
        raise refuse(given, f"a number, or one with its unit, is accepted; {unit!r} is not a known unit")
    own = unit if factor == 1 and "%" not in unit else _named(base)
    return _converted(given, own or "1"), own


def _named(base: Any) -> str:
    """Units as ``kg m²/s²``, or ``A/(kg m)``."""
    symbol, powers = _registry().get_symbol, sorted(base._units.items())
    terms = [(f"{symbol(name)}{abs(int(power)) if abs(power) > 1 else ''}", power) for name, power in powers]
    above, below = ([text for text, power in terms if sign * power > 0] for sign in (1, -1))
    under = f"({' '.join(below)})" if len(below) > 1 else "".join(below)
    return f"{' '.join(above) or '1'}{under and '/'}{under}".translate(str.maketrans("234", "²³⁴"))
