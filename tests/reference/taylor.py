"""Truth by Taylor series in 80-bit numbers (heyoka), from virtual work in minimal coordinates.

The equations are built by symbolic differentiation of the positions alone: a derivation apart from the free
bodies of ``bodies.py`` (velocity, mass matrix, centripetal and generalised force all follow from the
Jacobian of the positions). Event times are roots of the guards' own Taylor polynomials.
"""

from __future__ import annotations

import heyoka as hy
import numpy as np

from .bodies import GROUND
from .twin import guards

WIDE = np.longdouble


def number(value):
    """A double as an exact 80-bit constant."""
    return hy.expression(WIDE(value))


class Series:
    """Taylor integrators of a `Bodies` system, one for each set of modes, compiled when first met."""

    def __init__(self, system, real=WIDE, tol=None):
        self.system, self.p, self.n, self.real = system, system.p, system.n, real
        self.options = {"fp_type": real, "compact_mode": True} | ({} if tol is None else {"tol": real(tol)})
        self.q = [hy.expression(f"q{k}") for k in range(self.n)]
        self.v = [hy.expression(f"v{k}") for k in range(self.n)]
        self.cache = {}
        self._place()

    def _place(self):
        q = self.q
        self.e = [(hy.cos(q[k]), hy.sin(q[k])) for k in range(3)]
        self.origin = [None] * 3
        for link, x, old in self.system.steps:
            if old is None:
                self.origin[link] = (q[x], q[x + 1])
            else:
                px, py = self.point(old)
                self.origin[link] = (px - number(x) * self.e[link][0], py - number(x) * self.e[link][1])

    def point(self, place):
        """Position of a place on a link, or on the ground."""
        link, x = place
        if link == GROUND:
            return number(x[0]), number(x[1])
        px, py = self.origin[link]
        return px + number(x) * self.e[link][0], py + number(x) * self.e[link][1]

    def along(self, expression, of, direction):
        """Derivative of an expression along a direction in the variables ``of``."""
        return hy.sum([hy.diff(expression, x) * d for x, d in zip(of, direction, strict=True)])

    def inertia(self):
        """Mass matrix and generalised gravity and centripetal load."""
        n, p = self.n, self.p
        mass, load = [[number(0.0)] * n for _ in range(n)], [number(0.0)] * n
        for link in range(3):
            x, y = self.point((link, self.system.centre[link]))
            terms = [(x, self.system.mass[link], 0.0), (y, self.system.mass[link], -p.gravity)]
            terms.append((self.q[link], self.system.inertia[link], 0.0))
            for place, weight, pull in terms:
                row = [hy.diff(place, q) for q in self.q]
                bias = self.along(self.along(place, self.q, self.v), self.q, self.v)
                for k in range(n):
                    load[k] += number(weight) * row[k] * (number(pull) - bias)
                    for j in range(n):
                        mass[k][j] += number(weight) * row[k] * row[j]
        return mass, load

    def contact(self, joint):
        """rho^2, rho, F_n, v_t and the rows of generalised force of F_n and F_t."""
        p, (journal, bearing) = self.p, self.system.joints[joint]
        (ax, ay), (bx, by) = self.point(journal), self.point(bearing)
        rx, ry = ax - bx, ay - by
        square = rx * rx + ry * ry
        rho = hy.sqrt(square)
        c, s = rx / rho, ry / rho
        vx, vy = (self.along(r, self.q, self.v) for r in (rx, ry))
        normal = [-(c * hy.diff(rx, q) + s * hy.diff(ry, q)) for q in self.q]
        tangent = [s * hy.diff(rx, q) - c * hy.diff(ry, q) for q in self.q]
        tangent[journal[0]] -= number(p.R)
        v_t = vy * c - vx * s + number(p.R) * self.v[journal[0]]
        if bearing[0] != GROUND:
            tangent[bearing[0]] += number(p.R) + rho
            v_t -= (number(p.R) + rho) * self.v[bearing[0]]
        force = number(p.K) * (rho - number(self.system.clearance[joint])) + number(p.C_n) * (vx * c + vy * s)
        return square, force, v_t, normal, tangent

    def equations(self, modes):
        """Accelerations (n,) and F_t of each sticking joint; par[k] is the sign of slip of joint k."""
        n, p = self.n, self.p
        mass, load = self.inertia()
        if p.drive == "motor":
            load[0] += number(p.a) - number(p.b) * self.v[0]
        elif p.drive == "speed":
            mass[0], load[0] = [number(float(k == 0)) for k in range(n)], number(0.0)
        stuck, rows = [], []
        for k, (joint, mode) in enumerate(modes.items()):
            if mode in ("free", "released"):
                continue
            _, force, v_t, normal, tangent = self.contact(joint)
            load = [q + force * d for q, d in zip(load, normal, strict=True)]
            if mode == "stick":
                stuck.append(tangent)
                rows.append([hy.diff(v_t, v) for v in self.v] + [-self.along(v_t, self.q, self.v)])
            else:
                friction = hy.par[k] * number(p.f) * force + number(p.C_t) * v_t
                load = [q + friction * d for q, d in zip(load, tangent, strict=True)]
        if p.drive == "speed":  # the drive gives whatever torque keeps the crank's speed
            load[0], stuck = number(0.0), [[number(0.0), *column[1:]] for column in stuck]
        table = [[*mass[k], *(-column[k] for column in stuck), load[k]] for k in range(n)] + [
            [*row[:n], *(number(0.0) for _ in stuck), row[n]] for row in rows
        ]
        x = eliminate(table)
        return x[:n], dict(zip([j for j, mode in modes.items() if mode == "stick"], x[n:], strict=True))

    def integrator(self, modes):
        """Compiled Taylor integrator of these modes, with its guards as terminal events."""
        key = tuple(mode.rstrip("+-") for mode in modes.values())
        if key not in self.cache:
            acceleration, held = self.equations(modes)
            system = list(zip(self.q + self.v, self.v + acceleration, strict=True))
            events = [self.event(joint, guard, held) for joint, guard in guards(self.system, modes)]
            state = np.zeros(2 * self.n, dtype=self.real)
            self.cache[key] = hy.taylor_adaptive(system, state, t_events=events, **self.options)
        return self.cache[key]

    def event(self, joint, guard, held):
        """Terminal event that fires when a guard of `twin.guards` falls through 0."""
        square, force, v_t, _, _ = self.contact(joint)
        k = list(self.system.clearance).index(joint)
        limit, e = number(self.p.f) * force, number(self.system.clearance[joint])
        fall = {
            "touch": lambda: e * e - square,
            "leave": lambda: square - e * e,
            "release": lambda: force,
            "reload": lambda: -force,
            "slide": lambda: hy.par[k] * v_t,
            "cone+": lambda: limit - held[joint],
            "cone-": lambda: limit + held[joint],
        }[guard]
        return hy.t_event(fall(), direction=hy.event_direction.negative, fp_type=self.real)

    def __call__(self, system, modes, t, y, t_stop, rtol):
        """Advance function for `twin.run`; the tolerance is the series' own, ``rtol`` is not used."""
        series, live = self.integrator(modes), guards(system, modes)
        series.time, series.state[:] = self.real(t), y
        series.reset_cooldowns()
        for k, mode in enumerate([*modes.values()][: len(series.pars)]):
            series.pars[k] = -1 if mode == "slip-" else 1
        while True:
            outcome = series.propagate_until(self.real(t_stop))[0]
            if outcome == hy.taylor_outcome.time_limit:
                return self.real(t_stop), series.state.copy(), None, None
            fired = -int(outcome.value if hasattr(outcome, "value") else outcome) - 1
            if not 0 <= fired < len(live):
                raise RuntimeError(f"heyoka at t = {series.time}: {outcome}")
            # slip that begins from sticking starts with v_t = v_t' = 0: a root there is rounding
            if live[fired][1] != "slide" or series.time - t > 1e-10:
                return series.time, series.state.copy(), *live[fired]


def eliminate(table):
    """Solution of a linear system of expressions, rows (matrix | right side), by elimination in order."""
    rows = [list(row) for row in table]
    n = len(rows)
    for k in range(n):
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [None] * (k + 1) + [rows[i][j] - factor * rows[k][j] for j in range(k + 1, n + 1)]
    x = [None] * n
    for k in reversed(range(n)):
        rest = rows[k][n] - hy.sum([rows[k][j] * x[j] for j in range(k + 1, n)])
        x[k] = rest / rows[k][k]
    return x
