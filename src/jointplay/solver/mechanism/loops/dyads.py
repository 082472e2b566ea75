"""The order in which ideal loops close: which joints hold links, at which ones the loops are cut.

Method: Assur's groups. From the links that are known, the ground and the driven link first, two links are
added at a time that three ideal joints connect to known ones and to each other (a dyad, class II); where
there is none, one link more is free. Loops are cut at revolute joints only, so that every prismatic joint
holds a link. What is left with a joint between two known links does not decompose, and another link is tried
as the free one. Where all this fails, 2 m links with 3 m joints, m = 2, 3, ..., count as known together too
(class III and higher).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Joint

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
