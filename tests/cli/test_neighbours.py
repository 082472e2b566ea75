"""Files beside a study are not imported in place of a library, in this process or in workers."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import jointplay as package
from jointplay.jobs.parallel import safe_path
from tests.support.program import jointplay
from tests.support.study_samples import TEXT

NAMES = ("random", "platform", "tempfile", "hashlib", "subprocess", "socket", "numba", "joblib")
CELLS = """
from jointplay.analysis.cells import handed_out
print(handed_out(dict, [{'status': 0}] * 2, n_jobs=2))
"""
ANSWERS = "[{'status': 0}, {'status': 0}]\n"
PACKAGE = Path(package.__file__).parent


@pytest.fixture
def beside(tmp_path):
    """A folder with a study, and files that leave a trace when they are run."""
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text("open('ran', 'a').write(__name__)\n")
    (tmp_path / "small.toml").write_text(TEXT)
    return tmp_path


def test_the_command_line_runs_none_of_them(beside):
    done = jointplay("check", "small.toml", cwd=beside)
    assert done.returncode == 0, done.stderr
    assert not (beside / "ran").exists()


@pytest.mark.nightly
def test_workers_run_none_of_them(beside):
    command = [sys.executable, "-P", "-c", CELLS]
    done = subprocess.run(command, cwd=beside, capture_output=True, text=True, timeout=300)
    assert done.stdout == ANSWERS, done.stderr
    assert not (beside / "ran").exists()


def test_the_environment_of_this_process_is_left_as_it_was(monkeypatch):
    for before in (None, "", "1"):
        monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
        if before is not None:
            monkeypatch.setenv("PYTHONSAFEPATH", before)
        with safe_path():
            assert os.environ["PYTHONSAFEPATH"] == "1"
        assert os.environ.get("PYTHONSAFEPATH") == before


@pytest.mark.nightly
def test_a_checkout_that_is_not_installed_still_runs_from_its_own_folder(beside):
    """Workers import this very package, and not the installed one."""
    shutil.copytree(PACKAGE, beside / "jointplay", ignore=shutil.ignore_patterns("__pycache__"))
    (beside / "jointplay" / "there.py").write_text("def there():\n    return {'status': 0}\n")
    (beside / "jointplay" / "__main__.py").write_text(
        "from jointplay.there import there\n" + CELLS.replace("dict, [{'status': 0}]", "there, [{}]")
    )
    (beside / "numba.py").unlink()  # libraries come behind it
    (beside / "joblib.py").unlink()
    done = jointplay(cwd=beside, env=os.environ | {"PYTHONPATH": ""}, timeout=300)
    assert done.stdout == ANSWERS, done.stderr
    assert not (beside / "ran").exists()
