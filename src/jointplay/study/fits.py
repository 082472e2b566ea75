"""Whether the figure that a study asks for fits what it computes: all that can be told before it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from jointplay import figures
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.vary import largest
from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.kinds import load
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import Mechanism, TestSystem
from jointplay.study.vary_table import points

if TYPE_CHECKING:
    from jointplay.study.models import Study


def figure_problems(study: Study) -> list[Problem]:
    """List what a figure asks for and the result cannot have; keywords are right by themselves."""
    options, keywords = study.figure, study.keywords()
    mechanism = largest(study.mechanism, _varied(keywords))
    asked = keywords | {"recorded": _recorded(study, mechanism)}
    suited = _suited(study, mechanism)
    kind = options.get("kind", next(iter(suited), None))
    if kind not in suited:
        expected = f"for this {study.kind} one of {', '.join(suited) or 'none'} is accepted"
        found = [Problem("figure.kind", kind, expected)]
    elif kind == "sweep":
        found = [*_misplaced_sweep(study, asked)]
    else:
        found = figures.study_problems(kind, options, asked)
    found += _unknown_parts(mechanism, options)
    events = options.get("events", False)
    named = [] if isinstance(events, bool) else [events] if isinstance(events, str) else list(events)
    found += [unknown("figure.events", e, e, EVENTS, "kind of event") for e in named if e not in EVENTS]
    return sorted(found, key=lambda problem: problem.key)


def _varied(keywords: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters that the analysis varies itself, with their values."""
    followed = {keywords["parameter"]: keywords["range"]} if "parameter" in keywords else {}
    return keywords.get("over", followed)


def _recorded(study: Study, mechanism: Mechanism | TestSystem) -> tuple[str, ...] | None:
    """Quantities that `record` asks for, of a test system states too; None if wrong ones, or none can be."""
    if "record" not in type(study.analysis).model_fields:
        return None
    try:
        names = load(study.row.recorded)(study.analysis.record, mechanism)
    except InputError:
        return None
    return names + (assemble(mechanism).states if "state_value" in names else ())


def _suited(study: Study, mechanism: Mechanism | TestSystem) -> list[str]:
    """The figures that the result can be drawn as; where it has cells, these side by side too."""
    kinds = [*figures.suited(study.row), *["sweep"] * (bool(study.vary) and "over" not in study.keywords())]
    if "windows" in type(study.analysis).model_fields and study.analysis.section:
        kinds.append("poincare_section")
    if isinstance(mechanism, Mechanism) and mechanism.clearance_joints:
        return kinds
    return [name for name in kinds if not figures.ABOUT[name].clearance]


def _misplaced_sweep(study: Study, asked: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield what a picture of all cells asks for and the result cannot have."""
    options, usual = study.figure, figures.suited(study.row)[:1]
    lost = not study.row.shown or any(figures.study_problems(each, {"kind": each}, asked) for each in usual)
    if not options.get("quantity") and lost:
        expected = f"the name of a variable is needed: a {study.kind} has no usual number here"
        yield Problem("figure.quantity", options.get("quantity", NOTHING), expected)
    known = points(study.mechanism, study.vary)
    names = [*known.dims, *(axis.name for axis in known.axes if axis.name not in known.dims)]
    if (along := options.get("along")) is not None and along not in names:
        yield unknown("figure.along", along, along, names, "varied parameter")


def _unknown_parts(mechanism: Mechanism | TestSystem, options: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield links and joints that a figure names and the mechanism has not."""
    if not isinstance(mechanism, Mechanism):
        return
    ideal = tuple(joint for joint in mechanism.joints if not joint.clearance)
    parts = {"link": (mechanism.links, "link"), "joint": (mechanism.clearance_joints, "joint with clearance")}
    for key, (those, what) in (parts | {"pin": (ideal, "ideal joint")}).items():
        names = [part.name for part in those]
        if key in options and options[key] not in names:
            yield unknown(f"figure.{key}", options[key], options[key], names, what)
