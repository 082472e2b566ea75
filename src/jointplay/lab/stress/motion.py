"""One run of a model: its states, energy balance, events and cost; and how small differences grow in it.

The largest growth is the measure of a disagreement of two runs. Each step adds an error of its own, and the
flow carries it on. So what counts are growths between any two times: with Phi_k the flow's derivative over
block k, jumps at events included, the norms of Phi_j ... Phi_i, i <= j. The errors of all blocks i add up in
block j: their sum, or where one is larger than the sum's share of a shorter block, the largest. The frame of
unit tangents starts anew with each block, so that none of it is lost to the fastest direction. What grows and
is ended by an event (the onset of sticking) within a block does not show: shorter blocks show it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.tangents import Bundle, scales
from jointplay.analysis.trajectory import Records, Request, follow
from jointplay.mechanism.model import SPEED_FLOOR, Model

SAMPLES = 48  # a nominal turn, at which runs are compared
FLOWS = ("energy_residual", "drive_work", "joint_work", "structural_work", "kinetic_energy")
OK = STATUS.index("ok")
BLOCKS = 24  # a nominal turn, and at least in a run
BEYOND = 1e12  # growth at which it is not followed further
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
        _events(model, records),
        residual(model, records),
        records.counts,
        records.wall_time,
        spent,
        float(rows[-1, 0] / model.period) if len(rows) else 0.0,
    )


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


def largest_growth(
    model: Model, unit: np.ndarray, turns: float, rtol: float, max_steps: int, closer: int = 1
) -> float:
    """Return the largest growth, at least 1, of what small differences add up to, made in all blocks of a run.

    Differences are in units of the states' sizes `unit`; a whole one is made in a block of usual length.
    Blocks are `closer` times shorter than usual: growth that an event soon ends shows in short ones only. If
    the run stops, the part before counts.
    """
    end, n_x, whole = turns * model.period, len(unit), np.eye(len(unit))
    request = Request(end, rtol, max_steps=max_steps)
    bundle = Bundle(model, request, np.diag(unit), tolerance=SOLVED, held=True)
    products, largest = np.zeros((0, n_x, n_x)), 1.0
    for until in np.linspace(0.0, end, closer * max(BLOCKS, round(turns * BLOCKS)) + 1)[1:]:
        bundle.y.d.reshape(n_x, -1)[:] = np.diag(unit, 1)[:n_x]
        status = bundle.advance(until)
        block = (bundle.vectors / unit).T
        if not np.all(np.isfinite(block)):
            return largest
        products = block @ np.concatenate([products, whole[None]])
        norms = np.linalg.norm(products, 2, axis=(1, 2))
        largest = max(largest, float(np.max(norms)), float(np.sum(norms)) / closer)
        if status or largest > BEYOND:
            return largest
    return largest
