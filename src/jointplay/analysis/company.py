"""Calls side by side: each as if it were alone, and the motions that all of them wait for followed at once.

An analysis asks for its motions one after another, from anywhere in its code. Beside others it runs in a
thread of its own, one at a time and always in the same order: where it asks for a motion it waits, and the
next one goes on. When none can go on, the motions are followed together (`side_by_side`), as by an ensemble.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import Any, Generic, TypeVar

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])
Question = tuple[Any, ...]


class _DroppedError(BaseException):
    """Ends a call whose answer nobody waits for any more."""


class _Seat(threading.Thread, Generic[T]):
    """A call, and what it waits for."""

    def __init__(self, call: Callable[[], T]):
        super().__init__(daemon=True)
        self.call, self.question, self.answer = call, None, None
        self.result: T | None = None
        self.error: BaseException | None = None
        self.dropped = False
        self.mine, self.others = threading.Semaphore(0), threading.Semaphore(0)
        self.start()

    def run(self) -> None:
        """Call, once it is its turn."""
        self.mine.acquire()
        _seat.set(self)
        try:
            if not self.dropped:
                self.result = self.call()
        except _DroppedError:
            pass
        except BaseException as error:
            self.error = error
        self.others.release()

    def ask(self, question: Question) -> Any:
        """Wait for an answer, while others go on."""
        self.question = question
        self.others.release()
        self.mine.acquire()
        if self.dropped:
            raise _DroppedError
        return self.answer

    def go_on(self, answer: Any = None) -> None:
        """Give it its turn, until it asks, or has ended."""
        self.question, self.answer = None, answer
        self.mine.release()
        self.others.acquire()

    def drop(self) -> None:
        """Let it end."""
        self.dropped = True
        self.mine.release()


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
    seats = [_Seat(call) for call in calls]
    try:
        for seat in seats:
            seat.go_on()
        while waiting := [seat for seat in seats if seat.question is not None]:
            found = answers([seat.question for seat in waiting])
            for seat, answer in zip(waiting, found, strict=True):
                seat.go_on(answer)
    finally:
        for seat in seats:
            seat.drop()
    for seat in seats:
        if seat.error is not None:
            raise seat.error
    return [seat.result for seat in seats]
