"""Guards along a motion, as the flow watches them, and their margins before they fire.

The margin of a guard is the number that reaches zero where it fires: a gap in flight, the force or the
penetration in contact, the speed of sliding, the distance from the friction cone. It is evaluated by the
structure's own compiled functions on recorded states.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial

from jointplay.analysis.orbits.orbit_events import CONTACT, KIND, OF_GAPS, TIME, vertex
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Event
from jointplay.solver.motion.trajectory import Request, memory

SAMPLES = 720  # a turn
STAGES = (0.5, 1 / 32)  # spacings of the five samples, in those, through which an extremum is interpolated
FIVE = np.arange(-2.0, 3.0)
SLIDE, PLACES = 2, 4  # of a contact's guards
OF_SLIDING = (Event.SLIP_REVERSAL, Event.STICK_ONSET, Event.SLIP_ONSET)


@dataclass
class Guards:
    """The guards of a model.

    Parameters
    ----------
    model : Model
        Whose.
    """

    model: Model
    contacts: int = field(init=False)

    def __post_init__(self):
        self._module = cache.structure_module(self.model.structure)
        self._work, self._motion, self._options = memory(self.model, Request(1.0))
        self.contacts = len(self._motion.flags)

    def margins(self, rows: np.ndarray) -> np.ndarray:
        """Margins at rows of time, state, modes; shape (rows, guards); NaN where a guard is not watched."""
        from jointplay.solver.method.events import side_of

        motion, found = self._motion, self.values(rows)
        for modes, own in self._stretches(rows):
            found[own] *= [side_of(g, modes, motion.flags) or np.nan for g in range(len(motion.fired))]
        return found

    def values(self, rows: np.ndarray) -> np.ndarray:
        """The guards' numbers with their signs, as the modes of each row give them; shape (rows, guards)."""
        from jointplay.solver.method.modes import mask, variant_of

        work, motion, options = self._work, self._motion, self._options
        width, last = 1 + len(self.model.state), 8 * (options.guards + np.arange(len(motion.fired))) + 7
        found = np.empty((len(rows), len(motion.fired)))
        for modes, own in self._stretches(rows):
            variant = variant_of(modes)
            mask(modes, motion.m)
            work.w[:] = 0.0  # the increments; and guards that are not watched in these modes
            for row, numbers in zip(rows[own], found[own], strict=True):
                motion.s[:width] = row[:width]
                self._module.trig(motion.s, motion.p)
                self._module.rate(variant, work.w, motion.s, motion.p, motion.m)
                numbers[:] = work.w[last]
        return found

    def _stretches(self, rows: np.ndarray) -> Iterator[tuple[np.ndarray, slice]]:
        """Contact modes, and the rows one after another that have them."""
        first = 1 + len(self.model.state)
        modes = rows[:, first : first + len(self._motion.modes)].astype(self._motion.modes.dtype)
        changes = 1 + np.flatnonzero(np.any(modes[1:] != modes[:-1], axis=1))
        for begin, end in pairwise((0, *changes, len(rows))):
            yield modes[begin], slice(begin, end)

    def owner(self, guard: int) -> int:
        """Number of the contact, or wall, of a guard, as in rows of events."""
        if guard < PLACES * self.contacts:
            return guard // PLACES
        walls = len(self._motion.modes) - self.contacts
        return self.contacts + (guard - PLACES * self.contacts) % walls

    def kinds(self, guard: int) -> tuple[int, ...]:
        """Kinds of the events that a guard makes."""
        gaps = (PLACES - 1) * self.contacts + len(self._motion.modes)  # and after them the friction of walls
        sliding = guard % PLACES >= SLIDE if guard < PLACES * self.contacts else guard >= gaps
        return OF_SLIDING if sliding else OF_GAPS

    def count(self, guard: int, events: np.ndarray) -> int:
        """Number of an orbit's events that are of a guard's contact and kinds."""
        return int(
            np.sum((events[:, CONTACT] == self.owner(guard)) & np.isin(events[:, KIND], self.kinds(guard)))
        )

    def nearest(self, section: SectionMap, state: np.ndarray, duration: float, events: np.ndarray):
        """Local minimum of each guard's margin that is nearest to zero, its time, and the margin's size.

        Minima are those of the parabola through three samples: by the samples alone a farther one may win.
        """
        count = section.turns * SAMPLES
        times = section.begin + np.arange(count) / count * duration
        rows, status = section.sampled(state, times, False)
        if status:
            return None
        margins = self.margins(rows)
        before, after = np.roll(margins, 1, axis=0), np.roll(margins, -1, axis=0)
        with np.errstate(invalid="ignore"):
            minimal = (margins <= before) & (margins < after)
            sizes = np.nanmax(np.abs(margins), axis=0, initial=0.0, where=np.isfinite(margins))
        for row in events:
            at = int((row[TIME] - section.begin) / duration * count)
            contact, kind = int(row[CONTACT]), int(row[KIND])
            own = [self.owner(g) == contact and kind in self.kinds(g) for g in range(len(sizes))]
            minimal[np.ix_(np.arange(at - 1, at + 3) % count, np.flatnonzero(own))] = False
        least, shift = np.full_like(margins, np.inf), np.zeros_like(margins)
        least[minimal], shift[minimal] = vertex(before[minimal], margins[minimal], after[minimal])
        where, own = np.argmin(np.abs(least), axis=0), np.arange(len(sizes))
        return np.abs(least[where, own]), times[where] + shift[where, own] * duration / count, sizes

    def minimum(
        self, section: SectionMap, state: np.ndarray, guard: int, near: float, spacing: float, turn: float
    ) -> tuple[float, float] | None:
        """Local minimum of a guard's margin, and its time, from a time near it; None where there is none.

        The quartic through five samples, the second time through closer ones.
        """
        time, value = near, np.nan
        for share in STAGES:
            step = share * spacing
            time += turn if time - 2 * step < section.begin else 0.0
            rows, status = section.sampled(state, time + step * FIVE, False)
            margins = self.margins(rows)[:, guard] if not status else np.full(5, np.nan)
            if not np.all(np.isfinite(margins)):
                return None
            quartic = Polynomial(np.linalg.solve(np.vander(FIVE, increasing=True), margins))
            roots = quartic.deriv().roots()
            inside = roots[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) <= 2.5)].real
            if not len(inside):
                return None
            best = inside[np.argmin(quartic(inside))]
            time, value = time + step * best, float(quartic(best))
        return value, time
