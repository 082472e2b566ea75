"""The condition of two events at one time: slip reverses where contact begins or ends, and is gone in flight.

With s the speed of sliding and h the guard of the contact's beginning or end, at time t: g = s(t), over its
own size. With M the tangents up to t, dg = (grad s - s'/h' grad h) M dx + (ds - s'/h' dh)/dp dp. Points lie
SHORT of the curve, on that side on which slip does not reverse: there the orbit's events are the same ones.
Assumptions: the state does not jump at the event (a contact with a force). Validity: contact begins or ends
with a speed, h' is not 0.
Reference: di Bernardo et al., Piecewise-smooth Dynamical Systems (2008), chapter 8.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from jointplay.analysis.curves.grazing import EARLIER, SHORT, Meeting, slopes, spacing
from jointplay.analysis.curves.margins import OF_SLIDING, PLACES, SLIDE, Guards
from jointplay.analysis.orbits.family import Family, Point, Trial
from jointplay.analysis.orbits.orbit_events import CONTACT, KIND, OF_GAPS, PLACE, TIME
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Mode

SIDES = {Mode.SLIP_POSITIVE: 1.0, Mode.SLIP_NEGATIVE: -1.0}


@dataclass(frozen=True)
class Coincidence(Meeting):
    """A slip reversal at the beginning or the end of its contact.

    Parameters
    ----------
    contact : int
        Whose.
    kind : int
        Of the event that goes on beyond the curve.
    size : float
        Largest speed of sliding, by which it is divided; with the sign that it has in contact.
    event : tuple of int
        Contact and kind of the event that vanishes.
    """

    contact: int
    kind: int
    size: float
    event: tuple[int, int]
    sided = False

    def value(self, trial: Trial, like: Point) -> float:
        """The sliding speed at the event over its size, less `SHORT`; NaN where the event is missing."""
        row = self._row(trial.section.model, trial.image.events, like)
        if row is None:
            return np.nan
        return float(sliding(trial.section.model, row[None], self.contact)[0, 0]) / self.size - SHORT

    def gradient(self, family: Family, trial: Trial, like: Point) -> np.ndarray:
        """Its derivatives in the coordinates x/c and the fractions of the ranges."""
        row = self._row(trial.section.model, trial.image.events, like)
        found = None
        if row is not None:
            found = slopes(family, trial, like, row[0], partial(sliding, contact=self.contact))
        if found is None:
            return np.full(len(trial.section.free) + family.count, np.nan)
        values, rows, rates = found
        with np.errstate(divide="ignore", invalid="ignore"):
            fires = 1 + int(np.nanargmin(np.abs(values[1:] / rates[1:])))
            return (rows[0] - rates[0] / rates[fires] * rows[fires]) / self.size

    def _row(self, model: Model, events: np.ndarray, like: Point) -> np.ndarray | None:
        """Time, state and modes of the event that is the same as that of a point of the curve."""
        own, others = (
            rows[(rows[:, CONTACT] == self.contact) & (rows[:, KIND] == self.kind)]
            for rows in (like.orbit.image.events, events)
        )
        if not len(own) or len(own) != len(others):
            return None
        slips = sliding(model, own[:, TIME:], self.contact)[:, 0]
        apart = np.abs(others[:, PLACE] - own[np.argmin(np.abs(slips)), PLACE])
        return others[np.argmin(np.minimum(apart, 1 - apart)), TIME:]


def sliding(model: Model, rows: np.ndarray, contact: int) -> np.ndarray:
    """Speed of sliding, gap and force of a contact as if it touched, at rows of time, state, modes."""
    touching = rows.copy()
    touching[:, 1 + len(model.state) + contact] = Mode.SLIP_POSITIVE
    first = PLACES * contact
    return Guards(model).values(touching)[:, [first + SLIDE, first, first + 1]]


def coincident(orbit: Orbit, event: tuple[int, int]) -> tuple[float, Coincidence] | None:
    """The beginning or end of a contact with the slowest sliding, and that speed over its largest.

    None if slip has no part in the event that vanishes, or is not followed there.
    """
    (contact, kind), section, model = event, orbit.map, orbit.map.model
    events, guards = orbit.image.events, Guards(model)
    own = events[(events[:, CONTACT] == contact) & np.isin(events[:, KIND], OF_GAPS)]
    if kind not in OF_SLIDING or contact >= guards.contacts or not len(own):
        return None
    speeds = np.abs(sliding(model, own[:, TIME:], contact)[:, 0])
    row = own[int(np.argmin(speeds))]
    beside = EARLIER * spacing(section, orbit.image) * np.array([-1.0, 1.0])
    rows, status = section.sampled(orbit.state, row[TIME] + beside, False)
    modes = rows[:, 1 + len(model.state) + contact].astype(int)
    sides = [SIDES[mode] for mode in modes if mode in SIDES]
    near = guards.nearest(section, orbit.state, orbit.image.time, events)
    if status or near is None or not sides:
        return None
    size = float(near[2][PLACES * contact + SLIDE])
    return float(speeds.min() / size), Coincidence(contact, int(row[KIND]), sides[0] * size, event)
