"""The keywords of periodic orbits and their branches, checked: all problems at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from jointplay.analysis import request as asked
from jointplay.analysis.checks import refused, together, whole
from jointplay.analysis.starts import state_names
from jointplay.analysis.vary import axes
from jointplay.analysis.words import recorded
from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import MAIN_JOINT, CrankAngle, Mechanism, Plane, TestSystem


def check_orbit(mechanism: Any, section: Any, record: Any, **given: Any) -> None:
    """Refuse keywords of `periodic_orbit` that make no sense.

    Raises
    ------
    InputError
        Listing every problem.
    """
    together(
        lambda: asked.check(
            mechanism, given["period"], None, given["transient"], given["rtol"], given["max_steps"]
        ),
        lambda: refused(orbit_problems(mechanism, section, **given)),
        lambda: (
            recorded(record, mechanism, integrals=False)
            if isinstance(mechanism, Mechanism | TestSystem)
            else None
        ),
    )


def orbit_problems(mechanism: Any, section: Any, **given: Any) -> Iterator[Problem]:
    """What is wrong with the keywords that are an orbit's own."""
    yield from _section_problems(section, mechanism)
    if not _between(given["tolerance"], 0, 1):
        expected = "a number greater than 0 and less than 1 is accepted"
        yield Problem("tolerance", given["tolerance"], expected)
    for key in ("period", "max_iterations", "samples_per_turn", "max_points", "max_branches"):
        if key in given:
            yield from whole(key, given[key], 1)


def _section_problems(section: Any, mechanism: Any) -> Iterator[Problem]:
    if isinstance(section, Plane):
        if not isinstance(mechanism, TestSystem) or mechanism.period is not None:
            expected = "a crank angle (or phase of the forcing) is accepted here: kind = 'crank_angle'"
            yield Problem("section", section.kind, expected)
        elif section.quantity not in (names := state_names(assemble(mechanism))):
            yield unknown("section.quantity", section.quantity, section.quantity, names, "state")
    elif not isinstance(section, CrankAngle):
        expected = "a crank angle, or a plane of a state, is accepted"
        yield Problem("section", getattr(section, "kind", section), expected)
    elif isinstance(mechanism, TestSystem) and mechanism.period is None:
        expected = "a plane of a state is accepted for a system that nothing forces: kind = 'plane'"
        yield Problem("section", section.kind, expected)


def _between(value: Any, low: float, high: float) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and low < value < high


def check_branch(mechanism: Any, section: Any, record: Any, **given: Any) -> float:
    """Refuse keywords of `continuation` that make no sense; give back the value to start at.

    Raises
    ------
    InputError
        Listing every problem.
    """
    own = {key: given.pop(key) for key in ("parameter", "range", "start", "step", "branch_switching")}
    together(
        lambda: check_orbit(mechanism, section, record, **given),
        lambda: refused(_branch_problems(mechanism, **own)),
    )
    return present(mechanism, own["parameter"]) if own["start"] is None else float(own["start"])


def _branch_problems(
    mechanism: Any, parameter: Any, range: Any, start: Any, step: Any, branch_switching: Any
) -> Iterator[Problem]:
    if not _between(step, 0, 1):
        yield Problem("step", step, "a fraction of the range, greater than 0 and less than 1, is accepted")
    if not isinstance(branch_switching, bool):
        yield Problem("branch_switching", branch_switching, "true or false is accepted")
    if not isinstance(mechanism, Mechanism | TestSystem):
        return
    pair = isinstance(range, list | tuple) and len(range) == 2
    if not pair or not all(_between(v, -math.inf, math.inf) for v in range) or not range[0] < range[1]:
        yield Problem("range", range, "two numbers, the lower first, are accepted")
        return
    try:
        axes(mechanism, {parameter: list(range)}, "range")
    except InputError as error:
        yield from error.problems
        return
    value = present(mechanism, parameter) if start is None else start
    if not isinstance(value, int | float) or not range[0] <= value <= range[1]:
        given = NOTHING if value is None else value
        yield Problem("start", given, f"a number from {range[0]:g} to {range[1]:g} is needed")


def present(mechanism: Mechanism | TestSystem, key: str) -> float | None:
    """The value that a mechanism has of a parameter (analysis.vary); None where it has none."""
    if isinstance(mechanism, TestSystem):
        return mechanism.parameters.get(key)
    if "." in key:
        record: Any = mechanism
        for name in key.split("."):
            named = {part.name: part for part in record} if isinstance(record, tuple) else {}
            record = named[name] if named else getattr(record, name)
        return record
    main = next((joint for joint in mechanism.joints if joint.name == MAIN_JOINT), mechanism.joints[0])
    bending = next((link.beam for link in mechanism.links if link.elastic), None)
    return {
        "clearance": main.clearance,
        "friction": main.friction.coefficient if main.friction else 0.0,
        "gravity": mechanism.gravity,
        "gear_ratio": getattr(mechanism.drive, "gear_ratio", None),
        "speed": getattr(mechanism.drive, "speed", None),
        "damping_ratio": bending.damping_ratio if bending else None,
    }.get(key)
