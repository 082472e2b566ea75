"""heyoka as a peer on the paper's mechanism, with expressions tuned by hand to need few products."""

from __future__ import annotations

import heyoka as hy

from jointplay.solver.codegen import cache
from jointplay.solver.method.modes import CONE, FORCE, FREE, GAP, SLIDE, STICK
from jointplay_lab.precision.contenders import Heyoka


class TunedHeyoka(Heyoka):
    """Taylor series of the hand-written equations of a rigid four-bar with a motor and clearance at B."""

    name = "heyoka, tuned"

    def expressions(self):
        """States, their rates and the watched guards, in the present contact mode."""
        model, (mode,) = self.equations.model, self.equations.key
        values = cache.structure_module(model.structure).PARAMETERS, map(float, model.numbers)
        states = [hy.expression(f"x{i}") for i in range(6)]
        rates, guards = equations(states, mode, dict(zip(*values, strict=True)))
        watch = self.equations.watch.reshape(-1, 2).tolist()
        watched = [guards[guard] * (hy.par[0] if guard == SLIDE else float(side)) for guard, side in watch]
        return states, rates, watched


def equations(y, mode, p):
    """Rates of angles and speeds of crank, coupler, rocker, and guards by number; the slip sign is par[0]."""
    w3, w1, w2 = w = y[3:]
    c, s, e = hy.cos(y[0] - y[1]), hy.sin(y[0] - y[1]), p["e_B"]
    links = ("crank", "coupler", "rocker")
    arms = [(p[f"D_B_{link}"], hy.cos(q), hy.sin(q)) for link, q in zip(links, y, strict=False)]
    weights = [p["g"] * p[f"mu_{link}"] * cos for link, (_, cos, _) in zip(links, arms, strict=True)]
    rx, ry = p["rx0_B"] + hy.sum([d * cos for d, cos, _ in arms]), hy.sum([d * sin for d, _, sin in arms])
    square, coupling = rx * rx + ry * ry, p["H_crank_coupler"]
    force = [
        p["a"] - p["b"] * w3 - coupling * (s * (w1 * w1)) - weights[0],
        coupling * (s * (w3 * w3)) - weights[1],
        -weights[2],
    ]
    guards = {GAP: square - e * e}
    if mode == FREE:
        return [*w, *accelerate(c, force, p)], guards
    rho = hy.sqrt(square)
    n = nx, ny = rx / rho, ry / rho
    vx = hy.sum([-d * (sin * speed) for (d, _, sin), speed in zip(arms, w, strict=True)])
    vy = hy.sum([d * (cos * speed) for (d, cos, _), speed in zip(arms, w, strict=True)])
    v_n, along = vx * nx + vy * ny, vy * nx - vx * ny
    guards[SLIDE] = along + p["R_B"] * (w1 - w2) - rho * w2
    guards[FORCE] = normal = p["K_B"] * (rho - e) + p["C_B"] * v_n
    if mode == STICK:
        pressed = push(force, arms, n, rho, normal, 0.0, p)
        friction = sticking(c, w, arms, n, rho, along, v_n, pressed, p)
        guards[CONE] = (p["f_B"] * normal - friction) * (p["f_B"] * normal + friction)
    else:
        friction = hy.par[0] * p["f_B"] * normal
    return [*w, *accelerate(c, push(force, arms, n, rho, normal, friction, p), p)], guards


def push(force, arms, n, rho, normal, friction, p):
    """Generalised forces with those of a contact."""
    fx, fy = normal * n[0] - friction * n[1], normal * n[1] + friction * n[0]
    q3, q1, q2 = (q - d * (fy * cos - fx * sin) for q, (d, cos, sin) in zip(force, arms, strict=True))
    return [q3, q1 - p["R_B"] * friction, q2 + (p["R_B"] + rho) * friction]


def sticking(c, w, arms, n, rho, along, v_n, force, p):
    """Friction force that keeps v_t at 0, from accelerations without it and under a unit of it."""
    unit = push([0.0, 0.0, 0.0], arms, n, rho, 0.0, 1.0, p)
    bias = -(along / rho) * v_n - w[2] * v_n
    for (d, cos, sin), speed in zip(arms, w, strict=True):
        bias += d * speed * speed * (n[1] * cos - n[0] * sin)
    free, yields = accelerate(c, force, p), accelerate(c, unit, p)
    rest = bias - hy.sum([t * a for t, a in zip(unit, free, strict=True)])
    return rest / hy.sum([t * a for t, a in zip(unit, yields, strict=True)])


def accelerate(c, force, p):
    """Angular accelerations under generalised forces; c = cos(crank - coupler)."""
    q3, q1, q2 = force
    crank, coupler, m = p["H_crank_crank"], p["H_coupler_coupler"], p["H_crank_coupler"] * c
    share = 1.0 / (crank * coupler - m * m)
    return [(coupler * q3 - m * q1) * share, (crank * q1 - m * q3) * share, q2 / p["H_rocker_rocker"]]
