"""Eligibility of motions for lanes: how one is followed, and why it may not go beside others.

Calls side by side: each as if it were alone, and the motions that all of them wait for followed at once.

An analysis asks for its motions one after another, from anywhere in its code. Beside others it runs in a
greenlet, which has a stack and a context of its own, in the thread of its caller: where it asks for a motion
it waits, and the next one goes on, always in the same order. When none can go on, the motions are followed
together (`batch`), as by an ensemble.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
from greenlet import getcurrent, greenlet

from jointplay.solver.codegen import lanes as ensemble
from jointplay.solver.equations.structure import Linkage, Oscillator
from jointplay.solver.mechanism.model import Model
from jointplay.solver.method.lanes import PHASE

FOLLOWED = "how the motion was followed"
RTOL = 1e-8  # sharper is for the method of higher order, one trajectory at a time
SAME = 1e-12  # of the last of several times: how far steps between them may differ that are even
ONE_BY_ONE, IN_LANES, LEFT = range(3)
# What a result says of a motion: not asked for in lanes, or too few; in lanes; begun there; what excludes it
ROUTES = ("one_by_one", "in_lanes", "left_lanes", *ensemble.EXCLUSIONS, "tolerance", "records", "exponents")

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
Question = tuple[Any, ...]


def route_of(exclusion: str) -> int:
    """Index in `ROUTES` for a motion that is not followed in lanes."""
    return ROUTES.index(exclusion) if exclusion else ONE_BY_ONE


def joined_route(first: int, then: int) -> int:
    """The route of a motion in two parts: in lanes if both are."""
    return then if first == IN_LANES else first


def exclusion(model: Model, request: Any) -> str:
    """Why a motion cannot be batched, a word of `ROUTES`; empty where it can be followed with others.

    The request is a trajectory.Request.
    """
    if found := structure_exclusion(model.structure):
        return found
    if not request.rtol >= RTOL:
        return "tolerance"
    return "" if _recorded(model, request) else "records"


@lru_cache(maxsize=256)
def structure_exclusion(structure: Linkage | Oscillator) -> str:
    """Why a structure cannot be batched."""
    return ensemble.exclusion(structure)


def _recorded(model: Model, request: Any) -> bool:
    """Whether lanes make the wanted records."""
    from jointplay.solver.method.lanes.radau import MAX_TURN

    longest = MAX_TURN if model.links else MAX_TURN / PHASE  # one section point in a step
    sampled = not (request.steps or request.rates) and _even(model, request, longest)
    ahead = (request.level - (model.crank_angle if model.links else 0.0)) * request.direction > 0
    section = request.direction == 0 or (ahead and request.period > longest)
    n = len(model.turning)
    scaled = not (model.links and np.any(model.relative[:n])) and bool(np.all(model.relative[n:] == 1.0))
    return sampled and section and scaled


def _even(model: Model, request: Any, longest: float) -> bool:
    """Whether samples are at the end alone, or of a test system at even times, as sections are."""
    at = request.at
    if len(at) < 2:
        return not len(at) or at[0] == request.duration
    far = np.diff(at, prepend=0.0) * math.tau / model.period > longest
    even = far.all() and np.ptp(np.diff(at)) < SAME * at[-1]
    return not model.links and request.direction == 0 and request.event < 0 and bool(even)


class _BatchedCall(greenlet):
    """A batched call: switched to, it goes on to its next question or its result, and gives that."""


def batched_answer(*question: Any) -> Any:
    """The answer to a question that a batched call puts; None where the call is alone."""
    here = getcurrent()
    return here.parent.switch(question) if isinstance(here, _BatchedCall) else None


def batchable(**wanted: Any) -> Callable[[F], F]:
    """Mark an analysis whose cells in a `[vary]` gain by batching, where its keywords are `wanted`."""

    def marked(analysis: F) -> F:
        analysis.batchable = wanted  # type: ignore[attr-defined]
        return analysis

    return marked


def batched(
    wanted: bool | None, call: Callable[[], T], answers: Callable[[list[Question]], Sequence[Any]]
) -> T:
    """Call alone or, where batching is wanted, as a batch of one."""
    alone = not wanted or isinstance(getcurrent(), _BatchedCall)
    return call() if alone else batch([call], answers)[0]


def batch(calls: Sequence[Callable[[], T]], answers: Callable[[list[Question]], Sequence[Any]]) -> list[T]:
    """Run calls side by side; `answers` gives the answers to all that they ask at once.

    Returns
    -------
    list
        What the calls give back, in order.

    Raises
    ------
    BaseException
        The first that a call or `answers` raised; calls that wait still end where they wait.
    """
    begun = [_BatchedCall(call) for call in calls]
    try:
        said = [each.switch() for each in begun]  # questions, and results in the end
        while waiting := [number for number, each in enumerate(begun) if not each.dead]:
            found = answers([said[number] for number in waiting])
            for number, answer in zip(waiting, found, strict=True):
                said[number] = begun[number].switch(answer)
        return said
    finally:
        for each in begun:
            each.throw()
