"""Numbers in words: a value with its error to the digits that it leaves, units with raised powers.

Display units: the one table from the units of a file (SI, UDUNITS spelling) to units on an axis.
"""

import math
import re
from collections.abc import Sequence
from decimal import Decimal
from typing import Any, NamedTuple

MINUS = str.maketrans("-", "\N{MINUS SIGN}")
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
LARGEST = 99999.5  # below which no power of ten is written
LONGEST = 5  # decimals, before a small number is written with a power of ten

PLAIN = {"1": "\N{EN DASH}", "": "\N{EN DASH}"}
# stored unit: (shown as, factor, used where the largest magnitude in the stored unit is at least this)
TABLE = {
    "m": (("m", 1.0, 2.0), ("mm", 1e3, 1e-3), ("µm", 1e6, 0.0)),
    "s": (("s", 1.0, 1.0), ("ms", 1e3, 0.0)),
    "rad": (("deg", 180 / math.pi, 0.0),),
    "rad s-1": (("rad/s", 1.0, 0.0),),
    "rad s-2": (("rad/s²", 1.0, 0.0),),
    "m s-1": (("m/s", 1.0, 0.2), ("mm/s", 1e3, 1e-4), ("µm/s", 1e6, 0.0)),
    "m s-2": (("m/s²", 1.0, 0.0),),
    "N": (("N", 1.0, 0.0),),
    "N m": (("N·m", 1.0, 0.0),),
    "J": (("J", 1.0, 0.0),),
    "W": (("W", 1.0, 0.0),),
    "Pa": (("MPa", 1e-6, 1e5), ("kPa", 1e-3, 0.0)),
}
POWERS = str.maketrans("²³⁴", "234")


def with_error(value: float, error: float) -> str:
    """Return `value` ± `error`, two digits of the error; without it where it is unknown or 0."""
    if math.isnan(value):
        return "\N{EN DASH}"
    if math.isinf(value):
        return ("-∞" if value < 0 else "∞").translate(MINUS)
    if not (math.isfinite(error) and error > 0):
        return plain(value)
    digits = 1 - math.floor(math.log10(error))
    if digits <= LONGEST:
        return f"{value:.{max(digits, 0)}f} ± {error:.{max(digits, 0)}f}".translate(MINUS)
    power = math.floor(math.log10(max(abs(value), error)))
    if power > -3:
        return f"{value:.{LONGEST}f} ± {plain(error, 1)}".translate(MINUS)
    places, size = min(digits + power, LONGEST), 10.0**power
    words = f"({value / size:.{places}f} ± {error / size:.{places}f})".translate(MINUS)
    return f"{words} × 10{str(power).translate(RAISED)}"


def plain(value: float, digits: int = 6) -> str:
    """Return a number in so many significant digits."""
    if math.isnan(value):
        return "\N{EN DASH}"
    text = f"{value:.{digits}g}"
    mantissa, _, power = (f"{Decimal(text):f}" if 1 <= abs(value) < LARGEST else text).partition("e")
    tail = f" × 10{str(int(power)).translate(RAISED)}" if power else ""
    return mantissa.translate(MINUS) + tail


def percent(share: float, low: float, high: float) -> str:
    """Return a share in per cent, with the ends of its interval."""
    value, *ends = (plain(100 * each, 3) for each in (share, low, high))
    return f"{value} % ({' to '.join(ends)})"


def typed(value: float, digits: int = 6) -> str:
    """Return a number as one types it into a file: ``0.00029``, ``7.15e6``; of 0 digits, with all of them."""
    number = Decimal(f"{value:.{digits}g}" if digits else repr(float(value)))
    if not number.is_finite():
        return str(float(value))
    number, size = number.normalize(), number.adjusted() if number else 0
    written, powered = f"{number:f}", f"{number.scaleb(-size).normalize():f}e{size}"
    return powered if size < -4 or (size > 4 and len(powered) < len(written)) else written


def duration(seconds: float) -> str:
    """Return a time in the unit in which it is at least 2: ``40 s``, ``3.5 min``, ``2.0 h``."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.0f} s" if seconds >= 10 else f"{seconds:.2g} s"


def raised(units: str) -> str:
    """Return units in UDUNITS spelling with their powers raised."""
    return units.translate(RAISED)


def signed(value: float, error: float) -> str:
    """Return `value` ± `error` with its sign, also where that is plus."""
    text = with_error(value, error)
    return f"+{text}" if value > 0 else text


def counted(count: int, noun: str) -> str:
    """A number of things: ``1 motion``, ``2 motions``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def listed(names: Sequence[str], most: int, last: str = " and ") -> str:
    """The first of some names, and how many more there are: ``a, b and 3 more``."""
    more = f"{last}{len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def cf_units(units: str) -> str:
    """Units of the records (``N/m``, ``kg m²``) as units of datasets (``N m-1``, ``kg m2``)."""
    above, _, below = units.translate(POWERS).partition("/")
    lowered = (
        re.sub(r"^(\D+)(\d*)$", r"\1-\2", unit) + "1" * unit.isalpha() for unit in below.strip("()").split()
    )
    return " ".join([above, *lowered])


class Shown(NamedTuple):
    """A unit on an axis: its symbol, and the factor from stored values to it."""

    symbol: str
    factor: float


def shown(values, units: str) -> Shown:
    """Choose the display unit of `values`, stored in `units`; units outside the table are shown as stored."""
    import numpy as np

    known = cf_units(units.replace("^", ""))
    if known not in TABLE:
        return Shown(PLAIN.get(units, units), 1.0)
    magnitudes = np.abs(np.asarray(values, dtype=float))
    largest = np.max(magnitudes, initial=0.0, where=np.isfinite(magnitudes))
    symbol, factor, _ = next(row for row in TABLE[known] if largest >= row[2] or not largest)
    return Shown(symbol, factor)


def measure(value: float, units: str, digits: int = 4) -> str:
    """Write a value with a friendly unit: 9.22e-5 m is 92.2 µm."""
    unit = shown(value, units)
    symbol = "" if unit.symbol in PLAIN.values() else f" {raised(unit.symbol)}"
    return f"{plain(value * unit.factor + 0.0, digits)}{symbol}"  # no minus before a zero


def measured(value: Any, variable: Any, digits: int = 4) -> str:
    """Write a value of a variable of a dataset, or of one in its units."""
    return measure(float(value), str(variable.attrs.get("units", "1")), digits)
