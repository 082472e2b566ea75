"""Pictures of results: each a function from a dataset to a matplotlib Figure; `draw` chooses among them."""

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure
from xarray import Dataset

from jointplay.errors import NOTHING, InputError, Problem

from . import cells, check, pick
from .basins import basins
from .bifurcation import bifurcation
from .branch import continuation
from .chaos_test import chaos_test
from .check import lacking
from .claims import claims
from .contact_angle import contact_angle
from .dimension import dimension
from .divergence import divergence
from .field import field
from .floquet import floquet
from .journal_orbit import journal_orbit
from .lyapunov import lyapunov
from .overview import overview
from .parameter_map import parameter_map
from .phase_portrait import phase_portrait
from .poincare_section import poincare_section
from .readings import readings
from .scheme_comparison import scheme_comparison
from .spectrum import spectrum
from .stress import stress
from .sweep import sweep
from .time_history import time_history
from .work_precision import work_precision

KINDS: dict[str, Callable[..., Figure]] = {
    "time_history": time_history,
    "contact_angle": contact_angle,
    "journal_orbit": journal_orbit,
    "phase_portrait": phase_portrait,
    "poincare_section": poincare_section,
    "overview": overview,
    "claims": claims,
    "readings": readings,
    "scheme_comparison": scheme_comparison,
    "bifurcation": bifurcation,
    "parameter_map": parameter_map,
    "lyapunov": lyapunov,
    "chaos_test": chaos_test,
    "spectrum": spectrum,
    "dimension": dimension,
    "divergence": divergence,
    "field": field,
    "basins": basins,
    "continuation": continuation,
    "floquet": floquet,
    "stress": stress,
    "work_precision": work_precision,
    "sweep": sweep,
}

# the figures that suit a result, by the result's own kind
SUITED = {
    "response": ("time_history", "contact_angle", "journal_orbit", "phase_portrait", "overview"),
    "section": ("poincare_section",),
    "claims": ("claims",),
    "readings": ("readings",),
    "scheme_comparison": ("scheme_comparison",),
    "bifurcation": ("bifurcation", "parameter_map"),
    "periodic_orbit": ("floquet", "time_history", "journal_orbit", "phase_portrait"),
    "continuation": ("continuation", "floquet"),
    "lyapunov": ("lyapunov",),
    "chaos_test": ("chaos_test",),
    "spectrum": ("spectrum",),
    "dimension": ("dimension",),
    "sensitivity": ("divergence", "field"),
    "basins": ("basins",),
    "stress": ("stress",),
    "work_precision": ("work_precision",),
}

__all__ = ["KINDS", "SUITED", "draw", "lacking", "of_sweep", "problems"]


def draw(dataset: Dataset, options: dict | None = None, /, **named: Any) -> Figure:
    """Draw a result.

    Parameters
    ----------
    dataset : Dataset
        What an analysis returned, or `jointplay.open`.
    options : dict, optional
        `kind`, one of `KINDS`, and the keywords of that function: the `[figure]` table of a study file.
        By default the kind that suits the dataset's own `kind`.
    **named
        The same options by name, such as ``kind="journal_orbit", joint="B"``.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If an option, or a variable, link or joint that it names, does not exist.
    """
    options = dict(options or {}) | named
    for known in ({}, {"kind": options.get("kind") or usual_kind(dataset)}):
        if wrong := problems(options | known):
            raise InputError(wrong)
    if known["kind"] != "sweep" and (left := cells.varied(dataset)):
        one = f"jp.cell(dataset, {', '.join(f'{dim}=...' for dim in left)})"
        expected = f"one cell is drawn, as {one} gives it, or a number a cell by the figure kind 'sweep'"
        raise InputError([Problem("result", f"a sweep over {', '.join(left)}", expected)])
    return KINDS[known["kind"]](dataset, **{name: value for name, value in options.items() if name != "kind"})


def of_sweep(dataset: Dataset, options: dict) -> dict | None:
    """Return the options that draw a whole sweep; None where those given are of one cell, or none suit."""
    whole, shown = options | {"kind": "sweep"}, options.get("quantity") or cells.usual(dataset)
    asked = options.get("kind") == "sweep" or ("kind" not in options and shown and not problems(whole))
    return whole if asked else None


def problems(options: dict) -> list[Problem]:
    """Return what is wrong with figure options as far as that can be told before there is a result.

    Without a `kind`, an option is accepted if any kind has it.
    """
    return check.problems(options, KINDS)


def usual_kind(dataset: Dataset) -> str:
    """Return the picture that a dataset gets where none is asked for."""
    kind = dataset.attrs.get("kind")
    if cells.usual(dataset):
        return "sweep"
    if kind == "response":
        whole = pick.labels(dataset, "joint") and not lacking({"kind": "overview"}, tuple(dataset.data_vars))
        return "overview" if whole else "time_history"
    if kind == "sensitivity" and "mean_log_distance" not in dataset:
        return "field"
    if kind in SUITED:
        return SUITED[kind][0]
    raise pick.refuse(
        "kind", dataset.attrs.get("kind", NOTHING), "the kind of figure: one of " + ", ".join(KINDS)
    )
