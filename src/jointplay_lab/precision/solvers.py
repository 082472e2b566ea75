"""SciPy's and SUNDIALS' solvers as peers: compiled rates, Jacobians, guards; events located, then restarted.

References: A. C. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363-396 (CVODE); L. Petzold, SIAM J.
Sci. Stat. Comput. 4 (1983) 136-148 (LSODA); E. Hairer and G. Wanner, Solving Ordinary Differential Equations
I and II (DOP853, Radau).
"""

from __future__ import annotations

import numpy as np

from jointplay_lab.precision.contenders import Peer, Trouble

EXPLICIT = ("DOP853",)


class Cvode(Peer):
    """Variable-order BDF with root functions; a new solver after each event."""

    name = "CVODE"

    def __init__(self, *given):
        from sksundae.cvode import CVODE

        super().__init__(*given)
        self.solver = CVODE

    def integrate(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        equations, n = self.equations, self.equations.guards

        def rate(time, state, out):
            self.count()
            equations.rate(time, state, out)

        def jacobian(time, state, _, out):
            equations.jacobian(time, state, out)

        def roots(time, state, out):
            equations.roots(time, state, out)

        roots.terminal, roots.direction = [True] * n, [-1] * n
        options = {"eventsfn": roots, "num_events": n} if n else {}
        options |= {"jacfn": jacobian, "max_num_steps": 10**8, "rtol": self.tolerance, "atol": self.absolute}
        found = self.solver(rate, **options).solve([t, self.end], y)
        self.steps += len(found.t)
        end, state = float(found.t[-1]), np.array(found.y[-1])
        if found.status == 2:
            return end, state, int(np.flatnonzero(found.i_events[-1])[0])
        if end < self.end:
            raise Trouble("not_converged")
        return end, state, None


class Scipy(Peer):
    """A method of `scipy.integrate.solve_ivp`, with terminal events."""

    def __init__(self, name: str, *given):
        from scipy.integrate import solve_ivp

        super().__init__(*given)
        self.solver = solve_ivp
        self.name = name
        self._out, self._square = np.empty(len(self.absolute)), np.empty(2 * [len(self.absolute)])

    def integrate(self, t: float, y: np.ndarray) -> tuple[float, np.ndarray, int | None]:
        equations = self.equations

        def rate(time, state):
            self.count()
            equations.rate(time, state, self._out)
            return self._out.copy()

        def jacobian(time, state):
            equations.jacobian(time, state, self._square)
            return self._square.copy()

        options = {"method": self.name, "rtol": self.tolerance, "atol": self.absolute}
        options |= {"events": self._guards(), "first_step": min(self.first_step, self.end - t)}
        options |= {} if self.name in EXPLICIT else {"jac": jacobian}
        found = self.solver(rate, (t, self.end), y, **options)
        self.steps += len(found.t) - 1
        if found.status == -1:
            raise Trouble("not_converged")
        fired = [k for k, times in enumerate(found.t_events or ()) if len(times)]
        return float(found.t[-1]), found.y[:, -1].copy(), fired[0] if found.status == 1 else None

    def _guards(self):
        """The watched guards, as functions of their own that share an evaluation's array."""
        out = np.empty(max(self.equations.guards, 1))

        def one(k):
            def guard(time, state):
                self.equations.roots(time, state, out)
                return out[k]

            guard.terminal, guard.direction = True, -1
            return guard

        return [one(k) for k in range(self.equations.guards)] or None
