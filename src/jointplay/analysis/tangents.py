"""A motion followed with tangents, by the flow of variations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from jointplay.solver.codegen import cache
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.directions import Directions
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.method.codes import Mode
from jointplay.solver.motion.trajectory import Request, advance, memory, prepare, row

# An estimated error E of a vibration, of order 8, stands for a true one of some E^(14/8)/2, of order 14 (with
# the five stages of lanes alike): so a step errs by 100 rtol at most.
SAFE, FOLLOWED = 20.0, 8 / 14
# of it, where slopes of forces jump or begin as a root or logarithm: orders are no better there
ROUGH = 1.5e-3
APART = 1e-7  # of its terms: a change of a gap beyond rounding
DUE = 1e-4  # of the period: an event that rounding puts before or behind a time is passed
TINY = 1e-200  # length of a tangent of which nothing is left
TIGHT = 1e-13  # tolerance of the tangents' iteration where their map itself is wanted


@lru_cache(maxsize=256)
def variations(structure: Linkage | Oscillator, directions: tuple[tuple[str, ...], ...] = ()) -> tuple:
    """The compiled derivatives of a structure's functions."""
    from jointplay.solver.method.interface import Variations, pointers

    return pointers(cache.variation_module(structure, directions), kind=Variations)


def scales(model: Model) -> np.ndarray:
    """Size of each state, in whose units tangents are measured."""
    return model.absolute * (1 + model.relative / SPEED_FLOOR)


def measures(model: Model) -> np.ndarray:
    """Scales of the states for growth: infinite for memories of loop groups, which follow from the rest."""
    found = scales(model)
    found[len(found) - model.guesses :] = np.inf
    return found


def tolerated(structure: Linkage | Oscillator, rtol: float) -> float:
    """Estimated error of tangents that a step may have, relative to their length."""
    rough = isinstance(structure, Linkage) and any(joint.rough for joint in structure.joints)
    return SAFE * rtol**FOLLOWED * (ROUGH if rough else 1.0)


@dataclass
class Bundle:
    """A run with tangents, which goes on at each `advance`: arrays, options, functions.

    Parameters
    ----------
    model, request
        As in `trajectory.follow`.
    frame : ndarray
        Initial tangents, shape (vectors, states).
    tolerance : float
        Of the tangents' iteration, relative to their length.
    saltation : bool
        False leaves the jumps at events out (a comparison, not a result).
    held : bool
        True: the frame is not made orthonormal, so that it becomes the tangent map's image of itself.
    rows : int
        Recorded rows after which `advance` comes back.
    neutral : bool
        Whether the first tangent is the rate of the state itself, which is then evaluated
        (method.tangents.tangent).
    directions : Directions, optional
        Parameters in which the state is differentiated too: by as many tangents, after those of the frame.
    """

    model: Model
    request: Request
    frame: np.ndarray
    tolerance: float = TIGHT
    saltation: bool = True
    held: bool = False
    rows: int = 1
    neutral: bool = False
    directions: Directions | None = None

    def __post_init__(self):
        from jointplay.solver.method.tangents import tangent

        self._names = self.directions.names if self.directions else ()
        prepare(self.model.structure, "tangents.tangent_flow")
        variations(self.model.structure, self._names)
        self.at = tangent  # the names of its places
        rows = cache.variation_module(self.model.structure, self._names).ROWS
        self.work, self.motion, self.options = memory(self.model, self.request)
        frame, driven = np.asarray(self.frame, dtype=float), ()
        if self.directions:
            self.motion = self.motion._replace(p=np.concatenate([self.motion.p, self.directions.rates]))
            driven = np.append(np.zeros(len(frame)), np.arange(1, 1 + len(self.directions)))
            frame = np.vstack([frame, self.directions.starts])
        held = self.held or self.directions is not None
        given = frame, (scales if held else measures)(self.model), self.options.n, rows, self.rows
        units = self.directions.units if self.directions else ()
        self.tangents = tangent.tangents(*given, driven, units, len(self.motion.work), len(self.motion.s))
        count = {tangent.SALTATION: self.saltation, tangent.HELD: held, tangent.NEUTRAL: self.neutral}
        for place, value in count.items():
            self.tangents.count[place] = value
        real = {tangent.TOLERANCE: self.tolerance, tangent.GRAZING: np.inf}
        real |= {tangent.LIMIT: tolerated(self.model.structure, self.request.rtol)}
        real |= {tangent.BLOCK: np.inf, tangent.NEXT: np.inf}
        for place, value in real.items():
            self.tangents.real[place] = value

    def advance(self, until: float = np.inf, tell: Callable[[], None] | None = None) -> int:
        """Go on until that time, or the rows are full, or the run ends; give back which it was (method.flow).

        `tell` is called after each piece of the run (motion.trajectory).
        """
        structure, options = self.model.structure, self.options
        derivatives = variations(structure, self._names)
        options = options._replace(t_end=min(options.t_end, float(until)))
        return advance(structure, self.work, self.motion, options, derivatives, self.tangents, tell)

    def join(self, other: Bundle) -> None:
        """Go on along the motion of another run of the same model, with the own frame.

        Where only one of both has gone through an event that is due, both go a little past it first.
        """
        from jointplay.solver.method.memory import EVENTS

        self.advance(other.time)
        if self.motion.count[EVENTS] != other.motion.count[EVENTS]:
            past = other.time + DUE * self.model.period
            other.advance(past)
            self.advance(past)
        if self.motion.count[EVENTS] == other.motion.count[EVENTS]:
            for own, given in zip(self.motion, other.motion, strict=True):
                own[...] = given
            self.work.past[:] = other.work.past

    def forget(self) -> None:
        """Take memories of laws of contact out of the frame; begin it anew where nothing else is left."""
        d = self.tangents.d.reshape(len(self.tangents.alive), -1)[:, 1:]
        memories = slice(d.shape[1] - self.model.followers, d.shape[1] - self.model.guesses)
        if d[:, memories].any():
            d[:, memories] = 0.0
            R = np.linalg.qr((d * self.tangents.weight).T, mode="r")
            d[:] = np.linalg.solve(R.T, d) if np.abs(np.diag(R)).min() > TINY else self.frame

    def record(self, block: float) -> None:
        """From here on, record a row after each `block` of time."""
        self.tangents.real[self.at.BLOCK] = block
        self.tangents.real[self.at.NEXT] = self.time + block

    def row(self) -> np.ndarray:
        """A row as recorded ones, of where the run stands; shape (1, columns)."""
        places = [self.at.TRACE, self.at.VOLUME, self.at.UNRESOLVED]
        sums = self.tangents.real[places], self.tangents.logs
        return np.concatenate([[self.time], *sums, self.state])[None, :]

    @property
    def full(self) -> int:
        """Number that `advance` gives back when the rows are full."""
        from jointplay.solver.method.control import FULL

        return FULL

    @property
    def time(self) -> float:
        """Time that the motion has reached, s."""
        return float(self.motion.s[0])

    @property
    def logs(self) -> slice:
        """The logarithms' columns in a row, after time, trace, volume, time by volume; the state follows."""
        return slice(self.at.AHEAD, self.at.AHEAD + len(self.tangents.alive))

    @property
    def carried(self) -> slice:
        """The logarithms' columns of all directions but the motion's own."""
        return slice(self.logs.start + self.neutral, self.logs.stop)

    @property
    def grazing(self) -> float:
        """Smallest relative approach speed of a guard at an event so far."""
        return float(self.tangents.real[self.at.GRAZING])

    def taken(self) -> np.ndarray:
        """The rows recorded since the last call."""
        rows = self.tangents.rows[: self.tangents.count[self.at.ROWS]].copy()
        self.tangents.count[self.at.ROWS] = 0
        return rows

    @property
    def state(self) -> np.ndarray:
        """Positions and speeds where the run stands."""
        return self.motion.s[1 : 1 + len(self.motion.absolute)].copy()

    def rate(self) -> np.ndarray:
        """Rate of the state where the run stands."""
        return rate(self.model.structure, self.work, self.motion, self.options)

    def powers(self) -> np.ndarray:
        """Rates of the works where the run stands, of a model without a section."""
        first = self.options.guards + len(self.motion.fired)
        return _rows(self.model.structure, self.work, self.motion)[first : first + len(self.motion.work)]

    @property
    def recorded(self) -> np.ndarray:
        """Present state of the run, as a record's row: time, positions, speeds, modes, works."""
        return row(self.motion)

    @property
    def vectors(self) -> np.ndarray:
        """The tangents, shape (vectors, states)."""
        return self.tangents.d.reshape(-1, 1 + len(self.motion.absolute))[:, 1:].copy()

    def opened(self) -> np.ndarray:
        """Whether neighbours along each direction are off a guard that is 0 here, as of a wall at rest."""
        from jointplay.solver.method.modes import FREE, GAP, RELEASED, SLIDE, mask

        motion, first = self.motion, len(self.motion.flags)
        n_x, modes = len(motion.absolute), np.where(np.arange(len(motion.modes)) < first, motion.modes, FREE)
        met = [4 * first + wall for wall in np.flatnonzero(motion.modes[first:] > RELEASED)]
        values = np.abs(_rows(self.model.structure, self.work, motion)[self.options.guards :])
        for j in range(first):
            slips = motion.modes[j] in (Mode.SLIP_POSITIVE, Mode.SLIP_NEGATIVE)
            watched = [4 * j + guard for guard in ((GAP, SLIDE) if slips else (GAP,))]  # else forgotten
            met += [guard for guard in watched if values[guard] <= motion.margin[guard]]
        slopes, found = self.tangents.gradient.copy(), np.zeros(len(self.directions), dtype=bool)
        module = cache.variation_module(self.model.structure, self._names)
        mask(modes, motion.m)
        for guard in met:
            module.gradient(guard, motion.s, motion.p, motion.m, slopes)
            terms = np.column_stack([slopes[1 : 1 + n_x] * self.directions.starts, slopes[1 + n_x :]])
            found |= np.abs(terms.sum(axis=1)) > APART * np.abs(terms).sum(axis=1)
        mask(motion.modes, motion.m)
        return found

    def shift(self, times: np.ndarray) -> None:
        """Add the rate of the state, times a time of each direction, to the directions' tangents."""
        d = self.tangents.d.reshape(-1, 1 + len(self.motion.absolute))
        d[len(d) - len(times) :, 1:] += np.outer(times, self.rate())

    @property
    def works(self) -> np.ndarray:
        """Derivatives of the works, of each tangent where there are directions; shape (vectors, works).

        Those of the joints without what they take in impacts on rigid walls: see gradients.evaluated.
        """
        whole = self.tangents.works[: len(self.tangents.works) // 2]
        return whole.reshape(len(self.tangents.alive), -1).copy()


def rate(structure: Linkage | Oscillator, work, motion, options) -> np.ndarray:
    """Rate of the state where a run stands, by its arrays and options."""
    n_q, first = options.n_q, options.first + 1 + options.n_q + options.n
    found = _rows(structure, work, motion)[first : first + options.n]
    return np.concatenate([motion.s[1 + n_q : 1 + 2 * n_q], found])


def _rows(structure: Linkage | Oscillator, work, motion) -> np.ndarray:
    """Values of the equations at the present state of a run, by lane row."""
    from jointplay.solver.method.modes import mask, variant_of

    module, w = cache.structure_module(structure), np.zeros_like(work.w)
    module.trig(motion.s, motion.p)
    mask(motion.modes, motion.m)
    module.rate(variant_of(motion.modes), w, motion.s, motion.p, motion.m)
    return w.reshape(-1, 8)[:, 7]


def warm_tangents(model: Model) -> None:
    """Compile the code that the tangents of a model need, so that worker processes find it on the disk."""
    Bundle(model, Request(1e-9 * model.period, max_steps=1), np.eye(len(model.state))).advance()
