"""What is wrong with figure options, as far as that can be told before there is a result."""

from collections.abc import Callable, Iterator
from inspect import signature
from typing import Any

from jointplay.errors import NOTHING, InputError, Problem, unknown

from . import pick, style, timebase
from .bifurcation import lines
from .lyapunov import PER, leading
from .phase_portrait import PAIRS
from .scheme_comparison import MEASURES
from .spectrum import ABSCISSAE, limits
from .sweep import entries

NEEDS = {
    "contact_angle": ("contact_angle",),
    "journal_orbit": ("journal_x", "journal_y"),
    "overview": ("normal_force", "journal_x", "journal_y", "eccentricity", "normal_velocity"),
}
OF_A_PAIR = ("phase_portrait", "poincare_section")
NAMES = ("variables", "x", "y")


def problems(options: dict, kinds: dict[str, Callable]) -> list[Problem]:
    """Return what is wrong with figure options by themselves.

    Without a `kind`, an option is accepted if any kind has it.
    """
    kind = options.get("kind")
    if kind is not None and not (isinstance(kind, str) and kind in kinds):
        return [unknown("figure.kind", kind, kind, kinds, "figure")]
    known = {
        name for one in ([kind] if kind else kinds) for name in list(signature(kinds[one]).parameters)[1:]
    }
    accepted = sorted(known | {"kind"})
    strange = [
        unknown(f"figure.{key}", options[key], key, accepted, "option")
        for key in options
        if key not in accepted
    ]
    there = {key: options[key] for key in options.keys() & set(accepted)}
    return strange + list(_values(there)) + list(_values({"at": there.get("at")}, _AT.get(kind, {})))


def lacking(options: dict, names: tuple[str, ...]) -> list[Problem]:
    """Return what figure options ask for and a result with the variables `names` does not have."""
    kind = options.get("kind")
    asked = [(key, name) for key in NAMES if key in options for name in _listed(options[key])]
    found = [
        unknown(f"figure.{key}", name, name, names, "recorded variable")
        for key, name in asked
        if name not in names
    ]
    missing = [name for name in NEEDS.get(kind, ()) if name not in names]
    if missing:
        expected = f"a list that holds {', '.join(missing)} too: the figure {kind} draws them"
        found.append(Problem("analysis.record", list(names), expected))
    pair = "x" in options and "y" in options
    if kind in OF_A_PAIR and not pair and not any(set(one) <= set(names) for one in PAIRS):
        pairs = " or ".join(map(" and ".join, PAIRS))
        found.append(Problem("figure.x", options.get("x", NOTHING), f"x and y, as {pairs} are not recorded"))
    return found


def _listed(given: Any) -> list[Any]:
    return list(given) if isinstance(given, list | tuple) else [given]


def _values(options: dict, checks: dict | None = None) -> Iterator[Problem]:
    checks = _CHECKS if checks is None else checks
    for key, value in options.items():
        if key not in checks or value is None:
            continue
        try:
            checks[key](value)
        except InputError as error:
            yield from error.problems


def _switch(value: Any, option: str = "zoom") -> None:
    if not isinstance(value, bool):
        raise pick.refuse(option, value, "true or false")


def _some(value: Any) -> None:
    if not isinstance(value, bool | str) and not isinstance(value, list | tuple):
        raise pick.refuse("events", value, "true, false, or a list of kinds of event, is accepted")


def _number(value: Any) -> None:
    if not pick.is_number(value):
        raise pick.refuse("at", value, "a value of the first of two parameters")


_AT = {"sweep": {"at": entries}, "bifurcation": {"at": _number}}  # one word, two forms
_CHECKS: dict[str, Callable[[Any], Any]] = {
    "abscissa": lambda value: pick.choice("abscissa", value, ABSCISSAE),
    "axis": timebase.axis_names,
    "events": _some,
    "limits": lines,
    "period": lambda value: _switch(value, "period"),
    "between": limits,
    "exponents": leading,
    "neighbours": lambda value: _switch(value, "neighbours"),
    "points": lambda value: _switch(value, "points"),
    "multipliers": lambda value: _switch(value, "multipliers"),
    "measure": lambda value: pick.choice("measure", value, MEASURES),
    "column": lambda value: pick.choice("column", value, style.COLUMNS),
    "per": lambda value: pick.choice("per", value, PER),
    "time": timebase.time_limits,
    "turns": lambda value: timebase.turn_limits(value, 0.0),
    "zoom": _switch,
}
