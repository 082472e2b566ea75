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
from jointplay.solver.motion.eligibility import ROUTES
from jointplay.study import execute
from jointplay.study import run as study_run
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


@pytest.mark.nightly
def test_lanes_are_taken_where_motions_fill_them(whole):
    assert (whole.followed == 1).all()
    assert whole.followed.attrs["flag_meanings"].startswith("one_by_one in_lanes left_lanes")
    assert not ran_in_memory(FEW).followed.any()
    assert not ran_in_memory(MAP, "integrator.ensemble=false").followed.any()


def ran_in_memory(text, *changes):
    record = loaded(text, *changes).record
    return jp.bifurcation(record.mechanism, n_jobs=1, **record.keywords())


@pytest.mark.long
def test_chains_in_lanes_are_those_one_by_one(whole):
    alone = ran_in_memory(MAP, "integrator.ensemble=false")
    for name in ("cell_status", "impacts", "separations", "mode_word"):
        assert whole[name].values.tolist() == alone[name].values.tolist()
    assert np.allclose(whole.end_state, alone.end_state, rtol=1e-4, atol=1e-4)
    assert not np.array_equal(whole.end_state, alone.end_state)


def test_what_lanes_cannot_do_goes_one_by_one_and_says_so():
    found = ran_in_memory(MAP, "vary.clearance=[0, 2e-5, 3e-5]", "analysis.direction=['up']",
                          "vary.gear_ratio={start=2.9,stop=3.1,num=16}")  # fmt: skip
    assert {ROUTES[way] for way in found.followed.values[:, 0].ravel()} == {"no_clearance"}
    assert found.followed.values[:, 1:].min() == 1
    assert not found.cell_status.any()


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_neither_company_nor_workers_show(jobs, whole, tmp_path, monkeypatch):
    monkeypatch.setattr(chains, "ABREAST", 3)
    monkeypatch.setattr(chains, "TOGETHER", 2)
    monkeypatch.setattr(execute, "part", lambda queue, _: random.Random(jobs).sample(list(queue), len(queue)))
    assert same(ran(loaded(MAP), tmp_path, jobs), whole)


@pytest.mark.long
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


@pytest.mark.long
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


CELLS = """
kind = "KIND"
name = "cells"
[mechanism]
catalog = "chunmei2002"
gear_ratio = 3.0
[integrator]
rtol = 1e-6
ensemble = true
[vary]
clearance = [2.9e-5, 4e-5, 2.9e-4]
[analysis]
turns = 20
transient = 10
"""


@pytest.mark.parametrize("kind", ["section", pytest.param("lyapunov", marks=pytest.mark.nightly)])
def test_cells_of_a_vary_table_share_lanes(kind, tmp_path, monkeypatch):
    text, last = CELLS.replace("KIND", kind), 2
    text += 'record = ["journal_x"]' * (kind == "section")  # accelerations are not recorded in lanes
    found = ran(loaded(text), tmp_path / "together")
    assert found.followed.values.tolist() == [1, 1, 1]
    alone = ran(loaded(text, "integrator.ensemble=false"), tmp_path / "alone")
    assert alone.followed.values.tolist() == [0, 0, 0]
    if kind == "section":  # the last one is chaotic
        assert np.allclose(found.journal_x[:last], alone.journal_x[:last], atol=1e-7)
    else:
        apart = (found.section_exponent_per_turn - alone.section_exponent_per_turn).values[:, 0]
        error = np.hypot(*(each.section_standard_error_per_turn.values[:, 0] for each in (found, alone)))
        assert np.all(np.abs(apart) < 4 * error + 1e-3)
    monkeypatch.setattr(study_run, "TOGETHER", 1)
    assert same(ran(loaded(text), tmp_path / "single"), found)


def test_a_vary_table_chooses_lanes_where_cells_fill_them():
    many = "vary.clearance={start=2e-5,stop=3e-5,num=20}"
    whole = first_work(loaded(CELLS.replace("KIND", "section").replace("ensemble = true", ""), many).record)
    assert [len(job.keys) for job in whole.jobs] == [10, 10]
    text = CELLS.replace("KIND", "lyapunov").replace("ensemble = true", "")
    for change in ("analysis.exponents=2", "analysis.exponents='all'"):
        assert [len(job.keys) for job in first_work(loaded(text, many, change).record).jobs] == [10, 10]
    for change in ("analysis.error=0.1", "integrator.rtol=1e-10"):
        assert [len(job.keys) for job in first_work(loaded(text, many, change).record).jobs] == [1] * 20
    assert len({key for job in whole.jobs for key in job.keys}) == 20
