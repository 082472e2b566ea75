"""Readings of an ambiguous paper: the character of the motion under each, for each panel of its Figure 12.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002). Its Figure 12 shows three Poincaré maps, told
apart by clearance and gear ratio only; several equations and parameters can be read in more than one way. A
reading changes one of them and leaves the others as printed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.labels import coded, column, number
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import quantity
from jointplay.display.errors import InputError, Problem, unknown
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural, Positive, unit
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, MotorLine
from jointplay_lab.paper.character import RTOL, TOLERANCE, variables
from jointplay_lab.paper.reading_list import PANELS, READINGS

POINTS = 200  # section points kept for a small picture


def printed_fits(mechanism: Any) -> list[Problem]:
    """Problems of a mechanism unlike the paper's: motor-driven crank, coupler, clearance at B."""
    if mechanism is None:
        return []
    expected = (
        "a linkage like catalog.chunmei2002() is accepted: motor-driven crank, a coupler, contact data at B"
    )
    parts = isinstance(mechanism, Mechanism) and isinstance(mechanism.drive, MotorLine)
    if parts and {"crank", "coupler"} <= {link.name for link in mechanism.links}:
        joint = next((joint for joint in mechanism.joints if joint.name == "B"), None)
        if joint and joint.contact and joint.friction and joint.radius:
            return []
    return [Problem("mechanism", mechanism, expected)]


def unknown_names(panels: Sequence[str], readings: Sequence[str]) -> list[Problem]:
    """Problems of names of panels and readings: unknown, or none given."""
    lists = (("panels", panels, PANELS, "panel"), ("readings", readings, READINGS, "reading"))
    wrong = [
        unknown(f"{key}[{i}]", name, name, known, what)
        for key, names, known, what in lists
        for i, name in enumerate(names)
        if name not in known
    ]
    return wrong + [
        Problem(key, names, f"at least one of {', '.join(known)} is accepted")
        for key, names, known, _ in lists
        if not len(names)
    ]


@analysis(printed_fits, unknown_names, usual={"rtol": RTOL})
def readings(
    mechanism: Moving | None = None,
    *,
    panels: listed(str, "a list of panels: a, b, c") = tuple(PANELS),
    readings: listed(str, f"a list of readings: {', '.join(READINGS)}") = tuple(READINGS),
    turns: Natural = 300,
    transient: Count = 400,
    growth_turns: Natural = 200,
    tolerance: Annotated[Positive, unit("tolerance of a period", "1")] = TOLERANCE,
    n_jobs: Natural | None = None,
    **motion: Unpack[Integration],
) -> xr.Dataset:
    """Compute every panel of Figure 12 under every reading.

    Parameters
    ----------
    mechanism : Mechanism, optional
        As printed; the catalog's `chunmei2002` if left out. Each panel sets clearance and gear ratio.
    panels : sequence of str
        Of `PANELS`: a, b, c.
    readings : sequence of str
        Of `READINGS`.
    turns, transient, growth_turns : int
        Turns looked at; turns dropped before; turns over which the growth of a difference is averaged.
    tolerance : float
        Spread of section points that count as one, as a fraction of the clearance.
    rtol : float
        Relative tolerance of a step; the growth is always followed at its own.
    n_jobs
        Worker processes; called with the fraction done.

    Returns
    -------
    xarray.Dataset
        Over ``panel`` (with coordinates ``clearance`` in m, ``gear_ratio``) and ``reading`` (with
        coordinate ``reading_text``): ``separations``, ``impacts`` (1 a turn), ``contact_fraction``,
        ``period`` (turns; 0: none found), ``growth``, ``growth_standard_error`` (a turn), ``motion`` (flags
        undecided, periodic, chaotic), ``cell_status``, ``trouble`` (text); and over ``point`` too
        ``section_x``, ``section_y``: the last section points, the journal's centre over the clearance. What
        a failed cell lacks is NaN, its period -1. ``status`` is ok if every cell is.

    Raises
    ------
    InputError
        If a panel or reading is unknown, or the mechanism is no motor-driven linkage with a coupler.
    """
    printed = catalog.chunmei2002() if mechanism is None else mechanism
    common = {"turns": turns, "growth_turns": growth_turns, "tolerance": tolerance}
    common |= {key: motion[key] for key in ("rtol", "max_steps")}
    cells = [
        {"mechanism": printed.replace(clearance=PANELS[p][0], gear_ratio=PANELS[p][1]), "reading": r}
        | {"settings": common | {"transient": transient} | READINGS[r].settings}
        for p in panels
        for r in readings
    ]
    warm(_scenes(cells))
    answers = handed_out(cell, cells, motion["progress"], n_jobs)
    return _dataset(list(panels), list(readings), answers)


def cell(mechanism: Mechanism, reading: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Measure one panel, as a mechanism, under one reading."""
    one = READINGS[reading]
    result = one.measure(one.change(mechanism), **settings)
    if result["status"]:
        return result
    return result | {"extent": float(np.ptp(result["points"], axis=0).max())}


def _scenes(cells: list[dict[str, Any]]):
    """Models whose kernels the cells need; a reading that is refused raises its error in its own cell."""
    for one in cells:
        try:
            mechanism = READINGS[one["reading"]].change(one["mechanism"])
            yield assemble(mechanism, None, quantity(CrankAngle(), mechanism))
        except InputError:
            continue


_NUMBERS = {
    "separations": ("1", "losses of contact in a turn"),
    "impacts": ("1", "contacts begun in a turn"),
    "contact_fraction": ("1", "fraction of time in contact"),
    "extent": ("1", "largest extent of the section points over the clearance"),
    "growth": ("1", "mean logarithm of the growth of a difference in a turn"),
    "growth_standard_error": ("1", "standard error of the growth"),
}


def _dataset(panels: list[str], names: list[str], answers: list[dict[str, Any]]) -> xr.Dataset:
    shape, dims = (len(panels), len(names)), ("panel", "reading")
    found = variables(answers, dims, shape, _NUMBERS)
    codes = column(answers, "status", STATUS.index("not_run")).reshape(shape)
    found["cell_status"] = coded(dims, codes, "how the run ended", STATUS)
    failed = [*codes[codes != 0], 0][0]
    found["status"] = coded((), failed, "ok, or how the first cell that failed ended", STATUS)
    trouble = column(answers, "trouble", "", object).astype(str).reshape(shape)
    found["trouble"] = (dims, trouble, {"long_name": "what went wrong, where something did"})
    for axis, name in enumerate(("section_x", "section_y")):
        cut = np.stack([_last_points(answer)[:, axis] for answer in answers]).reshape(*shape, POINTS)
        text = f"journal centre over clearance at the section, {'xy'[axis]}"
        found[name] = number((*dims, "point"), cut, "1", text)
    return xr.Dataset(found, _coordinates(panels, names), {"Conventions": "CF-1.11", "kind": "readings"})


def _last_points(answer: dict[str, Any]) -> np.ndarray:
    """The last section points, shape (POINTS, 2), NaN where there are fewer."""
    points = answer.get("points", np.zeros((0, 2)))[-POINTS:]
    return np.concatenate([np.full((POINTS - len(points), 2), np.nan), points])


def _coordinates(panels: list[str], names: list[str]) -> dict[str, Any]:
    texts = [READINGS[name].text for name in names]
    return {
        "panel": ("panel", panels, {"long_name": "panel of Figure 12"}),
        "reading": ("reading", names, {"long_name": "reading of the paper"}),
        "reading_text": ("reading", texts, {"long_name": "what the reading means"}),
        "point": number("point", np.arange(POINTS), "1", "section point"),
    } | panel_coordinates(panels)


def panel_coordinates(panels: Iterable[str]) -> dict[str, Any]:
    """Clearance and gear ratio of panels, as coordinates."""
    clearances, ratios = zip(*(PANELS[panel] for panel in panels), strict=True)
    return {
        "clearance": number("panel", list(clearances), "m", "radial clearance"),
        "gear_ratio": number("panel", list(ratios), "1", "gear ratio"),
    }
