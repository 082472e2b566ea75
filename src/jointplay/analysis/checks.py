"""Checks of keywords, gathered: every problem at once, and the kinds of values that several analyses take."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from jointplay.errors import InputError, Problem


def together(*checks: Callable[[], Any]) -> None:
    """Run checks that raise `InputError`; raise one with the problems of all."""
    found: list[Problem] = []
    for check in checks:
        try:
            check()
        except InputError as error:
            found += error.problems
    if found:
        raise InputError(found)


def refused(problems: Iterator[Problem]) -> None:
    """Raise the problems, if there are any."""
    found = list(problems)
    if found:
        raise InputError(found)


def whole(key: str, value: Any, least: int) -> Iterator[Problem]:
    """Yield a problem where a value is no whole number of at least `least`."""
    if not (isinstance(value, int) and not isinstance(value, bool) and value >= least):
        yield Problem(key, value, f"a whole number, {least} or more, is accepted")


def share(key: str, value: Any) -> Iterator[Problem]:
    """Yield a problem where a value is no number from 0 to less than 1."""
    if not (isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < 1):
        yield Problem(key, value, "a number from 0 to less than 1 is accepted")
