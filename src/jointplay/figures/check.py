"""Validation of figure options, as far as it needs no result."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from jointplay.display.errors import NOTHING, InputError, Problem, did_you_mean, unknown
from jointplay.figures.drawing import select, style, timebase
from jointplay.figures.motion.phase_portrait import PAIRS

from .registry import ABOUT, GENERAL, KINDS, keywords

NAMES = ("variables", "x", "y")
WIDEST = 1000.0  # mm


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
    asked = [(key, name) for key in NAMES if key in options for name in _listed(options[key])]
    absent = [(key, name) for key, name in asked if name not in names]
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


def study_problems(kind: str, options: Mapping[str, Any], asked: Mapping[str, Any]) -> list[Problem]:
    """Return the problems of drawing a figure from the result of a study.

    Parameters
    ----------
    kind : str
        Which figure.
    options : mapping
        Its options; without a `kind` where it is the usual one.
    asked : mapping
        The study's keywords, and under ``recorded`` the names of the quantities that its result will have;
        None where they are not known.
    """
    about, names = ABOUT[kind], asked["recorded"]
    if "kind" in options and names == () and (about.needs or about.pair or "variables" in keywords(kind)):
        expected = f"a list of what the figure {kind} draws is needed"
        return [Problem("analysis.record", NOTHING, expected)]
    linkage = names is not None and "state_value" not in names
    found = [*(_missing_variables(options, names) if linkage else ()), *about.fits(options, asked)]
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


def _width(value: Any) -> None:
    if not select.is_number(value) or not 20.0 <= value <= WIDEST:
        raise select.refuse("width", value, f"a width in mm, 20 to {WIDEST:g}, is accepted")


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
    "width": _width,
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
