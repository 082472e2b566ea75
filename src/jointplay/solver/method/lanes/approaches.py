"""Closest approaches of the lanes of an ensemble, compiled only where they are recorded."""

from ..interface import inner, options_at, trajectory_at, work_at
from ..record import closest_approaches
from . import layout as rows
from .exchange import gather, gather_guards, gather_step, signed
from .memory import PART


@inner
def approaches(functions, lanes, jobs, i):
    """Log closest approaches of open gaps in the step that is taken, up to its end (method.record)."""
    w, job = lanes.w, lanes.whole[8 * rows.JOB + i]
    work, options = work_at(jobs.work, 0), options_at(jobs.options, job)
    motion = trajectory_at(jobs.motions, job)
    gather(lanes, jobs, motion, i)
    gather_guards(lanes, work, options, len(motion.fired), i)
    gather_step(lanes, work, options, i)
    h = w[8 * rows.H + i]
    closest_approaches(work, motion, options, h, 1.0 + w[8 * rows.LATER + i] / h)
    signed(jobs, motion, job)


UNIT = {"approaches": PART}
