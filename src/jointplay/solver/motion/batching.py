"""Calls side by side: each as if it were alone, and the motions that all of them wait for followed at once.

An analysis asks for its motions one after another, from anywhere in its code. Beside others it runs in a
greenlet, which has a stack and a context of its own, in the thread of its caller: where it asks for a motion
it waits, and the next one goes on, always in the same order. When none can go on, the motions are followed
together (`batch`), as by an ensemble.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from greenlet import getcurrent, greenlet

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
Question = tuple[Any, ...]


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
