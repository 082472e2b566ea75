"""A linkage cut at its clearance joints: a forest of open chains, and the constant tables of its equations.

The model, section 1: every link's origin is P_j = base + sum_k L_jk e_k with constant L, in a chain that is
grounded (base a fixed point), floats (base a coordinate) or slides (base on a guide). Ideal loops are cut as
well.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations_with_replacement, starmap
from typing import Any

from jointplay.display.errors import InputError, Problem
from jointplay.solver.equations import structure
from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.loops.dyads import Cuts, Plan, Unknown, decompose
from jointplay.solver.mechanism.parts import stretch
from jointplay.solver.mechanism.parts.beam import Link, modal
from jointplay.solver.mechanism.parts.friction import FRICTIONLESS
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.records import Mechanism

_LOOP = (
    "ideal loops that leave every link free to move are accepted; these joints hold links twice: clearance "
    "greater than 0 m at one of them opens a loop"
)
_DRIVEN = "a link that no ideal loop determines is accepted, one pinned to the ground by an ideal joint"


Angles = Mapping[str, float]  # or angular velocities, by link


@dataclass
class Place:
    """Position of a point of a link: arms L_jk from a fixed point or from the base of a floating chain.

    Of a link's origin, `parent` is the ideal joint that holds it, `holder` the link on its other side.
    """

    arms: dict[str, float] = field(default_factory=dict)
    fixed: tuple[float, float] = (0.0, 0.0)
    chain: int | None = None
    parent: Joint | None = None
    holder: str | None = None

    @property
    def sides(self) -> tuple[Pin, Pin]:
        """Pins that hold a link's origin: the parent's pin on the holder and the one on the link."""
        return next(pair for pair in self.parent.ends if pair[0].link == self.holder)

    def at(self, link: str, distance: float) -> Place:
        """A place on the link at a distance from its origin."""
        arms = dict(self.arms)
        if distance:
            arms[link] = arms.get(link, 0.0) + distance
        return Place(arms, self.fixed, self.chain)

    def motion(self, angles: Angles, speeds: Angles) -> tuple[list[float], list[float]]:
        """Position and velocity relative to the base."""
        x, v = list(self.fixed), [0.0, 0.0]
        for k, arm in self.arms.items():
            c, s = math.cos(angles[k]), math.sin(angles[k])
            x = [x[0] + arm * c, x[1] + arm * s]
            v = [v[0] - arm * s * speeds[k], v[1] + arm * c * speeds[k]]
        return x, v


@dataclass(frozen=True)
class Sum:
    """A vector in a linkage cut open: r0 + sum_k D_k e_k + sum_s sign s d + sum_f sign b_f.

    Slides are by joint name; bases are those of chains, with their signs.
    """

    arms: dict[str, float]
    fixed: tuple[float, float]
    slides: dict[str, int] = field(default_factory=dict)
    bases: tuple[tuple[int, int], ...] = ()

    def numbers(self, name: str, prefix: str = "") -> dict[str, float]:
        """Its constant part and its arms, m, by their names in the equations."""
        fixed = {f"{prefix}{axis}0_{name}": v for axis, v in zip("xy", self.fixed, strict=True)}
        return fixed | {f"D_{name}_{k}": arm for k, arm in self.arms.items()}


@dataclass(frozen=True)
class Forest:
    """Positions of the links of a linkage that is cut at its clearance joints, and at one joint of each loop.

    Parameters
    ----------
    links : dict of str to Link
        By name, in the mechanism's order; point masses are in their own.
    places : dict of str to Place
        Origin of each link by its name, a holder before what it holds.
    cuts : tuple of (tuple of Joint, tuple of Unknown)
        Joints at which ideal loops that close together are cut, with the angles and slides that follow, in
        order.
    """

    links: dict[str, Link]
    places: dict[str, Place]
    cuts: Cuts = ()

    @classmethod
    def of(cls, mechanism: Mechanism) -> Forest:
        """Cut a linkage.

        Raises
        ------
        InputError
            If ideal loops hold links twice, or one of them moves the driven link.
        """
        links = {link.name: link.total for link in mechanism.links}
        joints = [joint for joint in mechanism.joints if joint.ideal]
        places = origins(mechanism, joints)
        parents = [place.parent for place in places.values()]
        if all(joint in parents for joint in joints):
            return cls(links, places)
        plan = decomposed(mechanism, mechanism.crank)
        if plan is None and decomposed(mechanism, None) is None:
            problem = Problem("mechanism.joints", [joint.name for joint in _on_loops(joints)], _LOOP)
            raise InputError([problem], "mechanism")
        if plan is None or (mechanism.drive and mechanism.drive.link not in plan.free):
            raise InputError([Problem("mechanism.drive.link", mechanism.crank, _DRIVEN)], "mechanism")
        return cls(links, held(plan), plan.cuts)

    @property
    def slides(self) -> dict[str, str]:
        """Links that hang on a guide, by the joint's name; a guide's own link before the sliding ones."""
        parents = ((name, place.parent) for name, place in self.places.items())
        return {joint.name: name for name, joint in parents if joint is not None and joint.prismatic}

    def base(self, link: str) -> Sum:
        """Position of the base of a sliding link's chain, from the base of its guide's chain."""
        place = self.places[link]
        inner, outer = place.sides
        start = place_of(self.places, inner)
        return Sum(start.arms, start.fixed, {place.parent.name: 1 if outer is place.parent.journal else -1})

    def closure(self, joint: Joint) -> Sum:
        """The vector from bearing to journal, with every slide on the way."""
        arms: Counter[str] = Counter()
        fixed, slides = [0.0, 0.0], Counter()
        for pin, sign in ((joint.journal, 1), (joint.bearing, -1)):
            place = place_of(self.places, pin)
            while place is not None:
                fixed = [x + sign * part for x, part in zip(fixed, place.fixed, strict=True)]
                for k, arm in place.arms.items():
                    arms[k] += sign * arm
                root = self._sliding_root(place.chain)
                place = None
                if root is not None:
                    base = self.base(root)
                    slides.update({name: sign * own for name, own in base.slides.items()})
                    place = Place(base.arms, base.fixed, self._inner(root))
        return Sum(
            {k: arm for k, arm in arms.items() if arm}, tuple(fixed), {k: n for k, n in slides.items() if n}
        )

    def _sliding_root(self, chain: int | None) -> str | None:
        return next((name for name in self.slides.values() if self.places[name].chain == chain), None)

    def _inner(self, root: str) -> int | None:
        """The chain in which the guide of a sliding link lies."""
        return place_of(self.places, self.places[root].sides[0]).chain

    def vector(self, *pins: Pin) -> Sum:
        """The vector to a pin, from a second one where there are two; a base that both have falls out."""
        ends = [(place_of(self.places, pin), sign) for pin, sign in zip(pins, (1, -1), strict=False)]
        arms: dict[str, float] = {}
        for place, sign in ends:
            for k, arm in place.arms.items():
                arms[k] = arms.get(k, 0.0) + sign * arm
        x, y = (sum(sign * place.fixed[i] for place, sign in ends) for i in (0, 1))
        same = len({place.chain for place, _ in ends}) < len(ends)
        bases = tuple((place.chain, sign) for place, sign in ends if place.chain is not None)
        return Sum(arms, (x, y), bases=() if same else bases)

    def parts(self, loose: Iterable[Joint]) -> dict[str, Any]:
        """Parts of the equations' structure that follow from the cut, by their names in a `Linkage`.

        Parameters
        ----------
        loose : iterable of Joint
            Those with clearance.
        """
        held = (name for name, place in self.places.items() if place.parent is not None)
        return {
            "links": tuple(self.links),
            "couplings": self._couplings(),
            "floats": self._floats(),
            "joints": tuple(each for joint in loose for each in self._clearances(joint)),
            "pins": tuple(map(self._pin, held)),
            "beams": tuple(self._beam(link) for link in self.links.values() if link.elastic),
            "slides": tuple(starmap(self._slide, self.slides.items())),
            "closures": tuple(self._closure(joint, led) for cut, led in self.cuts for joint in cut),
        }

    def numbers(self, made: structure.Linkage, loose: Iterable[Joint]) -> dict[str, float]:
        """Numbers of a structure that is made of these parts, but of its loops, by name."""
        links = self.links
        values = {f"H_{k}_{m}": self._inertia(k, m) for k, m in made.couplings}
        values |= {f"mu_{k}": self._moment(k, links) for k in links}
        values |= {f"m_{f}": sum(links[k].mass for k in chain) for f, chain in enumerate(made.floats)}
        for pin in made.pins:
            values[f"m_{pin.name}"] = sum(links[k].mass for k in pin.links)
            for chain, name in pin.bases:
                values[name] = sum(links[k].mass for k in pin.links if self.places[k].chain == chain)
            values |= {f"mu_{pin.name}_{k}": self._moment(k, pin.links) for k in pin.arms}
        for joint in loose:
            values |= {f"{word}_{joint.name}": value for word, value in joint.numbers.items()}
            values |= self.vector(joint.journal, joint.bearing).numbers(joint.name, "r")
        for beam in made.beams:
            link, arms = links[beam.link], self.places[beam.link].arms
            values |= _bending(link) | {f"L_{link.name}_{k}": arm for k, arm in arms.items()}
            values |= stretch.numbers(link) if beam.axial else {}
        return values

    def span(self, name: str, pins: Mapping[str, Pin]) -> structure.Span:
        """The vector between two pins of a spring or a load, or to its one, in the equations' structure."""
        vector = self.vector(*pins.values())
        return structure.Span(name, tuple(vector.arms), vector.bases)

    def span_numbers(self, name: str, pins: Mapping[str, Pin]) -> dict[str, float]:
        """Its constant part and its arms, m, by name."""
        return self.vector(*pins.values()).numbers(name)

    def _floats(self) -> tuple[tuple[str, ...], ...]:
        """Names of the links of each floating chain."""
        chains = {place.chain for place in self.places.values()} - {None}
        of = {name: self.places[name].chain for name in self.links}
        return tuple(tuple(name for name in of if of[name] == chain) for chain in sorted(chains))

    def _clearances(self, joint: Joint) -> Iterator[structure.Clearance]:
        """A bearing, or the corners of a slider."""
        one = self._clearance(joint)
        corners = structure.CORNERS.values() if joint.prismatic else (None,)
        for name, corner in zip(joint.contacts, corners, strict=True):
            yield replace(one, name=name, joint=joint.name, corner=corner) if corner else one

    def _clearance(self, joint: Joint) -> structure.Clearance:
        pins = joint.journal, joint.bearing
        vector, friction = self.vector(*pins), joint.friction or FRICTIONLESS
        bends = [pin.link in self.links and self.links[pin.link].elastic for pin in pins]
        ends = [("end" if pin.at else "start") * bent for pin, bent in zip(pins, bends, strict=True)]
        return structure.Clearance(
            name=joint.name,
            journal=joint.journal.link,
            bearing=joint.bearing.link,
            arms=tuple(vector.arms),
            bases=vector.bases,
            law=joint.contact.law,
            tension=joint.contact.tension,
            friction=friction.law if friction.rubs else "none",
            viscous=friction.viscous > 0,
            ends=tuple(ends),
        )

    def _pin(self, link: str) -> structure.Pin:
        """The joint that holds a link, and the links, arms and masses of chains beyond it."""
        parent, moved = self.places[link].parent, [link]
        for name, place in self.places.items():
            if place.holder in moved:
                moved.append(name)
        arms = dict.fromkeys(k for j in moved for k in (*self.places[j].arms, j))
        chains, pin = dict.fromkeys(self.places[k].chain for k in moved), f"m_{parent.name}"
        bases = tuple((f, pin if len(chains) == 1 else f"{pin}_{f}") for f in chains if f is not None)
        sign = 1 if parent.bearing.link == link else -1
        return structure.Pin(parent.name, sign, tuple(arms), bases, tuple(moved))

    def _beam(self, link: Link) -> structure.Beam:
        place, beam = self.places[link.name], link.beam
        modes = beam.size, tuple(place.arms), place.chain, beam.damping_ratio > 0, 2 * beam.axial
        return structure.Beam(link.name, *modes)

    def _slide(self, name: str, link: str) -> structure.Slide:
        place, base, inner = self.places[link], self.base(link), self._inner(link)
        own = place.holder, place.chain, base.slides[name]
        return structure.Slide(name, link, *own, tuple(base.arms), inner)

    def _closure(self, joint: Joint, unknowns: tuple[Unknown, ...]) -> structure.Closure:
        vector = self.closure(joint)
        names = joint.name, joint.journal.link, joint.bearing.link
        return structure.Closure(*names, tuple(vector.arms), tuple(vector.slides.items()), unknowns)

    def _couplings(self) -> tuple[tuple[str, str], ...]:
        """Pairs of links (each once) whose angles share an entry of the mass matrix."""
        moving = [{*place.arms, name} for name, place in self.places.items()]  # that move its centre
        pairs = combinations_with_replacement(self.links, 2)
        return tuple(pair for pair in pairs if any({*pair} <= links for links in moving))

    def _inertia(self, k: str, m: str) -> float:
        """H_km = sum_j m_j L_jk L_jm + m_m s_m L_mk + m_k s_k L_km + delta_km J_k."""
        total = sum(link.mass * self._arm(j, k) * self._arm(j, m) for j, link in self.links.items())
        for a, b in ((k, m), (m, k)):
            total += self.links[b].mass * self.links[b].centre * self._arm(b, a)
        return total + (self.links[k].inertia if k == m else 0.0)

    def _moment(self, k: str, among: Collection[str]) -> float:
        """mu_k = sum_j m_j L_jk + m_k s_k over the links of these names."""
        own = self.links[k].mass * self.links[k].centre if k in among else 0
        return own + sum(self.links[j].mass * self._arm(j, k) for j in among)

    def _arm(self, j: str, k: str) -> float:
        return self.places[j].arms.get(k, 0.0)


def _bending(link: Link) -> dict[str, float]:
    """Modal numbers S, I, omega^2, 2 xi omega, end slopes, gauge; rates and accelerations given as 0."""
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
    return stretch.named(link, rows)


def decomposed(mechanism: Mechanism, first: str | None) -> Plan | None:
    """The order in which the ideal loops close after one link; None where they do not.

    Links that would be known first if clearances were 0 are free first: where that mechanism is away from its
    dead centres, so is this.
    """
    names = [link.name for link in mechanism.links]
    whole = decompose(names, mechanism.joints, first)
    ideal = [joint for joint in mechanism.joints if joint.ideal]
    return decompose(names, ideal, first, whole.order if whole else ())


def _on_loops(joints: Sequence[Joint]) -> list[Joint]:
    """The joints on loops: joints that are left when links held by one joint are taken away."""
    left = list(joints)
    while True:
        count = Counter(name for joint in left for name in joint.links)
        inner = [joint for joint in left if all(name == GROUND or count[name] > 1 for name in joint.links)]
        if len(inner) == len(left):
            return left
        left = inner


def origins(mechanism: Mechanism, joints: Sequence[Joint]) -> dict[str, Place]:
    """Place every link's origin: from the ground outwards along these joints, then the chains that float.

    Of joints that would close a loop none is used: along all joints, the origins are the ideal mechanism's.
    """
    places: dict[str, Place] = {}
    _grow(places, joints)
    for link in mechanism.links:
        if link.name not in places:
            places[link.name] = Place(chain=_chains(places))
            _grow(places, joints)
    return places


def held(plan: Plan) -> dict[str, Place]:
    """Place every link's origin as a plan holds it."""
    places: dict[str, Place] = {}
    for link, joint, holder in plan.held:
        places[link] = _hang(places, link, joint, holder) if joint else Place(chain=_chains(places))
    return places


def _chains(places: Mapping[str, Place]) -> int:
    """Number of chains with a base of their own."""
    return len({place.chain for place in places.values()} - {None})


def _grow(places: dict[str, Place], joints: Sequence[Joint]) -> None:
    """Add every link that a joint connects to one that is placed (or to the ground)."""
    grown = True
    while grown:
        grown = False
        for joint in joints:
            for inner, outer in joint.ends:
                known = inner.link == GROUND or inner.link in places
                if known and outer.link != GROUND and outer.link not in places:
                    places[outer.link] = _hang(places, outer.link, joint, inner.link)
                    grown = True


def _hang(places: Mapping[str, Place], link: str, joint: Joint, holder: str) -> Place:
    """Place a link on the other side of a joint; on a guide it is the first of its own chain."""
    inner, outer = next(pair for pair in joint.ends if pair[0].link == holder)
    start = Place(chain=_chains(places)) if joint.prismatic else place_of(places, inner)
    origin = start.at(link, -outer.at)
    return Place(origin.arms, origin.fixed, origin.chain, joint, holder)


def place_of(places: Mapping[str, Place], pin: Pin) -> Place:
    """Place of a pin."""
    return Place(fixed=pin.point) if pin.link == GROUND else places[pin.link].at(pin.link, pin.at)
