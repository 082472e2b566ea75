"""Readings of an ambiguous paper: the character of the motion under each, for each panel of its Figure 12.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002). Its Figure 12 shows three Poincaré maps, told
apart by clearance and gear ratio only; several equations and parameters can be read in more than one way. A
reading changes one of them and leaves the others as printed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.cells import first_bad, handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.labels import Out, along, columns
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import quantity
from jointplay.display import codes
from jointplay.display.errors import InputError, Problem, strangers, with_keys
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural, Positive, unit
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, MotorLine
from jointplay_lab.paper.character import NUMBERS, RTOL, TOLERANCE
from jointplay_lab.paper.reading_list import PANELS, READINGS

POINTS = 200  # section points kept for a small picture
OVER = ("panel", "reading")
OF_PANEL = {"clearance": Out("panel", "radial clearance", "m"), "gear_ratio": Out("panel", "gear ratio")}
COLUMNS = {"separations": ".2f", "impacts": ".2f", "contact_fraction": ".4f", "extent": ".0e"}


def answer(dataset: xr.Dataset) -> str:
    """The motion of each panel, counted over the readings of the paper."""
    motions = zip(dataset.panel.values, codes.words(dataset["motion"]).values, strict=True)
    return "\n".join(f"panel {panel}, {row.size} readings: {codes.counted(row)}" for panel, row in motions)


def table(dataset: xr.Dataset) -> str:
    """Every panel of Figure 12 under every reading as text, one a line."""
    head = ("panel", "reading", *COLUMNS, "period", "growth per turn", "motion")
    motions = codes.words(dataset["motion"]).values
    rows = [_reading(dataset.isel(panel=p, reading=r), motions[p, r]) for p, r in np.ndindex(motions.shape)]
    both = (dataset.reading, dataset.reading_text)
    texts = [f"{name.item():<32}{text.item()}" for name, text in zip(*both, strict=True)]
    return "\n".join([_row(head), *map(_row, rows), "", *texts]) + "\n"


def _row(words: tuple[str, ...]) -> str:
    return "{:<7}{:<30}{:>12}{:>9}{:>18}{:>9}{:>8}  {:<18}{}".format(*words)


def _reading(one: xr.Dataset, motion: str) -> tuple[str, ...]:
    period = {0: "none", -1: "-"}.get(int(one.period), str(int(one.period)))
    growth = f"{_number(one.growth, '+.3f')} ± {_number(one.growth_standard_error, '.3f')}"
    numbers = (_number(one[name], form) for name, form in COLUMNS.items())
    return one.panel.item(), one.reading.item(), *numbers, period, growth.replace("- ± -", "-"), motion


def _number(value: xr.DataArray, form: str) -> str:
    """A number as text, a dash where there is none."""
    return format(float(value), form) if math.isfinite(value) else "-"


OUTPUTS = Outputs(
    "readings",
    {
        "panel": Out("panel", "panel of Figure 12", ""),
        "reading": Out("reading", "reading of the paper", ""),
        "reading_text": Out("reading", "what the reading means", ""),
        "point": Out("point", "section point"),
    }
    | OF_PANEL,
    along(NUMBERS, *OVER)
    | {
        "cell_status": Out(OVER, "how the run ended", flags=STATUS, missing="not_run"),
        "status": Out((), "ok, or how the first cell that failed ended", flags=STATUS),
        "trouble": Out(OVER, "what went wrong, where something did", "", missing=""),
        "section_x": Out((*OVER, "point"), "journal centre over clearance at the section, x"),
        "section_y": Out((*OVER, "point"), "journal centre over clearance at the section, y"),
    },
    answer,
    table=table,
)


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
    wrong = [each for key, names, *known in lists for each in strangers(with_keys(key, names), *known)]
    return wrong + [
        Problem(key, names, f"at least one of {', '.join(known)} is accepted")
        for key, names, known, _ in lists
        if not len(names)
    ]


@analysis(printed_fits, unknown_names, usual={"rtol": RTOL}, outputs=OUTPUTS)
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

    What a failed cell lacks is NaN, its period -1.

    Parameters
    ----------
    mechanism : Mechanism, optional
        As printed; the catalog's `chunmei2002` if left out. Each panel sets clearance and gear ratio.
    panels : sequence of str
        Panels of Figure 12 that are computed: a, b, c.
    readings : sequence of str
        Readings of the paper under which they are computed; their names are those of `READINGS`.
    turns : int
        Number of turns that are looked at.
    transient : int
        Number of turns that are followed first and left out.
    growth_turns : int
        Number of turns over which the growth of a small difference is averaged.
    tolerance : float
        Spread within which section points count as one, as a fraction of the clearance.
    rtol : float
        Relative tolerance of a step; the growth of differences is always followed at a tolerance of its own.
    n_jobs
        Worker processes; called with the fraction done.

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


def _dataset(panels: list[str], names: list[str], answers: list[dict[str, Any]]) -> xr.Dataset:
    shape = (len(panels), len(names))
    rows = [answer | {"cell_status": answer["status"]} for answer in answers]
    cells = {name: OUTPUTS.variables[name] for name in (*NUMBERS, "cell_status", "trouble")}
    values = columns(cells, rows, shape) | of_panels(panels)
    values["status"] = first_bad(answers)
    cut = np.stack([_last_points(answer) for answer in answers]).reshape(*shape, POINTS, 2)
    values |= {"section_x": cut[..., 0], "section_y": cut[..., 1], "point": np.arange(POINTS)}
    values |= {"panel": panels, "reading": names, "reading_text": [READINGS[name].text for name in names]}
    return OUTPUTS.dataset(values)


def _last_points(answer: dict[str, Any]) -> np.ndarray:
    """The last section points, shape (POINTS, 2), NaN where there are fewer."""
    points = answer.get("points", np.zeros((0, 2)))[-POINTS:]
    return np.concatenate([np.full((POINTS - len(points), 2), np.nan), points])


def of_panels(panels: Iterable[str]) -> dict[str, list[float]]:
    """Clearance and gear ratio of panels: values of `OF_PANEL`."""
    return dict(zip(OF_PANEL, map(list, zip(*(PANELS[panel] for panel in panels), strict=True)), strict=True))
