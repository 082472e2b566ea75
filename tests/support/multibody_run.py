"""Starts and motions of the bodies of `tests.support.multibody`.

Motions are smooth between events: points of touch close where u rises through 0, open where it falls, and,
where a force may not pull, are released and loaded again where the law's force changes sign. Events are
roots of a step's dense output, looked for at several points of it; ideal joints are kept by projection after
every step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests.support.multibody import Now, System
from tests.support.multibody_loads import Driven

SAMPLES = 8  # points a step at which guards are looked at
MOST = 100_000  # events


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
    parts, n = [*system.joints, *system.drives, *pins], len(system.mass)
    y, placed = np.zeros(2 * n), np.zeros(n, dtype=bool)
    for name, given in rough.items():
        i, values = system.at[name], np.atleast_1d(given)
        y[i + 3 - len(values) : i + 3] = values
        placed[i + 3 - len(values) : i + 3] = True
    for name, speed in (speeds or {}).items():
        y[n + system.at[name] + 2] = speed
    for step in range(50):
        g, G, g_t, _ = system.constraints(Now(system, 0.0, y), parts)
        free = ~placed if step == 0 and not placed.all() else np.ones(n, dtype=bool)
        y[:n][free] -= np.linalg.lstsq(G[:, free], g, rcond=1e-12)[0]
        if step and np.abs(g).max() < 1e-15:
            break
    g, G, g_t, _ = system.constraints(Now(system, 0.0, y), parts)
    if np.abs(g).max() > 1e-13:
        raise ValueError(f"the loops stay open by {np.abs(g).max():g}")
    y[n:] -= np.linalg.lstsq(G, G @ y[n:] + g_t, rcond=1e-12)[0]
    return y


def projected(system: System, t: float, y: np.ndarray) -> np.ndarray:
    """The nearest state that ideal joints and drives allow."""
    n, y = len(y) // 2, y.copy()
    if system.ideal:
        g, G, _, _ = system.constraints(Now(system, t, y), system.ideal)
        y[:n] -= np.linalg.lstsq(G, g, rcond=1e-12)[0]
        _, G, g_t, _ = system.constraints(Now(system, t, y), system.ideal)
        y[n:] -= np.linalg.lstsq(G, G @ y[n:] + g_t, rcond=1e-12)[0]
    return y


@dataclass(frozen=True)
class Event:
    """What happened to which touch: 'contact', 'separation', 'release' or 'reload', and the state there."""

    time: float
    touch: int
    kind: str
    y: np.ndarray


KINDS = {  # by mode: guards, positive in the mode, with the kind of event and the mode that follows
    "free": ((lambda touch: -touch.u, "contact", "closed"),),
    "closed": (
        (lambda touch: touch.u, "separation", "free"),
        (lambda touch: touch.law(), "release", "released"),
    ),
    "released": (
        (lambda touch: touch.u, "separation", "free"),
        (lambda touch: -touch.law(), "reload", "closed"),
    ),
}


def mode_of(touch, inside: bool) -> str:
    """Mode of a touch that begins inside the surface, or outside."""
    if not inside:
        return "free"
    return "closed" if touch.play.tension or touch.law() > 0 else "released"


def closed(modes: Sequence[str]) -> list[bool]:
    """Which touches have their force."""
    return [mode == "closed" for mode in modes]


def follow(system: System, y: np.ndarray, at: Sequence[float], rtol: float = 1e-11, method=DOP853, **options):
    """Follow a motion from t = 0: states at ascending times, shape (times, 2 n); modes there; events."""
    t, states, kept, events = 0.0, [], [], []
    modes = [mode_of(touch, touch.u > 0) for _, touch in system.touches(Now(system, 0.0, y))]
    for end in at:
        while t < end:
            t, y, event = _advance(system, modes, t, y, end, rtol, method, options)
            if event:
                i, kind, modes[i] = event
                events.append(Event(t, i, kind, y.copy()))
                if kind == "contact":  # a law that pulls at once is not felt where it may not
                    modes[i] = mode_of(system.touches(Now(system, t, y))[i][1], True)
                if len(events) > MOST:
                    raise RuntimeError(f"more than {MOST} events until {t} s")
        states.append(y.copy())
        kept.append(list(modes))
    return np.array(states), kept, events


def _advance(system, modes, t, y, end, rtol, method, options):
    """Go on to the next event or the end: time, state and (touch, kind, next mode) of the event, or None."""
    shut, n = closed(modes), len(y) // 2

    def rate(t, y):
        return np.concatenate([y[n:], system.solve(t, y, shut).acceleration])

    def guards(t, y):
        found = []
        for i, (_, touch) in enumerate(system.touches(Now(system, t, y))):
            ways = KINDS[modes[i]][: 1 if touch.play.tension else 2]
            found += [(guard(touch), i, kind, after) for guard, kind, after in ways]
        return found

    solver = method(rate, t, y, end, rtol=rtol, atol=1e-3 * rtol, **options)
    seen = guards(t, y)
    while solver.status == "running":
        if message := solver.step():
            raise RuntimeError(message)
        if seen:
            path, before = solver.dense_output(), solver.t_old
            for now in np.linspace(solver.t_old, solver.t, SAMPLES + 1)[1:]:
                new = guards(now, path(now))
                fallen = [k for k, (value, *_) in enumerate(new) if value < 0]
                if fallen:
                    t, k = min((_root(guards, path, k, before, now), k) for k in fallen)
                    return t, projected(system, t, path(t)), new[k][1:]
                before = now
        if solver.status == "running":
            solver.y = projected(system, solver.t, solver.y)
            solver.f = rate(solver.t, solver.y)
    return end, projected(system, end, solver.y), None


def _root(guards, path, k, before, after):
    """Where guard k falls through 0; at once where it has not been positive since its mode began."""

    def value(t):
        return guards(t, path(t))[k][0]

    return brentq(value, before, after, xtol=1e-18, rtol=1e-15) if value(before) > 0 else before
