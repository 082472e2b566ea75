"""Coarse steps followed again in shorter ones; compiled only where rates are recorded (analysis.evaluate)."""

from numpy import inf

from . import flow as _flow
from .interface import FUNCTIONS, INT, OPTIONS, TRAJECTORY, WORK, Array, inner, until, void
from .memory import GROWTH, H_LIMIT, SAMPLES, STARTED, T_EVENT, T_SECTION, H
from .record import END, FIRED, TIME

PARTS = 2  # steps at least
BEGUN = 1e-2  # of a step: the first one again


@inner
def _resume(row, n_x, motion):
    """Begin at a coarse step's base point, as if the run had come here."""
    modes, work = TIME + 1 + n_x, TIME + 1 + n_x + len(motion.modes)
    for i in range(1 + n_x):
        motion.s[i] = row[TIME + i]
    for j in range(len(motion.modes)):
        motion.modes[j] = int(row[modes + j])
    for i in range(len(motion.work)):
        motion.work[i] = row[work + i]
    fired = int(row[FIRED])
    for g in range(len(motion.fired)):
        motion.fired[g], fired = fired % 4, fired // 4
    for i in range(len(motion.count)):
        motion.count[i] = 0
    for i in range(GROWTH):
        motion.real[i] = 0.0
    motion.count[STARTED], motion.real[H_LIMIT] = 1, inf
    motion.real[T_EVENT], motion.real[T_SECTION] = -inf, -inf
    motion.real[H] = BEGUN * (row[END] - row[TIME])


@inner
def retake(flow, functions, work, motion, options, steps, first):
    """Follow each coarse step again; samples from number first[d] on are within step d.

    The flow (flow.flow) comes as an address: joined to this loop, it would be compiled a second time.
    """
    for d in range(len(steps)):
        _resume(steps[d], options.n_q + options.n, motion)
        motion.count[SAMPLES] = first[d]
        end, h_max = steps[d, END], (steps[d, END] - steps[d, TIME]) / PARTS
        flow(functions, work, motion, until(options, end, h_max), None, None)


UNIT = {"retake": void(_flow.UNIT["flow"], FUNCTIONS, WORK, TRAJECTORY, OPTIONS, Array(axes=2), Array(INT))}
