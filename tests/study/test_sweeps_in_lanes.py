"""Chains side by side in lanes: chosen by the program, as one by one, and resumed bit for bit."""

from __future__ import annotations

import random
import signal

import numpy as np
import pytest

import jointplay as jp
from jointplay import cli
from jointplay.analysis.sweeps import chains
from jointplay.jobs import worker
from jointplay.jobs.job import CRASHED, redone, remaining
from jointplay.jobs.journal import Journal
from jointplay.study import execute
from jointplay.study.run import first_work
from tests.support.sweep_samples import die, forked, loaded, ran, same

MAP = """
kind = "bifurcation"
name = "map"
[mechanism]
catalog = "chunmei2002"
[integrator]
rtol = 1e-5
[vary]
gear_ratio = { start = 2.9, stop = 3.1, num = 8 }
clearance = [2e-5, 3e-5, 4.5e-5]
[analysis]
direction = ["up", "down", "reset"]
turns = 4
transient = 3
"""
FEW = MAP.replace("num = 8", "num = 2")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The dataset of a run that nothing disturbed."""
    return ran(loaded(MAP), tmp_path_factory.mktemp("whole"))


def test_lanes_are_taken_where_motions_fill_them(whole):
    assert (whole.followed == 1).all()
    assert whole.followed.attrs["flag_meanings"] == "one_by_one in_lanes"
    assert not ran_in_memory(FEW).followed.any()
    assert not ran_in_memory(MAP, "integrator.ensemble=false").followed.any()


def ran_in_memory(text, *changes):
    record = loaded(text, *changes).record
    return jp.bifurcation(record.mechanism, n_jobs=1, **record.keywords())


def test_chains_in_lanes_are_those_one_by_one(whole):
    alone = ran_in_memory(MAP, "integrator.ensemble=false")
    for name in ("cell_status", "impacts", "separations", "mode_word"):
        assert whole[name].values.tolist() == alone[name].values.tolist()
    assert np.allclose(whole.end_state, alone.end_state, rtol=1e-4, atol=1e-4)
    assert not np.array_equal(whole.end_state, alone.end_state)


def test_what_lanes_cannot_do_goes_one_by_one_and_says_so():
    found = ran_in_memory(MAP, "vary.clearance=[0, 2e-5, 3e-5]", "analysis.direction=['up']",
                          "vary.gear_ratio={start=2.9,stop=3.1,num=16}")  # fmt: skip
    assert found.followed.values[:, 0].max() == 0
    assert found.followed.values[:, 1:].min() == 1
    assert not found.cell_status.any()


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.long)])
def test_neither_company_nor_workers_show(jobs, whole, tmp_path, monkeypatch):
    monkeypatch.setattr(chains, "ABREAST", 3)
    monkeypatch.setattr(chains, "TOGETHER", 2)
    monkeypatch.setattr(execute, "part", lambda queue, _: random.Random(jobs).sample(list(queue), len(queue)))
    assert same(ran(loaded(MAP), tmp_path, jobs), whole)


@pytest.mark.parametrize("count", [1, 17, 40])
def test_a_killed_run_goes_on_where_it_was(count, whole, tmp_path, monkeypatch):
    study, seen, put = loaded(MAP), [], worker.Notes.put
    monkeypatch.setattr(worker, "BATCH", 0.0)  # each cell a part

    def counted(*words):
        put(*words)
        seen.append(1)
        if len(seen) == count:
            die()

    with monkeypatch.context() as patch:
        patch.setattr(worker.Notes, "put", counted)
        assert forked(lambda: ran(study, tmp_path)) == signal.SIGKILL
    done = Journal(tmp_path / "map.journal").index()
    assert len(done) == count
    rest = remaining(first_work(study.record).jobs, done, {})
    assert sum(len(job.keys) for job in rest) == 72 - count
    assert same(ran(study, tmp_path), whole)


def test_parts_make_the_whole(whole, tmp_path):
    (tmp_path / "map.toml").write_text(MAP)
    words = ["run", str(tmp_path / "map.toml"), "--out", str(tmp_path), "--jobs", "1", "--no-figure"]
    for share in ("1/2", "2/2"):
        assert cli.main([*words, "--part", share]) == 0
    assert same(ran(loaded(MAP), tmp_path), whole)


def test_of_several_chains_each_goes_on_by_itself():
    jobs = first_work(loaded(MAP).record).jobs
    side = next(job for job in jobs if job.chains)
    first, second = side.chains[:2]
    crashed = dict.fromkeys([*first, *second], 0) | {first[0]: CRASHED}
    assert redone([side], crashed) == {*first}
    alone = side.only(second[1])
    assert alone.keys == second[:2]
