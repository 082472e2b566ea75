"""Events of a periodic orbit, the speed of approach to each, and the closest approach to others.

An event is about to vanish where its approach speed goes to 0, and another about to appear where the
distance of an open contact (or of a closed one from opening) has a minimum that goes to 0: grazing.
Rows of events are those of `section_map.Image`: contact, kind, place in the orbit, time, state, modes.
"""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace

import numpy as np

from jointplay.analysis.contacts import approach
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Event

OF_GAPS = (Event.IMPACT, Event.CONTACT, Event.SEPARATION, Event.REOPENING)  # causes before effects
BEGINS = (Event.CONTACT, Event.IMPACT)
CONTACT, KIND, PLACE, TIME = range(4)


def _counts(events: np.ndarray) -> Counter:
    """Number of events of each contact and kind."""
    return Counter((int(row[CONTACT]), int(row[KIND])) for row in events)


def same_events(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two orbits have the same events, in whichever order."""
    return _counts(one) == _counts(other)


def changed_event(one: np.ndarray, other: np.ndarray) -> tuple[int, int]:
    """Contact and kind of an event of which one orbit has more than the other; (-1, -1) if there is none.

    Of two that appear together, which are the nearest to each other, the first.
    """
    first, second = _counts(one), _counts(other)
    differing = (first - second) + (second - first)
    rank = {kind: i for i, kind in enumerate(OF_GAPS)}
    event = min(differing, key=lambda pair: (rank.get(pair[1], len(rank)), pair), default=(-1, -1))
    rows = one if len(one) > len(other) else other
    of_contact = [(event[0], int(kind)) in differing for kind in rows[:, KIND]] if len(rows) else []
    near = rows[np.array(of_contact, dtype=bool) & (rows[:, CONTACT] == event[0])]
    if len(near) < 2 or sum(differing.values()) < 2:
        return event
    near = near[np.argsort(near[:, PLACE])]
    apart = np.mod(np.roll(near[:, PLACE], -1) - near[:, PLACE], 1.0)
    return event[0], int(near[np.argmin(apart), KIND])


def gaps(model: Model, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gaps (negative: penetration, m) and closing speeds (m/s) at rows of time, state, modes."""
    start = SimpleNamespace(start=rows[0] if len(rows) else np.zeros(0))
    return approach(model, start, rows)


def approach_speeds(model: Model, events: np.ndarray) -> np.ndarray:
    """Speed at which the gap changes at each event, m/s; NaN at events that no gap makes."""
    if not len(events):
        return np.zeros(0)
    _, rates = gaps(model, events[:, TIME:])
    speeds = np.abs(rates[np.arange(len(events)), events[:, CONTACT].astype(int)])
    return np.where(np.isin(events[:, KIND], OF_GAPS), speeds, np.nan)


def smallest_impact_speed(model: Model, events: np.ndarray) -> float:
    """Smallest speed with which contact begins, m/s; NaN where none does."""
    speeds = approach_speeds(model, events[np.isin(events[:, KIND], BEGINS)])
    return float(speeds.min()) if len(speeds) else np.nan


def closest_approach(values: np.ndarray, events: np.ndarray) -> float:
    """Smallest local minimum of the distance from touching or from opening, m; NaN if there is none.

    Parameters
    ----------
    values : ndarray, shape (samples, contacts)
        Gaps over a whole period in even steps. Minima are those of the parabola through three samples.
    events : ndarray
        Of the orbit: at an event of a contact its gap has no minimum.
    """
    size, count = np.abs(values), len(values)
    before, after = np.roll(size, 1, axis=0), np.roll(size, -1, axis=0)
    minimal = (size <= before) & (size < after)
    for row in events:
        at = int(row[PLACE] * count)
        minimal[np.arange(at - 1, at + 3) % count, int(row[CONTACT])] = False
    if not minimal.any():
        return np.nan
    lowest, _ = vertex(before[minimal], size[minimal], after[minimal])
    return float(max(0.0, lowest.min()))


def vertex(before: np.ndarray, here: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Extremum of the parabola through three samples, and its distance after the middle one, in samples."""
    slope, bend = (after - before) / 2, before - 2 * here + after
    return here - slope**2 / (2 * bend), -slope / bend


def free_phase(events: np.ndarray, turns: int) -> tuple[float, float]:
    """Place in a turn (0 to 1 from the section) farthest from events, and the nearest event's distance."""
    places = np.sort(np.mod(events[:, PLACE] * turns, 1.0)) if len(events) else np.zeros(0)
    if not len(places):
        return 0.0, 1.0
    nearest = float(min(places[0], 1.0 - places[-1]))
    widths = np.diff(np.append(places, places[0] + 1.0))
    widest = int(np.argmax(widths))
    return float((places[widest] + widths[widest] / 2) % 1.0), nearest
