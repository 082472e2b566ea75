"""Runs that do not reach their end: by the numerics (exit 1, all kept) or by Ctrl-C (exit 130)."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from jointplay.analysis.orbits.branch import Tracer
from jointplay.cli import main
from jointplay.solver.motion import progress
from jointplay.study.results.outcome import name_of
from jointplay.study.results.store import open_result
from tests.support.program import jointplay
from tests.support.study_samples import SOFT

STUDIES = Path(__file__).parents[2] / "studies"


@pytest.mark.nightly
def test_a_run_out_of_steps_keeps_and_draws_what_it_has(tmp_path):
    words = ["run", STUDIES / "quickstart.toml", "--out", tmp_path, "--set", "analysis.transient=0"]
    done = jointplay(*words, "integrator.max_steps=1500", "analysis.turns=30", "figure.turns=1")
    assert done.returncode == 1, done.stderr
    assert "step_limit" in done.stderr
    assert "raise integrator.max_steps" in done.stderr
    dataset = open_result(tmp_path / "quickstart.nc")
    assert name_of(dataset) == "step_limit"
    assert 0 < dataset.sizes["time"] < 30 * 3600
    assert np.isfinite(dataset["normal_force"]).all()
    assert dataset.sizes["turn"] > 0
    assert (tmp_path / "quickstart.png").exists()


@pytest.mark.nightly
def test_a_section_that_stops_in_the_transient_is_still_a_result(tmp_path):
    words = ["run", STUDIES / "paper" / "fig12c.toml", "--out", tmp_path]
    done = jointplay(*words, "--set", "integrator.max_steps=50")
    assert done.returncode == 1, done.stderr
    dataset = open_result(tmp_path / "fig12c.nc")
    assert (name_of(dataset), dataset.sizes["turn"]) == ("step_limit", 0)


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("seconds", [0.5, 3.0])
def test_an_interrupt_ends_a_run_soon_with_a_sentence(seconds, tmp_path):
    words = ["run", STUDIES / "paper" / "fig12c.toml", "--out", tmp_path / "out"]
    words += ["--set", "analysis.turns=10000000"]
    command = [sys.executable, "-m", "jointplay", *map(str, words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        process.stdout.readline()  # the study is read, the run begins
        time.sleep(seconds)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert "interrupted: run the same command again" in said
    assert "Traceback" not in said
    assert {path.name for path in (tmp_path / "out").iterdir()} <= {"fig12c.partial.nc"}


KEPT = {
    "response": ("turns = 1000000\nsamples_per_turn = 2\n", lambda found: found.sizes["time"] > 100),
    "section": ("turns = 100000000\n", lambda found: found.sizes["turn"] > 100),
    "lyapunov": ("turns = 100000000\n", lambda found: np.isfinite(found["lyapunov_exponent"]).all()),
    "continuation": (
        'parameter = "gap"\nrange = [0.5, 2.0]\ntransient = 20\nstep = 1e-4\nmax_points = 100000\n',
        lambda found: (
            (found.sizes["point"] > 1)
            & bool(np.isfinite(found["orbit_state"][0, : int(found["n_points"][0])]).all())
        ),
    ),
    "sensitivity": (
        "neighbours = 2\nreferences = 99\nturns = 300\n",
        lambda found: np.isfinite(found["distance"][0]).all(),
    ),
}


@pytest.fixture
def interrupting(monkeypatch):
    """Ctrl-C when something has been done."""

    def pressed(self, fraction):
        self.said += fraction > 0
        if self.said == 5:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("jointplay.display.terminal.Progress.__call__", pressed)
    monkeypatch.setattr(progress, "PATIENCE", 60.0)  # longer than whatever compiles meanwhile


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("kind", KEPT)
def test_what_a_single_analysis_has_is_kept_apart_from_its_result(kind, tmp_path, interrupting, capsys):
    analysis, worth_keeping = KEPT[kind]
    study, result = tmp_path / "one.toml", tmp_path / "one.nc"
    study.write_text(f'kind = "{kind}"\n{SOFT}{analysis}')
    result.write_text("of a run before")
    assert main(["run", str(study), "--out", str(tmp_path), "--fresh"]) == 130
    said = capsys.readouterr()
    assert "one.partial.nc" in said.out
    assert "interrupted: run the same command again to start over" in said.err
    found = open_result(tmp_path / "one.partial.nc")
    assert name_of(found) == "interrupted"
    assert worth_keeping(found)
    assert result.read_text() == "of a run before"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_branch_is_kept_although_no_look_comes(tmp_path, interrupting, monkeypatch, capsys):
    def busy(self, last, length):
        if progress._stop.requested:
            time.sleep(60)
        return advance(self, last, length)

    advance = Tracer._advance
    monkeypatch.setattr(Tracer, "_advance", busy)
    monkeypatch.setattr(progress, "PATIENCE", 0.05)
    analysis, worth_keeping = KEPT["continuation"]
    study = tmp_path / "one.toml"
    study.write_text(f'kind = "continuation"\n{SOFT}{analysis}')
    assert main(["run", str(study), "--out", str(tmp_path), "--fresh"]) == 130
    assert "one.partial.nc" in capsys.readouterr().out
    assert worth_keeping(open_result(tmp_path / "one.partial.nc"))


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_run_that_ends_takes_away_what_an_interrupted_one_kept(tmp_path):
    study, partial = tmp_path / "one.toml", tmp_path / "one.partial.nc"
    study.write_text(f'kind = "section"\n{SOFT}turns = 5\n')
    partial.write_text("of a run before")
    assert main(["run", str(study), "--out", str(tmp_path), "--no-figure"]) == 0
    assert (tmp_path / "one.nc").exists()
    assert not partial.exists()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_what_cannot_be_kept_starts_over(tmp_path, interrupting, capsys):
    study = tmp_path / "one.toml"
    study.write_text(f'kind = "chaos_test"\n{SOFT}turns = 100000000\n')
    assert main(["run", str(study), "--out", str(tmp_path), "--fresh"]) == 130
    assert "interrupted: run the same command again to start over" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["one.toml"]


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_stop_that_nothing_comes_to_interrupts_all_the_same(monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.05)
    with progress.stoppable():
        assert progress.stop()
        assert not progress.stop()  # the second time is in earnest
        with pytest.raises(KeyboardInterrupt):
            time.sleep(60)
