"""The package's records as bodies of `tests.support.multibody`; what these cannot do is refused."""

from __future__ import annotations

import math

import numpy as np

from jointplay.solver.mechanism.start import start
from tests.support import multibody_beams
from tests.support.multibody import GROUND, Body, Marker, Now, Play, Prismatic, Revolute, System
from tests.support.multibody_laws import normal, tangential
from tests.support.multibody_loads import Driven, Held, constant_speed, force, motor, spring, torque, torsion
from tests.support.multibody_run import assemble
from tests.support.plain import plain

MECHANISM = ("name", "links", "joints", "drive", "springs", "loads")
MECHANISM += ("gravity", "gravity_direction", "branch", "order", "guess")
LINK = ("name", "length", "mass", "centre", "inertia", "inertia_centre", "masses", "elastic", "beam")
JOINT = ("name", "kind", "journal", "bearing", "clearance", "radius", "contact", "friction")
JOINT += ("half_length", "half_height")


def from_mechanism(mechanism, crank_angle: float = 0.0) -> System:
    """Bodies and joints of a `Mechanism`; an imposed speed starts at an angle of the crank."""
    _only(mechanism, MECHANISM)
    drives, loads = _drive(mechanism.drive, crank_angle)
    loads += [_spring(each) for each in mechanism.springs] + [_load(each) for each in mechanism.loads]
    bodies = [_body(link, mechanism.order) for link in mechanism.links]
    joints = [_joint(joint) for joint in mechanism.joints]
    return System(bodies, joints, drives, loads, mechanism.gravity, mechanism.gravity_direction)


def rough(mechanism, initial=None) -> dict[str, float]:
    """Angles of the program's start, to two digits: they say which branch."""
    return {name: round(float(angle), 2) for name, angle in start(mechanism, initial or {}).angles.items()}


def started(mechanism, crank_angle: float = 0.0, speed: float | None = None) -> tuple[System, np.ndarray]:
    """Bodies and their state without play at a crank angle, at the drive's speed if none is given."""
    system, crank, held = from_mechanism(mechanism, crank_angle), mechanism.crank, {}
    if not system.drives:
        drive = mechanism.drive
        held[crank] = crank_angle, (drive.start_speed if drive else 0.0) if speed is None else speed
    near = rough(mechanism, {"crank_angle": crank_angle}) | {crank: crank_angle}
    return system, assemble(system, near, held)


def at_state(mechanism, model, state) -> tuple[System, np.ndarray]:
    """Bodies and their state, with play, at positions and speeds of the program's own unknowns."""
    system, n = from_mechanism(mechanism, model.crank_angle), len(model.turning)
    roots, crank = [chain[0] for chain in model.structure.floats], model.crank_angle
    held = []
    for name, *pair in zip(plain(model.structure).STATE[1:], state[:n], state[n:], strict=False):
        word, _, rest = name.partition("_")
        held.append(Held(name, _seen(system, word, rest, roots), *pair))
        crank = pair[0] if name == f"theta_{mechanism.crank}" else crank
    ideal = [joint for joint in system.joints if not joint.play]
    closing = System(system.bodies, ideal, [*system.drives, *held])
    return system, assemble(closing, rough(mechanism, {"crank_angle": float(crank)}))


def state_at(mechanism, model, system, t: float, y) -> np.ndarray:
    """The program's own unknowns and their rates, read off bodies: what `at_state` puts them at."""
    now, roots = Now(system, t, y), [chain[0] for chain in model.structure.floats]
    read = []
    for name in plain(model.structure).STATE[1 : len(model.turning) + 1]:
        word, _, rest = name.partition("_")
        value, row = _seen(system, word, rest, roots)(now)
        read.append((value, row @ now.v))
    return np.transpose(read).ravel()


def _seen(system, word, rest, roots):
    """Number and row of an unknown of the program: an angle, a slide, or x or y of a base."""
    if word == "theta":
        return lambda now: now.turn(Marker(rest))[:2]
    if word == "slide":
        joint = next(joint for joint in system.joints if joint.name == rest)

        def slide(now):
            along = now.along(joint.journal, joint.bearing)
            return along.slide, along.slide_row

        return slide
    root, axis = Marker(roots[int(rest)]), "xy".index(word)
    return lambda now: tuple(part[axis] for part in now.point(root)[:2])


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
    if drive.kind == "cycle":
        return [Driven("drive", drive.link, lambda t: _cycle(drive, start, t))], []
    if drive.kind == "servo":
        return [], [torque(drive.link, lambda now: _servo(drive, now))]
    if drive.kind == "motor":
        return [], [motor(drive.link, drive.stall_torque, drive.slope)]
    raise ValueError(f"a drive {drive.kind} is not known here")


def _profile(drive, start, t) -> tuple[float, float, float]:
    """Angle, speed and acceleration of a smooth change of speed."""
    x, T, more = min(t / drive.time, 1.0), drive.time, drive.end - drive.start
    run = T * x**5 * (7 + x * (-14 + x * (10 - 2.5 * x))) + max(t - T, 0.0)
    rise, steep = x**4 * (35 + x * (-84 + x * (70 - 20 * x))), 140 * x**3 * (1 - x) ** 3 / T
    return start + drive.start * t + more * run, drive.start + more * rise, more * steep


def _cycle(drive, start, t) -> tuple[float, float, float]:
    """Angle, speed and acceleration of a speed with harmonics."""
    nu = drive.frequency
    return start + _course(drive, nu * t, -1) / nu, _course(drive, nu * t), nu * _course(drive, nu * t, 1)


def _servo(drive, now) -> float:
    """The torque of a controller, with what it feeds forward."""
    nu = drive.frequency or 0.0
    theta, _, omega = now.turn(Marker(drive.link))
    wanted = [drive.speed * now.t + _course(drive, nu * now.t)]
    wanted += [drive.speed + nu * _course(drive, nu * now.t, 1), nu**2 * _course(drive, nu * now.t, 2)]
    words = {"t": now.t, "angle": theta, "angular_velocity": omega}
    words |= dict(zip(("wanted_angle", "wanted_velocity", "wanted_acceleration"), wanted, strict=True))
    words |= {name: getattr(math, name) for name in ("sin", "cos", "tanh", "exp", "sqrt", "pi")}
    for name, text in drive.where.items():
        words[name] = eval(text, {"__builtins__": {}}, words)
    fed = eval(drive.feedforward, {"__builtins__": {}}, words) if drive.feedforward else 0.0
    return drive.stiffness * (wanted[0] - theta) + drive.damping * (wanted[1] - omega) + fed


def _course(record, phase, order: int = 0) -> float:
    """A constant and harmonics at a phase; differentiated in it so many times, −1: integrated from 0."""
    if record.table is not None:
        raise ValueError("a table is not known here")
    constant, terms = record.constant, [(h.order, h.cosine, h.sine) for h in record.harmonics]
    total = {-1: constant * phase, 0: constant}.get(order, 0.0)
    for n, a, b in terms:
        turned = n * phase + order * math.pi / 2
        total += float(n) ** order * (a * math.cos(turned) + b * math.sin(turned))
        total -= b * math.sin(-math.pi / 2) / n if order == -1 else 0.0
    return record.factor * total


def _load(record):
    """A force or torque over time or over an angle."""

    def size(now) -> float:
        phase = now.turn(Marker(record.angle))[0] if record.angle else (record.frequency or 0.0) * now.t
        return _course(record, phase)

    if record.kind == "torque":
        return torque(record.link, size)
    place = marker(record.on)

    def pull(now) -> np.ndarray:
        angle = record.direction + (now.turn(place)[0] if record.fixed == "link" else 0.0)
        return size(now) * np.array([math.cos(angle), math.sin(angle)])

    return force(place, pull)


def _only(record, known) -> None:
    """Raise where a record's field that is not known here says anything."""
    for name, field in type(record).model_fields.items():
        if name not in known and getattr(record, name) != field.get_default(call_default_factory=True):
            raise ValueError(f"{name} of {type(record).__name__} is not known here")


def _body(link, order) -> Body:
    """A link with its point masses, about the mass centre of all."""
    _only(link, LINK)
    own = link.inertia_centre
    own = link.inertia - link.mass * link.centre**2 if own is None else own
    parts = [(link.mass, link.centre, own)]
    parts += [(point.mass, point.at, 0.0) for point in link.masses]
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * s for m, s, _ in parts) / mass
    beam = multibody_beams.row(link, order) if link.elastic else None
    return Body(link.name, mass, sum(J + m * (s - centre) ** 2 for m, s, J in parts), centre, beam)


def _joint(joint) -> Revolute | Prismatic:
    _only(joint, JOINT)
    kind = {"revolute": Revolute, "prismatic": Prismatic}[joint.kind]
    return kind(joint.name, marker(joint.journal), marker(joint.bearing), _play(joint))


def _spring(record):
    first, second = getattr(record, "from"), record.to
    if record.kind == "torsion":
        return torsion(Marker(first), Marker(second), record.stiffness, record.angle, record.damping)
    ends = marker(first), marker(second)
    return spring(*ends, record.stiffness, record.free_length, record.damping)


def marker(pin) -> Marker:
    """A pin's point and direction."""
    _only(pin, ("link", "at", "point", "direction"))
    at = tuple(pin.point) if pin.link == GROUND else (pin.at, 0.0)
    return Marker(pin.link, at, pin.direction)


def _play(joint) -> Play | None:
    if joint.ideal:
        return None
    sizes = joint.radius or 0.0, joint.half_length or 0.0, joint.half_height or 0.0
    law, more = normal(joint.contact, joint.clearance, sizes[0])
    if joint.friction and (joint.friction.coefficient or joint.friction.viscous):
        more |= tangential(joint.friction)
    names = dict(zip(("radius", "half_length", "half_height"), sizes, strict=True))
    return Play(joint.clearance, law, tension=joint.contact.tension, **names, **more)
