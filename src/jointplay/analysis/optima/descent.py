"""Descent by sequential quadratic programming in boxes, drawn in where a motion has no derivative.

scipy's SLSQP takes the exact derivatives. A design without a motion that can be differentiated (chaos where
an orbit is sought, a run that stopped) ends its pass: the next one begins at the best design so far, in a box
of a quarter of the size. A pass that ends at a side of its box goes on in one of twice the size. Reference:
Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28 (1988).
"""

from __future__ import annotations

import warnings

import numpy as np
from scipy.optimize import minimize

from jointplay.analysis.optima.trials import Aim, NoMotion, Trial, Trials, best

SHORTER, LONGER, PASSES = 0.25, 2.0, 40
SMALLEST = 1e-6  # half width of a box, in the variables' ranges


def descended(trials: Trials, aim: Aim, x: np.ndarray, tolerance: float, most: int) -> tuple[str, Trial]:
    """Descend from x: the reason of the end (a word of `ENDS`), and the best trial."""
    made, reach = len(trials.made), 1.0
    start = trials.at(x)
    if start.status:
        return "no_motion", start
    for _ in range(PASSES):
        here = best(trials.made[made:] or [start], aim, tolerance)
        left = most - (len(trials.made) - made)
        if left <= 0:
            return "iterations", here
        done, stopped = _pass(trials, aim, here.x, reach, tolerance, left)
        now = best([start, *trials.made[made:]], aim, tolerance)
        if stopped:
            reach *= SHORTER
            if reach < SMALLEST:
                break
        elif reach < 1.0 and np.max(np.abs(now.x - here.x)) > 0.999 * reach:
            reach = min(1.0, LONGER * reach)
        elif aim.missed(now) > tolerance:
            return ("infeasible" if len(trials.made) - made < most else "iterations"), now
        elif np.max(np.abs(now.x - here.x)) > SMALLEST and aim.value(here) - aim.value(now) > tolerance:
            continue  # once more from there, with no memory of how it bent before
        else:
            return ("converged" if done else "no_descent"), now
    return "no_descent", best([start, *trials.made[made:]], aim, tolerance)


def _pass(
    trials: Trials, aim: Aim, x: np.ndarray, reach: float, tolerance: float, most: int
) -> tuple[bool, bool]:
    """One run of SLSQP in a box: whether it converged, and whether a design had no motion."""

    def at(point: np.ndarray) -> Trial:
        trial = trials.at(np.clip(point, 0.0, 1.0))
        if trial.status:
            raise NoMotion(trial.status)
        return trial

    limits = {"type": "ineq", "fun": lambda p: aim.margins(at(p)), "jac": lambda p: aim.margin_slopes(at(p))}
    box = list(zip(np.maximum(x - reach, 0.0), np.minimum(x + reach, 1.0), strict=True))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of points that it clips to the box
            found = minimize(
                lambda p: aim.value(at(p)),
                x,
                jac=lambda p: aim.slope(at(p)),
                bounds=box,
                constraints=[limits] if np.isfinite(aim.limits).any() else [],
                method="SLSQP",
                options={"ftol": 1e-2 * tolerance, "maxiter": most},
            )
    except NoMotion:
        return False, True
    return bool(found.success), False
