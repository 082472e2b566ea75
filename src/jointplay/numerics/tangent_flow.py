"""The flow with tangents: the same loop as numerics.flow, compiled only where tangents are asked for."""

import numpy as np
from numba import int64, typeof

from .flow import run
from .interface import FUNCTIONS, OPTIONS, TRAJECTORY, VARIATIONS, WORK, entry
from .tangent import tangents

TANGENTS = typeof(tangents(np.zeros((1, 1)), np.ones(1), 1, 1, 1))

flow = entry(int64(FUNCTIONS, WORK, TRAJECTORY, OPTIONS, VARIATIONS, TANGENTS))(run)
