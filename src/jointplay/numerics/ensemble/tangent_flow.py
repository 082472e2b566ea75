"""The loop over an ensemble with tangents: that of .flow, compiled only where tangents are asked for."""

import numpy as np
from numba import int64, typeof

from ..interface import entry
from . import layout as rows
from .flow import FULL, PART, enter, event, jobs, lanes, nothing, run
from .memory import AT_EVENT, JOBS, LANES, PARTS
from .tangent import tangents

__all__ = ["FULL", "PART", "enter", "event", "flow", "jobs", "lanes", "nothing", "tangents"]
TANGENTS = typeof(tangents(np.zeros((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 1))

flow = entry(int64(AT_EVENT, PARTS, rows.FUNCTIONS, LANES, JOBS, rows.VARIATIONS, TANGENTS))(run)
