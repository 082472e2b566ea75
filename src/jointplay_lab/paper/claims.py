"""The four conclusions of a paper, graded by stated rules on computed numbers.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002), section 5. Here are the numbers; the rules
are in `jointplay_lab.paper.grades`.
"""

from __future__ import annotations

import math
from typing import Any, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.labels import coded, number
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import quantity
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural
from jointplay.solver.mechanism.parts.beam import DampingRatio
from jointplay.solver.mechanism.records import CrankAngle, Mechanism
from jointplay_lab.paper.character import character, variables
from jointplay_lab.paper.grades import CLAIMS, GRADES, graded
from jointplay_lab.paper.reading_list import PANELS
from jointplay_lab.paper.readings import panel_coordinates, printed_fits
from jointplay_lab.paper.response_peaks import WINDOWS, peaks

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


@analysis(printed_fits)
def claims(
    mechanism: Moving | None = None,
    *,
    damping_ratios: listed(DampingRatio, "a list of damping ratios, 0 to 1") = DAMPING_RATIOS,
    turns: Natural = 300,
    transient: Count = 400,
    growth_turns: Natural = 200,
    n_jobs: Natural | None = None,
    **motion: Unpack[Integration],
) -> xr.Dataset:
    """Compute what the paper's conclusions speak of, and grade them.

    Parameters
    ----------
    mechanism : Mechanism, optional
        As printed; the catalog's `chunmei2002` if left out. Each panel of Figure 12 sets clearance and gear
        ratio, and each case which links bend, whatever bends in what is given.
    damping_ratios : sequence of float
        Of the elastic coupler; 0 and 0.01 are always among them.
    turns, transient, growth_turns : int
        As in `readings`, for the fourth conclusion.
    rtol : float
        Relative tolerance of a step of the time histories; the fourth conclusion's motions have their own.
    n_jobs
        As in `readings`.

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
    elastic = {"elastic": ("coupler",), "elements": 2}
    bodies: list[dict[str, Any]] = [{"elastic": ()}, *(elastic | {"damping_ratio": r} for r in ratios)]
    limits = {key: motion[key] for key in ("rtol", "max_steps")}
    histories = [
        {"mechanism": _panel(printed, p, joints).replace(**body), "turns": STEADY[p]} | limits
        for p in PANELS
        for joints in JOINTS
        for body in bodies
    ]
    lengths = {"turns": turns, "transient": transient, "growth_turns": growth_turns}
    motions = [
        {"mechanism": one, "initial": start, "max_steps": motion["max_steps"]} | lengths
        for one in (_panel(printed, p, "clearance") for p in PANELS)
        for start in starts(one).values()
    ]
    warm(assemble(one["mechanism"]) for one in histories)
    warm(assemble(one["mechanism"], None, quantity(CrankAngle(), one["mechanism"])) for one in motions)
    cells = [{"kind": "peaks", "keywords": one} for one in histories]
    cells += [{"kind": "character", "keywords": one} for one in motions]
    answers = handed_out(cell, cells, motion["progress"], n_jobs)
    numbers = _peaks(answers[: len(histories)], ratios) | _motions(answers[len(histories) :])
    return _finished(xr.Dataset(numbers, _coordinates(ratios)))


def cell(kind: str, keywords: dict[str, Any]) -> dict[str, Any]:
    """Evaluate one run: the `peaks` of a time history, or the `character` of a motion."""
    return {"peaks": peaks, "character": character}[kind](**keywords)


def _panel(printed: Mechanism, panel: str, joints: str) -> Mechanism:
    clearance, ratio = PANELS[panel]
    rigid = {"gear_ratio": ratio, "elastic": ()}
    return printed.replace(clearance=clearance if joints == "clearance" else 0.0, **rigid)


def starts(mechanism: Mechanism) -> dict[str, dict[str, Any] | None]:
    """Initial states at crank angle 0: the usual one, two other crank speeds, a journal set aside.

    The last lets the coupler's end lie nine tenths of the clearance beside the bearing's centre.
    """
    model, drive = assemble(mechanism), mechanism.drive
    names = [link.name for link in mechanism.links]
    angles = dict(zip(names, model.state[: len(names)].tolist(), strict=True))
    speeds = dict(zip(names, model.state[len(names) :].tolist(), strict=True))
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
        found[name] = number((*dims, "window"), values[..., 0], units, text)
        found[f"{name}_error"] = number((*dims, "window"), values[..., 1], units, f"standard error: {text}")
    return found | {"peak_status": _status(answers, dims, shape)}


def _motions(answers: list[dict[str, Any]]) -> dict[str, Any]:
    dims, shape = ("panel", "start"), (len(PANELS), len(START_NAMES))
    found = variables(answers, dims, shape, MOTION)
    rows = [answers[i : i + shape[1]] for i in range(0, len(answers), shape[1])]
    distances = np.array([[_distance(row[0], one) for one in row] for row in rows])
    text = "farthest of the last section points from the first start's, over clearance"
    found["distance"] = number(dims, distances, "1", text)
    return found | {"motion_status": _status(answers, dims, shape)}


def _distance(first: dict[str, Any], other: dict[str, Any]) -> float:
    """Largest distance of the last points of one motion from the nearest of another's."""
    if "points" not in first or "points" not in other:
        return math.nan
    a, b = other["points"][-LAST:], first["points"][-LAST:]
    return float(np.linalg.norm(a[:, None] - b[None], axis=-1).min(axis=1).max())


def _status(answers: list[dict[str, Any]], dims: tuple[str, ...], shape: tuple[int, ...]) -> Any:
    return coded(
        dims, np.reshape([answer["status"] for answer in answers], shape), "how the run ended", STATUS
    )


def _coordinates(ratios: list[float]) -> dict[str, Any]:
    links = ["rigid", *(f"elastic {ratio:g}" for ratio in ratios)]
    plain = {"panel": list(PANELS), "joints": list(JOINTS), "links": links, "window": list(WINDOWS)}
    plain |= {"start": list(START_NAMES), "claim": list(CLAIMS)}
    names = {"panel": "panel of Figure 12", "joints": "joint B", "links": "coupler"}
    names |= {"window": "turns looked at", "start": "initial state", "claim": "conclusion of the paper"}
    found: dict[str, Any] = {dim: (dim, values, {"long_name": names[dim]}) for dim, values in plain.items()}
    text = "structural damping ratio of the coupler"
    found["damping_ratio"] = number("links", [math.nan, *ratios], "1", text)
    found["claim_text"] = ("claim", list(CLAIMS.values()), {"long_name": "what the paper concludes"})
    return found | panel_coordinates(PANELS)


def _finished(numbers: xr.Dataset) -> xr.Dataset:
    """Add grades, evidence and an overall status."""
    grades, texts = zip(*(graded(claim, numbers) for claim in CLAIMS), strict=True)
    statuses = np.concatenate([numbers[f"{name}_status"].values.ravel() for name in ("peak", "motion")])
    failed = [*statuses[statuses != 0], 0][0]
    return numbers.assign(
        grade=coded("claim", [GRADES.index(grade) for grade in grades], "how the conclusion stands", GRADES),
        evidence=("claim", list(texts), {"long_name": "the numbers behind the grade"}),
        status=coded((), failed, "ok, or how the first run that failed ended", STATUS),
    ).assign_attrs(Conventions="CF-1.11", kind="claims")
