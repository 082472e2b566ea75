"""Scenes that pay for one part each, and how a turn of them is measured.

Each changes one thing of the paper's mechanism at gear ratio 3.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from functools import partial
from statistics import median

import numpy as np

from jointplay.analysis.exponents.frame_growth import framed
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request, counts, functions, memory

SAMPLES = 720  # of a turn, where it is recorded


@dataclass(frozen=True)
class Part:
    """What a model has that the plain one has not."""

    changes: dict = field(default_factory=dict)
    recorded: bool = False
    powers: bool = False
    vectors: int | None = 0  # exponents; None: as many as the state has components


SCENES = {
    "plain": Part(),
    "free of friction": Part({"friction": 0.0}),
    "sticking (f = 0.3)": Part({"friction": 0.3}),
    "gravity off": Part({"gravity": 0.0}),
    "one elastic link": Part({"elastic": ("coupler",), "elements": 2}),
    "three elastic links": Part({"elastic": ("crank", "coupler", "rocker"), "elements": 2}),
    "recorded, 720 a turn": Part(recorded=True),
    "and its energy balance": Part(recorded=True, powers=True),
    "one exponent": Part(vectors=1),
    "all exponents": Part(vectors=None),
}


def measured(turns=40, rounds=7, rtol=1e-8):
    """Of each model, what a turn takes: counts, CPU time in µs, and that over the plain model's.

    All run in one process, taking turns: load comes and goes, and hits those of one round alike. Medians; a
    first run, which loads or compiles, is not timed.
    """
    runs = {name: prepared(part, turns, rtol) for name, part in SCENES.items()}
    found = {name: run()[1] for name, run in runs.items()}
    times = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            times[name].append(run()[0])
    return {name: _of_a_turn(found[name], times[name], times["plain"], turns) for name in runs}


def _of_a_turn(found, times, plain, turns):
    attempts = found["n_steps"] + found["n_rejected"] + found["n_failed"]
    whole = {"evaluations": found["n_evaluations"], "attempts": attempts, "events": found["n_events"]}
    ratios = [each / base for each, base in zip(times, plain, strict=True)]
    cost = {"CPU µs": 1e6 * median(times) / turns, "of plain": median(ratios)}
    return {name: number / turns for name, number in whole.items()} | cost


def prepared(part, turns, rtol):
    """A function that runs a model and gives CPU seconds and counts."""
    model = assemble(catalog.chunmei2002(gear_ratio=3.0, **part.changes), powers=part.powers)
    end, record = turns * model.period, {}
    if part.recorded:
        at = np.linspace(0.0, end, SAMPLES * turns + 1)
        record = {"at": at, "events": True, "log_from": 0.0}
    request = Request(end, rtol, **record)
    if part.vectors == 0:
        return partial(followed, model, request)
    return partial(with_tangents, model, request, part.vectors)


def followed(model, request):
    """A run of the flow."""
    from jointplay.solver.method.control import FULL, OK
    from jointplay.solver.method.memory import LOGGED

    compiled, run, (work, motion, options) = (
        functions(model.structure),
        cache.method("flow").flow,
        memory(model, request),
    )
    began, code = time.process_time(), FULL
    while code == FULL:
        code = run(compiled, work, motion, options, None, None)
        motion.count[LOGGED] = 0
    seconds = time.process_time() - began
    if code != OK:
        raise RuntimeError(f"the run ended with {code}")
    return seconds, counts(motion)


def with_tangents(model, request, vectors):
    """A run of the flow with that many exponents, None: all."""
    bundle = framed(model, request, vectors or len(model.state))
    began = time.process_time()
    while (status := bundle.advance()) == bundle.full:
        bundle.taken()
    seconds = time.process_time() - began
    if status:
        raise RuntimeError(f"the run ended with {status}")
    return seconds, counts(bundle.motion)
