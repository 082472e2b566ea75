"""Studies of coexisting motions: kept, killed, in parts, with a value more, they are the same bit for bit."""

import signal
import tracemalloc

import numpy as np
import pytest

from jointplay.jobs import worker
from jointplay.jobs.journal import Journal
from jointplay.jobs.pool import Pool
from jointplay.results.answers.coexisting import attractors
from jointplay.results.store import open_result
from jointplay.study.execute import complete, merge
from jointplay.study.run import run
from tests.support.sweep_samples import KINDS, SLOW, die, forked, loaded, ran, same

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


def test_a_killed_study_goes_on_and_a_value_more_runs_alone(tmp_path, monkeypatch):
    whole = run(loaded(STUDY), jobs=1)
    assert same(ran(loaded(STUDY), tmp_path / "kept"), whole)
    assert same(open_result(tmp_path / "kept" / "coexisting.nc"), whole)
    cells = Journal(tmp_path / "kept" / JOURNAL).index().keys()
    monkeypatch.setattr(worker, "BATCH", 0.0)
    written, write_part = [], worker.write_part

    def fatal(*given):
        write_part(*given)
        written.append(1)
        if len(written) == 5:
            die()

    with monkeypatch.context() as patch:
        patch.setattr(worker, "write_part", fatal)
        assert forked(lambda: ran(loaded(STUDY), tmp_path / "killed")) == signal.SIGKILL
    assert len(Journal(tmp_path / "killed" / JOURNAL).index()) == 5
    assert same(ran(loaded(STUDY), tmp_path / "killed"), whole)
    ran(loaded(STUDY.replace("3.68]", "3.68, 3.72]")), tmp_path / "kept")
    more = Journal(tmp_path / "kept" / JOURNAL).index().keys() - cells
    assert cells <= Journal(tmp_path / "kept" / JOURNAL).index().keys()
    assert 0 < len(more) < len(cells)


@pytest.mark.parametrize("kind", [pytest.param(k, marks=pytest.mark.long) if k in SLOW else k for k in KINDS])
def test_parts_make_the_whole(kind, tmp_path):
    for number in (1, 2):
        complete(loaded(KINDS[kind]), tmp_path, Pool(1), share=(number, 2))
    assert same(merge(loaded(KINDS[kind]), tmp_path).dataset, run(loaded(KINDS[kind]), jobs=1))


@pytest.mark.long
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
    lines = attractors(found).splitlines()
    assert lines[0] == "2 motions, at most 2 beside each other (gap 3.6)"
    assert "period 1, from gap 3.6 to gap 3.68, up to 50 % of the starts" in lines[1]
