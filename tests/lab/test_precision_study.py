"""Studies of kind work_precision."""

from __future__ import annotations

from pathlib import Path

import pytest

from jointplay.study import run
from jointplay.study.file import Loaded, load, validate
from jointplay.study.toml_text import override, parse
from tests.support.wrong import texts_of

STUDIES = Path(__file__).parents[2] / "studies" / "precision"
SMALL = """\
kind = "work_precision"
name = "small"

[mechanism]
catalog = "impact_pair"
gap = 2.0
restitution = 0.6

[analysis]
turns = 0.5
tolerances = [1e-5]
peers = []
rounds = 1
initial = [0.1, 0.0]
"""


def problems(*changes):
    """Key and message of each problem."""
    return texts_of(validate, override(parse(SMALL), changes))


def test_what_is_left_out_is_as_in_the_function():
    record = validate({"name": "x", "kind": "work_precision", "mechanism": {"catalog": "chunmei2002"}})
    keywords = record.keywords()
    assert keywords["rtol"] == 1e-13
    assert keywords["peers"] == ("heyoka", "CVODE", "LSODA", "Radau", "DOP853")
    assert len(keywords["tolerances"]) == 9
    assert "9 tolerances, beside heyoka" in record.summary()


def test_a_study_runs():
    found = run.run(Loaded(validate(parse(SMALL)), SMALL))
    assert found.attrs["study"] == "small"
    assert found.error.shape == (1, 1)


def test_every_mistake_is_told_with_its_place():
    found = problems("analysis.tolerances=[1e-8, 1e-5]", "analysis.peers=['LSODE']", "analysis.initial=[0.1]")
    assert set(found) == {"analysis.tolerances", "analysis.peers[0]", "analysis.initial"}
    assert "did you mean 'LSODA'" in found["analysis.peers[0]"]
    assert set(problems("analysis.budget=0", "analysis.rounds=-1")) == {"analysis.budget", "analysis.rounds"}
    assert set(problems("vary.gap=[1.0, 2.0]")) == {"vary"}
    assert "work_precision" in problems('figure.kind="overview"')["figure.kind"]


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.toml")), ids=lambda path: path.stem)
def test_the_shipped_studies(path):
    record = load(path).record
    assert record.analysis.budget <= 60
    assert record.figure["kind"] == "work_precision"
