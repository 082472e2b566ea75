"""The bodies' free coordinates through SUNDIALS' CVODE (scikit-sundae), with its own root functions.

A second integrator for the same equations: variable-order BDF, events by CVODE's root finder, a new solver
after every event. A fresh object each time also avoids the event records an old one would keep.
"""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE

from tests.support.multibody_run import State, guards, passed, watched

from .four_bar import FourBar
from .motion import tolerances

__all__ = ["bdf"]


def bdf(system: FourBar, now: State, stop: float, rtol: float):
    """Go on by BDF to a time or the next event, as `multibody_run.followed` takes it."""
    ways = watched(system, now)
    modes = {joint.name: mode for joint, mode in zip(system.loose, now.modes, strict=True)}
    if thrown := passed(system, now, ways):
        return now.t, now.y, thrown

    def rate(_, state, out):
        out[:] = system.rate(state, modes)

    def roots(t, state, out):
        out[:] = guards(system, now, ways, t, system.full(state))

    roots.terminal, roots.direction = [True] * len(ways), [-1] * len(ways)
    options = {"eventsfn": roots, "num_events": len(ways)} if ways else {}
    options |= {"rtol": rtol, "atol": tolerances(system, rtol, free=True), "max_num_steps": 10**8}
    end, y = now.t, system.reduced(now.y)
    for _ in range(20):  # slip that begins from sticking has v_t = v_t' = 0: roots there are rounding
        found = CVODE(rate, **options).solve([end, stop], y)
        end, y = float(found.t[-1]), np.array(found.y[-1])
        if found.status != 2:
            if end < stop:
                raise RuntimeError(f"CVODE at t = {end}: {found.message}")
            return stop, system.full(y), None
        k = int(np.argmin(np.where(found.i_events[-1] != 0, -1, 0)))
        if not ways[k][1].startswith("still") or end - now.t > 1e-10:
            return end, system.full(y), ways[k]
    raise RuntimeError(f"CVODE finds the same root again and again at t = {end}")
