"""Figures of results: each a function from a dataset to a matplotlib Figure; `draw` chooses among them.

Validation of figure options, as far as it needs no result.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from importlib import import_module
from pkgutil import walk_packages
from typing import Annotated, Any

from pydantic import PlainValidator

from ..display.errors import NOTHING, InputError, Problem, did_you_mean, of_a_result, refuse, unknown
from ..solver.mechanism.base import accepts
from ..solver.mechanism.records import Mechanism
from ..solver.mechanism.signature import checked
from . import drawing
from .comparison import compared, overlaid
from .drawing import Dataset, Figure, cell_quantity, select, style, sweep_axes, timebase
from .motion.phase_portrait import PAIRS
from .registry import ABOUT, GENERAL, KINDS, keywords, suited, suited_to, usual

NAMES = ("variables", "x", "y")
WIDEST = 1000.0  # mm

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
    dataset: Annotated[Any, PlainValidator(_drawn), accepts("a result, a list of results or a mechanism")],
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
        return style.owner(KINDS[known["kind"]](dataset, **options))


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
        return style.owner(sheet)


def of_sweep(dataset: Dataset, options: dict) -> dict | None:
    """Return the options that draw a whole sweep; None where they are of one cell, or none suit."""
    whole, shown = options | {"kind": "sweep"}, options.get("quantity") or cell_quantity.usual(dataset)
    wanted = options.get("kind") == "sweep" or ("kind" not in options and shown and not problems(whole))
    return whole if wanted else None


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


def problems(options: dict) -> list[Problem]:
    """Return the problems of figure options, as far as they show before there is a result.

    Without a `kind`, an option is accepted if any kind has it.
    """
    kind = options.get("kind")
    if kind is not None and not (isinstance(kind, str) and kind in KINDS):
        return [unknown("figure.kind", kind, kind, KINDS, "figure")]
    accepted = sorted({"kind", *GENERAL}.union(*map(keywords, [kind] if kind else KINDS)))
    strange = [key for key in options if key not in accepted]
    found = [unknown(f"figure.{key}", options[key], key, accepted, "option") for key in strange]
    return found + [each for key in options if key in accepted for each in _value(key, options, kind)]


def _missing_variables(options: Mapping[str, Any], names: tuple[str, ...]) -> list[Problem]:
    """Problems of figure options that need variables which a result with the variables `names` lacks."""
    kind = options.get("kind")
    requested = [(key, name) for key in NAMES if key in options for name in _listed(options[key])]
    absent = [(key, name) for key, name in requested if name not in names]
    found = [unknown(f"figure.{key}", name, name, names, "recorded variable") for key, name in absent]
    if kind not in ABOUT:
        return found
    missing = [name for name in ABOUT[kind].needs if name not in names]
    if missing:
        expected = f"a list that holds {', '.join(missing)} too: the figure {kind} draws them"
        found.append(Problem("analysis.record", list(names), expected))
    pair = "x" in options and "y" in options
    if ABOUT[kind].pair and not pair and not any(set(one) <= set(names) for one in PAIRS):
        pairs = " or ".join(map(" and ".join, PAIRS))
        found.append(Problem("figure.x", options.get("x", NOTHING), f"x and y, as {pairs} are not recorded"))
    return found


def study_problems(kind: str, options: Mapping[str, Any], settings: Mapping[str, Any]) -> list[Problem]:
    """Return the problems of drawing a figure from the result of a study.

    Parameters
    ----------
    kind : str
        Which figure.
    options : mapping
        Its options; without a `kind` where it is the usual one.
    settings : mapping
        The study's keywords, and under ``recorded`` the names of the quantities that its result will have;
        None where they are not known.
    """
    about, names = ABOUT[kind], settings["recorded"]
    if "kind" in options and names == () and (about.needs or about.pair or "variables" in keywords(kind)):
        expected = f"a list of what the figure {kind} draws is needed"
        return [Problem("analysis.record", NOTHING, expected)]
    linkage = names is not None and "state_value" not in names
    found = [*(_missing_variables(options, names) if linkage else ()), *about.fits(options, settings)]
    found += _value("width", options, kind) if "width" in options else []
    return [each for each in found if "kind" in options or each.key != "figure.kind"]


def _listed(given: Any) -> list[Any]:
    return list(given) if isinstance(given, list | tuple) else [given]


def _value(key: str, options: Mapping[str, Any], kind: str | None) -> list[Problem]:
    """Problems of an option's value; without a kind, the problems that every figure with the option has."""
    those, value = [about for name, about in ABOUT.items() if kind in (None, name)], options[key]
    words = {word: None for about in those for word in about.choices.get(key, ())}
    checks = [about.checks[key] for about in those if key in about.checks]
    if words:
        checks.append(lambda given: select.choice(key, given, words))
    if key == "width":
        checks = [partial(_width, min(about.least for about in those))]
    found: list[list[Problem]] = []
    for check in checks or [_CHECKS.get(key, lambda _: None)]:
        try:
            if value is not None:
                check(value)
            return []
        except InputError as error:
            found.append(error.problems)
    return found[0]


def _some(value: Any) -> None:
    if not isinstance(value, bool | str) and not isinstance(value, list | tuple):
        raise select.refuse("events", value, "true, false, or a list of kinds of event, is accepted")


def _names(key: str, value: Any) -> None:
    if not isinstance(value, str | list | tuple):
        raise select.refuse(key, value, "a name or a list of names is accepted")


def _diagram(value: Any) -> None:
    from xarray import Dataset

    if not isinstance(value, Dataset):
        raise select.refuse("over", value, "a result of bifurcation, as jp.open gives it, is accepted")


def _width(least: float, value: Any) -> None:
    if not select.is_number(value) or not least <= value <= WIDEST:
        raise select.refuse("width", value, f"a width in mm, {least:g} to {WIDEST:g}, is accepted")


def _font(value: Any) -> None:
    from matplotlib.font_manager import findfont, fontManager

    try:
        if not isinstance(value, str):
            raise ValueError
        findfont(value, fallback_to_default=False)
    except ValueError:
        near = did_you_mean(value, {font.name for font in fontManager.ttflist})
        raise select.refuse(
            "font", value, f"the name of a font that is installed is accepted;{near}"
        ) from None


def _place(value: Any) -> None:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

    if not isinstance(value, Axes | SubFigure):
        raise select.refuse("ax", value, "an Axes or SubFigure of matplotlib is accepted, in Python")


_CHECKS: dict[str, Callable[[Any], Any]] = {  # of options that mean the same in every figure that has them
    "font": _font,
    "ax": _place,
    "axis": timebase.axis_names,
    "column": lambda value: select.choice("column", value, style.COLUMNS),
    "events": _some,
    "over": _diagram,
    "time": timebase.time_limits,
    "turns": lambda value: timebase.turn_limits(value, 0.0),
    **{name: partial(_names, name) for name in ("maps", "variables")},
    **{
        name: partial(select.switch, name)
        for name in ("multipliers", "neighbours", "period", "points", "zoom")
    },
}
