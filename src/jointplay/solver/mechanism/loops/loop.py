"""Four-bar loops: ground, crank, coupler and rocker, found from the joints alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Joint, Pin

Branch = Literal["upper", "lower"]


@dataclass(frozen=True)
class FourBar:
    """A closed loop ground – crank – coupler – rocker – ground.

    Parameters
    ----------
    crank, coupler, rocker : str
        Names of the links in loop order.
    joints : tuple of str, shape (4,)
        Names of the joints O, A, B, C in loop order, whatever they are called.
    spans : tuple of float, shape (3,)
        Signed distances between a link's two pins along its direction, m; crank, coupler, rocker.
    origin, pivot : tuple of float, shape (2,)
        Where the crank and the rocker are pinned to the ground, m.
    """

    crank: str
    coupler: str
    rocker: str
    joints: tuple[str, str, str, str]
    spans: tuple[float, float, float]
    origin: tuple[float, float]
    pivot: tuple[float, float]

    @property
    def links(self) -> tuple[str, str, str]:
        """Names of crank, coupler and rocker."""
        return self.crank, self.coupler, self.rocker

    @property
    def ground(self) -> float:
        """Distance between the two pins on the ground, m."""
        return math.dist(self.origin, self.pivot)

    def side(self, branch: Branch) -> float:
        """Give the side of the line A–C on which B lies: 1 on the left, −1 on the right."""
        left = (self.pivot[0] >= self.origin[0]) == (branch == "upper")
        return 1.0 if left else -1.0

    @property
    def lengths(self) -> dict[str, float]:
        """Distances between the pins, m, by link name and ``ground``."""
        return {name: abs(d) for name, d in zip(self.links, self.spans, strict=True)} | {GROUND: self.ground}

    @property
    def closes(self) -> bool:
        """Whether it closes at some crank angle without lying flat: no side as long as the rest together."""
        sides = list(self.lengths.values())
        return min(sides[:3]) > 0 and 2 * max(sides) < sum(sides)


def find_four_bar(joints: Sequence[Joint], crank: str | None) -> FourBar | None:
    """Find the loop that starts with the driven link, from the joints alone; None if there is no four-bar."""
    pins: dict[str, list[tuple[Joint, Pin, Pin]]] = {}
    for joint in joints:
        for near, far in joint.ends:
            pins.setdefault(near.link, []).append((joint, near, far))
    turning = len(joints) == 4 and not any(joint.prismatic for joint in joints)
    if not turning or len(pins) != 4 or any(len(pair) != 2 for pair in pins.values()):
        return None
    first = [end for end in pins.get(GROUND, ()) if end[2].link == crank]
    if len(first) != 1:
        return None
    path = first
    while len(path) < 4:
        path += [end for end in pins[path[-1][2].link] if end[0] is not path[-1][0]]
    (_, origin, o), (_, a, a2), (_, b, b2), (_, c, pivot) = path
    names: Any = tuple(joint.name for joint, _, _ in path)
    ends: Any = origin.point, pivot.point  # never None on the ground
    return FourBar(o.link, a2.link, b2.link, names, (a.at - o.at, b.at - a2.at, b2.at - c.at), *ends)
