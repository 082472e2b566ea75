"""What holds for whole spans of a motion, whatever is sampled: contacts, share of contact, largest sizes.

Contacts are those of the integrator's list of events. Largest sizes are those at the integrator's own points,
both sides of every event, and at even times that depend on the spans alone, with a parabola through the top.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from jointplay.analysis import rates
from jointplay.analysis.contacts import CONTACT, IMPACT, KIND, ROW, TIME
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.labels import described
from jointplay.analysis.quantities import WORDS
from jointplay.analysis.trajectory import Records
from jointplay.mechanism.model import Model
from jointplay.numerics.codes import Mode

Spans = Sequence[tuple[float, float]]  # from, to, in s, ascending and apart
FINE, COARSE = 4096, 720  # even times in a turn: of short spans, and at least
MANY, MOST = 16_384, 2_000_000  # even times in all: beyond the first coarser ones, beyond the second none
BLOCK = 100_000  # rows evaluated at once
UNEVEN = 0.01  # of the longer of two intervals: a shorter one is not used for a parabola
NORMAL, ACROSS, PINS = "normal_force", "tangential_force", "reaction"


def even_times(spans: Spans, period: float) -> np.ndarray | None:
    """Times at which largest sizes are looked for; None where they would be too many to keep."""
    turns = sum(b - a for a, b in spans) / period
    per_turn = min(FINE, max(COARSE, MANY / max(turns, 1e-300)))
    if turns * per_turn > MOST:
        return None
    counts = [max(1, round((b - a) / period * per_turn)) for a, b in spans]
    return np.concatenate([np.linspace(a, b, n + 1) for (a, b), n in zip(spans, counts, strict=True)])


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
    """Variables of the spans' length, the contacts begun in them, and each joint's share of contact."""
    rows, length = records.events, sum(b - a for a, b in spans)
    hits = rows[np.isin(rows[:, KIND], (CONTACT, IMPACT)), TIME]
    table = {"recorded_time": ((), length, "s", "time that counts and largest sizes are of")}
    if model.touching:
        begun = np.int64(np.count_nonzero(_within(hits, spans)))
        table["contacts_begun"] = ((), begun, "1", "contacts begun in the recorded time")
    if model.links and model.joints and length > 0:
        share = sum(_touching(model, records, *span) for span in spans) / length
        table["contact_fraction"] = ("joint", share, "1", "share of the recorded time in contact")
    return described(table)


def _touching(model: Model, records: Records, begin: float, end: float) -> np.ndarray:
    """Time in contact of each joint, s; an event is listed with the modes just before it."""
    after = np.concatenate([records.events[:, ROW:], records.end[None, :]])
    edges = np.clip(np.concatenate([[begin], after[:, 0]]), begin, end)
    edges[-1] = end
    return np.diff(edges) @ (Quantities(model, after, records.start).modes > Mode.RELEASED)


def largest(
    model: Model, rtol: float, records: Records, samples: np.ndarray, names: Sequence[str], spans: Spans
) -> dict[str, Any]:
    """Variables of the largest sizes of quantities, with the resultant in place of the tangential force.

    `samples` are those of the records at the `even_times`.
    """
    tops: dict[str, np.ndarray] = {}
    dims: dict[str, tuple[str, ...]] = {}
    for rows in _blocks(records.steps[:, ROW:], samples, spans):
        found = rates.quantities(model, rtol, records, rows).variables(names, "time")
        sizes = {name: np.abs(values) for name, (_, values, _) in found.items()}
        dims = {name: own[1:] for name, (own, _, _) in found.items()}
        if ACROSS in sizes:
            sizes["force"] = np.hypot(sizes[NORMAL], sizes.pop(ACROSS))
            dims["force"] = dims[NORMAL]
        for name, size in sizes.items():
            tops[name] = np.fmax(tops.get(name, np.nan), np.apply_along_axis(_top, 0, size, rows[:, 0]))
    return described(
        {f"largest_{name}": (dims[name], top, *_named(name)) for name, top in tops.items() if np.size(top)}
    )


def _top(sizes: np.ndarray, times: np.ndarray) -> float:
    """The largest of the sizes, or the top of the parabola through it and both neighbours in one piece.

    Between two pieces lies an event, whose two sides have the same time.
    """
    if np.isnan(sizes).all():
        return np.nan
    at = int(np.nanargmax(sizes))
    before, after = np.diff(times[at - 1 : at + 2]) if 0 < at < len(sizes) - 1 else (0.0, 0.0)
    if not min(before, after) > UNEVEN * max(before, after):
        return sizes[at]
    rise, fall = np.diff(sizes[at - 1 : at + 2]) / (before, after)
    bend = (rise - fall) / (before + after)
    slope = (rise * after + fall * before) / (before + after)
    return sizes[at] + slope**2 / (4.0 * bend) if bend > 0.0 else sizes[at]


def _named(name: str) -> tuple[str, str]:
    if name == "force":
        return "N", "largest force at a joint with clearance, normal and tangential together"
    return WORDS[name].units, f"largest size of {WORDS[name].long_name}"


def _blocks(steps: np.ndarray, samples: np.ndarray, spans: Spans) -> Iterator[np.ndarray]:
    """Rows of the integrator's points and of samples within the spans, in order of time."""
    steps, samples = (rows[_within(rows[:, 0], spans)] for rows in (steps, samples))
    order = np.argsort(np.concatenate([steps[:, 0], samples[:, 0]]), kind="stable")
    for first in range(0, len(order), BLOCK):
        here = order[first : first + BLOCK]
        points = here < len(steps)
        rows = np.concatenate([steps[here[points]], samples[here[~points] - len(steps)]])
        yield rows[np.argsort(rows[:, 0], kind="stable")]


def _within(times: np.ndarray, spans: Spans) -> np.ndarray:
    inside = [(a <= times) & (times <= b) for a, b in spans]
    return np.any([np.zeros(len(times), dtype=bool), *inside], axis=0)  # of no spans, none
