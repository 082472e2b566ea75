"""The four conclusions of a paper, graded by stated rules on computed numbers.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002), section 5. Here are the numbers; the rules
are in `jointplay.lab.paper.grades`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.cells import Steps, divided, handed_out, warm
from jointplay.analysis.evaluate import flags
from jointplay.analysis.keywords import Moving, Progress, Rtol, analysis, listed
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import quantity
from jointplay.lab.paper.answers import motions
from jointplay.lab.paper.character import character
from jointplay.lab.paper.grades import CLAIMS, GRADES, graded
from jointplay.lab.paper.peaks import WINDOWS, peaks
from jointplay.lab.paper.reading_list import PANELS
from jointplay.lab.paper.readings import printed_fits
from jointplay.mechanism import catalog
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.base import Count, Natural
from jointplay.mechanism.beam import DampingRatio
from jointplay.mechanism.records import CrankAngle, Mechanism

DAMPING_RATIOS = (0.0, 0.005, 0.01, 0.02, 0.05)
JOINTS = ("ideal", "clearance")
STEADY = {"a": 10, "b": 10, "c": 60}  # turns of the steady window: panel c's motion is irregular
LAST = 50  # section points by which the ends of two starts are compared

PEAKS = {  # over panel, joints, links and window
    "peak_force": ("N", "largest force in joint B"),
    "peak_coupler_acceleration": ("rad s-2", "largest angular acceleration of the coupler"),
    "peak_crank_acceleration": ("rad s-2", "largest angular acceleration of the crank"),
    "impacts": ("1", "contacts begun in a turn"),
    "peak_deflection": ("m", "largest mid-point deflection of the coupler"),
    "rms_deflection": ("m", "root mean square of the mid-point deflection of the coupler"),
    "vibration": ("1", "fast part of the deflection over the whole"),
    "irregularity": ("1", "change of the deflection from turn to turn over the whole"),
}
MOTION = {  # over panel and start
    "separations": ("1", "losses of contact in a turn"),
    "contact_fraction": ("1", "fraction of time in contact"),
    "growth": ("1", "mean logarithm of the growth of a difference in a turn"),
    "growth_standard_error": ("1", "standard error of the growth"),
}


@divided
@analysis(printed_fits)
def claims(
    mechanism: Moving | None = None,
    *,
    damping_ratios: listed(DampingRatio, "a list of damping ratios, 0 to 1") = DAMPING_RATIOS,
    turns: Natural = 300,
    transient: Count = 400,
    growth_turns: Natural = 200,
    rtol: Rtol = 1e-8,
    max_steps: Natural | None = None,
    n_jobs: Natural | None = None,
    progress: Progress = None,
) -> Steps:
    """Compute what the paper's conclusions speak of, and grade them.

    Parameters
    ----------
    mechanism : Mechanism, optional
        Rigid, as printed; the catalog's `chunmei2002` if left out. Each panel of Figure 12 sets clearance and
        gear ratio.
    damping_ratios : sequence of float
        Of the elastic coupler; 0 and 0.01 are always among them.
    turns, transient, growth_turns : int
        As in `readings`, for the fourth conclusion.
    rtol : float
        Relative tolerance of a step of the time histories; the fourth conclusion's motions have their own.
    max_steps : int, optional
        Attempted steps after which a run stops.
    n_jobs : int, optional
        Worker processes.
    progress : callable, optional
        Called with the fraction done.

    Returns
    -------
    xarray.Dataset
        Over ``claim``: ``grade`` (flags undecidable, not, partly, reproduced), ``evidence`` (text), and the
        coordinate ``claim_text``. Over ``panel`` (a, b, c; coordinates ``clearance``, ``gear_ratio``),
        ``joints`` (ideal, clearance), ``links`` (rigid, then elastic by ``damping_ratio``) and ``window``
        (start_up, steady): ``peak_force`` (N), ``peak_coupler_acceleration``, ``peak_crank_acceleration``
        (rad s-2), ``impacts``, ``peak_deflection``, ``rms_deflection`` (m), ``vibration``,
        ``irregularity``: means over the turns of the window, each with its ``…_error``, the standard error
        (0 for the single turn of start-up). Over ``panel`` and ``start``: ``separations``,
        ``contact_fraction``, ``period``, ``growth``, ``growth_standard_error``, ``motion``, ``distance``
        (of its last section points from those of the first start, over the clearance). ``status`` is ok if
        every run was; ``peak_status`` and ``motion_status`` tell them apart.

    Raises
    ------
    InputError
        If the mechanism is no motor-driven linkage with a coupler and contact data at B, or a damping ratio
        is not between 0 and 1.
    """
    printed = catalog.chunmei2002() if mechanism is None else mechanism
    ratios = sorted({0.0, 0.01, *damping_ratios})
    bodies: list[dict[str, Any]] = [
        {"elastic": ()},
        *({"elastic": ("coupler",), "elements": 2, "damping_ratio": r} for r in ratios),
    ]
    histories = [
        {
            "mechanism": _panel(printed, p, joints).replace(**body),
            "rtol": rtol,
            "turns": STEADY[p],
            "max_steps": max_steps,
        }
        for p in PANELS
        for joints in JOINTS
        for body in bodies
    ]
    lengths = {"turns": turns, "transient": transient, "growth_turns": growth_turns}
    lengths["max_steps"] = max_steps
    motions = [
        {"mechanism": one, "initial": start} | lengths
        for one in (_panel(printed, p, "clearance") for p in PANELS)
        for start in starts(one).values()
    ]
    warm(assemble(one["mechanism"]) for one in histories)
    warm(assemble(one["mechanism"], None, quantity(CrankAngle(), one["mechanism"])) for one in motions)
    cells = [("peaks", one) for one in histories] + [("character", one) for one in motions]
    answers = yield from handed_out(cell, [{"kind": kind, "keywords": one} for kind, one in cells], progress)
    numbers = _peaks(answers[: len(histories)], ratios) | _motions(answers[len(histories) :])
    return _finished(xr.Dataset(numbers, _coordinates(ratios)))


def cell(kind: str, keywords: dict[str, Any]) -> dict[str, Any]:
    """One run: `peaks` of a time history, or the `character` of a motion."""
    return {"peaks": peaks, "character": character}[kind](**keywords)


def _panel(printed: Mechanism, panel: str, joints: str) -> Mechanism:
    clearance, ratio = PANELS[panel]
    return printed.replace(clearance=clearance if joints == "clearance" else 0.0, gear_ratio=ratio)


def starts(mechanism: Mechanism) -> dict[str, dict[str, Any] | None]:
    """Initial states at crank angle 0: the usual one, two other crank speeds, a journal set aside.

    The last lets the coupler's end lie nine tenths of the clearance beside the bearing's centre.
    """
    model, drive = assemble(mechanism), mechanism.drive
    names = mechanism.links
    angles = dict(zip((link.name for link in names), model.state[: len(names)].tolist(), strict=True))
    speeds = dict(zip((link.name for link in names), model.state[len(names) :].tolist(), strict=True))
    angles["coupler"] -= 0.9 * model.clearances[0] / mechanism.link("coupler").length
    slow, fast = ({"crank_speed": factor * drive.nominal_speed} for factor in (0.8, 1.2))
    return {
        "ideal": None,
        "slower_crank": slow,
        "faster_crank": fast,
        "journal_aside": {"angle": angles, "angular_velocity": speeds},
    }


START_NAMES = ("ideal", "slower_crank", "faster_crank", "journal_aside")


def _peaks(answers: list[dict[str, Any]], ratios: list[float]) -> dict[str, Any]:
    dims, shape = ("panel", "joints", "links"), (len(PANELS), len(JOINTS), 1 + len(ratios))
    missing, found = [(math.nan, math.nan)] * len(WINDOWS), {}
    for name, (units, text) in PEAKS.items():
        rows = np.array([answer.get(name, missing) for answer in answers], dtype=float)
        values = rows.reshape(*shape, len(WINDOWS), 2)
        found[name] = ((*dims, "window"), values[..., 0], {"units": units, "long_name": text})
        told = {"units": units, "long_name": f"standard error: {text}"}
        found[f"{name}_error"] = ((*dims, "window"), values[..., 1], told)
    found["peak_status"] = (dims, _status(answers, shape), {"long_name": "how the run ended"} | flags(STATUS))
    return found


def _motions(answers: list[dict[str, Any]]) -> dict[str, Any]:
    dims, shape = ("panel", "start"), (len(PANELS), len(START_NAMES))
    found = motions(answers, dims, shape, MOTION)
    rows = [answers[i : i + shape[1]] for i in range(0, len(answers), shape[1])]
    told = {
        "units": "1",
        "long_name": "farthest of the last section points from the first start's, over clearance",
    }
    found["distance"] = (dims, np.array([[_distance(row[0], one) for one in row] for row in rows]), told)
    found["motion_status"] = (
        dims,
        _status(answers, shape),
        {"long_name": "how the run ended"} | flags(STATUS),
    )
    return found


def _distance(first: dict[str, Any], other: dict[str, Any]) -> float:
    """How far the farthest of the last points of one motion lies from the nearest of another's."""
    if "points" not in first or "points" not in other:
        return math.nan
    a, b = other["points"][-LAST:], first["points"][-LAST:]
    return float(np.linalg.norm(a[:, None] - b[None], axis=-1).min(axis=1).max())


def _status(answers: list[dict[str, Any]], shape: tuple[int, ...]) -> np.ndarray:
    return np.array([answer["status"] for answer in answers], dtype=np.int8).reshape(shape)


def _coordinates(ratios: list[float]) -> dict[str, Any]:
    links = ["rigid", *(f"elastic {ratio:g}" for ratio in ratios)]
    plain = {"panel": list(PANELS), "joints": list(JOINTS), "links": links, "window": list(WINDOWS)}
    plain |= {"start": list(START_NAMES), "claim": list(CLAIMS)}
    names = {
        "panel": "panel of Figure 12",
        "joints": "joint B",
        "links": "coupler",
        "window": "turns looked at",
    }
    names |= {"start": "initial state", "claim": "conclusion of the paper"}
    found: dict[str, Any] = {dim: (dim, values, {"long_name": names[dim]}) for dim, values in plain.items()}
    told = {"units": "1", "long_name": "structural damping ratio of the coupler"}
    found["damping_ratio"] = ("links", [math.nan, *ratios], told)
    for place, (name, units, text) in enumerate(
        (("clearance", "m", "radial clearance"), ("gear_ratio", "1", "gear ratio"))
    ):
        values = [panel[place] for panel in PANELS.values()]
        found[name] = ("panel", values, {"units": units, "long_name": text})
    found["claim_text"] = ("claim", list(CLAIMS.values()), {"long_name": "what the paper concludes"})
    return found


def _finished(numbers: xr.Dataset) -> xr.Dataset:
    """With grades, evidence and an overall status."""
    grades = {claim: graded(claim, numbers) for claim in CLAIMS}
    codes = np.array([GRADES.index(grade) for grade, _ in grades.values()], dtype=np.int8)
    failed = [
        code for name in ("peak_status", "motion_status") for code in numbers[name].values.ravel() if code
    ]
    status = {"long_name": "ok, or how the first run that failed ended"} | flags(STATUS)
    return numbers.assign(
        grade=("claim", codes, {"long_name": "how the conclusion stands"} | flags(GRADES)),
        evidence=(
            "claim",
            [text for _, text in grades.values()],
            {"long_name": "the numbers behind the grade"},
        ),
        status=((), np.int8(failed[0] if failed else 0), status),
    ).assign_attrs(Conventions="CF-1.11", kind="claims")
