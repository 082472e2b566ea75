"""Correlation dimension of a motion's section points: how their correlation sum grows.

The motion's own dimension in state space is that of its section plus one.

C(r) is the share of pairs of points closer than r, pairs closer in time than Theiler's window left out; where
C(r) ~ r^D, D is the correlation dimension. Pairs are counted by SciPy's trees. References: P. Grassberger and
I. Procaccia, Physica D 9 (1983) 189-208; J. Theiler, Phys. Rev. A 34 (1986) 2427-2432.

D is the slope of ln C over ln r where C lies in a stated range. Its error is the larger of two: the spread of
the slopes over quarters of that range, for sets that do not scale evenly or bend it at their edges; and the
standard error from quarters of the series, for the chance of these points. Pairs grow with the square of the
points, so the latter is up to twice too large.

Validity: N points tell dimensions up to some 2 log10 N (J.-P. Eckmann and D. Ruelle, Physica D 56 (1992)
185-187), and only if the range lies well below the size of the set and above its noise. A set with edges
comes out low: a uniform square, whose C is π r² - (8/3) r³ + r⁴/2, by 0.09 at C = 0.03.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, Unpack

import numpy as np
from pydantic import AfterValidator

from jointplay.analysis.declared import Outputs, values_of
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import Cut, Moving, Quantities, Share, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.poincare import poincare
from jointplay.analysis.rules import section_fits
from jointplay.analysis.signals.observable import MOVED, observable, series
from jointplay.display.errors import refuse
from jointplay.display.number_text import with_error
from jointplay.solver.mechanism.base import Natural, accepts
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import part, ticked

FLOOR, PER_DECADE = 1e-3, 32  # radii: from this share of the set's size on, so many a decade
BLOCK = 512  # points whose neighbours are counted between two looks
PARTS = 4  # of the range, and of the series
FEWEST = 3  # radii that make a slope


class Slope(NamedTuple):
    """Dimension, its spread over parts of the range, its standard error, radii at the ends of the range."""

    dimension: float
    spread: float
    standard_error: float
    radii: tuple[float, float]

    @property
    def error(self) -> float:
        """The larger of spread and standard error, as far as they are known."""
        return float(np.fmax(self.spread, self.standard_error))


NOTHING = Slope(math.nan, math.nan, math.nan, (math.nan, math.nan))


def radii(points: np.ndarray) -> np.ndarray:
    """Radii in even ratios, up to the largest extent of the set in a coordinate."""
    size = float(np.ptp(points, axis=0).max())
    return size * np.geomspace(FLOOR, 1, round(-PER_DECADE * math.log10(FLOOR)) + 1)


def correlation_sum(points: np.ndarray, at: np.ndarray, window: int) -> np.ndarray:
    """Share of pairs no farther apart than each radius.

    Parameters
    ----------
    points : ndarray, shape (points, coordinates)
        In the order of time.
    at : ndarray
        Radii, ascending.
    window : int
        Pairs fewer than so many points apart in time are left out; 1 leaves out none.
    """
    from scipy.spatial import cKDTree

    tree, count = cKDTree(points), len(points)
    blocks = (tree.indices[i : i + BLOCK] for i in range(0, count, BLOCK))  # of points near each other
    close = sum(cKDTree(points[block]).count_neighbors(tree, at) for block in ticked(blocks))
    close -= count  # each pair twice, and each point with itself
    total = count * (count - 1)
    for lag in ticked(range(1, window)):
        apart = np.linalg.norm(points[lag:] - points[:-lag], axis=1)
        close -= 2 * np.searchsorted(np.sort(apart), at, side="right")
        total -= 2 * (count - lag)
    return close / total


def fit(
    points: np.ndarray, at: np.ndarray, sums: np.ndarray, shares: tuple[float, float], window: int
) -> Slope:
    """Slope of the correlation sum `sums` at the radii `at` where it lies between two shares of the pairs.

    Points that lie in so few places that even the smallest radius holds more than the greater share have
    dimension 0; where too few radii fall into the range, there is none (NaN).
    """
    if sums[0] >= shares[1]:
        return Slope(0.0, 0.0, 0.0, (float(at[0]), float(at[-1])))
    inside = (sums >= shares[0]) & (sums <= shares[1])
    if inside.sum() < PARTS * FEWEST:
        return NOTHING
    used, of_them = at[inside], sums[inside]
    quarters = np.array_split(np.arange(len(used)), PARTS)
    spread = np.std([_slope(used[part], of_them[part]) for part in quarters], ddof=1)
    parts = np.array_split(points, PARTS)
    of_parts = [_slope(used, correlation_sum(part, used, window)) for part in parts]
    error = np.std(of_parts, ddof=1) / math.sqrt(PARTS)
    return Slope(_slope(used, of_them), float(spread), float(error), (float(used[0]), float(used[-1])))


def _slope(at: np.ndarray, sums: np.ndarray) -> float:
    there = sums > 0
    if there.sum() < 2:
        return math.nan
    return float(np.polyfit(np.log(at[there]), np.log(sums[there]), 1)[0])


WINDOW, TOLERANCE = 10, 1e-4
USUAL = {"rtol": 1e-10, "turns": 5000}  # noise of a periodic motion then stays below the tolerance
SHARES = (1e-4, 3e-2)
LEAST = 100  # points that can be judged
_SHARES = "a pair of rising shares of the pairs, between 0 and 1,"


def answer(result: xr.Dataset) -> str:
    """The correlation dimension with its error."""
    value = float(result["correlation_dimension"])
    if math.isnan(value):
        return "the correlation dimension is not known: too few pairs of points lie within the range"
    points = f"of {int(result['n_points'])} section points"
    if value == 0:
        return f"correlation dimension 0 {points}: they lie in a few places, as those of a periodic motion do"
    names = [f"correlation_dimension_{each}" for each in ("spread", "standard_error")]
    error = float(np.fmax(*(float(result[name]) for name in names)))
    return f"correlation dimension {with_error(value, error)} {points}; that of the motion itself is one more"


NAME = "correlation dimension"


OUTPUTS = Outputs(
    "dimension",
    {
        "radius": Out("radius", "distance in standard deviations"),
        "bound": Out("bound", "end of the range", ""),
    },
    {
        "correlation_dimension": Out((), NAME),
        "correlation_dimension_spread": Out(
            (),
            f"spread of the {NAME} over its range",
            about="standard deviation of the slopes of four parts of the range",
        ),
        "correlation_dimension_standard_error": Out(
            (), f"standard error of the {NAME}", about="from four parts of the series"
        ),
        "correlation_dimension_error": Out((), f"error of the {NAME}, the larger of the two"),
        "correlation_sum": Out("radius", "share of pairs closer than the radius"),
        "local_slope": Out("radius", "slope of the correlation sum"),
        "fit_radius": Out("bound", "ends of the range of the slope"),
        "n_points": Out((), "section points"),
        "n_coordinates": Out((), "coordinates that vary"),
    }
    | RUN,
    answer,
    shown={"correlation_dimension": ""},
)


def _quantities_fit(mechanism: Mechanism | TestSystem, quantities: tuple[str, ...] | None) -> None:
    _named(mechanism, quantities)


def _rising(shares: tuple[float, float]) -> tuple[float, float]:
    if not 0 < shares[0] < shares[1]:
        raise refuse(shares, f"{_SHARES} is accepted")
    return shares


@analysis(_quantities_fit, deferred=[section_fits, "model"], usual=USUAL, outputs=OUTPUTS)
def dimension(
    mechanism: Moving,
    *,
    quantities: Quantities | None = None,
    window: Natural = WINDOW,
    shares: Annotated[tuple[Share, Share], AfterValidator(_rising), accepts(_SHARES)] = SHARES,
    tolerance: Share = TOLERANCE,
    **motion: Unpack[Cut],
) -> xr.Dataset:
    """Give the correlation dimension of a motion's section points.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    quantities : sequence of str, optional
        Coordinates of the points, such as ``journal_x`` or ``angular_velocity:rocker``; of a test system,
        states. Each is measured in units of its standard deviation. By default the journals' places and the
        links' angular velocities (and deflections, where links bend), or all states.
    window : int
        Theiler window: pairs of points fewer than so many apart in time are left out.
    shares : pair of float
        Range of the correlation sum over which its slope is taken.
    tolerance : float
        A coordinate that spreads less than this fraction of its largest value counts as constant and is left
        out. If all do, the points are one, of dimension 0.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    chosen = _named(mechanism, quantities)
    run = motion | {"progress": part(motion["progress"], 0.0, MOVED)}
    record = list(dict.fromkeys(word for word, _ in chosen))
    cut = poincare(mechanism, record=record, **run)
    points = np.stack([series(cut, *one).values for one in chosen], axis=-1)
    found = _measured(points, shares, window, tolerance, int(cut.status))
    return OUTPUTS.dataset(found | values_of(cut, RUN), **cut.attrs)


def _named(mechanism: Mechanism | TestSystem, quantities: tuple[str, ...] | None) -> list[tuple[str, str]]:
    names = _coordinates(mechanism) if quantities is None else quantities
    if not names:
        raise refuse(names, "a list of at least one name is accepted", "quantities")
    return [observable(mechanism, name, f"quantities[{i}]") for i, name in enumerate(names)]


def _coordinates(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    if isinstance(mechanism, TestSystem):
        return mechanism.observed
    found = [f"{word}:{joint}" for joint in mechanism.contacts for word in ("journal_x", "journal_y")]
    found += [f"angular_velocity:{link.name}" for link in mechanism.links]
    return (*found, *(f"deflection:{link.name}" for link in mechanism.elastic_links))


def scaled(points: np.ndarray, tolerance: float) -> np.ndarray:
    """Coordinates that vary, in units of their standard deviations."""
    varies = np.ptp(points, axis=0) > tolerance * np.max(np.abs(points), axis=0)
    return points[:, varies] / np.std(points[:, varies], axis=0)


def _measured(points: np.ndarray, shares, window: int, tolerance: float, status: int) -> dict[str, Any]:
    """Correlation sum and its slope; NaN where there are too few points."""
    used = np.zeros((len(points), 0))
    least, slope = max(LEAST, 2 * PARTS * window), NOTHING
    at = sums = np.zeros(0)
    if not status and len(points) >= least and np.all(np.isfinite(points)):
        used, slope = scaled(points, tolerance), Slope(0.0, 0.0, 0.0, (np.nan, np.nan))
    if used.shape[1]:
        at = radii(used)
        sums = correlation_sum(used, at, window)
        slope = fit(used, at, sums, tuple(shares), window)
    return {
        "radius": at,
        "bound": ["lower", "upper"],
        "correlation_dimension": slope.dimension,
        "correlation_dimension_spread": slope.spread,
        "correlation_dimension_standard_error": slope.standard_error,
        "correlation_dimension_error": slope.error,
        "correlation_sum": sums,
        "local_slope": _local(at, sums),
        "fit_radius": np.array(slope.radii),
        "n_points": np.int64(len(points)),
        "n_coordinates": np.int64(used.shape[1]),
    }


def _local(at: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """Slope over an eighth of a decade around each radius."""
    if not len(at):
        return np.zeros(0)
    with np.errstate(divide="ignore", invalid="ignore"):
        y = np.log(sums)
        rise = y[_AROUND:] - y[:-_AROUND]
    middle = np.where(np.isfinite(rise), rise, np.nan) / np.log(at[_AROUND] / at[0])
    return np.pad(middle, _AROUND // 2, constant_values=np.nan)


_AROUND = PER_DECADE // 8
