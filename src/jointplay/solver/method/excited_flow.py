"""The flow where friction may excite vibrations (method.excited), compiled for such structures only."""

from .flow import run
from .interface import FUNCTIONS, INT, OPTIONS, TRAJECTORY, WORK, Signature

flow = run
UNIT = {"flow": Signature(INT, (FUNCTIONS, WORK, TRAJECTORY, OPTIONS, INT, None))}
