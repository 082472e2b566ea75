"""Derivatives of a motion's end with respect to its start, by the tangents that are carried beside it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from jointplay.analysis.tangents import Bundle
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import Request


def agreed(found, apart, limit):
    """The best of difference quotients of several steps (each quotient, events, whether they are alike).

    None where none of two neighbouring ones is nearer to the next than a limit.
    """
    pairs = [(apart(a, b), b) for (a, _, one), (b, _, other) in pairwise(found) if one and other]
    spread, best = min(pairs, key=lambda pair: pair[0], default=(np.inf, None))
    return best if spread < limit else None


def tangent_map(model: Model, duration: float, rtol: float = 1e-11, saltation: bool = True) -> np.ndarray:
    """Derivative of the state after `duration` s with respect to the state at the start.

    Returns
    -------
    ndarray
        Shape (states, states); entry (i, j) is d state_i(duration) / d state_j(0).

    Raises
    ------
    ArithmeticError
        If the motion did not reach the end.
    """
    bundle = Bundle(model, Request(duration, rtol), np.eye(len(model.state)), saltation=saltation, held=True)
    status = bundle.advance()
    if status:
        raise ArithmeticError(f"the motion ended with status {status}")
    return bundle.vectors.T
