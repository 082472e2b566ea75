"""Figures of results: each a function from a dataset to a matplotlib Figure; `draw` chooses among them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from importlib import import_module
from pkgutil import walk_packages
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import PlainValidator

from jointplay.display.errors import NOTHING, InputError, Problem, of_a_result, refuse
from jointplay.figures import drawing
from jointplay.figures.drawing import cell_quantity, panel, select, style, sweep_axes
from jointplay.solver.mechanism.base import accepts
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.signature import checked

from .check import problems, study_problems
from .comparison import compared, overlaid
from .registry import ABOUT, GENERAL, KINDS, suited, suited_to, usual

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from xarray import Dataset

for _each in walk_packages(__path__, f"{__name__}."):  # a figure adds itself
    if not _each.name.startswith(drawing.__name__):
        import_module(_each.name)

__all__ = ["ABOUT", "KINDS", "draw", "of_sweep", "problems", "sheet_of", "study_problems", "suited", "usual"]

OF_A_MECHANISM = "mechanism"
ACCEPTED = "a result, a list of results to be compared, or a mechanism is accepted"


def _drawn(given: Any) -> Dataset | Mechanism | list[Dataset]:
    from xarray import Dataset

    several = isinstance(given, list | tuple) and len(given) > 1
    one = Dataset | Mechanism
    if not all(isinstance(each, Dataset) for each in given) if several else not isinstance(given, one):
        raise refuse(given, ACCEPTED)
    return given


@checked()
def draw(
    dataset: Annotated[
        Any,
        PlainValidator(_drawn),
        accepts("a result, a list of results or a mechanism"),
    ],
    options: Annotated[dict[str, Any] | None, accepts("a table of options")] = None,
    /,
    **named: Any,
) -> Figure:
    """Draw a result, or a mechanism.

    Parameters
    ----------
    dataset : Dataset, Mechanism or list of Dataset
        What an analysis returned, or `jointplay.open`; or a linkage, to see it. Several results are drawn on
        one sheet, with the same axes.
    options : dict, optional
        `kind`, one of `KINDS`, and the keywords of that function: the `[figure]` table of a study file.
        By default the kind that suits the dataset's own `kind`.
    **named
        The same options by name, such as ``kind="journal_orbit", joint="B"``. Of every kind: ``width`` in mm,
        ``font``, the name of one that is installed, and ``ax``, an Axes (for kinds with one panel) or
        a SubFigure of matplotlib to draw in.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If an option, or a variable, link or joint that it names, does not exist.
    """
    options = dict(options or {}) | named
    if isinstance(dataset, list | tuple):
        return sheet_of([(each, options) for each in dataset])
    if isinstance(dataset, Mechanism):
        if options.get("kind", OF_A_MECHANISM) != OF_A_MECHANISM:
            raise select.refuse("kind", options["kind"], "mechanism, the kind of figure of a mechanism")
        return _one(dataset, options)
    with of_a_result(dataset):
        return _one(dataset, options)


def _one(dataset: Dataset | Mechanism, options: dict[str, Any]) -> Figure:
    """Draw one result or mechanism."""
    for known in ({}, {"kind": options.get("kind") or usual_kind(dataset, options)}):
        if wrong := problems(options | known):
            raise InputError(wrong)
    general = {name: options.pop(name) for name in GENERAL if name in options}
    one_cell = known["kind"] not in ("sweep", OF_A_MECHANISM)
    if one_cell and (left := cell_quantity.varied(dataset)):
        one = f"jp.cell(dataset, {', '.join(f'{dim}=...' for dim in left)})"
        expected = f"one cell is drawn, as {one} gives it, or a number a cell by the figure kind 'sweep'"
        raise InputError([Problem("result", f"a sweep over {', '.join(left)}", expected)])
    options.pop("kind", None)
    with style.settings(**general):
        return panel.owner(KINDS[known["kind"]](dataset, **options))


def sheet_of(
    parts: Sequence[tuple[Dataset, dict[str, Any]]],
    columns: int | None = None,
    windows: Sequence[Sequence[float]] | None = None,
) -> Figure:
    """Draw results on one sheet with the same axes, each with its own options as in `draw`.

    In so many `columns`; with `windows`, pairs of times in s, their curves over each other, a panel each.
    """
    general = {name: parts[0][1][name] for name in GENERAL if name in parts[0][1]}
    own = [
        (one, {"kind": usual_kind(one, options)} | {k: v for k, v in options.items() if k not in GENERAL})
        for one, options in parts
    ]
    with style.settings(**general):
        sheet = compared(own, draw, columns) if windows is None else overlaid(own, draw, windows)
        return panel.owner(sheet)


def of_sweep(dataset: Dataset, options: dict) -> dict | None:
    """Return the options that draw a whole sweep; None where they are of one cell, or none suit."""
    whole, shown = options | {"kind": "sweep"}, options.get("quantity") or cell_quantity.usual(dataset)
    asked = options.get("kind") == "sweep" or ("kind" not in options and shown and not problems(whole))
    return whole if asked else None


def usual_kind(dataset: Dataset | Mechanism, options: Collection[str] = ()) -> str:
    """Return the default kind of figure, with the given options, of a dataset or a mechanism."""
    if isinstance(dataset, Mechanism):
        return OF_A_MECHANISM
    if cell_quantity.usual(dataset):
        return "sweep"
    kind, there = dataset.attrs.get("kind"), {str(name) for name in dataset.data_vars}
    names = [name for name in suited_to(kind) if there.issuperset(ABOUT[name].needs)]
    if name := usual(names, options, len(sweep_axes.varied(dataset))):
        return name
    expected = f"the kind of figure: one of {', '.join(KINDS)}"
    raise select.refuse("kind", NOTHING if kind is None else kind, expected)
