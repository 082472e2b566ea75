"""Values that vary with time or with an angle: a constant, harmonics, or a table over one period.

Method of a table: the trigonometric polynomial through N evenly spaced values (its coefficients are their
discrete Fourier transform), cut after the fewest harmonics that do. Its error is measured as the largest
difference to another smooth curve, the periodic cubic spline through all of the values, between them and at
them: where two such curves differ, the values do not say what lies between. Source: Trefethen, Approximation
Theory and Approximation Practice (2013); de Boor, A Practical Guide to Splines (1978).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from jointplay.display.errors import NOTHING, Problem, raise_any
from jointplay.display.number_text import measure
from jointplay.solver.equations import structure
from jointplay.solver.mechanism.base import Few, Number, Positive, Record, measured
from jointplay.solver.mechanism.measures import ANY

LEAST, MOST = 3, 1000  # values of a table
_TABLE = f"a list of {LEAST} to {MOST} finite numbers, evenly spaced over one period and not all alike,"
FORCES = "N or N m"  # units of what is a force or a torque, as its whole is
_AMPLITUDE = "a finite number, or in the table of a load or drive one with its unit,"
_STEP = 0.7  # rad of a phase that a step may span: within where the generated polynomials hold
MOST_ORDERS = 24
_FINER = 16  # points at which the two curves are compared, for each value


class Series(NamedTuple):
    """A mean, harmonics as (order, cosine, sine), and the error as a share of the values' range."""

    mean: float
    harmonics: tuple[tuple[int, float, float], ...]
    error: float


@lru_cache(maxsize=256)
def series(table: tuple[float, ...], tolerance: float) -> Series:
    """Give the shortest series whose error is within a tolerance; the best one where none is.

    Parameters
    ----------
    table : tuple of float
        At least three values, the first at phase 0, the last a step before the period's end; not all alike.
    tolerance : float
        Of the error, as a share of the values' range.
    """
    from scipy.interpolate import CubicSpline

    values = np.array(table)
    count = len(values)
    places = 2 * np.pi * np.arange(count + 1) / count
    fine = 2 * np.pi * np.arange(count * _FINER) / (count * _FINER)
    spline = CubicSpline(places, np.append(values, values[0]), bc_type="periodic")(fine)
    spectrum = np.fft.rfft(values) / count
    best, curve, terms = None, np.full(len(fine), spectrum[0].real), []
    for n in range(1, min(MOST_ORDERS, count // 2) + 1):
        twice = 1 if 2 * n == count else 2
        a, b = twice * spectrum[n].real, -twice * spectrum[n].imag
        terms.append((n, float(a), float(b)))
        curve = curve + a * np.cos(n * fine) + b * np.sin(n * fine)
        error = float(np.abs(curve - spline).max() / np.ptp(values))
        if best is None or error < best.error:
            best = Series(float(spectrum[0].real), tuple(terms), error)
        if error <= tolerance:
            break
    return best


class Harmonic(Record):
    """One term A cos nφ + B sin nφ.

    Parameters
    ----------
    order : int
        n, 1 to 24.
    cosine, sine : float
        A and B, in the units of the whole.
    """

    order: Annotated[int, Field(strict=True, ge=1, le=MOST_ORDERS)]
    cosine: Number = measured("cosine's amplitude", FORCES, 0.0, accepts=_AMPLITUDE)
    sine: Number = measured("sine's amplitude", FORCES, 0.0, accepts=_AMPLITUDE)

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        return {"cosine": None, "sine": None}  # those of the whole, which brings its tables into them

    @property
    def name(self) -> str:
        """Its order, by which a sweep finds it."""
        return str(self.order)


class Course(Record):
    """A constant, and harmonics or a table, times a factor.

    Parameters
    ----------
    constant : float
        N or N m.
    harmonics : tuple of Harmonic
        Terms of different orders.
    table : tuple of float
        Values over one period, evenly spaced, the first at phase 0; in the place of harmonics. A series of as
        few harmonics as will do stands for it.
    tolerance : float
        Error of that series, as a share of the values' range, up to which it is accepted.
    factor : float
        By which all of it is multiplied.
    """

    units: ClassVar[str] = "N m"
    phases: ClassVar[tuple[str, ...]] = ()  # keys of which one says what it varies with
    constant: Number = measured("constant part", FORCES, 0.0)
    harmonics: Few[Harmonic] = ()
    table: Annotated[tuple[Number, ...] | None, Field(json_schema_extra={"accepts": _TABLE})] = None
    tolerance: Annotated[Positive, Field(le=1)] = measured("tolerance of the table", "1", 0.01)
    factor: Number = measured("factor", "1", 1.0)

    @classmethod
    def _further_units(cls, data: Mapping[str, Any]) -> Mapping[str, Any]:
        own, given = cls.units, [key for key in cls.phases if data.get(key) is not None]
        phases = dict.fromkeys(given, ANY) if len(given) > 1 else {}  # then none of them is right
        return {"constant": own, "table": own, "harmonics": {"cosine": own, "sine": own}, **phases}

    @model_validator(mode="after")
    def _one_course(self) -> Self:
        raise_any([*self._forms(), *self._phase_problems()])
        return self

    def _forms(self) -> Iterator[Problem]:
        orders = [harmonic.order for harmonic in self.harmonics]
        for i, order in enumerate(orders):
            if order in orders[:i]:
                text = "an order that no other of the harmonics has is accepted"
                yield Problem(f"harmonics[{i}].order", order, text)
        if self.harmonics and self.table is not None:
            yield Problem("table", self.table, "either harmonics or a table is accepted, not both")
        elif self.table is not None:
            yield from self._table_problems(self.table)
        elif not self.harmonics and not self.constant:
            yield Problem("constant", NOTHING, "a constant other than 0, harmonics or a table is needed")

    def _table_problems(self, table: tuple[float, ...]) -> Iterator[Problem]:
        if not LEAST <= len(table) <= MOST or not 0 < np.ptp(table) < math.inf:
            yield Problem("table", table, f"{_TABLE} is accepted")
        elif (error := series(table, self.tolerance).error) > self.tolerance:
            reach = f"{MOST_ORDERS} and a spline through these values differ by {error:.3g} of their range"
            text = f"values that few harmonics join smoothly are accepted: {reach}, more than the key"
            yield Problem("table", table, f"{text} tolerance allows ({self.tolerance:g}, of at most 1)")

    def _phase_problems(self) -> Iterator[Problem]:
        given = [key for key in self.phases if getattr(self, key) is not None]
        words, keys = f"{' or '.join(self.phases)}", ", ".join(self.phases)
        if not self.phases:
            return
        if self.varies and not given:
            yield Problem(self.phases[0], NOTHING, f"one of {keys} is needed: what it varies with")
        elif len(given) > 1:
            yield Problem(given[1], getattr(self, given[1]), f"either {words} is accepted, not both")
        elif given and not self.varies:
            yield Problem(given[0], getattr(self, given[0]), "accepted beside harmonics or a table only")

    @property
    def varies(self) -> bool:
        """Whether it is more than a constant."""
        return bool(self.harmonics) or self.table is not None

    @property
    def terms(self) -> Series:
        """Mean and harmonics, without the factor."""
        if self.table is not None:
            found = series(self.table, self.tolerance)
            return found._replace(mean=found.mean + self.constant)
        return Series(self.constant, tuple((h.order, h.cosine, h.sine) for h in self.harmonics), 0.0)

    def course(self, name: str, timed: bool = False, link: str = "") -> structure.Course:
        """Its structure in the equations."""
        return structure.Course(name, tuple(n for n, _, _ in self.terms.harmonics), timed, link)

    def course_numbers(self, name: str) -> dict[str, float]:
        """Parameters of the equations."""
        mean, harmonics, _ = self.terms
        values = {f"mean_{name}": self.factor * mean}
        for n, a, b in harmonics:
            values |= {f"a_{name}_{n}": self.factor * a, f"b_{name}_{n}": self.factor * b}
        return values

    @property
    def step(self) -> float:
        """Longest step in the phase, rad: at least one in a period of the highest harmonic."""
        return min([_STEP, *(2 * math.pi / n for n, _, _ in self.terms.harmonics)])

    @property
    def course_description(self) -> str:
        """Its values in a few words."""
        mean, harmonics, error = self.terms
        text = [measure(self.factor * mean, self.units)]
        if harmonics:
            text.append(f"with harmonics {', '.join(str(n) for n, _, _ in harmonics)}")
        if self.table is not None:
            text.append(f"of {len(self.table)} values, to {error:.2g} of their range")
        return " ".join(text)
