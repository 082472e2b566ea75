"""Ctrl-C in every stage of a run: it ends soon, what was computed is kept, and nothing hangs or is lost."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from jointplay import figures
from jointplay.analysis import declared, evaluate
from jointplay.analysis.sweeps import gather
from jointplay.cli import main
from jointplay.jobs import interrupts
from jointplay.solver.motion import progress
from jointplay.study.results import provenance, store
from jointplay.study.results.outcome import name_of
from tests.support.study_samples import SOFT

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
resource = pytest.importorskip("resource")
LENGTH = "turns = 40\nsamples_per_turn = 250\n"


def press():
    os.kill(os.getpid(), signal.SIGINT)


def pressing(monkeypatch, place, name, at=1, counts=lambda *_, **__: True):
    """Make a function press Ctrl-C as it begins its so many-th call that counts."""
    before, calls = getattr(place, name), []

    def pressed(*arguments, **keywords):
        if counts(*arguments, **keywords):
            calls.append(name)
            if len(calls) == at:
                press()
        return before(*arguments, **keywords)

    monkeypatch.setattr(place, name, pressed)
    return calls


@pytest.fixture
def study(tmp_path):
    """A motion of 10 000 samples."""
    (tmp_path / "one.toml").write_text(f'kind = "response"\n\n{SOFT}{LENGTH}')
    return ["run", str(tmp_path / "one.toml"), "--out", str(tmp_path)]


def files(tmp_path):
    return {path.name for path in tmp_path.iterdir()} - {"one.toml"}


@pytest.mark.parametrize("at", [2, 4])
def test_in_the_evaluation_the_motion_is_kept(study, tmp_path, monkeypatch, capfd, at):
    monkeypatch.setattr(evaluate, "BLOCK", 1000)
    monkeypatch.setattr(evaluate, "MOST", 2000)
    pressing(monkeypatch, evaluate.Quantities, "given", at, lambda _, rows: len(rows) == 1000)
    assert main(study) == 130
    found = store.open_result(tmp_path / "one.partial.nc")
    assert name_of(found) == "interrupted"
    assert found.sizes["time"] == 1667
    assert float(found.time[-1]) > 0.999 * 40 * float(found.turn_period_nominal)
    assert found.attrs["partial"] == "1 in 6 of what was computed along time"
    assert files(tmp_path) == {"one.partial.nc"}
    assert "interrupted: run the same command again to start over" in capfd.readouterr().err


def test_of_windows_each_kept_sample_has_its_own(study, tmp_path, monkeypatch):
    monkeypatch.setattr(evaluate, "BLOCK", 1000)
    monkeypatch.setattr(evaluate, "MOST", 100)
    pressing(monkeypatch, evaluate.Quantities, "given", 2, lambda _, rows: len(rows) == 1000)
    assert main([*study, "--set", "analysis.windows=[[1, 5], [20, 29]]"]) == 130
    found = store.open_result(tmp_path / "one.partial.nc")
    turns = found.time / found.turn_period_nominal
    assert found.sizes["time"] <= 100
    np.testing.assert_array_equal(found.window, turns.values > 10)


LAST = {
    "as all is computed": (declared, "on_joints"),
    "as its origin is noted": (provenance, "attach"),
    "as it is stored": (store, "_fill"),
    "as it is drawn": (figures, "draw"),
}


@pytest.mark.parametrize(("place", "name"), LAST.values(), ids=LAST)
def test_a_result_that_is_there_or_nearly_is_stored(study, tmp_path, monkeypatch, capfd, place, name):
    assert pressing(monkeypatch, place, name) == []
    assert main(study) == 130
    assert files(tmp_path) == {"one.nc"}
    assert name_of(store.open_result(tmp_path / "one.nc")) == "ok"
    said = capfd.readouterr().err
    assert f"interrupted: the result is stored; `jointplay figure {tmp_path / 'one.nc'}` draws it" in said
    assert "run the same command" not in said


def test_of_a_result_that_would_take_long_to_store_a_part_is_kept(study, tmp_path, monkeypatch):
    for name, most in (("SOON", 10_000), ("PARTIAL", 50_000), ("BLOCK", 10_000)):
        monkeypatch.setattr(store, name, most)
    pressing(monkeypatch, store, "_blocks", 3)
    assert main(study) == 130
    assert files(tmp_path) == {"one.partial.nc"}
    found = store.open_result(tmp_path / "one.partial.nc")
    assert name_of(found) == "interrupted"
    assert found.nbytes <= 50_000
    assert float(found.time[-1]) > 39.5 * float(found.turn_period_nominal)


def test_while_cells_are_gathered_they_are_kept(tmp_path, monkeypatch, capfd):
    (tmp_path / "one.toml").write_text(f'kind = "section"\n\n{SOFT}turns = 5\n\n[vary]\ngap = [0.9, 1.0]\n')
    command = ["run", str(tmp_path / "one.toml"), "--out", str(tmp_path), "--jobs", "1", "--no-figure"]
    with monkeypatch.context() as patch:
        pressing(patch, gather, "dataset")
        assert main(command) == 130
    assert "run the same command again to go on; what is finished is kept" in capfd.readouterr().err
    assert main(command) == 0
    assert "2 of 2 cells are there already" in capfd.readouterr().out


def test_no_look_comes_any_more_and_the_run_ends_all_the_same(study, tmp_path, monkeypatch):
    """A press just before the end of what looks is not lost."""
    with pytest.raises(KeyboardInterrupt), progress.stoppable():
        assert progress.stop()


@pytest.fixture
def large():
    """A dataset of many variables that takes a while to write."""
    rng = np.random.default_rng(3)
    names = {f"x{i}": ("time", rng.normal(size=3000), {"units": "m"}) for i in range(60)}
    return xr.Dataset(names | {"long": (("time", "link"), rng.normal(size=(3000, 40)))}, attrs={"kind": "x"})


def act_and_wait(act, path, seconds):
    """Act, with Ctrl-C after some seconds."""
    threading.Timer(seconds, press).start()
    act(path)
    time.sleep(60)


def random_presses(tmp_path, dataset, times, act):
    """How often each outcome came, of Ctrl-C at random moments of an action; nothing is left behind."""
    began = time.perf_counter()
    act(tmp_path / "whole.nc")
    lasts, rng, came = time.perf_counter() - began, random.Random(7), {"stored": 0, "not": 0}
    for i in range(times):
        path = tmp_path / f"{i}.nc"
        with pytest.raises(KeyboardInterrupt):
            act_and_wait(act, path, rng.uniform(0, lasts))
        assert not [*tmp_path.glob(".*")]
        came["stored" if path.exists() else "not"] += 1
        if path.exists():
            assert store.open_result(path).identical(dataset)
    return came


MANY = [12, pytest.param(200, marks=pytest.mark.nightly)]


@pytest.mark.nightly
@pytest.mark.parametrize("times", MANY)
def test_at_random_moments_of_storing_it_is_stored_or_not_and_never_hangs(large, tmp_path, times):
    came = random_presses(tmp_path, large, times, lambda path: store.write_result(large, path))
    assert came["stored"] > times / 2


@pytest.mark.long
@pytest.mark.parametrize("times", MANY)
def test_at_random_moments_of_reading_the_next_reading_does_not_hang(large, tmp_path, times):
    store.write_result(large, tmp_path / "a.nc")
    came = random_presses(tmp_path, large, times, lambda _: store.open_result(tmp_path / "a.nc"))
    assert came == {"stored": 0, "not": times}
    assert store.open_result(tmp_path / "a.nc").identical(large)


LONG = """kind = "response"

[mechanism]
catalog = "chunmei2002"
clearance = 2.9e-4
gear_ratio = 3.0

[analysis]
turns = 3000
"""


def cpu_of(pid):
    """CPU time of a process so far, s."""
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, words[11:15])) / os.sysconf("SC_CLK_TCK")


def cpu_of_ended():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


COMMAND = [sys.executable, "-m", "jointplay", "run", "one.toml", "--out", "out"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """CPU time of the long run where nothing stops it, s."""
    place, ended = tmp_path_factory.mktemp("whole"), cpu_of_ended()
    (place / "one.toml").write_text(LONG)
    subprocess.run(COMMAND, cwd=place, check=True, capture_output=True)
    return cpu_of_ended() - ended


@pytest.mark.nightly
@pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="CPU time of another process, as Linux has it"
)
@pytest.mark.parametrize("seed", range(20))
def test_a_run_of_two_million_samples_stops_at_any_moment(tmp_path, whole, seed):
    """Within a quarter of what the whole run takes, where two quarters and more were still to come."""
    (tmp_path / "one.toml").write_text(LONG)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": tmp_path}
    with subprocess.Popen(COMMAND, **pipes) as process:
        process.stdout.readline()
        wanted = random.Random(seed).uniform(0, 0.5) * whole
        while cpu_of(process.pid) < wanted:
            time.sleep(0.05)
        before, ended = cpu_of(process.pid), cpu_of_ended()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=120)
    assert process.returncode == 130, said
    assert cpu_of_ended() - ended - before < whole / 4
    assert "Exception ignored" not in said
    assert "Traceback" not in said
    kept = {path.name for path in (tmp_path / "out").iterdir()} if (tmp_path / "out").exists() else set()
    assert not {name for name in kept if name.endswith(".tmp")}
    assert kept & {"one.partial.nc", "one.nc"} or "%" not in said


def test_blocks_of_an_array_are_all_of_it(monkeypatch, tmp_path):
    monkeypatch.setattr(store, "BLOCK", 800)
    rng = np.random.default_rng(5)
    shapes = [(3, 1000), (1000, 3), (7, 11, 13), (1,), (), (500,)]
    whole = xr.Dataset(
        {f"v{i}": ([f"d{i}{j}" for j in range(len(s))], rng.normal(size=s)) for i, s in enumerate(shapes)}
    )
    for write in (store.write_result, store.write_partial):
        kept = store.open_result(write(whole, tmp_path / "a.nc"))
        kept.attrs.pop("seal", None)
        assert kept.identical(whole)
    with netCDF4.Dataset(tmp_path / "a.nc") as file:
        assert len([*store._blocks(whole.v0.values, "contiguous")]) > 25
        assert file["v0"].shape == (3, 1000)


def test_inside_a_held_block_it_waits_and_comes_to_who_was_to_get_it():
    done = []

    def press_inside():
        with interrupts.held() as outer:
            with interrupts.held() as pressed:
                assert not pressed()
                press()
                assert pressed()
                done.append("inner")
            assert outer()
            done.append("outer")

    with pytest.raises(KeyboardInterrupt):
        press_inside()
    assert done == ["inner", "outer"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


# a sort in C lets other threads run, as the compiler does, and no handler of Python
STUCK = """
import ctypes, os, signal, sys, threading, argparse
from jointplay import cli
libc, many = ctypes.CDLL(None), 1 << 28
zeros = (ctypes.c_char * many)()
def verb(arguments):
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    libc.qsort(zeros, ctypes.c_size_t(many), ctypes.c_size_t(1), libc.strcmp)
    print("sorted")
parser = argparse.ArgumentParser()
parser.set_defaults(verb=verb)
cli.build_parser = lambda: parser
sys.exit(cli.main([]))
"""


@pytest.mark.nightly
def test_where_compiled_code_goes_on_the_process_ends_without_it():
    done = subprocess.run([sys.executable, "-c", STUCK], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "interrupted: run the same command again\n"
