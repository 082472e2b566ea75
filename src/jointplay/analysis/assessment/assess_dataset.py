"""The dataset of an assessment, made of the answers of its cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.analysis.assessment.edges import HOW, SIDES
from jointplay.analysis.assessment.forces import EXPONENT, PER_TURN, SHOWN
from jointplay.analysis.assessment.settled import CHANGES
from jointplay.analysis.cells import first_bad
from jointplay.analysis.labels import coded, labelled
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism

if TYPE_CHECKING:
    import xarray as xr

OVER = ("parameter", "side", "change")
LOSSES = {
    "impact_loss": "energy lost by normal contact per turn",
    "friction_loss": "energy lost by friction per turn",
    "sliding_work": "normal force times sliding distance per turn",
}
CONTACTS = {
    "separations": ("1", "separations in a turn"),
    "impacts": ("1", "contacts begun in a turn"),
    "contact_fraction": ("1", "share of time in contact"),
    "impact_speed": ("m s-1", "largest normal speed with which contact begins"),
    **{name: ("J", text) for name, text in LOSSES.items()},
    **{f"{name}_error": ("J", f"error of: {text}") for name, text in LOSSES.items()},
}
Answer = Mapping[str, Any]


def status(answers: Sequence[Answer]) -> int:
    """The present motion's status, else the ideal one's; sides have their own."""
    return first_bad(answers[:2])


def assembled(mechanism: Mechanism, keys: Sequence[str], answers: Sequence[Answer]) -> xr.Dataset:
    """Make the dataset: of the present motion, of the ideal one, and of each parameter's sides."""
    import xarray as xr

    now, ideal, *sides = answers
    joints = [joint.name for joint in mechanism.joints]
    variables = _forces(joints, now, ideal) | _contacts(mechanism, joints, now) | _motion(now)
    variables |= _edges(mechanism, keys, sides)
    texts = {
        "joint": (joints, "joint"),
        "parameter": (list(keys), "what is varied"),
        "side": (list(SIDES), "side of the present value"),
        "change": (list(CHANGES), "what changes"),
    }
    coords = labelled({"turn_share": (np.linspace(0, 1, SHOWN + 1), "1", "share of a turn")}, "turn_share")
    for name, (labels, text) in texts.items():
        coords[name] = name, np.array(labels, dtype=str), {"long_name": text}
    return xr.Dataset(variables, coords, {"Conventions": "CF-1.11", "kind": "assess"})


def _on(joints: list[str], answer: Answer, key: str, rows: int | None = None) -> np.ndarray:
    """Values of an answer in the order of the mechanism's joints; NaN where it has none."""
    result = np.full((len(joints),) if rows is None else (rows, len(joints)), np.nan)
    given = np.asarray(answer.get(key, np.zeros(0)))
    for i, name in enumerate(answer.get("names", ())[: given.shape[-1]]):
        result[..., joints.index(name)] = given[..., i]
    return result


def _forces(joints: list[str], now: Answer, ideal: Answer) -> dict[str, Any]:
    peak, like = _on(joints, now, "peak"), _on(joints, ideal, "peak")
    table = {
        "peak_force": (peak, "N", "largest joint force"),
        "peak_force_error": (_on(joints, now, "peak_error"), "N", "error of the largest joint force"),
        "ideal_peak_force": (like, "N", "largest joint force of the ideal mechanism"),
        "ideal_peak_force_error": (_on(joints, ideal, "peak_error"), "N", "error of the ideal one"),
        "force_ratio": (peak / like, "1", "largest joint force over the ideal mechanism's"),
    }
    turn = {
        "joint_force": (_on(joints, now, "force", SHOWN + 1), "N", "joint force"),
        "ideal_joint_force": (_on(joints, ideal, "force", SHOWN + 1), "N", "joint force, ideal mechanism"),
    }
    return labelled(table, "joint") | labelled(turn, ("turn_share", "joint"))


def _contacts(mechanism: Mechanism, joints: list[str], now: Answer) -> dict[str, Any]:
    clearance = [joint.clearance for joint in mechanism.joints]
    table = {"clearance": (clearance, "m", "radial clearance")}
    table |= {name: (_on(joints, now, name), *about) for name, about in CONTACTS.items()}
    return labelled(table, "joint")


def _motion(now: Answer) -> dict[str, Any]:
    taken = float(sum(np.sum(now.get(name, np.nan)) for name in PER_TURN[:2]))
    doubt = float(np.hypot(*(np.sum(now.get(f"{name}_error", np.nan)) for name in PER_TURN[:2])))
    exponent, error = (float(now.get(name, np.nan)) for name in EXPONENT)
    table = {
        "period": (float(now.get("period", np.nan)), "1", "period in turns, 0 for none"),
        "section_exponent_per_turn": (exponent, "1", "largest exponent of the section's map, per turn"),
        "section_standard_error_per_turn": (error, "1", "its standard error"),
        "crank_speed": (2 * np.pi / now.get("turn_period", np.nan), "rad s-1", "mean speed of the crank"),
        "drive_work": (now.get("drive_work", np.nan), "J", "work of the drive in a turn"),
        "joint_work": (now.get("joint_work", np.nan), "J", "work taken in by the contacts in a turn"),
        "joint_loss": (taken, "J", "sum of the losses in normal contact and friction"),
        "joint_loss_error": (doubt, "J", "error of the sum of the losses"),
    }
    traits = np.asarray(now.get("traits", np.full(len(CHANGES), 2)), dtype=np.int8)
    return labelled(table) | {"present": coded("change", traits, "present motion", ("no", "yes", "unknown"))}


def _edges(mechanism: Mechanism, keys: Sequence[str], sides: Sequence[Answer]) -> dict[str, Any]:
    shape = (len(keys), len(SIDES), len(CHANGES))
    along = [Parameter(mechanism, key) for key in keys]
    values = np.array([float(each.value) for each in along])
    none = np.full(len(CHANGES), np.nan)
    names = ("edge", "error", "low", "high", "back")
    found = {n: np.array([each.get(n, none) for each in sides]).reshape(shape) for n in names}
    ratio = {name: each / values[:, None, None] for name, each in found.items()}
    limits = np.array([each.get("limit", np.nan) for each in sides]).reshape(shape[:2])
    how = np.array([each.get("how", np.zeros(len(CHANGES))) for each in sides]).reshape(shape)
    speeds = [[_speed(mechanism, key, v) for v in found["edge"][i].flat] for i, key in enumerate(keys)]
    table = {
        "edge_ratio": (ratio["edge"], "1", "where it changes, over the present value"),
        "edge_ratio_error": (np.abs(ratio["error"]), "1", "its error"),
        "bracket_low": (np.minimum(ratio["low"], ratio["high"]), "1", "lower end of its bracket"),
        "bracket_high": (np.maximum(ratio["low"], ratio["high"]), "1", "upper end of its bracket"),
        "return_ratio": (
            ratio["back"],
            "1",
            "where it is first found as at present again, beyond the change",
        ),
        "edge_speed": (np.reshape(speeds, shape), "rad s-1", "nominal speed of the crank there"),
    }
    own = {
        "present_value": (values, "1", "present value, in the units of parameter_units"),
        "parameter_units": ([each.cf_units for each in along], "1", "units of the parameter"),
        "parameter_name": ([each.noun for each in along], "1", "the parameter"),
    }
    looked = np.reshape([each.get("looked", 0) for each in sides], shape[:2])
    limit = {
        "limit_ratio": (limits / values[:, None], "1", "last value looked at, over the present one"),
        "values_looked_at": (looked, "1", "values looked at, in even steps of the logarithm"),
    }
    most = max(len(each.get("windows", ())) for each in sides)
    windows = np.full((len(sides), most, 3), np.nan)
    for rows, each in zip(windows, sides, strict=True):
        for row, window in zip(rows, each.get("windows", ()), strict=False):
            row[:] = window
    windows = windows.reshape(*shape[:2], most, 3)
    ends = np.sort(windows[..., :2] / values[:, None, None, None], axis=-1)
    met = {
        "window_low": (ends[..., 0], "1", "lower end of a window in chaos, over the present value"),
        "window_high": (ends[..., 1], "1", "its upper end"),
        "window_period": (windows[..., 2], "1", "period of the motion in the window, turns; 0 for none"),
    }
    codes = np.array([each["status"] for each in sides]).reshape(shape[:2])
    return {
        **labelled(table, OVER),
        **labelled(own, "parameter"),
        **labelled(limit, OVER[:2]),
        **labelled(met, (*OVER[:2], "window")),
        "found_by": coded(OVER, how, "how it was found", HOW),
        "side_status": coded(OVER[:2], codes, "why no further values were looked at"),
    }


def _speed(mechanism: Mechanism, key: str, value: float) -> float:
    """Nominal speed of the drive where a parameter has a value, rad/s."""
    try:
        return float(mechanism.varied({key: float(value)}).drive.nominal_speed)
    except InputError:  # not met
        return float("nan")
