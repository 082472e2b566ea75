"""Covariant Lyapunov vectors through contact: directions that grow or shrink, and the parts that move.

Each exponent has a direction of its own that the tangent flow, with the jumps at every event, takes into
itself: a small push along the first one grows for good, one along the last only decays. They are found from a
forward run with a frame and a backward pass over its record.

The record is that of a window of turns: each pass goes back over twice the settling time and gives the
vectors of the first half, whose record is then dropped. Memory grows by the section points alone.

Shares of crank, play and bending in each tell where it lives. A linkage moves in as many ways as it has
coordinates q: the crank turns with every journal held in its bearing, a journal moves in its bearing, a link
bends. These are other coordinates z(q): the crank's angle, places of journals in their bearings, deflections.
A tangent (dq, dq') changes them by

    dz = Z dq,    dz' = Z dq' + Z' dq,    Z = dz/dq,

and each moves the linkage by its columns B of Z^-1. The size of a part's motion is an energy, with the mass
matrix M and the drive's nominal speed W,

    E = (B dz')^T M (B dz') / 2 + W^2 (B dz)^T M (B dz) / 2,

and its share is E over the sum of all parts' E. A motion that the ideal mechanism could make has no share of
play. What has no such coordinates (a test system, guides with play, more freedom than that) has one part a
state: the square of its change in units of its scale (tangents), over the sum of these.

Plain linear algebra, of flows and of maps: forward, a frame Q is carried by the tangent maps M and made
orthonormal again: M Q = Q' R, with R upper triangular. Its first j columns come to span the j directions that
grow fastest, whatever units they are measured in. The vectors that maps take into one another are V = Q C, C
upper triangular with unit columns:

    R C = C' D,    D diagonal: M V = V' D.

Solved backward, C = R^-1 C' D, column j forgets where it began as exp(-(lambda_(j-1) - lambda_j) t): what
grows least within the first j directions grows most backward. Reference: F. Ginelli, P. Poggi, A. Turchi, H.
Chate, R. Livi and A. Politi, Physical Review Letters 99 (2007) 130601.

Validity: away from both ends of the series, by the time in which directions settle. Where two exponents are
equal, only the plane of their vectors is determined.

The record holds QR factors block by block, and the frame at section points. A block is a piece of the run in
which the frame is carried as it is; at its end it is made orthonormal. Blocks are so short that no direction
is lost in the rounding of another. The last direction of a whole frame may shrink faster than steps resolve
(method.tangents.tangent): its growth is what the volume leaves for it.

Section points are those at the crank's first angle (at a forcing's first phase, at a constant speed once a
turn, and in a system that nothing turns once in its time scale); blocks end there.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Annotated, Any, NamedTuple, Unpack

import numpy as np
from pydantic import BeforeValidator

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OF_A_MODEL, mass_matrix, of_states, run_values
from jointplay.analysis.exponents import batch_means, frame_growth
from jointplay.analysis.exponents.batch_means import ERRORS
from jointplay.analysis.exponents.frame_growth import frame
from jointplay.analysis.exponents.growth import standard_error
from jointplay.analysis.exponents.lyapunov import directions, exponents_fit, number_or_all, steady
from jointplay.analysis.keywords import HANDED, Lasting, Length, Moving, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.starts import crank_place, state_names
from jointplay.analysis.tangents import TIGHT, Bundle, scales
from jointplay.display.number_text import plain, signed
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import TestSystem
from jointplay.solver.method.tangents.tangent import LOST
from jointplay.solver.motion.trajectory import Request, counts

LONGEST = 1 / 50  # of a turn: a block
SPREAD = 6.0  # ln of the ratio of the largest to the smallest growth in a block that is aimed at
SHORTEST = 1e-3  # of the longest block
NEAR = 1e-6  # rad of the crank's angle: so near to a section point is there
TINY = 1e-100  # of the last direction's growth, that is as good as 0; its square is still a number
AIM = 0.98  # of the way to a section point, gone before the last block to it


@dataclass(frozen=True)
class Block:
    """A block of a run.

    Parameters
    ----------
    time : float
        Its end, s.
    R : ndarray
        Factor of the frame that was carried through it.
    below : float
        ln of the last direction's growth less that of R's last entry.
    state, frame, rate : ndarray, optional
        Where its end is a section point: state; frame of unit columns in units of the scales; rate of the
        state in these units.
    """

    time: float
    R: np.ndarray
    below: float
    state: np.ndarray | None = None
    frame: np.ndarray | None = None
    rate: np.ndarray | None = None

    @property
    def growth(self) -> np.ndarray:
        """ln of the growth of each direction of the frame."""
        logs = np.log(np.diag(self.R))
        logs[-1] += self.below
        return logs


class Recorder:
    """A run that goes on block by block, from where a bundle of tangents stands.

    Parameters
    ----------
    bundle : Bundle
        Its tangents, without the motion's own, are the frame.

    Attributes
    ----------
    status : int
        How the last block ended (method.flow); 0: well.
    lost : int
        How many directions the motion's events have taken away since.
    spread : float
        Largest ln of the ratio of two directions' growth in a block.
    """

    def __init__(self, bundle: Bundle):
        self.bundle, self.model, self.status, self.lost = bundle, bundle.model, 0, 0
        self.spread = 0.0
        self.scale, self.crank = scales(self.model), crank_place(self.model)
        bundle.tangents.count[bundle.at.HELD] = 1
        self.Q = factors(self._image())[0]
        self.whole = self.Q.shape[0] == self.Q.shape[1]
        bundle.tangents.alive[:] = np.arange(len(bundle.tangents.alive)) < self.Q.shape[1]
        self.longest = LONGEST * self.model.period
        passed = math.floor(bundle.time / self.model.period + NEAR)
        self.length, self.next = self.longest, self.model.period * (passed + 1)
        if self.crank is not None:
            turned = (self._angle - self.model.crank_angle) * self.model.forward / math.tau
            self.next = self.model.crank_angle + self.model.forward * math.tau * (math.floor(turned) + 1)

    @property
    def left(self) -> int:
        """Number of directions left."""
        return self.Q.shape[1]

    @property
    def _angle(self) -> float:
        return float(self.bundle.motion.s[1 + self.crank])

    def _image(self) -> np.ndarray:
        """The frame's image in units of the scales, shape (states, directions that are left)."""
        return (self.bundle.vectors[self.bundle.tangents.alive.astype(bool)] / self.scale).T

    def blocks(self, until: float, tell: Callable[[], None] | None = None) -> Iterator[Block]:
        """Go on until a time, the run's end or the last direction's; give each block.

        `tell` as of `Bundle.advance`.
        """
        while self.status == 0 and self.left and self.bundle.time < until:
            block = self._block(until, tell)
            if self.status == 0 and self.left:
                yield block

    def _block(self, until: float, tell: Callable[[], None] | None) -> Block:
        bundle, real, at = self.bundle, self.bundle.tangents.real, self.bundle.at
        d = bundle.tangents.d.reshape(len(bundle.tangents.alive), -1)
        d[: self.Q.shape[1], 1:] = (self.Q * self.scale[:, None]).T  # the frame in place of its image
        real[at.TRACE] = real[at.VOLUME] = 0.0
        end, there = self._end(until)
        self.status = bundle.advance(end, tell)
        image, volume = self._image(), float(real[at.TRACE] + real[at.VOLUME])
        Q, R = factors(image)
        if volume == -math.inf:
            Q, R = self._without_lost(image, Q, R)
        self.Q, below = Q, 0.0
        if self.whole and self.lost == 0:
            R[-1, -1] = max(R[-1, -1], TINY)
            below = volume - float(np.log(np.diag(R)).sum())
        self._adapt(R)
        if not self._passed(there):
            return Block(bundle.time, R, below)
        return Block(bundle.time, R, below, bundle.state, Q, bundle.rate() / self.scale)

    def _without_lost(self, image: np.ndarray, Q: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give up a direction that an event has left to rounding, and the directions after it."""
        gone = np.flatnonzero(np.diag(R) <= LOST * np.linalg.norm(image, axis=0))
        if not gone.size:
            return Q, R
        kept = int(gone[0])
        self.lost += len(R) - kept
        self.bundle.tangents.alive[kept:] = 0
        return Q[:, :kept], R[:kept, :kept]

    def _end(self, until: float) -> tuple[float, bool]:
        """End of the next block, and whether a section point is aimed at."""
        time, ahead = self.bundle.time, self._ahead()
        end = until if until - time < 1.001 * self.length else time + self.length
        if not 0.0 < ahead <= 1.001 * (end - time):
            return end, False
        if self.crank is not None and ahead > 0.05 * self.length:
            return time + AIM * ahead, True
        return until if abs(until - time - ahead) < NEAR * self.length else time + ahead, True

    def _ahead(self) -> float:
        """Time to the next section point, at the present speed."""
        if self.crank is None:
            return self.next - self.bundle.time
        speed = float(self.bundle.state[len(self.model.turning) + self.crank])
        return (self.next - self._angle) / speed if speed else math.inf

    def _passed(self, there: bool) -> bool:
        """Whether a section point is reached; the next one is aimed at then."""
        if self.crank is None:
            if there:
                self.next += self.model.period
            return there
        left = (self.next - self._angle) * self.model.forward
        if left > NEAR:
            return False
        self.next += self.model.forward * math.tau
        return True

    def _adapt(self, R: np.ndarray) -> None:
        """Fit the next block to the spread of growth in this one."""
        logs = np.log(np.diag(R))[: len(R) - (self.whole and self.lost == 0)]
        spread = float(np.ptp(logs)) if len(logs) else 0.0
        self.spread = max(self.spread, spread)
        wanted = self.length * min(2.0, SPREAD / max(spread, 1e-3))
        self.length = min(self.longest, max(wanted, SHORTEST * self.longest))


OTHER = 1  # seed of a second frame
UNSETTLED = 1e-3  # rad, from which a vector is not known
COARSE = 20.0  # ln of the spread of growth in a block, from which the last vectors are inaccurate
WORDS = {"crank": "the crank's motion", "bending": "the bending of links"}
STEP = 1e-6  # of a turn: to either side, for the rate of Z
COMPLEX = 1e-30  # of an imaginary part, for Z itself: no difference is taken
DEPENDENT = 1e-9  # of its largest singular value, at which Z counts as singular


def answer(result: xr.Dataset) -> str:
    """The parts in the direction that grows most, its angle with the others, and doubts.

    A direction counts as growing where its exponent is above 0 by more than three standard errors.
    """
    if "mean_share" not in result:
        return "\n".join(["the covariant vectors are not known", *filter(None, [_doubts(result)])])
    tail, per = ("_per_turn", "per turn") if "turn_period" in result else ("", "per second")
    values, errors = (result[f"covariant_{name}{tail}"].values for name in ("exponent", "standard_error"))
    growing = int(np.count_nonzero(values > ERRORS * errors))
    rate = f"{signed(float(values[0]), float(errors[0]))} {per}"
    shares = _shares(result)
    lines = [
        f"chaos lives in {shares} (the direction that grows by {rate})"
        if growing
        else f"no chaos: no direction grows significantly; the leading one, {rate}, lies in {shares}"
    ]
    if 0 < growing < len(values):
        angles = np.degrees(result["splitting_angle"].isel(splitting=growing - 1).values)
        low, middle = plain(float(angles.min()), 2), plain(float(np.median(angles)), 2)
        what = "the growing direction" if growing == 1 else f"the {growing} growing directions"
        lines.append(f"angle of {what} with the others: at least {low}°, median {middle}°")
    return "\n".join([*lines, *filter(None, [_doubts(result)])])


def _shares(result: xr.Dataset) -> str:
    """Parts of the first vector, the largest first, with their mean shares."""
    share = result["mean_share"].isel(vector=0).values
    names = [str(name) for name in result["part"].values]
    order = [i for i in np.argsort(-share) if share[i] >= 0.01]
    return ", ".join(f"{_named(names[i])} {plain(100 * float(share[i]), 3)} %" for i in order)


def _named(part: str) -> str:
    if part.startswith("play "):
        return f"the play of {part.removeprefix('play ')}"
    return WORDS.get(part, part)


def _doubts(result: xr.Dataset) -> str:
    doubts, loose = [], np.zeros(0)
    if "settling_residual" in result:
        loose = result["vector"].values[result["settling_residual"].values > UNSETTLED]
    if loose.size:
        numbers = ", ".join(map(str, loose))
        doubts.append(
            f"vectors {numbers} have not settled: lengthen settling or transient, unless exponents are equal"
        )
    if float(result["block_spread"]) > COARSE:
        doubts.append("directions shrink so differently that the last vectors are inaccurate")
    if lost := int(result["lost"]):
        doubts.append(f"{lost} direction{'s' * (lost > 1)} lost at events, without a vector")
    return "; ".join(doubts)


BETWEEN = "smallest angle between the first vectors and all others"


RATES = {
    f"{key}_{word}": Out("vector", f"{before}{name}", "s-1")
    for key, name in (
        ("covariant", "exponent of the covariant vector"),
        ("lyapunov", "Lyapunov exponent, by the frame"),
    )
    for word, before in (("exponent", ""), ("standard_error", "standard error of the "))
}


OUTPUTS = Outputs(
    "covariant",
    {
        "vector": Out("vector", "number of the vector, that of the largest exponent first"),
        "splitting": Out("splitting", "number of vectors before the splitting"),
        "turn": Out("turn", "section point"),
        "part": Out("part", "what moves", ""),
        "component": Out("component", "state", ""),
    },
    RATES
    | {f"{name}_per_turn": Out("vector", f"{out.long_name}, per turn") for name, out in RATES.items()}
    | {
        "covariant_batch_correlation": Out("vector", "correlation of a batch mean with the next"),
        "turn_period": Out((), "mean period of a turn", "s", "where something turns"),
        "settling_residual": Out(
            "vector",
            "largest angle between vectors from two beginnings of the backward pass, or two first frames",
            "rad",
        ),
        "share": Out(("turn", "vector", "part"), "share of a part in a vector"),
        "time": Out("turn", "time of the section point", "s"),
        "section_state": Out(("turn", "component"), "state, in SI units"),
        "covariant_vector": Out(
            ("turn", "vector", "component"), "vector of unit length, in units of the states' scales"
        ),
        "mean_share": Out(("vector", "part"), "mean share of a part in a vector"),
        "mean_share_standard_error": Out(("vector", "part"), "standard error of the mean share"),
        "splitting_angle": Out(("turn", "splitting"), BETWEEN, "rad"),
        "smallest_angle": Out("splitting", f"{BETWEEN}, of all points", "rad"),
        "neutral_vector": Out((), "vector along the motion", about="where nothing outside keeps the time"),
        "neutral_angle": Out("turn", "angle of the neutral vector with the rate of the state", "rad"),
        "lost": Out((), "directions that events took away", about="which have no vectors"),
        "grazing": Out((), "smallest relative approach to a guard"),
        "block_spread": Out((), "largest spread of directions' growth (ln) in a block"),
    }
    | OF_A_MODEL,
    answer,
    shown={"covariant_exponent_per_turn": "", "covariant_exponent": ""},
)


@analysis(
    rules.length_fits,
    exponents_fit,
    steady,
    usual={"transient": 20},
    outputs=OUTPUTS,
    left_out=rules.lasting(20, 100),
)
def covariant(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    exponents: Annotated[int | str, BeforeValidator(number_or_all)] = "all",
    settling: Length = 20,
    **motion: Unpack[Lasting],
) -> xr.Dataset:
    """Give the covariant Lyapunov vectors of a motion, and the share of each part in them.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    exponents : int or "all"
        Number of vectors, those of the largest exponents first, or ``all``.
    turns : float
        Length after the transient, in nominal turns of the crank, periods of the forcing, or time scales of a
        system that nothing turns; instead of `duration`.
    duration : float
        Length after the transient, s; instead of `turns`.
    transient : float
        Number of turns for which the motion and its tangents are followed first and left out.
    settling : float
        Number of turns that are followed after the stretch, over which the vectors settle backward in time. A
        record of twice as many is in memory at a time.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.

    Notes
    -----
    Of a run that failed, or of which no direction is left, there are only ``lost``, ``grazing``,
    ``block_spread`` and how it ended.

    Sections are those at the crank's first angle, or at a forcing's first phase; in a system that nothing
    turns, points are a time scale apart. ``settling_residual`` is the largest angle, at the ends of windows,
    between vectors from two beginnings of the backward pass, or at the end of the transient between a vector
    and the directions that another first frame has come to: it says how well they are known. It stays large
    where two exponents are equal. ``block_spread`` is the largest ln of the ratio of two directions' growth
    before they were made orthonormal: above 20, the last vectors are inaccurate. Angles are measured in units
    of the states' scales; exponents do not depend on these. What shares are shares of is their attribute
    ``norm``: of a linkage with play, an energy of the motion of the crank, of each joint's journal in its
    bearing and of bending, each by itself; else the squares of the vector's components.
    """
    began, count = time.perf_counter(), directions(model) if exponents == "all" else int(exponents)
    (begin, until), window = rules.span(model, motion), settling * model.period
    limit, progress = rules.steps(motion["max_steps"]), motion["progress"]
    request = Request(until + window, motion["rtol"], max_steps=limit)
    first = partial(frame, count, scales(model), model.followers)
    bundle, other = (Bundle(model, request, each, TIGHT) for each in (first(), first(seed=OTHER)))

    def tell() -> None:
        if progress is not None:
            progress(bundle.time / request.duration)

    status = _together(bundle, other, begin, tell)
    recorder, found = Recorder(bundle), Findings(model, begin, until)
    if status == 0:
        frames = recorder.Q, Recorder(other).Q
        for vectors, residual, C in _settled(recorder, begin, until, window, tell):
            found.add(vectors, residual if found.residuals else _larger(residual, beyond(*frames, C)))
        status = recorder.status
    turning = not (isinstance(mechanism, TestSystem) and mechanism.period is None)
    known = status == 0 and recorder.left > 0
    values = found.values(turning) | found.coordinates() if known else {}
    values["lost"] = np.int64(count - (found.count if known else recorder.left))
    values |= {"grazing": bundle.grazing, "block_spread": recorder.spread}
    ended = {"status": status, "wall_time": time.perf_counter() - began, "counts": counts(bundle.motion)}
    result = OUTPUTS.dataset(values | run_values(model, SimpleNamespace(**ended)), model=model)
    if "share" in result:
        result["share"].attrs["norm"] = found.participation.norm
    return result


def _together(bundle: Bundle, other: Bundle, until: float, tell: Callable[[], None]) -> int:
    """Carry two frames along one motion until a time: in chaos, two of one start would part."""
    bundle.record(bundle.model.period)
    while (status := bundle.advance(until, tell)) == bundle.full:
        bundle.taken()
        other.join(bundle)
    bundle.record(math.inf)
    if status == 0:
        other.join(bundle)
    return status


def _settled(
    recorder: Recorder, begin: float, until: float, window: float, tell: Callable[[], None]
) -> Iterator[tuple[list[Vectors], np.ndarray, np.ndarray]]:
    """Follow the stretch and a window after it: vectors over its blocks, window by window, with residuals.

    And the vectors' columns where each window begins.
    """
    kept, edge = [], min(begin + window, until)
    for block in recorder.blocks(until + window, tell):
        kept.append(block)
        while kept and block.time >= edge + window:
            done = sum(each.time <= edge for each in kept)
            yield _solved(kept, done)
            if edge >= until:
                return
            kept, edge = kept[done:], min(edge + window, until)


def _larger(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The larger of two angles of each vector that both know."""
    shared = min(len(one), len(other))
    return np.maximum(one[:shared], other[:shared])


def _solved(blocks: list[Block], done: int) -> tuple[list[Vectors], np.ndarray, np.ndarray]:
    """Vectors over the first `done` blocks, and their angles at the end with vectors from another beginning.

    Then the vectors' columns where the blocks begin.
    """
    one, other = (list(_back(blocks[first:], seed)) for first, seed in ((0, 1), (done, 2)))
    ends = [C for C, _ in one[1:]] + [start(len(blocks[-1].R), 1)]
    given = zip(blocks[:done], ends[:done], [growth for _, growth in one[:done]], strict=True)
    later = start(len(blocks[-1].R), 2) if done == len(blocks) else other[0][0]
    here = ends[done - 1]
    shared = min(here.shape[1], later.shape[1])
    residual = angles_between(here[:shared, :shared], later[:shared, :shared])
    return [Vectors(block, C, growth) for block, C, growth in given], residual, one[0][0]


def _back(blocks: list[Block], seed: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Columns at the beginning of each block, and their growth over it, from one end of the pass."""
    C = start(len(blocks[-1].R), seed) if blocks else np.eye(0)
    found = list(backward((block.R for block in reversed(blocks)), C))[::-1]
    for block, (_, growth) in zip(blocks, found, strict=True):
        growth[-1] += block.below
    return found


class Vectors(NamedTuple):
    """Vectors over a block: columns of C at its end, and the ln of their growth over it."""

    block: Block
    C: np.ndarray
    growth: np.ndarray


class Point(NamedTuple):
    """A section point: its block, C, and the vectors' shares of parts (rows)."""

    block: Block
    C: np.ndarray
    shares: np.ndarray

    @property
    def vectors(self) -> np.ndarray:
        """Columns of unit length, in units of the states' scales."""
        return self.block.frame[:, : len(self.C)] @ self.C


class Findings:
    """Findings on the vectors of a motion, gathered block by block.

    Parameters
    ----------
    model : Model
        What moves.
    begin, until : float
        Ends of the stretch, s.
    """

    def __init__(self, model: Model, begin: float, until: float):
        self.model, self.participation = model, Participation(model)
        self.points: list[Point] = []
        self.residuals: list[np.ndarray] = []
        self.sums: np.ndarray | None = None
        self.rows: list[tuple[float, np.ndarray]] = []
        self.begin, self.row = begin, (until - begin) / batch_means.BLOCKS

    def add(self, vectors: list[Vectors], residual: np.ndarray) -> None:
        """Add the vectors of the next blocks, and their distance from settled ones at the end."""
        self.residuals.append(residual)
        for block, C, grown in vectors:
            growth = np.array([grown, block.growth])
            if self.sums is None:
                self.sums = np.zeros_like(growth)
                self.rows.append((self.begin, self.sums))
            self.sums = self.sums[:, : growth.shape[1]] + growth
            if block.time >= self.begin + len(self.rows) * self.row:
                self.rows.append((block.time, self.sums))
            if block.state is not None:
                shares = self.participation(block.time, block.state, block.frame[:, : len(C)] @ C)
                self.points.append(Point(block, C, shares))

    @property
    def count(self) -> int:
        """Number of vectors that last all the way."""
        return min(self.sums.shape[1], *(len(each) for each in self.residuals))

    @property
    def turn(self) -> float:
        """Mean length of a turn, s."""
        crank, blocks = crank_place(self.model), [point.block for point in self.points]
        if crank is None or len(blocks) < 2:
            return self.model.period
        angle = blocks[-1].state[crank] - blocks[0].state[crank]
        return math.tau * (blocks[-1].time - blocks[0].time) / abs(angle)

    def coordinates(self) -> dict[str, Any]:
        """Values of the coordinates."""
        return {
            "vector": np.arange(1, self.count + 1),
            "splitting": np.arange(1, self.count),
            "turn": np.arange(len(self.points)),
            "part": np.array(self.participation.parts, dtype=str),
            "component": np.array(state_names(self.model), dtype=str),
        }

    def values(self, turning: bool) -> dict[str, Any]:
        """Values of the variables; also per turn where something turns."""
        found = self._exponents(turning)
        found["settling_residual"] = np.max([each[: self.count] for each in self.residuals], axis=0)
        return found | self._at_points() if self.points else found

    def _exponents(self, turning: bool) -> dict[str, Any]:
        count, times = self.count, np.array([time for time, _ in self.rows])
        sums = np.array([each[:, :count] for _, each in self.rows])
        columns, found = slice(1, 1 + count), {}
        for place, key in enumerate(("covariant", "lyapunov")):
            rows = np.column_stack([times, sums[:, place]])
            found[f"{key}_exponent"] = batch_means.growth(rows, columns)
            found[f"{key}_standard_error"] = batch_means.standard_error(rows, columns)
        if turning:
            found |= {f"{name}_per_turn": each * self.turn for name, each in found.items()}
            found["turn_period"] = self.turn
        rows = np.column_stack([times, sums[:, 0]])
        return found | {"covariant_batch_correlation": batch_means.batch_correlation(rows, columns)}

    def _at_points(self) -> dict[str, Any]:
        count, points = self.count, self.points
        vectors = np.array([point.vectors[:, :count].T for point in points])
        shares = np.array([point.shares[:, :count].T for point in points])
        angles = np.array([splittings(point.C[:count, :count]) for point in points])
        found = {
            "share": shares,
            "time": np.array([point.block.time for point in points]),
            "section_state": np.array([point.block.state for point in points]),
            "covariant_vector": vectors,
            "mean_share": shares.mean(axis=0),
            "mean_share_standard_error": np.apply_along_axis(standard_error, 0, shares),
            "splitting_angle": angles,
            "smallest_angle": angles.min(axis=0),
        }
        return found | (self._along(vectors) if frame_growth.has_no_clock(self.model) else {})

    def _along(self, vectors: np.ndarray) -> dict[str, Any]:
        """The vector that is the motion's own direction, and its angle with that."""
        rates = np.array([point.block.rate for point in self.points])
        sizes = np.linalg.norm(rates, axis=1)
        if not np.all(sizes > 0):
            return {}
        angles = np.array(
            [angles_between(V.T, (F / s)[:, None]) for V, F, s in zip(vectors, rates, sizes, strict=True)]
        )
        best = int(np.argmin(np.median(angles, axis=0)))
        return {"neutral_vector": np.int64(best + 1), "neutral_angle": angles[:, best]}


class Participation:
    """Shares of a model's parts in tangents.

    Parameters
    ----------
    model : Model
        Its state plays no part, but for the choice of the parts.

    Attributes
    ----------
    parts : tuple of str
        ``crank``, ``play NAME`` of each joint, ``bending``; or the names of the states.
    norm : str
        What the shares are shares of, in words.
    """

    def __init__(self, model: Model):
        self.model, self.rows = model, _rows(model)
        self.parts = tuple(self.rows) or state_names(model)
        self.norm = (
            "kinetic energy of the part's motion alone, and of its displacements at the nominal speed"
            if self.rows
            else "square of a state's change in units of its scale"
        )

    def __call__(self, time: float, state: np.ndarray, tangents: np.ndarray) -> np.ndarray:
        """Shares of each part in tangents (columns, in units of the scales), shape (parts, tangents)."""
        if not self.rows:
            return tangents**2 / np.sum(tangents**2, axis=0)
        n, physical = len(self.model.turning), tangents * scales(self.model)[:, None]
        dq, rate = physical[:n], physical[n : 2 * n]
        Z, M = _coordinates(self.model, time, state), mass_matrix(self.model, state, time)
        B, dz, dz_rate = np.linalg.inv(Z), Z @ dq, Z @ rate + _turning(self.model, time, state) @ dq
        W = math.tau / self.model.period
        energies = [
            _energy(M, B[:, rows] @ dz_rate[rows]) + W**2 * _energy(M, B[:, rows] @ dz[rows])
            for rows in self.rows.values()
        ]
        return np.array(energies) / np.sum(energies, axis=0)


def _energy(M: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    return np.einsum("im,ij,jm->m", speeds, M, speeds) / 2


def _rows(model: Model) -> dict[str, list[int]]:
    """Rows of Z by part; none where Z does not determine a motion."""
    if not model.links:
        return {}
    names, count = state_names(model)[: len(model.turning)], 2 * len(model.joints)
    bending = [i for i, name in enumerate(names) if name.startswith("eta_")]
    crank = f"theta_{model.crank}" in names
    if crank + count + len(bending) != len(names):
        return {}
    rows = {"crank": [0]} if crank else {}
    rows |= {f"play {name}": [crank + 2 * j, crank + 2 * j + 1] for j, name in enumerate(model.joints)}
    rows |= {"bending": list(range(crank + count, len(names)))} if bending else {}
    sizes = np.linalg.svd(_coordinates(model, 0.0, model.state), compute_uv=False)
    return rows if sizes[-1] > DEPENDENT * sizes[0] else {}


def _coordinates(model: Model, time: float, state: np.ndarray) -> np.ndarray:
    """Z at a state: rows of the crank's angle, of journals' x and y, of deflections."""
    names = state_names(model)[: len(model.turning)]
    unit = np.eye(len(names))
    crank = [i for i, name in enumerate(names) if name == f"theta_{model.crank}"]
    bending = [i for i, name in enumerate(names) if name.startswith("eta_")]
    keys = [f"journal_{axis}:{name}" for name in model.joints for axis in "xy"]
    steps = np.pad(unit, ((0, 0), (0, len(state) - len(names))))
    stepped = of_states(model, keys, state + 1j * COMPLEX * steps, time)
    play = np.array([*stepped.values()]).imag / COMPLEX
    return np.concatenate([unit[crank], play.reshape(len(keys), len(names)), unit[bending]])


def _turning(model: Model, time: float, state: np.ndarray) -> np.ndarray:
    """Rate of Z along the motion."""
    n, step = len(model.turning), STEP * model.period
    speeds = np.pad(state[n : 2 * n], (0, len(state) - n))
    ahead, behind = (_coordinates(model, time + dt, state + dt * speeds) for dt in (step, -step))
    return (ahead - behind) / (2 * step)


def factors(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """QR factors of a frame's image, columns in units of the states' scales; R has a positive diagonal."""
    Q, R = np.linalg.qr(image)
    sign = np.where(np.diag(R) < 0, -1.0, 1.0)
    return Q * sign, R * sign[:, None]


def backward(factors: Iterable[np.ndarray], C: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Take the columns of C back through the factors R.

    Parameters
    ----------
    factors : iterable of ndarray, shape (j, j)
        R of each map, the last one first; a later one may have fewer directions, the leading ones.
    C : ndarray, shape (j, j)
        Upper triangular, of unit columns: where the series ends.

    Yields
    ------
    C, growth : ndarray
        Columns where the map begins, and the logarithm by which the map makes each vector grow.
    """
    for R in factors:
        back = np.linalg.solve(R, widened(C, len(R)))  # triangular: no row is exchanged, no zero is filled
        lengths = np.linalg.norm(back, axis=0)
        C = back / lengths
        yield C, -np.log(lengths)


def widened(C: np.ndarray, count: int) -> np.ndarray:
    """C with so many columns, new ones along axes of their own."""
    wide = np.eye(count)
    wide[: len(C), : len(C)] = C
    return wide


def start(count: int, seed: int) -> np.ndarray:
    """Reproducible upper triangular matrix of unit columns, that no direction is left out of."""
    C = np.triu(np.random.default_rng(seed).normal(size=(count, count)))
    return C / np.linalg.norm(C, axis=0)


def angles_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angles between the lines of unit columns, rad; small ones to rounding."""
    along = np.sum(one * other, axis=0)
    return np.arctan2(np.linalg.norm(other - one * along, axis=0), np.abs(along))


def beyond(one: np.ndarray, other: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Angles of the j-th vector with the span of another frame's first j columns, j = 1, 2, …, in rad.

    Parameters
    ----------
    one, other : ndarray, shape (states, columns)
        Orthonormal frames: that of the vectors, and another.
    C : ndarray, shape (columns, vectors)
        The vectors' columns in the first frame.
    """
    V, angles = one[:, : len(C)] @ C, []
    for j in range(min(V.shape[1], other.shape[1])):
        span = other[:, : j + 1]
        inside = span.T @ V[:, j]
        angles.append(np.arctan2(np.linalg.norm(V[:, j] - span @ inside), np.linalg.norm(inside)))
    return np.array(angles)


def splittings(C: np.ndarray) -> np.ndarray:
    """Smallest angle between the span of the first j vectors and that of all others, j = 1, 2, …, in rad.

    The first j columns span the first j axes, so that the sines of the principal angles are the singular
    values of what the others, made orthonormal, have across these.
    """
    return np.array(
        [
            np.arcsin(min(1.0, np.linalg.svd(np.linalg.qr(C[:, j:])[0][j:], compute_uv=False)[-1]))
            for j in range(1, len(C))
        ]
    )
