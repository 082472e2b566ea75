"""Closest approaches of the lanes of an ensemble, compiled only where they are recorded."""

from ..interface import inner, options_at, trajectory_at, work_at
from ..record import closest_approaches
from . import layout as rows
from .exchange import gather, gather_guards, gather_step, signed
from .memory import PART


@inner
def approaches(f, e, j, i):
    """Log closest approaches of open gaps in the step that is taken, up to its end (method.record)."""
    w, job = e.w, e.whole[8 * rows.JOB + i]
    k, x, o = work_at(j.k, 0), trajectory_at(j.x, job), options_at(j.o, job)
    gather(e, j, x, i)
    gather_guards(e, k, o, len(x.fired), i)
    gather_step(e, k, o, i)
    h = w[8 * rows.H + i]
    closest_approaches(k, x, o, h, 1.0 + w[8 * rows.LATER + i] / h)
    signed(j, x, job)


UNIT = {"approaches": PART}
