"""heyoka as a peer: one compiled Taylor integrator a mode, terminal events, case parameters in par[]."""

from __future__ import annotations

import heyoka as hy
import numpy as np

from . import systems as S


class Heyoka:
    """Integrators of one tolerance for every case; compiled when first met, so warm up before timing."""

    name = "heyoka"

    def __init__(self, tol):
        self.tol, self.integrators = tol, {}

    def integrator(self, mode):
        """Integrator of free flight, slip (its sign in par[4]) or sticking."""
        group = abs(mode)
        if group not in self.integrators:
            system, guards = equations(group)
            down = hy.event_direction.negative
            events = [hy.t_event(guard, direction=down) for guard in guards]
            options = {"tol": self.tol, "t_events": events, "fast_math": True}
            ta = hy.taylor_adaptive(system, np.zeros(6), **options)
            self.integrators[group] = ta, ta.state, ta.pars, len(ta.pars)  # views: fetching them costs 1 us
        return self.integrators[group]

    def run(self, case):
        """End state, steps and event kinds of a case."""
        t, y, mode, steps, kinds = 0.0, case.start, S.FREE, 0, []
        par = case.par
        while True:
            ta, state, pars, used = self.integrator(mode)
            ta.time, state[:], pars[:] = t, y, (*par, mode)[:used]
            ta.reset_cooldowns()
            outcome, _, _, taken, _, _ = ta.propagate_until(case.t_end)
            t, y, steps = ta.time, state, steps + taken
            if outcome == hy.taylor_outcome.time_limit:
                return y.copy(), steps, kinds
            guard = min(-int(outcome.value) - 1, 1)
            new = S.switch(y, mode, guard, par)
            kinds.append(S.kind(mode, guard, new))
            mode = new


def equations(mode):
    """System and guards (each falls through 0) of a mode as heyoka expressions, with few products."""
    y = [hy.expression(name) for name in ("q3", "q1", "q2", "w3", "w1", "w2")]
    w3, w1, w2 = w = y[3:]
    c, s, e = hy.cos(y[0] - y[1]), hy.sin(y[0] - y[1]), hy.par[2]
    arms = [(d, hy.cos(q), hy.sin(q)) for d, q in zip((S.L3, S.L1, -S.L2), y, strict=False)]
    rx, ry = hy.sum([d * cos for d, cos, _ in arms]) - S.L4, hy.sum([d * sin for d, _, sin in arms])
    square = rx * rx + ry * ry
    force = [
        hy.par[0] - hy.par[1] * w3 - S.H13 * (s * (w1 * w1)) - S.G3 * arms[0][1],
        S.H13 * (s * (w3 * w3)) - S.G1 * arms[1][1],
        -S.G2 * arms[2][1],
    ]
    if mode == S.FREE:
        return list(zip(y, [*w, *accelerate(c, force)], strict=True)), [e * e - square]
    rho = hy.sqrt(square)
    n = nx, ny = rx / rho, ry / rho
    vx = hy.sum([-d * (sin * speed) for (d, _, sin), speed in zip(arms, w, strict=True)])
    vy = hy.sum([d * (cos * speed) for (d, cos, _), speed in zip(arms, w, strict=True)])
    v_n, along = vx * nx + vy * ny, vy * nx - vx * ny
    v_t = along + S.R * (w1 - w2) - rho * w2
    normal = S.K * (rho - e) + S.C_N * v_n
    if mode == S.STICK:
        friction = sticking(c, y, arms, n, rho, along, v_n, push(force, arms, n, rho, normal, 0.0))
        limit = hy.par[3] * normal
        guards = [rho - e, limit - friction, limit + friction]
    else:
        friction = hy.par[4] * hy.par[3] * normal
        guards = [rho - e, hy.par[4] * v_t]
    force = push(force, arms, n, rho, normal, friction)
    return list(zip(y, [*w, *accelerate(c, force)], strict=True)), guards


def push(force, arms, n, rho, normal, friction):
    """Generalised forces with those of a contact."""
    fx, fy = normal * n[0] - friction * n[1], normal * n[1] + friction * n[0]
    q3, q1, q2 = (q - d * (fy * cos - fx * sin) for q, (d, cos, sin) in zip(force, arms, strict=True))
    return [q3, q1 - S.R * friction, q2 + S.R * friction + rho * friction]


def sticking(c, y, arms, n, rho, along, v_n, force):
    """Friction force that keeps v_t at 0, from accelerations without it and under a unit of it."""
    w = y[3:]
    unit = push([0.0, 0.0, 0.0], arms, n, rho, 0.0, 1.0)
    bias = -(along / rho) * v_n - w[2] * v_n
    for (d, cos, sin), speed in zip(arms, w, strict=True):
        bias += d * speed * speed * (n[1] * cos - n[0] * sin)
    free, yields = accelerate(c, force), accelerate(c, unit)
    rest = bias - hy.sum([t * a for t, a in zip(unit, free, strict=True)])
    return rest / hy.sum([t * a for t, a in zip(unit, yields, strict=True)])


def accelerate(c, force):
    """Angular accelerations under generalised forces; c = cos(crank - coupler)."""
    m = S.H13 * c
    share = 1.0 / (S.H33 * S.H11 - m * m)
    q3, q1, q2 = force
    return [(S.H11 * q3 - m * q1) * share, (S.H33 * q1 - m * q3) * share, q2 / S.J2]
