"""The structure of a linkage's equations: which parts it has, without their numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from jointplay.display.errors import Problem, raise_any
from jointplay.solver.equations.structure import (
    CORNERS,
    Beam,
    Clearance,
    Closure,
    Linkage,
    Pin,
    Slide,
    Span,
    Spring,
)
from jointplay.solver.mechanism.base import DOWNWARDS
from jointplay.solver.mechanism.loops.dyads import Unknown
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from jointplay.solver.mechanism.parts import stretch
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.friction import FRICTIONLESS
from jointplay.solver.mechanism.parts.joints import Joint
from jointplay.solver.mechanism.records import AnyLoad, AnySpring, Mechanism


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
    links, places = tuple(forest.links), forest.places
    structure = Linkage(
        links=links,
        couplings=forest.couplings(),
        floats=forest.floats,
        joints=tuple(each for joint in mechanism.clearance_joints for each in _clearances(joint, forest)),
        pins=tuple(_pin(name, forest) for name, place in places.items() if place.parent is not None),
        driven=mechanism.crank or links[0],
        drive=mechanism.drive.kind if mechanism.drive else "none",
        gravity=mechanism.gravity != 0,
        section=section,
        powers=powers,
        beams=tuple(_beam(link, forest) for link in mechanism.elastic_links),
        slides=tuple(_slide(name, link, forest) for name, link in forest.slides.items()),
        closures=tuple(_closure(joint, led, forest) for cut, led in forest.cuts for joint in cut),
        order="paper" if relaxed else mechanism.order,
        relaxed=relaxed,
        tilted=mechanism.gravity_direction != DOWNWARDS,
        springs=tuple(
            Spring(_span(f"spring{i}", each, forest), each.links, each.twists, each.damping > 0)
            for i, each in enumerate(mechanism.springs)
        ),
        loads=tuple(
            each.structure(f"load{i}", None if each.twists else _span(f"load{i}", each, forest))
            for i, each in enumerate(mechanism.loads)
        ),
        course=mechanism.drive.structure if mechanism.drive else None,
        fed=getattr(mechanism.drive, "fed", ()),
    )
    stretched = stretch.problems(mechanism, forest, structure.beams, structure.order)
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


def _clearances(joint: Joint, forest: Forest) -> Iterator[Clearance]:
    """A bearing, or the corners of a slider."""
    one = _clearance(joint, forest)
    for name, corner in zip(joint.contacts, CORNERS.values() if joint.prismatic else (None,), strict=True):
        yield replace(one, name=name, joint=joint.name, corner=corner) if corner else one


def _clearance(joint: Joint, forest: Forest) -> Clearance:
    pins = joint.journal, joint.bearing
    vector = forest.vector(*pins)
    friction = joint.friction or FRICTIONLESS
    elastic = [pin.link in forest.links and forest.links[pin.link].elastic for pin in pins]
    return Clearance(
        name=joint.name,
        journal=joint.journal.link,
        bearing=joint.bearing.link,
        arms=tuple(vector.arms),
        bases=vector.bases,
        law=joint.contact.law,
        tension=joint.contact.tension,
        friction=friction.law if friction.rubs else "none",
        viscous=friction.viscous > 0,
        ends=tuple(("end" if pin.at else "start") * bends for pin, bends in zip(pins, elastic, strict=True)),
    )


def _span(name: str, part: AnySpring | AnyLoad, forest: Forest) -> Span:
    vector = forest.vector(*part.pins.values())
    return Span(name, tuple(vector.arms), vector.bases)


def _pin(link: str, forest: Forest) -> Pin:
    place, moved = forest.places[link], forest.carried(link)
    arms = dict.fromkeys(k for j in moved for k in (*forest.places[j].arms, j))
    sign = 1 if place.parent.bearing.link == link else -1
    return Pin(place.parent.name, sign, tuple(arms), forest.bases(link), tuple(moved))


def _beam(link: Link, forest: Forest) -> Beam:
    place = forest.places[link.name]
    beam, modes_along = link.beam, 2 * link.beam.axial
    return Beam(link.name, beam.size, tuple(place.arms), place.chain, beam.damping_ratio > 0, modes_along)


def _slide(name: str, link: str, forest: Forest) -> Slide:
    place, base = forest.places[link], forest.base(link)
    arms = tuple(base.arms)
    return Slide(name, link, place.holder, place.chain, base.slides[name], arms, forest.inner(link))


def _closure(joint: Joint, unknowns: tuple[Unknown, ...], forest: Forest) -> Closure:
    vector = forest.closure(joint)
    names = joint.name, joint.journal.link, joint.bearing.link
    return Closure(*names, tuple(vector.arms), tuple(vector.slides.items()), unknowns)
