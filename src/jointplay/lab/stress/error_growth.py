"""Largest growth of a small difference while a model runs: the measure of a disagreement of two runs.

Each step adds an error of its own, and the flow carries it on. So the growth that counts is the largest
between any two times: with Phi_k the flow's derivative over block k, jumps at events included, the largest
norm of Phi_j ... Phi_i, i <= j. The frame of unit tangents starts anew with
each block, so that none of it is lost to the fastest direction. What grows and is ended by an event (the
onset of sticking) within a block does not show: shorter blocks show it.
"""

from __future__ import annotations

import numpy as np

from jointplay.analysis.tangents import Bundle
from jointplay.analysis.trajectory import Request
from jointplay.mechanism.model import Model

BLOCKS = 24  # a nominal turn, and at least in a run
BEYOND = 1e12  # growth at which it is not followed further
SOLVED = 1e-6  # tolerance of the tangents' iteration: their size is wanted, not their digits


def largest_growth(
    model: Model, unit: np.ndarray, turns: float, rtol: float, max_steps: int, closer: int = 1
) -> float:
    """Return the largest growth, at least 1, of a small difference between any two times of a run.

    Differences are in units of the states' sizes `unit`. Blocks are `closer` times shorter than usual: growth
    that an event soon ends shows in short ones only. If the run stops, the part before counts.
    """
    end, n_x, whole = turns * model.period, len(unit), np.eye(len(unit))
    request = Request(end, rtol, max_steps=max_steps)
    bundle = Bundle(model, request, np.diag(unit), tolerance=SOLVED, held=True)
    products, largest = np.zeros((0, n_x, n_x)), 1.0
    for until in np.linspace(0.0, end, closer * max(BLOCKS, round(turns * BLOCKS)) + 1)[1:]:
        bundle.y.d.reshape(n_x, -1)[:] = np.diag(unit, 1)[:n_x]
        status = bundle.advance(until)
        block = (bundle.vectors / unit).T
        if not np.all(np.isfinite(block)):
            return largest
        products = block @ np.concatenate([products, whole[None]])
        largest = max(largest, float(np.max(np.linalg.norm(products, 2, axis=(1, 2)))))
        if status or largest > BEYOND:
            return largest
    return largest
