"""The suite works without the packages beside it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

STUDIES = Path(__file__).parents[1] / "studies"
LOST = """
import importlib.metadata, sys
sys.modules |= {"jointplay_lab": None, "jointplay_page": None}  # as if they were not there
from jointplay.cli import main
"""
ALONE = LOST.replace(
    "from", "importlib.metadata.entry_points = lambda **_: importlib.metadata.EntryPoints()\nfrom"
)


def ran(code, *given, folder):
    command = [sys.executable, "-c", code, *given]
    return subprocess.run(command, cwd=folder, env=os.environ, capture_output=True, text=True)


@pytest.mark.long
def test_the_suite_alone_runs_and_draws_a_study(tmp_path):
    given = ["run", str(STUDIES / "quickstart.toml"), "--out", "out", "--set", "analysis.turns=2"]
    given += ["analysis.transient=1", "figure.turns=[1, 2]"]
    done = ran(f"{ALONE}sys.exit(main(sys.argv[1:]))", *given, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "out").glob("quickstart.*")} >= {
        "quickstart.nc",
        "quickstart.png",
    }


@pytest.mark.parametrize(("verb", "missing"), [("report", "jointplay_page"), ("reproduce", "jointplay_lab")])
def test_a_verb_of_another_package_is_unknown_without_it(verb, missing, tmp_path):
    done = ran(f"{ALONE}sys.exit(main(sys.argv[1:]))", verb, "x", folder=tmp_path)
    assert done.returncode == 2
    assert f"invalid choice: '{verb}' (choose from 'run', " in done.stderr
    assert "not loaded" not in done.stderr
    done = ran(f"{LOST}sys.exit(main(sys.argv[1:]))", verb, "x", folder=tmp_path)
    assert done.returncode == 2
    assert f"({missing}.verbs)" in done.stderr.partition("not loaded: ")[2]
    assert "Traceback" not in done.stderr


@pytest.mark.nightly
def test_a_function_of_another_package_is_unknown_without_it(tmp_path):
    code = (
        "import jointplay\nprint([hasattr(jointplay, name) for name in ('report', 'waveform', 'simulate')])"
    )
    assert ran(code, folder=tmp_path).stdout == "[True, True, True]\n"
    done = ran(f"{ALONE}{code}", folder=tmp_path)
    assert (done.returncode, done.stdout) == (0, "[False, False, True]\n"), done.stderr


def test_a_kind_of_the_laboratory_is_unknown_without_it(tmp_path):
    (tmp_path / "claims.toml").write_text((STUDIES / "paper" / "claims.toml").read_text())
    done = ran(f"{ALONE}sys.exit(main(sys.argv[1:]))", "check", "claims.toml", folder=tmp_path)
    assert done.returncode == 2
    assert "claims" in done.stderr
    assert "Traceback" not in done.stderr
