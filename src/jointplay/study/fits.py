"""Whether the parts of a study fit together: all that can be told before anything is computed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from jointplay import figures
from jointplay.analysis.request import quantity
from jointplay.analysis.words import EVENTS, recorded
from jointplay.errors import NOTHING, InputError, Problem, join, unknown
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import Mechanism
from jointplay.study.points import points

MOST, NODES = 200_000_000, 2_000_000  # numbers of one quantity, and initial states of a plane, in memory
TOGETHER = {  # whose product is a number of samples, by the kind of study
    "response": (("turns", "samples_per_turn"),),
    "spectrum": (("turns", "samples_per_turn"),),
    "sensitivity": (("turns", "samples_per_turn", "neighbours", "references"),),
}

if TYPE_CHECKING:
    from jointplay.study.kinds import Study


def problems(study: Study) -> list[Problem]:
    """List what does not fit: section, start and recorded quantities to the mechanism, the figure to all."""
    checks = (_too_much, _misplaced_section, _impossible_start, _unknown_words, _misplaced_figure)
    return [problem for check in checks for problem in check(study)]


def _too_much(study: Study) -> list[Problem]:
    """What would fill any memory."""
    analysis, found = study.analysis, []
    for names in TOGETHER.get(study.kind, ()):
        given = {name: getattr(analysis, name) or 1 for name in names}
        if (count := math.prod(given.values())) > MOST:
            expected = f"together with {', '.join(names[1:])} at most {MOST:,} are accepted, not {count:,}"
            found.append(Problem(f"analysis.{names[0]}", given[names[0]], expected))
    nodes = math.prod(map(len, (getattr(analysis, "plane", None) or {}).values()))
    if nodes > NODES:
        found.append(Problem("analysis.plane", f"{nodes:,} nodes", f"at most {NODES:,} are accepted"))
    return found


def _misplaced_section(study: Study) -> list[Problem]:
    try:
        quantity(study.analysis.section, study.mechanism)
    except InputError as error:
        return error.under("analysis.section").problems
    return []


def _impossible_start(study: Study) -> list[Problem]:
    try:
        assemble(study.mechanism, study.keywords().get("initial"))
    except InputError as error:
        tails = [(problem, problem.key.removeprefix("initial")) for problem in error.problems]
        return [
            problem if tail.startswith("mechanism") else replace(problem, key=join("analysis.initial", tail))
            for problem, tail in tails
        ]
    return []


def _unknown_words(study: Study) -> list[Problem]:
    try:
        whole = study.kind in ("response", "section")
        recorded(study.analysis.record, study.mechanism, "analysis.record", integrals=whole)
    except InputError as error:
        return error.problems
    return []


def _misplaced_figure(study: Study) -> list[Problem]:
    """What a figure asks for and the result cannot have; said before anything is computed."""
    problems, options, kinds = [], study.figure, _kinds_of_figure(study)
    if options.get("kind", kinds[0]) not in kinds:
        expected = f"for this {study.kind} one of {', '.join(kinds)} is accepted"
        problems.append(Problem("figure.kind", options["kind"], expected))
    elif isinstance(study.mechanism, Mechanism) and not _unknown_words(study):
        problems += figures.lacking(options, recorded(study.analysis.record, study.mechanism))
    if isinstance(study.mechanism, Mechanism):
        joints, whats = study.mechanism.joints, {"joint": "joint with clearance", "pin": "ideal joint"}
        parts = {"link": study.mechanism.links, "joint": study.mechanism.clearance_joints}
        parts["pin"] = tuple(joint for joint in joints if not joint.clearance)
        for key in parts.keys() & options.keys():
            names = [part.name for part in parts[key]]
            if options[key] not in names:
                what = whats.get(key, key)
                problems.append(unknown(f"figure.{key}", options[key], options[key], names, what))
    events = options.get("events", False)
    named = [] if isinstance(events, bool) else [events] if isinstance(events, str) else list(events)
    problems += _misplaced_sweep(study)
    problems += [unknown("figure.events", e, e, EVENTS, "kind of event") for e in named if e not in EVENTS]
    return sorted(problems, key=lambda problem: problem.key)


def unsuited_figure(study: Study) -> list[Problem]:
    """Say so where the figure asked for is none of those that this kind of study has."""
    suited, asked = _suited(study), study.figure.get("kind")
    if asked is None or asked in suited:
        return _misplaced_sweep(study)
    expected = f"for this {study.kind} one of {', '.join(suited) or 'none'} is accepted"
    return [Problem("figure.kind", asked, expected)]


def _suited(study: Study) -> list[str]:
    """The figures of its kind; of one that varies, of cells side by side too."""
    own = list(figures.SUITED.get(study.kind, ()))
    return own + ["sweep"] * (bool(study.vary) and study.kind != "bifurcation")


def _misplaced_sweep(study: Study) -> list[Problem]:
    """What a picture of all cells asks for and the result cannot have."""
    options, found = study.figure, []
    if options.get("kind") != "sweep" or "sweep" not in _suited(study):
        return []
    if not options.get("quantity") and study.kind not in figures.cells.USUAL:
        expected = f"the name of a variable is needed: a {study.kind} has no usual number"
        found.append(Problem("figure.quantity", options.get("quantity", NOTHING), expected))
    known = points(study.mechanism, study.vary)
    names = [*known.dims, *(axis.name for axis in known.axes if axis.name not in known.dims)]
    if (along := options.get("along")) is not None and along not in names:
        found.append(unknown("figure.along", along, along, names, "varied parameter"))
    return found


def _kinds_of_figure(study: Study) -> list[str]:
    """The figures that a result of this study can be drawn as."""
    kinds = _suited(study)
    kinds += ["poincare_section"] if study.kind == "response" and study.analysis.section else []
    if isinstance(study.mechanism, Mechanism) and study.mechanism.clearance_joints:
        return kinds
    return [name for name in kinds if name not in ("contact_angle", "journal_orbit", "overview")]
