"""The flow with steps of one length: every tolerance is loose but that of Newton's iteration."""

from __future__ import annotations

from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method import memory
from jointplay.solver.method.control import OK
from jointplay.solver.motion import trajectory

LOOSE = 1e3
NEWTON = 1e-14


def follow(system, duration, h, initial=None):
    """State at the end of a run in steps of length h (shorter ones before events), and its counts.

    The estimate of the error is divided by LOOSE, so that it never shortens a step; Newton's tolerance counts
    in the same units and is divided by it too.
    """
    model = assemble(system, initial)
    work, motion, options = trajectory.memory(model, trajectory.Request(duration, rtol=LOOSE))
    motion.real[memory.H] = h
    code = cache.method("flow").flow(
        trajectory.functions(model.structure),
        work,
        motion,
        options._replace(h_max=h, newton=NEWTON / LOOSE),
        None,
        None,
    )
    assert code == OK
    return motion.s[1 : 1 + len(motion.absolute)].copy(), motion.count[:5].tolist()
