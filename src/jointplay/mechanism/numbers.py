"""Values of every parameter of a structure: the tables of its chains, joints, beams, loop and drive."""

from __future__ import annotations

from collections.abc import Mapping

from jointplay.equations.laws import LAWS
from jointplay.equations.structure import Linkage
from jointplay.mechanism import kinematic_chains
from jointplay.mechanism.beam import modal
from jointplay.mechanism.closure import four_bar
from jointplay.mechanism.kinematic_chains import Place, place_of
from jointplay.mechanism.records import ConstantSpeed, Joint, Link, Mechanism, MotorLine


def numbers(
    mechanism: Mechanism, places: dict[str, Place], structure: Linkage, angles: Mapping[str, float]
) -> dict[str, float]:
    """Give the value of every parameter of a linkage's equations.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    places : dict of str to Place
        Where its links lie when it is cut.
    structure : Linkage
        Its structure.
    angles : mapping of str to float
        Link angles at time 0, rad.

    Returns
    -------
    dict of str to float
        By name, SI units; what is given from outside is 0.
    """
    links, by_name = mechanism.links, {link.name: link for link in mechanism.links}
    values = {f"H_{k}_{m}": kinematic_chains.inertia(links, places, k, m) for k, m in structure.couplings}
    values |= {f"mu_{k}": kinematic_chains.moment(list(links), places, k) for k in structure.links}
    values |= {f"m_{f}": sum(by_name[k].mass for k in chain) for f, chain in enumerate(structure.floats)}
    values["g"] = mechanism.gravity
    for joint in mechanism.clearance_joints:
        values |= _joint(joint, places)
    for pin in structure.pins:
        moved = [by_name[k] for k in pin.links]
        values[f"m_{pin.name}"] = sum(link.mass for link in moved)
        values |= {f"mu_{pin.name}_{k}": kinematic_chains.moment(moved, places, k) for k in pin.arms}
    for beam in structure.beams:
        values |= _beam(by_name[beam.link], places[beam.link])
    if structure.loop:
        values |= _loop(mechanism, structure, places)
    return values | _drive(mechanism, angles)


def _joint(joint: Joint, places: dict[str, Place]) -> dict[str, float]:
    journal, bearing = place_of(places, joint.journal), place_of(places, joint.bearing)
    friction = joint.friction
    values = {
        "e": joint.clearance,
        "R": joint.radius,
        **dict(zip(LAWS[joint.contact.law].letters, joint.contact.numbers.values(), strict=True)),
        "f": friction.coefficient if friction else 0.0,
        "v": (friction.velocity or 0.0) if friction else 0.0,
        "Ct": friction.viscous if friction else 0.0,
    }
    values |= {f"r{axis}0": journal.fixed[i] - bearing.fixed[i] for i, axis in enumerate("xy")}
    return {f"{word}_{joint.name}": value for word, value in values.items()} | _arms(joint, places)


def _arms(joint: Joint, places: dict[str, Place]) -> dict[str, float]:
    """D_k of r = const + sum_k D_k e_k."""
    journal, bearing = place_of(places, joint.journal), place_of(places, joint.bearing)
    return {
        f"D_{joint.name}_{k}": journal.arms.get(k, 0.0) - bearing.arms.get(k, 0.0)
        for k in (*journal.arms, *bearing.arms)
    }


def _beam(link: Link, place: Place) -> dict[str, float]:
    """Modal numbers S, I, omega^2, 2 xi omega, end slopes, gauge; arms of the origin."""
    modes, xi = modal(link), link.beam.damping_ratio
    rows = {
        "S": modes.force,
        "I": modes.moment,
        "k": modes.frequency**2,
        "c": 2 * xi * modes.frequency,
        "start": modes.slope_start,
        "end": modes.slope_end,
        "gauge": modes.gauge,
        "rate": 0 * modes.frequency,
        "acc": 0 * modes.frequency,
    }
    values = {f"{word}_{link.name}_{i}": float(v) for word, row in rows.items() for i, v in enumerate(row)}
    return values | {f"L_{link.name}_{k}": arm for k, arm in place.arms.items()}


def _loop(mechanism: Mechanism, structure: Linkage, places: dict[str, Place]) -> dict[str, float]:
    """The closed four-bar: spans, the vector from pivot to pivot, the side of the closing joint."""
    loop = four_bar(mechanism)
    values = {f"d_{k}": span for k, span in zip(loop.links, loop.spans, strict=True)}
    values |= _arms(mechanism.joint(structure.loop.name), places)
    values |= {f"c{axis}": loop.pivot[i] - loop.origin[i] for i, axis in enumerate("xy")}
    values |= {"span_2": abs(loop.spans[1]), "span_3": abs(loop.spans[2])}
    return values | {"side": loop.side(mechanism.branch)}


def _drive(mechanism: Mechanism, angles: Mapping[str, float]) -> dict[str, float]:
    drive = mechanism.drive
    if isinstance(drive, MotorLine):
        return {"a": drive.stall_torque, "b": drive.slope}
    if isinstance(drive, ConstantSpeed):
        return {"Omega": drive.speed, "theta_0": angles[drive.link]}
    return {}
