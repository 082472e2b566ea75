"""The loop over an ensemble with tangents: that of .flow, compiled only where tangents are carried."""

import numpy as np

from ..interface import FUNCTIONS, INT, Record, Signature
from ..tangents.tangent_flow import TANGENTS as FRAME
from . import layout as rows
from .flow import run
from .memory import JOBS, LANES, PARTS
from .tangent import tangents

TANGENTS = Record.of(tangents(np.zeros((1, 1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 1))
flow = run
OWN = rows.VARIATIONS, TANGENTS, FRAME
UNIT = {"flow": Signature(INT, (FUNCTIONS, PARTS, rows.FUNCTIONS, LANES, JOBS, *OWN))}
