"""Starts and motions of the bodies of `tests.support.multibody`.

Motions are smooth between events: points of touch close where u rises through 0, open where it falls, and,
where a force may not pull, are released and loaded again where the law's force changes sign. Dry friction
changes where v_t comes to 0, to sticking if the force that keeps it there is within the cone, and back where
that leaves it. Of rigid touches u = 0 is an impact: Newton's and Coulomb's laws for all that touch there, of
which every combination of what they may do is tried; a rebound slower than `STILL` is rest. Events are roots
of a step's dense output, looked for at several points of it; that step is done again up to the event, since
dense output is less exact. Ideal joints are kept by projection after every step.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests.support.multibody import Now, System
from tests.support.multibody_loads import Driven

SAMPLES = 8  # points a step at which guards are looked at
MOST = 100_000  # events
STILL = 1e-7  # m/s: a rebound that rises this fast is none
TOGETHER = 1e-9  # m, of what is met at the instant of an impact
ROUND = 1e-7  # N, of a force that sticks


def assemble(
    system: System,
    rough: Mapping[str, float | Sequence[float]],
    held: Mapping[str, tuple[float, float]] | None = None,
    speeds: Mapping[str, float] | None = None,
) -> np.ndarray:
    """Find the state at t = 0 without play that is nearest to rough angles θ, or (x, y, θ) of mass centres.

    `held` gives bodies an angle and a speed; `speeds` are rough ones of others. Raises where none is found.
    """
    pins = [Driven(f"held {name}", name, lambda t, x=x: (*x, 0.0)) for name, x in (held or {}).items()]
    parts, n = [*system.joints, *system.drives, *pins], system.n
    y, placed = np.zeros(2 * n), np.arange(n) >= 3 * len(system.bodies)  # bent links begin straight
    for name, given in rough.items():
        i, values = system.at[name], np.atleast_1d(given)
        y[i + 3 - len(values) : i + 3] = values
        placed[i + 3 - len(values) : i + 3] = True
    for name, speed in (speeds or {}).items():
        y[n + system.at[name] + 2] = speed
    for step in range(50):
        g, G, g_t, _ = system.constraints(Now(system, 0.0, y), parts)
        free = ~placed if step == 0 and not placed.all() else np.arange(n) < 3 * len(system.bodies)
        y[:n][free] -= np.linalg.lstsq(G[:, free], g, rcond=1e-12)[0]
        if step and np.abs(g).max() < 1e-15:
            break
    g, G, g_t, _ = system.constraints(Now(system, 0.0, y), parts)
    if np.abs(g).max() > 1e-13:
        raise ValueError(f"the loops stay open by {np.abs(g).max():g}")
    rigid = slice(0, 3 * len(system.bodies))
    y[n:][rigid] -= np.linalg.lstsq(G[:, rigid], G @ y[n:] + g_t, rcond=1e-12)[0]
    return y


def projected(system: System, t: float, y: np.ndarray) -> np.ndarray:
    """The nearest state that ideal joints and drives allow."""
    n, y = system.n, y.copy()
    speeds = slice(n, 2 * n)
    if system.ideal:
        g, G, _, _ = system.constraints(Now(system, t, y), system.ideal)
        y[:n] -= np.linalg.lstsq(G, g, rcond=1e-12)[0]
        _, G, g_t, _ = system.constraints(Now(system, t, y), system.ideal)
        y[speeds] -= np.linalg.lstsq(G, G @ y[speeds] + g_t, rcond=1e-12)[0]
    return y


@dataclass(frozen=True)
class Event:
    """What happened to which touch, and the state there; the mode that it ended.

    Kinds are those of `GUARDS` and of `_after`: contact, separation, release, reload, impact, rest,
    slip_reversal, stick_onset, slip_onset.
    """

    time: float
    touch: int
    kind: str
    y: np.ndarray
    mode: str = ""
    share: float = 1.0  # of the restitutions, at an impact


GUARDS = {  # by kind, what is positive until it happens: of the touch, its F_n, F_t and mu(0) F_n
    "contact": lambda touch, F_n, F_t, cone: -touch.u,
    "impact": lambda touch, F_n, F_t, cone: -touch.u,
    "separation": lambda touch, F_n, F_t, cone: touch.u,
    "release": lambda touch, F_n, F_t, cone: touch.law(),
    "reload": lambda touch, F_n, F_t, cone: -touch.law(),
    "lift": lambda touch, F_n, F_t, cone: F_n,
    "still+": lambda touch, F_n, F_t, cone: touch.v_t,
    "still-": lambda touch, F_n, F_t, cone: -touch.v_t,
    "slides+": lambda touch, F_n, F_t, cone: cone - F_t,
    "slides-": lambda touch, F_n, F_t, cone: cone + F_t,
}
WATCHED = {  # by mode
    "free": ("contact",),
    "closed": ("separation", "release"),
    "released": ("separation", "reload"),
    "slip+": ("separation", "release", "still+"),
    "slip-": ("separation", "release", "still-"),
    "stick": ("separation", "release", "slides+", "slides-"),
    "rest": ("lift",),
    "rest+": ("lift", "still+"),
    "rest-": ("lift", "still-"),
    "rest=": ("lift", "slides+", "slides-"),
}


Ways = Sequence[tuple[int, str]]


def watched(system: System, now: State) -> Ways:
    """What may happen next: (touch, kind)."""
    plays = [joint.play for joint in system.loose for _ in joint.touches(Now(system, now.t, now.y))]
    found = []
    for i, (mode, play) in enumerate(zip(now.modes, plays, strict=True)):
        kinds = ("impact",) if mode == "free" and play.restitution is not None else WATCHED[mode]
        found += [(i, kind) for kind in kinds if kind not in ("release", "reload") or not play.tension]
    return found


def guards(
    system: System, now: State, ways: Sequence[tuple[int, str]], t: float, y: np.ndarray
) -> list[float]:
    """What is positive until it happens, of each way that a motion may go from a state."""
    if any(kind in ("lift", "slides+", "slides-") for _, kind in ways):
        seen = [(x, F_n, F_t) for _, x, F_n, F_t in system.solve(t, y, now.modes, now.memory).touches]
    else:
        seen = [(x, 0.0, 0.0) for _, x in system.touches(Now(system, t, y, now.memory))]
    cones = [x.play.dry(0.0) * F_n if x.play.dry else 0.0 for x, F_n, _ in seen]
    return [GUARDS[kind](*seen[i], cones[i]) for i, kind in ways]


def mode_of(touch, inside: bool, pushes: bool = False) -> str:
    """Mode of a touch that begins inside the surface, or outside; `pushes`: whether its law is known to."""
    if not inside:
        return "free"
    if not (pushes or touch.play.tension or touch.law() > 0):
        return "released"
    if touch.play.dry:
        return "slip+" if touch.v_t > 0 else "slip-"
    return "closed"


def closed(modes: Sequence[str]) -> list[bool]:
    """Which touches have their force."""
    return [mode not in ("free", "released") for mode in modes]


def passed(system: System, now: State, ways: Ways) -> tuple[int, str] | None:
    """The first way that is gone already: another touch's event threw one that sticks out of its cone."""
    if "stick" not in now.modes:
        return None
    values = guards(system, now, ways, now.t, now.y)
    slides = (way for way, x in zip(ways, values, strict=True) if way[1].startswith("slides") and x < -ROUND)
    return next(slides, None)


@dataclass
class State:
    """A motion as it goes: time, state, and of each touch its mode and the speed with which it began."""

    t: float
    y: np.ndarray
    modes: list[str]
    memory: list[float]


def begun(system: System, y: np.ndarray) -> State:
    """A start: touches that begin inside have begun with their speed there."""
    bristles = any(joint.play.bristles for joint in system.loose)
    touches = [touch for _, touch in system.touches(Now(system, 0.0, y))]
    y = np.append(y, np.zeros(len(touches) * bristles))
    slowest = [touch.play.slowest or 0.0 for touch in touches]
    memory = [max(abs(x.v_n), v) if x.u > 0 else v for x, v in zip(touches, slowest, strict=True)]
    seen = [touch for _, touch in system.touches(Now(system, 0.0, y, memory))]
    return State(0.0, y, [mode_of(touch, touch.u > 0) for touch in seen], memory)


def follow(system: System, y: np.ndarray, at: Sequence[float], rtol: float = 1e-11, method=DOP853, **options):
    """Follow a motion from t = 0: states at ascending times, shape (times, 2 n); modes there; events."""
    found = followed(system, y, at, rtol, method, **options)
    return np.array([state.y for state in found[0]]), [state.modes for state in found[0]], found[1]


def followed(system: System, y: np.ndarray, at: Sequence[float], rtol=1e-11, method=DOP853, **options):
    """As `follow`: whole states, and events.

    The method is a solver of scipy, with its options; or a function that goes on from a `State` to an end or
    to the next event, and gives what `_advance` does.
    """
    now, kept, events = begun(system, y), [], []
    for end in at:
        while now.t < end:
            if isinstance(method, type):
                now.t, now.y, event = _advance(system, now, end, rtol, method, options)
            else:
                now.t, now.y, event = method(system, now, end, rtol)
            if event:
                events += _changed(system, now, *event)
                if len(events) > MOST:
                    raise RuntimeError(f"more than {MOST} events until {now.t} s")
        kept.append(State(now.t, now.y.copy(), list(now.modes), list(now.memory)))
    return kept, events


def _changed(system: System, now: State, i: int, kind: str) -> list[Event]:
    """Change modes, memories and, at impacts, speeds; the events that these are."""
    mode = now.modes[i]
    if kind == "impact":
        return _impact(system, now, i)
    if kind in ("separation", "lift"):
        now.modes[i] = "free"
        if len(now.y) > 2 * system.n:
            now.y[2 * system.n + i] = 0.0
        kind = "separation"
    elif kind == "release":
        now.modes[i] = "released"
    elif kind in ("contact", "reload"):
        touch = system.touches(Now(system, now.t, now.y, now.memory))[i][1]
        if kind == "contact":
            now.memory[i] = max(touch.v_n, touch.play.slowest or 0.0)
            touch = system.touches(Now(system, now.t, now.y, now.memory))[i][1]
        # a law that pulls at once is not felt where it may not; one that reloads is 0 but for rounding
        now.modes[i] = mode_of(touch, True, pushes=kind == "reload")
    elif kind.startswith("slides"):
        now.modes[i] = ("rest" if mode.startswith("rest") else "slip") + kind[-1]
        kind = "slip_onset"
    else:
        kind = _stopped(system, now, i)
    return [Event(now.t, i, kind, now.y.copy(), mode)]


def _stopped(system: System, now: State, i: int) -> str:
    """Let a touch whose sliding has come to 0 stick, or slide on the other way."""
    mode, resting = now.modes[i], now.modes[i].startswith("rest")
    now.modes[i] = "rest=" if resting else "stick"
    _, touch, F_n, F_t = system.solve(now.t, now.y, now.modes, now.memory).touches[i]
    if F_n > 0 and abs(F_t) <= touch.play.dry(0.0) * F_n:
        return "stick_onset"
    now.modes[i] = mode[:-1] + ("-" if mode[-1] == "+" else "+")
    return "slip_reversal"


def _impact(system: System, now: State, i: int) -> list[Event]:
    """Newton's and Coulomb's laws for all rigid touches that are closed here."""
    touches = [touch for _, touch in system.touches(Now(system, now.t, now.y, now.memory))]
    resting = [k for k, mode in enumerate(now.modes) if mode.startswith("rest")]
    met = [
        k
        for k, touch in enumerate(touches)
        if k == i
        or (
            now.modes[k] == "free"
            and touch.play.restitution is not None
            and touch.u > -TOGETHER
            and touch.v_n > 0
        )
    ]
    part = sorted({*resting, *met})
    n = system.n
    v = now.y[n : 2 * n]
    M, _ = system.inertia(Now(system, now.t, now.y))
    _, G, _, _ = system.constraints(Now(system, now.t, now.y), system.ideal)
    share, elastic, inelastic = 1.0, 1.0, 0.0
    new, made = _struck(M, G, v, touches, part, resting, elastic)
    if made > 1e-12 * (v @ M @ v):
        for _ in range(60):  # the largest share of all restitutions that makes no energy
            middle = (elastic + inelastic) / 2
            _, made = _struck(M, G, v, touches, part, resting, middle)
            elastic, inelastic = (middle, inelastic) if made > 0 else (elastic, middle)
        share = inelastic
        new, _ = _struck(M, G, v, touches, part, resting, share)
    now.y[n : 2 * n] = new
    after = [touch for _, touch in system.touches(Now(system, now.t, now.y, now.memory))]
    events = [Event(now.t, k, "impact", now.y.copy(), now.modes[k], share) for k in met]
    for k in part:
        if abs(after[k].v_n) > STILL:
            if k in resting:
                events.append(Event(now.t, k, "separation", now.y.copy(), now.modes[k]))
            now.modes[k] = "free"
            continue
        if k in met:
            events.append(Event(now.t, k, "rest", now.y.copy(), "free"))
        now.modes[k] = _rested(system, now, k, after[k])
    return events


def _rested(system: System, now: State, k: int, touch) -> str:
    """The mode of a touch that rests from now on."""
    if not touch.play.dry:
        return "rest"
    if abs(touch.v_t) > STILL:
        return "rest+" if touch.v_t > 0 else "rest-"
    now.modes[k] = "rest="
    _, _, F_n, F_t = system.solve(now.t, now.y, now.modes, now.memory).touches[k]
    if F_n > 0 and abs(F_t) <= touch.play.dry(0.0) * F_n:
        return "rest="
    return "rest-" if F_t > 0 else "rest+"  # it slides the way that the force would have to hold it from


def _struck(M, G, v, touches, part, resting, share):
    """Speeds after an impact, restitutions lowered to a share, and the work of contacts, not of drives."""
    n, m, found = len(v), len(G), []
    ways = [("open", "shut") if touches[k].play.dry is None else ("open", "+", "-", "=") for k in part]
    for choice in itertools.product(*ways):
        rows, sides, right = [], [], []
        for k, what in zip(part, choice, strict=True):
            touch = touches[k]
            if what == "open":
                continue
            r = 0.0 if k in resting else share * touch.play.restitution
            slip = {"+": 1.0, "-": -1.0}.get(what, 0.0) * (touch.play.dry(0.0) if touch.play.dry else 0.0)
            rows.append(touch.W_n)
            sides.append(touch.W_n + slip * touch.W_t)
            right.append(-(1 + r) * touch.v_n)
            if what == "=":
                rows.append(touch.W_t)
                sides.append(touch.W_t)
                right.append(-touch.v_t)
        every, pushes = np.vstack([G, *rows]), np.vstack([G, *sides])
        matrix = np.zeros((n + len(every),) * 2)
        matrix[:n, :n], matrix[:n, n:], matrix[n:, :n] = M, pushes.T, every
        try:
            solved = np.linalg.solve(matrix, np.concatenate([np.zeros(n + m), right]))
        except np.linalg.LinAlgError:
            continue
        new, impulses = v + solved[:n], [*solved[n + m :]]
        work = -solved[n + m :] @ pushes[m:] @ (new + v) / 2
        found.append((_broken(touches, part, resting, choice, new, impulses, share), new, work))
    worst = min(each[0] for each in found)
    if worst > 1e-9:
        raise RuntimeError(f"no impact fits, by {worst:g}")
    return next(each[1:] for each in found if each[0] == worst)


def _broken(touches, part, resting, choice, new, impulses, share) -> float:
    """By how much a choice breaks what it supposes: m/s and N s alike."""
    worst = 0.0
    for k, what in zip(part, choice, strict=True):
        touch = touches[k]
        r = 0.0 if k in resting else share * touch.play.restitution
        if what == "open":
            worst = max(worst, touch.W_n @ (new) + r * touch.v_n)  # it must open fast enough
            continue
        push = impulses.pop(0)
        worst = max(worst, -push)
        if what in "+-":
            worst = max(worst, -float(f"{what}1") * (touch.W_t @ new))
        if what == "=":
            worst = max(worst, abs(impulses.pop(0)) - touch.play.dry(0.0) * push)
    return worst


def _advance(system, now, end, rtol, method, options):
    """Go on to the next event or the end: time, state and (touch, kind) of the event, or None."""
    modes, memory, n = list(now.modes), list(now.memory), system.n
    bristles, ways = len(now.y) > 2 * n, watched(system, now)
    options = {"rtol": rtol, "atol": 1e-3 * rtol} | options
    first = options.pop("first_step", math.inf)

    def rate(t, y):
        if not np.isfinite(y).all():  # of a trial step that fails
            return np.full(len(y), np.nan)
        solved = system.solve(t, y, modes, memory)
        bent = [_bending(x, mode) for (_, x, *_), mode in zip(solved.touches, modes, strict=True)]
        return np.concatenate([y[n : 2 * n], solved.acceleration, bent if bristles else []])

    def nearing(k):
        """The normal speed that belongs to guard k, of an impact; None of others."""
        i, kind = ways[k]
        if kind != "impact":
            return None
        return lambda t, y: system.touches(Now(system, t, y, memory))[i][1].v_n

    def steps(t, y, end):
        begin = {"first_step": first} if first < end - t else {}
        return method(rate, t, y, end, **begin, **options)

    def values(t, y):
        return guards(system, now, ways, t, y)

    solver = steps(now.t, now.y, end)
    while solver.status == "running":
        start = solver.y.copy()
        if message := solver.step():
            raise RuntimeError(message)
        if ways:
            path, before = solver.dense_output(), solver.t_old
            for ahead in np.linspace(solver.t_old, solver.t, SAMPLES + 1)[1:]:
                fallen = [k for k, value in enumerate(values(ahead, path(ahead))) if value < 0]
                fallen = [k for k in fallen if not nearing(k) or nearing(k)(ahead, path(ahead)) > 0]
                if fallen:
                    t, k = min((_root(values, path, k, before, ahead, nearing(k)), k) for k in fallen)
                    return t, projected(system, t, _ended(steps(solver.t_old, start, t))), ways[k]
                before = ahead
        if solver.status == "running":
            solver.y = projected(system, solver.t, solver.y)
            solver.f = rate(solver.t, solver.y)
    return end, projected(system, end, solver.y), None


def _ended(solver):
    """State at the end of a solver's interval."""
    while solver.status == "running":
        if message := solver.step():
            raise RuntimeError(message)
    return solver.y


def _bending(touch, mode) -> float:
    """z' of a touch."""
    return touch.play.bristles(touch.v_t, touch.z)[1] if mode == "closed" and touch.play.bristles else 0.0


def _root(guards, path, k, before, after, nearing=None):
    """Where guard k falls through 0; at once where it has not been positive since its mode began.

    `nearing`: of an impact, its normal speed. What rebounds is back after its top, however low that is.
    """

    def value(t):
        return guards(t, path(t))[k]

    if nearing and nearing(before, path(before)) < 0:
        top = brentq(lambda t: nearing(t, path(t)), before, after, xtol=1e-18, rtol=1e-15)
        low = min(2 * top - before, after)  # its way back takes as long, where rounding hides its height
        return brentq(value, top, after, xtol=1e-18, rtol=1e-15) if value(top) > 0 else low
    if value(before) > 0:
        return brentq(value, before, after, xtol=1e-18, rtol=1e-15)
    # just begun, at 0: it has risen in between where it is positive at one of ever later points
    rising = [t for t in before + (after - before) * 0.5 ** np.arange(40.0, 0.0, -1.0) if value(t) > 0]
    return brentq(value, rising[-1], after, xtol=1e-18, rtol=1e-15) if rising else before
