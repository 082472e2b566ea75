"""Every test has a time limit: one without end is ended, and the test command with it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

CONFIGURATION = Path(__file__).parents[1] / "pyproject.toml"
WITHOUT_END = """
import threading

def test_without_end():
    threading.Event().wait()
"""


def test_every_test_has_a_limit(request):
    items = request.session.items
    own = [item.get_closest_marker("timeout") for item in items]
    assert float(request.config.getini("timeout")) > 0
    assert all(marker is None or marker.args[0] > 0 for marker in own)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("options", "told"),
    [(["-p", "no:xdist"], "Timeout"), (["-n", "1"], "crashed while running")],
    ids=["alone", "in a worker"],
)
def test_one_without_end_is_ended(tmp_path, options, told):
    (tmp_path / "test_waits.py").write_text(WITHOUT_END)
    command = [sys.executable, "-m", "pytest", "-c", str(CONFIGURATION), "--rootdir", str(tmp_path)]
    done = subprocess.run(
        [*command, *options, "-p", "no:cacheprovider", "--timeout=2", "test_waits.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    assert told in done.stdout + done.stderr
