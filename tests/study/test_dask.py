"""A sweep on a cluster: a scheduler and two worker processes on this machine."""

import subprocess
import sys

import pytest
from sweep_samples import CELLS, CHAINS, loaded, ran, same

import jointplay as jp
from jointplay import cli

pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def scheduler():
    """Address of a scheduler that has two workers."""
    start = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard"]
    with subprocess.Popen(start, stderr=subprocess.PIPE, text=True) as boss:
        address = next(line.split()[-1] for line in boss.stderr if "Scheduler at:" in line)
        hire = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1"]
        hire += ["--no-dashboard", "--no-nanny"]
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        hands = [subprocess.Popen(hire, **silent) for _ in range(2)]
        yield address
        for process in (*hands, boss):
            process.kill()
            process.wait()


@pytest.mark.parametrize("text", [CELLS, CHAINS])
def test_a_cluster_gives_the_same(text, scheduler, tmp_path):
    path, name = tmp_path / "a.toml", loaded(text).record.name
    path.write_text(text)
    words = ["run", str(path), "--out", str(tmp_path), "--no-figure"]
    assert cli.main([*words, "--backend", "dask", "--scheduler", scheduler]) == 0
    assert same(jp.open(tmp_path / f"{name}.nc").load(), _stored(text, tmp_path / "one"))


def _stored(text, out):
    ran(loaded(text), out)
    return jp.open(out / f"{loaded(text).record.name}.nc")


def test_a_scheduler_that_is_not_there_is_wrong_input(tmp_path, capsys, monkeypatch):
    path = tmp_path / "a.toml"
    path.write_text(CELLS)
    words = ["run", str(path), "--out", str(tmp_path), "--backend", "dask", "--scheduler"]
    monkeypatch.setattr("jointplay.study.pool.PATIENCE", "1s")
    assert cli.main([*words, "tcp://127.0.0.1:1"]) == 2
    assert "--scheduler" in capsys.readouterr().err
