"""Check the figure that a study asks for against what it computes, before anything is computed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from jointplay import figures
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.vary import largest
from jointplay.display.errors import NOTHING, InputError, Problem, unknown
from jointplay.kinds import Kind, load
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.study.vary_table import Points, points


def figure_problems(
    row: Kind,
    mechanism: Mechanism | TestSystem,
    keywords: Mapping[str, Any],
    vary: Mapping[str, Any],
    options: Mapping[str, Any],
) -> list[Problem]:
    """Problems of a figure's options that the result cannot satisfy; keywords are right by themselves."""
    followed = {keywords["parameter"]: keywords["range"]} if "parameter" in keywords else {}
    grown = largest(mechanism, keywords.get("over", followed))  # by what the analysis varies itself
    asked = {**keywords, "recorded": _recorded(row, grown, keywords)}
    suited = _suited(row, grown, keywords, vary)
    kind = options.get("kind", figures.usual(suited, options, len(keywords.get("over", ()))))
    if kind not in suited:
        expected = f"for this {row.name} one of {', '.join(suited) or 'none'} is accepted"
        problems = [Problem("figure.kind", kind, expected)]
    elif kind == "sweep":
        problems = [*_sweep_problems(row, points(mechanism, vary), options, asked)]
    else:
        problems = figures.study_problems(kind, options, asked)
    problems += _unknown_parts(grown, options)
    events = options.get("events", False)
    named = [] if isinstance(events, bool) else [events] if isinstance(events, str) else list(events)
    problems += [unknown("figure.events", e, e, EVENTS, "kind of event") for e in named if e not in EVENTS]
    return sorted(problems, key=lambda problem: problem.key)


def _recorded(
    row: Kind, mechanism: Mechanism | TestSystem, keywords: Mapping[str, Any]
) -> tuple[str, ...] | None:
    """Quantities that `record` asks for, of a test system states too; None if wrong ones, or none can be."""
    if "record" not in row.function.fields():
        return None
    try:
        names = load(row.recorded)(keywords.get("record"), mechanism)
    except InputError:
        return None
    return names + (assemble(mechanism).states if "state_value" in names else ())


def _suited(
    row: Kind, mechanism: Mechanism | TestSystem, keywords: Mapping[str, Any], vary: Mapping[str, Any]
) -> list[str]:
    """Kinds of figure that the result can be drawn as; with `[vary]`, of all cells side by side too."""
    kinds = [*figures.suited(row), *["sweep"] * (bool(vary) and "over" not in keywords)]
    if "windows" in row.function.fields() and keywords.get("section"):
        kinds.append("poincare_section")
    if isinstance(mechanism, Mechanism) and mechanism.clearance_joints:
        return kinds
    return [name for name in kinds if not figures.ABOUT[name].clearance]


def _sweep_problems(
    row: Kind, grid: Points, options: Mapping[str, Any], asked: Mapping[str, Any]
) -> Iterator[Problem]:
    """Problems of the options of a figure of all cells."""
    usual = figures.suited(row)[:1]
    unnamed = not row.in_sweeps or any(figures.study_problems(kind, {"kind": kind}, asked) for kind in usual)
    if not options.get("quantity") and unnamed:
        expected = f"the name of a variable is needed: a {row.name} has no usual number here"
        yield Problem("figure.quantity", options.get("quantity", NOTHING), expected)
    names = [*grid.dims, *(axis.name for axis in grid.axes if axis.name not in grid.dims)]
    if (along := options.get("along")) is not None and along not in names:
        yield unknown("figure.along", along, along, names, "varied parameter")


def _unknown_parts(mechanism: Mechanism | TestSystem, options: Mapping[str, Any]) -> Iterator[Problem]:
    """Problems of a figure's options that name a link or joint that the mechanism does not have."""
    if not isinstance(mechanism, Mechanism):
        return
    parts = {
        "link": ([link.name for link in mechanism.links], "link"),
        "joint": (
            [*dict.fromkeys(mechanism.contacts + mechanism.guides)],
            "joint with clearance, or prismatic",
        ),
        "pin": ([joint.name for joint in mechanism.joints if joint.ideal], "ideal joint"),
    }
    for key, (names, what) in parts.items():
        if key in options and options[key] not in names:
            yield unknown(f"figure.{key}", options[key], options[key], names, what)
