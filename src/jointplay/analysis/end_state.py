"""Where a run ends, as a start of another that goes on as it would have."""

from __future__ import annotations

import math

import numpy as np

from jointplay.analysis.exponents.section_exponents import timeless
from jointplay.analysis.starts import moved, whole_names
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import Records, Request, advance, memory

WHOLE = 1e-9  # of a period of the forcing, up to which it is over


def end_state(model: Model, records: Records) -> np.ndarray:
    """State at the end, as `starts.placed` takes it; NaN where a run that starts there would go on otherwise.

    So it is where the time counts (of a forced system unless periods are over), and where a contact or a
    switch is in a mode that no start has there.
    """
    n_x, time = len(model.state), records.end[0]
    state, angle = records.end[1 : 1 + n_x], model.crank_angle + model.crank_speed * time
    found = np.append(state, angle)[: len(whole_names(model))]
    goes_on = np.isfinite(found).all() and _starts_anew(model, time) and _alike(model, records)
    return found if goes_on else np.full_like(found, np.nan)


def _starts_anew(model: Model, time: float) -> bool:
    """Whether the time that has passed is of no account."""
    if timeless(model):
        return True
    if not model.links:
        return math.isclose(time / model.period, round(time / model.period), abs_tol=WHOLE)
    structure = model.structure
    return structure.drive == "speed" and not any(load.course.timed for load in structure.loads)


def _alike(model: Model, records: Records) -> bool:
    """Whether contacts and switches begin there in the modes in which they are."""
    n_x, time = len(model.state), float(records.end[0])
    k, x, o = memory(moved(model, records.end[1 : 1 + n_x]), Request(time))
    x.s[0] = time
    advance(model.structure, k, x, o)
    return bool(np.all(x.modes == records.end[1 + n_x :][: len(x.modes)]))
