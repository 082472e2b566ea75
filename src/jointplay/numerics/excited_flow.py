"""The flow where friction may excite vibrations (numerics.excited), compiled for such structures only."""

from numba import int64, types

from .flow import run
from .interface import FUNCTIONS, OPTIONS, TRAJECTORY, WORK, entry

flow = entry(int64(FUNCTIONS, WORK, TRAJECTORY, OPTIONS, int64, types.none))(run)
