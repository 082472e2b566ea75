"""The order in which ideal loops close: which joints hold links, at which ones the loops are cut.

Method: Assur's groups. From the links that are known, the ground and the driven link first, two links are
added at a time that three ideal joints connect to known ones and to each other (a dyad, class II); where
there is none, one link more is free. Loops are cut at revolute joints only, so that every prismatic joint
holds a link. What is left with a joint between two known links does not decompose, and another link is tried
as the free one. Where all this fails, 2 m links with 3 m joints, m = 2, 3, ..., count as known together too
(class III and higher).

A four-bar is the driven link and one dyad of coupler and rocker, whose joint B lies on two circles: one about
the crank's end A, one about the rocker's pivot C. Where these meet are its branches. Its speeds are the
closure d1 e1 + d2 e2 = C - O + d3 e3 differentiated in time and projected on e2 and e3. Units: m, rad, rad/s.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from jointplay.display.errors import refuse
from jointplay.solver.mechanism.base import GROUND, Branch
from jointplay.solver.mechanism.parts.joints import Joint, Pin

ROUNDING = 1e-12  # of the loop's length: a change-point linkage goes flat, and closes
_DEAD = 1e-12  # squared height of B over A-C, in squared lengths, below which its digits are mostly rounding

Unknown = str | tuple[None, str]  # angle of a link, by name; slide of a joint
Cuts = tuple[tuple[tuple[Joint, ...], tuple[Unknown, ...]], ...]


@dataclass(frozen=True)
class Plan:
    """Plan of a mechanism: the joint that holds each link, and the joints at which loops are cut.

    Parameters
    ----------
    held : tuple of (str, Joint or None, str or None)
        Each link, the joint that holds it, and the link on its other side, a holder before what it holds;
        None: the link floats.
    cuts : tuple of (tuple of Joint, tuple of Unknown)
        Revolute joints at which loops that close together are cut, with the unknowns that follow, two of each
        joint, in order.
    """

    held: tuple[tuple[str, Joint | None, str | None], ...] = ()
    cuts: Cuts = ()

    @property
    def order(self) -> list[str]:
        """Names of the links, in order."""
        return [link for link, _, _ in self.held]

    @property
    def free(self) -> list[Unknown]:
        """Angles and slides that are free."""
        led = [unknown for _, follow in self.cuts for unknown in follow]
        unknowns = (_unknown(link, joint) for link, joint, _ in self.held)
        return [unknown for unknown in unknowns if unknown not in led]

    def _with(self, held: Sequence[tuple[str, Joint, str]], *cut: Joint) -> Plan:
        follow = tuple(_unknown(link, joint) for link, joint, _ in held)
        return Plan((*self.held, *held), (*self.cuts, (cut, follow)) if cut else self.cuts)

    @property
    def joints(self) -> list[Joint]:
        """The joints that it uses."""
        cut = [joint for joints, _ in self.cuts for joint in joints]
        return [joint for _, joint, _ in self.held if joint] + cut


def _unknown(link: str, joint: Joint | None) -> Unknown:
    return (None, joint.name) if joint and joint.prismatic else link


def decompose(
    links: Sequence[str], joints: Sequence[Joint], first: str | None, order: Sequence[str] = ()
) -> Plan | None:
    """Decompose a linkage into free links and dyads, and larger groups where these do not suffice.

    Parameters
    ----------
    links : sequence of str
        Names of the links.
    joints : sequence of Joint
        The ideal joints, all of which are used.
    first : str or None
        The driven link.
    order : sequence of str
        Links in the order in which they are best free, after the driven one.

    Returns
    -------
    Plan or None
        None where the loops do not decompose.
    """
    rank = {name: place for place, name in enumerate(dict.fromkeys([first, *order, *links]))}
    return _decomposed(links, joints, rank, dyads=True) or _decomposed(links, joints, rank, dyads=False)


def _decomposed(
    links: Sequence[str], joints: Sequence[Joint], rank: dict[str, int], dyads: bool
) -> Plan | None:
    """Decompose it, into dyads alone or not."""
    dead: set[frozenset[str]] = set()

    def grown(plan: Plan) -> Plan | None:
        known = {GROUND, *plan.order}
        used = plan.joints
        if frozenset(known) in dead:
            return None
        if any(joint.links <= known and joint not in used for joint in joints):
            dead.add(frozenset(known))
            return None
        if len(known) > len(links):
            return plan
        groups = (group for size in range(4, len(rank), 2) for group in _groups(plan, size, joints, rank))
        for step in _steps(plan, known, joints, rank, iter(()) if dyads else groups):
            if (found := grown(step)) is not None:
                return found
        dead.add(frozenset(known))
        return None

    return grown(Plan())


def _steps(
    plan: Plan, known: Collection[str], joints: Sequence[Joint], rank: dict[str, int], groups: Iterator[Plan]
) -> Iterator[Plan]:
    """Next plans: with the driven link, a dyad or group, one more free link, or one that floats."""
    rest = sorted((name for name in rank if name is not None and name not in known), key=rank.get)
    holds = {name: [j for j in joints if name in j.links and j.links & {*known}] for name in rest}
    if rest[0] == next(iter(rank)) and any(not j.prismatic for j in holds[rest[0]]):
        joint = next(j for j in holds[rest[0]] if not j.prismatic)
        yield plan._with([(rest[0], joint, _other(joint, rest[0]))])
        return
    dyads = (_dyad(one, other, middle, holds) for one, other, middle in _pairs(rest, joints))
    if dyad := next(filter(None, dyads), None):
        yield plan._with(*dyad)
        return
    if (group := next(groups, None)) is not None:
        yield group
        return
    hung = [name for name in rest if holds[name]]
    for name in hung:
        yield plan._with([(name, holds[name][0], _other(holds[name][0], name))])
    if not hung:
        yield plan._with([(rest[0], None, None)])


def _pairs(rest: list[str], joints: Sequence[Joint]) -> Iterator[tuple[str, str, Joint]]:
    for place, one in enumerate(rest):
        for other in rest[place + 1 :]:
            yield from ((one, other, joint) for joint in joints if joint.links == {one, other})


def _dyad(
    one: str, other: str, middle: Joint, holds: dict[str, list[Joint]]
) -> tuple[list[tuple[str, Joint, str]], Joint] | None:
    """Joints that hold the two links of a dyad, and the joint at which it is cut."""
    if not holds[one] or not holds[other]:
        return None
    near, far = holds[one][0], holds[other][0]
    if near.prismatic and far.prismatic and middle.prismatic:
        return None
    if not middle.prismatic:
        return [(one, near, _other(near, one)), (other, far, _other(far, other))], middle
    if far.prismatic:
        one, other, near, far = other, one, far, near
    return [(one, near, _other(near, one)), (other, middle, one)], far


def _groups(plan: Plan, size: int, joints: Sequence[Joint], rank: dict[str, int]) -> Iterator[Plan]:
    """Next plans with links that as many joints determine together, each cut where none slides."""
    known = {GROUND, *plan.order}

    def count(links: Collection[str]) -> int:
        """Equations less unknowns of some links of a group, all others at rest."""
        held = [joint for joint in inner if joint.links & {*links} and joint.links <= known | {*links}]
        return 2 * len(held) - 3 * len(links)

    for group in combinations([name for name in rank if name is not None and name not in known], size):
        inner = [j for j in joints if j.links & {*group} and j.links <= known | {*group}]
        parts = (part for few in range(1, size) for part in combinations(group, few))
        if count(group) != 0 or any(count(part) > 0 for part in parts):
            continue
        held, seen = [], {*known}
        while joint := _next(inner, seen):
            (link,) = joint.links - seen
            held.append((link, joint, _other(joint, link)))
            seen.add(link)
        cut = [joint for joint in inner if all(joint is not one for _, one, _ in held)]
        if len(held) == size and not any(joint.prismatic for joint in cut):
            yield plan._with(held, *cut)


def _next(joints: Sequence[Joint], known: Collection[str]) -> Joint | None:
    """A joint that connects one more link to known ones, best a prismatic one."""
    ends = [joint for joint in joints if len(joint.links & {*known}) == 1]
    return min(ends, key=lambda joint: not joint.prismatic, default=None)


def _other(joint: Joint, link: str) -> str:
    (name,) = joint.links - {link}
    return name


@dataclass(frozen=True)
class FourBar:
    """A loop of revolute joints: ground, driven link, dyad of coupler and rocker, ground.

    Parameters
    ----------
    links : tuple of str, shape (3,)
        Names of crank, coupler and rocker.
    joints : tuple of str, shape (4,)
        Names of the joints O, A, B, C in loop order, whatever they are called.
    spans : tuple of float, shape (3,)
        Signed distances between a link's two pins along its direction, m; crank, coupler, rocker.
    origin, pivot : complex
        x + iy of where the crank and the rocker are pinned to the ground, m.
    """

    links: tuple[str, ...]
    joints: tuple[str, ...]
    spans: tuple[float, float, float]
    origin: complex
    pivot: complex

    @classmethod
    def of(cls, joints: Sequence[Joint], crank: str | None) -> FourBar | None:
        """Find the loop that starts with the driven link, from the joints alone; None if there is none."""
        pins: dict[str, list[tuple[Joint, Pin, Pin]]] = {}
        for joint in joints:
            for near, far in joint.ends:
                pins.setdefault(near.link, []).append((joint, near, far))
        turning = len(joints) == 4 and not any(joint.prismatic for joint in joints)
        path = [end for end in pins.get(GROUND, ()) if end[2].link == crank]
        if not turning or len(path) != 1 or sorted(map(len, pins.values())) != [2, 2, 2, 2]:
            return None
        while len(path) < 4:
            path += [end for end in pins[path[-1][2].link] if end[0] is not path[-1][0]]
        names, near, far = zip(*((joint.name, near, far) for joint, near, far in path), strict=True)
        a, b, c = (there.at - here.at for here, there in zip(far, near[1:], strict=False))
        links = tuple(pin.link for pin in near[1:])
        return cls(links, names, (a, b, -c), complex(*near[0].point), complex(*far[3].point))

    @property
    def lengths(self) -> dict[str, float]:
        """Distances between the pins, m, by link name and ``ground``."""
        sides = {name: abs(span) for name, span in zip(self.links, self.spans, strict=True)}
        return sides | {GROUND: abs(self.pivot - self.origin)}

    @property
    def closes(self) -> bool:
        """Whether it closes at some crank angle without lying flat: no side as long as the rest together."""
        sides = list(self.lengths.values())
        return min(sides[:3]) > 0 and 2 * max(sides) < sum(sides)

    def angles(self, crank_angle: float, branch: Branch) -> tuple[float, float, float]:
        """Intersect the circles about A and C.

        Raises
        ------
        InputError
            If the loop cannot close at this angle, or is at a dead centre, where coupler and rocker lie in
            one line and the crank does not determine their speeds.
        """
        crank, coupler, rocker = self.spans
        diagonal = self.pivot - (self.origin + cmath.rect(crank, crank_angle))  # from A to C
        gap = math.hypot(diagonal.real, diagonal.imag)
        along, across = self._triangle(gap, crank_angle)
        if (self.pivot.real >= self.origin.real) != (branch == "upper"):  # B is on the right of the line A-C
            across = -across
        reach = complex(along, across) * (diagonal / gap)  # from A to B
        rest = reach - diagonal
        on = (cmath.phase(v if span > 0 else -v) for v, span in ((reach, coupler), (rest, rocker)))
        return crank_angle, *on

    def speeds(self, angles: tuple[float, float, float], crank_speed: float) -> tuple[float, float, float]:
        """Project d1 w1 n1 + d2 w2 n2 = d3 w3 n3 on e3 and on e2."""
        (d1, d2, d3), (t1, t2, t3) = self.spans, angles
        fold = math.sin(t3 - t2)
        coupler = -d1 * crank_speed * math.sin(t3 - t1) / (d2 * fold)
        rocker = -d1 * crank_speed * math.sin(t2 - t1) / (d3 * fold)
        return crank_speed, coupler, rocker

    def open_arcs(self, slack: float = 0.0) -> tuple[tuple[float, float], ...]:
        """Give the crank angles at which it cannot close, from where to where, rad.

        `slack`: by how much its clearances can make up together, m.
        """
        crank, coupler, rocker, ground = sides = self.lengths.values()
        slack += ROUNDING * sum(sides)
        base, near, far = self._limits
        arcs = []
        if abs(ground - crank) < abs(coupler - rocker) - slack:
            arcs.append((base - near, base + near))
        if ground + crank > coupler + rocker + slack:
            arcs.append((base + far, base + math.tau - far))
        return tuple(arcs)

    def _triangle(self, gap: float, crank_angle: float) -> tuple[float, float]:
        """Give B's distances along and across the line A-C; the sides are coupler, rocker and `gap`."""
        coupler, rocker = abs(self.spans[1]), abs(self.spans[2])
        scale = max(coupler, rocker, gap)
        # Heron's product keeps digits where the triangle is nearly flat; a difference of squares loses them
        flat = (coupler + rocker - gap) * (gap - coupler + rocker) * (gap + coupler - rocker)
        height = 0.0 if gap <= _DEAD * scale else flat * (coupler + rocker + gap) / (2 * gap) ** 2
        if height >= _DEAD * scale**2:
            return (gap**2 + (coupler - rocker) * (coupler + rocker)) / (2 * gap), math.sqrt(height)
        both = " and ".join(self.links[1:])
        if height >= -_DEAD * scale**2:
            text = f"a crank angle away from the dead centre is accepted: {both} lie in one line here"
        else:
            base, near, far = self._limits
            text = f"a crank angle between {near:.6g} and {far:.6g} rad to either side of the ground line"
            text += f" (at {base:.6g} rad) is accepted: {both} span from {abs(coupler - rocker):.6g} to"
            text += f" {coupler + rocker:.6g} m, and here {gap:.6g} m lie between their far pins"
        raise refuse(crank_angle, text, "crank_angle")

    @property
    def _limits(self) -> tuple[float, float, float]:
        """Crank angle of the ground line; those from it, within [0, pi], at which the dyad lies flat, rad."""
        crank, coupler, rocker, ground = self.lengths.values()
        line = cmath.phase(self.pivot - self.origin) + (math.pi if self.spans[0] < 0 else 0.0)
        flat = (abs(coupler - rocker), coupler + rocker) if ground else ()
        cosines = [(crank**2 + ground**2 - gap**2) / (2 * crank * ground) for gap in flat] or [1.0, 1.0]
        return line, *(math.acos(min(1.0, max(-1.0, cosine))) for cosine in cosines)
