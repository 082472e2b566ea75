"""From records to what is computed: the structure of the equations, and the numbers that go into them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jointplay.equations.structure import Beam, Linkage, parameter_names
from jointplay.errors import NOTHING, InputError, Problem, unknown
from jointplay.mechanism import oscillators
from jointplay.mechanism.beam import line_density, modal
from jointplay.mechanism.kinematic_chains import Angles, Forest, origins, place_of
from jointplay.mechanism.model import DEEP, DEFLECTION, SPEED_FLOOR, Model
from jointplay.mechanism.numbers import numbers
from jointplay.mechanism.records import Mechanism, TestSystem
from jointplay.mechanism.section import Section
from jointplay.mechanism.start import start
from jointplay.mechanism.structure import linkage


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
    forest = Forest.of(mechanism)
    structure = linkage(mechanism, forest, section, powers, relaxed)
    angles, speeds = start(mechanism, initial)
    values = numbers(mechanism, forest, structure, angles)
    position, velocity = _coordinates(mechanism, structure, forest, angles, speeds)
    _check_journals(mechanism, forest, angles, position)
    loose = mechanism.clearance_joints
    driven = [mechanism.drive.nominal_speed] if mechanism.drive else speeds.values()
    nominal = max(map(abs, driven), default=0.0) or 1.0
    unit, floor = _scales(mechanism, structure, nominal)
    turning = [name in structure.links for name, _ in _freedoms(structure)]
    # some of the motion is no unknown whose error is watched
    followed = structure.drive == "speed" or forest.loop
    return Model(
        structure=structure,
        numbers=np.array([values[name] for name in parameter_names(structure)]),
        state=np.array(position + velocity),
        absolute=np.concatenate([unit, floor]),
        relative=np.concatenate([np.zeros(len(unit)), np.ones(len(unit))]),
        turning=np.array(turning, dtype=float),
        period=2 * math.pi / nominal,
        creep=SPEED_FLOOR * nominal * max((joint.radius for joint in loose), default=0.0),
        reach=sum(link.length for link in mechanism.links),
        h_max=(0.3 if forest.loop else 0.7) / nominal if followed else math.inf,
        links=structure.links,
        joints=tuple(joint.name for joint in loose),
        clearances=tuple(joint.clearance for joint in loose),
        pins=tuple(joint.name for joint in mechanism.joints if joint.ideal),
        bending=structure.links if structure.beams else (),
        crank=structure.driven,
        crank_angle=angles[structure.driven],
        crank_speed=speeds[structure.driven],
    )


def _check_journals(mechanism: Mechanism, forest: Forest, angles: Angles, position: list[float]) -> None:
    """Refuse a start whose journals are nowhere near their bearings."""
    bases, problems = position[len(position) - 2 * len(forest.floats) :], []

    def centre(pin):
        place = place_of(forest.places, pin)
        x, y = (0.0, 0.0) if place.chain is None else bases[2 * place.chain : 2 * place.chain + 2]
        arm, _ = place.motion(angles, dict.fromkeys(angles, 0.0))
        return x + arm[0], y + arm[1]

    for joint in mechanism.clearance_joints:
        apart = math.dist(centre(joint.journal), centre(joint.bearing))
        if apart > DEEP * joint.clearance:
            far = f"{apart / joint.clearance:.3g} clearances ({apart:.3g} m)"
            expected = f"at most {DEEP} clearances from its bearing's centre are accepted for the journal of"
            problems.append(Problem("initial.angle", angles, f"{expected} {joint.name}, here {far} away"))
    if problems:
        raise InputError(problems, "initial")


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


def _coordinates(
    mechanism: Mechanism, structure: Linkage, forest: Forest, angles: Angles, speeds: Angles
) -> tuple[list[float], list[float]]:
    """Positions and speeds in the order of the equations; straight beams, bases as in the ideal mechanism."""
    ideal = origins(mechanism, mechanism.joints)
    position, velocity = [], []
    for part, axis in _freedoms(structure):
        x, v = 0.0, 0.0
        if isinstance(part, int):
            root = next(k for k in structure.floats[part] if forest.places[k].parent is None)
            x, v = (values[axis] for values in ideal[root].motion(angles, speeds))
        elif part in structure.links:
            x, v = angles[part], speeds[part]
        position.append(x)
        velocity.append(v)
    return position, velocity


def check_section(section: Section, mechanism: Mechanism) -> None:
    """Refuse a section that a mechanism cannot have.

    Raises
    ------
    InputError
        If it names a link or joint that the mechanism lacks, or needs clearance where there is none.
    """
    link, joint = getattr(section, "link", None), getattr(section, "joint", None)
    links, problems = [each.name for each in mechanism.links], []
    if link is not None and link not in links:
        problems.append(unknown("section.link", link, link, links, "link"))
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
    given, ideal = (NOTHING, "every joint here is") if joint is None else (joint, f"joint {joint} is")
    accepted = f"a joint with clearance is accepted: {', '.join(loose) or 'none'}"
    return [Problem("section.joint", given, f"{ideal} ideal (clearance 0); {accepted}")]
