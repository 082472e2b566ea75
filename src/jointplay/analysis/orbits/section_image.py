"""What a section map makes of a state."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Image:
    """Result of applying a section map to a state.

    Parameters
    ----------
    status : int
        Index into `STATUS`; all else is meaningless unless it is 0.
    state : ndarray
        State at the end, angles brought back by whole turns to near the start's.
    time : float
        Duration, s.
    derivative : ndarray
        Of the free coordinates with respect to themselves, in units of their scales.
    events : ndarray
        Rows: contact, kind, time since the start over the duration, time, positions, speeds, modes.
    grazing : float
        Smallest approach speed of a guard at an event, relative to the terms that it is a sum of.
    along : ndarray
        Derivatives of the free coordinates, in units of their scales, in parameters: a column each.
    times : ndarray
        Derivatives of the duration in these.
    """

    status: int
    state: np.ndarray
    time: float = math.nan
    derivative: np.ndarray | None = None
    events: np.ndarray | None = None
    grazing: float = math.inf
    along: np.ndarray | None = None
    times: np.ndarray | None = None
