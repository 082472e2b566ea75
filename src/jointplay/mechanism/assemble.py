"""From records to what is computed: the structure of the equations, and the numbers that go into them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from jointplay.equations.structure import Clearance, Linkage, Pin, parameter_names
from jointplay.errors import InputError, Problem, refuse
from jointplay.mechanism import chains, oscillators
from jointplay.mechanism.chains import Place, place_of
from jointplay.mechanism.closure import ideal_state
from jointplay.mechanism.records import ConstantSpeed, Joint, Mechanism, MotorLine, TestSystem
from jointplay.mechanism.scene import SPEED_FLOOR, Scene


def assemble(
    mechanism: Mechanism | TestSystem, initial: Any = None, section: str | None = None, powers: bool = False
) -> Scene:
    """Assemble a mechanism or a test system.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    initial : mapping, sequence of float, or None
        Of a linkage, ``crank_angle`` and ``crank_speed`` of the ideal mechanism, or ``angle`` and
        ``angular_velocity`` by link; of a test system, its state. None: the default start.
    section : str, optional
        Quantity whose level is to be watched, as ``word:label``; of a test system, a state or ``phase``.
    powers : bool
        Whether the work of drive and joints is to be integrated.

    Raises
    ------
    InputError
        If the mechanism has a loop of ideal joints, or the start does not fit it.
    """
    if isinstance(mechanism, TestSystem):
        return oscillators.scene(mechanism, initial, section)
    places = chains.forest(mechanism)
    structure = _structure(mechanism, places, section, powers)
    angles, speeds = _start(mechanism, initial)
    numbers = _numbers(mechanism, places, structure) | _drive_numbers(mechanism, angles)
    position, velocity = _coordinates(mechanism, structure, places, angles, speeds)
    length = max(link.length for link in mechanism.links)
    nominal = (
        abs(mechanism.drive.nominal_speed) if mechanism.drive else max(map(abs, speeds.values()), default=0.0)
    )
    nominal = nominal or 1.0
    turns = [name in structure.links for name, _ in _places_of_state(structure)]
    unit = np.where(turns, 1.0, length)
    return Scene(
        structure=structure,
        numbers=np.array([numbers[name] for name in parameter_names(structure)]),
        state=np.array(position + velocity),
        absolute=np.concatenate([unit, SPEED_FLOOR * nominal * unit]),
        relative=np.concatenate([np.zeros(len(unit)), np.ones(len(unit))]),
        turning=np.array(turns, dtype=float),
        period=2 * math.pi / nominal,
        h_max=0.7 / nominal if structure.drive == "speed" else math.inf,
        links=structure.links,
        joints=tuple(joint.name for joint in mechanism.clearance_joints),
        clearances=tuple(joint.clearance for joint in mechanism.clearance_joints),
        pins=tuple(pin.name for pin in structure.pins),
        crank=structure.driven,
        crank_angle=angles[structure.driven],
        crank_speed=speeds[structure.driven],
    )


def _structure(mechanism: Mechanism, places: dict[str, Place], section: str | None, powers: bool) -> Linkage:
    links = tuple(link.name for link in mechanism.links)
    floats = [[k for k in links if places[k].chain == f] for f in range(_floating(places))]
    return Linkage(
        links=links,
        couplings=tuple(chains.couplings(mechanism, places)),
        floats=tuple(map(tuple, floats)),
        joints=tuple(_clearance(joint, places) for joint in mechanism.clearance_joints),
        pins=tuple(_pin(k, place, places) for k, place in places.items() if place.parent is not None),
        driven=mechanism.crank or links[0],
        drive={MotorLine: "motor", ConstantSpeed: "speed"}.get(type(mechanism.drive), "none"),
        gravity=mechanism.gravity != 0,
        section=section,
        powers=powers,
    )


def _floating(places: dict[str, Place]) -> int:
    return 1 + max((p.chain for p in places.values() if p.chain is not None), default=-1)


def _clearance(joint: Joint, places: dict[str, Place]) -> Clearance:
    journal, bush = place_of(places, joint.journal), place_of(places, joint.bush)
    bases = [(place.chain, sign) for place, sign in ((journal, 1), (bush, -1)) if place.chain is not None]
    friction = joint.friction
    return Clearance(
        name=joint.name,
        journal=joint.journal.link,
        bush=joint.bush.link,
        arms=tuple(dict.fromkeys([*journal.arms, *bush.arms])),
        bases=() if journal.chain == bush.chain else tuple(bases),
        law=joint.contact.law,
        tension=joint.contact.tension,
        friction=friction.law if friction and friction.coefficient > 0 else "none",
        viscous=bool(friction and friction.viscous > 0),
    )


def _pin(link: str, place: Place, places: dict[str, Place]) -> Pin:
    moved = chains.beyond(places, link)
    arms = dict.fromkeys(k for j in moved for k in (*places[j].arms, j))
    sign = 1 if place.parent.bush.link == link else -1
    return Pin(place.parent.name, sign, tuple(arms), place.chain, tuple(moved))


def _numbers(mechanism: Mechanism, places: dict[str, Place], structure: Linkage) -> dict[str, float]:
    """Values of the parameters, but for the drive's."""
    links, by_name = mechanism.links, {link.name: link for link in mechanism.links}
    values = {f"H_{k}_{m}": chains.inertia(links, places, k, m) for k, m in structure.couplings}
    values |= {f"mu_{k}": chains.moment(list(links), places, k) for k in structure.links}
    values |= {f"m_{f}": sum(by_name[k].mass for k in chain) for f, chain in enumerate(structure.floats)}
    values["g"] = mechanism.gravity
    for joint in mechanism.clearance_joints:
        values |= _joint_numbers(joint, places)
    for pin in structure.pins:
        moved = [by_name[k] for k in pin.links]
        values[f"m_{pin.name}"] = sum(link.mass for link in moved)
        values |= {f"mu_{pin.name}_{k}": chains.moment(moved, places, k) for k in pin.arms}
    return values


def _joint_numbers(joint: Joint, places: dict[str, Place]) -> dict[str, float]:
    journal, bush = place_of(places, joint.journal), place_of(places, joint.bush)
    friction = (joint.friction.coefficient, joint.friction.viscous) if joint.friction else (0.0, 0.0)
    values = {
        "e": joint.clearance,
        "R": joint.radius,
        "K": joint.contact.stiffness,
        "C": joint.contact.damping,
    }
    values |= {"f": friction[0], "Ct": friction[1]}
    values |= {f"r{axis}0": journal.fixed[i] - bush.fixed[i] for i, axis in enumerate("xy")}
    arms = {k: journal.arms.get(k, 0.0) - bush.arms.get(k, 0.0) for k in (*journal.arms, *bush.arms)}
    return {f"{word}_{joint.name}": value for word, value in values.items()} | {
        f"D_{joint.name}_{k}": value for k, value in arms.items()
    }


def _drive_numbers(mechanism: Mechanism, angles: Mapping[str, float]) -> dict[str, float]:
    drive = mechanism.drive
    if isinstance(drive, MotorLine):
        return {"a": drive.stall_torque, "b": drive.slope}
    if isinstance(drive, ConstantSpeed):
        return {"Omega": drive.speed, "theta_0": angles[drive.link]}
    return {}


def _start(mechanism: Mechanism, initial: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Angles and speeds of every link at the start."""
    if initial is None:
        return ideal_state(mechanism)
    if not isinstance(initial, Mapping):
        raise refuse(
            initial,
            "a table of crank_angle and crank_speed, or of angle and angular_velocity by link, is accepted",
            "initial",
        )
    known = ("crank_angle", "crank_speed", "branch", "angle", "angular_velocity")
    unknown = [
        Problem(f"initial.{key}", initial[key], f"keys {', '.join(known)} are accepted")
        for key in initial.keys() - set(known)
    ]
    if unknown:
        raise InputError(unknown, "initial")
    if "angle" not in initial:
        return ideal_state(mechanism, **initial)
    names = [link.name for link in mechanism.links]
    given = [dict(initial.get(key, {})) for key in ("angle", "angular_velocity")]
    wrong = [
        Problem(
            f"initial.{key}", sorted(values), f"one finite number for each of {', '.join(names)} is accepted"
        )
        for key, values in zip(("angle", "angular_velocity"), given, strict=True)
        if set(values) != set(names)
        or not all(isinstance(v, int | float) and math.isfinite(v) for v in values.values())
    ]
    if wrong:
        raise InputError(wrong, "initial")
    return given[0], given[1]


def _places_of_state(structure: Linkage) -> list[tuple[str, int]]:
    """What each position is: (link, 0), or (floating chain, axis)."""
    free = [k for k in structure.links if structure.drive != "speed" or k != structure.driven]
    return [(k, 0) for k in free] + [
        (f"float {f}", axis) for f in range(len(structure.floats)) for axis in (0, 1)
    ]


def _coordinates(mechanism, structure: Linkage, places, angles, speeds) -> tuple[list[float], list[float]]:
    """Positions and speeds in the order of the equations; floating bases as in the ideal mechanism."""
    ideal = chains.forest(mechanism, cut=False)
    free = [k for k, _ in _places_of_state(structure) if k in structure.links]
    position, velocity = [angles[k] for k in free], [speeds[k] for k in free]
    for f in range(len(structure.floats)):
        root = next(k for k in structure.floats[f] if places[k].parent is None)
        x, v = _origin(ideal[root], angles, speeds)
        position += x
        velocity += v
    return position, velocity


def _origin(place: Place, angles, speeds) -> tuple[list[float], list[float]]:
    x, v = list(place.fixed), [0.0, 0.0]
    for k, arm in place.arms.items():
        c, s = math.cos(angles[k]), math.sin(angles[k])
        x = [x[0] + arm * c, x[1] + arm * s]
        v = [v[0] - arm * s * speeds[k], v[1] + arm * c * speeds[k]]
    return x, v
