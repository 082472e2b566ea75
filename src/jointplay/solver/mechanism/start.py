"""Start of a linkage: angles, speeds and places of its links."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from jointplay.display.errors import NOTHING, Problem, raise_any, refuse
from jointplay.display.number_text import typed
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.base import ANGLE, FAR, GROUND, is_number
from jointplay.solver.mechanism.loops.ideal import State, ideal_state, placed
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from jointplay.solver.mechanism.loops.loop_numbers import Bases
from jointplay.solver.mechanism.parts.joints import Pin
from jointplay.solver.mechanism.records import Mechanism

IDEAL, WRITTEN_OUT = ("crank_angle", "crank_speed", "branch"), ("angle", "angular_velocity")
SAME = 1e-12  # of a speed: what units and ten operations round away


def start(mechanism: Mechanism, initial: Any, forest: Forest | None = None) -> State:
    """Give angles (rad), speeds (rad/s) and places of every link at the start.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    initial : mapping or None
        ``crank_angle``, ``crank_speed`` and ``branch`` of the ideal mechanism, or ``angle`` and
        ``angular_velocity`` by link; None: the ideal mechanism at crank angle 0 and no-load speed.
    forest : Forest, optional
        The same, cut at its clearance joints and ideal loops.

    Raises
    ------
    InputError
        Naming every key that does not fit.
    """
    initial = {} if initial is None else initial
    closed = bool((forest or Forest.of(mechanism)).cuts)
    if not isinstance(initial, Mapping):
        text = "a table of crank_angle and crank_speed, or of angle and angular_velocity by link, is accepted"
        raise refuse(initial, text, "initial")
    known = IDEAL if closed else (*IDEAL, *WRITTEN_OUT)
    why = ": in ideal loops links determine each other" if closed else ""
    accepted = f"keys {', '.join(known)} are accepted{why}"
    problems = [Problem(f"initial.{key}", initial[key], accepted) for key in initial if key not in known]
    own = _fixed(mechanism, closed) if not problems else {}
    for key, value in own.items():
        if initial.get(key) is not None and not _same(initial[key], value):
            accepted = f"{value!r}, the mechanism's own, is accepted here"
            problems.append(Problem(f"initial.{key}", initial[key], accepted))
    raise_any(problems, "initial")
    if not initial.keys().isdisjoint(WRITTEN_OUT):
        return placed(mechanism, *_written_out(mechanism, initial))
    return ideal_state(mechanism, **{k: own.get(k, v) for k, v in initial.items() if v is not None})


def _fixed(mechanism: Mechanism, closed: bool) -> dict[str, Any]:
    """Fixed values of a start: a closed loop's own branch, and the crank speed that a drive imposes."""
    speed = mechanism.drive.imposed_speed if mechanism.drive else None
    own = {"branch": mechanism.branch} if closed else {}
    return own | ({"crank_speed": speed} if speed is not None else {})


def _same(given: object, own: object) -> bool:
    """Whether a value is the mechanism's own, a number but for rounding."""
    return given == own or (is_number(given) and is_number(own) and math.isclose(given, own, rel_tol=SAME))


def _written_out(mechanism: Mechanism, initial: Mapping[str, Any]) -> tuple[Any, Any]:
    names = [link.name for link in mechanism.links]
    given = [initial.get(key, NOTHING) for key in WRITTEN_OUT]
    problems = [
        Problem(f"initial.{key}", values, f"one finite number for each of {', '.join(names)} is accepted")
        for key, values in zip(WRITTEN_OUT, given, strict=True)
        if not isinstance(values, Mapping)
        or {*values} != {*names}
        or not all(map(is_number, values.values()))
    ]
    problems = problems or [
        Problem(f"initial.angle.{name}", angle, ANGLE) for name, angle in given[0].items() if abs(angle) > FAR
    ]
    drive = mechanism.drive
    imposed = drive.imposed_speed if drive else None
    if not problems and imposed is not None and not _same(given[1][drive.link], imposed):
        accepted = f"{typed(imposed, 0)}, at which its drive starts, is accepted"
        problems = [Problem(f"initial.angular_velocity.{drive.link}", given[1][drive.link], accepted)]
    raise_any(problems, "initial")
    return given[0], given[1] if imposed is None else dict(given[1]) | {drive.link: imposed}


def approaches(bases: Bases) -> np.ndarray:
    """Give the memories of laws at the start: speeds with which contacts began, then deflections of bristles.

    A joint that starts in contact has no beginning to remember: it counts as begun with the size of the
    normal speed that it has there, or with the smallest speed of its law, whichever is larger; one that
    starts in flight has the smallest speed. Bristles are straight.

    Returns
    -------
    ndarray, shape (laws that remember, 2)
        The speed, and the law's smallest one, m/s; the deflection, and that of steady sliding, m.
    """
    rows = []
    for joint in bases.mechanism.clearance_joints:
        if LAWS[joint.contact.law].floor:
            slowest = joint.contact.coefficients[LAWS[joint.contact.law].floor]
            for u, v_n in bases.penetrations(joint):
                rows.append((max(abs(v_n) if u >= 0 else 0.0, slowest), slowest))
    for joint in bases.mechanism.clearance_joints:
        friction = joint.friction
        if friction and friction.rubs and (size := FRICTIONS[friction.law].deflection):
            row = (0.0, size(friction.coefficient, *friction.numbers.values()))
            rows += [row] * len(bases.penetrations(joint))
    return np.array(rows, dtype=float).reshape(-1, 2)


class Pose(NamedTuple):
    """Angles of the links, rad, and their origins, shape (2,), m, by name."""

    angles: Mapping[str, float]
    origins: Mapping[str, np.ndarray]

    def along(self, link: str, at: float) -> np.ndarray:
        """The point of a link's line at a distance from its origin, m."""
        angle = self.angles[link]
        return self.origins[link] + at * np.array([np.cos(angle), np.sin(angle)])

    def point(self, pin: Pin) -> np.ndarray:
        """The point of a pin, m."""
        return np.array(pin.point) if pin.link == GROUND else self.along(pin.link, pin.at)

    def direction(self, pin: Pin) -> float:
        """The direction of a pin's line, rad from x."""
        return pin.direction + (0.0 if pin.link == GROUND else self.angles[pin.link])


def start_pose(mechanism: Mechanism, initial: Any = None) -> Pose:
    """Give where the links are at the start; keywords and errors as of `start`."""
    state = start(mechanism, initial)
    return Pose(state.angles, {name: rows[0] for name, rows in state.points.items()})
