"""The keywords that analyses share: length, start, section. Checked here, all problems at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from jointplay.analysis.run import MAX_STEPS
from jointplay.analysis.words import BALANCE, EVENTS, WORDS
from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.mechanism.closure import closed_four_bar
from jointplay.mechanism.records import CrankAngle, Mechanism, Plane, Section, TestSystem, check_section
from jointplay.mechanism.scene import Scene

RTOL = (1e-14, 1e-4)
SLACK = 4  # nominal periods that a turn may take before the run gives up


def check(mechanism: Any, turns: Any, duration: Any, transient: Any, rtol: Any, max_steps: Any) -> None:
    """Refuse keywords that make no run.

    Raises
    ------
    InputError
        Listing every problem.
    """
    found = list(_problems(mechanism, turns, duration, transient, rtol, max_steps))
    if found:
        raise InputError(found)


def _problems(mechanism, turns, duration, transient, rtol, max_steps) -> Iterator[Problem]:
    if not isinstance(mechanism, Mechanism | TestSystem):
        yield Problem(
            "mechanism", mechanism, "a Mechanism or TestSystem is accepted, such as catalog.chunmei2002()"
        )
    if (turns is None) == (duration is None):
        yield Problem(
            "turns",
            NOTHING if turns is None else turns,
            "either turns or duration (s) is accepted, one of them",
        )
    for key, value in (("turns", turns), ("duration", duration)):
        if value is not None and not (_number(value) and value > 0):
            yield Problem(key, value, "a finite number greater than 0 is accepted")
    if not (_number(transient) and transient >= 0):
        yield Problem("transient", transient, "a number of turns, 0 or more, is accepted")
    if not (_number(rtol) and RTOL[0] <= rtol <= RTOL[1]):
        yield Problem("rtol", rtol, f"a relative tolerance from {RTOL[0]:g} to {RTOL[1]:g} is accepted")
    if max_steps is not None and not (isinstance(max_steps, int) and max_steps > 0):
        yield Problem("max_steps", max_steps, "a whole number greater than 0 is accepted")


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def steps(max_steps: int | None) -> int:
    """The number of attempts after which a run stops."""
    return MAX_STEPS if max_steps is None else max_steps


def quantity(section: Section | None, mechanism: Mechanism | TestSystem) -> str | None:
    """The quantity (as word:label) whose level makes the section; None if events make it, or nothing does.

    Raises
    ------
    InputError
        If the mechanism has no such quantity.
    """
    if section is None:
        return None
    linkage = isinstance(mechanism, Mechanism)
    if linkage:
        check_section(section, mechanism)
    if isinstance(section, CrankAngle):
        return f"angle:{mechanism.crank}" if linkage else _phase(mechanism)
    if isinstance(section, Plane):
        return _plane(section, mechanism) if linkage else section.quantity
    return None


def _phase(system: TestSystem) -> str:
    if system.period is None:
        expected = "a plane section is accepted for a system that nothing forces"
        raise InputError([Problem("section.kind", "crank_angle", expected)], "section")
    return "phase"


def _plane(section: Plane, mechanism: Mechanism) -> str:
    follower = section.link not in (None, mechanism.crank)
    if section.quantity == "angle" and follower and closed_four_bar(mechanism):
        expected = f"the crank, {mechanism.crank}, is accepted: without clearance the other angles follow it"
        raise InputError([Problem("section.link", section.link, expected)], "section")
    words = [name for name, word in WORDS.items() if name not in _NOT_SECTIONS]
    if section.quantity not in words:
        problem = unknown("section.quantity", section.quantity, section.quantity, words, "quantity")
        raise InputError([problem], "section")
    of = WORDS[section.quantity].of
    names = {
        "link": [each.name for each in mechanism.links],
        "bending": [each.name for each in mechanism.links if each.elastic],
        "joint": [j.name for j in mechanism.clearance_joints],
    }
    given = {"link": section.link, "bending": section.link, "joint": section.joint}.get(of)
    if of is None:
        return section.quantity
    if not names[of] or given not in (None, *names[of]):
        whose = "an elastic link" if of == "bending" else f"a {of}"
        accepted = f"a quantity of {whose} is accepted: {', '.join(names[of]) or 'none here'}"
        raise InputError([Problem("section.quantity", section.quantity, accepted)], "section")
    if given is None and len(names[of]) > 1:
        problem = Problem(
            f"section.{of}", NOTHING, f"one of {', '.join(names[of])} is needed for {section.quantity}"
        )
        raise InputError([problem], "section")
    return f"{section.quantity}:{given or names[of][0]}"


_NOT_SECTIONS = (
    *(
        "mode",
        "reaction_x",
        "reaction_y",
        "reaction",
        "energy",
        "state_value",
        *BALANCE,
    ),
    *("contact_angle", "eccentricity_ratio"),
)


def section_fields(section: Section | None, scene: Scene, skip: int) -> dict[str, Any]:
    """The fields of a run's request that describe a section."""
    if section is None:
        return {}
    if isinstance(section, CrankAngle):
        forward = 1 if scene.crank_speed >= 0 else -1
        turns = (section.angle - scene.crank_angle) * forward / math.tau
        first = scene.crank_angle + forward * math.tau * (turns - math.ceil(turns) + 1)
        return {"level": first, "period": math.tau, "direction": forward, "skip": skip}
    if isinstance(section, Plane):
        return {"level": section.value, "direction": 1 if section.direction == "up" else -1, "skip": skip}
    names, kind = scene.joints, section.kind
    if scene.resets and kind == "contact":
        names, kind = scene.resets, "impact"
    if not names or section.joint not in (None, *names):
        raise InputError(
            [unknown("section.joint", section.joint, section.joint, names, "contact")], "section"
        )
    joint = -1 if section.joint is None else names.index(section.joint)
    return {"event": EVENTS.index(kind), "joint": joint, "skip": skip}
