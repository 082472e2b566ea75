"""CVODE and scipy as peers, on numba right-hand sides with exact Jacobians and located, restarted events."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE

from . import systems as S


class Stepper:
    """Event loop shared by the peers; a subclass integrates one mode up to a guard or the end."""

    def __init__(self, tol):
        self.tol, self.evaluations = tol, 0
        self.out, self.square, self.pair = np.empty(6), np.empty((6, 6)), np.empty(2)

    def run(self, case):
        """End state, evaluations and event kinds of a case."""
        t, y, mode, kinds, self.evaluations = 0.0, case.start, S.FREE, [], 0
        while True:
            t, y, guard = self.until(case, mode, t, y)
            if guard is None:
                return y, self.evaluations, kinds
            new = S.switch(y, mode, guard, case.par)
            kinds.append(S.kind(mode, guard, new))
            mode = new
            if len(kinds) > 10 * len(case.events):
                raise RuntimeError("the same events again and again")

    def tolerances(self, case):
        """Relative and absolute tolerances: atol is rtol/100 in units of (1 rad, a/b)."""
        return {"rtol": self.tol, "atol": self.tol / 100 * case.scale}


class Cvode(Stepper):
    """SUNDIALS' variable-order BDF with root functions."""

    name = "CVODE"

    def until(self, case, mode, t, y):
        """Integrate until a root or the end; a new solver each time."""
        par = case.par

        def rate(_, state, out):
            S.rate(state, mode, par, out)

        def jacobian(_, state, __, out):
            S.jacobian(state, mode, par, out)

        def roots(_, state, out):
            S.guards(state, mode, par, out)

        roots.terminal, roots.direction = [True, True], [-1, -1]
        options = {"jacfn": jacobian, "eventsfn": roots, "num_events": 2, "max_num_steps": 10**8}
        solver = CVODE(rate, **options, **self.tolerances(case))
        found = solver.solve([t, case.t_end], y)
        self.evaluations += found.nfev
        end, y = float(found.t[-1]), np.array(found.y[-1])
        if found.status == 2:
            return end, y, int(found.i_events[-1][0] == 0)
        if end < case.t_end:
            raise RuntimeError(str(found.message))
        return end, y, None


class Scipy(Stepper):
    """A scipy method through solve_ivp, with terminal events."""

    def __init__(self, tol, name):
        super().__init__(tol)
        self.name = name

    def until(self, case, mode, t, y):
        """Integrate until a terminal event or the end."""
        par = case.par

        def rate(_, state):
            S.rate(state, mode, par, self.out)
            return self.out.copy()

        def jacobian(_, state):
            S.jacobian(state, mode, par, self.square)
            return self.square.copy()

        options = {"method": self.name, "events": guards(mode, par, self.pair), **self.tolerances(case)}
        if self.name != "DOP853":
            options["jac"] = jacobian
        # the motor rests at no load, so a first step chosen from the rate alone is far too long
        options["first_step"] = min(1e-7, case.t_end - t)
        found = solve_ivp(rate, (t, case.t_end), y, **options)
        self.evaluations += found.nfev
        if found.status == -1:
            raise RuntimeError(found.message)
        fired = [k for k, times in enumerate(found.t_events or ()) if len(times)]
        if found.status == 0 or not fired:
            return case.t_end, found.y[:, -1].copy(), None
        return float(found.t[-1]), found.y[:, -1].copy(), fired[0]


def guards(mode, par, pair):
    """Guard functions of a mode as solve_ivp takes them."""

    def one(k):
        def guard(_, state):
            S.guards(state, mode, par, pair)
            return pair[k]

        guard.terminal, guard.direction = True, -1
        return guard

    return [one(0)] if mode == S.FREE else [one(0), one(1)]
