"""Settings that analyses share: a keyword of all of them is three lines of one file."""

import inspect
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Unpack

import pytest

import jointplay as jp
from jointplay.analysis.keywords import Motion, analysis
from jointplay.kinds import KINDS

SOURCES = Path(jp.__file__).parents[1]
DOCS = SOURCES.parent / "docs"
PLACE = "jointplay/analysis/keywords.py"
LINES = (  # where in its file each of the three goes, and what it is
    (
        "    progress : bool or callable, optional\n",
        "    patience_s : float\n        How long anybody waits.\n",
    ),
    ("    progress: Annotated[Progress", "    patience_s: Annotated[Positive, Usual(4.5)]\n"),
)
LOOK = """
import inspect, json, sys
sys.path.insert(0, sys.argv[1])
import jointplay as jp
from jointplay.kinds import KINDS
from jointplay.study.file import schema
from jointplay.study.new import new
from pages import kinds
tables = schema()["$defs"]
def said(row):
    table = row.name.title().replace("_", "") + "Analysis"
    try:
        row.function(None, patience_s=-1.0)
    except jp.InputError as error:
        refused = [problem.key for problem in error.problems]
    return {
        "signature": str(inspect.signature(row.function).parameters["patience_s"]),
        "help": "patience_s : float\\n    How long anybody waits." in row.function.__doc__,
        "schema": tables[table]["properties"]["patience_s"],
        "new": "# patience_s = 4.5" in new(row.name, "trial"),
        "page": "How long anybody waits" in kinds.tables(row),
        "refused": "patience_s" in refused,
    }
json.dump({row.name: said(row) for row in KINDS.values()}, sys.stdout)
"""


@pytest.mark.nightly
def test_a_keyword_of_all_analyses_is_three_lines_of_one_file(tmp_path):
    for package in ("jointplay", "jointplay_lab"):
        shutil.copytree(
            SOURCES / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__", "*.o")
        )
    text = (tmp_path / PLACE).read_text(encoding="utf-8")
    assert sum(added.count("\n") for _, added in LINES) == 3
    for place, added in LINES:
        assert text.count(place) == 1
        text = text.replace(place, added + place)
    (tmp_path / PLACE).write_text(text, encoding="utf-8")
    command = [sys.executable, "-c", LOOK, str(DOCS)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert found.keys() == KINDS.keys()
    for kind, said in found.items():
        assert said.pop("signature") == "patience_s: 'Positive' = 4.5", kind
        described = said.pop("schema")
        assert described["default"] == 4.5, kind
        assert described["description"] == "How long anybody waits.", kind
        assert all(said.values()), (kind, said)


def test_a_default_of_ones_own_is_that_of_signature_call_and_study_file():
    assert inspect.signature(jp.chaos_test).parameters["rtol"].default == 1e-10
    assert jp.chaos_test.fields()["rtol"][1] == 1e-10
    assert inspect.signature(jp.simulate).parameters["rtol"].default == 1e-8
    found = jp.chaos_test(jp.catalog.impact_pair(3.0, 0.8), turns=2)
    assert found.attrs["rtol"] == 1e-10


def test_a_default_of_no_keyword_is_refused_where_it_is_written():
    with pytest.raises(TypeError, match="trial takes no tolerence"):

        @analysis(usual={"tolerence": 1e-3})
        def trial(mechanism, **motion: Unpack[Motion]):
            """Nothing."""


def test_what_an_analysis_says_itself_of_a_shared_keyword_is_said_once():
    doc = jp.bifurcation.__doc__
    assert doc.count("\nrtol : float\n") == 1
    assert "costs four fifths of 1e-8" in doc
    assert doc.index("\ninitial : mapping or sequence, optional\n") < doc.index("\nReturns\n")
