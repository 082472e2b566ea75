"""The ideal mechanism's configurations: of a four-bar in closed form, else by Newton's method.

A four-bar has a branch by name (`dyads.FourBar`). Of any other linkage its guess names it, and unknowns are
x, y and angle of every link; every joint, with clearance taken as 0, gives two equations

    revolute    P_journal - P_bearing = 0,
    prismatic   l (theta_journal + direction - theta_bearing - direction) = 0,  n.(P_journal - P_bearing) = 0,

n across the guide, l a length. With the driven link's angle (and where more is free, that as it was guessed)
they are as many as the unknowns. From rough angles the driven link is led to its angle in small steps, so
that the motion stays on the branch that was guessed. Speeds solve the same Jacobian. Units: m, rad, s.

Whether a driven link can go where its drive takes it: the angles at which its mechanism does not close.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, get_args

import numpy as np

from jointplay.display.errors import NOTHING, InputError, Problem, raise_any, refuse, unknown
from jointplay.solver.mechanism.base import ANGLE, FAR, GROUND, Branch, is_number
from jointplay.solver.mechanism.loops.dyads import FourBar, decompose
from jointplay.solver.mechanism.loops.kinematic_chains import origins
from jointplay.solver.mechanism.parts.joints import Joint, Pin
from jointplay.solver.mechanism.records import Mechanism

STEP = 0.05  # rad of the driven link: the largest step from configuration to configuration
LEAST = 1e-4  # rad: where smaller steps do not close either, nothing does
MOST = 0.5  # rad in a step of Newton's method
CLOSED = 1e-13  # of the reach: a gap in a joint that is rounding
AROUND = 49  # crank angles at which a mechanism that does not close is looked at
FLAT = 1e-6  # of the largest singular value: at a smaller one the driven link determines no speeds


class State(NamedTuple):
    """Angles and speeds of the links by name, and their origins' x, y and velocities."""

    angles: dict[str, float]
    speeds: dict[str, float]
    points: dict[str, np.ndarray]


@dataclass(frozen=True)
class Closure:
    """Closure of every joint of a mechanism, in absolute coordinates x, y, angle of each link."""

    mechanism: Mechanism

    @cached_property
    def place(self) -> dict[str, int]:
        """Index of the first coordinate of each link."""
        return {link.name: 3 * i for i, link in enumerate(self.mechanism.links)}

    @cached_property
    def reach(self) -> float:
        """The length of all links together, m."""
        return sum(link.length for link in self.mechanism.links)

    @cached_property
    def driver(self) -> str:
        """The link that a crank angle means: the driven one, or the first that is on no guide."""
        sliding = {pin.link for joint in self.mechanism.joints if joint.prismatic for pin in joint.ends[0]}
        names = [link.name for link in self.mechanism.links]
        return self.mechanism.crank or next((name for name in names if name not in sliding), names[0])

    @cached_property
    def further(self) -> list[str | tuple[None, str]]:
        """Freedoms besides the driven link: angles and slides; empty with one freedom."""
        links, joints = list(self.place), self.mechanism.joints
        if 3 * len(links) - 2 * len(joints) <= 1:
            return []
        plan = decompose(links, joints, self.driver)
        return [unknown for unknown in plan.free if unknown != self.driver] if plan else []

    def pin(self, x: np.ndarray, pin: Pin) -> tuple[np.ndarray, np.ndarray]:
        """A pin's point and its derivative by the coordinates, shape (2, coordinates)."""
        slope = np.zeros((2, len(x)))
        if pin.link == GROUND:
            return np.array(pin.point), slope
        i = self.place[pin.link]
        c, s = math.cos(x[i + 2]), math.sin(x[i + 2])
        slope[:, i : i + 3] = [[1, 0, -pin.at * s], [0, 1, pin.at * c]]
        return x[i : i + 2] + pin.at * np.array([c, s]), slope

    def line(self, x: np.ndarray, pin: Pin) -> tuple[float, np.ndarray]:
        """Direction of a pin's line, rad, and its derivative by the coordinates."""
        slope = np.zeros(len(x))
        if pin.link == GROUND:
            return pin.direction, slope
        slope[self.place[pin.link] + 2] = 1.0
        return x[self.place[pin.link] + 2] + pin.direction, slope

    def joint(self, x: np.ndarray, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
        """Gap of a joint (two values, m), and its derivative."""
        (P, dP), (Q, dQ) = self.pin(x, joint.journal), self.pin(x, joint.bearing)
        if not joint.prismatic:
            return P - Q, dP - dQ
        (a, da), (b, db) = self.line(x, joint.journal), self.line(x, joint.bearing)
        d, n = np.array([math.cos(b), math.sin(b)]), np.array([-math.sin(b), math.cos(b)])
        turn = self.reach * math.remainder(a - b, math.tau)
        rows = [self.reach * (da - db), n @ (dP - dQ) - (d @ (P - Q)) * db]
        return np.array([turn, n @ (P - Q)]), np.array(rows)

    def slide(self, x: np.ndarray, joint: Joint) -> tuple[float, np.ndarray]:
        """Position of a slider along its guide, m, and its derivative."""
        (P, dP), (Q, dQ) = (self.pin(x, pin) for pin in (joint.journal, joint.bearing))
        b, db = self.line(x, joint.bearing)
        d, n = np.array([math.cos(b), math.sin(b)]), np.array([-math.sin(b), math.cos(b)])
        return float(d @ (P - Q)), d @ (dP - dQ) + (n @ (P - Q)) * db

    def free(self, x: np.ndarray, unknown: str | tuple[None, str]) -> tuple[float, np.ndarray]:
        """An angle or a slide, and its derivative."""
        if isinstance(unknown, tuple):
            return self.slide(x, self.mechanism.joint(unknown[1]))
        row = np.zeros(len(x))
        row[self.place[unknown] + 2] = 1.0
        return float(x[self.place[unknown] + 2]), row

    def equations(self, x: np.ndarray, held: Mapping) -> tuple[np.ndarray, np.ndarray]:
        """Left-hand sides and Jacobian: all joints, then the unknowns held at a value."""
        pairs = [self.joint(x, joint) for joint in self.mechanism.joints]
        frees = [(self.free(x, unknown), value) for unknown, value in held.items()]
        values = [v for value, _ in pairs for v in value] + [now - value for (now, _), value in frees]
        rows = [row for _, rows in pairs for row in rows] + [row for (_, row), _ in frees]
        return np.array(values), np.array(rows)

    def closed(self, x: np.ndarray, held: Mapping) -> np.ndarray | None:
        """The configuration near x, by Newton's method; None where there is none."""
        for _ in range(50):
            value, J = self.equations(x, held)
            if not np.all(np.isfinite(value)):
                return None
            if np.abs(value).max() <= CLOSED * self.reach:
                return x
            step = np.linalg.lstsq(J, -value, rcond=1e-13)[0]
            x = x + step / max(1.0, np.abs(step[2::3]).max() / MOST)
        return x if np.abs(value).max() <= 1e3 * CLOSED * self.reach else None

    def rough(self, angles: Mapping[str, float], slides: Mapping[str, float]) -> np.ndarray:
        """Coordinates at given angles, and slides where given, with every joint open as little as can be."""
        x = np.zeros(3 * len(self.place))
        for name, i in self.place.items():
            x[i + 2] = angles[name]
        value, J = self.equations(x, {(None, name): s for name, s in slides.items()})
        where = [i + k for i in self.place.values() for k in (0, 1)]
        x[where] += np.linalg.lstsq(J[:, where], -value, rcond=None)[0]
        return x

    def state(self, x: np.ndarray, w: np.ndarray) -> State:
        """The coordinates and speeds by link."""
        angles = {name: float(x[i + 2]) for name, i in self.place.items()}
        speeds = {name: float(w[i + 2]) for name, i in self.place.items()}
        points = {name: np.array([x[i : i + 2], w[i : i + 2]]) for name, i in self.place.items()}
        return State(angles, speeds, points)


def ideal_state(
    mechanism: Mechanism,
    crank_angle: float | None = None,
    crank_speed: float | None = None,
    branch: Branch | None = None,
) -> State:
    """Give the state of a mechanism with every joint ideal: of a four-bar in closed form, else by its guess.

    Parameters
    ----------
    mechanism : Mechanism
        Any linkage; clearances in it are taken as 0.
    crank_angle : float, optional
        Angle of the driven link, rad; 0 if left out.
    crank_speed : float, optional
        Its angular velocity, rad/s. Left out: that at which the drive starts, 0 without one.
    branch : {'upper', 'lower'}, optional
        Which of the two ways to assemble a four-bar; the mechanism's own if left out. Seen along the line
        from the crank's end to the rocker's pivot, ``upper`` puts the joint between coupler and rocker on
        the left where the ground line O–C points to +x (or straight up or down), and on the right where it
        points to −x. With a level ground line longer than the crank this is above it; a mirror image left
        to right keeps its branch.

    Returns
    -------
    State
        The crank's angle as given, the others' in (−π, π].

    Raises
    ------
    InputError
        If the mechanism cannot close at this angle, is at a dead centre, where the crank does not determine
        the other speeds, or is no four-bar and its guess is missing or does not close.
    """
    loop = FourBar.of(mechanism.joints, mechanism.crank)
    if loop is None and branch is not None:
        accepted = "a branch is accepted of a four-bar only; guess names that of others"
        raise refuse(branch, accepted, "initial.branch")
    crank_angle = 0.0 if crank_angle is None else crank_angle
    branch = mechanism.branch if branch is None else branch
    if crank_speed is None:
        crank_speed = mechanism.drive.start_speed if mechanism.drive else 0.0
    _check(crank_angle, crank_speed, branch)
    if loop is None:
        return ideal_configuration(mechanism, crank_angle, crank_speed)
    angles = loop.angles(crank_angle, branch)
    speeds = loop.speeds(angles, crank_speed)
    names = [link.name for link in mechanism.links]
    by_link = (dict(zip(loop.links, values, strict=True)) for values in (angles, speeds))
    return placed(mechanism, *({name: values[name] for name in names} for values in by_link))


def _check(crank_angle: Any, crank_speed: Any, branch: Any) -> None:
    """Refuse an angle, a speed or a branch that is none."""
    problems = []
    if not is_number(crank_angle) or abs(crank_angle) > FAR:
        problems.append(Problem("crank_angle", crank_angle, ANGLE))
    if not is_number(crank_speed):
        problems.append(Problem("crank_speed", crank_speed, "a finite speed in rad/s is accepted"))
    if branch not in get_args(Branch):
        problems.append(unknown("branch", branch, branch, get_args(Branch), "branch"))
    raise_any(problems)


def ideal_configuration(mechanism: Mechanism, crank_angle: float, crank_speed: float) -> State:
    """Give the ideal mechanism's state at a crank angle, on the branch of the mechanism's `guess`.

    Parameters
    ----------
    mechanism : Mechanism
        Any linkage; clearances in it are taken as 0.
    crank_angle, crank_speed : float
        Of the driven link, rad and rad/s. What else is free stays as guessed, at rest.

    Raises
    ------
    InputError
        If the guess is missing or does not close, or the mechanism does not close at this crank angle.
    """
    closure = Closure(mechanism)
    angles, slides = _guessed(closure)
    begin = angles[closure.driver]
    x = closure.rough(angles, slides)
    held = {closure.driver: begin} | {k: closure.free(x, k)[0] for k in closure.further}
    start = closure.closed(x, held)
    if start is None:
        raise refuse(dict(mechanism.guess), _open(closure, x, held, begin), "mechanism.guess")
    turn = math.remainder(crank_angle - begin, math.tau)
    x, done = _led(closure, start, held, begin, turn)
    if done < 1:
        x, done = _led(closure, start, held, begin, turn - math.copysign(math.tau, turn))
    if done < 1:
        raise refuse(crank_angle, _open(closure, start, held, crank_angle), "initial.crank_angle")
    x[2::3] = [math.remainder(angle, math.tau) for angle in x[2::3]]
    x[closure.place[closure.driver] + 2] = crank_angle
    _, J = closure.equations(x, held)
    scale = np.linalg.svd(J / np.linalg.norm(J, axis=1, keepdims=True), compute_uv=False)
    if len(scale) < len(x) or scale[-1] < FLAT * scale[0]:
        text = "a crank angle away from the dead centre, where the crank determines no speeds, is accepted"
        raise refuse(crank_angle, text, "initial.crank_angle")
    right = np.zeros(len(J))
    right[2 * len(mechanism.joints)] = crank_speed
    return closure.state(x, np.linalg.lstsq(J, right, rcond=None)[0])


def placed(mechanism: Mechanism, angles: Mapping[str, float], speeds: Mapping[str, float]) -> State:
    """Give the state at given angles and speeds of all links, placed along the joints as if these were ideal.

    Where some are prismatic, every joint is open as little as can be.
    """
    if not any(joint.prismatic for joint in mechanism.joints):
        along = origins(mechanism, mechanism.joints)
        points = {name: np.array(place.motion(angles, speeds)) for name, place in along.items()}
        return State(angles, speeds, points)
    closure = Closure(mechanism)
    x = closure.rough(angles, {})
    _, J = closure.equations(x, {})
    where = [i + k for i in closure.place.values() for k in (0, 1)]
    w = np.zeros(len(x))
    for name, i in closure.place.items():
        w[i + 2] = speeds[name]
    w[where] = np.linalg.lstsq(J[:, where], -J[:, 2::3] @ w[2::3], rcond=None)[0]
    return closure.state(x, w)


def open_arcs(mechanism: Mechanism) -> tuple[tuple[float, float], ...]:
    """Give the driven link's angles at which the mechanism cannot close, whatever its clearances.

    Returns
    -------
    tuple of (float, float)
        From where to where, rad. None where it closes all round, where more than the driven link is free, or
        where the mechanism's `guess` does not close.
    """
    closure = Closure(mechanism)
    if closure.further:
        return ()
    try:
        angles, slides = _guessed(closure)
    except InputError:
        return ()
    begin = angles[closure.driver]
    held = {closure.driver: begin}
    x = closure.closed(closure.rough(angles, slides), held)
    if x is None:
        return ()
    last, ahead = _led(closure, x, held, begin, math.tau)
    if ahead == 1:
        return ()
    _, back = _led(closure, x, held, begin, -math.tau)
    slack = sum(joint.clearance for joint in mechanism.joints) + FLAT * closure.reach

    def opens(angle: float) -> bool:
        return sum(_gaps(closure, last, held, angle).values()) > slack

    fine = np.linspace(begin + ahead * math.tau, begin + (1 - back) * math.tau, AROUND)
    found = [opens(angle) for angle in fine]
    edges = []  # at the first angle it closes still
    for i in np.flatnonzero(np.diff(found)):
        low, high = fine[i], fine[i + 1]
        while high - low > LEAST:
            middle = (low + high) / 2
            low, high = (middle, high) if opens(middle) == found[i] else (low, middle)
        edges.append((low + high) / 2)
    edges += [fine[-1]] * found[-1]
    return tuple((float(a), float(b)) for a, b in zip(edges[::2], edges[1::2], strict=True))


def _led(closure: Closure, x: np.ndarray, held: dict, begin: float, turn: float) -> tuple[np.ndarray, float]:
    """Lead the driven link through a turn in small steps, up to which share of it the mechanism closes."""
    done, step, drive = 0.0, STEP, len(closure.mechanism.joints) * 2
    while done < 1.0:
        ahead = min(1.0, done + step / max(abs(turn), step))
        _, J = closure.equations(x, held)
        right = np.zeros(len(J))
        right[drive] = (ahead - done) * turn
        guess = x + np.linalg.lstsq(J, right, rcond=1e-13)[0]
        found = closure.closed(guess, held | {closure.driver: begin + ahead * turn})
        if found is not None and np.abs(found - guess)[2::3].max() < 10 * step:
            x, done, step = found, ahead, min(STEP, 2 * step)
        elif (step := step / 4) < LEAST:
            break
    return x, done


def _gaps(closure: Closure, x: np.ndarray, held: dict, crank_angle: float) -> dict[str, float]:
    """Gap of each joint at a crank angle, where the joints are as little open as can be, m."""
    from scipy.optimize import least_squares

    joints = closure.mechanism.joints
    weight = np.where(np.arange(2 * len(joints) + len(held)) < 2 * len(joints), 1.0, 1e3 * closure.reach)
    aim = held | {closure.driver: crank_angle}
    best = least_squares(
        lambda y: weight * closure.equations(y, aim)[0],
        x,
        jac=lambda y: weight[:, None] * closure.equations(y, aim)[1],
    )
    return {joint.name: float(np.hypot(*closure.joint(best.x, joint)[0])) for joint in joints}


def _open(closure: Closure, x: np.ndarray, held: dict, crank_angle: float) -> str:
    """Message on a mechanism that does not close at a crank angle: the gaps of its joints."""
    gaps = _gaps(closure, x, held, crank_angle)
    open_ones = ", ".join(name for name, gap in gaps.items() if gap > 1e-3 * max(gaps.values()))
    miss = f"its joints are {sum(gaps.values()):.3g} m apart ({open_ones})"
    where = f"at a crank angle of {crank_angle:.6g} rad {miss}"
    return f"a mechanism that closes is accepted: {where}"


def _guessed(closure: Closure) -> tuple[dict[str, float], dict[str, float]]:
    """Rough angle of every link, of links on guides by the guides', and the slides that were guessed."""
    mechanism, guess = closure.mechanism, dict(closure.mechanism.guess)
    angles = {closure.driver: 0.0} | {name: guess[name] for name in closure.place if name in guess}
    slides = {joint.name: guess[joint.name] for joint in mechanism.joints if joint.name in guess}
    grown = True
    while grown:
        grown = False
        for near, far in (pair for joint in mechanism.joints if joint.prismatic for pair in joint.ends):
            if far.link not in angles and far.link != GROUND and (near.link == GROUND or near.link in angles):
                angles[far.link] = angles.get(near.link, 0.0) + near.direction - far.direction
                grown = True
    missing = [name for name in closure.place if name not in angles]
    if missing:
        rough = ", ".join(f"{name} = …" for name in missing)
        text = (
            f"rough angles (rad) that name the branch are needed of {', '.join(missing)}: "
            f"guess = {{ {rough} }}, beside {closure.driver} = {angles[closure.driver]:g}"
        )
        raise InputError([Problem("mechanism.guess", guess or NOTHING, text)], "mechanism")
    return angles, slides


def cannot_turn(mechanism: Mechanism, angle: float, travel: float) -> Iterator[Problem]:
    """Yield the problem of a crank that is to be driven where the mechanism cannot close.

    Parameters
    ----------
    mechanism : Mechanism
        Whose drive imposes a speed.
    angle : float
        Where the crank starts, rad.
    travel : float
        How far it goes on, rad.
    """
    arcs = _unclosed(mechanism)
    if any(_meets(arc, angle, travel) for arc in arcs):
        yield _stuck(mechanism, arcs)


def doubts(mechanism: Mechanism) -> Iterator[Problem]:
    """Yield the doubt whether a crank that is driven round, at no imposed speed, is meant to rock."""
    drive = mechanism.drive
    round_ = drive and (drive.kind in ("motor", "torque") or (drive.kind == "servo" and drive.speed != 0.0))
    if round_ and (arcs := _unclosed(mechanism)):
        yield _stuck(mechanism, arcs)


def _meets(arc: tuple[float, float], angle: float, travel: float) -> bool:
    begin, end = sorted((angle, angle + travel))
    ahead = (arc[0] - begin) % math.tau  # from where the way begins to where the arc does
    return begin + ahead < end or ahead > math.tau - (arc[1] - arc[0])


def _stuck(mechanism: Mechanism, arcs: tuple[tuple[float, float], ...]) -> Problem:
    loop, crank = FourBar.of(mechanism.joints, mechanism.crank), mechanism.crank
    lengths = loop.lengths if loop else {link.name: link.length for link in mechanism.links}
    spans = (
        f"from {a:.4g} to {b:.4g} rad ({math.degrees(a):.4g} to {math.degrees(b):.4g} deg)" for a, b in arcs
    )
    closed = f"the loop does not close at angles of {crank} {' and '.join(spans)}"
    accepted = f"lengths (m) with which {crank} can go where it is driven are accepted: {closed}"
    return Problem("mechanism.links", lengths, accepted)


def _unclosed(mechanism: Mechanism) -> tuple[tuple[float, float], ...]:
    """From where to where the driven link finds the mechanism open, rad."""
    if loop := FourBar.of(mechanism.joints, mechanism.crank):
        return loop.open_arcs(sum(joint.clearance for joint in mechanism.joints))
    parts = (
        *((link.name, link.length) for link in mechanism.links),
        *((each.kind, each.journal, each.bearing, each.clearance) for each in mechanism.joints),
        *sorted(mechanism.guess.items()),
        mechanism.crank,
    )
    return _led_round(_Geometry(mechanism, parts))


@dataclass(frozen=True)
class _Geometry:
    """A mechanism, equal to another with the same links and joints: whether it closes hangs on no more."""

    mechanism: Mechanism = field(compare=False)
    parts: tuple[Any, ...]


@lru_cache(maxsize=256)
def _led_round(given: _Geometry) -> tuple[tuple[float, float], ...]:
    return open_arcs(given.mechanism)
