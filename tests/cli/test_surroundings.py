"""Surroundings that refuse: files that may not grow, a cache not to be written; two cold starts at once."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from jointplay.study.results.store import open_result
from tests.support.study_samples import SOFT

pytestmark = pytest.mark.skipif(os.name == "nt", reason="limits and permissions of POSIX")
STUDY = f'kind = "response"\n{SOFT}turns = 200\nsamples_per_turn = 250\n'


@pytest.fixture
def command(tmp_path):
    (tmp_path / "one.toml").write_text(STUDY)
    return [sys.executable, "-m", "jointplay", "run", str(tmp_path / "one.toml"), "--no-figure"]


@pytest.mark.nightly
@pytest.mark.parametrize("blocks", [8, 400])
def test_a_file_that_may_not_grow_ends_a_run_in_a_sentence(command, tmp_path, blocks):
    """As by `ulimit -f`, at the beginning of the result or in its middle."""
    words = " ".join([*command, "--out", str(tmp_path / "out")])
    done = subprocess.run(["bash", "-c", f"ulimit -f {blocks}; {words}"], capture_output=True, text=True)
    assert done.returncode == 1, done.stderr
    assert "not done: " in done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    assert not [*(tmp_path / "out").iterdir()]


UNWRITABLE = """
import os
from jointplay.solver.codegen import place
place.digest()
if not os.geteuid():  # whom no permission stops
    os.seteuid(65534)
print(place.folder().is_dir())
"""


def test_a_cache_that_cannot_be_written_is_told_and_leaves_nothing():
    with tempfile.TemporaryDirectory() as folder:
        cache, temporary = Path(folder) / "cache", Path(folder) / "temporary"
        for each in (Path(folder), cache, temporary):
            each.mkdir(exist_ok=True)
            if not os.geteuid():
                os.chown(each, 65534, 65534)
        cache.chmod(0o500)
        own = os.environ | {"JOINTPLAY_CACHE": str(cache), "TMPDIR": str(temporary)}
        done = subprocess.run([sys.executable, "-c", UNWRITABLE], env=own, capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr
        assert "compiled for this run alone" in done.stderr
        assert done.stderr.count("\n") == 1
        assert not [*cache.iterdir(), *temporary.iterdir()]


@pytest.mark.nightly
def test_two_processes_that_fill_one_cold_cache_give_one_answer(command, tmp_path):
    own = os.environ | {"JOINTPLAY_CACHE": str(tmp_path / "cache")}
    places = [tmp_path / name for name in ("a", "b", "c")]
    racing = [subprocess.Popen([*command, "--out", str(place)], env=own) for place in places[:2]]
    assert [each.wait(600) for each in racing] == [0, 0]
    done = subprocess.run([*command, "--out", str(places[2])], env=own, capture_output=True, text=True)
    assert done.returncode == 0
    assert "compiling" not in done.stderr
    assert "kernel cache" not in done.stderr
    one, *others = (open_result(place / "one.nc").drop_vars("wall_time") for place in places)
    assert all(one.equals(other) for other in others)
