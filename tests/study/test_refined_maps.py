"""Adaptive maps as studies: killed, resumed, by one worker or two, the same; beside the whole map."""

import signal

import numpy as np
import pytest

import jointplay as jp
from jointplay import cli
from jointplay.analysis.sweeps import chains
from jointplay.jobs import worker
from jointplay.jobs.job import CRASHED
from jointplay.jobs.journal import Journal
from jointplay.study.plan import plan, status
from tests.support.sweep_samples import die, forked, loaded, ran, same
from tests.support.wrong import problems_of

MAP = """\
kind = "bifurcation"
name = "map"

[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.8

[vary]
gap = { start = 1.0, stop = 9.0, num = 9 }
restitution = { start = 0.7, stop = 0.86, num = 9 }

[analysis]
turns = 12
transient = 30
direction = "reset"
initial = [0.05, 0.7]
keep = 1
refine = 2

[integrator]
ensemble = false
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    out = tmp_path_factory.mktemp("map")
    return out, ran(loaded(MAP), out)


def begun(monkeypatch, act=lambda number: None):
    """Keys of the cells that begin; `act` is called with how many there are."""
    keys, begin = [], worker.Notes.begin

    def noted(notes, key):
        if key:
            keys.append(key)
            act(len(keys))
        begin(notes, key)

    monkeypatch.setattr(worker.Notes, "begin", noted)
    return keys


@pytest.mark.long
def test_computed_points_are_those_of_the_whole_map(whole, tmp_path):
    out, found = whole
    everywhere = ran(loaded(MAP, "analysis.refine=0"), tmp_path)
    done = found["computed"] == 1
    assert 30 < int(done.sum()) < 75
    assert (found["computed"].dims, found["refinement_level"].dims) == (("gap", "restitution"),) * 2
    for name in ("period", "impacts", "end_state", "n_steps"):
        left, right = (each[name].where(done) for each in (found, everywhere))
        assert left.equals(right), name
    assert float((found["period"] != everywhere["period"]).where(~done, 0).mean()) < 0.1
    assert f"{int(done.sum())} of 81 values computed" in str(jp.summary(found)).splitlines()[-1]
    assert "computed" not in everywhere
    assert found.equals(jp.open(out / "map.nc"))


@pytest.mark.parametrize("count", [pytest.param(3, marks=pytest.mark.nightly), 30])
def test_a_killed_map_goes_on_where_it_was(count, whole, tmp_path, monkeypatch):
    """In the first round, or in a later one."""
    monkeypatch.setattr(worker, "BATCH", 0.0)

    def kill(number):
        if number == count:
            die()

    with monkeypatch.context() as patch:
        begun(patch, kill)
        assert forked(lambda: ran(loaded(MAP), tmp_path)) == signal.SIGKILL
    done = Journal(tmp_path / "map.journal").index()
    assert len(done) == count - 1
    said, lines = begun(monkeypatch), []
    assert same(ran(loaded(MAP), tmp_path, say=lines.append), whole[1])
    assert not set(said) & done.keys()
    assert len(said) == len(set(said)) == int(whole[1]["computed"].sum()) - len(done)
    assert not any("other values or settings" in line for line in lines)


def test_a_cell_that_crashed_in_the_first_round_runs_again(whole, tmp_path, monkeypatch):
    def failing(mechanism, start, plan):
        if mechanism.parameters == {"gap": 5.0, "restitution": 0.78}:
            raise MemoryError("by chance")
        return settle(mechanism, start, plan)

    settle = chains.settle
    with monkeypatch.context() as patch:
        patch.setattr(chains, "settle", failing)
        hurt = ran(loaded(MAP), tmp_path)
    assert int(hurt["cell_status"].sel(gap=5.0, restitution=0.78, method="nearest").item()) == CRASHED
    assert same(ran(loaded(MAP), tmp_path), whole[1])


@pytest.mark.nightly
def test_the_whole_map_goes_on_from_an_adaptive_one(whole, tmp_path, monkeypatch):
    ran(loaded(MAP), tmp_path)
    keys = begun(monkeypatch)
    ran(loaded(MAP, "analysis.refine=0"), tmp_path)
    assert len(keys) == 81 - int(whole[1]["computed"].sum())


@pytest.mark.nightly
def test_workers_do_not_show(whole, tmp_path):
    assert same(ran(loaded(MAP), tmp_path, jobs=2), whole[1])


def test_plan_and_status_say_what_they_know(whole, tmp_path):
    lines = "\n".join(plan(loaded(MAP), tmp_path, 1))
    assert "cells    9" in lines
    assert "where these differ more follow, up to 81" in lines
    done = int(whole[1]["computed"].sum())
    assert next(iter(status(loaded(MAP), whole[0]))) == f"cells    {done} finished"


def test_parts_and_chains_are_refused(tmp_path, capsys):
    path = tmp_path / "map.toml"
    path.write_text(MAP)
    for words in (["run", str(path), "--part", "1/2", "--jobs", "1"], ["merge", str(path)]):
        assert cli.main([*words, "--out", str(tmp_path), "--no-figure"]) == 2
        assert "whose cells are known before it runs" in capsys.readouterr().err
    for change, key in (("direction='up'", "refine"), ("refine=-1", "refine"), ("contrast=-1", "contrast")):
        assert list(problems_of(loaded, MAP, f"analysis.{change}")) == [f"analysis.{key}"]


@pytest.mark.nightly
def test_few_values_differ_from_the_whole_map():
    """Impact pair, 49 x 33: what is computed is the same, of the rest 97 of 100 have the same period."""
    over = {"gap": np.linspace(0.2, 12.0, 49).tolist(), "restitution": np.linspace(0.6, 0.9, 33).tolist()}
    run = {"direction": "reset", "turns": 40, "transient": 150, "exponents": 1, "lyapunov_turns": 20}
    run |= {"initial": (0.05, 0.7), "over": over, "keep": 1}
    found, everywhere = (jp.bifurcation(jp.catalog.impact_pair(1.0, 0.8), refine=n, **run) for n in (4, 0))
    done = (found["computed"] == 1).values
    assert done.mean() < 0.75
    for name in ("period", "section_exponent_per_turn", "impacts"):
        left, right = (each[name].transpose("gap", "restitution", ...).values for each in (found, everywhere))
        np.testing.assert_array_equal(left[done], right[done])
    differ = (found["period"] != everywhere["period"]).values[..., 0]
    assert differ[~done].mean() < 0.03
