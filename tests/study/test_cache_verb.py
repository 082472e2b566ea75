"""The verb ``cache``: what lies on the disk, and what `prune` leaves."""

import os

from program import jointplay

from jointplay.codegen.cache import digest


def test_the_cache_is_listed_and_pruned_down_to_what_is_in_use(tmp_path):
    old = tmp_path / "0123456789abcdef"
    old.mkdir()
    (tmp_path / "thesis").mkdir()
    (old / "kernel.nbc").write_bytes(bytes(2_000_000))
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
