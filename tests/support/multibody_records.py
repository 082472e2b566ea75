"""The package's records as bodies of `tests.support.multibody`; what these cannot do is refused."""

from __future__ import annotations

import math

import numpy as np

from tests.support.multibody import GROUND, Body, Marker, Play, Prismatic, Revolute, System
from tests.support.multibody_loads import (
    Driven,
    constant_speed,
    force,
    kelvin_voigt,
    motor,
    spring,
    tanh_friction,
    torque,
    torsion,
)

MECHANISM = ("name", "links", "joints", "drive", "springs", "loads")
MECHANISM += ("gravity", "gravity_direction", "branch", "order", "guess")
LINK = ("name", "length", "mass", "centre", "inertia", "inertia_centre", "masses", "beam")
JOINT = ("name", "kind", "journal", "bearing", "clearance", "radius", "contact", "friction")
JOINT += ("half_length", "half_height")


def from_mechanism(mechanism, crank_angle: float = 0.0) -> System:
    """Bodies and joints of a `Mechanism` of rigid links; a constant speed starts at an angle of the crank."""
    _only(mechanism, MECHANISM)
    drives, loads = _drive(mechanism.drive, crank_angle)
    loads += [_spring(each) for each in mechanism.springs] + [_load(each) for each in mechanism.loads]
    bodies, joints = [_body(link) for link in mechanism.links], [_joint(joint) for joint in mechanism.joints]
    return System(bodies, joints, drives, loads, mechanism.gravity, mechanism.gravity_direction)


def _drive(drive, start) -> tuple[list, list]:
    """What a drive holds, and what it loads."""
    if drive is None:
        return [], []
    if drive.kind == "speed":
        return [constant_speed(drive.link, drive.speed, start)], []
    if drive.kind == "profile":
        return [Driven("drive", drive.link, lambda t: _profile(drive, start, t))], []
    if drive.kind == "torque":
        return [], [torque(drive.link, lambda now: _course(drive, now.turn(Marker(drive.link))[0]))]
    if drive.kind == "motor":
        return [], [motor(drive.link, drive.stall_torque, drive.slope)]
    raise ValueError(f"a drive {drive.kind} is not known here")


def _profile(drive, start, t) -> tuple[float, float, float]:
    """Angle, speed and acceleration of a smooth change of speed."""
    x, T, more = min(t / drive.time, 1.0), drive.time, drive.end - drive.start
    run = T * x**5 * (7 + x * (-14 + x * (10 - 2.5 * x))) + max(t - T, 0.0)
    rise, steep = x**4 * (35 + x * (-84 + x * (70 - 20 * x))), 140 * x**3 * (1 - x) ** 3 / T
    return start + drive.start * t + more * run, drive.start + more * rise, more * steep


def _course(record, phase) -> float:
    """A constant and harmonics at a phase."""
    if record.table is not None:
        raise ValueError("a table is not known here")
    terms = (
        h.cosine * math.cos(h.order * phase) + h.sine * math.sin(h.order * phase) for h in record.harmonics
    )
    return record.factor * (record.constant + sum(terms))


def _load(record):
    """A force or torque over time or over an angle."""

    def size(now) -> float:
        phase = now.turn(Marker(record.angle))[0] if record.angle else (record.frequency or 0.0) * now.t
        return _course(record, phase)

    if record.kind == "torque":
        return torque(record.link, size)
    place = _marker(record.on)

    def pull(now) -> np.ndarray:
        angle = record.direction + (now.turn(place)[0] if record.fixed == "link" else 0.0)
        return size(now) * np.array([math.cos(angle), math.sin(angle)])

    return force(place, pull)


def _only(record, known) -> None:
    """Raise where a record's field that is not known here says anything."""
    for name, field in type(record).model_fields.items():
        if name not in known and getattr(record, name) != field.get_default(call_default_factory=True):
            raise ValueError(f"{name} of {type(record).__name__} is not known here")


def _body(link) -> Body:
    """A link with its point masses, about the mass centre of all."""
    _only(link, LINK)
    parts = [(link.mass, link.centre, link.inertia - link.mass * link.centre**2)]
    parts += [(point.mass, point.at, 0.0) for point in link.masses]
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * s for m, s, _ in parts) / mass
    return Body(link.name, mass, sum(J + m * (s - centre) ** 2 for m, s, J in parts), centre)


def _joint(joint) -> Revolute | Prismatic:
    _only(joint, JOINT)
    kind = {"revolute": Revolute, "prismatic": Prismatic}[joint.kind]
    return kind(joint.name, _marker(joint.journal), _marker(joint.bearing), _play(joint))


def _spring(record):
    first, second = getattr(record, "from"), record.to
    if record.kind == "torsion":
        return torsion(Marker(first), Marker(second), record.stiffness, record.angle, record.damping)
    ends = _marker(first), _marker(second)
    return spring(*ends, record.stiffness, record.free_length, record.damping)


def _marker(pin) -> Marker:
    _only(pin, ("link", "at", "point", "direction"))
    at = tuple(pin.point) if pin.link == GROUND else (pin.at, 0.0)
    return Marker(pin.link, at, pin.direction)


def _play(joint) -> Play | None:
    if joint.ideal:
        return None
    contact, friction, smoothed = joint.contact, joint.friction, None
    if contact.law != "kelvin_voigt":
        raise ValueError(f"a contact {contact.law} is not known here")
    if friction and (friction.coefficient or friction.viscous):
        if friction.law != "tanh":
            raise ValueError(f"friction {friction.law} is not known here")
        smoothed = tanh_friction(friction.coefficient, friction.velocity, friction.viscous)
    law, stored = kelvin_voigt(contact.stiffness, contact.damping), lambda u: 0.5 * contact.stiffness * u * u
    sizes = joint.radius or 0.0, joint.half_length or 0.0, joint.half_height or 0.0
    return Play(joint.clearance, law, smoothed, contact.tension, *sizes, stored=stored)
