"""From records to what is computed: the structure of the equations, and the numbers that go into them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.equations.structure import Beam, Clearance, Linkage, Loop, Pin, parameter_names
from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.mechanism import kinematic_chains, oscillators
from jointplay.mechanism.beam import line_density, modal
from jointplay.mechanism.closure import closed_four_bar
from jointplay.mechanism.kinematic_chains import Place, place_of
from jointplay.mechanism.model import DEEP, DEFLECTION, SPEED_FLOOR, Model
from jointplay.mechanism.numbers import numbers
from jointplay.mechanism.records import ConstantSpeed, Joint, Link, Mechanism, MotorLine, TestSystem
from jointplay.mechanism.section import Section
from jointplay.mechanism.start import start

DRIVES = {MotorLine: "motor", ConstantSpeed: "speed"}


def assemble(
    mechanism: Mechanism | TestSystem,
    initial: Any = None,
    section: str | None = None,
    powers: bool = False,
    relaxed: bool = False,
) -> Model:
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
        Whether the work of drive, joints and elastic links is to be integrated.
    relaxed : bool
        Whether the motion of elastic modes is given from outside, as numbers, with the paper's inertia terms.

    Raises
    ------
    InputError
        If ideal joints close a loop other than a four-bar's, or the start does not fit the mechanism.
    """
    if isinstance(mechanism, TestSystem):
        return oscillators.model(mechanism, initial, section)
    loop = closed_four_bar(mechanism)
    places = kinematic_chains.forest(mechanism, without=loop.joints[2] if loop else None)
    structure = _structure(mechanism, places, section, powers, relaxed)
    angles, speeds = start(mechanism, initial)
    values = numbers(mechanism, places, structure, angles)
    position, velocity = _coordinates(mechanism, structure, places, angles, speeds)
    _check_journals(mechanism, structure, places, angles, position)
    nominal = (
        abs(mechanism.drive.nominal_speed) if mechanism.drive else max(map(abs, speeds.values()), default=0.0)
    )
    nominal = nominal or 1.0
    unit, floor = _scales(mechanism, structure, nominal)
    turning = [name in structure.links for name, _ in _freedoms(structure)]
    followed = structure.drive == "speed" or loop  # some of the motion is no unknown whose error is watched
    return Model(
        structure=structure,
        numbers=np.array([values[name] for name in parameter_names(structure)]),
        state=np.array(position + velocity),
        absolute=np.concatenate([unit, floor]),
        relative=np.concatenate([np.zeros(len(unit)), np.ones(len(unit))]),
        turning=np.array(turning, dtype=float),
        period=2 * math.pi / nominal,
        creep=SPEED_FLOOR
        * nominal
        * max((joint.radius or 0.0 for joint in mechanism.clearance_joints), default=0.0),
        reach=sum(link.length for link in mechanism.links),
        h_max=(0.3 if loop else 0.7) / nominal if followed else math.inf,
        links=structure.links,
        joints=tuple(joint.name for joint in mechanism.clearance_joints),
        clearances=tuple(joint.clearance for joint in mechanism.clearance_joints),
        pins=tuple(joint.name for joint in mechanism.joints if not joint.clearance),
        bending=structure.links if structure.beams else (),
        crank=structure.driven,
        crank_angle=angles[structure.driven],
        crank_speed=speeds[structure.driven],
    )


def linkage(mechanism: Mechanism) -> Linkage:
    """Give the structure of a mechanism's equations, with no section and no work integrals.

    Raises
    ------
    InputError
        If ideal joints close a loop other than a four-bar's.
    """
    loop = closed_four_bar(mechanism)
    places = kinematic_chains.forest(mechanism, without=loop.joints[2] if loop else None)
    return _structure(mechanism, places, None, False, False)


def _check_journals(mechanism: Mechanism, structure: Linkage, places, angles, position) -> None:
    """Refuse a start whose journals are nowhere near their bearings."""
    bases, wrong = position[len(position) - 2 * len(structure.floats) :], []

    def at(pin):
        place = place_of(places, pin)
        x, y = (0.0, 0.0) if place.chain is None else bases[2 * place.chain : 2 * place.chain + 2]
        found, _ = _origin(place, angles, dict.fromkeys(angles, 0.0))
        return x + found[0], y + found[1]

    for joint in mechanism.clearance_joints:
        apart = math.dist(at(joint.journal), at(joint.bearing))
        if apart > DEEP * joint.clearance:
            far = f"{apart / joint.clearance:.3g} clearances ({apart:.3g} m)"
            expected = f"at most {DEEP} clearances from its bearing's centre are accepted for the journal of"
            wrong.append(Problem("initial.angle", angles, f"{expected} {joint.name}, here {far} away"))
    if wrong:
        raise InputError(wrong, "initial")


def _structure(mechanism: Mechanism, places: dict[str, Place], section, powers, relaxed: bool) -> Linkage:
    links = tuple(link.name for link in mechanism.links)
    floats = [[k for k in links if places[k].chain == f] for f in range(_floating(places))]
    return Linkage(
        links=links,
        couplings=tuple(kinematic_chains.couplings(mechanism, places)),
        floats=tuple(map(tuple, floats)),
        joints=tuple(_clearance(joint, mechanism, places) for joint in mechanism.clearance_joints),
        pins=tuple(_pin(k, place, places) for k, place in places.items() if place.parent is not None),
        driven=mechanism.crank or links[0],
        drive=DRIVES.get(type(mechanism.drive), "none"),
        gravity=mechanism.gravity != 0,
        section=section,
        powers=powers,
        beams=tuple(_beam(link, places[link.name]) for link in mechanism.links if link.elastic),
        loop=_loop(mechanism),
        order="paper" if relaxed else mechanism.order,
        relaxed=relaxed,
    )


def _floating(places: dict[str, Place]) -> int:
    return 1 + max((p.chain for p in places.values() if p.chain is not None), default=-1)


def _clearance(joint: Joint, mechanism: Mechanism, places: dict[str, Place]) -> Clearance:
    journal, bearing = place_of(places, joint.journal), place_of(places, joint.bearing)
    bases = [(place.chain, sign) for place, sign in ((journal, 1), (bearing, -1)) if place.chain is not None]
    friction = joint.friction
    elastic = {link.name for link in mechanism.links if link.elastic}
    ends = (("end" if pin.at else "start") * (pin.link in elastic) for pin in (joint.journal, joint.bearing))
    return Clearance(
        name=joint.name,
        journal=joint.journal.link,
        bearing=joint.bearing.link,
        arms=tuple(dict.fromkeys([*journal.arms, *bearing.arms])),
        bases=() if journal.chain == bearing.chain else tuple(bases),
        law=joint.contact.law,
        tension=joint.contact.tension,
        friction=friction.law if friction and friction.coefficient > 0 else "none",
        viscous=bool(friction and friction.viscous > 0),
        ends=tuple(ends),
    )


def _pin(link: str, place: Place, places: dict[str, Place]) -> Pin:
    moved = kinematic_chains.beyond(places, link)
    arms = dict.fromkeys(k for j in moved for k in (*places[j].arms, j))
    sign = 1 if place.parent.bearing.link == link else -1
    return Pin(place.parent.name, sign, tuple(arms), place.chain, tuple(moved))


def _beam(link: Link, place: Place) -> Beam:
    return Beam(link.name, link.beam.size, tuple(place.arms), place.chain, link.beam.damping_ratio > 0)


def _loop(mechanism: Mechanism) -> Loop | None:
    loop = closed_four_bar(mechanism)
    if loop is None:
        return None
    joint = mechanism.joint(loop.joints[2])
    return Loop(joint.name, joint.journal.link, joint.bearing.link, loop.links)


def _freedoms(structure: Linkage) -> list[tuple[Any, int]]:
    """What each position is, in the equations' order: (beam, mode), (link, 0), (floating chain, axis)."""
    modes = [] if structure.relaxed else [(beam, i) for beam in structure.beams for i in range(beam.modes)]
    free = structure.links
    if structure.loop:
        free = (structure.driven,)
    elif structure.drive == "speed":
        free = tuple(k for k in structure.links if k != structure.driven)
    bases = [(f, axis) for f in range(len(structure.floats)) for axis in (0, 1)]
    return [*modes, *((k, 0) for k in free), *bases]


def _scales(mechanism: Mechanism, structure: Linkage, nominal: float) -> tuple[np.ndarray, np.ndarray]:
    """Units in which errors of positions and of speeds are tolerated: 1 rad, lengths, small deflections."""
    length, units, floors = max(link.length for link in mechanism.links), [], []
    modes = {link.name: modal(link) for link in mechanism.links if link.elastic}
    for part, i in _freedoms(structure):
        if isinstance(part, Beam):
            link = mechanism.link(part.link)
            unit = DEFLECTION * length * math.sqrt(line_density(link) * link.length / 2)
            floor = max(SPEED_FLOOR * nominal / DEFLECTION, modes[part.link].frequency[i]) * unit
        else:
            unit = 1.0 if part in structure.links else length
            floor = SPEED_FLOOR * nominal * unit
        units.append(unit)
        floors.append(floor)
    return np.array(units), np.array(floors)


def _coordinates(mechanism, structure: Linkage, places, angles, speeds) -> tuple[list[float], list[float]]:
    """Positions and speeds in the order of the equations; straight beams, bases as in the ideal mechanism."""
    ideal = kinematic_chains.forest(mechanism, cut=False)
    position, velocity = [], []
    for part, axis in _freedoms(structure):
        x, v = 0.0, 0.0
        if isinstance(part, int):
            root = next(k for k in structure.floats[part] if places[k].parent is None)
            origin, motion = _origin(ideal[root], angles, speeds)
            x, v = origin[axis], motion[axis]
        elif part in structure.links:
            x, v = angles[part], speeds[part]
        position.append(x)
        velocity.append(v)
    return position, velocity


def _origin(place: Place, angles, speeds) -> tuple[list[float], list[float]]:
    x, v = list(place.fixed), [0.0, 0.0]
    for k, arm in place.arms.items():
        c, s = math.cos(angles[k]), math.sin(angles[k])
        x = [x[0] + arm * c, x[1] + arm * s]
        v = [v[0] - arm * s * speeds[k], v[1] + arm * c * speeds[k]]
    return x, v


def check_section(section: Section, mechanism: Mechanism) -> None:
    """Refuse a section that a mechanism cannot have.

    Raises
    ------
    InputError
        If it names a link or joint that the mechanism lacks, or needs clearance where there is none.
    """
    problems = []
    link, joint = getattr(section, "link", None), getattr(section, "joint", None)
    names = [each.name for each in mechanism.links]
    if link is not None and link not in names:
        problems.append(unknown("section.link", link, link, names, "link"))
    if joint is not None or section.kind in ("contact", "separation"):
        problems += _joint_problems(joint, mechanism)
    if problems:
        raise InputError(problems, "section")


def _joint_problems(joint: str | None, mechanism: Mechanism) -> list[Problem]:
    names = [each.name for each in mechanism.joints]
    loose = [each.name for each in mechanism.clearance_joints]
    if joint is not None and joint not in names:
        return [unknown("section.joint", joint, joint, names, "joint")]
    if joint in loose or (joint is None and loose):
        return []
    given = NOTHING if joint is None else joint
    state = (
        "every joint here is ideal (clearance 0)"
        if joint is None
        else f"joint {joint} is ideal (clearance 0)"
    )
    return [
        Problem(
            "section.joint",
            given,
            f"{state}; a joint with clearance is accepted: {', '.join(loose) or 'none'}",
        )
    ]
