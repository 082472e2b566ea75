"""Answers of motions: histories, section points, signals, and settled motions over a parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import TYPE_CHECKING

import numpy as np

from jointplay.analysis.exponents.batch_means import CHAOTIC, FOLLOWING, decided
from jointplay.analysis.period import period
from jointplay.display.number_text import plain
from jointplay.display.units import measure
from jointplay.study.results.answers import stretches

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

TOLERANCE = 1e-4  # of a clearance, or of a coordinate's size: spread of section points that count as one
ROUNDING = 1e-12
LASTS = 0.01  # share of a parameter over which the end of chaos lasts; what is narrower is a window


def response(dataset: Dataset) -> str:
    """Return the largest force of each joint, and the rate and duration of contacts."""
    lines = [line for line in (_forces(dataset) or _sizes(dataset), _contacts(dataset)) if line]
    return "\n".join(lines) or f"{dataset.sizes['time']} samples over {measure(_span(dataset), 's')}"


def _span(dataset: Dataset) -> float:
    times = dataset["time"].values
    return float(times[-1] - times[0]) if len(times) else 0.0


def _forces(dataset: Dataset) -> str:
    normal = "force" if "largest_force" in dataset else "normal_force"
    found = []
    for name, kind in ((normal, "contact"), ("reaction", "ideal joints")):
        known = [text for text in _each(dataset, f"largest_{name}") if text]
        found += [f"{kind} {', '.join(known)}"] if known else []
    what = "normal forces" if "largest_normal_force" in dataset and normal != "force" else "forces"
    return f"largest {what}: {'; '.join(found)}" if found else ""


def _each(dataset: Dataset, name: str) -> list[str]:
    """The known values of a variable with their labels."""
    if name not in dataset or dataset[name].ndim > 1:
        return []
    array = dataset[name]
    units = str(array.attrs.get("units", "1"))
    labels = array[array.dims[0]].values if array.ndim and array.dims[0] in array.coords else [""]
    pairs = zip(labels, np.atleast_1d(array.values), strict=False)
    return [f"{label} {measure(float(v), units, 3)}".strip() for label, v in pairs if np.isfinite(v)]


def _sizes(dataset: Dataset) -> str:
    """Largest sizes of a quantity that is no force."""
    names = [name for name in dataset.data_vars if str(name).startswith("largest_")]
    each = next(filter(None, (_each(dataset, name) for name in names)), [])
    text = str(dataset[names[0]].attrs.get("long_name", names[0])) if each else ""
    return f"{text}: {', '.join(each)}" if each else ""


def _contacts(dataset: Dataset) -> str:
    if "recorded_time" not in dataset:
        return ""
    parts, turns = [], float(dataset["recorded_time"]) / float(dataset.get("turn_period_nominal", math.nan))
    if turns > 0 and "contacts_begun" in dataset:
        parts.append(f"contacts begun per nominal turn: {plain(int(dataset['contacts_begun']) / turns, 3)}")
    if "contact_fraction" in dataset:
        loose = dataset["contact_fraction"].values
        names = dataset["joint"].values
        each = [f"{n} {plain(100 * s, 3)} %" for n, s in zip(names, loose, strict=True) if np.isfinite(s)]
        parts += [f"in contact {', '.join(each)} of the time"] if each else []
    return "; ".join(parts)


def section(dataset: Dataset) -> str:
    """Return the period of the section points, or that they show none."""
    count, points = dataset.sizes["turn"], _points(dataset)
    if points is None or count < 4:
        return f"{count} section points"
    found = period(points, TOLERANCE)
    if not found:
        return f"no period in {count} section points: a longer period, a transient, or no periodic motion"
    spread = max(float(np.ptp(points[rest::found], axis=0).max()) for rest in range(found))
    near = "rounding" if spread < ROUNDING else plain(spread, 1)
    of = "of the clearance" if "journal_x" in dataset else "of each coordinate's size"
    return f"period {found}: {count} section points, equal to {near} {of}"


def _points(dataset: Dataset) -> np.ndarray | None:
    """Section points by coordinates: journals over their clearances, else states or speeds over sizes."""
    if "clearance" in dataset and {"journal_x", "journal_y"} <= set(dataset.data_vars):
        parts = [dataset[name].values / dataset["clearance"].values for name in ("journal_x", "journal_y")]
        return np.hstack(parts)
    name = next((name for name in ("state_value", "angular_velocity") if name in dataset), None)
    if name is None:
        return None
    values = dataset[name].transpose("turn", ...).values
    return values / np.maximum(np.nanmax(np.abs(values), axis=0, initial=0.0), 1e-300)


def bifurcation_verdict(dataset: Dataset) -> DataArray:
    """Return of each point its period; without one ``chaotic``, if the exponent says so by its error."""
    from xarray import where

    period = dataset["period"]
    none = where(period == 0, "no period found", "not known")
    if "section_exponent_per_turn" in dataset or "lyapunov_exponent_per_turn" in dataset:
        word, dim = (
            ("section", "multiplier") if "section_exponent_per_turn" in dataset else ("lyapunov", "exponent")
        )
        value, error = (
            dataset[f"{word}_{each}_per_turn"].isel({dim: 0}) for each in ("exponent", "standard_error")
        )
        sure = decided(value, error) == CHAOTIC
        if "section_batch_correlation" in dataset:
            sure &= ~(dataset["section_batch_correlation"].isel(multiplier=0) > FOLLOWING)
        none = where((period == 0) & sure, CHAOTIC, none)
    known = [f"period {n}" if n > 0 else "" for n in range(int(max(period.max(), 0)) + 1)]
    named = period.copy(data=np.array(known)[np.maximum(period.values, 0)])
    words = where(period > 0, named, none)
    return where(dataset["cell_status"] == 0, words, stretches.FAILED)


def bifurcation(dataset: Dataset) -> str:
    """Return the settled motions over the parameter, direction by direction where they differ."""
    if "period" not in dataset:
        every = [str(dim) for dim in dataset["cell_status"].dims if dim not in ("start", "direction")]
        return "\n".join(stretches.failures(dataset, every))
    return "\n".join([*_told(dataset), *_saved(dataset)])


def _saved(dataset: Dataset) -> list[str]:
    """Line on the values that an adaptive map computed, and the rest."""
    if "computed" not in dataset:
        return []
    done, size = int(dataset["computed"].sum()), dataset["computed"].size
    share = plain(100 * done / size, 3)
    return [f"{done} of {size} values computed ({share} %); the nearest of these stand for the others"]


def _told(dataset: Dataset) -> list[str]:
    """Lines on the motions of all points."""
    verdict = bifurcation_verdict(dataset)
    beside = [dim for dim in ("start", "direction") if dim in verdict.dims]
    dims = [str(dim) for dim in verdict.dims if dim not in beside]
    lines = stretches.failures(dataset, dims)
    stacked = verdict.transpose(*beside, *dims).values.reshape(-1, *(dataset.sizes[dim] for dim in dims))
    names = _ways(verdict, beside)
    axes = [dataset[dim] for dim in dims]
    if all(np.array_equal(stacked[0], other) for other in stacked[1:]):
        return [*lines, stretches.told(stacked[0], axes), *_windows(stacked[0], axes)]
    for name, each in zip(names, stacked, strict=True):
        lines += [f"{name}: {line}" for line in (stretches.told(each, axes), *_windows(each, axes))]
    if (differ := _differ(stacked)).any():
        at = f"at {np.count_nonzero(differ)} of {differ.size} values{stretches.places(differ, axes)}"
        lines.append(f"motions coexist {at}")
    return lines


def _windows(words: np.ndarray, axes: Sequence[DataArray]) -> list[str]:
    """A line on the stretches in chaos, along one parameter, that are too narrow to be an end of it."""
    if len(axes) != 1 or not np.issubdtype(axes[0].dtype, np.number):
        return []
    chaos, values = np.flatnonzero(words == CHAOTIC), axes[0].values
    units = str(axes[0].attrs.get("units", "1"))
    pairs = [(a, b) for a, b in pairwise(chaos) if b > a + 1 and stretches.FAILED not in words[a + 1 : b]]
    narrow = [(a, b) for a, b in pairs if abs(values[b] - values[a]) <= LASTS * abs(values[a])]
    each = []
    for a, b in narrow[: stretches.NAMED]:
        ends = " to ".join(measure(values[i], units, 5) for i in (a, b))
        each.append(f"{ends} ({', '.join(sorted({*words[a + 1 : b]}))})")
    more = f" and {len(narrow) - len(each)} more" if len(narrow) > len(each) else ""
    what = f"windows in chaos, no end of it, which would last {plain(100 * LASTS, 2)} %"
    return [f"{what}: {', '.join(each)}{more}"] if each else []


def _differ(words: np.ndarray) -> np.ndarray:
    """Mask of places at which two sweeps, along the first axis, have different motions, both known."""
    known = (words == CHAOTIC) | np.char.startswith(words, "period ")
    pairs = combinations(range(len(words)), 2)
    apart = ((words[a] != words[b]) & known[a] & known[b] for a, b in pairs)
    return np.logical_or.reduce([*apart, np.zeros(words.shape[1:], dtype=bool)])


def _ways(verdict: DataArray, beside: Sequence[str]) -> list[str]:
    """Names of the sweeps along directions and starts."""
    names = [""]
    for dim in beside:
        labels = verdict[dim].values if dim in verdict.coords else range(verdict.sizes[dim])
        named = [str(label) if dim == "direction" else f"start {label}" for label in labels]
        names = [f"{name} {each}".strip() for name in names for each in named]
    return names
