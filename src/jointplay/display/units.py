"""Display units: the one table from the units of a file (SI, UDUNITS spelling) to units on an axis."""

from typing import NamedTuple

import numpy as np

from jointplay.display.number_text import plain, raised

PLAIN = {"1": "\N{EN DASH}", "": "\N{EN DASH}"}

# stored unit: (shown as, factor, used where the largest magnitude in the stored unit is at least this)
TABLE = {
    "m": (("m", 1.0, 2.0), ("mm", 1e3, 1e-3), ("µm", 1e6, 0.0)),
    "s": (("s", 1.0, 1.0), ("ms", 1e3, 0.0)),
    "rad": (("deg", 180 / np.pi, 0.0),),
    "rad s-1": (("rad/s", 1.0, 0.0),),
    "rad s-2": (("rad/s²", 1.0, 0.0),),
    "m s-1": (("m/s", 1.0, 0.2), ("mm/s", 1e3, 1e-4), ("µm/s", 1e6, 0.0)),
    "m s-2": (("m/s²", 1.0, 0.0),),
    "N": (("N", 1.0, 0.0),),
    "N m": (("N·m", 1.0, 0.0),),
    "J": (("J", 1.0, 0.0),),
    "W": (("W", 1.0, 0.0),),
}
SPELLINGS = {
    "rad/s": "rad s-1",
    "rad/s2": "rad s-2",
    "rad/s^2": "rad s-2",
    "m/s": "m s-1",
    "m/s2": "m s-2",
    "m/s^2": "m s-2",
    "N.m": "N m",
    "degree": "deg",
    "degrees": "deg",
}


class Shown(NamedTuple):
    """A unit on an axis: its symbol, and the factor from stored values to it."""

    symbol: str
    factor: float


def shown(values, units: str) -> Shown:
    """Choose the display unit of `values`, stored in `units`; units outside the table are shown as stored."""
    units = SPELLINGS.get(units, units)
    if units not in TABLE:
        return Shown(PLAIN.get(units, units), 1.0)
    magnitudes = np.abs(np.asarray(values, dtype=float))
    largest = np.max(magnitudes, initial=0.0, where=np.isfinite(magnitudes))
    symbol, factor, _ = next(row for row in TABLE[units] if largest >= row[2])
    return Shown(symbol, factor)


def measure(value: float, units: str, digits: int = 4) -> str:
    """Write a value with a friendly unit: 9.22e-5 m is 92.2 µm."""
    unit = shown(value, units)
    symbol = "" if unit.symbol in PLAIN.values() else f" {raised(unit.symbol)}"
    return f"{plain(value * unit.factor + 0.0, digits)}{symbol}"  # no minus before a zero
