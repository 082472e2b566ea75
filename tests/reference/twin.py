"""The slow twin: mode machine and event-located integration of the free bodies of ``bodies.py``.

Every guard is positive inside its mode and fires when it falls through 0, so a guard that is 0 where a mode
starts cannot fire again at once. An integrator is a function ``advance(system, modes, t, y, t_stop, rtol)``
giving ``(t, y, joint, guard)``, with joint None at t_stop; scipy's is here, CVODE's and the Taylor series' in
the files of those names.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import DOP853, LSODA, Radau
from scipy.optimize import brentq

from .bodies import LINKS, Bodies, Parameters

__all__ = ["Event", "Parameters", "Result", "march", "run"]

METHODS = {"DOP853": DOP853, "Radau": Radau, "LSODA": LSODA}
SAMPLES = 8  # points a step at which guards are looked at


@dataclass(frozen=True)
class Event:
    """One event: time (s), joint, kind, normal and slip speed (m/s) there."""

    time: float
    joint: str
    kind: str
    v_n: float
    v_t: float


@dataclass
class Result:
    """Final angles and speeds by link, (r, r') by clearance joint, events, and states at asked times."""

    t: float
    angles: dict
    speeds: dict
    joints: dict
    events: list
    modes: dict
    y: np.ndarray
    evaluations: int
    states: list = field(default_factory=list)


def guards(system, modes):
    """The (joint, guard) pairs that can fire in these modes."""
    p, found = system.p, []
    for joint, mode in modes.items():
        if mode == "free":
            found.append((joint, "touch"))
        elif mode == "released":
            found.append((joint, "leave"))
            found.append((joint, "reload"))
        else:
            found.append((joint, "leave" if p.tension else "release"))
            if mode == "stick":
                found += [(joint, "cone+"), (joint, "cone-")]
            elif p.f > 0:
                found.append((joint, "slide"))
    return found


def guard_values(system, modes, y):
    """Guard values, each positive inside its mode, in the order of `guards`."""
    motion = system.motion(y)
    contact = {joint: system.contact(joint, y, motion) for joint in modes}
    held = system.solve(y, modes)[1] if "stick" in modes.values() else {}
    values = []
    for joint, guard in guards(system, modes):
        c, limit = contact[joint], system.p.f * contact[joint].force
        values.append(
            {
                "touch": -c.u,
                "leave": c.u,
                "release": c.force,
                "reload": -c.force,
                "slide": -c.v_t if modes[joint] == "slip-" else c.v_t,
                "cone+": limit - held.get(joint, 0.0),
                "cone-": limit + held.get(joint, 0.0),
            }[guard]
        )
    return values


def slide(system, modes, joint, y, v_t):
    """Mode of a touching joint: the sign of v_t, or at v_t = 0 Filippov's choice from both one-sided v_t'."""
    if v_t != 0.0 or system.p.f == 0.0:
        return "slip-" if v_t < 0.0 else "slip+"
    up = system.solve(y, {**modes, joint: "slip+"})[2][joint]
    down = system.solve(y, {**modes, joint: "slip-"})[2][joint]
    if up < 0.0 < down:  # both sides push towards 0; cannot happen where F_n < 0, since then up > down
        return "stick"
    return "slip+" if up + down > 0.0 else "slip-"


def switch(system, modes, joint, guard, y):
    """New modes and the kind of event after ``guard`` of ``joint`` fired at state y."""
    c = system.contact(joint, y)
    if guard == "touch":
        new, kind = slide(system, modes, joint, y, c.v_t), "contact"
    elif guard == "leave":
        new, kind = "free", "separation"
    elif guard == "release":
        new, kind = "released", "release"
    elif guard == "slide":
        new = slide(system, modes, joint, y, 0.0)
        kind = "stick_onset" if new == "stick" else "slip_reversal"
    elif guard == "reload":
        raise RuntimeError(f"released joint {joint} is loaded again before it separates")
    else:
        new, kind = "slip" + guard[-1], "slip_onset"
    return {**modes, joint: new}, kind


def loosen(system, modes, y):
    """Joints whose sticking force another joint's event threw out of its cone."""
    if "stick" not in modes.values():
        return {}
    held = system.solve(y, modes)[1]
    out = {}
    for joint, force in held.items():
        if abs(force) > system.p.f * system.contact(joint, y).force * (1 + 1e-12):
            out[joint] = "slip+" if force > 0 else "slip-"
    return out


def tolerances(system, rtol):
    """Absolute tolerance of every state: rtol/100, speeds in units of a/b."""
    return rtol / 100 * np.repeat([1.0, system.p.w0], system.n)


def advance(system, modes, t, y, t_stop, rtol, method="DOP853"):
    """Integrate with a scipy method until a guard falls through 0 or t_stop is reached."""
    live = guards(system, modes)

    def rate(_, state):
        return system.rate(state, modes)

    # the motor rests at no load, so a first step chosen from the rate alone would be far too long
    options = {"rtol": rtol, "atol": tolerances(system, rtol), "first_step": min(1e-7, t_stop - t)}
    solver = METHODS[method](rate, t, y, t_stop, **options)
    before = [max(value, 0.0) for value in guard_values(system, modes, y)]
    while solver.status == "running":
        start = solver.t, solver.y.copy()
        message = solver.step()
        if solver.status == "failed":
            raise RuntimeError(f"{method} at t = {solver.t}: {message}")
        dense, time = solver.dense_output(), start[0]
        for later in np.linspace(start[0], solver.t, SAMPLES + 1)[1:]:
            state = solver.y if later == solver.t else dense(later)
            after = guard_values(system, modes, state)
            hits = [k for k in range(len(live)) if before[k] > 0.0 >= after[k]]
            if hits:
                roots = {k: _root(system, modes, k, dense, time, later) for k in hits}
                first = min(roots, key=roots.get)
                return *_pin(system, modes, first, start, roots[first], rate), *live[first]
            before, time = after, later
    return solver.t, solver.y, None, None


def _root(system, modes, k, dense, low, high):
    def value(time):
        return guard_values(system, modes, dense(time))[k]

    if value(low) <= 0.0 or value(high) > 0.0:  # the interpolant misses the step's end by rounding
        return high
    return brentq(value, low, high, xtol=1e-18, rtol=1e-15)


def _pin(system, modes, k, start, guess, rate):
    """State on guard k, reached by integration from the step's start, not by its interpolant."""
    (t, y), target = start, guess
    for _ in range(6):
        if target != t:
            solver = DOP853(rate, t, y, target, rtol=2.3e-14, atol=tolerances(system, 1e-14))
            while solver.status == "running":
                solver.step()
            t, y = solver.t, solver.y
        slope, half = rate(t, y), 1e-9
        ahead, behind = (guard_values(system, modes, y + s * half * slope)[k] for s in (1, -1))
        correction = guard_values(system, modes, y)[k] * 2 * half / (behind - ahead)
        if abs(correction) < 1e-11:
            return t + correction, y + correction * slope
        target = t + correction
    return t, y


def march(system, y, stops, rtol, step):
    """Integrate through events to each time of ``stops``: (states there, events, modes)."""
    t, modes = 0.0, dict.fromkeys(system.clearance, "free")
    states, events = [], []
    for stop in stops:
        while t < stop:
            t, y, joint, guard = step(system, modes, t, y, stop, rtol)
            if joint is None:
                break
            c = system.contact(joint, y)
            modes, kind = switch(system, modes, joint, guard, y)
            events.append(Event(float(t), joint, kind, c.v_n, c.v_t))
            for other, new in loosen(system, modes, y).items():
                modes = {**modes, other: new}
                c = system.contact(other, y)
                events.append(Event(float(t), other, "slip_onset", c.v_n, c.v_t))
            if len(events) > 100_000:
                raise RuntimeError(f"chatter at t = {t}")
        states.append(np.array(y))
    return states, events, modes


def run(parameters=None, clearance=None, turns=1, t_end=None, method="DOP853", rtol=1e-12, at=(), start=None):
    """Motion of the four-bar with play, from the ideal mechanism at crank angle 0.

    Parameters
    ----------
    parameters : Parameters
        Table 1 with i, e and f; default the paper's i = 15.
    clearance : dict
        Clearance joints and their e in m; default ``{"B": parameters.e}``.
    turns, t_end : float
        Length in nominal revolutions 2 pi / (a/b), or in s.
    method : str or callable
        ``"DOP853"``, ``"Radau"``, ``"LSODA"``, or an advance function of another integrator.
    rtol : float
        Relative tolerance; absolute ones are rtol/100 (1 rad, a/b).
    at : sequence of float
        Further times, s, at which states are kept.
    start : array, optional
        State to start from, with every joint free.

    Returns
    -------
    Result
    """
    p = parameters or Parameters()
    system = Bodies(p, clearance or {"B": p.e})
    end = t_end if t_end is not None else turns * 2 * math.pi / p.w0
    y = system.start() if start is None else np.array(start)

    def named(*arguments):
        return advance(*arguments, method=method)

    step = method if callable(method) else named
    states, events, modes = march(system, y, [*sorted(at), end], rtol, step)
    return report(system, end, states, events, modes)


def report(system, end, states, events, modes):
    """Result record of a finished march."""
    y, n = states[-1], system.n
    joints = {}
    for name in system.clearance:
        c = system.contact(name, y)
        joints[name] = c.r, c.rate
    angles = dict(zip(LINKS, (float(v) for v in y[:3]), strict=True))
    speeds = dict(zip(LINKS, (float(v) for v in y[n : n + 3]), strict=True))
    return Result(end, angles, speeds, joints, events, modes, y, system.evaluations, states[:-1])
