"""Calls side by side: each as if it were alone, and the motions that all of them wait for followed at once.

An analysis asks for its motions one after another, from anywhere in its code. Beside others it runs in a
thread, one at a time and always in the same order: where it asks for a motion it waits, its thread with it,
and the next one goes on in another. When none can go on, the motions are followed together (`side_by_side`),
as by an ensemble. Calls that ask for nothing share a thread.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextvars import Context, ContextVar
from queue import SimpleQueue
from typing import Any, TypeVar

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
Question = tuple[Any, ...]


class _DroppedError(BaseException):
    """Ends a call whose answer nobody waits for any more."""


class _Seat(threading.Thread):
    """Makes calls one after the other, until one asks; what that waits for.

    `left` numbers calls that nobody has begun; by these numbers, results and errors are kept.
    """

    def __init__(self, left: Iterator[tuple[int, Callable[[], Any]]], results: dict, errors: dict):
        super().__init__(daemon=True)
        self.left, self.results, self.errors = left, results, errors
        self.question: Question | None = None
        self.asked = self.dropped = False
        self.mine, self.others = SimpleQueue(), SimpleQueue()  # faster than semaphores
        self.start()

    def run(self) -> None:
        """Call, once it is its turn."""
        self.mine.get()
        while not (self.asked or self.dropped) and (each := next(self.left, None)):
            number, call = each
            try:
                self.results[number] = Context().run(self._called, call)
            except _DroppedError:
                pass
            except BaseException as error:
                self.errors[number] = error
        self.others.put(None)

    def _called(self, call: Callable[[], Any]) -> Any:
        _seat.set(self)
        return call()

    def ask(self, question: Question) -> Any:
        """Wait for an answer, while others go on."""
        self.question, self.asked = question, True
        self.others.put(None)
        answer = self.mine.get()
        if self.dropped:
            raise _DroppedError
        return answer

    def go_on(self, answer: Any = None) -> None:
        """Give it its turn, until it asks, or has ended."""
        self.question = None
        self.mine.put(answer)
        self.others.get()

    def drop(self) -> None:
        """Let it end."""
        self.dropped = True
        self.mine.put(None)


_seat: ContextVar[_Seat | None] = ContextVar("seat", default=None)


def asked(*question: Any) -> Any:
    """The answer to a question that a call beside others asks; None where it is alone."""
    return None if (seat := _seat.get()) is None else seat.ask(question)


def beside(**wanted: Any) -> Callable[[F], F]:
    """Mark an analysis whose cells in a `[vary]` gain by company, where its keywords are those `wanted`."""

    def marked(analysis: F) -> F:
        analysis.beside = wanted  # type: ignore[attr-defined]
        return analysis

    return marked


def in_company(
    asked: bool | None, call: Callable[[], T], answers: Callable[[list[Question]], Sequence[Any]]
) -> T:
    """Call; where it is `asked` for, as if others were beside it."""
    alone = not asked or _seat.get() is not None
    return call() if alone else side_by_side([call], answers)[0]


def side_by_side(
    calls: Sequence[Callable[[], T]], answers: Callable[[list[Question]], Sequence[Any]]
) -> list[T]:
    """Run calls side by side; `answers` gives the answers to all that they ask at once.

    Returns
    -------
    list
        What the calls give back, in order.

    Raises
    ------
    BaseException
        What the first call raised that raised anything.
    """
    left, results, errors, seats = iter(enumerate(calls)), {}, {}, []
    try:
        while not seats or seats[-1].asked:
            seats.append(_Seat(left, results, errors))
            seats[-1].go_on()
        while waiting := [seat for seat in seats if seat.question is not None]:
            found = answers([seat.question for seat in waiting])
            for seat, answer in zip(waiting, found, strict=True):
                seat.go_on(answer)
    finally:
        for seat in seats:
            seat.drop()
    if errors:
        raise errors[min(errors)]
    return [results[number] for number in range(len(calls))]
