"""The assessment of a linkage with clearance: loads of its joints, and distances to other motions.

The present motion's forces are held against those of the same linkage with ideal joints (`forces`); from its
present value outward, each clearance and the drive's speed is followed to where contact is first lost or
kept, the motion first leaves or reaches period 1, and chaos begins or ends (`edges`).
Validity: of the one motion that is followed, from the start given; where others coexist, each has its own.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.assessment.edges import HOW, SIDES, Search, edges
from jointplay.analysis.assessment.forces import EXPONENT, PER_TURN, SHOWN, WORK, forces
from jointplay.analysis.assessment.page import answer, page
from jointplay.analysis.assessment.settled import CHANGES, LASTING, plan
from jointplay.analysis.cells import first_bad, handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import Moving, Names, Settling, Small, analysis
from jointplay.analysis.labels import Out, ended
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import placed
from jointplay.analysis.tangents import warm_tangents
from jointplay.display.errors import NOTHING, InputError, Problem
from jointplay.solver.mechanism.base import Natural, Number, is_number, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism, TestSystem

if TYPE_CHECKING:
    import xarray as xr

TURNS, LYAPUNOV_TURNS, RTOL = 20, 200, 1e-7
REACH, STEP, ACCURACY, LASTS = 2.0, 0.0025, 1e-3, 0.01
LOOKED_AT = 32  # turns in which a settled motion must repeat


OVER = ("parameter", "side", "change")
LOSSES = {
    "impact_loss": "energy lost by normal contact per turn",
    "friction_loss": "energy lost by friction per turn",
    "sliding_work": "normal force times sliding distance per turn",
}
CONTACTS = {
    "separations": Out("joint", "separations in a turn"),
    "impacts": Out("joint", "contacts begun in a turn"),
    "contact_fraction": Out("joint", "share of time in contact"),
    "impact_speed": Out("joint", "largest normal speed with which contact begins", "m s-1"),
    **{name: Out("joint", text, "J") for name, text in LOSSES.items()},
    **{f"{name}_error": Out("joint", f"error of: {text}", "J") for name, text in LOSSES.items()},
}
OUTPUTS = Outputs(
    "assess",
    {
        "turn_share": Out("turn_share", "share of a turn"),
        "joint": Out("joint", "joint", ""),
        "parameter": Out("parameter", "what is varied", ""),
        "side": Out("side", "side of the present value", ""),
        "change": Out("change", "what changes", ""),
    },
    {
        "peak_force": Out("joint", "largest joint force", "N"),
        "peak_force_error": Out("joint", "error of the largest joint force", "N"),
        "ideal_peak_force": Out("joint", "largest joint force of the ideal mechanism", "N"),
        "ideal_peak_force_error": Out("joint", "error of the ideal one", "N"),
        "force_ratio": Out("joint", "largest joint force over the ideal mechanism's"),
        "joint_force": Out(("turn_share", "joint"), "joint force", "N"),
        "ideal_joint_force": Out(("turn_share", "joint"), "joint force, ideal mechanism", "N"),
        "clearance": Out("joint", "radial clearance", "m"),
    }
    | CONTACTS
    | {
        "period": Out((), "period in turns, 0 for none"),
        "section_exponent_per_turn": Out((), "largest exponent of the section's map, per turn"),
        "section_standard_error_per_turn": Out((), "its standard error"),
        "crank_speed": Out((), "mean speed of the crank", "rad s-1"),
        "drive_work": Out((), "work of the drive in a turn", "J"),
        "joint_work": Out((), "work taken in by the contacts in a turn", "J"),
        "joint_loss": Out(
            (),
            "sum of the losses in normal contact and friction",
            "J",
            "equal to ``joint_work`` and ``drive_work`` where nothing else takes energy",
        ),
        "joint_loss_error": Out((), "error of the sum of the losses", "J"),
        "present": Out("change", "present motion", flags=("no", "yes", "unknown")),
        "edge_ratio": Out(OVER, "where it changes, over the present value"),
        "edge_ratio_error": Out(OVER, "its error"),
        "bracket_low": Out(OVER, "lower end of its bracket"),
        "bracket_high": Out(OVER, "upper end of its bracket"),
        "return_ratio": Out(
            OVER,
            "where it is first found as at present again, beyond the change",
            about="of the values looked at; NaN: not met",
        ),
        "edge_speed": Out(OVER, "nominal speed of the crank there", "rad s-1"),
        "present_value": Out("parameter", "present value, in the units of parameter_units"),
        "parameter_units": Out("parameter", "units of the parameter"),
        "parameter_name": Out("parameter", "the parameter"),
        "limit_ratio": Out(OVER[:2], "last value looked at, over the present one"),
        "values_looked_at": Out(OVER[:2], "values looked at, in even steps of the logarithm"),
        "window_low": Out((*OVER[:2], "window"), "lower end of a window in chaos, over the present value"),
        "window_high": Out((*OVER[:2], "window"), "its upper end"),
        "window_period": Out((*OVER[:2], "window"), "period of the motion in the window, turns; 0 for none"),
        "found_by": Out(OVER, "how it was found", flags=HOW),
        "side_status": Out(OVER[:2], "why no further values were looked at", flags=STATUS),
        "preparation": Out((), "time to compile or load functions", "s"),
        "step": Out((), "relative distance of the values looked at first"),
        "lasting_share": Out((), "share of the parameter over which a change of chaos lasts"),
        "lasting_turns": Out((), "turns that chaos lasted, beside a chaotic motion"),
        "status": Out((), "how it ended", flags=STATUS),
        "wall_time": RUN["wall_time"],
    },
    answer,
    table=page,
)
Answer = Mapping[str, Any]


def _assessable(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    if not isinstance(mechanism, Mechanism):
        yield Problem("mechanism", mechanism.name, "a linkage is accepted, no test system")
        return
    if not mechanism.clearance_joints:
        yield Problem("mechanism.joints", "no clearance", "clearance in at least one joint is needed")
    for joint in mechanism.clearance_joints:
        if joint.kind == "prismatic":
            where = f"mechanism.joints.{joint.name}.clearance"
            yield Problem(where, joint.clearance, "0 is accepted of a guide: clearance in others is assessed")
    if mechanism.drive is None:
        yield Problem("mechanism.drive", NOTHING, "a drive that turns the crank is needed")


def _along_fits(mechanism: Mechanism | TestSystem, along: Sequence[str] | None) -> Iterator[Problem]:
    if along == () or len({*(along or ())}) < len(along or ()):
        yield Problem("along", along, "one parameter or several, each once, are accepted")
    several = isinstance(mechanism, Mechanism) and len(mechanism.clearance_joints) > 1
    for i, key in enumerate(along or ()):
        place = f"along[{i}]"
        value = Parameter.named(mechanism, key, f"along.{key}").value
        if not is_number(value) or value == 0:
            yield Problem(place, key, "what has a value here, and not 0, is accepted")
        elif key == "clearance" and several:
            yield Problem(
                place, key, "one of several clearances is accepted by its path, joints.NAME.clearance"
            )


@analysis(_assessable, _along_fits, "model", rules.turns_alike, usual={"rtol": RTOL}, outputs=OUTPUTS)
def assess(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model,
    along: Names | None = None,
    reach: Annotated[Number, Field(gt=1, le=100), unit("factor", "1")] = REACH,
    step: Annotated[Small, unit("relative step", "1")] = STEP,
    accuracy: Annotated[Small, unit("relative width", "1")] = ACCURACY,
    lasting: Annotated[Small, unit("relative width", "1")] = LASTS,
    turns: Annotated[Natural, Field(ge=2)] = TURNS,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Assess a linkage with clearance: forces, losses, and distances to other motions.

    Parameters
    ----------
    mechanism : Mechanism
        With clearance in a joint, and a drive.
    along : sequence of str, optional
        What is varied, each alone, as in `bifurcation`; every clearance, and the motor's gear ratio or the
        constant speed, if left out.
    reach : float
        Each is followed from its present value down to this fraction, and up to this multiple, of it.
    step : float
        Relative distance of the values looked at first; ten times that where the present motion is chaotic,
        twice that beyond the end of period 1. What begins and ends within it may be missed.
    accuracy : float
        Relative distance of the two values that enclose a change in the end; in chaos not below `step`.
    lasting : float
        Share of the parameter over which a change of a chaotic motion has to last. One that does not is a
        window in chaos.
    turns : int
        Turns over which forces are recorded.
    lyapunov_turns : int
        Turns over which the present motion's exponent is averaged; 0.3 of them at other values.
    n_jobs : int, optional
        Worker processes, 2 if left out.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    how = plan(motion["transient"], LOOKED_AT, lyapunov_turns, motion["rtol"], motion["max_steps"])
    ideal = mechanism.replace(clearance=0.0)
    initial, lasted = motion["initial"], LASTING[0] * motion["transient"]
    warm([model, rules.model_for(mechanism, initial, None, WORK), placed(ideal, None)])
    warm_tangents(model)
    ready = time.perf_counter()
    keys = parameters_of(mechanism) if along is None else along
    work = {"mechanism": mechanism, "start": initial, "turns": turns}
    sides = {"mechanism": mechanism, "start": initial, "search": Search(reach, step, accuracy, lasting)}
    cells = [work, work | {"mechanism": ideal, "start": None}]
    cells += [sides | {"key": key, "side": side} for key in keys for side in SIDES]
    answers = handed_out(answered, [each | {"how": how} for each in cells], motion["progress"], n_jobs)
    told = {"preparation": ready - began, "step": step, "lasting_share": lasting, "lasting_turns": lasted}
    told |= ended(status_of(answers), began)
    return assembled(mechanism, keys, answers).assign(OUTPUTS.variables_of(told)[0])


def status_of(answers: Sequence[Answer]) -> int:
    """The present motion's status, else the ideal one's; sides have their own."""
    return first_bad(answers[:2])


def assembled(mechanism: Mechanism, keys: Sequence[str], answers: Sequence[Answer]) -> xr.Dataset:
    """Make the dataset: of the present motion, of the ideal one, and of each parameter's sides."""
    now, ideal, *sides = answers
    joints = [joint.name for joint in mechanism.joints]
    values = _forces(joints, now, ideal) | _contacts(mechanism, joints, now) | _motion(now)
    values |= _edges(mechanism, keys, sides)
    labels = {"joint": joints, "parameter": list(keys), "side": list(SIDES), "change": list(CHANGES)}
    values |= {name: np.array(each, dtype=str) for name, each in labels.items()}
    return OUTPUTS.dataset(values | {"turn_share": np.linspace(0, 1, SHOWN + 1)})


def _on(joints: list[str], answer: Answer, key: str, rows: int | None = None) -> np.ndarray:
    """Values of an answer in the order of the mechanism's joints; NaN where it has none."""
    result = np.full((len(joints),) if rows is None else (rows, len(joints)), np.nan)
    given = np.asarray(answer.get(key, np.zeros(0)))
    for i, name in enumerate(answer.get("names", ())[: given.shape[-1]]):
        result[..., joints.index(name)] = given[..., i]
    return result


def _forces(joints: list[str], now: Answer, ideal: Answer) -> dict[str, Any]:
    peak, like = _on(joints, now, "peak"), _on(joints, ideal, "peak")
    return {
        "peak_force": peak,
        "peak_force_error": _on(joints, now, "peak_error"),
        "ideal_peak_force": like,
        "ideal_peak_force_error": _on(joints, ideal, "peak_error"),
        "force_ratio": peak / like,
        "joint_force": _on(joints, now, "force", SHOWN + 1),
        "ideal_joint_force": _on(joints, ideal, "force", SHOWN + 1),
    }


def _contacts(mechanism: Mechanism, joints: list[str], now: Answer) -> dict[str, Any]:
    clearance = np.asarray([joint.clearance for joint in mechanism.joints])
    return {"clearance": clearance} | {name: _on(joints, now, name) for name in CONTACTS}


def _motion(now: Answer) -> dict[str, Any]:
    taken = float(sum(np.sum(now.get(name, np.nan)) for name in PER_TURN[:2]))
    doubt = float(np.hypot(*(np.sum(now.get(f"{name}_error", np.nan)) for name in PER_TURN[:2])))
    exponent, error = (float(now.get(name, np.nan)) for name in EXPONENT)
    return {
        "period": float(now.get("period", np.nan)),
        "section_exponent_per_turn": exponent,
        "section_standard_error_per_turn": error,
        "crank_speed": 2 * np.pi / now.get("turn_period", np.nan),
        "drive_work": now.get("drive_work", np.nan),
        "joint_work": now.get("joint_work", np.nan),
        "joint_loss": taken,
        "joint_loss_error": doubt,
        "present": now.get("traits", np.full(len(CHANGES), 2)),
    }


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
    most = max(len(each.get("windows", ())) for each in sides)
    windows = np.full((len(sides), most, 3), np.nan)
    for rows, each in zip(windows, sides, strict=True):
        for row, window in zip(rows, each.get("windows", ()), strict=False):
            row[:] = window
    windows = windows.reshape(*shape[:2], most, 3)
    ends = np.sort(windows[..., :2] / values[:, None, None, None], axis=-1)
    return {
        "edge_ratio": ratio["edge"],
        "edge_ratio_error": np.abs(ratio["error"]),
        "bracket_low": np.minimum(ratio["low"], ratio["high"]),
        "bracket_high": np.maximum(ratio["low"], ratio["high"]),
        "return_ratio": ratio["back"],
        "edge_speed": np.reshape(speeds, shape),
        "present_value": values,
        "parameter_units": np.asarray([each.cf_units for each in along]),
        "parameter_name": np.asarray([each.noun for each in along]),
        "limit_ratio": limits / values[:, None],
        "values_looked_at": np.reshape([each.get("looked", 0) for each in sides], shape[:2]),
        "window_low": ends[..., 0],
        "window_high": ends[..., 1],
        "window_period": windows[..., 2],
        "found_by": how,
        "side_status": np.array([each["status"] for each in sides]).reshape(shape[:2]),
    }


def _speed(mechanism: Mechanism, key: str, value: float) -> float:
    """Nominal speed of the drive where a parameter has a value, rad/s."""
    try:
        return float(mechanism.varied({key: float(value)}).drive.nominal_speed)
    except InputError:  # not met
        return float("nan")


def answered(**keywords: Any) -> dict[str, Any]:
    """Answer of a cell: forces of a motion, or the edges on one side."""
    return edges(**keywords) if "key" in keywords else forces(**keywords)


def parameters_of(mechanism: Mechanism) -> tuple[str, ...]:
    """Parameters varied by default: every clearance, and the numbers that set the drive's speed."""
    loose = tuple(f"joints.{joint.name}.clearance" for joint in mechanism.joints if joint.clearance > 0)
    return (*loose, *(word for word in ("gear_ratio", "speed") if Parameter(mechanism, word).value))
