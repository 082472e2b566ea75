"""One run of a model: its states, energy balance, events and cost."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.tangents import scales
from jointplay.analysis.trajectory import Records, Request, follow
from jointplay.mechanism.model import SPEED_FLOOR, Model

SAMPLES = 48  # a nominal turn, at which runs are compared
FLOWS = ("energy_residual", "drive_work", "joint_work", "structural_work", "kinetic_energy")
OK = STATUS.index("ok")


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
