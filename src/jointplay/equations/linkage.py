"""A linkage with play in some joints: chains, contacts, friction and drive put together as one system."""

from collections.abc import Iterator

from sympy import Expr, Integer, atan2

from .chain import (
    Coordinates,
    base_force,
    beyond,
    coordinates,
    force,
    inertia_torque,
    kinetic_energy,
    mass_matrix,
    potential_energy,
)
from .contact import LAWS, Geometry, geometry
from .drive import torque
from .structure import Clearance, Linkage, parameter_names
from .system import Contact, System, number, traction


def system(structure: Linkage) -> System:
    """Write the equations of motion of a linkage."""
    c = coordinates(structure)
    joints = {joint.name: geometry(joint, c, structure.driven) for joint in structure.joints}
    contacts = tuple(_contact(joint, joints[joint.name]) for joint in structure.joints)
    outputs = dict(_outputs(structure, c, joints, contacts))
    return System(
        positions=c.positions,
        speeds=c.speeds,
        parameters=tuple(map(number, parameter_names(structure))),
        definitions=tuple(d for joint in joints.values() for d in joint.definitions),
        mass=mass_matrix(structure, c),
        force=_forces(structure, c),
        angles=tuple(c.angle.values()),
        contacts=contacts,
        powers=_powers(structure, c, outputs) if structure.powers else {},
        outputs=outputs,
        section=outputs[structure.section] if structure.section else None,
    )


def _contact(joint: Clearance, g: Geometry) -> Contact:
    F_n, stored = LAWS[joint.law](joint.name, g.u, g.v_n)
    return Contact(
        joint.name,
        g.u,
        g.v_n,
        F_n,
        g.normal,
        joint.tension,
        g.v_t,
        g.tangential,
        number(f"f_{joint.name}") if joint.friction == "coulomb" else None,
        number(f"Ct_{joint.name}") if joint.viscous else Integer(0),
        stored,
        g.gap,
    )


def _forces(structure: Linkage, c: Coordinates) -> tuple[Expr, ...]:
    Q = {c.speed[k]: force(structure, c, k) for k in structure.links}
    Q[c.speed[structure.driven]] += torque(structure.drive, c.speed[structure.driven])
    for f in range(len(structure.floats)):
        for axis in (0, 1):
            Q[c.base_speed[f][axis]] = base_force(structure, c, f, axis)
    return tuple(Q[speed] for speed in c.speeds)


def _powers(structure: Linkage, c: Coordinates, outputs: dict[str, Expr]) -> dict[str, Expr]:
    """Powers whose integrals close the energy balance: drive, and what the joints take in."""
    joints = Integer(0)
    for joint in structure.joints:
        joints += outputs[f"normal_force:{joint.name}"] * outputs[f"normal_velocity:{joint.name}"]
        joints += outputs[f"tangential_force:{joint.name}"] * outputs[f"tangential_velocity:{joint.name}"]
    return {"drive": outputs["drive_torque"] * c.speed[structure.driven], "joints": joints}


def _outputs(structure, c: Coordinates, joints: dict[str, Geometry], contacts) -> Iterator[tuple[str, Expr]]:
    """Every quantity that can be recorded, as word:label."""
    for k in structure.links:
        yield f"angle:{k}", c.angle[k].value
        yield f"angular_velocity:{k}", c.speed[k]
        yield f"angular_acceleration:{k}", c.acceleration[k]
    for contact in contacts:
        yield from _contact_outputs(contact, joints[contact.name])
    for pin in structure.pins:
        for axis in (0, 1):
            yield f"reaction_{'xy'[axis]}:{pin.name}", _reaction(structure, c, joints, pin, axis)
    yield "drive_torque", _drive_torque(structure, c, joints)
    yield "kinetic_energy", kinetic_energy(structure, c)
    yield "potential_energy", potential_energy(structure, c)


def _contact_outputs(contact: Contact, g: Geometry) -> Iterator[tuple[str, Expr]]:
    F_n, F_t = traction(contact)
    yield f"journal_x:{contact.name}", g.r[0]
    yield f"journal_y:{contact.name}", g.r[1]
    yield f"eccentricity:{contact.name}", g.rho
    yield f"eccentricity_ratio:{contact.name}", g.rho / number(f"e_{contact.name}")
    yield f"penetration:{contact.name}", g.u
    yield f"normal_velocity:{contact.name}", g.v_n
    yield f"tangential_velocity:{contact.name}", g.v_t
    yield f"contact_angle:{contact.name}", atan2(g.r[1], g.r[0])
    yield f"normal_force:{contact.name}", F_n
    yield f"tangential_force:{contact.name}", F_t
    yield f"stored_energy:{contact.name}", contact.stored


def _drive_torque(structure: Linkage, c: Coordinates, joints: dict[str, Geometry]) -> Expr:
    """The motor's law, or what a prescribed speed costs."""
    if structure.drive != "speed":
        return torque(structure.drive, c.speed[structure.driven])
    total = inertia_torque(structure, c, structure.driven)
    for joint in structure.joints:
        F_n, F_t = traction(_contact(joint, joints[joint.name]))
        N, T = joints[joint.name].on_drive
        total += N * F_n + T * F_t
    return total


def _reaction(structure: Linkage, c: Coordinates, joints: dict[str, Geometry], pin, axis: int) -> Expr:
    """Force on the bush of an ideal pin: momentum rate beyond it, less the contact forces that act there."""
    total = beyond(pin, c, axis, structure.gravity)
    for joint in structure.joints:
        g = joints[joint.name]
        F_n, F_t = traction(_contact(joint, g))
        across = (-g.direction[1], g.direction[0])
        F = F_n * g.direction[axis] + F_t * across[axis]
        total += F * ((joint.journal in pin.links) - (joint.bush in pin.links))
    return pin.sign * total
