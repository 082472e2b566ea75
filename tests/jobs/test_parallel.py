"""Calls side by side: asked for as workers get free, ended by an error, by a death, with their parent."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from joblib.externals.loky import get_reusable_executor

from jointplay.analysis.cells import handed_out
from jointplay.jobs import parallel
from jointplay.jobs.parallel import BrokenProcessPool, side_by_side
from jointplay.solver.motion.progress import heard, stands

SENDER = """
import os, time
from functools import partial
from jointplay.jobs.parallel import side_by_side
side_by_side([partial(os.symlink, "here", "begun"), partial(time.sleep, 1000)], print, 1)
"""
SOON = 60.0  # s on a busy machine; a quarter of one is meant


def alive(process):
    """Whether a process runs still, and is not only waited for."""
    try:
        return Path(f"/proc/{process}/stat").read_text().split(") ")[1][0] != "Z"
    except OSError:
        return False


def gone(process):
    """Whether a process ends before long."""
    end = time.monotonic() + SOON
    while alive(process) and time.monotonic() < end:
        time.sleep(0.05)
    return not alive(process)


@pytest.mark.parametrize(("backend", "jobs", "ahead"), [("here", 1, 1), ("threading", 3, 3), ("loky", 2, 4)])
def test_calls_are_asked_for_as_workers_get_free(backend, jobs, ahead):
    asked, found = [], []

    def calls():
        for i in range(20):
            asked.append(i)
            assert len(asked) - len(found) <= ahead
            yield partial(pow, i, 2)

    side_by_side(calls(), found.append, jobs, backend)
    assert sorted(found) == [i * i for i in range(20)]


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals of another kind")
def test_ctrl_c_reaches_no_worker_not_even_one_that_starts():
    found = []
    get_reusable_executor().shutdown(kill_workers=True)
    side_by_side([partial(signal.pthread_sigmask, signal.SIG_BLOCK, [])], found.append, 1)
    assert signal.SIGINT in found[0]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


@pytest.mark.parametrize("backend", ["here", "threading", "loky"])
def test_what_a_call_raises_is_raised(backend):
    with pytest.raises(ValueError, match="x"):
        side_by_side([partial(int, "x")], print, 1, backend)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="reads the processes of Linux")
def test_an_error_ends_the_workers_and_a_dead_one_does_not_spoil_the_next():
    found = []

    def take(process):
        found.append(process)
        raise KeyError(process)

    with pytest.raises(KeyError):
        side_by_side([os.getpid, partial(time.sleep, 1000)], take, 2)
    assert found[0] != os.getpid()
    assert gone(found[0])
    with pytest.raises(BrokenProcessPool):
        side_by_side([partial(os._exit, 1), partial(time.sleep, 1000)], found.append, 2)
    side_by_side([partial(abs, -3)], found.append, 1)
    assert found[1:] == [3]


@pytest.mark.long
@pytest.mark.skipif(not Path("/proc/self").exists(), reason="reads the processes of Linux")
def test_workers_end_with_the_process_that_sent_their_calls(tmp_path):
    sender = subprocess.Popen([sys.executable, "-P", "-c", SENDER], cwd=tmp_path)
    while not (tmp_path / "begun").is_symlink():
        time.sleep(0.05)
        assert sender.poll() is None
    child = sender.pid
    workers = [int(word) for word in Path(f"/proc/{child}/task/{child}/children").read_text().split()]
    sender.kill()
    sender.wait()
    assert workers
    assert all(map(gone, workers))


def test_somebody_looks_while_workers_are_busy():
    looks = []

    def look():
        looks.append(1)
        if len(looks) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        side_by_side([partial(time.sleep, 1000)], print, 1, "threading", look)
    assert len(looks) == 3
    assert parallel.LOOK <= 0.25  # s: what waits for a look is to be prompt


def begun(share, go):
    """A cell of which so much is soon done, and that ends when a file is there."""
    stands(share, "half way")
    end = time.monotonic() + 30.0
    while not go.exists() and time.monotonic() < end:
        time.sleep(0.01)
    return {"status": 0 if go.exists() else 1}


@pytest.mark.parametrize("n_jobs", [1, pytest.param(2, marks=pytest.mark.long)])
def test_what_is_done_of_cells_that_are_not_finished_is_part_of_the_progress(n_jobs, tmp_path):
    told, go = [], tmp_path / "go"

    def progress(done):
        told.append(done)
        if done == pytest.approx([0.125, 0.375][n_jobs - 1], abs=1e-4):
            go.touch()

    answers = handed_out(begun, [{"share": share, "go": go} for share in (0.25, 0.5)], progress, n_jobs)
    assert [each["status"] for each in answers] == [0, 0]
    assert told[-1] == 1.0
    if n_jobs == 1:
        assert told == [0.125, 0.5, 0.75, 1.0]


def test_where_nobody_asks_how_far_it_is_a_listener_farther_out_hears_it(tmp_path):
    """That of the cell in which an analysis has cells of its own."""
    places, go = [], tmp_path / "go"
    go.touch()
    with heard(lambda done, place: places.append((done, place))):
        handed_out(begun, [{"share": 0.25, "go": go}], None, 1)
    assert places == [(0.25, "half way")]
