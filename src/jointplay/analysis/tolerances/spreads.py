"""Spreads of numbers as drawings and data sheets give them, and samples of all of them together.

A number is ``normal`` (mean, standard deviation), ``lognormal`` (median, factor: its logarithm is normal with
the standard deviation ln factor), ``uniform``, ``triangular``, one of ``values``, ``within`` the limits of a
drawing, a ``fit`` of ISO 286, or of any distribution of SciPy. What is ``within`` limits low and high is made
by a process of capability C_p = (high - low) / (6 sigma), whose mean is 3 sigma C_pk from the nearer limit,
the upper one; parts beyond a limit are sorted out. The clearance of a fit is half the difference of two
diameters within their limits: sigma^2 = (sigma_hole^2 + sigma_shaft^2) / 4.

Every number is the quantile of a factor, uniform from 0 to 1, by its own distribution (inversion). Numbers of
one batch share a factor; a matrix of correlations is that of the factors' normal scores (Gaussian copula).
Factors are independent pseudo-random numbers, or scrambled points of Sobol's sequence: then every
`REPLICATES`-th sample belongs to the same one of so many independent scramblings, so that samples are the
first part of more samples.
References: ISO 286-1:2010; D. C. Montgomery, Introduction to Statistical Quality Control (2012), chapter 8;
A. B. Owen, SIAM J. Numer. Anal. 34 (1997) 1884; R. B. Nelsen, An Introduction to Copulas (2006).
Validity: the tail beyond a share of `TAIL` at either end is not checked against what the number can be.

Quantities that can be asked of each sample: names, words, units.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, model_validator

from jointplay.analysis.gradients import selection
from jointplay.analysis.rules import alike_beside
from jointplay.analysis.vary import axes, repeated
from jointplay.display.errors import InputError, Problem, join, problems_of, raise_any, strangers, unknown
from jointplay.display.number_text import measure
from jointplay.solver.mechanism.base import Name, Number, Positive, Record, Written, accepts, unit
from jointplay.solver.mechanism.measures import ANY, in_si
from jointplay.solver.mechanism.parameters import INITIAL, Parameter, declared_units
from jointplay.solver.mechanism.parts.fits import limits
from jointplay.solver.mechanism.records import Joint, Mechanism, TestSystem

FORMS = ("normal", "lognormal", "uniform", "triangular", "values", "within", "fit", "scipy")
TAIL = 1e-6
REPLICATES = 16
GRID = 100_000  # quantiles from which moments of what is cut off are
MOST_BITS = 30  # of Sobol's sequence
LEAST_EIGENVALUE = -1e-9  # of a correlation matrix, as far as rounding goes
_WORDS = f"a table of parameters, each with its spread as a table with one of {', '.join(FORMS)},"

OF_JOINT = {
    "force": ("largest joint force", "N"),
    "impact_speed": ("largest normal speed with which contact begins", "m s-1"),
    "pressure": ("largest force over the bearing's projected area", "Pa"),
    "sliding_work": ("normal force times sliding distance per turn", "J"),
    "impact_loss": ("energy lost by normal contact per turn", "J"),
    "friction_loss": ("energy lost by friction per turn", "J"),
}
COUNTED = {"separations": "contacts lost per turn", "impacts": "contacts begun per turn"}
PLAIN = {"period": ("period in turns, 0 for none", "1"), "turn_period": ("mean period of a turn", "s")}


class Spread(Record):
    """The spread of a number.

    Parameters
    ----------
    normal : (float, float), optional
        Mean and standard deviation.
    lognormal : (float, float), optional
        Median, and the factor within which, up and down, 68 % lie.
    uniform : (float, float), optional
        Lowest and highest.
    triangular : (float, float, float), optional
        Lowest, most frequent, highest.
    values, weights : sequence of float, optional
        One of these, each with a weight; without weights all alike.
    within : (float, float), optional
        Limits of a drawing.
    fit, diameter : str and float, optional
        A fit of ISO 286 at a diameter in m, of a radial clearance.
    cp, cpk : float, optional
        Capability of the process behind `within` and `fit`; 1, and the mean in the middle, if left out.
    scipy, parameters : str and dict of str to float, optional
        A continuous distribution of `scipy.stats`, with its parameters by name.
    above, below : float, optional
        The distribution is cut off there.
    """

    normal: tuple[Number, Positive] | None = None
    lognormal: tuple[Positive, Positive] | None = None
    uniform: tuple[Number, Number] | None = None
    triangular: tuple[Number, Number, Number] | None = None
    values: tuple[Number, ...] | None = None
    weights: tuple[Positive, ...] | None = None
    within: tuple[Number, Number] | None = None
    fit: Name | None = None
    diameter: Annotated[Positive, unit("diameter", "m")] | None = None
    cp: Positive | None = None
    cpk: Positive | None = None
    scipy: Name | None = None
    parameters: dict[str, Number] | None = None
    above: Written | None = None
    below: Written | None = None

    @model_validator(mode="before")
    @classmethod
    def _normal_by_another_name(cls, given: Any) -> Any:
        names = given if isinstance(given, Mapping) else ()
        meant = (key for key in names if str(key).lower().startswith("gauss"))
        raise_any(unknown(key, given[key], "normal", FORMS, "distribution") for key in meant)
        return given

    @model_validator(mode="after")
    def _is_one(self) -> Spread:
        raise_any(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        """Problems of fields that do not fit together."""
        given = {name for name, value in self if value is not None}
        forms = [name for name in FORMS if name in given]
        if len(forms) != 1:
            yield Problem("", forms or sorted(given), f"one of {', '.join(FORMS)} is accepted")
            return
        (form,) = forms
        optional = {"values": {"weights"}, "fit": {"diameter", "cp", "cpk"}, "within": {"cp", "cpk"}}
        taken = optional.get(form, {"parameters"} if form == "scipy" else set()) | {form}
        for name in sorted(given - taken - ({"above", "below"} if form != "values" else set())):
            yield Problem(name, getattr(self, name), f"nothing is accepted here beside {form}")
        rising = [*(getattr(self, form) if form in ("uniform", "triangular", "within") else ())]
        if rising != sorted(rising) or (rising and rising[0] == rising[-1]):
            yield Problem(form, rising, "rising numbers are accepted")
        if form == "lognormal" and not self.lognormal[1] > 1:
            yield Problem("lognormal[1]", self.lognormal[1], "a factor above 1 is accepted")
        if form == "values" and (not self.values or len({*self.values}) < len(self.values)):
            yield Problem("values", self.values, "one number or more, each once, is accepted")
        if self.weights is not None and len(self.weights) != len(self.values or ()):
            yield Problem("weights", self.weights, "as many weights as values are accepted")
        if form == "fit" and self.diameter is None:
            yield Problem("diameter", None, "the nominal diameter of pin and hole is needed beside a fit")
        elif form == "fit":
            yield from _fit_fits(self.fit, self.diameter)
        if self.cpk is not None and not self.cpk <= (self.cp or 1.0):
            yield Problem("cpk", self.cpk, f"at most {self.cp or 1.0:g}, which is cp, is accepted")
        if form == "scipy":
            yield from _scipy_fits(self.scipy, self.parameters or {})
        if self.above is not None and self.below is not None and not self.above < self.below:
            yield Problem("below", self.below, f"a number above {self.above:g} is accepted")


def _fit_fits(name: str, diameter: float) -> Iterator[Problem]:
    try:
        found = limits(name, diameter, "fit")
    except InputError as error:
        yield from error.problems
        return
    if found.least < 0:
        yield Problem("fit", name, f"a fit that leaves clearance everywhere is accepted; {found}")


def _scipy_fits(name: str, parameters: Mapping[str, float]) -> Iterator[Problem]:
    from scipy import stats

    known = [each for each in dir(stats) if isinstance(getattr(stats, each), stats.rv_continuous)]
    if name not in known:
        yield unknown("scipy", name, name, known, "distribution")
        return
    family = getattr(stats, name)
    shapes = family.shapes.split(", ") if family.shapes else []
    named = [*shapes, "loc", "scale"]
    yield from (unknown(f"parameters.{k}", v, k, named) for k, v in parameters.items() if k not in named)
    missing = [shape for shape in shapes if shape not in parameters]
    if missing:
        yield Problem("parameters", parameters, f"{', '.join(missing)} of {name} is needed")
    elif not {*parameters} - {*named} and math.isnan(family(**parameters).ppf(0.5)):
        yield Problem("parameters", parameters, f"parameters that {name} of scipy.stats takes are accepted")


def flat(table: Any) -> Any:
    """Tables within tables as one, down to the spreads, keys joined by dots."""
    if not isinstance(table, Mapping):
        return table
    found: dict[str, Any] = {}
    for key, value in table.items():
        tables = isinstance(value, Mapping) and any(isinstance(each, Mapping) for each in value.values())
        nested = tables and not set(value) & {*Spread.model_fields}
        found |= {join(str(key), k): v for k, v in flat(value).items()} if nested else {str(key): value}
    return found


Spreads = Annotated[dict[str, Spread], BeforeValidator(flat), accepts(_WORDS)]


def in_own_units(mechanism: Mechanism | TestSystem, table: Any) -> Any:
    """Bring values with a unit into that of their parameter; `InputError` where it is none of that kind."""
    table = flat(table)
    if not isinstance(table, Mapping):
        return table
    own = {}
    for key in table:
        units = units_of(mechanism, key)
        alike = ("normal", "uniform", "triangular", "values", "within", "above", "below")
        own[key] = dict.fromkeys(alike, units) | {"lognormal": (units, "1"), "diameter": "m"}
        own[key] |= {"parameters": {"loc": units, "scale": units}}
    return in_si(table, own)


def _inside(shares: np.ndarray) -> np.ndarray:
    """Shares of which none is 0 or 1, where quantiles may be infinite."""
    return np.clip(shares, 2.0**-53, 1 - 2.0**-53)


def units_of(mechanism: Mechanism | TestSystem, key: str) -> str:
    """Units of a parameter, or of a state at the start; any of one that does not exist."""
    if not key.startswith(INITIAL):
        return declared_units(mechanism, key)
    return mechanism.units.get(key.removeprefix(INITIAL), "1") if isinstance(mechanism, TestSystem) else ANY


@dataclass(frozen=True)
class Distribution:
    """A distribution by SciPy, cut off where it is."""

    spread: Spread

    @cached_property
    def whole(self) -> Any:
        """The distribution before it is cut off."""
        from scipy import stats

        given = self.spread
        if given.normal:
            return stats.norm(*given.normal)
        if given.lognormal:
            median, factor = given.lognormal
            return stats.lognorm(math.log(factor), scale=median)
        if given.uniform:
            return stats.uniform(given.uniform[0], given.uniform[1] - given.uniform[0])
        if given.triangular:
            low, mode, high = given.triangular
            return stats.triang((mode - low) / (high - low), low, high - low)
        if given.values:
            return None
        if given.scipy:
            return getattr(stats, given.scipy)(**(given.parameters or {}))
        low, high, sigma = self._drawn
        sigma /= given.cp or 1.0
        off = 3 * sigma * ((given.cp or 1.0) - (given.cpk or given.cp or 1.0))
        return stats.norm((low + high) / 2 + off, sigma)

    @cached_property
    def _drawn(self) -> tuple[float, float, float]:
        """Limits of a drawing, and the standard deviation of a process of capability 1 behind them."""
        if self.spread.fit:
            found = limits(self.spread.fit, self.spread.diameter)
            return found.least, found.most, math.hypot(np.ptp(found.hole), np.ptp(found.shaft)) / 12
        low, high = self.spread.within
        return low, high, (high - low) / 6

    @cached_property
    def _ends(self) -> tuple[float, float]:
        """Shares of the whole at which it is cut off."""
        low, high = self._drawn[:2] if self.spread.within or self.spread.fit else (-math.inf, math.inf)
        low = max(low, -math.inf if self.spread.above is None else self.spread.above)
        high = min(high, math.inf if self.spread.below is None else self.spread.below)
        return float(self.whole.cdf(low)), float(self.whole.cdf(high))

    @property
    def kept(self) -> float:
        """Share of the whole that is left."""
        return self._ends[1] - self._ends[0] if self.whole else 1.0

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values below which shares u lie."""
        u = _inside(u)
        if self.whole is None:
            weights = np.array(self.spread.weights or np.ones(len(self.spread.values)), dtype=float)
            at = np.searchsorted(np.cumsum(weights) / weights.sum(), u)
            return np.array(self.spread.values)[np.minimum(at, len(weights) - 1)]
        low, high = self._ends
        return self.whole.ppf(low + u * (high - low))

    def density(self, x: np.ndarray) -> np.ndarray:
        """Density at values, per their unit."""
        low, high = (self.whole.ppf(end) for end in self._ends)
        return np.where((x >= low) & (x <= high), self.whole.pdf(x) / self.kept, 0.0)

    @cached_property
    def median(self) -> float:
        """Median."""
        return float(self.quantile(np.array(0.5)))

    @cached_property
    def deviation(self) -> float:
        """Standard deviation."""
        return float(np.std(self.quantile((np.arange(GRID) + 0.5) / GRID)))

    def narrowed(self, x: np.ndarray, share: float) -> np.ndarray:
        """Ratio of the density of a spread narrowed to a share about its median, to its own, at values."""
        wide = self.median + (x - self.median) / share
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.nan_to_num(self.density(wide) / share / self.density(x))


@dataclass(frozen=True)
class Design:
    """All spreads together.

    Parameters
    ----------
    spreads : dict of str to Spread
        By parameter.
    together : sequence of sequence of str
        Parameters of one batch.
    correlation : sequence of sequence of float, optional
        Of the normal scores of the parameters, in their order.
    sequence : {'sobol', 'random'}
        Where factors come from.
    seed : int
        Of the random numbers.
    """

    spreads: Mapping[str, Spread]
    together: Sequence[Sequence[str]] = ()
    correlation: Sequence[Sequence[float]] | None = None
    sequence: str = "sobol"
    seed: int = 0

    @cached_property
    def laws(self) -> list[Distribution]:
        """Distribution of each parameter."""
        return [Distribution(each) for each in self.spreads.values()]

    @cached_property
    def factors(self) -> list[list[int]]:
        """Numbers of the parameters that share each factor."""
        keys = list(self.spreads)
        found: dict[int, list[int]] = {}
        for i, key in enumerate(keys):
            batch = next((each for each in self.together if key in each), (key,))
            found.setdefault(keys.index(min(batch, key=keys.index)), []).append(i)
        return list(found.values())

    def drawn(self, count: int) -> np.ndarray:
        """Two independent rows of factors for each sample, side by side, shape (count, 2 factors)."""
        from scipy.stats import qmc

        width = 2 * len(self.factors)
        if self.sequence == "random":
            return np.random.default_rng(self.seed).random((count, width))
        rows, each = np.empty((count, width)), -(-count // REPLICATES)
        for number in range(min(REPLICATES, count)):
            random = np.random.default_rng([self.seed, number])
            points = qmc.Sobol(width, scramble=True, bits=MOST_BITS, seed=random)
            part = rows[number::REPLICATES]
            part[:] = points.random_base2(math.ceil(math.log2(max(each, 1))))[: len(part)]
        return rows

    def scores(self, factors: np.ndarray) -> np.ndarray:
        """Normal scores of the parameters' factors, correlated, shape (count, factors)."""
        from scipy import special

        own = special.ndtri(_inside(factors))
        return own if self.correlation is None else own @ self._root.T

    @cached_property
    def _root(self) -> np.ndarray:
        """A square root of the matrix of correlations, lower triangular where it is regular."""
        matrix = np.array(self.correlation, dtype=float)
        try:
            return np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            values, vectors = np.linalg.eigh(matrix)
            return vectors * np.sqrt(np.maximum(values, 0.0))

    def values(self, scores: np.ndarray) -> np.ndarray:
        """Values of the parameters, shape (count, parameters)."""
        from scipy import special

        found, shares = np.empty((len(scores), len(self.laws))), special.ndtr(scores)
        for place, group in enumerate(self.factors):
            for i in group:
                found[:, i] = self.laws[i].quantile(shares[:, place])
        return found

    def changes(self, values: np.ndarray) -> list[dict[str, float]]:
        """Changes of the mechanism for each sample."""
        return [dict(zip(self.spreads, row, strict=True)) for row in values.tolist()]


def spreads_fit(mechanism: Mechanism | TestSystem, spreads: Spreads | None) -> Iterator[Problem]:
    """Yield the problems of parameters that do not exist, and of values that they cannot have."""
    if spreads is None:
        return
    if not spreads:
        yield Problem("spreads", spreads, f"{_WORDS} is accepted")
    yield from repeated([key for key in spreads if not key.startswith(INITIAL)], "spreads")
    for key, spread in spreads.items():
        place, law = join("spreads", key), Distribution(spread)
        if not law.kept > 0:
            yield Problem(
                place, spread.model_dump(exclude_none=True), "a spread that is not all cut off is accepted"
            )
            continue
        ends = law.quantile(np.array([TAIL, 0.5, 1 - TAIL])) if law.whole else np.array(spread.values)
        if key.startswith(INITIAL):
            yield from _state_fits(mechanism, key, place)
            continue
        found = problems_of(axes, mechanism, {key: sorted({*ends.tolist()})}, "spreads")
        yield from alike_beside(mechanism, place, [key], ends.tolist())
        if law.whole and not any(p.key == place for p in found):
            given, units = spread.model_dump(exclude_none=True), parameter_words(mechanism, key)[1]
            far = "{}; one in a million is beyond {}: above and below cut a spread off"
            own = ((p, far.format(p.expected, measure(p.given, units))) for p in found)
            found = [replace(p, given=given, expected=text) for p, text in own]
        yield from (replace(p, key=place) for p in found)


def _state_fits(mechanism: Mechanism | TestSystem, key: str, place: str) -> Iterator[Problem]:
    name = key.removeprefix(INITIAL)
    if isinstance(mechanism, Mechanism):
        yield Problem(place, key, "starts are accepted of a test system or of own equations, no linkage")
    elif name not in mechanism.states:
        yield unknown(place, key, name, mechanism.states, "state")


def dependence_fits(
    spreads: Spreads, together: Sequence[Sequence[str]], correlation: Sequence[Sequence[float]] | None
) -> Iterator[Problem]:
    """Yield the problems of batches, and of a matrix that is no correlation."""
    members = [key for batch in together for key in batch]
    for i, batch in enumerate(together):
        yield from strangers(((f"together[{i}]", key) for key in batch), [*spreads], "parameter")
        if len({*batch}) < 2 or any(members.count(key) > 1 for key in batch):
            yield Problem(f"together[{i}]", batch, "two parameters or more, each in one batch, are accepted")
    if correlation is None:
        return
    size, accepted = len(spreads), "is accepted, in the order of the spreads"
    if together:
        yield Problem("correlation", correlation, "either together or correlation is accepted")
    if len(correlation) != size or any(len(row) != size for row in correlation):
        yield Problem("correlation", correlation, f"a matrix of {size} rows of {size} numbers {accepted}")
        return
    matrix = np.array(correlation, dtype=float)
    if np.any(matrix != matrix.T) or np.any(np.diag(matrix) != 1) or np.any(np.abs(matrix) > 1):
        yield Problem("correlation", correlation, f"a symmetric matrix with 1 on its diagonal {accepted}")
    elif (least := float(np.linalg.eigvalsh(matrix)[0])) < LEAST_EIGENVALUE:
        expected = f"a matrix without negative eigenvalues {accepted}; the least one is {least:.3g}"
        yield Problem("correlation", correlation, expected)


def parameter_words(mechanism: Mechanism | TestSystem, key: str) -> tuple[str, str]:
    """Noun and units, as a dataset has them, of a parameter or a state at the start."""
    if key.startswith(INITIAL):
        return f"{key.removeprefix(INITIAL)} at the start", units_of(mechanism, key)
    found = Parameter(mechanism, key)
    return found.noun, found.cf_units


def known_quantities(mechanism: Mechanism | TestSystem) -> list[str]:
    """Names of all quantities of a sample: those of `gradient`, and of contacts."""
    inside = [
        name for name in selection.known_quantities(mechanism) if name.partition(":")[0] in selection.POINTS
    ]
    if isinstance(mechanism, TestSystem):
        return [*PLAIN, *COUNTED, *inside]
    joints, free = mechanism.contacts, [joint.name for joint in mechanism.joints if joint.ideal]
    own = [f"{word}:{name}" for word in (*COUNTED, *OF_JOINT) for name in joints]
    return [*PLAIN, *own, *(f"force:{name}" for name in free), *inside]


def joint_of(mechanism: Mechanism, name: str) -> Joint:
    """The joint whose contact a quantity is of."""
    return next(each for each in mechanism.joints if name.partition(":")[2] in each.contacts)


def words_of(name: str) -> tuple[str, str]:
    """Name of a quantity, and its units."""
    head, _, label = name.partition(":")
    if head in selection.POINTS:
        found = selection.quantity(name)
        return found.noun, found.units
    text, units = (PLAIN | OF_JOINT | {key: (each, "1") for key, each in COUNTED.items()})[head]
    return f"{text}, {label}" if label else text, units
