"""Sweeps that survive: killed, resumed, spread over workers, the result is the same bit for bit."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import cli
from jointplay.analysis import evaluate
from jointplay.analysis.sweeps import chains as chains
from jointplay.display.errors import InputError
from jointplay.jobs import worker
from jointplay.jobs.job import CRASHED, redone
from jointplay.jobs.journal import Journal
from jointplay.jobs.pool import Pool
from jointplay.study import execute
from jointplay.study.file import load, validate
from jointplay.study.results import store
from jointplay.study.run import compile_for, first_work, run
from tests.support.deadly import Deadly
from tests.support.sweep_samples import CELLS, CHAINS, bare, die, forked, loaded, ran, same

SHIPPED = Path(__file__).parents[2] / "studies"
STUDIES = {"cells": CELLS, "chains": CHAINS}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Datasets of runs that nothing disturbed."""
    out = tmp_path_factory.mktemp("whole")
    return {"out": out} | {name: ran(loaded(text), out) for name, text in STUDIES.items()}


@pytest.fixture
def log(tmp_path, monkeypatch):
    """What was begun, in this process and its copies: a line each."""
    path, begin = tmp_path / "log", worker.Notes.begin

    def noted(notes, key):
        with path.open("a") as file:
            file.write(f"{key}\n" if key else "")
        begin(notes, key)

    path.touch()
    monkeypatch.setattr(worker.Notes, "begin", noted)
    return path


def test_cells_are_the_analysis_by_itself(whole):
    found = whole["cells"]
    alone = jp.lyapunov(jp.catalog.impact_pair(3.0, 0.7), turns=5)
    cell = found.sel(gap=3.0, restitution=0.7)
    value = cell["lyapunov_exponent"]
    assert value.values.tobytes() == alone["lyapunov_exponent"].values.tobytes()
    assert value.attrs["units"] == alone["lyapunov_exponent"].attrs["units"]
    assert found.attrs["swept"] == "gap restitution"
    assert found["cell_status"].dims == ("gap", "restitution")
    assert not found["cell_status"].any()
    assert all("units" in found[name].attrs or "flag_values" in found[name].attrs for name in found.data_vars)


def test_chains_are_the_function(whole):
    keywords = loaded(CHAINS).record.keywords()
    direct = jp.bifurcation(jp.catalog.impact_pair(3.0, 0.8), **keywords, n_jobs=1)
    assert whole["chains"].assign_attrs(direct.attrs).identical(direct.assign_attrs(whole["chains"].attrs))


@pytest.mark.parametrize(("jobs", "backend"), [(2, "loky"), (2, "threading")])
def test_workers_do_not_show_in_the_result(jobs, backend, whole, tmp_path):
    for name, text in STUDIES.items():
        assert same(ran(loaded(text), tmp_path, jobs, backend), whole[name])


@pytest.mark.parametrize("name", STUDIES)
def test_the_order_of_cells_and_parts_does_not_show(name, whole, tmp_path, monkeypatch):
    def shuffled(jobs, _):
        return random.Random(5).sample(list(jobs), len(jobs))

    def backwards(journal):
        return sorted(journal.folder.glob("*.part"), reverse=True)

    monkeypatch.setattr(worker, "BATCH", 0.0)
    monkeypatch.setattr(execute, "part", shuffled)
    monkeypatch.setattr(Journal, "parts", backwards)
    assert same(ran(loaded(STUDIES[name]), tmp_path), whole[name])


@pytest.mark.long
@pytest.mark.parametrize("name", STUDIES)
@pytest.mark.parametrize("moment", ["begin 1", "put 1", "put 3", "put 5", "rename", "result", "compact"])
def test_a_killed_run_goes_on_where_it_was(name, moment, whole, tmp_path, monkeypatch, log):
    monkeypatch.setattr(worker, "BATCH", 0.0)  # each cell a part
    study, seen = loaded(STUDIES[name]), []

    def kill_at(place, attribute, count):
        original = getattr(place, attribute)

        def counted(*words, **options):
            found = None if attribute == "replace" else original(*words, **options)
            seen.append(1)
            if len(seen) == count:
                die()
            return original(*words, **options) if attribute == "replace" else found

        monkeypatch.setattr(place, attribute, counted)

    word, _, count = moment.partition(" ")
    places = {
        "begin": (worker.Notes, "begin", 1),
        "put": (worker.Notes, "put", int(count or 0)),
        "rename": (os, "replace", 4),
        "result": (store, "write_result", 1),
        "compact": (Journal, "compact", 1),
    }
    with monkeypatch.context() as patch:
        monkeypatch = patch
        kill_at(*places[word])
        assert forked(lambda: ran(study, tmp_path)) == signal.SIGKILL
    done = Journal(tmp_path / f"{name}.journal").index()
    log.write_text("")
    found = ran(study, tmp_path)
    begun = log.read_text().split()
    assert not set(begun) & done.keys()
    assert (
        len(begun) == len(set(begun)) == sum(len(s.keys) for s in first_work(study.record).jobs) - len(done)
    )
    assert len(done) == {"begin": 0, "put": int(count or 0), "rename": 2}.get(word, len(done) or -1)
    assert same(found, whole[name])
    assert same(store.open_result(tmp_path / f"{name}.nc"), store.open_result(whole["out"] / f"{name}.nc"))


@pytest.mark.parametrize("name", STUDIES)
def test_points_added_later_find_the_finished_ones(name, tmp_path, log):
    ran(loaded(STUDIES[name]), tmp_path)
    log.write_text("")
    more = loaded(STUDIES[name], "vary.gap=[2.9, 2.95, 3.0, 3.05, 3.1, 3.2]")
    found = ran(more, tmp_path)
    begun = log.read_text().split()
    assert len(begun) < found["cell_status"].size
    assert same(found, ran(more, tmp_path / "anew"))
    assert same(ran(loaded(STUDIES[name]), tmp_path), ran(loaded(STUDIES[name]), tmp_path / "anew"))


def test_a_damaged_part_costs_its_cells_only(whole, tmp_path, monkeypatch, log):
    monkeypatch.setattr(worker, "BATCH", 0.0)
    monkeypatch.setattr(Journal, "compact", lambda _: None)
    ran(loaded(CELLS), tmp_path)
    part = Journal(tmp_path / "cells.journal").parts()[2]
    part.write_bytes(part.read_bytes()[:-7])
    log.write_text("")
    said = []
    assert same(ran(loaded(CELLS), tmp_path, say=said.append), whole["cells"])
    assert len(log.read_text().split()) == 1
    assert any(part.name in line for line in said)


def test_a_cell_that_crashed_runs_again_and_what_follows_it_in_a_chain(whole, tmp_path, monkeypatch, log):
    settle = chains.settle

    def failing(mechanism, start, plan):
        if mechanism.parameters["gap"] == 3.0:
            raise MemoryError("by chance")
        return settle(mechanism, start, plan)

    with monkeypatch.context() as patch:
        patch.setattr(chains, "settle", failing)
        hurt = ran(loaded(CHAINS), tmp_path)
    assert (hurt["cell_status"].sel(gap=3.0) == CRASHED).all()
    assert (hurt["cell_status"] == 0).sum() == 9
    log.write_text("")
    assert same(ran(loaded(CHAINS), tmp_path), whole["chains"])
    assert len(log.read_text().split()) == 3 + 2 + 1  # up from 3.0, down from 3.0, reset that alone


@pytest.mark.parametrize(("carried", "again"), [(True, {"b", "c"}), (False, {"b"})])
def test_of_a_chain_what_follows_a_crashed_cell_is_not_called_done(carried, again):
    keys = ("a", "b", "c")
    strand = SimpleNamespace(keys=keys, chains=(keys,) if carried else ())
    assert redone([strand], {"a": 0, "b": CRASHED, "c": 0}) == again


def test_a_cell_that_fails_is_told_and_the_rest_goes_on(tmp_path, capsys):
    path = tmp_path / "cells.toml"
    path.write_text(CELLS.replace("turns = 5", "turns = 5\n[integrator]\nmax_steps = 3"))
    words = ["run", str(path), "--out", str(tmp_path), "--jobs", "1"]
    assert cli.main(words) == 1
    found = jp.open(tmp_path / "cells.nc")
    assert (found["cell_status"] == 2).all()
    assert "steps" in str(found["trouble"].values[0, 0])
    assert "step_limit" in capsys.readouterr().err


def test_values_that_fit_by_themselves_but_not_together_are_told_by_each_cell(tmp_path):
    text = CELLS[: CELLS.index("[mechanism]")] + (
        '[mechanism]\ncatalog = "chunmei2002"\n[vary]\ngear_ratio = [2.0, 3.0]\nspeed = [10.0]\n'
        "[analysis]\nturns = 5\n"
    )
    compile_for(loaded(text).record, [{"gear_ratio": 2.0, "speed": 10.0}])
    found = ran(loaded(text), tmp_path)
    assert found["cell_status"].all()
    assert all("only for a motor drive" in str(each) for each in found["trouble"].values.flat)


def test_a_cell_beyond_the_model_says_so_and_keeps_its_numbers(tmp_path, monkeypatch):
    text = (
        'kind = "response"\nname = "deep"\n[mechanism]\ncatalog = "chunmei2002"\ngear_ratio = 3.0\n'
        "[vary]\nclearance = [2.9e-4, 1e-4]\n[analysis]\nturns = 0.3\n"
    )
    monkeypatch.setattr(evaluate, "DEEP", 0.2)
    found, study = ran(loaded(text), tmp_path), loaded(text)
    deeper = jp.catalog.chunmei2002(gear_ratio=3.0, clearance=1e-4)
    with pytest.warns(jp.ModelWarning, match="clearances into its bearing"):
        alone = jp.simulate(deeper, turns=0.3)
    assert found["trouble"].values.tolist() == [alone.attrs["warning"], ""]
    assert not found["cell_status"].any()
    assert "warning" not in found.attrs
    numbers = found["journal_x"].sel(clearance=1e-4).values
    assert numbers[: len(alone["time"])].tobytes() == alone["journal_x"].values.tobytes()
    journal = execute.journal_of(tmp_path, study.record.name)
    kept = journal.load(first_work(study.record).jobs[i].keys[0] for i in range(2))
    assert len({answer["dataset"].layout for answer in kept.values()}) == 1


@pytest.mark.long
def test_a_worker_that_dies_costs_its_cell_a_second_try(tmp_path):
    log = str(tmp_path / "log")
    jobs = [Deadly(f"key{i}", {3: 1, 7: 2}.get(i, 0), log) for i in range(12)]
    said = []
    journal = Journal(tmp_path / "a.journal")
    with journal.held():
        Pool(2).run(jobs, journal, said.append)
    index = journal.index()
    assert len(index) == 12
    assert {key for key, status in index.items() if status} == {"key7"}
    assert index["key7"] == CRASHED
    assert any("crashed" in line for line in said)
    assert not list(journal.folder.glob("*.at"))


def test_a_full_disk_is_no_crashed_cell_and_no_half_result(tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(28, "No space left on device")

    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    monkeypatch.setattr(worker, "write_part", full)
    assert cli.main(["run", str(path), "--out", str(tmp_path), "--jobs", "1"]) == 1
    assert "No space left" in capsys.readouterr().err
    assert not (tmp_path / "cells.nc").exists()
    assert Journal(tmp_path / "cells.journal").index() == {}


@pytest.mark.parametrize("name", STUDIES)
def test_parts_put_together_are_the_whole(name, whole, tmp_path, capsys):
    path = tmp_path / f"{name}.toml"
    path.write_text(STUDIES[name])
    words = [str(path), "--out", str(tmp_path), "--no-figure"]
    assert cli.main(["run", *words, "--jobs", "1", "--part", "2/3"]) == 0
    assert cli.main(["merge", *words]) == 2
    assert "missing" in capsys.readouterr().err
    for share in ("1/3", "3/3"):
        assert cli.main(["run", *words, "--jobs", "1", "--part", share]) == 0
    assert not (tmp_path / f"{name}.nc").exists()
    assert cli.main(["merge", *words]) == 0
    assert same(store.open_result(tmp_path / f"{name}.nc"), store.open_result(whole["out"] / f"{name}.nc"))
    for share in ("0/3", "4/3", "1", "a/b"):
        assert cli.main(["run", *words, "--part", share]) == 2


@pytest.mark.nightly
def test_without_a_folder_a_study_gives_the_same(whole):
    assert same(run(loaded(CELLS)), whole["cells"])


@pytest.mark.nightly
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_stops_soon_and_says_how_to_go_on(tmp_path):
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    many = ["--set", "vary.gap={start=2.9, stop=3.1, num=40}", "analysis.turns=3000"]
    command = [sys.executable, "-m", "jointplay", "run", str(path), "--out", str(tmp_path), *many]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while len(Journal(tmp_path / "cells.journal").parts()) < 2:
            time.sleep(0.05)
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        said = process.communicate(timeout=60)[1]
        took = time.monotonic() - began
    assert process.returncode == 130, said
    assert "run the same command again to go on; what is finished is kept" in said
    assert "Traceback" not in said
    assert took < 30  # seconds on a busy machine; 2 are meant
    assert Journal(tmp_path / "cells.journal").index()


def test_cells_of_different_length_and_taken_names(tmp_path):
    text = """\
kind = "response"
name = "ragged"
[mechanism]
catalog = "chunmei2002"
clearance = 2.9e-4
gear_ratio = 3.0
[vary]
clearance = [2.9e-4, 3.5e-4]
[analysis]
turns = 1
steps = true
record = ["normal_force", "mode", "angle"]
"""
    found = ran(loaded(text), tmp_path)
    lengths = found["n_time"].values
    assert lengths[0] != lengths[1]
    for i, clearance in enumerate((2.9e-4, 3.5e-4)):
        mechanism = jp.catalog.chunmei2002(clearance=clearance, gear_ratio=3.0)
        alone = jp.simulate(mechanism, turns=1, steps=True, record=["normal_force", "mode", "angle"])
        taken = jp.cell(found, clearance=clearance).drop_vars(["status", "wall_time", "trouble"])
        assert bare(taken).identical(bare(alone.drop_vars(["status", "wall_time"])))
        cell, n = found.isel(clearance=i), alone.sizes["time"]
        assert n == lengths[i]
        assert np.array_equal(cell["normal_force"].values[:n], alone["normal_force"].values)
        assert np.array_equal(cell["cell_time"].values[:n], alone["time"].values)
        assert np.isnan(cell["normal_force"].values[n:]).all()
        assert (cell["mode"].values[n:] == -1).all()
        assert np.array_equal(cell["cell_clearance"], alone["clearance"])
        assert cell["angle"].sel(link="rocker").values[0] == alone["angle"].sel(link="rocker").values[0]
    with xr.open_dataset(tmp_path / "ragged.nc") as stored:
        assert stored["clearance"].attrs["units"] == "m"
        assert stored["cell_status"].attrs["flag_meanings"].startswith("ok ")


@pytest.mark.long
def test_a_journal_of_other_code_is_refused_by_the_command(tmp_path, capsys, monkeypatch):
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    words = ["run", str(path), "--out", str(tmp_path), "--jobs", "1"]
    assert cli.main(words) == 0
    monkeypatch.setattr("jointplay.jobs.origin.code", lambda: "another")
    assert cli.main(words) == 2
    assert "--fresh" in capsys.readouterr().err
    assert cli.main([*words, "--fresh"]) == 0
    assert execute.journal_of(tmp_path, "cells").header()["code"] == "another"


def test_dask_is_asked_for_by_its_address(tmp_path, capsys):
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    words = ["run", str(path), "--out", str(tmp_path)]
    assert cli.main([*words, "--backend", "dask"]) == 2
    assert "--" in capsys.readouterr().err
    assert cli.main([*words, "--scheduler", "tcp://localhost:1"]) == 2
    assert "--scheduler" in capsys.readouterr().err


def test_without_dask_it_is_said_how_to_install_it(tmp_path, capsys, monkeypatch):
    path = tmp_path / "cells.toml"
    path.write_text(CELLS)
    monkeypatch.setitem(sys.modules, "distributed", None)
    words = ["run", str(path), "--out", str(tmp_path), "--backend", "dask"]
    assert cli.main([*words, "--scheduler", "tcp://localhost:1"]) == 2
    assert "pip install distributed" in capsys.readouterr().err


@pytest.mark.parametrize("name", STUDIES)
def test_a_result_says_enough_to_run_it_again(name, whole, tmp_path):
    words = ["run", str(whole["out"] / f"{name}.nc"), "--out", str(tmp_path), "--jobs", "1", "--no-figure"]
    assert cli.main(words) == 0
    assert same(store.open_result(tmp_path / f"{name}.nc"), store.open_result(whole["out"] / f"{name}.nc"))
    (tmp_path / "none.nc").write_bytes((tmp_path / f"{name}.nc").read_bytes()[:100])
    assert cli.main(["run", str(tmp_path / "none.nc")]) == 2


@pytest.mark.long
@pytest.mark.parametrize("path", sorted(SHIPPED.rglob("*.toml")), ids=lambda path: path.stem)
def test_the_stored_study_is_the_study(path):
    record = load(path).record
    assert validate(json.loads(json.dumps(record.model_dump(mode="json")))) == record


def test_a_cell_of_a_sweep_is_drawn_by_itself(whole):
    with pytest.raises(InputError, match="restitution"):
        jp.figure(whole["cells"], kind="lyapunov")
    assert jp.figure(jp.cell(whole["cells"], gap=3.0, restitution=0.7)).axes
    with pytest.raises(InputError, match="each of gap, restitution"):
        jp.cell(whole["cells"], gap=3.0)
    with pytest.raises(InputError, match="sweep"):
        jp.cell(jp.lyapunov(jp.catalog.impact_pair(3.0, 0.7), turns=5), gap=3.0)


def test_a_cell_taken_out_is_the_analysis_by_itself(whole, tmp_path):
    alone = jp.lyapunov(jp.catalog.impact_pair(3.1, 0.7), turns=5).drop_vars("wall_time")
    cell = jp.cell(whole["cells"], gap=3.1001, restitution=0.7).drop_vars(["wall_time", "trouble"])
    assert (
        cell.drop_attrs(deep=False)
        .drop_vars("status")
        .identical(alone.drop_attrs(deep=False).drop_vars("status"))
    )
    assert int(cell["status"]) == 0
