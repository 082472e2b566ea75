"""Many motions at once against one at a time, at the same tolerance, both with section points once a turn."""

import math
import time
from statistics import median

import numpy as np

from jointplay import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.ensemble_runs import follow_ensemble
from jointplay.solver.motion.trajectory import Request, follow

TRAJECTORIES, AGAIN = 64, 7
LOADS = {  # gear ratio, least and largest clearance, friction, turns
    "B": (3.0, 2.9e-5, 6e-5, 0.01, 10),
    "B to C": (3.0, 2.9e-5, 2.9e-4, 0.01, 10),
    "A": (15.0, 2.9e-5, 2.9e-4, 0.01, 4),
    "friction 0.1": (3.0, 2.9e-5, 2.9e-4, 0.1, 4),
    "friction 0.3": (3.0, 2.9e-5, 2.9e-4, 0.3, 4),
    "friction 0.3, gear ratio 15": (15.0, 2.9e-5, 2.9e-4, 0.3, 4),
}
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
FOUND = ("times as fast", "µs a turn", "error", "error one by one")


class Ensemble:
    """CPU time, alternating, medians; the median error of end states against rtol 1e-11, two turns on."""

    params = (list(LOADS), list(TOLERANCES), list(FOUND))
    param_names = ("load", "rtol", "what")
    unit = ""

    def setup_cache(self):
        return {(load, rtol): compared(load, rtol) for load in LOADS for rtol in TOLERANCES}

    setup_cache.timeout = 3600

    def track_turn(self, found, load, rtol, quantity):
        return float(f"{found[load, rtol][quantity]:.3g}")


def compared(load, rtol):
    """What is `FOUND` of a load at a tolerance."""
    *what, turns = LOADS[load]
    scenes = _scenes(*what)
    requests = [_asked(model, turns, rtol) for model in scenes]
    follow_ensemble(scenes[:1], requests[:1])
    alone, together = [], []
    for _ in range(AGAIN):
        alone.append(_seconds(lambda: [follow(*pair) for pair in zip(scenes, requests, strict=True)]))
        together.append(_seconds(lambda: follow_ensemble(scenes, requests)))
    times = median(a / b for a, b in zip(alone, together, strict=True))
    errors = _errors(scenes, min(turns, 2), rtol)
    spent = 1e6 * median(together) / (turns * TRAJECTORIES)
    return dict(zip(FOUND, (times, spent, *errors), strict=True))


def _scenes(gear, low, high, friction):
    """Scenes over clearance, in a seeded order."""
    clearances = np.random.default_rng(1).permutation(np.geomspace(low, high, TRAJECTORIES))
    changes = {"gear_ratio": gear, "friction": friction}
    made = (catalog.chunmei2002(clearance=float(e), **changes) for e in clearances)
    return [assemble(each, section="angle:crank") for each in made]


def _asked(model, turns, rtol, **more):
    cut = {"level": model.crank_angle + math.tau, "period": math.tau, "direction": 1}
    return Request(turns * model.period, rtol, **cut, **more)


def _errors(scenes, turns, rtol):
    """Medians over scenes of the largest errors at the end, rad and nominal speeds: together, one by one."""
    end = {"at": np.array([turns * scenes[0].period])}
    together = follow_ensemble(scenes, [_asked(model, turns, rtol) for model in scenes])
    alone, truth = (
        [follow(model, _asked(model, turns, tight, **end)) for model in scenes] for tight in (rtol, 1e-11)
    )
    unit = np.repeat([1.0, math.tau / scenes[0].period], 3)
    for found in (together, alone):
        parts = [(a.samples[0] - b.samples[0])[1:7] / unit for a, b in zip(found, truth, strict=True)]
        yield median(float(np.abs(part).max()) for part in parts)


def _seconds(work):
    began = time.process_time()
    work()
    return time.process_time() - began
