"""The flow with tangents: the same loop as method.flow, compiled only where tangents are carried."""

import numpy as np

from ..flow import run
from ..interface import FUNCTIONS, INT, OPTIONS, TRAJECTORY, VARIATIONS, WORK, Record, Signature
from .tangent import tangents

TANGENTS = Record.of(tangents(np.zeros((1, 1)), np.ones(1), 1, 1, 1))
flow = run
UNIT = {"flow": Signature(INT, (FUNCTIONS, WORK, TRAJECTORY, OPTIONS, VARIATIONS, TANGENTS))}
