"""What a periodic orbit meets: its events, how fast it comes to each, and how near it comes to others.

An event is about to vanish where its approach speed goes to 0, and another about to appear where the
distance of an open contact (or of a closed one from opening) has a minimum that goes to 0: grazing.
Rows of events are those of `section_map.Image`: contact, kind, place in the orbit, time, state, modes.
"""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace

import numpy as np

from jointplay.analysis.contacts import approach
from jointplay.analysis.quantities import EVENTS
from jointplay.mechanism.model import Model

WALLS = [EVENTS.index(name) for name in ("contact", "separation", "reopening", "impact")]
BEGINS = [EVENTS.index(name) for name in ("contact", "impact")]
FIRST = ("impact", "contact", "separation", "reopening")  # whose birth or death explains that of others
CONTACT, KIND, PLACE, TIME = range(4)


def word(events: np.ndarray) -> Counter:
    """How many events of each contact and kind."""
    return Counter((int(row[CONTACT]), int(row[KIND])) for row in events)


def changed(one: np.ndarray, other: np.ndarray) -> tuple[int, int]:
    """Contact and kind of an event of which one orbit has more than the other; (-1, -1) if there is none."""
    first, second = word(one), word(other)
    found = [*((first - second) + (second - first))]
    order = [EVENTS.index(name) for name in FIRST]
    rank = {kind: place for place, kind in enumerate(order)}
    return min(found, key=lambda pair: (rank.get(pair[1], len(order)), pair), default=(-1, -1))


def gaps(model: Model, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gaps (negative: penetration, m) and closing speeds (m/s) at rows of time, state, modes."""
    start = SimpleNamespace(start=rows[0] if len(rows) else np.zeros(0))
    return approach(model, start, rows)


def approach_speeds(model: Model, events: np.ndarray) -> np.ndarray:
    """Speed at which the gap changes at each event, m/s; NaN where the event is no matter of a gap."""
    if not len(events):
        return np.zeros(0)
    _, rates = gaps(model, events[:, TIME:])
    found = np.abs(rates[np.arange(len(events)), events[:, CONTACT].astype(int)])
    return np.where(np.isin(events[:, KIND], WALLS), found, np.nan)


def smallest_impact_speed(model: Model, events: np.ndarray) -> float:
    """Smallest speed with which contact begins, m/s; NaN where none does."""
    found = approach_speeds(model, events[np.isin(events[:, KIND], BEGINS)])
    return float(found.min()) if len(found) else np.nan


def closest_approach(values: np.ndarray, events: np.ndarray) -> float:
    """Smallest distance from touching, or from opening, that is turned back from, m; NaN if there is none.

    Parameters
    ----------
    values : ndarray, shape (samples, contacts)
        Gaps over a whole period in even steps. Minima are those of the parabola through three samples.
    events : ndarray
        Of the orbit: where a contact has one, its gap does not turn back.
    """
    size, count = np.abs(values), len(values)
    before, after = np.roll(size, 1, axis=0), np.roll(size, -1, axis=0)
    turned = (size <= before) & (size < after)
    for row in events:
        at = int(row[PLACE] * count)
        turned[np.arange(at - 1, at + 3) % count, int(row[CONTACT])] = False
    if not turned.any():
        return np.nan
    a, b, c = before[turned], size[turned], after[turned]
    lowest = b - (a - c) ** 2 / (8 * (a - 2 * b + c))
    return float(max(0.0, lowest.min()))


def free_phase(events: np.ndarray, turns: int) -> tuple[float, float]:
    """Where in a turn (0 to 1 from the section) events are farthest, and how near the section they come."""
    places = np.sort(np.mod(events[:, PLACE] * turns, 1.0)) if len(events) else np.zeros(0)
    if not len(places):
        return 0.0, 1.0
    near = float(min(places[0], 1.0 - places[-1]))
    widths = np.diff(np.append(places, places[0] + 1.0))
    widest = int(np.argmax(widths))
    return float((places[widest] + widths[widest] / 2) % 1.0), near
