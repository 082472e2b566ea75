"""Provenance: complete, plain, and the same for identical runs."""

import json
import shutil
import subprocess

import pytest
import xarray as xr

import jointplay as jp
from jointplay.jobs.origin import version
from jointplay.solver.mechanism.records import TestSystem
from jointplay.study.results import provenance


def test_the_record_is_plain_json_and_does_not_change_between_runs():
    given = xr.Dataset(), {"kind": "response"}, "kind = 'response'"
    first, second = (provenance.attach(*given).attrs["provenance"] for _ in range(2))
    assert first == second
    record = json.loads(first)
    assert record["study"] == {"kind": "response"}
    assert record["study_text"] == "kind = 'response'"
    assert set(record["environment"]) == {"python", "numpy", "numba", "llvmlite", "platform", "processor"}
    assert set(record["software"]) == {"name", "version", "git"}


def test_without_git_there_is_no_description(tmp_path, monkeypatch):
    assert provenance.git_describe(tmp_path) is None
    monkeypatch.setenv("PATH", str(tmp_path))
    assert provenance.git_describe() is None


@pytest.mark.skipif(shutil.which("git") is None, reason="needs git")
def test_a_changed_checkout_is_called_dirty_and_a_foreign_one_is_not_described(tmp_path):
    def git(*words):
        subprocess.run(
            ["git", "-C", tmp_path, "-c", "user.name=x", "-c", "user.email=x@y", *words], check=True
        )

    package = tmp_path / "src" / "jointplay"
    package.mkdir(parents=True)
    (package / "a.py").write_text("1")
    git("init", "-q")
    git("add", ".")
    git("commit", "-qm", "first")
    clean = provenance.git_describe(package)
    (package / "a.py").write_text("2")
    assert clean
    assert provenance.git_describe(package) == f"{clean}-dirty"
    installed = tmp_path / "lib" / "jointplay"
    installed.mkdir(parents=True)
    assert provenance.git_describe(installed) is None


def test_a_result_says_in_plain_attributes_what_made_it():
    text = "kind = 'response'\n"
    told = provenance.attach(xr.Dataset(), {"kind": "response", "name": "small"}, text).attrs
    assert told["study_toml"] == text
    assert told["history"] == f"{told['source']}: jointplay run small.toml"
    assert provenance.read(xr.Dataset(attrs=told))["study_text"] == text


def test_what_python_computes_says_of_what_and_how():
    pair = jp.catalog.impact_pair(3.6, 0.8)
    cut = jp.poincare(pair, turns=2, initial=(0.0, 0.5), rtol=1e-9)
    plane = jp.bifurcation(pair, over={"gap": [3.6]}, turns=2, n_jobs=1, rtol=1e-9)
    for found in (cut, plane):
        assert TestSystem.model_validate_json(found.attrs["mechanism"]) == pair
        assert found.attrs["rtol"] == 1e-9
        assert found.attrs["source"] == f"jointplay {version('jointplay')}"
