"""Assembly of records: the structure of the equations, and the numbers that go into them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from jointplay.display.errors import NOTHING, Problem, raise_any, unknown
from jointplay.solver.equations.drives import DRIVES
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.equations.structure import Linkage, Spring
from jointplay.solver.mechanism.base import DOWNWARDS, GROUND
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from jointplay.solver.mechanism.loops.loop_numbers import Bases, guesses, loop_numbers
from jointplay.solver.mechanism.model import DEEP, DEFLECTION, SPEED_FLOOR, Model
from jointplay.solver.mechanism.own import oscillators
from jointplay.solver.mechanism.parts import stretch
from jointplay.solver.mechanism.parts.beam import line_density, modal
from jointplay.solver.mechanism.parts.stretch import along
from jointplay.solver.mechanism.records import Mechanism, Section, TestSystem
from jointplay.solver.mechanism.start import approaches, start

SETTLING = 5.0  # of the nominal speed: after a turn nothing is left of what a group of loops misremembered


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
        If ideal loops hold links twice, or the start does not fit the mechanism.
    """
    if isinstance(mechanism, TestSystem):
        return oscillators.model(mechanism, initial, section)
    forest = Forest.of(mechanism)
    structure = linkage(mechanism, forest, section, powers, relaxed)
    bases = Bases(mechanism, forest, start(mechanism, initial, forest))
    angles, speeds, _ = bases.state
    loose, nominal = mechanism.clearance_joints, nominal_speed(mechanism, speeds.values())
    values = numbers(mechanism, forest, structure, bases) | {"settling": SETTLING * nominal}
    rows = [*_positions(mechanism, structure, bases, nominal)]
    position, velocity, unit, floor, turning, fold = np.array(rows, dtype=float).reshape(-1, 6).T.copy()
    _check_journals(bases)
    guessed = guesses(structure, bases)
    remembered = np.concatenate([approaches(bases), guessed])
    velocity, floor = np.append(velocity, remembered[:, 0]), np.append(floor, remembered[:, 1])
    # some of the motion is no unknown whose error is watched
    followed = DRIVES[structure.drive].imposed or forest.cuts
    varying = [load for load in mechanism.loads if load.varies]
    course = structure.course
    varying += [mechanism.drive] if course and (followed or course.timed) else []
    forwards = mechanism.drive.nominal_speed if mechanism.drive else next(iter(speeds.values()))
    spans = [each.step / (getattr(each, "frequency", None) or nominal) for each in varying]
    return Model(
        structure=structure,
        numbers=np.array([values[name] for name in parameter_names(structure)]),
        state=np.concatenate([position, velocity]),
        absolute=np.concatenate([unit, floor]),
        relative=np.concatenate([np.zeros(len(unit)), np.ones(len(floor))]),
        turning=turning,
        fold=fold,
        period=2 * math.pi / nominal,
        creep=SPEED_FLOOR
        * nominal
        * max((joint.radius or joint.half_length for joint in loose), default=0.0),
        reach=sum(link.length for link in mechanism.links),
        h_max=min([(0.3 if forest.cuts else 0.7) / nominal if followed else math.inf, *spans]),
        links=structure.links,
        joints=mechanism.contacts,
        clearances=tuple(joint.clearance for joint in loose for _ in joint.contacts),
        pins=tuple(joint.name for joint in mechanism.joints if joint.ideal),
        guides=mechanism.guides,
        bending=structure.links if structure.beams else (),
        memories=len(remembered),
        guesses=len(guessed),
        crank=structure.driven,
        crank_angle=angles[structure.driven],
        crank_speed=speeds[structure.driven],
        forward=1 if (speeds[structure.driven] or forwards) >= 0 else -1,
    )


def linkage(
    mechanism: Mechanism,
    forest: Forest | None = None,
    section: str | None = None,
    powers: bool = False,
    relaxed: bool = False,
) -> Linkage:
    """Give the structure of a mechanism's equations.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    forest : Forest, optional
        The same, cut at its clearance joints.
    section, powers, relaxed
        As in `assemble`.

    Raises
    ------
    InputError
        If ideal loops hold links twice, or a torsion spring turns one of their links.
    """
    forest = forest or Forest.of(mechanism)
    structure = Linkage(
        **forest.parts(mechanism.clearance_joints),
        driven=mechanism.crank or next(iter(forest.links)),
        drive=mechanism.drive.kind if mechanism.drive else "none",
        gravity=mechanism.gravity != 0,
        section=section,
        powers=powers,
        order="paper" if relaxed else mechanism.order,
        relaxed=relaxed,
        tilted=mechanism.gravity_direction != DOWNWARDS,
        springs=tuple(
            Spring(forest.span(f"spring{i}", each.pins), each.links, each.twists, each.damping > 0)
            for i, each in enumerate(mechanism.springs)
        ),
        loads=tuple(
            load.structure(name := f"load{i}", None if load.twists else forest.span(name, load.pins))
            for i, load in enumerate(mechanism.loads)
        ),
        course=mechanism.drive.structure if mechanism.drive else None,
        fed=getattr(mechanism.drive, "fed", ()),
    )
    stretched = stretch.problems(mechanism, forest.places, structure.beams, structure.order)
    raise_any([*_unwound(mechanism, structure), *stretched], "mechanism")
    return structure


def _unwound(mechanism: Mechanism, structure: Linkage) -> Iterator[Problem]:
    """Torsion springs on links whose angle follows from a loop, and so is known up to whole turns only."""
    for i, spring in enumerate(mechanism.springs):
        for end, link in zip(("from", "to"), spring.links, strict=True):
            if spring.twists and link in structure.dependent:
                text = "a link whose angle follows from no ideal loop or guide is accepted"
                text += ": this one's is known up to whole turns only"
                yield Problem(f"mechanism.springs[{i}].{end}", link, text)


def nominal_speed(mechanism: Mechanism, speeds: Iterable[float] = ()) -> float:
    """Give the size of the speed after which a linkage's period is named, rad/s.

    That is the drive's; without one the largest of `speeds`, or of frequencies of loads where nothing turns.
    """
    driven = [mechanism.drive.nominal_speed] if mechanism.drive else speeds
    timed = (load.frequency for load in mechanism.loads if load.timed)
    return max(map(abs, driven), default=0.0) or max(timed, default=1.0)


def _check_journals(bases: Bases) -> None:
    """Refuse a start whose journals are nowhere near their bearings."""
    angles, problems = bases.state.angles, []
    for joint in bases.mechanism.clearance_joints:
        most = 1 if LAWS[joint.contact.law].rigid else min(DEEP, 1 + joint.deepest / joint.clearance)
        apart = bases.apart(joint)
        if apart > most * joint.clearance * (1 + 1e-9):
            far = f"{apart / joint.clearance:.3g} clearances ({apart:.3g} m)"
            expected = (
                f"at most {most:.4g} clearances from its bearing's centre are accepted for the journal of"
            )
            problems.append(Problem("initial.angle", angles, f"{expected} {joint.name}, here {far} away"))
    raise_any(problems, "initial")


def journal_distances(mechanism: Mechanism, initial: Any) -> dict[str, float]:
    """Distances of journals from their bearings' centres at a start, m, by joint."""
    bases = Bases(mechanism, Forest.of(mechanism), start(mechanism, initial))
    return {joint.name: bases.apart(joint) for joint in mechanism.clearance_joints}


def windings(mechanism: Mechanism, initial: Any) -> dict[str, float]:
    """Angles by which torsion springs are wound at a start, rad, by their place among the springs."""
    angles = {**start(mechanism, initial).angles, GROUND: 0.0}
    twisting = {f"springs[{i}].angle": each for i, each in enumerate(mechanism.springs) if each.twists}
    return {key: angles[a] - angles[b] - each.rest for key, each in twisting.items() for a, b in [each.links]}


def _positions(
    mechanism: Mechanism, structure: Linkage, bases: Bases, nominal: float
) -> Iterator[tuple[float, float, float, float, bool, bool]]:
    """Give each position in the equations' order.

    That is value, speed, units of their errors, whether it is an angle, whether by whole turns the same.

    Beams start straight, floating chains as in the ideal mechanism. Errors are tolerated in units of 1 rad,
    lengths, small deflections.
    """
    (angles, speeds, _), dependent = bases.state, structure.dependent
    length, slow = max(link.length for link in mechanism.links), SPEED_FLOOR * nominal
    for link in mechanism.elastic_links if not structure.relaxed else ():
        unit = DEFLECTION * length * math.sqrt(line_density(link) * link.length / 2)
        stretches = along(link).frequency if link.beam.axial else ()
        for frequency in (*modal(link).frequency, *stretches):
            yield 0.0, 0.0, unit, max(slow / DEFLECTION, frequency) * unit, False, False
    wound = {link for spring in mechanism.springs if spring.twists for link in spring.links}
    for name in structure.links:
        prescribed = name == structure.driven and structure.drive == "speed" and not structure.held
        if name not in dependent and not prescribed:
            yield angles[name], speeds[name], 1.0, slow, True, name not in wound
    for chain in structure.floating:
        for x, v in bases.of[chain].T:
            yield x, v, length, slow * length, False, False
    for slide in structure.slides:
        if slide.freedom not in dependent:
            yield *bases.slide(slide.name), length, slow * length, False, False


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
    on_guide = section.kind == "plane" and joint in mechanism.guides
    if not on_guide and (joint is not None or section.kind in ("contact", "separation")):
        problems += _joint_problems(joint, mechanism)
    raise_any(problems, "section")


def _joint_problems(joint: str | None, mechanism: Mechanism) -> list[Problem]:
    loose = mechanism.contacts
    if joint in loose or (joint is None and loose):
        return []
    names = [name for each in mechanism.joints for name in (each.contacts or (each.name,))]
    if joint is not None and joint not in names:
        return [unknown("section.joint", joint, joint, names, "joint")]
    given, ideal = (NOTHING, "every joint here is") if joint is None else (joint, f"joint {joint} is")
    accepted = f"a joint with clearance is accepted: {', '.join(loose) or 'none'}"
    return [Problem("section.joint", given, f"{ideal} ideal (clearance 0); {accepted}")]


def numbers(mechanism: Mechanism, forest: Forest, structure: Linkage, bases: Bases) -> dict[str, float]:
    """Give the value of every parameter of a linkage's equations.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    forest : Forest
        The same, cut at its clearance joints.
    structure : Linkage
        Its structure.
    bases : Bases
        Its start.

    Returns
    -------
    dict of str to float
        By name, SI units; what is given from outside is 0.
    """
    values = forest.numbers(structure, mechanism.clearance_joints) | {"g": mechanism.gravity}
    values |= {"up_x": -math.cos(mechanism.gravity_direction), "up_y": -math.sin(mechanism.gravity_direction)}
    for i, spring in enumerate(mechanism.springs):
        own = {"k": spring.stiffness, "c": spring.damping, "rest": spring.rest}
        values |= {f"{word}_spring{i}": value for word, value in own.items()}
        values |= forest.span_numbers(f"spring{i}", spring.pins)
    for i, load in enumerate(mechanism.loads):
        values |= {f"{word}_load{i}": value for word, value in load.numbers.items()}
        values |= load.course_numbers(f"load{i}") | forest.span_numbers(f"load{i}", load.pins)
    values |= loop_numbers(forest, bases)
    angles = bases.state.angles
    return values | (mechanism.drive.numbers(angles[mechanism.drive.link]) if mechanism.drive else {})
