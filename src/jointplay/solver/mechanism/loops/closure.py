"""The ideal four-bar: positions and speeds of its links at a crank angle, in closed form.

Method: the crank's end A follows from the crank angle; the joint B between coupler and rocker lies on two
circles, one about A and one about the rocker's pivot C; the two intersections are the branches. Speeds are
the closure d₁ e₁ + d₂ e₂ = C − O + d₃ e₃ differentiated in time and projected on e₂ and e₃, exactly.
Assumptions: planar, rigid, every joint ideal. Units: m, rad, rad/s.
"""

from __future__ import annotations

import math
from typing import Any

from jointplay.display.errors import InputError, Problem, refuse, unknown
from jointplay.solver.mechanism.base import ANGLE, FAR, GROUND, is_number
from jointplay.solver.mechanism.loops.loop import Branch, FourBar, find_four_bar
from jointplay.solver.mechanism.records import Mechanism

BRANCHES = ("upper", "lower")
ROUNDING = 1e-12  # of the loop's length: a change-point linkage goes flat, and closes
_DEAD = 1e-12  # squared height of B over A–C, in squared lengths, below which its digits are mostly rounding


def four_bar(mechanism: Mechanism) -> FourBar:
    """Find the four-bar loop of a mechanism.

    Raises
    ------
    InputError
        If the mechanism is not a four-bar with its driven link pinned to the ground.
    """
    loop = find_four_bar(mechanism.joints, mechanism.crank)
    if loop is None:
        links, joints = len(mechanism.links), len(mechanism.joints)
        given = f"{links} links, {joints} joints, driven link {mechanism.crank!r}"
        other = "of any other mechanism the initial angles of all links must be given"
        form = "crank, coupler and rocker in one loop of four joints, the driven crank pinned to the ground"
        problem = Problem("mechanism", given, f"a four-bar ({form}) is accepted; {other}")
        raise InputError([problem], "mechanism")
    return loop


def ideal_state(
    mechanism: Mechanism,
    crank_angle: float = 0.0,
    crank_speed: float | None = None,
    branch: Branch | None = None,
) -> tuple[dict[str, float], dict[str, float]]:
    """Give link angles and angular velocities of a four-bar with every joint ideal.

    Parameters
    ----------
    mechanism : Mechanism
        A four-bar; clearances in it are taken as 0.
    crank_angle : float
        Angle of the driven link, rad.
    crank_speed : float, optional
        Its angular velocity, rad/s. Left out: that at which the drive starts, 0 without one.
    branch : {'upper', 'lower'}, optional
        Which of the two ways to assemble the loop; the mechanism's own if left out. Seen along the line
        from the crank's end to the rocker's pivot, ``upper`` puts the joint between coupler and rocker on
        the left where the ground line O–C points to +x (or straight up or down), and on the right where it
        points to −x. With a level ground line longer than the crank this is above it; a mirror image left
        to right keeps its branch.

    Returns
    -------
    angles : dict of str to float
        By link name, rad; the crank's as given, the others' in (−π, π].
    speeds : dict of str to float
        By link name, rad/s.

    Raises
    ------
    InputError
        If the mechanism is not a four-bar, cannot close at this angle, or is at a dead centre, where
        coupler and rocker lie in one line and the crank does not determine their speeds.
    """
    branch = mechanism.branch if branch is None else branch
    if crank_speed is None:
        crank_speed = mechanism.drive.start_speed if mechanism.drive else 0.0
    check_crank(crank_angle, crank_speed, branch)
    loop = four_bar(mechanism)
    angles = _angles(loop, crank_angle, branch)
    state = dict(zip(loop.links, zip(angles, _speeds(loop, angles, crank_speed), strict=True), strict=True))
    names = [link.name for link in mechanism.links]
    return {name: state[name][0] for name in names}, {name: state[name][1] for name in names}


def check_crank(crank_angle: Any, crank_speed: Any, branch: Any = BRANCHES[0]) -> None:
    """Refuse an angle, a speed or a branch that is none."""
    problems = []
    if not is_number(crank_angle) or abs(crank_angle) > FAR:
        problems.append(Problem("crank_angle", crank_angle, ANGLE))
    if not is_number(crank_speed):
        problems.append(Problem("crank_speed", crank_speed, "a finite speed in rad/s is accepted"))
    if branch not in BRANCHES:
        problems.append(unknown("branch", branch, branch, BRANCHES, "branch"))
    if problems:
        raise InputError(problems)


def _angles(loop: FourBar, crank_angle: float, branch: Branch) -> tuple[float, float, float]:
    """Intersect the circles about A and C: B = A + (C − A)(along + i across)/D, as vectors."""
    crank, coupler, rocker = loop.spans
    ax = loop.origin[0] + crank * math.cos(crank_angle)
    ay = loop.origin[1] + crank * math.sin(crank_angle)
    dx, dy = loop.pivot[0] - ax, loop.pivot[1] - ay
    gap = math.hypot(dx, dy)
    along, across = _triangle(loop, gap, crank_angle)
    across *= loop.side(branch)
    ux, uy = dx / gap, dy / gap
    bx, by = along * ux - across * uy, along * uy + across * ux  # B − A
    on_coupler = math.atan2(math.copysign(1.0, coupler) * by, math.copysign(1.0, coupler) * bx)
    turn = math.copysign(1.0, rocker)
    return crank_angle, on_coupler, math.atan2(turn * (by - dy), turn * (bx - dx))


def _triangle(loop: FourBar, gap: float, crank_angle: float) -> tuple[float, float]:
    """Give B's distances along and across the line from A to C; the sides are coupler, rocker and `gap`."""
    coupler, rocker = abs(loop.spans[1]), abs(loop.spans[2])
    scale = max(coupler, rocker, gap)
    # Heron's product keeps digits where the triangle is nearly flat; the difference of squares loses them.
    flat = (coupler + rocker - gap) * (gap - coupler + rocker) * (gap + coupler - rocker)
    height = 0.0 if gap <= _DEAD * scale else flat * (coupler + rocker + gap) / (2 * gap) ** 2
    if height < -_DEAD * scale**2:
        raise refuse(crank_angle, _cannot_close(loop, gap), "crank_angle")
    if height < _DEAD * scale**2:
        accepted = "a crank angle away from the dead centre is accepted"
        why = f"{loop.coupler} and {loop.rocker} lie in one line here"
        raise refuse(crank_angle, f"{accepted}: {why}", "crank_angle")
    return (gap**2 + (coupler - rocker) * (coupler + rocker)) / (2 * gap), math.sqrt(height)


def open_arcs(loop: FourBar, slack: float = 0.0) -> tuple[tuple[float, float], ...]:
    """Give the crank angles at which a loop cannot close, from where to where, rad.

    Parameters
    ----------
    loop : FourBar
        The loop.
    slack : float
        By how much its clearances can make up together, m.
    """
    sides = loop.lengths
    coupler, rocker, crank, ground = sides[loop.coupler], sides[loop.rocker], sides[loop.crank], sides[GROUND]
    base, slack = _ground_line(loop), slack + ROUNDING * sum(sides.values())
    near, far = (_opening(crank, ground, d) for d in (abs(coupler - rocker), coupler + rocker))
    arcs = []
    if abs(ground - crank) < abs(coupler - rocker) - slack:
        arcs.append((base - near, base + near))
    if ground + crank > coupler + rocker + slack:
        arcs.append((base + far, base + math.tau - far))
    return tuple(arcs)


def _ground_line(loop: FourBar) -> float:
    """Crank angle at which its far end points to the rocker's pivot, rad."""
    base = math.atan2(loop.pivot[1] - loop.origin[1], loop.pivot[0] - loop.origin[0])
    return base + (math.pi if loop.spans[0] < 0 else 0.0)


def _cannot_close(loop: FourBar, gap: float) -> str:
    sides = loop.lengths
    coupler, rocker, crank, ground = sides[loop.coupler], sides[loop.rocker], sides[loop.crank], sides[GROUND]
    span = f"from {abs(coupler - rocker):.6g} to {coupler + rocker:.6g} m"
    why = f"{loop.coupler} and {loop.rocker} span {span}, and here {gap:.6g} m lie between their far pins"
    near, far = (_opening(crank, ground, d) for d in (abs(coupler - rocker), coupler + rocker))
    if not loop.closes:
        return f"links that close are accepted, these do at no crank angle: {why}"
    limits = f"between {near:.6g} and {far:.6g} rad to either side of the ground line"
    limits += f" (at {_ground_line(loop):.6g} rad)"
    return f"a crank angle {limits} is accepted: {why}"


def _opening(crank: float, ground: float, gap: float) -> float:
    """Angle between crank and ground line at which their far ends lie `gap` apart, clipped to [0, π]; rad."""
    cosine = (crank**2 + ground**2 - gap**2) / (2 * crank * ground) if ground else 1.0
    return math.acos(min(1.0, max(-1.0, cosine)))


def _speeds(
    loop: FourBar, angles: tuple[float, float, float], crank_speed: float
) -> tuple[float, float, float]:
    """Project d₁ω₁n₁ + d₂ω₂n₂ = d₃ω₃n₃ on e₃ and on e₂."""
    (d1, d2, d3), (t1, t2, t3) = loop.spans, angles
    fold = math.sin(t3 - t2)
    coupler = -d1 * crank_speed * math.sin(t3 - t1) / (d2 * fold)
    rocker = -d1 * crank_speed * math.sin(t2 - t1) / (d3 * fold)
    return crank_speed, coupler, rocker
