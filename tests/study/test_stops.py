"""Runs that do not reach their end: by the numerics (exit 1, all kept) or by Ctrl-C (exit 130)."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from program import jointplay

from jointplay.study.status import name_of
from jointplay.study.store import open_result

STUDIES = Path(__file__).parents[2] / "studies"


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


def test_a_section_that_stops_in_the_transient_is_still_a_result(tmp_path):
    words = ["run", STUDIES / "paper" / "fig12c.toml", "--out", tmp_path]
    done = jointplay(*words, "--set", "integrator.max_steps=50")
    assert done.returncode == 1, done.stderr
    dataset = open_result(tmp_path / "fig12c.nc")
    assert (name_of(dataset), dataset.sizes["turn"]) == ("step_limit", 0)


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
    assert list((tmp_path / "out").iterdir()) == []
