"""One mechanism twice: the reference's free bodies, and the package's generated functions."""

from __future__ import annotations

from jointplay.mechanism.assemble import assemble

from ..linkages import SMALL, mechanism, own_state, start
from ..plain import Point, plain
from ..reference.bodies import Bodies, Parameters


def pair(joints, drive="motor", **changes):
    """The reference's system and the package's scene of the same mechanism."""
    p = Parameters(i=3.0, drive=drive, **{"f": 0.2} | changes)
    clearance = dict.fromkeys(joints, SMALL)
    scene = assemble(mechanism(p, clearance), start(p) if drive == "none" else None)
    return Bodies(p, clearance), scene


def numbers(system, scene, y):
    """The package's numbers; a prescribed crank is at the reference's angle at time 0."""
    found = dict(zip(plain(scene.structure).PARAMETERS, scene.numbers, strict=True))
    return found | {"theta_0": y[0]} if system.p.drive == "speed" else found


def point(system, scene, y, modes):
    """The package's functions at the reference's state y."""
    values = list(numbers(system, scene, y).values())
    return Point(plain(scene.structure), values, own_state(system, y), modes)
