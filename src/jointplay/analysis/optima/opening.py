"""Homotopy in clearance: descents with ever more play, each from the design found with less of it.

A design that is best without play may rattle with it, and rattling has no useful derivative. The clearance is
opened in steps, from none on: at each the design is found anew, from a motion that still keeps the
constraints. A step at which no design keeps them is tried again, shorter. Reference: Allgower and Georg,
Introduction to Numerical Continuation Methods (2003), chapter 1.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jointplay.analysis.optima.asked import FORCE
from jointplay.analysis.optima.descent import descended
from jointplay.analysis.optima.trials import Aim, Trial, Trials
from jointplay.analysis.vary import changed

FIRST, WIDER = 0.1, 10**0.5  # share of the clearance in the first step; of the next in each
STAGES, TRIES = 4, 4  # steps to the whole clearance where none fails; steps that may fail
PARTLY = 1e-3  # tolerance with part of the play
IDEAL = "reaction:"


def opened(trials: Trials, aim: Aim, x: np.ndarray, tolerance: float, most: int) -> tuple[str, Trial, float]:
    """How the last descent ended, its best trial, and the share of play up to which constraints are kept.

    Parameters
    ----------
    trials : Trials
        With the whole clearance.
    aim : Aim
        Without units.
    x : ndarray
        Scaled variables of the first design.
    tolerance, most
        As `descended` takes them.
    """
    kept, share, wider, fails = -1.0, 0.0, WIDER, 0
    while fails < TRIES:
        part = trials if share == 1 else _with_share(trials, share)
        slack = tolerance if share in (0, 1) else max(tolerance, PARTLY)
        scaled = aim.sized(part.at(x))
        end, found = descended(part, scaled, x, slack, most)
        if not found.status and scaled.missed(found) <= slack:
            x, kept = found.x, share
            if share == 1:
                return end, found, kept
            share = min(1.0, share * wider or FIRST)
        elif share == 0:
            break
        else:
            fails, wider = fails + 1, wider**0.5
            share = kept * wider or share / WIDER
    return "infeasible", trials.at(x), max(kept, 0.0)


def _with_share(trials: Trials, share: float) -> Trials:
    """Trials of the mechanism with part of its clearances; without any, of its ideal joints' forces."""
    joints = trials.mechanism.clearance_joints
    clearance = {f"joints.{joint.name}.clearance": share * joint.clearance for joint in joints}
    names, settings = trials.quantities, trials.settings
    if not share:
        names = tuple(name.replace(f":{FORCE}", f":{IDEAL}") for name in names)
    if not isinstance(settings["initial"], dict):  # a state is one of the mechanism with all its play
        settings = {**settings, "initial": None}
    mechanism = changed(trials.mechanism, clearance)
    return replace(
        trials, mechanism=mechanism, quantities=names, settings=settings, share=share, known={}, near=None
    )
