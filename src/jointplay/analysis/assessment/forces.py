"""Forces and losses in the joints over some turns of a settled motion.

Of each joint with clearance, per turn, by the trapezoidal rule over even samples, the integrator's points,
and both sides of every event:

    loss of impacts    integral of F_n v_n       (what a contact stores, it gives back by the turn's end),
                       and what impacts of a rigid bearing take at once
    loss of friction   integral of F_t v_t
    sliding work       integral of |F_n v_t|     (to which Archard's wear is proportional)

Peaks are sought between these points too (`recorded_spans`). An error is the difference to every second
sample, together with the scatter of the mean over turns, or, of a peak, with the difference of the record's
halves. The sum of both losses is the integrator's own integral of the joints' work.
Reference: Archard, Journal of Applied Physics 24 (1953), for the wear.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from jointplay.analysis import evaluate, rules
from jointplay.analysis.assessment.settled import CHANGES, Settled, Unsettled
from jointplay.analysis.contacts import JOINT, KIND, ROW, TIME, approach, begun
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.quantities import WORDS
from jointplay.analysis.recorded_spans import peaks
from jointplay.analysis.starts import moved
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.codes import Event
from jointplay.solver.motion.trajectory import Records, Request, follow

SAMPLES, SHOWN = 4096, 512  # of a turn: evaluated; its parts, of each of which two values are kept
ROUNDING = 1e-12  # of the largest force: what is left of sums of forces that are 0
ORBIT = 1e-9  # tolerance of a step on an orbit, whose forces are known as well as it is followed
FORCES = ("normal_force", "tangential_force", "reaction")
WORK = ("drive_work", "joint_work")
WANTED = (*FORCES, "normal_velocity", "tangential_velocity", *WORK)
EXPONENT = ("section_exponent_per_turn", "section_standard_error_per_turn")
History = dict[str, np.ndarray]  # quantities by name, and their times
PER_TURN = ("impact_loss", "friction_loss", "sliding_work")


def forces(
    motion: Settled,
    turns: float,
    how: Plan,
    per_turn: int = SAMPLES,
    brief: bool = False,
    model: Model | None = None,
) -> dict[str, Any]:
    """Forces and losses over some turns of a settled motion; of a periodic orbit two of its periods suffice.

    In `brief`, largest forces and impact speeds alone, without errors; then the turns need not be whole, and
    the `model` may be given, assembled where the motion ends.

    Returns
    -------
    dict
        ``names`` of the joints, those with clearance first; over these ``force`` (the lowest and the highest
        of each part of the turn with the peak), ``peak`` and ``peak_error`` (N); over joints with clearance
        `PER_TURN` and their errors (J per turn), ``impact_speed`` (m/s), ``drive_work`` and ``joint_work``
        (J per turn); and numbers of the motion. Without clearance, and with no motion that repeats, ``names``
        and NaN as ``peak``.

    Raises
    ------
    Unsettled
        Where the motion cannot be followed.
    """
    end = motion.end
    turns = min(turns, 2 * motion.period) if motion.orbit is not None else turns
    if model is None:
        watched = WORK if motion.mechanism.clearance_joints else ()
        model = rules.model_for(motion.mechanism, {"crank_angle": end.crank_angle}, None, watched)
        model = moved(model, end.state)
    if not (model.joints or motion.period or motion.traits["chaos"]):  # a torque speeds it up for ever
        return {"names": [*model.pins], "peak": np.full(len(model.pins), np.nan)}
    times = np.linspace(0.0, turns * float(motion.value("turn_period")), round(turns * per_turn) + 1)
    rtol = min(how.rtol, ORBIT) if motion.orbit is not None else how.rtol
    limits = {"rtol": rtol, "max_steps": rules.steps(how.max_steps), "log_from": 0.0}
    records = follow(model, Request(times[-1], at=times, steps=True, events=True, rates=True, **limits))
    if records.status:
        raise Unsettled(records.status)
    samples, steps = records.samples, records.steps[:, 2:]
    names = FORCES if brief else WANTED
    fine = _history(model, rtol, records, [steps, samples], names)
    largest = partial(_largest, model, records)
    peak, sizes = largest(fine)
    answer = {"names": [*model.joints, *model.pins], "peak": peak} | _of_motion(motion)
    if model.joints:
        answer["impact_speed"] = _impact_speeds(model, records)
    if brief:
        return answer
    coarse, bounds = _history(model, rtol, records, [steps, samples[::2]], names), times[::per_turn]
    each = zip(sizes.T, peak, strict=True)
    answer["force"] = np.stack([_shown(fine["time"], size, most, bounds) for size, most in each], -1)
    answer["peak_error"] = _peak_error(lambda given: largest(given)[0], peak, fine, coarse, bounds[-1] / 2)
    if model.joints:
        hits = _taken_by_hits(records.events, fine, bounds, len(model.joints))
        answer |= _losses(fine, coarse, bounds, hits)
        answer |= {name: (fine[name][-1] - fine[name][0]) / turns for name in WORK}
    return answer


def columns(rows: Sequence[Mapping[str, Any]], keys: Sequence[str]) -> dict[str, Any]:
    """Answers of several motions by key, and names of the joints; NaN where one of them has none."""
    known = next((row for row in rows if "names" in row), {})
    none = {key: np.full_like(known[key], np.nan, dtype=float) for key in keys if key in known}
    found = {key: np.array([row.get(key, none.get(key, np.nan)) for row in rows]) for key in keys}
    return {"names": known.get("names", [])} | found


def _history(
    model: Model, rtol: float, records: Records, parts: list[np.ndarray], wanted: Sequence[str]
) -> History:
    """Quantities at rows in order of time; at an event the integrator's points are its two sides."""
    rows = evaluate.in_order(*parts)
    here = {"joint": model.joints, "pin": model.pins}
    names = [name for name in wanted if here.get(WORDS[name].of, model.joints)]
    found = evaluate.quantities(model, rtol, records, rows).variables(names, "time")
    return {name: values for name, (_, values, _) in found.items()} | {"time": rows[:, 0], "rows": rows}


def _sizes(given: History) -> History:
    """Forces of joints with clearance, and of the others."""
    sizes = {"reaction": given["reaction"]} if "reaction" in given else {}
    if "normal_force" in given:
        sizes = {"force": np.hypot(given["normal_force"], given["tangential_force"])} | sizes
    return sizes


def _shown(times: np.ndarray, sizes: np.ndarray, peak: float, bounds: np.ndarray) -> np.ndarray:
    """A force over the turn with its peak: the first one, then the lowest and the highest of each part."""
    top = int(np.argmax(sizes))
    turn = np.clip(np.searchsorted(bounds, times[top]) - 1, 0, len(bounds) - 2)
    *parts, end = np.linspace(*bounds[turn : turn + 2], SHOWN + 1)
    begins, sizes = np.searchsorted(times, parts), sizes[: np.searchsorted(times, end, "right")].copy()
    sizes[top] = peak
    low, high = (each.reduceat(sizes, begins) for each in (np.minimum, np.maximum))
    rises = sizes[np.append(begins[1:], -1)] > sizes[begins]
    return np.append(sizes[begins[0]], np.where(rises, (low, high), (high, low)).T)


def _largest(model: Model, records: Records, given: History) -> tuple[np.ndarray, np.ndarray]:
    """Largest force of each joint, joints with clearance first; and all their forces."""
    sizes = _sizes(given)
    found, sizes = peaks(Quantities(model, given["rows"], records.start), given["rows"], sizes)
    return np.hstack([*found.values()]), np.hstack([*sizes.values()])


def _peak_error(
    largest: Callable[[History], np.ndarray], peak: np.ndarray, fine: History, coarse: History, half: float
) -> np.ndarray:
    """Error of the largest force of each joint: between the record's halves, and to the coarser record."""
    first = fine["time"] <= half
    early, late = (largest({name: each[part] for name, each in fine.items()}) for part in (first, ~first))
    found = np.maximum(np.abs(early - late), np.abs(peak - largest(coarse)))
    return np.maximum(found, ROUNDING * np.max(peak, initial=0.0))


def _of_motion(motion: Settled) -> dict[str, Any]:
    """Numbers of the motion itself."""
    own = {name: np.array(motion.value(name, ())) for name in ("separations", "impacts", "contact_fraction")}
    own |= {name: float(motion.value(name)) for name in ("turn_period", *EXPONENT)}
    traits = motion.traits
    return own | {"period": motion.period, "traits": np.array([traits[name] for name in CHANGES])}


def _powers(given: History) -> dict[str, np.ndarray]:
    """Powers to integrate for each joint with clearance, W."""
    normal, across = given["normal_force"], given["tangential_velocity"]
    values = (normal * given["normal_velocity"], given["tangential_force"] * across, np.abs(normal * across))
    return dict(zip(PER_TURN, values, strict=True))


def _losses(fine: History, coarse: History, bounds: np.ndarray, hits: np.ndarray) -> dict[str, np.ndarray]:
    """Integrals of each joint with clearance, J per turn, and their errors."""
    (each, unsure), (less, _) = (_integrals(part, bounds, hits) for part in (fine, coarse))
    answer = {key: v for name in PER_TURN for key, v in _mean(name, each[name], less[name]).items()}
    answer["impact_loss_error"] = np.hypot(answer["impact_loss_error"], unsure)
    return answer


def _integrals(given: History, bounds: np.ndarray, hits: np.ndarray) -> tuple[History, np.ndarray]:
    """Integrals of each joint over each turn, J, and errors of the joints' shares of the error of their sum.

    What a stiff contact stores and gives back is many times its loss: the joints' work, which the integrator
    has, says by how much the sum of their losses is off, to which each adds by what passes through it.
    """
    powers = _powers(given)
    found = {name: _per_turn(given, power, bounds) for name, power in powers.items()}
    found["impact_loss"] += hits
    share = _per_turn(given, np.abs(powers["impact_loss"]), bounds) + np.finfo(float).tiny
    share /= share.sum(axis=1, keepdims=True)
    work = np.diff(_at_bounds(given, given["joint_work"], bounds))
    off = work - sum(found[name].sum(axis=1) for name in PER_TURN[:2])
    found["impact_loss"] += share * off[:, None]
    return found, np.abs(np.mean(share * (1 - share) * off[:, None], axis=0))


def _taken_by_hits(events: np.ndarray, given: History, bounds: np.ndarray, joints: int) -> np.ndarray:
    """Energy that impacts of rigid joints take at once, in each turn, J; shape (turns, joints)."""
    rows, taken = events[events[:, KIND] == Event.IMPACT], np.zeros((len(bounds) - 1, joints))
    before, after = (np.searchsorted(given["time"], rows[:, TIME], side) for side in ("left", "right"))
    work = given["joint_work"][after - 1] - given["joint_work"][before]
    turn = np.clip(np.searchsorted(bounds, rows[:, TIME]) - 1, 0, len(taken) - 1)
    np.add.at(taken, (turn, rows[:, JOINT].astype(int)), work)
    return taken


def _mean(name: str, each: np.ndarray, coarse: np.ndarray) -> dict[str, np.ndarray]:
    """Mean over turns, and its error: their scatter, and the difference to the coarser record."""
    mean, scatter = each.mean(axis=0), each.std(axis=0, ddof=1) / math.sqrt(len(each))
    return {name: mean, f"{name}_error": np.hypot(scatter, mean - coarse.mean(axis=0))}


def _per_turn(given: History, power: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Integrals over each turn, by the trapezoidal rule; turns along the first axis."""
    widths = np.diff(given["time"]).reshape(-1, *[1] * (power.ndim - 1))
    whole = np.zeros_like(power)
    np.cumsum((power[1:] + power[:-1]) / 2 * widths, axis=0, out=whole[1:])
    return np.diff(_at_bounds(given, whole, bounds), axis=0)


def _at_bounds(given: History, values: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Values at the bounds of turns."""
    return values[np.searchsorted(given["time"], bounds - 1e-12 * bounds[-1])]


def _impact_speeds(model: Model, records: Records) -> np.ndarray:
    """Largest speed at which contact begins in each joint, or a rigid one hits, m/s; 0 where none does."""
    rows = begun(model, records.events)
    if not len(rows):
        return np.zeros(len(model.joints))
    speeds = np.abs(approach(model, records, rows[:, ROW:])[1])
    own = (speeds[rows[:, JOINT] == j, j] for j in range(len(model.joints)))
    return np.array([np.max(each, initial=0.0) for each in own])
