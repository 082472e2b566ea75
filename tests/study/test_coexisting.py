"""Studies of coexisting motions: kept, killed, in parts, with a value more, they are the same bit for bit."""

import random
import signal
import tracemalloc
from functools import wraps

import numpy as np
import pytest

from jointplay.analysis.coexisting import passes, tipping
from jointplay.analysis.coexisting.attractors import answer
from jointplay.jobs import worker
from jointplay.jobs.job import CRASHED
from jointplay.jobs.journal import Journal
from jointplay.jobs.pool import Pool
from jointplay.study import execute
from jointplay.study.execute import complete, merge
from jointplay.study.plan import plan, status
from jointplay.study.results.store import open_result
from jointplay.study.run import run
from tests.support.sweep_samples import KINDS, SLOW, die, forked, killed_after, loaded, ran, same

STUDY = """\
kind = "attractors"
name = "coexisting"

[mechanism]
catalog = "impact_pair"
gap = 3.6
restitution = 0.8

[vary]
gap = [3.6, 3.64, 3.68]

[analysis]
region.y = [-1.6, 1.6]
region.v = [-3.0, 3.0]
starts = 6
turns = 16
transient = 40
patience = 2
lyapunov_turns = 10
"""
JOURNAL = "coexisting.journal"


def some(kinds):
    """Kinds, of which the slow ones are long."""
    return [pytest.param(k, marks=pytest.mark.nightly) if k in SLOW else k for k in kinds]


@pytest.mark.nightly
def test_a_killed_study_goes_on_and_a_value_more_runs_alone(tmp_path, monkeypatch):
    whole = run(loaded(STUDY), jobs=1)
    assert same(ran(loaded(STUDY), tmp_path / "kept"), whole)
    assert same(open_result(tmp_path / "kept" / "coexisting.nc"), whole)
    cells = Journal(tmp_path / "kept" / JOURNAL).index().keys()
    monkeypatch.setattr(worker, "BATCH", 0.0)
    assert killed_after(5, lambda: ran(loaded(STUDY), tmp_path / "killed")) == signal.SIGKILL
    assert len(Journal(tmp_path / "killed" / JOURNAL).index()) == 5
    assert same(ran(loaded(STUDY), tmp_path / "killed"), whole)
    ran(loaded(STUDY.replace("3.68]", "3.68, 3.72]")), tmp_path / "kept")
    more = Journal(tmp_path / "kept" / JOURNAL).index().keys() - cells
    assert cells <= Journal(tmp_path / "kept" / JOURNAL).index().keys()
    assert 0 < len(more) < len(cells)


@pytest.mark.nightly
@pytest.mark.parametrize("kind", some(KINDS))
def test_parts_make_the_whole(kind, tmp_path):
    for number in (1, 2):
        complete(loaded(KINDS[kind]), tmp_path, Pool(1), share=(number, 2))
    assert same(merge(loaded(KINDS[kind]), tmp_path).dataset, run(loaded(KINDS[kind]), jobs=1))


@pytest.mark.nightly
@pytest.mark.parametrize("kind", ["attractors", "covariant", "tipping"])
def test_neither_workers_nor_the_order_of_cells_and_parts_show(kind, tmp_path, monkeypatch):
    def shuffled(jobs, _):
        return random.Random(5).sample(list(jobs), len(jobs))

    whole, parts = run(loaded(KINDS[kind]), jobs=1), Journal.parts
    monkeypatch.setattr(worker, "BATCH", 0.0)
    monkeypatch.setattr(execute, "part", shuffled)
    monkeypatch.setattr(Journal, "parts", lambda journal: parts(journal)[::-1])
    assert same(ran(loaded(KINDS[kind]), tmp_path, jobs=2), whole)


@pytest.mark.nightly
@pytest.mark.parametrize("kind", some(["covariant", "tipping"]))
def test_a_kill_between_two_cells_costs_neither(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(worker, "BATCH", 0.0)
    began, begin = [], worker.Notes.begin

    def noted(notes, key):
        began.append(key)
        if len(began) == 3:
            die()
        begin(notes, key)

    with monkeypatch.context() as patch:
        patch.setattr(worker.Notes, "begin", noted)
        assert forked(lambda: ran(loaded(KINDS[kind]), tmp_path)) == signal.SIGKILL
        done = Journal(tmp_path / f"{kind}.journal").index()
        assert len(done) == 2
        began += [""] * 3  # so that none is fatal
        found = ran(loaded(KINDS[kind]), tmp_path)
    cells = Journal(tmp_path / f"{kind}.journal").index().keys()
    assert sorted(began[3:]) == sorted(cells - done.keys())
    assert same(found, run(loaded(KINDS[kind]), jobs=1))


@pytest.mark.parametrize("kind", some(["attractors", "tipping"]))
def test_a_cell_that_crashed_runs_again_though_others_follow_from_it(kind, tmp_path, monkeypatch):
    place, name = {"attractors": (passes, "found"), "tipping": (tipping, "knocked")}[kind]
    real, calls = getattr(place, name), []

    @wraps(real)
    def failing(*given, **cell):
        calls.append(1)
        if len(calls) == 2:
            raise MemoryError("by chance")
        return real(*given, **cell)

    with monkeypatch.context() as patch:
        patch.setattr(place, name, failing)
        hurt = ran(loaded(KINDS[kind]), tmp_path)
    assert [*Journal(tmp_path / f"{kind}.journal").index().values()].count(CRASHED) == 1
    whole = run(loaded(KINDS[kind]), jobs=1)
    assert not same(hurt, whole)
    assert same(ran(loaded(KINDS[kind]), tmp_path), whole)


def test_what_follows_from_the_first_cells_is_told_and_not_called_others(tmp_path, monkeypatch):
    study, given, call = loaded(STUDY), [], execute._Journaled.__call__
    follow = "more may follow from what these find"
    assert f"follow   {follow}, which are not estimated here" in [*plan(study, tmp_path, 1)]

    def stopped(journaled, work):
        given.append(work)
        if len(given) == 2:
            raise KeyboardInterrupt
        return call(journaled, work)

    with monkeypatch.context() as patch:
        patch.setattr(execute._Journaled, "__call__", stopped)
        with pytest.raises(KeyboardInterrupt):
            ran(study, tmp_path)
    assert next(iter(status(study, tmp_path))) == f"cells    3 of 3 finished; {follow}"
    said = []
    for _ in range(2):
        ran(study, tmp_path, say=said.append)
    assert next(iter(status(study, tmp_path))) == "cells    3 of 3 finished"
    assert not any("other values" in line for line in said)
    ran(loaded(STUDY, "analysis.starts=5"), tmp_path, say=said.append, fresh=False)
    assert said[-1].endswith("cells of other values or settings are kept; --fresh drops them")


@pytest.mark.nightly
@pytest.mark.parametrize(("kind", "most"), [("covariant", 16e3), ("attractors", 96e3)])
def test_a_cell_more_costs_little_memory(kind, most, tmp_path):
    """Bytes a cell: 6 kB of `covariant`, 59 kB of `attractors`, which keeps the points of all motions."""
    peaks = []
    for count in (1, 4, 12):  # the first for what is loaded once
        study = loaded(
            KINDS[kind], f"vary.gap={{start=3.4, stop=3.8, num={count}}}" if count > 1 else "vary.gap=[3.6]"
        )
        tracemalloc.start()
        ran(study, tmp_path / str(count))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[2] - peaks[1] < 8 * most


def test_the_answer_is_in_words():
    found = run(loaded(STUDY), jobs=1)
    assert np.isfinite(found["fraction"].values).any()
    lines = answer(found).splitlines()
    assert lines[0] == "2 motions, of which at most 2 coexist (gap 3.6)"
    assert "period 1, from gap 3.6 to gap 3.68, up to 50 % of the starts" in lines[1]
