"""The loop over an ensemble with tangents: that of .flow, compiled only where tangents are asked for."""

import numpy as np
from numba import int64, typeof

from ..interface import AT_POINT, entry
from . import layout as rows
from .flow import FULL, JOBS, LANES, jobs, lanes, run
from .tangent import tangents

__all__ = ["FULL", "flow", "jobs", "lanes", "tangents"]
TANGENTS = typeof(tangents(np.zeros((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 1))

flow = entry(int64(AT_POINT, rows.FUNCTIONS, LANES, JOBS, rows.VARIATIONS, TANGENTS))(run)
