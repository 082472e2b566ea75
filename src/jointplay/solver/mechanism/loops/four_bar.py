"""Four-bar loops: ground, crank, coupler and rocker, found from the joints alone, and closed in closed form.

Method: the crank's end A follows from the crank angle; the joint B of the dyad of coupler and rocker lies on
two circles, one about A and one about the rocker's pivot C; the two intersections are the branches. Speeds
are the closure d₁ e₁ + d₂ e₂ = C − O + d₃ e₃ differentiated in time and projected on e₂ and e₃, exactly.
Assumptions: planar, rigid, every joint ideal. Units: m, rad, rad/s.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

from jointplay.display.errors import refuse
from jointplay.solver.mechanism.base import GROUND
from jointplay.solver.mechanism.parts.joints import Joint, Pin

Branch = Literal["upper", "lower"]
BRANCHES: tuple[Branch, ...] = get_args(Branch)
ROUNDING = 1e-12  # of the loop's length: a change-point linkage goes flat, and closes
_DEAD = 1e-12  # squared height of B over A–C, in squared lengths, below which its digits are mostly rounding


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
    def lengths(self) -> dict[str, float]:
        """Distances between the pins, m, by link name and ``ground``."""
        sides = {name: abs(d) for name, d in zip(self.links, self.spans, strict=True)}
        return sides | {GROUND: math.dist(self.origin, self.pivot)}

    @property
    def closes(self) -> bool:
        """Whether it closes at some crank angle without lying flat: no side as long as the rest together."""
        sides = list(self.lengths.values())
        return min(sides[:3]) > 0 and 2 * max(sides) < sum(sides)

    def angles(self, crank_angle: float, branch: Branch) -> tuple[float, float, float]:
        """Intersect the circles about A and C: B = A + (C − A)(along + i across)/D, as vectors.

        Raises
        ------
        InputError
            If the loop cannot close at this angle, or is at a dead centre, where coupler and rocker lie in
            one line and the crank does not determine their speeds.
        """
        crank, coupler, rocker = self.spans
        ax = self.origin[0] + crank * math.cos(crank_angle)
        ay = self.origin[1] + crank * math.sin(crank_angle)
        dx, dy = self.pivot[0] - ax, self.pivot[1] - ay
        gap = math.hypot(dx, dy)
        along, across = self._triangle(gap, crank_angle)
        if (self.pivot[0] >= self.origin[0]) != (branch == "upper"):  # B is on the right of the line A–C
            across = -across
        ux, uy = dx / gap, dy / gap
        bx, by = along * ux - across * uy, along * uy + across * ux  # B − A
        on_coupler = math.atan2(math.copysign(1.0, coupler) * by, math.copysign(1.0, coupler) * bx)
        turn = math.copysign(1.0, rocker)
        return crank_angle, on_coupler, math.atan2(turn * (by - dy), turn * (bx - dx))

    def speeds(self, angles: tuple[float, float, float], crank_speed: float) -> tuple[float, float, float]:
        """Project d₁ω₁n₁ + d₂ω₂n₂ = d₃ω₃n₃ on e₃ and on e₂."""
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
        base, slack = self._ground_line, slack + ROUNDING * sum(sides)
        near, far = self._limits
        arcs = []
        if abs(ground - crank) < abs(coupler - rocker) - slack:
            arcs.append((base - near, base + near))
        if ground + crank > coupler + rocker + slack:
            arcs.append((base + far, base + math.tau - far))
        return tuple(arcs)

    def _triangle(self, gap: float, crank_angle: float) -> tuple[float, float]:
        """Give B's distances along and across the line A–C; the sides are coupler, rocker and `gap`."""
        coupler, rocker = abs(self.spans[1]), abs(self.spans[2])
        scale = max(coupler, rocker, gap)
        # Heron's product keeps digits where the triangle is nearly flat; a difference of squares loses them
        flat = (coupler + rocker - gap) * (gap - coupler + rocker) * (gap + coupler - rocker)
        height = 0.0 if gap <= _DEAD * scale else flat * (coupler + rocker + gap) / (2 * gap) ** 2
        if height < -_DEAD * scale**2:
            raise refuse(crank_angle, self._cannot_close(gap), "crank_angle")
        if height < _DEAD * scale**2:
            accepted = "a crank angle away from the dead centre is accepted"
            why = f"{self.coupler} and {self.rocker} lie in one line here"
            raise refuse(crank_angle, f"{accepted}: {why}", "crank_angle")
        return (gap**2 + (coupler - rocker) * (coupler + rocker)) / (2 * gap), math.sqrt(height)

    @property
    def _ground_line(self) -> float:
        """Crank angle at which its far end points to the rocker's pivot, rad."""
        base = math.atan2(self.pivot[1] - self.origin[1], self.pivot[0] - self.origin[0])
        return base + (math.pi if self.spans[0] < 0 else 0.0)

    @property
    def _limits(self) -> list[float]:
        """Angles between crank and ground line at which coupler and rocker lie flat, within [0, π], rad."""
        crank, coupler, rocker, ground = self.lengths.values()
        flat = (abs(coupler - rocker), coupler + rocker) if ground else ()
        cosines = [(crank**2 + ground**2 - gap**2) / (2 * crank * ground) for gap in flat] or [1.0, 1.0]
        return [math.acos(min(1.0, max(-1.0, cosine))) for cosine in cosines]

    def _cannot_close(self, gap: float) -> str:
        _, coupler, rocker, _ = self.lengths.values()
        span = f"from {abs(coupler - rocker):.6g} to {coupler + rocker:.6g} m"
        why = f"{self.coupler} and {self.rocker} span {span}, and here {gap:.6g} m lie between their far pins"
        if not self.closes:
            return f"links that close are accepted; these close at no crank angle: {why}"
        near, far = self._limits
        limits = f"between {near:.6g} and {far:.6g} rad to either side of the ground line"
        limits += f" (at {self._ground_line:.6g} rad)"
        return f"a crank angle {limits} is accepted: {why}"


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
