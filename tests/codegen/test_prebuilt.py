"""Loops compiled ahead for a release: taken if they are of these sources and this processor, else ignored."""

import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.codegen import cache, place, prebuilt
from jointplay.solver.method.interface import interpreted
from tests.benchmarks.first_runs import wheel

SMALL = "modal_response"  # a loop that compiles fast

pytestmark = [
    pytest.mark.skipif(platform.machine() != "x86_64", reason="compiled ahead for x86-64 alone"),
    pytest.mark.skipif(interpreted(), reason="nothing is compiled"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with one loop compiled ahead."""
    place = tmp_path_factory.mktemp("ready")
    prebuilt.write(place, [SMALL])
    return place


@pytest.fixture
def ready(folder, tmp_path, monkeypatch):
    """A copy of it, in use; the file of the loops."""
    if not prebuilt._suits():
        pytest.skip("this processor cannot run it")
    path = tmp_path / prebuilt.NAME
    path.write_bytes((folder / path.name).read_bytes())
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path)
    return path


def test_every_loop_is_compiled_ahead():
    assert {"flow", "tangents.tangent_flow", "lanes.flow", "sparse", SMALL} <= {*prebuilt.units()}
    assert all(cache._module_of(name).UNIT for name in prebuilt.units())


def test_it_is_taken_without_compiling(ready, monkeypatch):
    monkeypatch.setattr(cache, "_loops", {})
    monkeypatch.setattr(cache, "_compiled", lambda name: pytest.fail(f"{name} is compiled"))
    monkeypatch.setattr(cache.place, "read", lambda _: None)
    kept = {}
    monkeypatch.setattr(cache.place, "write", kept.setdefault)
    assert cache.method(SMALL).respond.address
    assert kept == {cache._file(SMALL): prebuilt.found(SMALL)}  # what later processes read


def cut(path, _):
    path.write_bytes(path.read_bytes()[:-9])


def flip(path, _):
    data = bytearray(path.read_bytes())
    data[-20] ^= 4
    path.write_bytes(data)


def other_sources(_, monkeypatch):
    monkeypatch.setattr(prebuilt, "_sources", lambda: b"edited")


def another_processor(_, monkeypatch):
    monkeypatch.setenv("NUMBA_CPU_NAME", "x86-64-v2")
    prebuilt._suits.cache_clear()


def a_lesser_processor(_, monkeypatch):
    monkeypatch.setattr(prebuilt.place.llvm(), "get_host_cpu_features", dict)
    prebuilt._suits.cache_clear()


ATTACKS = [cut, flip, other_sources, another_processor, a_lesser_processor]


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda x: x.__name__)
def test_what_is_not_of_these_sources_and_this_processor_is_not_taken(ready, monkeypatch, attack):
    assert prebuilt.found(SMALL) is not None
    assert prebuilt.found("flow") is None
    attack(ready, monkeypatch)
    prebuilt._loops.cache_clear()
    found = prebuilt.found(SMALL)
    prebuilt._suits.cache_clear()
    assert found is None


@pytest.mark.nightly
def test_a_motion_has_the_same_bits(tmp_path, monkeypatch):
    prebuilt.write(tmp_path, ["flow"])
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path)
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    here = jp.simulate(mechanism, turns=20)
    code, native = prebuilt.found("flow"), cache._found
    assert code != native("flow")
    monkeypatch.setattr(cache, "_loops", {})
    monkeypatch.setattr(cache, "_found", lambda name: code if name == "flow" else native(name))
    there = jp.simulate(mechanism, turns=20)
    for name in ("angle", "angular_velocity", "event_time", "normal_force"):
        assert np.array_equal(here[name], there[name]), name
    assert place.target().cpu != prebuilt.LEVEL


ALONE = """
import sys
import jointplay as jp
from jointplay.solver.codegen import cache
cache._compiled = lambda name: sys.exit(f"{name} is compiled")
run = jp.simulate(jp.catalog.chunmei2002(gear_ratio=3.0), turns=1)
assert "numba" not in sys.modules
print(jp.__file__, float(run["angle"].sel(link="rocker")[-1]).hex())
"""


@pytest.mark.nightly
def test_a_wheel_brings_the_loops_and_runs_without_a_compiler(tmp_path):
    if not prebuilt._suits():
        pytest.skip("this processor cannot run it")
    installed = wheel(Path(__file__).parents[2], tmp_path / "made")
    assert installed, "the benchmark does not find what compiles the loops"
    changes = {"PYTHONPATH": str(installed), "JOINTPLAY_CACHE": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", ALONE], env=os.environ | changes, cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    place, angle = done.stdout.split()
    assert Path(place).is_relative_to(installed)
    run = jp.simulate(jp.catalog.chunmei2002(gear_ratio=3.0), turns=1)
    assert angle == float(run["angle"].sel(link="rocker")[-1]).hex()
