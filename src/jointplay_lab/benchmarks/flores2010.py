"""The slider-crank of Flores, Leine and Glocker (2010) just before its first impact, and a stored motion.

Source: Siconos tutorials (INRIA), `SliderCrankMoreauJeanCombinedProjectionOSI.ref`, its row at 2.6 ms: the
paper itself prints no digits. That motion has steps of 0.1 ms, of first order and one Newton iteration
each. It is off by 2e-3 of the angles and by a sixth of what is left of the gap. The test of this kind takes
these steps and meets every digit: the equations are the same. After the impact no digits can be compared.
"""

from __future__ import annotations

import math

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.keywords import Progress
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.trajectory import Request, follow
from jointplay_lab.benchmarks.answer import Answer

END, SPEED = 2.6e-3, 150.0
PUBLISHED = {
    "crank angle": ("rad", math.tau * 5.500750885904324e-2),
    "rod angle": ("rad", -1.671997699721930e-1),
    "crank speed": ("rad s-1", 1.113312008760953e2),
    "rod speed": ("rad s-1", -5.046469159463980e1),
    "gap of corners": ("m", 9.138508429411968e-5),
}


def answer(mechanism: Mechanism, rtol: float, max_steps: int, progress: Progress = None) -> Answer:
    """Follow the motion from the paper's start and give it with the stored state."""
    model = assemble(mechanism, {"crank_speed": SPEED})
    records = follow(model, Request(END, rtol, at=np.array([END]), max_steps=max_steps), progress)
    computed = [math.nan] * len(PUBLISHED)
    if len(records.samples):
        words = ("angle", "angular_velocity")
        found = Quantities(model, records.samples, records.start).variables(words, "time")
        places = [model.links.index(name) for name in ("crank", "rod")]
        angles, speeds = (found[word][1][-1, places] for word in words)
        raised = sum(
            mechanism.link(model.links[i]).length * math.sin(found["angle"][1][-1, i]) for i in places
        )
        computed = [*angles, *speeds, mechanism.joint("G").clearance - raised]
    return Answer(PUBLISHED, computed, records)
