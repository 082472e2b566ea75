"""The verb ``cache``: what lies on the disk, and what `prune` leaves."""

import os

import pytest

from jointplay.solver.codegen.cache import digest
from tests.support.program import jointplay


@pytest.mark.nightly
def test_the_cache_is_listed_and_pruned_down_to_what_is_in_use(tmp_path):
    old = tmp_path / "0123456789abcdef"
    old.mkdir()
    (tmp_path / "thesis").mkdir()
    (old / "kernel.nbc").write_bytes(bytes(2_000_000))
    (tmp_path / digest()).mkdir(0o700)
    here = os.environ | {"JOINTPLAY_CACHE": str(tmp_path)}
    listed = jointplay("cache", env=here)
    assert listed.returncode == 0
    lines = {line.split()[0]: line for line in listed.stdout.splitlines()}
    assert lines.keys() == {old.name, digest()}
    assert lines[old.name].endswith("2.0 MB  old")
    assert lines[digest()].endswith("in use")
    pruned = jointplay("cache", "prune", env=here)
    assert "removed 1 " in pruned.stdout
    assert {path.name for path in tmp_path.iterdir()} == {digest(), "thesis"}, "other folders are not ours"
    assert "removed 0 " in jointplay("cache", "prune", env=here).stdout
    assert jointplay("cache", "purge", env=here).returncode == 2
    assert "removed 1 " in jointplay("cache", "prune", "--all", env=here).stdout
    assert [path.name for path in tmp_path.iterdir()] == ["thesis"]
    assert jointplay("cache", "--all", env=here).returncode == 2


@pytest.mark.long
def test_verification_removes_what_is_damaged_and_says_so(tmp_path):
    here = os.environ | {"JOINTPLAY_CACHE": str(tmp_path)}
    assert jointplay("cache", "verify", env=here).returncode == 0
    damaged = tmp_path / digest() / "k0123456789abcdef.py"
    damaged.write_text("# 0123\n1 + 1\n")
    first, second = (jointplay("cache", "verify", env=here) for _ in range(2))
    assert first.returncode == 1
    assert f"{damaged} is damaged" in first.stderr
    assert "0 files of the kernels in use are sound; 1 " in first.stdout
    assert second.returncode == 0
    assert not damaged.exists()


def test_an_empty_name_of_the_cache_is_refused():
    for words in (["cache"], ["cache", "verify"]):
        refused = jointplay(*words, env=os.environ | {"JOINTPLAY_CACHE": ""})
        assert refused.returncode == 2
        assert refused.stderr.startswith("wrong input:\n  JOINTPLAY_CACHE: got ''; ")


def test_no_cache_lies_in_the_current_folder_for_want_of_a_home(tmp_path):
    nowhere = dict.fromkeys(("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"), "") | {"HOME": str(tmp_path / "home")}
    plain = {name: value for name, value in os.environ.items() if name != "JOINTPLAY_CACHE"}
    (tmp_path / "study").mkdir()
    jointplay("cache", "verify", env=plain | nowhere, cwd=tmp_path / "study")
    assert not list((tmp_path / "study").iterdir())
    assert (tmp_path / "home" / ".cache" / "jointplay" / digest()).is_dir()
