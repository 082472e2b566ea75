"""Properties of whole spans of a motion, at any sampling: contacts, share of contact, largest sizes.

Contacts are those of the integrator's list of events. Largest sizes are those at the integrator's own points,
both sides of every event, and at even times that depend on the spans alone, with a parabola through the top.
The same points give each force's extremes between its samples.

A short contact has few points, too few for a parabola through its force. Its states are known with their
rates: about the largest point they are interpolated by a polynomial through it and both neighbours, and the
force is evaluated there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from jointplay.analysis.contacts import ROW, TIME, begun
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.quantities import WORDS
from jointplay.display import codes
from jointplay.display.number_text import measure, plain
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Mode
from jointplay.solver.motion.trajectory import Records

Spans = Sequence[tuple[float, float]]  # from, to, in s, ascending and apart
History = tuple[np.ndarray, dict[str, Any]]  # times, s, and variables
Sizes = dict[str, np.ndarray]  # by name of the quantity
COARSE, FINER = 720, 5  # even times in a turn, and how many times as many in short spans
MANY, MOST = 16_384, 2_000_000  # even times in all: beyond the first no finer ones, beyond the second none
BLOCK = 100_000  # rows evaluated at once
UNEVEN = 0.01  # of the longer of two intervals: a shorter one is not used for a parabola
LOW = 0.5  # of the largest point: lower ones are not looked about
HIGHEST, CLOSE = 32, 16  # points about which a largest size is sought, and interpolated states about each
NORMAL, ACROSS, PINS = "normal_force", "tangential_force", "reaction"
OUTS = {
    "recorded_time": Out((), "time that counts and largest sizes are of", "s"),
    "contacts_begun": Out((), "contacts begun in the recorded time"),
    "contact_fraction": Out("joint", "share of the recorded time in contact"),
    "LARGEST_QUANTITY": Out(
        (),
        "largest sizes of the forces that are recorded, as ``largest_force``, or of the first quantity",
        "",
    ),
    "HIGHEST_QUANTITY": Out("time", "highest values of recorded forces since the sample before", ""),
    "LOWEST_QUANTITY": Out("time", "lowest values of recorded forces since the sample before", ""),
}


def even_times(spans: Spans, period: float) -> np.ndarray | None:
    """Times at which largest sizes are sought; None where they would be too many to keep.

    Of long spans they are those of a history that is sampled as usual, which then serves both.
    """
    turns = sum(b - a for a, b in spans) / period
    if turns * COARSE > MOST:
        return None
    per_turn = COARSE * min(FINER, max(1, round(MANY / COARSE / max(turns, 1e-300))))
    counts = [max(1, round((b - a) / period * per_turn)) for a, b in spans]
    return np.concatenate([evenly(a, b, n) for (a, b), n in zip(spans, counts, strict=True)])


def evenly(begin: float, end: float, count: int) -> np.ndarray:
    """Times from a begin to an end, in so many equal parts; of none, the begin."""
    return np.minimum(begin + np.arange(count + 1) * (end - begin) / max(count, 1), end)


def between(steps: np.ndarray, period: float) -> np.ndarray:
    """Mask of the integrator's points that even times may miss: sides of events, ends of short steps.

    Along a step that is longer than two of their distances a motion is smooth, and the parabola has the top.
    """
    gaps = np.diff(steps[:, ROW], prepend=-np.inf, append=np.inf)
    return np.minimum(gaps[:-1], gaps[1:]) < 2.0 * period / COARSE


def sized(names: Sequence[str]) -> tuple[str, ...]:
    """The recorded quantities whose largest sizes are stated: forces, or the first quantity."""
    forces = tuple(name for name in (NORMAL, ACROSS, PINS) if name in names and name != ACROSS)
    if not forces:
        return tuple(name for name in names if name not in ("mode", ACROSS))[:1]
    return (*forces, ACROSS) if NORMAL in forces and ACROSS in names else forces


def reached(spans: Spans, records: Records) -> Spans:
    """The spans as far as the motion came."""
    end = float(records.end[0])
    return [(a, min(b, end)) for a, b in spans if a < end]


def contacts(model: Model, records: Records, spans: Spans) -> dict[str, Any]:
    """Values of the spans' length, the contacts begun in them, and each joint's share of contact."""
    hits, length = begun(model, records.events)[:, TIME], sum(b - a for a, b in spans)
    values = {"recorded_time": length}
    if model.gaps:
        values["contacts_begun"] = np.int64(sum(np.sum((a <= hits) & (hits <= b)) for a, b in spans))
    if model.links and model.joints and length > 0:
        values["contact_fraction"] = sum(_touching(model, records, *span) for span in spans) / length
    return values


def _touching(model: Model, records: Records, begin: float, end: float) -> np.ndarray:
    """Time in contact of each joint, s; an event is listed with the modes just before it."""
    after = np.concatenate([records.events[:, ROW:], records.end[None, :]])
    edges = np.clip(np.concatenate([[begin], after[:, 0]]), begin, end)
    edges[-1] = end
    return np.diff(edges) @ (Quantities(model, after, records.start).modes > Mode.RELEASED)


def extremes(
    own: Quantities, even: Quantities, names: Sequence[str], spans: Spans, history: History, shared: bool
) -> dict[str, dict[str, Any]]:
    """Groups of variables: largest sizes of quantities, and each force's extremes between samples.

    Of the integrator's own points, and at the `even_times`; `history` are samples' times, s, and variables,
    `shared` where they are at these. The largest size of the resultant stands for the tangential force's.
    """
    times, known = history
    tops: Sizes = {}
    dims: dict[str, tuple[str, ...]] = {}
    high = {name: known[name][1].copy() for name in names if name in (NORMAL, ACROSS, PINS)}
    low = {name: each.copy() for name, each in high.items()}
    for points, samples in _blocks(own.time, even.time, spans):
        found = own.of(points).variables(names, "time")
        there = known if shared else even.of(samples).variables(names, "time")
        at = np.searchsorted(even.time[samples], own.time[points])
        order = np.insert(even.time[samples], at, own.time[points])
        part = samples if shared else slice(None)
        values = {n: np.insert(there[n][1][part], at, each[1], axis=0) for n, each in found.items()}
        sizes = _sizes_of(values)
        dims = {name: each[0][1:] for name, each in found.items()}
        dims["force"] = dims.get(NORMAL, ())
        rows = np.insert(even.rows[samples], at, own.rows[points], axis=0)
        largest, sizes = peaks(own, rows, sizes)
        tops = {name: np.fmax(tops.get(name, np.nan), most) for name, most in largest.items()}
        values |= {name: np.copysign(sizes[name], values[name]) for name in high.keys() & sizes.keys()}
        last = np.searchsorted(times, order)
        inside = last < len(times)
        for name, each in high.items():
            np.fmax.at(each, last[inside], values[name][inside])
            np.fmin.at(low[name], last[inside], values[name][inside])
    made = {
        name: Out(dims[name], *_named(name)).variable(most) for name, most in tops.items() if np.size(most)
    }
    groups = {"LARGEST_QUANTITY": {f"largest_{name}": each for name, each in made.items()}}
    for word, extreme in (("highest", high), ("lowest", low)):
        said = {name: f"{word} {WORDS[name].long_name} since the sample before" for name in extreme}
        groups[f"{word.upper()}_QUANTITY"] = {
            f"{word}_{name}": Out(known[name][0], said[name], "N").variable(each)
            for name, each in extreme.items()
        }
    return groups


def _sizes_of(values: dict[str, np.ndarray]) -> Sizes:
    """Sizes of quantities; that of the resultant in place of the tangential force's."""
    sizes = {name: np.abs(each) for name, each in values.items()}
    if ACROSS in sizes:
        sizes["force"] = np.hypot(sizes[NORMAL], sizes.pop(ACROSS))
    return sizes


def peaks(given: Quantities, rows: np.ndarray, sizes: Sizes) -> tuple[Sizes, Sizes]:
    """Largest sizes of quantities over rows of a motion, of each joint where they are of joints.

    Also the sizes, the highest of which are those of the tops beside them.
    """
    most = {name: top(np.moveaxis(size, 0, -1), rows[:, 0]) for name, size in sizes.items()}
    forces = [name for name in (NORMAL, PINS, "force") if name in sizes and given.model.links]
    each = ((name, j, size) for name in forces for j, size in enumerate(sizes[name].T))
    wanted = {(name, j): _tops(size, rows[:, 0]) for name, j, size in each}
    indices = np.unique(np.concatenate([np.empty(0, dtype=int), *wanted.values()]))
    places, near = _around(given.model, rows, indices)
    if not len(places):
        return most, sizes
    sizes = {name: size.copy() for name, size in sizes.items()}
    names = [name for name in (NORMAL, ACROSS, PINS) if name in sizes or (name != PINS and "force" in sizes)]
    close = Quantities(given.model, np.concatenate(near), given.start).variables(names, "time")
    highest = {
        name: top(each.reshape(*near.shape[:2], -1).swapaxes(1, 2), near[:, None, :, 0])
        for name, each in _sizes_of({name: each[1] for name, each in close.items()}).items()
    }
    for (name, j), tops in wanted.items():
        known = tops[np.isin(tops, places)]
        sizes[name][known, j] = highest[name][np.searchsorted(places, known), j]
        most[name][j] = max(sizes[name][tops, j], default=most[name][j])
    return most, sizes


def _tops(sizes: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Places of the highest of the points that no neighbour exceeds: the largest may lie beside another.

    The two sides of an event are no neighbours: where they differ by rounding alone both may be tops.
    """
    inner = np.nan_to_num(sizes, nan=-np.inf)
    apart = np.diff(times) > 0
    before = np.append(-np.inf, np.where(apart, inner[:-1], -np.inf))
    after = np.append(np.where(apart, inner[1:], -np.inf), -np.inf)
    least = LOW * max(inner.max(initial=0.0), np.finfo(float).tiny)
    at = np.flatnonzero((inner >= before) & (inner >= after) & (inner >= least))
    return at[np.argsort(inner[at], kind="stable")[-HIGHEST:]]


def _around(model: Model, rows: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places among three rows of one piece, and the states there, between these rows.

    A place is the middle one, or an end of the piece. Positions are the polynomial of fifth degree through
    the three rows that has their speeds; speeds are its slope, and all else is the parabola through the rows.
    """
    half, first = len(model.turning), 1 + len(model.state)
    modes = slice(first, first + len(model.touching))
    three, known = np.empty((len(places), 3, rows.shape[1])), np.zeros(len(places), dtype=bool)
    for begin in (-1, -2, 0):
        at = np.flatnonzero(~known & (places + begin >= 0) & (places + begin + 2 < len(rows)))
        near = rows[places[at, None] + begin + np.arange(3)]
        gaps = np.diff(near[..., 0])
        smooth = (gaps.min(-1) > UNEVEN * gaps.max(-1)) & ~np.ptp(near[..., modes], axis=1).any(-1)
        three[at[smooth]], known[at[smooth]] = near[smooth], True
    three = three[known]
    scale, powers = np.diff(three[..., 0]).max(-1)[:, None, None], np.arange(6)
    s = (three[..., :1] - three[:, 1:2, :1]) / scale
    fine = np.linspace(s[:, 0], s[:, 2], CLOSE + 1, axis=1)

    def slopes(s: np.ndarray) -> np.ndarray:
        return powers * s ** np.maximum(powers - 1, 0)

    place, speed = slice(1, 1 + half), slice(1 + half, 1 + 2 * half)
    given = np.concatenate([three[..., place], scale * three[..., speed]], axis=1)
    course = np.linalg.solve(np.concatenate([s**powers, slopes(s)], axis=1), given)
    near = fine ** powers[:3] @ np.linalg.solve(s ** powers[:3], three)
    near[..., place] = fine**powers @ course
    near[..., speed] = slopes(fine) @ course / scale
    near[..., modes] = three[:, 1:2, modes]
    return places[known], near


def top(sizes: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The largest of sizes along their last axis, or the top of the parabola through it and both neighbours.

    Between two pieces lies an event, whose two sides have the same time: no parabola goes across it.
    """
    if sizes.shape[-1] < 3:
        return np.fmax.reduce(sizes, axis=-1, initial=np.nan)
    times = np.broadcast_to(times, sizes.shape)
    at = np.argmax(np.nan_to_num(sizes, nan=-np.inf), axis=-1)[..., None]
    largest = np.take_along_axis(sizes, at, -1)[..., 0]
    three = np.clip(at, 1, sizes.shape[-1] - 2) + np.arange(-1, 2)
    before, after = np.moveaxis(np.diff(np.take_along_axis(times, three, -1)), -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        rise, fall = np.moveaxis(np.diff(np.take_along_axis(sizes, three, -1)), -1, 0) / (before, after)
        bend = (rise - fall) / (before + after)
        slope = (rise * after + fall * before) / (before + after)
        higher = largest + slope**2 / (4.0 * bend)
    even = np.minimum(before, after) > UNEVEN * np.maximum(before, after)
    return np.where((at[..., 0] == three[..., 1]) & even & (bend > 0.0), higher, largest)


def _named(name: str) -> tuple[str, str]:
    if name == "force":
        return "largest force at a joint with clearance, normal and tangential together", "N"
    return f"largest size of {WORDS[name].long_name}", WORDS[name].units


def _blocks(own: np.ndarray, even: np.ndarray, spans: Spans) -> Iterator[tuple[slice, slice]]:
    """Places of own points and of even samples, block by block of each span, by their times."""
    for begin, end in spans:
        first, stop = np.searchsorted(even, begin), np.searchsorted(even, end, side="right")
        since, last = np.searchsorted(own, begin), np.searchsorted(own, end, side="right")
        for place in range(first, stop, BLOCK):
            beyond = min(place + BLOCK, stop)
            until = np.searchsorted(own, even[beyond]) if beyond < stop else last
            yield slice(since, until), slice(place, beyond)
            since = until


def answer(dataset: xr.Dataset) -> str:
    """Largest force of each joint of a motion, and the rate and duration of contacts."""
    lines = [line for line in (_forces(dataset) or _sizes(dataset), _contacts(dataset)) if line]
    span = float(np.ptp(dataset["time"].values)) if dataset.sizes["time"] else 0.0
    return "\n".join(lines) or f"{dataset.sizes['time']} samples over {measure(span, 's')}"


def _forces(dataset: xr.Dataset) -> str:
    whole, normal = _each(dataset, "largest_force"), _each(dataset, "largest_normal_force")
    notes = {
        name: f" (normal {normal[name]})" for name in whole if normal.get(name, whole[name]) != whole[name]
    }
    contact = [f"{name} {size}{notes.get(name, '')}" for name, size in (whole or normal).items()]
    ideal = [f"{name} {size}" for name, size in _each(dataset, "largest_reaction").items()]
    kinds = {"contact": contact, "ideal joints": ideal}
    found = [f"{kind} {', '.join(known)}" for kind, known in kinds.items() if known]
    what = "normal forces" if contact and not whole else "forces"
    return f"largest {what}: {'; '.join(found)}" if found else ""


def _each(dataset: xr.Dataset, name: str) -> dict[str, str]:
    """The known values of a variable in words, by their labels."""
    if name not in dataset or dataset[name].ndim > 1:
        return {}
    array = dataset[name]
    units = str(array.attrs.get("units", "1"))
    labels = array[array.dims[0]].values if array.ndim and array.dims[0] in array.coords else [""]
    pairs = zip(labels, np.atleast_1d(array.values), strict=False)
    return {codes.contact(str(label)): measure(float(v), units, 3) for label, v in pairs if np.isfinite(v)}


def _sizes(dataset: xr.Dataset) -> str:
    """Largest sizes of a quantity that is no force."""
    names = [name for name in dataset.data_vars if str(name).startswith("largest_")]
    each = next(filter(None, (_each(dataset, name) for name in names)), {})
    text = str(dataset[names[0]].attrs.get("long_name", names[0])) if each else ""
    return f"{text}: {', '.join(f'{name} {size}'.strip() for name, size in each.items())}" if each else ""


def _contacts(dataset: xr.Dataset) -> str:
    if "recorded_time" not in dataset:
        return ""
    parts, turns = [], float(dataset["recorded_time"]) / float(dataset.get("turn_period_nominal", math.nan))
    if turns > 0 and "contacts_begun" in dataset:
        parts.append(f"contacts begun per nominal turn: {plain(int(dataset['contacts_begun']) / turns, 3)}")
    if "contact_fraction" in dataset:
        loose = dataset["contact_fraction"].values
        names = map(codes.contact, dataset["joint"].values)
        each = [f"{n} {plain(100 * s, 3)} %" for n, s in zip(names, loose, strict=True) if np.isfinite(s)]
        parts += [f"share of the time in contact: {', '.join(each)}"] if each else []
    return "; ".join(parts)
