"""Calls side by side: their order, answers and errors, and what becomes of those that nobody awaits."""

from __future__ import annotations

import threading
from contextvars import ContextVar

import pytest

from jointplay.solver.motion.company import asked, in_company, side_by_side


def call(name, questions, seen):
    """Ask some questions, one after another."""
    found = []
    for number in range(questions):
        seen.append(f"{name}{number}")
        found.append(asked(name, number))
    return found


def test_calls_wait_for_each_other_and_have_their_own_answers():
    seen, rounds = [], []

    def answers(questions):
        rounds.append(list(questions))
        return [f"{name}:{number}" for name, number in questions]

    names = {"a": 2, "b": 0, "c": 3}
    found = side_by_side([lambda n=n, k=k: call(n, k, seen) for n, k in names.items()], answers)
    assert found == [["a:0", "a:1"], [], ["c:0", "c:1", "c:2"]]
    assert rounds == [[("a", 0), ("c", 0)], [("a", 1), ("c", 1)], [("c", 2)]]
    assert seen == ["a0", "c0", "a1", "c1", "c2"]


def test_a_call_alone_has_no_answer():
    assert asked("a") is None
    assert call("a", 1, []) == [None]


def test_the_first_error_is_raised_when_all_have_ended():
    seen = []

    def wrong():
        asked("x")
        raise ValueError("wrong")

    with pytest.raises(ValueError, match="wrong"):
        side_by_side([lambda: call("a", 3, seen), wrong], lambda questions: [1] * len(questions))
    assert seen == ["a0", "a1", "a2"]


def test_calls_end_when_nobody_answers():
    before, ended = threading.active_count(), []

    def waits():
        try:
            asked("x")
        finally:
            ended.append(1)

    def stopped(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        side_by_side([waits, waits], stopped)
    for thread in threading.enumerate()[before:]:
        thread.join(5)
    assert ended == [1, 1]
    assert threading.active_count() == before


def test_calls_that_ask_for_nothing_share_a_thread():
    def asks():
        return asked("x") and threading.get_ident()

    calls = [threading.get_ident, threading.get_ident, asks, threading.get_ident, threading.get_ident]
    first, *others = side_by_side(calls, lambda questions: [1] * len(questions))
    assert others[:2] == [first, first]
    assert others[2] == others[3] != first
    assert first != threading.get_ident()


def test_what_a_call_sets_in_its_context_is_its_own():
    own = ContextVar("own", default=0)

    def count():
        own.set(own.get() + 1)
        return own.get()

    assert side_by_side([count, count], lambda questions: questions) == [1, 1]


def test_company_is_asked_for_once():
    """Within company there is no other."""
    count = []

    def answers(questions):
        count.append(len(questions))
        return [7] * len(questions)

    def inner():
        return in_company(True, lambda: asked("x"), answers)

    assert side_by_side([inner, inner], answers) == [7, 7]
    assert count == [2]
    assert in_company(True, lambda: asked("x"), answers) == 7
    assert in_company(None, lambda: asked("x"), answers) is None
