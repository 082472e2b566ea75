"""The package's records as bodies of `tests.support.multibody`; what these cannot do is refused."""

from __future__ import annotations

from tests.support.multibody import GROUND, Body, Marker, Play, Revolute, System
from tests.support.multibody_loads import constant_speed, kelvin_voigt, motor, tanh_friction

MECHANISM = ("name", "links", "joints", "drive", "gravity", "branch", "order")
LINK = ("name", "length", "mass", "centre", "inertia", "beam")
JOINT = ("name", "journal", "bearing", "clearance", "radius", "contact", "friction")


def from_mechanism(mechanism, crank_angle: float = 0.0) -> System:
    """Bodies and joints of a `Mechanism` of rigid links; a constant speed starts at an angle of the crank."""
    _only(mechanism, MECHANISM)
    drive, drives, loads = mechanism.drive, [], []
    if drive and drive.kind == "speed":
        drives = [constant_speed(drive.link, drive.speed, crank_angle)]
    elif drive and drive.kind == "motor":
        loads = [motor(drive.link, drive.stall_torque, drive.slope)]
    elif drive:
        raise ValueError(f"a drive {drive.kind} is not known here")
    bodies, joints = [_body(link) for link in mechanism.links], [_joint(joint) for joint in mechanism.joints]
    return System(bodies, joints, drives, loads, mechanism.gravity)


def _only(record, known) -> None:
    """Raise where a record's field that is not known here says anything."""
    for name, field in type(record).model_fields.items():
        if name not in known and getattr(record, name) != field.get_default(call_default_factory=True):
            raise ValueError(f"{name} of {type(record).__name__} is not known here")


def _body(link) -> Body:
    _only(link, LINK)
    return Body(link.name, link.mass, link.inertia - link.mass * link.centre**2, link.centre)


def _joint(joint) -> Revolute:
    _only(joint, JOINT)
    return Revolute(joint.name, _marker(joint.journal), _marker(joint.bearing), _play(joint))


def _marker(pin) -> Marker:
    _only(pin, ("link", "at", "point"))
    return Marker(GROUND, tuple(pin.point)) if pin.link == GROUND else Marker(pin.link, (pin.at, 0.0))


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
    return Play(joint.clearance, law, smoothed, contact.tension, joint.radius, stored=stored)
