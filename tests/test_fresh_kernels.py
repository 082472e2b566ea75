"""Compiled kernels are never stale: an edit shows in the next process, and no edit compiles nothing."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import jointplay

PACKAGE = Path(jointplay.__file__).parent
SCRIPT = """
import json
from jointplay import catalog, simulate
end = simulate(catalog.{system}, duration={duration}, rtol=1e-9, at=[{duration}], record={record})
end = end.isel(time=-1)
print(json.dumps([float(x) for name in {record} for x in end[name].values]))
"""
KERNEL = """
import json
import numpy as np
from jointplay.solver.codegen import cache
step, rows = np.ones((1, 2, 4)), np.arange(1.0, 7.0).reshape(3, 2, 1)
cache.method("modal_response").respond(step, *rows)
print(json.dumps(rows.ravel().tolist()))
"""
WARM = """
from jointplay import catalog
from jointplay.analysis.cells import warm
from jointplay.solver.mechanism.assemble import assemble
warm(map(assemble, (catalog.duffing(), catalog.lorenz(), catalog.duffing(damping=0.1))))
print("null")
"""
BALL = {"system": "duffing()", "duration": 3.0, "record": ["state_value"]}
LINKAGE = {
    "system": "chunmei2002(gear_ratio=3.0, friction=0)",
    "duration": 0.002,
    "record": ["angle", "angular_velocity"],
}


@pytest.fixture
def copy(tmp_path):
    """A copy of the package that may be edited, beside an empty cache."""
    shutil.copytree(PACKAGE, tmp_path / "jointplay", ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def run(folder, what, **variables):
    """End state of a small run in a process of its own."""
    return answer(folder, SCRIPT.format(**what), **variables)


def answer(folder, script, **variables):
    """What a script prints in a process of its own, with the copy of the package and its cache."""
    own = {"PYTHONPATH": str(folder), "JOINTPLAY_CACHE": str(folder / "cache")} | variables
    plain = {k: v for k, v in os.environ.items() if k not in ("JOINTPLAY_KERNELS", "NUMBA_CACHE_DIR")}
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=plain | own,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def edit(folder, file, old, new):
    """Replace text that occurs once in a file of the copy."""
    path = folder / "jointplay" / file
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def compiled(folder):
    """Every file of the cache with its time of change."""
    return {path: path.stat().st_mtime_ns for path in (folder / "cache").rglob("*") if path.is_file()}


@pytest.mark.long
def test_no_edit_compiles_nothing_and_an_edit_shows(copy):
    unedited(copy, answer, KERNEL, "solver/method/modal_response.py", "c[0, 2] * a", "c[0, 2] * a * 2")


@pytest.mark.nightly
def test_no_edit_compiles_nothing_and_an_edit_of_the_method_shows(copy):
    unedited(copy, run, BALL, "solver/method/control.py", "SAFETY * error **", "0.5 * SAFETY * error **")


def unedited(copy, ask, what, file, old, new):
    """The same answer, and nothing compiled, until the file is edited."""
    first, files = ask(copy, what), compiled(copy)
    assert any(path.suffix == ".o" for path in files)
    assert ask(copy, what) == first
    assert compiled(copy) == files
    edit(copy, file, old, new)
    assert ask(copy, what) != first
    folders = {path.relative_to(copy / "cache").parts[0] for path in compiled(copy)}
    assert len(folders) == 2


@pytest.mark.nightly
def test_what_is_warmed_is_made_by_no_other_process(copy):
    answer(copy, WARM, NUMBA_DISABLE_JIT="1")
    files = compiled(copy)
    for system in ("duffing()", "lorenz()"):
        run(copy, BALL | {"system": system, "duration": 0.01}, NUMBA_DISABLE_JIT="1")
    assert compiled(copy) == files


@pytest.mark.nightly
def test_an_edit_of_an_equation_shows(copy):
    first = run(copy, LINKAGE)
    edit(
        copy,
        "solver/equations/chain.py",
        'yield k, -GRAVITY * number(f"mu_{k}")',
        'yield k, GRAVITY * number(f"mu_{k}")',
    )
    assert max(abs(a - b) for a, b in zip(run(copy, LINKAGE), first, strict=True)) > 1e-6


@pytest.mark.nightly
def test_a_cache_that_cannot_be_written_costs_only_time(copy):
    (copy / "cache").write_text("not a folder")
    assert run(copy, BALL, HOME=str(copy))


@pytest.mark.nightly
@pytest.mark.parametrize("what", [BALL, LINKAGE])
def test_uncompiled_python_gives_the_same_motion(tmp_path, what):
    """The method as ordinary Python: the slow twin of the kernels."""
    slow = run(PACKAGE.parent, what, NUMBA_DISABLE_JIT="1", JOINTPLAY_CACHE=str(tmp_path / "slow"))
    fast = run(
        PACKAGE.parent, what, JOINTPLAY_CACHE=os.environ.get("JOINTPLAY_CACHE", str(tmp_path / "fast"))
    )
    scale = max(map(abs, fast))
    assert slow == pytest.approx(fast, abs=1e-9 * scale)
