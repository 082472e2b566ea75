"""Periodic ends of motions that attract nothing: saddles and repellers that a start hits exactly.

By the multipliers of the section map over the period: one beyond the unit circle, and neighbours leave.
Validity: multipliers within `BEYOND` of it are not told from those on it.
"""

from __future__ import annotations

import numpy as np

from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.starts import crank_place
from jointplay.analysis.states.ends import Observation
from jointplay.analysis.states.matching import Attractors
from jointplay.solver.mechanism.model import Model

BEYOND = 1e-3  # of 1: a multiplier that differs less may be on the unit circle


def repels(base: Model, period: int, state: np.ndarray, observation: Observation) -> bool:
    """Whether the periodic orbit through a state at the section has a multiplier beyond the unit circle."""
    place = crank_place(base) if base.structure.section is not None else None
    limits = {"rtol": observation.rtol, "max_steps": observation.max_steps}
    image = SectionMap(base, period, base.crank_angle, place, base.forward, **limits).image(state)
    if image.status:  # without a derivative it is as it was found
        return False
    return bool(np.max(np.abs(np.linalg.eigvals(image.derivative)), initial=0.0) > 1 + BEYOND)


def without_saddles(
    found: Attractors, states: list[np.ndarray], base: Model, observation: Observation
) -> tuple[Attractors, np.ndarray]:
    """The attractors that attract, and whether each end is an orbit that does not.

    Parameters
    ----------
    found : Attractors
        Sorted ends.
    states : list of ndarray
        States at the section of each end.
    base : Model
        The model on its section.
    observation : Observation
        How the motions were followed.
    """
    pairs = zip(found.periods, found.shown_by, strict=True)
    kept = np.array([not (p and repels(base, int(p), states[i][-1], observation)) for p, i in pairs], bool)
    number = np.append(0, np.where(kept, np.cumsum(kept), 0)).astype(np.int32)
    on_saddle = np.append(False, ~kept)[found.labels]
    return Attractors(number[found.labels], found.periods[kept], found.shown_by[kept]), on_saddle
