"""Truth by Taylor series in 80-bit numbers (heyoka), from virtual work in minimal coordinates.

The equations are built by symbolic differentiation of the positions alone: a derivation apart from that of
`tests.support.multibody` (velocity, mass matrix, centripetal and generalised force all follow from the
Jacobian of the positions). Event times are roots of the guards' own Taylor polynomials.
"""

from __future__ import annotations

import heyoka as hy
import numpy as np

from tests.support.multibody import GROUND, Marker
from tests.support.multibody_run import passed, watched

from .four_bar import LINKS

WIDE = np.longdouble


def number(value):
    """A double as an exact 80-bit constant."""
    return hy.expression(WIDE(value))


class Series:
    """Taylor integrators of a rigid `FourBar` with play, one for each set of modes, made when first met."""

    def __init__(self, system, real=WIDE, tol=None):
        self.system, self.p, self.n, self.real = system, system.p, system.half, real
        self.options = {"fp_type": real, "compact_mode": True} | ({} if tol is None else {"tol": real(tol)})
        self.q = [hy.expression(f"q{k}") for k in range(self.n)]
        self.v = [hy.expression(f"v{k}") for k in range(self.n)]
        self.cache, self.reached = {}, (None, (None, None))
        self.joints = {joint.name: (joint.journal, joint.bearing) for joint in system.joints}
        self._place()

    def _place(self):
        q, bases = self.q, self.system.bases
        self.turned = dict(zip(LINKS, q, strict=False))
        self.e = {name: (hy.cos(angle), hy.sin(angle)) for name, angle in self.turned.items()}
        self.origin = {name: (q[3 + 2 * k], q[4 + 2 * k]) for k, name in enumerate(bases)}
        for new, old in self.system.steps:
            (x, y), (c, s) = self.point(old), self.e[new.body]
            self.origin[new.body] = x - number(new.at[0]) * c, y - number(new.at[0]) * s

    def point(self, marker):
        """Position of a place on a link's line, or on the ground."""
        if marker.body == GROUND:
            return tuple(number(float(x)) for x in marker.at)
        (x, y), (c, s), along = self.origin[marker.body], self.e[marker.body], number(marker.at[0])
        return x + along * c, y + along * s

    def along(self, expression, of, direction):
        """Derivative of an expression along a direction in the variables ``of``."""
        return hy.sum([hy.diff(expression, x) * d for x, d in zip(of, direction, strict=True)])

    def inertia(self):
        """Mass matrix and generalised gravity and centripetal load."""
        n, p = self.n, self.p
        mass, load = [[number(0.0)] * n for _ in range(n)], [number(0.0)] * n
        for body in self.system.bodies:
            x, y = self.point(Marker(body.name, (body.centre, 0.0)))
            terms = [(x, body.mass, 0.0), (y, body.mass, -p.gravity)]
            terms.append((self.turned[body.name], body.inertia, 0.0))
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
        p, (journal, bearing) = self.p, self.joints[joint]
        (ax, ay), (bx, by) = self.point(journal), self.point(bearing)
        rx, ry = ax - bx, ay - by
        square = rx * rx + ry * ry
        rho = hy.sqrt(square)
        c, s = rx / rho, ry / rho
        vx, vy = (self.along(r, self.q, self.v) for r in (rx, ry))
        normal = [-(c * hy.diff(rx, q) + s * hy.diff(ry, q)) for q in self.q]
        tangent = [s * hy.diff(rx, q) - c * hy.diff(ry, q) for q in self.q]
        carried = LINKS.index(journal.body)
        tangent[carried] -= number(p.R)
        v_t = vy * c - vx * s + number(p.R) * self.v[carried]
        if bearing.body != GROUND:
            carrier = LINKS.index(bearing.body)
            tangent[carrier] += number(p.R) + rho
            v_t -= (number(p.R) + rho) * self.v[carrier]
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
                dry = hy.par[k] * number(p.f) * force if mode.startswith("slip") else number(0.0)
                friction = dry + number(p.C_t) * v_t
                load = [q + friction * d for q, d in zip(load, tangent, strict=True)]
        if p.drive == "speed":  # the drive gives whatever torque keeps the crank's speed
            load[0], stuck = number(0.0), [[number(0.0), *column[1:]] for column in stuck]
        table = [[*mass[k], *(-column[k] for column in stuck), load[k]] for k in range(n)] + [
            [*row[:n], *(number(0.0) for _ in stuck), row[n]] for row in rows
        ]
        x = eliminate(table)
        return x[:n], dict(zip([j for j, mode in modes.items() if mode == "stick"], x[n:], strict=True))

    def integrator(self, modes, ways):
        """Compiled Taylor integrator of these modes, with what may happen as terminal events."""
        key = tuple(mode.rstrip("+-") for mode in modes.values())
        if key not in self.cache:
            acceleration, held = self.equations(modes)
            system = list(zip(self.q + self.v, self.v + acceleration, strict=True))
            names = list(modes)
            events = [self.event(names[touch], touch, kind, held) for touch, kind in ways]
            state = np.zeros(2 * self.n, dtype=self.real)
            self.cache[key] = hy.taylor_adaptive(system, state, t_events=events, **self.options)
        return self.cache[key]

    def event(self, joint, k, kind, held):
        """Terminal event that fires when a guard of `multibody_run.GUARDS` falls through 0."""
        square, force, v_t, _, _ = self.contact(joint)
        limit, e = number(self.p.f) * force, number(self.system.clearance[joint])
        fall = {
            "contact": lambda: e * e - square,
            "separation": lambda: square - e * e,
            "release": lambda: force,
            "reload": lambda: -force,
            "still": lambda: hy.par[k] * v_t,
            "slides+": lambda: limit - held[joint],
            "slides-": lambda: limit + held[joint],
        }["still" if kind.startswith("still") else kind]
        return hy.t_event(fall(), direction=hy.event_direction.negative, fp_type=self.real)

    def __call__(self, system, now, stop, rtol):
        """Go on as `multibody_run.followed` takes it; the tolerance is the series' own, not ``rtol``."""
        names, ways = [joint.name for joint in system.loose], watched(system, now)
        if thrown := passed(system, now, ways):
            return now.t, now.y, thrown
        series = self.integrator(dict(zip(names, now.modes, strict=True)), ways)
        known, (t, y) = self.reached  # with more digits than the motion has
        series.time, series.state[:] = (t, y) if known is now.y else (self.real(now.t), system.reduced(now.y))
        series.reset_cooldowns()
        for k, mode in enumerate(now.modes[: len(series.pars)]):
            series.pars[k] = -1 if mode == "slip-" else 1
        while True:
            outcome = series.propagate_until(self.real(stop))[0]
            if outcome == hy.taylor_outcome.time_limit:
                return self._left(series, stop, None)
            fired = -int(outcome.value if hasattr(outcome, "value") else outcome) - 1
            if not 0 <= fired < len(ways):
                raise RuntimeError(f"heyoka at t = {series.time}: {outcome}")
            # slip that begins from sticking starts with v_t = v_t' = 0: a root there is rounding
            if not ways[fired][1].startswith("still") or series.time - now.t > 1e-10:
                return self._left(series, float(series.time), ways[fired])

    def _left(self, series, t, way):
        """What `followed` takes; the whole digits are kept for the next call."""
        y = self.system.full(series.state)
        self.reached = y, (series.time, series.state.copy())
        return t, y, way


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
