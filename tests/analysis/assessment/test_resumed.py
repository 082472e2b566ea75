"""An assessment that its budget cut short, or that was killed, goes on where it was, to the last bit."""

import math
import signal
import time
from contextlib import contextmanager, suppress

import pytest

from jointplay.analysis.assessment import assess as assess_module
from jointplay.analysis.assessment import curves
from jointplay.analysis.assessment import settled as settled_module
from jointplay.analysis.assessment.page import page
from jointplay.jobs import worker
from jointplay.jobs.job import key_of
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.progress import OutOfTime, limited, tick
from tests.support.sweep_samples import bare, killed_after, loaded, ran, same

CHAOTIC = """\
kind = "assess"
name = "chaotic"

[mechanism]
catalog = "chunmei2002"
clearance = "0.29 mm"
gear_ratio = 3.0

[analysis]
along = ["joints.B.clearance"]
reach = 1.03
step = 0.001
turns = 4
transient = 10
lyapunov_turns = 40
"""
LEFT = int(Status.NOT_RUN)


@pytest.fixture(autouse=True)
def short_curves(monkeypatch):
    for module in (assess_module, curves):
        monkeypatch.setattr(module, "VALUES", 5)


@pytest.fixture
def counted(monkeypatch):
    """Keys of the motions that are settled along a parameter; a second is taken as one motion of a cell."""
    keys, left, settle = [], [math.inf], settled_module.settle

    @contextmanager
    def limited(motions):
        before, left[0] = left[0], motions
        try:
            yield
        finally:
            left[0] = before

    def noted(mechanism, start, how):
        if left[0] < 1:
            raise OutOfTime
        left[0] -= 1
        keys.extend([key_of(mechanism, start, repr(how))] * isinstance(how, settled_module.Remembering))
        return settle(mechanism, start, how)

    monkeypatch.setattr(settled_module, "settle", noted)
    monkeypatch.setattr(assess_module, "limited", limited)
    return keys


def left(dataset, name):
    return int((dataset[f"{name}_status"] == LEFT).sum())


def alike(one, other):
    return same(*(bare(each).drop_vars("preparation") for each in (one, other)))


def budget(seconds):
    return f"analysis.budget={seconds}"


@pytest.mark.nightly
def test_what_the_budget_cut_short_goes_on_where_it_was(tmp_path, counted):
    whole = ran(loaded(CHAOTIC, budget(1e6)), tmp_path / "whole")
    assert left(whole, "variant") == left(whole, "curve") == left(whole, "side") == 0
    once, counts, looked = [*counted], [], set()
    counted.clear()
    for more in range(20):
        found = ran(loaded(CHAOTIC, budget(1e-9 * (1 + more))), tmp_path / "cut")
        counts.append(tuple(left(found, name) for name in ("variant", "curve", "side")))
        looked.add(int(found["values_looked_at"].sum()))
        if not any(counts[-1]):
            break
        assert "not looked at" in page(found)
    assert counts[:2] == [(6, 5, 2), (6, 5, 2)]
    assert counts == sorted(counts, reverse=True)
    assert len(looked) > 2, "what is known of a side is shown though it was cut short"
    assert alike(found, whole)
    assert sorted(counted) == sorted(once), "no motion is settled twice"


@pytest.mark.nightly
def test_one_that_was_killed_goes_on_where_it_was(tmp_path, monkeypatch):
    whole = ran(loaded(CHAOTIC, budget(1e6)), tmp_path / "whole")
    monkeypatch.setattr(worker, "BATCH", 0.0)
    for count in (1, 2):
        cut = killed_after(count, lambda: ran(loaded(CHAOTIC, budget(1e6)), tmp_path / "cut"))
        assert cut == signal.SIGKILL
    assert alike(ran(loaded(CHAOTIC), tmp_path / "cut"), whole)


@pytest.mark.parametrize("earlier", [0, 1, 3])
def test_what_begins_anew_has_twice_as_long_in_each_later_run(monkeypatch, earlier):
    """Three cells that 30 s cut short, of which a journal holds what `earlier` runs came to."""
    limits = []

    def handed_out(function, asked, *rest, **more):
        limits.append(asked[0]["limit"])
        kept = {"at": 0.0} if len(limits) <= earlier else {}
        return [{"status": LEFT, "cpu": each["limit"], "at": math.inf} | kept for each in asked]

    monkeypatch.setattr(assess_module, "handed_out", handed_out)
    rounds = assess_module.Rounds(90.0, None, 1, 3)
    rounds.answers(assess_module.curved, [{}] * 3, {"status": 0})
    assert limits == [30.0 * 2**n for n in range(earlier + 1)]


def test_a_block_ends_when_its_time_is_used_up_and_no_other_does():
    with limited(1e3):
        with suppress(OutOfTime), limited(0.0):
            tick()
            pytest.fail("it had no time")
        tick()
    tick()


def test_progress_is_that_of_the_budget_where_this_is_used_up_sooner():
    said = []
    rounds = assess_module.Rounds(10.0, said.append, 1, 3)
    rounds.told(0.2)
    rounds.began, rounds.since, rounds.spent = time.time() - 8.0, time.time() - 4.0, 4.0
    rounds.told(0.2)
    rounds.told(0.9)
    rounds.since -= 3.0
    rounds.told(0.3)
    rounds.spent = 0.0  # what went before was known already: seven seconds of one processor
    rounds.told(0.3)
    assert said == pytest.approx([0.2, 0.8, 0.9, 1.0, 0.7], abs=0.01)
