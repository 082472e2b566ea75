"""Exact motions of test systems: free flights in closed form, linear pieces by matrix exponentials.

Nothing here comes from the package: roots are bracketed by sampling and found by SciPy's `brentq`.
"""

import math

import mpmath as mp
import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

TAU = 2 * math.pi


class Flight:
    """y'' = sin t from (t, y, v)."""

    def __init__(self, t, y, v):
        self.t, self.y, self.v = t, y, v

    def at(self, time):
        slope = self.v + math.cos(self.t)
        y = self.y + slope * (time - self.t) - math.sin(time) + math.sin(self.t)
        return y, slope - math.cos(time)

    def leaves(self, half):
        """Time and wall (+1, -1) of the first passage of |y| = half after the start."""
        step, left = 0.02, self.t
        for side in (1, -1):  # a short hop from the wall on which the flight begins
            if self.y == side * half and side * self.v < 0:
                left = self.t - 2 * self.v / math.sin(self.t) if side * math.sin(self.t) > 0 else self.t
                step = min(step, 0.05 * (left - self.t)) if left > self.t else step
                left = self.t + 0.01 * step
        for _ in range(200_000):
            right = left + step
            for side in (1, -1):
                if side * self.at(right)[0] > half:
                    root = brentq(
                        lambda t, s=side: s * self.at(t)[0] - half, left, right, xtol=1e-15, rtol=1e-15
                    )
                    return root, side
            left = right
            step = min(1.2 * step, 0.02)
        raise AssertionError("no impact found")


def impacts(gap, restitution, start, count):
    """Impacts (time, wall, incoming speed) of the rattling mass from start = (t, y, v)."""
    found, flight = [], Flight(*start)
    for _ in range(count):
        t, side = flight.leaves(gap / 2)
        v = flight.at(t)[1]
        found.append((t, side, abs(v)))
        flight = Flight(t, side * gap / 2, -restitution * v)
    return found


def strobed(gap, restitution, start, periods):
    """State (y, v) of the rattling mass at the time `periods` * 2 pi."""
    flight = Flight(*start)
    while True:
        t, side = flight.leaves(gap / 2)
        if t > periods * TAU:
            return flight.at(periods * TAU)
        flight = Flight(t, side * gap / 2, -restitution * flight.at(t)[1])


class Symmetric:
    """The rattling mass's symmetric motion with one impact a wall a period: TRUTH.md's closed form.

    The lower wall is met at t0 + 2 pi n with the incoming speed 2 cos t0 / (1 - r), the upper one half a
    period later.
    """

    def __init__(self, gap, restitution):
        k = (1 + restitution) / (1 - restitution)
        self.gap, self.r, self.fold = gap, restitution, math.hypot(math.pi * k, 2)
        self.t0 = math.atan2(2, math.pi * k) - math.acos(gap / self.fold)  # the branch that can be stable
        self.speed = 2 * math.cos(self.t0) / (1 - restitution)

    @property
    def at_zero(self):
        """State at time 0."""
        half_a_period, side = (0.0, -1) if self.t0 <= 0 else (math.pi, 1)
        return Flight(self.t0 - half_a_period, side * self.gap / 2, -side * self.r * self.speed).at(0.0)

    @property
    def half_map(self):
        """Trace and determinant of the map from one impact to the next."""
        return 2 * self.r + (1 - self.r**2) * math.pi / 2 * math.tan(self.t0), self.r**2


def symmetry_lost(restitution):
    """Gap below which the symmetric motion is unstable."""
    k = (1 + restitution) / (1 - restitution)
    return k * (math.pi - 4 / math.pi) / math.sqrt(1 + 4 * k**2 / math.pi**2)


class Walls:
    """y'' + 2 z y' = mean + amplitude trig(W t) - contact force, walls at +-half: linear between events.

    `x` is (y, v, cos W t, sin W t, 1). A wall pushes with K u + C u' while in contact. `pulls`: contact ends
    where u = 0; else where the force is 0, from when on the wall is `released` until u = 0 or the force is
    positive again.
    """

    def __init__(self, half, K, C, pulls=True, W=1.0, cos=0.0, sin=0.0, mean=0.0, drag=0.0):
        self.half, self.K, self.C, self.pulls, self.W = half, K, C, pulls, W
        self.free = np.zeros((5, 5))
        self.free[0, 1], self.free[2, 3], self.free[3, 2] = 1, -W, W
        self.free[1] = 0, -drag, cos, sin, mean
        self.side, self.mode = 0, "free"

    @property
    def A(self):
        if self.mode != "contact":
            return self.free
        A = self.free.copy()
        A[1] -= np.array([self.K, self.C, 0, 0, -self.K * self.half * self.side])
        return A

    def force(self, x):
        return self.K * (self.side * x[0] - self.half) + self.C * self.side * x[1]

    def guards(self):
        """What ends the piece where it becomes positive: (kind, function of x, side after, mode after)."""
        if self.mode == "free":
            return [("contact", lambda x, s=s: s * x[0] - self.half, s, "contact") for s in (1, -1)]
        gap = (lambda x: self.half - self.side * x[0]), 0, "free"
        if self.mode == "released":
            return [("reopening", *gap), ("contact", self.force, self.side, "contact")]
        if self.pulls:
            return [("separation", *gap)]
        return [("separation", lambda x: -self.force(x), self.side, "released")]

    def run(self, y, v, end, at=(), step=0.02):
        """Events (time, wall, kind) up to `end`, and states (y, v) at the times `at`."""
        t, x, events, states = 0.0, np.array([y, v, 1.0, 0.0, 1.0]), [], []
        at = list(at)
        self.side, self.mode = 0, "free"
        while True:
            root, guard = self._next(t, x, end, step)
            while at and at[0] <= min(root, end):
                states.append((expm(self.A * (at.pop(0) - t)) @ x)[:2])
            if guard is None:
                return events, np.array(states)
            kind, _, side, mode = guard
            x, t = expm(self.A * (root - t)) @ x, root
            x[2:4] = math.cos(self.W * t), math.sin(self.W * t)
            events.append((t, {1: 0, -1: 1}[side or self.side], kind))
            self.side, self.mode = side, mode

    def _next(self, t, x, end, step):
        """Time and guard of the next event after (t, x); infinity and None if there is none before `end`."""
        h, A = step if self.mode == "free" else min(step, 0.02 / math.sqrt(self.K)), self.A
        move, tau = expm(A * h), 0.0
        before, guards, first = x, self.guards(), True
        while t + tau < end:
            after = move @ before
            for guard in guards:
                value = guard[1]
                if value(after) > 0 and (first or value(before) <= 0):
                    low = 1e-9 * h if first else 0.0
                    if first and value(expm(A * low) @ before) > 0:
                        continue  # it has just fired: it comes from the other side
                    place = brentq(
                        lambda s, f=value, x=before: f(expm(A * s) @ x), low, h, xtol=1e-15, rtol=1e-14
                    )
                    return t + tau + place, guard
            before, tau, first = after, tau + h, False
        return math.inf, None


def distinct(section, tolerance=1e-6):
    """Number of distinct points of a section."""
    found = []
    for point in section.state_value.values:
        if not any(np.abs(point - other).max() < tolerance for other in found):
            found.append(point)
    return len(found)


class Rebounds:
    """x'' = F(t) between rigid walls, with every impact of a complete chatter, until its limit is known.

    Impacts are bracketed in floats, and found with 50 digits; very short rebounds begin with their leading
    order. Where they are over the body rests on its wall until F turns away from it (at the next of the times
    that `release` gives). `walls` has the level and side (+1 above the body) of each, in the package's order.
    """

    TINY = 1e-27  # speed of the last impact of a chatter

    def __init__(self, x, rate, F, release, walls, restitution):
        self.x, self.rate, self.F, self.release = x, rate, F, release
        self.walls, self.r, self.wall, self.events = walls, restitution, None, []

    def run(self, t, x, v, until):
        """Events up to a time: (time, wall, kind, speed before it)."""
        with mp.workdps(50):
            self.t, self.at, self.v = map(mp.mpf, (t, x, v))
            while self._impact(until):
                if abs(self.v) < self.TINY and self._push() > 0:
                    self._rest()
            return [event for event in self.events if event[0] <= until]

    def _place(self, t):
        slope = self.v - self.rate(self.t)
        return self.at + slope * (t - self.t) + self.x(t) - self.x(self.t)

    def _push(self):
        """Force against the wall that was met last."""
        return 0 if self.wall is None else self.walls[self.wall][1] * self.F(self.t)

    def _impact(self, until):
        hop = 2 * abs(self.v) / self._push() if self._push() > 0 and self.v else mp.inf
        if hop < 1e-6 * self._push():
            level = self.walls[self.wall][0]
            found, wall = mp.findroot(lambda t: self._place(t) - level, self.t + hop), self.wall
        else:
            found, wall = self._bracketed(min(0.03, float(hop) / 20), until)
        if found is None or found > until:
            return False
        speed = self.v + self.rate(found) - self.rate(self.t)
        self.t, self.at, self.v, self.wall = found, self.walls[wall][0], -self.r * speed, wall
        self.events.append((float(found), wall, "impact", float(abs(speed))))
        return True

    def _bracketed(self, step, until):
        before = self.t + step / 10
        while before < until:
            after, step = before + step, min(1.1 * step, 0.03)
            for wall, (level, side) in enumerate(self.walls):
                if side * (self._place(after) - level) > 0:
                    return mp.findroot(lambda t: self._place(t) - level, (before, after), "anderson"), wall  # noqa: B023
            before = after
        return None, None

    def _rest(self):
        self.v = mp.mpf(0)
        self.events.append((float(self.t), self.wall, "rest", 0.0))
        self.t = self.release(self.t)
        self.events.append((float(self.t), self.wall, "separation", 0.0))


def rattle(gap, restitution, start, until):
    """Events of the impact pair from start = (t, y, v)."""
    half = mp.mpf(gap) / 2
    turn = lambda t: (mp.floor(t / mp.pi) + 1) * mp.pi  # noqa: E731
    pair = Rebounds(
        lambda t: -mp.sin(t), lambda t: -mp.cos(t), mp.sin, turn, [(half, 1), (-half, -1)], restitution
    )
    return pair.run(*start, until)


def bounce(acceleration, restitution, start, until):
    """Events of the bouncing ball from start = (t, y, v), by its height over the table."""
    g = 1 / mp.mpf(acceleration)

    def release(t):
        first = mp.asin(g) if g <= 1 else mp.inf
        return first + 2 * mp.pi * mp.ceil((t - first) / (2 * mp.pi)) if g <= 1 else mp.inf

    ball = Rebounds(
        lambda t: -g * t**2 / 2 - mp.sin(t),
        lambda t: -g * t - mp.cos(t),
        lambda t: mp.sin(t) - g,
        release,
        [(mp.mpf(0), -1)],
        restitution,
    )
    t, y, v = start
    return ball.run(t, y - mp.sin(t), v - mp.cos(t), until)
