"""Forces and losses in the joints over some turns of a settled motion.

Of each joint with clearance, per turn, by the trapezoidal rule over even samples:

    loss of impacts    integral of F_n v_n       (what a contact stores, it gives back by the turn's end)
    loss of friction   integral of F_t v_t
    sliding work       integral of |F_n v_t|     (to which Archard's wear is proportional)

Peaks are those of the samples. An error is the difference to every second sample, together with the scatter
of the mean over turns, or, of a peak, with the difference of the record's halves. Check: the drive puts in
what the joints take, where nothing else takes or gives.
Reference: Archard, Journal of Applied Physics 24 (1953), for the wear.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.analysis import rates, rules
from jointplay.analysis.assessment.settled import CHANGES, Settled, Unsettled, settled
from jointplay.analysis.contacts import JOINT, KIND, ROW, approach
from jointplay.analysis.quantities import recorded
from jointplay.analysis.starts import placed
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.analysis.trajectory import Records, Request, follow
from jointplay.mechanism.model import Model
from jointplay.mechanism.records import Mechanism
from jointplay.numerics.codes import Event

SAMPLES, SHOWN = 4096, 512  # of a turn: evaluated, and kept of the last one
WANTED = ("normal_force", "tangential_force", "normal_velocity", "tangential_velocity")
WANTED += ("reaction", "drive_torque", "angular_velocity")
EXPONENT = ("section_exponent_per_turn", "section_standard_error_per_turn")
PER_TURN = ("impact_loss", "friction_loss", "sliding_work")


def forces(mechanism: Mechanism, start: Any, turns: int, how: Plan) -> dict[str, Any]:
    """Forces and losses of the motion that a mechanism settles to.

    Returns
    -------
    dict
        ``status``; ``names`` of the joints, those with clearance first; over these ``force`` (samples of the
        last turn), ``peak`` and ``peak_error`` (N); over joints with clearance `PER_TURN` and their errors
        (J per turn) and ``impact_speed`` (m/s); ``drive_input`` (J per turn), and numbers of the motion.
    """
    try:
        motion = settled(mechanism, start, how)
        return {"status": 0, "trouble": ""} | _measured(motion, turns, how)
    except Unsettled as error:
        return {"status": error.status, "trouble": str(error)}


def _measured(motion: Settled, turns: int, how: Plan) -> dict[str, Any]:
    model = placed(motion.mechanism, motion.end)
    times = np.linspace(0.0, turns * float(motion.value("turn_period")), turns * SAMPLES + 1)
    limits = {"rtol": how.rtol, "max_steps": rules.steps(how.max_steps)}
    records = follow(model, Request(times[-1], at=times, events=True, rates=True, log_from=0.0, **limits))
    if records.status:
        raise Unsettled(records.status)
    names = [name for name in WANTED if name in recorded(None, motion.mechanism)]
    history = rates.quantities(model, how.rtol, records, records.samples).variables(names, "time")
    given = {name: values for name, (_, values, _) in history.items()}
    size = np.hypot(given["normal_force"], given["tangential_force"]) if model.joints else given["reaction"]
    if model.joints and model.pins:
        size = np.hstack([size, given["reaction"]])
    answer = {"names": [*model.joints, *model.pins], "force": size[-1 - SAMPLES :: SAMPLES // SHOWN]}
    answer |= _peaks(size) | _of_motion(motion) | {"drive_input": _drive(model, given, times, turns)}
    if model.joints:
        answer |= _losses(given, times, turns) | {"impact_speed": _impact_speeds(model, records)}
    return answer


def _peaks(size: np.ndarray) -> dict[str, np.ndarray]:
    """Largest force of each joint, and its error."""
    peak, half = size.max(axis=0), len(size) // 2
    halves = size[:half].max(axis=0) - size[half:].max(axis=0)
    return {"peak": peak, "peak_error": np.maximum(np.abs(halves), peak - size[::2].max(axis=0))}


def _of_motion(motion: Settled) -> dict[str, Any]:
    """Numbers of the motion itself."""
    own = {name: np.array(motion.value(name, ())) for name in ("separations", "impacts", "contact_fraction")}
    own |= {name: float(motion.value(name)) for name in ("turn_period", *EXPONENT)}
    traits = motion.traits
    return own | {"period": motion.period, "traits": np.array([traits[name] for name in CHANGES])}


def _drive(model: Model, given: dict[str, np.ndarray], times: np.ndarray, turns: int) -> float:
    """Work of the drive, J per turn."""
    speed = given["angular_velocity"][:, model.links.index(model.crank)]
    return float(np.trapezoid(given["drive_torque"] * speed, times) / turns)


def _losses(given: dict[str, np.ndarray], times: np.ndarray, turns: int) -> dict[str, np.ndarray]:
    """Integrals of each joint with clearance, J per turn, and their errors."""
    normal, across = given["normal_force"], given["tangential_velocity"]
    powers = (normal * given["normal_velocity"], given["tangential_force"] * across, np.abs(normal * across))
    answer = {}
    for name, power in zip(PER_TURN, powers, strict=True):
        each, coarse = (_by_turn(power[::n], times[::n], turns) for n in (1, 2))
        scatter = each.std(axis=0, ddof=1) / math.sqrt(turns) if turns > 1 else 0.0
        mean = each.mean(axis=0)
        answer |= {name: mean, f"{name}_error": np.hypot(scatter, mean - coarse.mean(axis=0))}
    return answer


def _by_turn(power: np.ndarray, times: np.ndarray, turns: int) -> np.ndarray:
    """Integrals over each turn, shape (turns, joints)."""
    pieces = (power[1:] + power[:-1]) / 2 * np.diff(times)[:, None]
    return pieces.reshape(turns, -1, power.shape[1]).sum(axis=1)


def _impact_speeds(model: Model, records: Records) -> np.ndarray:
    """Largest speed at which contact begins in each joint, m/s; 0 where none does."""
    rows = records.events[records.events[:, KIND] == Event.CONTACT]
    if not len(rows):
        return np.zeros(len(model.joints))
    speeds = np.abs(approach(model, records, rows[:, ROW:])[1])
    own = (speeds[rows[:, JOINT] == j, j] for j in range(len(model.joints)))
    return np.array([np.max(each, initial=0.0) for each in own])
