"""Derivatives of a motion's end with respect to its start, by the tangents that are carried beside it."""

from __future__ import annotations

import numpy as np

from jointplay.analysis.tangents import Bundle
from jointplay.solver.mechanism.model import Model
from jointplay.solver.motion.trajectory import Request


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
