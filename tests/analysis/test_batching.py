"""Calls side by side: their order, answers and errors, and what becomes of those that nobody awaits."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from functools import partial

import pytest

from jointplay.solver.motion.eligibility import batch, batched, batched_answer


def call(name, questions, seen):
    """Ask some questions, one after another."""
    found = []
    for number in range(questions):
        seen.append(f"{name}{number}")
        found.append(batched_answer(name, number))
    return found


def test_calls_wait_for_each_other_and_have_their_own_answers():
    seen, rounds = [], []

    def answers(questions):
        rounds.append(list(questions))
        return [f"{name}:{number}" for name, number in questions]

    names = {"a": 2, "b": 0, "c": 3}
    found = batch([lambda n=n, k=k: call(n, k, seen) for n, k in names.items()], answers)
    assert found == [["a:0", "a:1"], [], ["c:0", "c:1", "c:2"]]
    assert rounds == [[("a", 0), ("c", 0)], [("a", 1), ("c", 1)], [("c", 2)]]
    assert seen == ["a0", "c0", "a1", "c1", "c2"]


def test_a_call_alone_has_no_answer():
    assert batched_answer("a") is None
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
        batched_answer("x")
        raise error("wrong")

    with pytest.raises(error, match="wrong"):
        batch([waits, wrong, waits], lambda questions: [1] * len(questions))
    assert seen == ["a0", "a0", "a1"]
    assert ended == [1, 1]


def test_calls_end_when_nobody_answers():
    ended = []

    def waits():
        try:
            batched_answer("x")
        finally:
            ended.append(1)

    def stopped(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch([waits, waits], stopped)
    assert ended == [1, 1]


def test_calls_stay_in_the_thread_of_their_caller():
    """A signal's handler, as that of Ctrl-C, interrupts them themselves."""

    def asks():
        return batched_answer("x") and threading.get_ident()

    found = batch([threading.get_ident, asks, asks], lambda questions: [1] * len(questions))
    assert found == [threading.get_ident()] * 3


def test_threads_have_calls_of_their_own_beside_each_other():
    """As workers of a pool of threads: nothing that one of them asks comes to another."""
    meet = threading.Barrier(2, timeout=60)

    def answers(questions):
        meet.wait()
        return [(threading.get_ident(), *question) for question in questions]

    def run(name):
        own = threading.get_ident()
        found = batch([partial(call, name, 2, []), partial(call, name, 2, [])], answers)
        return found == [[(own, name, 0), (own, name, 1)]] * 2

    with ThreadPoolExecutor(2) as pool:
        assert [*pool.map(run, "ab")] == [True, True]


def test_what_a_call_sets_in_its_context_is_its_own():
    own = ContextVar("own", default=0)

    def count():
        own.set(own.get() + 1)
        batched_answer("x")
        return own.get()

    own.set(5)
    assert batch([count, count], lambda questions: questions) == [1, 1]
    assert own.get() == 5


def test_a_batch_within_a_batch_is_part_of_it():
    """A call in a batch that wants one of its own waits with the others."""
    count = []

    def answers(questions):
        count.append(len(questions))
        return [7] * len(questions)

    def inner():
        return batched(True, lambda: batched_answer("x"), answers)

    assert batch([inner, inner], answers) == [7, 7]
    assert count == [2]
    assert batched(True, lambda: batched_answer("x"), answers) == 7
    assert batched(None, lambda: batched_answer("x"), answers) is None
