"""Calls side by side: their order, answers and errors, and what becomes of those that nobody awaits."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from functools import partial

import pytest

from jointplay.solver.motion.batching import asked, in_company, side_by_side


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


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_error_ends_all_calls(error):
    seen, ended = [], []

    def waits():
        try:
            call("a", 3, seen)
        finally:
            ended.append(1)

    def wrong():
        asked("x")
        raise error("wrong")

    with pytest.raises(error, match="wrong"):
        side_by_side([waits, wrong, waits], lambda questions: [1] * len(questions))
    assert seen == ["a0", "a0", "a1"]
    assert ended == [1, 1]


def test_calls_end_when_nobody_answers():
    ended = []

    def waits():
        try:
            asked("x")
        finally:
            ended.append(1)

    def stopped(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        side_by_side([waits, waits], stopped)
    assert ended == [1, 1]


def test_calls_stay_in_the_thread_of_their_caller():
    """A signal's handler, as that of Ctrl-C, interrupts them themselves."""

    def asks():
        return asked("x") and threading.get_ident()

    found = side_by_side([threading.get_ident, asks, asks], lambda questions: [1] * len(questions))
    assert found == [threading.get_ident()] * 3


def test_threads_have_calls_of_their_own_beside_each_other():
    """As workers of a pool of threads: nothing that one of them asks comes to another."""
    meet = threading.Barrier(2, timeout=60)

    def answers(questions):
        meet.wait()
        return [(threading.get_ident(), *question) for question in questions]

    def run(name):
        own = threading.get_ident()
        found = side_by_side([partial(call, name, 2, []), partial(call, name, 2, [])], answers)
        return found == [[(own, name, 0), (own, name, 1)]] * 2

    with ThreadPoolExecutor(2) as pool:
        assert [*pool.map(run, "ab")] == [True, True]


def test_what_a_call_sets_in_its_context_is_its_own():
    own = ContextVar("own", default=0)

    def count():
        own.set(own.get() + 1)
        asked("x")
        return own.get()

    own.set(5)
    assert side_by_side([count, count], lambda questions: questions) == [1, 1]
    assert own.get() == 5


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
