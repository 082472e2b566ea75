"""Exponents of a section's map, from the growth of tangents along the flow.

Where nothing outside keeps the time, the direction of the motion itself, F = dx/dt, is carried along by the
tangent flow and through every event (S F- = F+): it neither grows nor shrinks in the long run, and has the
exponent 0. A section's map has the other exponents, times the length of a turn. The volume of F and j
tangents is |F| times the volume of what these have across F, and this grows as the sum of the section map's
first j exponents, exactly, whichever section is taken. So the frame has F as its first tangent
(method.tangents.tangent), and those after it give the map's exponents.

Validity: a motion that comes to rest has no section, and its exponents are NaN. Reference: Benettin et al.,
Meccanica 15 (1980) 9-20; Pikovsky and Politi, Lyapunov Exponents (2016), chapter 2.
"""

from __future__ import annotations

import math

from jointplay.analysis.exponents import batch_means
from jointplay.analysis.labels import Out
from jointplay.solver.codegen import cache
from jointplay.solver.equations.drives import DRIVES
from jointplay.solver.equations.structure import Oscillator
from jointplay.solver.mechanism.model import Model

STILL = math.log(1e-6)  # fall of the speed at which a motion counts as having come to rest


def timeless(model: Model) -> bool:
    """Whether nothing outside keeps the time, so that one exponent of the flow is 0.

    By structure, since rates may not tell: in flight, what is driven by contact alone feels no drive.
    """
    structure = model.structure
    if isinstance(structure, Oscillator):
        return "phase" not in cache.structure_module(structure).OUTPUTS
    drive, loads = DRIVES[structure.drive], structure.loads
    return not (drive.imposed or drive.follows or any(load.course.timed for load in loads))


def moves(start: float, end: float) -> bool:
    """Whether a motion still moves, by ln|F| where it began and at the end."""
    return bool(start > -math.inf and end - start >= STILL)


_NAME = "exponent of the section's map"
OUTS = {
    "section_exponent": Out("multiplier", f"{_NAME}, over the length of a turn", "s-1"),
    "section_standard_error": Out("multiplier", f"standard error of the {_NAME}", "s-1"),
    "section_exponent_per_turn": Out("multiplier", f"{_NAME}, per turn", about="without the flow's zero"),
    "section_standard_error_per_turn": Out("multiplier", f"standard error of the {_NAME}, per turn"),
    "section_batch_correlation": Out("multiplier", f"correlation of a batch mean with the next, {_NAME}"),
}
OF_THE_FLOW = dict(zip(OUTS, batch_means.ESTIMATES, strict=False))  # what is the same of the flow
NUMBER = "number of the exponent of the section's map, the largest first"
