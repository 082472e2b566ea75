"""A linkage cut at its clearance joints: a forest of open chains, and the constant tables of its equations.

The model, section 1: every link's origin is P_j = base + sum_k L_jk e_k with constant L, in a chain that is
grounded (base a fixed point) or floats (base a coordinate).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations_with_replacement

from jointplay.errors import InputError, Problem
from jointplay.mechanism.base import GROUND
from jointplay.mechanism.beam import Link
from jointplay.mechanism.closure import closed_four_bar
from jointplay.mechanism.joints import Joint, Pin
from jointplay.mechanism.loop import FourBar
from jointplay.mechanism.records import Mechanism

_LOOP = (
    "these ideal joints close a loop; a four-bar without any clearance is accepted, or a mechanism with at "
    "least one clearance joint in each loop (clearance greater than 0 m)"
)


Angles = Mapping[str, float]  # or angular velocities, by link


@dataclass
class Place:
    """Where a point of a link lies: arms L_jk from a fixed point or from the base of a floating chain.

    Of a link's origin, `parent` is the ideal joint that holds it, `holder` the link on its other side.
    """

    arms: dict[str, float] = field(default_factory=dict)
    fixed: tuple[float, float] = (0.0, 0.0)
    chain: int | None = None
    parent: Joint | None = None
    holder: str | None = None

    def at(self, link: str, distance: float) -> Place:
        """A place on the link at a distance from its origin."""
        arms = Counter(self.arms)
        if distance:
            arms[link] += distance
        return Place(dict(arms), self.fixed, self.chain)

    def motion(self, angles: Angles, speeds: Angles) -> tuple[list[float], list[float]]:
        """Position and velocity relative to the base."""
        x, v = list(self.fixed), [0.0, 0.0]
        for k, arm in self.arms.items():
            c, s = math.cos(angles[k]), math.sin(angles[k])
            x = [x[0] + arm * c, x[1] + arm * s]
            v = [v[0] - arm * s * speeds[k], v[1] + arm * c * speeds[k]]
        return x, v


@dataclass(frozen=True)
class Forest:
    """Where the links of a linkage lie when it is cut at its clearance joints.

    Parameters
    ----------
    links : dict of str to Link
        By name, in the mechanism's order; point masses are in their own.
    places : dict of str to Place
        Origin of each link by its name, a holder before what it holds.
    loop : FourBar or None
        The closed loop of a four-bar, which is cut at the joint between coupler and rocker.
    """

    links: dict[str, Link]
    places: dict[str, Place]
    loop: FourBar | None

    @classmethod
    def of(cls, mechanism: Mechanism) -> Forest:
        """Cut a linkage.

        Raises
        ------
        InputError
            If ideal joints close a loop other than a four-bar's.
        """
        loop = closed_four_bar(mechanism)
        joints = [j for j in mechanism.joints if j.ideal and not (loop and j.name == loop.joints[2])]
        places = origins(mechanism, joints)
        parents = [place.parent for place in places.values()]
        if closing := [joint.name for joint in joints if joint not in parents]:
            raise InputError([Problem("mechanism.joints", closing, _LOOP)], "mechanism")
        return cls({link.name: link.total for link in mechanism.links}, places, loop)

    @property
    def floats(self) -> tuple[tuple[str, ...], ...]:
        """Names of the links of each floating chain."""
        chains = {place.chain for place in self.places.values()} - {None}
        of = {name: self.places[name].chain for name in self.links}
        return tuple(tuple(name for name in of if of[name] == chain) for chain in sorted(chains))

    def separation(self, joint: Joint) -> Place:
        """Constant part and arms D_k of the vector from bearing to journal, r = const + sum_k D_k e_k."""
        journal, bearing = (place_of(self.places, pin) for pin in (joint.journal, joint.bearing))
        names = dict.fromkeys([*journal.arms, *bearing.arms])
        arms = {k: journal.arms.get(k, 0.0) - bearing.arms.get(k, 0.0) for k in names}
        return Place(arms, (journal.fixed[0] - bearing.fixed[0], journal.fixed[1] - bearing.fixed[1]))

    def carried(self, link: str) -> list[str]:
        """The link and all that hang on it."""
        names = [link]
        for name, place in self.places.items():
            if place.holder in names:
                names.append(name)
        return names

    def couplings(self) -> tuple[tuple[str, str], ...]:
        """Pairs of links (each once) whose angles share an entry of the mass matrix."""
        moving = [{*place.arms, name} for name, place in self.places.items()]  # that move its centre
        pairs = combinations_with_replacement(self.links, 2)
        return tuple(pair for pair in pairs if any({*pair} <= links for links in moving))

    def inertia(self, k: str, m: str) -> float:
        """H_km = sum_j m_j L_jk L_jm + m_m s_m L_mk + m_k s_k L_km + delta_km J_k."""
        total = sum(link.mass * self._arm(j, k) * self._arm(j, m) for j, link in self.links.items())
        for a, b in ((k, m), (m, k)):
            total += self.links[b].mass * self.links[b].centre * self._arm(b, a)
        return total + (self.links[k].inertia if k == m else 0.0)

    def moment(self, k: str, among: Collection[str]) -> float:
        """mu_k = sum_j m_j L_jk + m_k s_k over the links of these names."""
        own = self.links[k].mass * self.links[k].centre if k in among else 0
        return own + sum(self.links[j].mass * self._arm(j, k) for j in among)

    def _arm(self, j: str, k: str) -> float:
        return self.places[j].arms.get(k, 0.0)


def origins(mechanism: Mechanism, joints: Sequence[Joint]) -> dict[str, Place]:
    """Place every link's origin: from the ground outwards along these joints, then the chains that float.

    Of joints that would close a loop none is used: along all joints, the origins are the ideal mechanism's.
    """
    places, floats = {}, 0
    _grow(places, joints)
    for link in mechanism.links:
        if link.name not in places:
            places[link.name] = Place(chain=floats)
            floats += 1
            _grow(places, joints)
    return places


def _grow(places: dict[str, Place], joints: Sequence[Joint]) -> None:
    """Add every link that a joint connects to one that is placed (or to the ground)."""
    grown = True
    while grown:
        grown = False
        for joint in joints:
            for inner, outer in joint.ends:
                known = inner.link == GROUND or inner.link in places
                if known and outer.link != GROUND and outer.link not in places:
                    held = place_of(places, inner).at(outer.link, -outer.at)
                    places[outer.link] = Place(held.arms, held.fixed, held.chain, joint, inner.link)
                    grown = True


def place_of(places: Mapping[str, Place], pin: Pin) -> Place:
    """Where a pin lies."""
    return Place(fixed=pin.point) if pin.link == GROUND else places[pin.link].at(pin.link, pin.at)
