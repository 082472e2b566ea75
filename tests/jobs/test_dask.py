"""A sweep on a cluster: a scheduler and two worker processes on this machine."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from contextlib import contextmanager
from pathlib import Path

import pytest

import jointplay as jp
from jointplay import cli
from jointplay.jobs import pool
from jointplay.jobs.job import CRASHED
from jointplay.jobs.journal import Journal
from jointplay.jobs.pool import Pool
from tests.study.test_refined_maps import MAP
from tests.support.deadly import Deadly, DeadlyChain
from tests.support.sweep_samples import CELLS, CHAINS, KINDS, SLOW, ran, same
from tests.support.sweep_samples import loaded as read

distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.peer
ALLOWED = 1  # failures of a task before the scheduler gives it up


@contextmanager
def _cluster(*options):
    """Address of a scheduler, with a worker process for each set of options; all end with the block."""
    places = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    told = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": str(ALLOWED)}
    told |= {"PYTHONPATH": os.pathsep.join(places)}
    group = {"env": os.environ | told, "start_new_session": True}
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard"]
    with subprocess.Popen(start, stderr=subprocess.PIPE, text=True, **group) as boss:
        address = next(line.split()[-1] for line in boss.stderr if "Scheduler at:" in line)
        hire = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1"]
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        hands = [subprocess.Popen([*hire, "--no-dashboard", *each], **silent, **group) for each in options]
        try:
            yield address
        finally:
            for process in (*hands, boss):  # with their nannies' children
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


@pytest.fixture(scope="module")
def scheduler():
    """Address of a scheduler that has two workers."""
    with _cluster(["--no-nanny"], ["--no-nanny"]) as address:
        yield address


@pytest.fixture(scope="module")
def nursery():
    """Address of a scheduler that has two workers, which nannies start anew when they die."""
    with _cluster(["--nanny"], ["--nanny"]) as address:
        yield address


@pytest.mark.parametrize(
    "text",
    [
        *(CELLS, CHAINS, pytest.param(MAP, marks=pytest.mark.nightly)),
        *(
            pytest.param(
                KINDS[k],
                marks=pytest.mark.nightly
                if k in (*SLOW, "tipping", "covariant", "gradient", "tolerances")
                else (),
            )
            for k in KINDS
        ),
    ],
    ids=["cells", "chains", "refined", *KINDS],
)
def test_a_cluster_gives_the_same(text, scheduler, tmp_path):
    path, name = tmp_path / "a.toml", read(text).record.name
    path.write_text(text)
    words = ["run", str(path), "--out", str(tmp_path), "--no-figure"]
    assert cli.main([*words, "--backend", "dask", "--scheduler", scheduler]) == 0
    assert same(jp.open(tmp_path / f"{name}.nc").load(), _stored(text, tmp_path / "one"))


def _stored(text, out):
    ran(read(text), out)
    return jp.open(out / f"{read(text).record.name}.nc")


def _on(address, jobs, folder):
    """What lies in the journal after jobs ran on a pool, and what was said."""
    said, journal = [], Journal(folder)
    with journal.held():
        Pool(backend="dask", scheduler=address).run(jobs, journal, said.append)
    return journal, said


def test_a_chain_travels_back_in_pieces_and_is_the_same(scheduler, tmp_path, monkeypatch):
    parts, write = [], Journal.write

    def noted(journal, entries, by):
        parts.append(len(entries))
        write(journal, entries, by)

    monkeypatch.setattr(Journal, "write", noted)
    monkeypatch.setattr(pool, "LIMIT", 0.0)  # each cell a piece
    (tmp_path / "pieces").mkdir()
    study = read(CHAINS)
    path = tmp_path / "a.toml"
    path.write_text(CHAINS)
    words = ["run", str(path), "--out", str(tmp_path / "pieces"), "--no-figure"]
    assert cli.main([*words, "--backend", "dask", "--scheduler", scheduler]) == 0
    assert parts[:12] == [1] * 12
    found = jp.open(tmp_path / "pieces" / f"{study.record.name}.nc").load()
    assert same(found, _stored(CHAINS, tmp_path / "one"))


def test_workers_of_other_code_compute_nothing(scheduler, tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "code", lambda: "another")
    with pytest.raises(OSError, match=r"another is needed.*same version of jointplay"):
        _on(scheduler, [Deadly("a", 0, str(tmp_path / "log"))], tmp_path / "a.journal")
    assert not Journal(tmp_path / "a.journal").index()


def test_workers_of_several_kinds_of_processors_are_told_once(tmp_path):
    said = []
    here = pool.Cluster(None, Journal(tmp_path), said.append)
    for kind in ("zen 1", "zen 1", "lake 2", "zen 1"):
        here._note_processor(kind)
    assert len(said) == 1
    assert "2 kinds of processors (lake 2, zen 1)" in said[0]


@pytest.mark.nightly
def test_the_death_of_a_worker_costs_the_fatal_cell_alone(nursery, tmp_path):
    log, ever = tmp_path / "log", 10**6
    chain = tuple(f"link{i}" for i in range(6))
    jobs = [Deadly(f"key{i}", {2: 1, 5: ever}.get(i, 0), str(log)) for i in range(10)]
    jobs.append(DeadlyChain(chain, {"link3": ever}, str(log)))
    journal, said = _on(nursery, jobs, tmp_path / "a.journal")
    crashed = {key for key, status in journal.index().items() if status == CRASHED}
    assert crashed == {"key5", "link3"}
    assert len(journal.index()) == 16
    begun = log.read_text().split()
    # twice as often where the task itself is begun again; a worker may die before it has noted that
    assert 1 + ALLOWED <= begun.count("key5") <= 2 * (1 + ALLOWED)
    assert begun.count("key2") >= 2
    counts = [journal.load([key])[key].get("count") for key in chain]
    assert counts == [1, 2, 3, None, 4, 5]
    assert sum("crashed" in line for line in said) == 2
    assert any("once more" in line for line in said)


@pytest.mark.nightly
def test_what_did_not_kill_its_worker_is_not_charged(nursery, tmp_path):
    jobs = [Deadly(f"key{i}", 1, str(tmp_path / "log")) for i in range(3)]
    jobs.append(DeadlyChain(tuple("abcdef"), {"c": 1}, str(tmp_path / "log")))
    journal, _ = _on(nursery, jobs, tmp_path / "a.journal")
    assert not any(journal.index().values())
    assert journal.load("f")["f"]["count"] == 6


class _Taken:
    """A task whose answer arrived, and went with its worker before it was fetched."""

    status = "lost"

    def __init__(self, error):
        self.error = error

    def result(self):
        raise self.error


def test_an_answer_may_die_with_its_worker_before_it_is_fetched(tmp_path):
    here = pool.Cluster(None, Journal(tmp_path), print)
    assert here._taken(_Taken(distributed.scheduler.KilledWorker("task", None, 1))) is None
    with pytest.raises(OSError, match="scheduler was lost"):
        here._taken(_Taken(CancelledError()))


def test_without_workers_it_waits_and_says_so(tmp_path, monkeypatch):
    def stop(*_):
        raise KeyboardInterrupt

    said, journal = [], Journal(tmp_path / "a.journal")
    monkeypatch.setattr(pool.Cluster, "_ended", stop)
    with _cluster() as address, journal.held(), pytest.raises(KeyboardInterrupt):
        Pool(backend="dask", scheduler=address).run([Deadly("a", 0, "")], journal, said.append)
    assert said == ["the cluster has no workers; waiting for one"]


@pytest.mark.nightly
def test_a_lost_scheduler_is_told(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(CELLS)
    with _cluster(["--no-nanny"]) as address:
        words = ["run", str(path), "--out", str(tmp_path), "--no-figure", "--set", "analysis.turns=20000"]
        command = [sys.executable, "-m", "jointplay", *words, "--backend", "dask", "--scheduler", address]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        while not Journal(tmp_path / "cells.journal").parts():
            time.sleep(0.05)
            assert process.poll() is None
    said = process.communicate(timeout=120)[1]
    assert process.returncode == 1
    assert "Traceback" not in said
    assert "scheduler" in said


def test_a_scheduler_that_is_not_there_is_wrong_input(tmp_path, capsys, monkeypatch):
    path = tmp_path / "a.toml"
    path.write_text(CELLS)
    words = ["run", str(path), "--out", str(tmp_path), "--no-figure", "--backend", "dask", "--scheduler"]
    monkeypatch.setattr(pool, "PATIENCE", "1s")
    assert cli.main([*words, "tcp://127.0.0.1:1"]) == 2
    assert "--scheduler" in capsys.readouterr().err
