"""One run of a model: its states, energy balance, events and cost; and the growth of small differences.

The largest growth is the measure of a disagreement of two runs. Each step adds an error of its own, and the
flow carries it on. So what counts are growths between any two times: with Phi_k the flow's derivative over
block k, jumps at events included, the norms of Phi_j ... Phi_i, i <= j: the largest, or if it is more a tenth
of their sum over i, since errors of that size in all blocks add up. The frame of unit tangents starts anew
with each block, so that none of it is lost to the fastest direction. What grows and is ended by an event (the
onset of sticking) within a block does not show: shorter blocks show it. Rest on rigid walls takes from the
derivatives what it does not take from the motion: there the difference of a twin tells.

At equal times two runs differ by a whole jump of the speeds where only one of them has met an impact yet. So
impacts are counted, on each rigid wall since something last came to rest there.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.analysis.tangents import Bundle, scales
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.motion.trajectory import Records, Request, follow

SAMPLES = 48  # a nominal turn, at which runs are compared
FLOWS = ("energy_residual", "drive_work", "joint_work", "structural_work", "kinetic_energy")
OK = STATUS.index("ok")
IMPACT, REST = (EVENTS.index(name) for name in ("impact", "rest"))
BLOCKS = 24  # a nominal turn, and at least in a run
BEYOND = 1e12  # growth at which it is not followed further
ADDED = 0.1  # share of a growth that the errors of each block make, beside the one that makes all of it
SOLVED = 1e-6  # tolerance of the tangents' iteration: their size is wanted, not their digits


@dataclass(frozen=True)
class Motion:
    """A run of a model.

    Parameters
    ----------
    status : int
        How it ended, of `STATUS`.
    states : ndarray, shape (samples, states)
        Positions and speeds at the samples that it reached.
    positions : int
        How many of the states are positions.
    met : ndarray, shape (samples, joints)
        Impacts on each rigid wall since something last came to rest there.
    events : ndarray, shape (events, 3)
        Joint, kind and normal speed of each event, over that of the journal's surface at the nominal speed.
    residual : float
        Largest energy unaccounted for, over the energy that flowed.
    counts : dict
        Steps and evaluations.
    wall_time, cpu_time : float
        s.
    turns : float
        Nominal turns that it reached.
    """

    status: int
    states: np.ndarray
    positions: int
    met: np.ndarray
    events: np.ndarray
    residual: float
    counts: dict[str, int]
    wall_time: float
    cpu_time: float
    turns: float


def move(model: Model, turns: int, rtol: float, max_steps: int) -> Motion:
    """Follow a model, assembled with the work of its parts, over nominal turns."""
    end = turns * model.period
    times = np.linspace(0.0, end, turns * SAMPLES + 1)
    began = time.thread_time()
    records = follow(model, Request(end, rtol, at=times, log_from=0.0, events=True, max_steps=max_steps))
    rows, spent = records.samples, time.thread_time() - began
    return Motion(
        records.status,
        rows[:, 1 : 1 + len(model.state)],
        len(model.turning),
        _met(records, rows[:, 0], len(model.touching)),
        _events(model, records),
        residual(model, records),
        records.counts,
        records.wall_time,
        spent,
        float(rows[-1, 0] / model.period) if len(rows) else 0.0,
    )


def _met(records: Records, times: np.ndarray, joints: int) -> np.ndarray:
    """Impacts on each rigid wall up to these times, since something last came to rest there."""
    rows, found = records.events[np.argsort(records.events[:, 2], kind="stable")], []
    for joint in range(joints):
        kinds, at = rows[rows[:, 0] == joint][:, 1:3].T
        hits, rests = (np.concatenate([[0], np.cumsum(kinds == kind)]) for kind in (IMPACT, REST))
        since = hits - np.maximum.accumulate(np.where(np.diff(rests, prepend=0) > 0, hits, 0))
        found.append(since[np.searchsorted(at, times, side="right")])
    return np.reshape(found, (joints, len(times))).T


def _events(model: Model, records: Records) -> np.ndarray:
    """Joint, kind and normal speed of each event, that speed over the journal's at nominal speed."""
    rows = records.events
    if not len(rows):
        return np.zeros((0, 3))
    of = rows[:, 0].astype(int)
    speeds = Quantities(model, rows[:, 2:], records.start).variables(["normal_velocity"], "event")
    speed = speeds["normal_velocity"][1][np.arange(len(of)), of]
    return np.stack([of, rows[:, 1], speed * SPEED_FLOOR / model.creep], -1)


def sizes(model: Model, motion: Motion) -> np.ndarray:
    """Size of each state: its scale, or the largest that it grew to."""
    scale = scales(model)
    return np.maximum(scale, np.max(np.abs(motion.states), axis=0, initial=0.0))


def residual(model: Model, records: Records) -> float:
    """Largest energy residual at the samples, over the energy that flowed to and fro between them."""
    names = [name for name in FLOWS if name != "structural_work" or model.bending]
    history = Quantities(model, records.samples, records.start)
    found = {name: value for name, (_, value, _) in history.variables(names, "time").items()}
    works = (found[name] for name in names if name.endswith("_work"))
    flowed = sum(float(np.abs(np.diff(work)).sum()) for work in works)
    flowed += float(np.max(found["kinetic_energy"], initial=0.0))
    largest = float(np.max(np.abs(found["energy_residual"]), initial=0.0))
    return largest / flowed if flowed > 0.0 else largest


def kick(model: Model, difference: np.ndarray) -> Model:
    """The model with other speeds at its start, where the gaps and loops are as they were."""
    speeds = np.arange(len(model.state)) >= len(model.turning)
    return replace(model, state=model.state + np.where(speeds, difference, 0.0))


def upto(motion: Motion, other: Motion) -> Motion:
    """A motion as far as another one came."""
    n = len(other.states)
    return replace(motion, states=motion.states[:n], met=motion.met[:n])


def largest_growth(
    model: Model, unit: np.ndarray, turns: float, rtol: float, max_steps: int, closer: int = 1
) -> float:
    """Return the largest growth, at least 1, of a small difference between any two times of a run.

    Or, if it is more, what a tenth of one made in each block of usual length adds up to. Differences are in
    units of the states' sizes `unit`. Blocks are `closer` times shorter than usual: growth that an event soon
    ends shows in short ones only. If the run stops, the part before counts.
    """
    end, n_x, whole = turns * model.period, len(unit), np.eye(len(unit))
    request = Request(end, rtol, max_steps=max_steps)
    bundle = Bundle(model, request, np.diag(unit), tolerance=SOLVED, held=True)
    products, largest = np.zeros((0, n_x, n_x)), 1.0
    for until in np.linspace(0.0, end, closer * max(BLOCKS, round(turns * BLOCKS)) + 1)[1:]:
        bundle.tangents.d.reshape(n_x, -1)[:] = np.diag(unit, 1)[:n_x]
        status = bundle.advance(until)
        block = (bundle.vectors / unit).T
        if not np.all(np.isfinite(block)):
            return largest
        products = block @ np.concatenate([products, whole[None]])
        norms = np.linalg.norm(products, 2, axis=(1, 2))
        largest = max(largest, float(np.max(norms)), ADDED / closer * float(np.sum(norms)))
        if status or largest > BEYOND:
            return largest
    return largest
