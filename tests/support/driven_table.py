"""Errors of derivatives in all parameters of a scene (tests.support.driven_scenes), by differences.

All parameters change at once, each by as much as moves the end of the motion as far as the others do, with a
sign of its own: an error in any of them is seen in the sum, whose fourth-order difference takes four runs.
As a program: `python -m tests.support.driven_table NAME …` prints them.
"""

from __future__ import annotations

import sys
import time
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.gradients.gradient import Run
from jointplay.analysis.gradients.selection import quantity
from jointplay.analysis.tangents import Bundle, scales
from jointplay.display.errors import InputError
from jointplay.solver.codegen import cache
from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.directions import Directions, along, stacked
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import NAMED, Parameter
from jointplay.solver.method.codes import Event
from jointplay.solver.motion.trajectory import Request
from tests.support.driven import distance, end, quotient
from tests.support.driven_scenes import LINKAGES, SYSTEMS

SHARES = (1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 1e-7, 1e-8)
ENOUGH = 3e-8
ROUGHLY = 1e-6  # a share of each parameter, by which its influence is judged
HARDLY = 1e-6  # a share of the largest influence, below which a parameter has none
RTOL = 1e-12


class Found(NamedTuple):
    """What a scene showed: its error, parameters that moved it, all of them, and its events."""

    error: float
    moving: int
    parameters: int
    events: list[str]


def keys(system: Any) -> list[str]:
    """All parameters of a system: numbers of its equations, or key paths of a linkage."""
    every = (each for each in Parameter.of(system) if each.smooth)
    return [each.key for each in every if each.key not in NAMED or each.paths == (each.key,)]


def directions(system: Any, start: Any) -> tuple[list[str], Any]:
    """Parameters that can change to both sides, and the directions of those."""
    found = {}
    for key in keys(system):
        try:
            found[key] = along(
                lambda v, key=key: assemble(system.varied({key: v}), start, powers=True),
                *(Parameter(system, key).value, key),
            )
        except InputError:
            continue
    return list(found), stacked(list(found.values()))


def combined(parts: Directions, weights: np.ndarray, model: Model) -> Directions:
    """One direction along which all parameters change, each by its weight: a third of the code of all."""
    rates = dict.fromkeys(cache.structure_module(model.structure).PARAMETERS, 0.0)
    for names, own, weight in zip(parts.names, parts.rates_of, weights, strict=True):
        for name, rate in zip(names, own, strict=True):
            rates[name] += weight * rate
    changed_names = {name for names in parts.names for name in names}
    moved = {name: rate for name, rate in rates.items() if name in changed_names}
    sums = ((weights @ each)[None] for each in (parts.starts, parts.begins, parts.periods))
    return Directions((tuple(moved),), np.array([*moved.values()]), *sums, np.ones(1), np.zeros(1))


def by_tangents(model: Model, direction: Directions, duration: float) -> np.ndarray:
    """Derivatives of the state and of the works, as `gradient` has them: by the balance at rigid walls."""
    bundle = Bundle(model, Request(duration, RTOL), np.zeros((0, len(model.state))), directions=direction)
    assert bundle.advance() == 0
    run = Run(model, direction, duration, 0.0, None, RTOL, rules.steps(None))
    works = run.quantities([quantity(f"work:{name}") for name in powers(model.structure)])[1]
    return np.append(bundle.vectors[0], works)


def error(system: Any, start: Any, duration: float, seed: int = 1) -> Found:
    """Error of the derivative along all parameters, of the best of several differences; NaN: none was fit."""
    model = assemble(system, start, powers=True)
    names, parts = directions(system, start)
    values, events = np.array([Parameter(system, key).value for key in names]), []

    def state(weights, at):
        changes = {
            key: float(v) for key, v, w in zip(names, values + at * weights, weights, strict=True) if w
        }
        reached, happened = end(assemble(system.varied(changes), start, powers=True), duration)
        events.append(happened)
        return reached

    singly = np.diag(parts.units)
    influences = np.array([(state(w, ROUGHLY) - state(w, -ROUGHLY)) / (2 * ROUGHLY) for w in singly])
    n_x = len(model.state)
    largest = np.abs(influences[:, n_x:]).max(initial=1e-300)
    unit = np.append(scales(model), np.full(influences.shape[1] - n_x, largest))
    moves = np.linalg.norm(influences / unit, axis=1)
    moving = moves > HARDLY * moves.max()
    sizes = np.minimum(np.quantile(moves[moving], 0.25) / np.where(moving, moves, np.inf), 1.0)
    signs = np.where(np.random.default_rng(seed).uniform(size=len(names)) < 0.5, -1.0, 1.0)
    weights, errors = sizes * parts.units * signs, []
    exact = by_tangents(model, combined(parts, weights, model), duration)
    for share in SHARES:
        events.clear()
        estimate = quotient(partial(state, weights), 0.0, share)
        if all(sorted(each) == sorted(events[0]) for each in events):
            errors.append(distance(exact, estimate, model))
        if min(errors, default=np.inf) < ENOUGH:
            break
    words = [Event(int(kind)).name.lower() for _, kind in events[0]]
    return Found(min(errors, default=np.nan), int(moving.sum()), len(names), words)


def scene(name: str) -> Found:
    """What a scene of the table shows."""
    if name in SYSTEMS:
        return error(*SYSTEMS[name])
    make, start, turns = LINKAGES[name]
    system = make()
    return error(system, start, turns * assemble(system, start).period)


if __name__ == "__main__":
    for name in sys.argv[1:] or (*SYSTEMS, *LINKAGES):
        began = time.process_time()
        try:
            *numbers, words = scene(name)
            kinds = {word: words.count(word) for word in dict.fromkeys(words)}
            print(name, *numbers, kinds, f"{time.process_time() - began:.1f} s", flush=True)
        except Exception as problem:
            print(name, "FAILED", repr(problem)[:300], flush=True)
