"""Where a linkage starts: angles and speeds of its links."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jointplay.errors import NOTHING, InputError, Problem, refuse
from jointplay.mechanism.base import ANGLE, FAR, is_number
from jointplay.mechanism.closure import closed_four_bar, ideal_state
from jointplay.mechanism.records import Mechanism

IDEAL, WRITTEN_OUT = ("crank_angle", "crank_speed", "branch"), ("angle", "angular_velocity")


def start(mechanism: Mechanism, initial: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Give angles (rad) and speeds (rad/s) of every link at the start.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    initial : mapping or None
        ``crank_angle``, ``crank_speed`` and ``branch`` of the ideal mechanism, or ``angle`` and
        ``angular_velocity`` by link; None: the ideal mechanism at crank angle 0 and no-load speed.

    Raises
    ------
    InputError
        Naming every key that does not fit.
    """
    if initial is None:
        return ideal_state(mechanism)
    if not isinstance(initial, Mapping):
        raise refuse(
            initial,
            "a table of crank_angle and crank_speed, or of angle and angular_velocity by link, is accepted",
            "initial",
        )
    closed = closed_four_bar(mechanism) is not None
    known = IDEAL if closed else (*IDEAL, *WRITTEN_OUT)
    why = ": with every joint ideal the crank determines the other links" if closed else ""
    accepted = f"keys {', '.join(known)} are accepted{why}"
    problems = [Problem(f"initial.{key}", initial[key], accepted) for key in initial if key not in known]
    for key, value in _fixed(mechanism, closed).items() if not problems else ():
        if initial.get(key) not in (None, value):
            accepted = f"{value!r}, the mechanism's own, is accepted here"
            problems.append(Problem(f"initial.{key}", initial[key], accepted))
    if problems:
        raise InputError(problems, "initial")
    if not initial.keys().isdisjoint(WRITTEN_OUT):
        return _written_out(mechanism, initial)
    return ideal_state(mechanism, **initial)


def _fixed(mechanism: Mechanism, closed: bool) -> dict[str, Any]:
    """What a closed loop starts with in any case, its own branch, and the speed that drives a linkage."""
    speed = mechanism.drive.imposed_speed if mechanism.drive else None
    given = closed or (mechanism.drive and mechanism.drive.transient)
    own = {"branch": mechanism.branch} if closed else {}
    return own | ({"crank_speed": speed} if given and speed is not None else {})


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
    if not problems and drive and drive.transient and given[1][drive.link] != drive.imposed_speed:
        accepted = f"{drive.imposed_speed:g}, at which its drive starts, is accepted"
        problems = [Problem(f"initial.angular_velocity.{drive.link}", given[1][drive.link], accepted)]
    if problems:
        raise InputError(problems, "initial")
    return given[0], given[1]
