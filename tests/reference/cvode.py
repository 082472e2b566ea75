"""The twin's right-hand side through SUNDIALS' CVODE (scikit-sundae), with its own root functions.

A second integrator for the same equations: variable-order BDF, events by CVODE's root finder, a new solver
after every event. A fresh object each time also avoids the event records an old one would keep.
"""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE

from .twin import guard_values, guards, run, tolerances

__all__ = ["advance", "run_cvode"]


def advance(system, modes, t, y, t_stop, rtol):
    """Advance function for `twin.run`: BDF until a guard falls through 0 or t_stop is reached."""
    live = guards(system, modes)

    def rate(_, state, out):
        out[:] = system.rate(state, modes)

    def roots(_, state, out):
        out[:] = guard_values(system, modes, state)

    roots.terminal, roots.direction = [True] * len(live), [-1] * len(live)
    options = {"rtol": rtol, "atol": tolerances(system, rtol), "max_num_steps": 10**8}
    end = t
    for _ in range(20):  # slip that begins from sticking has v_t = v_t' = 0: roots there are rounding
        solver = CVODE(rate, eventsfn=roots, num_events=len(live), **options)
        found = solver.solve([end, t_stop], y)
        end, y = float(found.t[-1]), np.array(found.y[-1])
        if found.status != 2:
            if end < t_stop:
                raise RuntimeError(f"CVODE at t = {end}: {found.message}")
            return t_stop, y, None, None
        k = int(np.argmin(np.where(found.i_events[-1] != 0, -1, 0)))
        if live[k][1] != "slide" or end - t > 1e-10:
            return end, y, *live[k]
    raise RuntimeError(f"CVODE finds the same root again and again at t = {end}")


def run_cvode(parameters=None, clearance=None, turns=1.0, t_end=None, rtol=1e-12, at=(), start=None):
    """As `twin.run`, integrated by CVODE; same arguments but ``method``, same result."""
    return run(parameters, clearance, turns, t_end, method=advance, rtol=rtol, at=at, start=start)
