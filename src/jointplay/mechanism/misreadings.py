"""Numbers that are probably meant in another unit, and are computed all the same, with a warning.

Rule: what no mechanism can be is refused where its record is checked (`draft`, `base.Turn`); what a rare one
may be is doubted here. Either names the likely unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from jointplay.errors import Problem
from jointplay.mechanism.assemble import journal_distances
from jointplay.mechanism.base import in_degrees, in_millimetres
from jointplay.mechanism.records import ConstantSpeed, Mechanism, MotorLine, Plane

RPM = math.tau / 60  # rad/s
WIDE = 0.1  # of the shortest link: a wider clearance is seldom meant
MAINS = 400.0  # rad/s: no motor on mains of 60 Hz turns faster than 377 rad/s, 3600 rpm
FAST = 1000.0  # rad/s, 9549 rpm: few cranks turn faster
HURRY = 5.0  # times the drive's own speed: below the 9.55 that rpm are of rad/s
SUNK = 1.0  # clearances: a journal seldom starts deeper in its bearing


def doubts(mechanism: Any, initial: Any = None, section: Any = None) -> Iterator[Problem]:
    """Yield what a valid mechanism, start and section probably do not mean, with keys of an analysis.

    Of a test system, which is dimensionless, nothing is doubted.
    """
    if not isinstance(mechanism, Mechanism):
        return
    yield from _wide(mechanism)
    yield from _fast(mechanism.drive)
    if isinstance(initial, Mapping):
        yield from _start(mechanism, initial)
    if isinstance(section, Plane) and section.quantity == "angle" and abs(section.value) > math.tau:
        yield Problem("section.value", section.value, in_degrees(section.value))


def _wide(mechanism: Mechanism) -> Iterator[Problem]:
    length = min(link.length for link in mechanism.links)
    for i, joint in enumerate(mechanism.joints):
        if joint.clearance > WIDE * length or joint.clearance > (joint.radius or math.inf):
            shares = f"{joint.clearance / length:.2g} of the shortest link"
            shares += (
                f" and {joint.clearance / joint.radius:.2g} of the journal's radius" if joint.radius else ""
            )
            yield Problem(
                f"mechanism.joints[{i}].clearance",
                joint.clearance,
                f"that is {shares}{in_millimetres(joint.clearance)}",
            )


def _fast(drive: Any) -> Iterator[Problem]:
    if isinstance(drive, MotorLine) and drive.synchronous_speed > MAINS:
        why = "faster than any motor on the mains (3600 rpm)"
        yield _in_rpm("mechanism.drive.synchronous_speed", drive.synchronous_speed, why)
    if isinstance(drive, ConstantSpeed) and abs(drive.speed) > FAST:
        yield _in_rpm("mechanism.drive.speed", drive.speed, "faster than most cranks turn")


def _in_rpm(key: str, speed: float, why: str) -> Problem:
    meant = f"if {speed:g} rpm are meant, write '{speed:g} rpm' or {speed * RPM:.6g}"
    return Problem(key, speed, f"{speed:g} rad/s are {speed / RPM:.5g} rpm, {why}; {meant}")


def _start(mechanism: Mechanism, initial: Mapping[str, Any]) -> Iterator[Problem]:
    own = abs(mechanism.drive.nominal_speed) if mechanism.drive else math.inf
    speed = initial.get("crank_speed")
    if speed is not None and abs(speed) > HURRY * own:
        yield _in_rpm("initial.crank_speed", speed, f"{abs(speed) / own:.3g} times what the drive turns at")
    for name, angle in (initial.get("angle") or {}).items():
        if abs(angle) > math.tau:
            yield Problem(f"initial.angle.{name}", angle, in_degrees(angle))
    clearances = {joint.name: joint.clearance for joint in mechanism.clearance_joints}
    for name, apart in journal_distances(mechanism, initial).items() if "angle" in initial else ():
        depth = apart / clearances[name] - 1
        if depth > SUNK:
            text = f"the journal of {name} starts {depth:.3g} clearances deep in its bearing: digits lost?"
            yield Problem("initial.angle", dict(initial["angle"]), text)
