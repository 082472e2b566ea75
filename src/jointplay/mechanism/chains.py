"""A linkage cut at its clearance joints: a forest of open chains, and the constant tables of its equations.

The model, section 1: every link's origin is P_j = base + sum_k L_jk e_k with constant L, in a chain that is
grounded (base a fixed point) or floats (base a coordinate).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from jointplay.errors import InputError, Problem
from jointplay.mechanism.base import GROUND
from jointplay.mechanism.beam import Link
from jointplay.mechanism.parts import Joint, Pin
from jointplay.mechanism.records import Mechanism


@dataclass
class Place:
    """Where a link's origin lies: L_jk, a fixed point or the number of a floating chain, and how it is held.

    `parent` is the ideal joint that holds it, `holder` the link on that joint's other side.
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


def forest(mechanism: Mechanism, cut: bool = True, without: str | None = None) -> dict[str, Place]:
    """Place every link: from the ground outwards along joints, then the chains that float.

    Parameters
    ----------
    mechanism : Mechanism
        Its links and joints.
    cut : bool
        True: clearance joints are cut. False: every joint counts as ideal, and of the joints that would close
        a loop none is used; so is the position of the ideal mechanism found from its angles.
    without : str, optional
        An ideal joint that is cut as well: the one that closes a four-bar.

    Raises
    ------
    InputError
        If ideal joints close a loop (only where `cut`).
    """
    joints = [j for j in mechanism.joints if not (cut and j.clearance > 0) and j.name != without]
    places, floats = {}, 0
    _grow(places, joints)
    for link in mechanism.links:
        if link.name not in places:
            places[link.name] = Place(chain=floats)
            floats += 1
            _grow(places, joints)
    closing = [joint.name for joint in joints if joint not in [p.parent for p in places.values()]]
    if cut and closing:
        raise InputError([Problem("mechanism.joints", closing, _LOOP)], "mechanism")
    return places


_LOOP = (
    "these ideal joints close a loop; a four-bar without any clearance is accepted, or a mechanism with at "
    "least one clearance joint in each loop (clearance greater than 0 m)"
)


def _grow(places: dict[str, Place], joints: list[Joint]) -> None:
    """Add every link that a joint connects to one that is placed (or to the ground)."""
    grown = True
    while grown:
        grown = False
        for joint in joints:
            for inner, outer in ((joint.journal, joint.bush), (joint.bush, joint.journal)):
                known = inner.link == GROUND or inner.link in places
                if known and outer.link != GROUND and outer.link not in places:
                    held = place_of(places, inner).at(outer.link, -outer.at)
                    places[outer.link] = Place(held.arms, held.fixed, held.chain, joint, inner.link)
                    grown = True


def place_of(places: dict[str, Place], pin: Pin) -> Place:
    """Where a pin lies."""
    if pin.link == GROUND:
        return Place(fixed=pin.point)
    return places[pin.link].at(pin.link, pin.at)


def support(places: dict[str, Place], link: str) -> set[str]:
    """Links whose turning moves the mass centre of a link."""
    return {*places[link].arms, link}


def beyond(places: dict[str, Place], link: str) -> list[str]:
    """The link and all that hang on it: a holder has its place before what it holds."""
    found = [link]
    for name, place in places.items():
        if place.holder in found:
            found.append(name)
    return found


def couplings(mechanism: Mechanism, places: dict[str, Place]) -> Iterator[tuple[str, str]]:
    """Pairs of links (each once) whose angles share an entry of the mass matrix."""
    names = [link.name for link in mechanism.links]
    for i, k in enumerate(names):
        for m in names[i:]:
            if any({k, m} <= support(places, j) for j in names):
                yield k, m


def inertia(links: tuple[Link, ...], places: dict[str, Place], k: str, m: str) -> float:
    """H_km = sum_j m_j L_jk L_jm + m_m s_m L_mk + m_k s_k L_km + delta_km J_k."""
    arm = {link.name: places[link.name].arms for link in links}
    total = sum(link.mass * arm[link.name].get(k, 0.0) * arm[link.name].get(m, 0.0) for link in links)
    by_name = {link.name: link for link in links}
    for a, b in ((k, m), (m, k)):
        total += by_name[b].mass * by_name[b].centre * arm[b].get(a, 0.0)
    return total + (by_name[k].inertia if k == m else 0.0)


def moment(links: list[Link], places: dict[str, Place], k: str) -> float:
    """mu_k = sum_j m_j L_jk + m_k s_k over the given links."""
    own = sum(link.mass * link.centre for link in links if link.name == k)
    return own + sum(link.mass * places[link.name].arms.get(k, 0.0) for link in links)
