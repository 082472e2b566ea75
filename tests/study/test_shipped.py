"""The studies that come with the project."""

import tomllib
from pathlib import Path

import pytest

from jointplay.study.file import load
from jointplay.study.models import build_mechanism

STUDIES = Path(__file__).parents[2] / "studies"
PANELS = ("03a", "03b", "04", "05a", "05b", "06a", "06b", "07", "08", "09a", "09b", "10", "11a", "11b")
PAPER = {f"fig{panel}" for panel in (*PANELS, "12a", "12b", "12c")} | {"claims", "readings"}


OWN = sorted((STUDIES / "own").glob("*.toml"))  # each has a structure of its own, to be compiled


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_a_shipped_system_is_well_posed(path):
    table = tomllib.loads(path.read_text())
    assert build_mechanism(table["mechanism"]).initial
    assert {"title", "figure"} <= table.keys()


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.nightly) if path in OWN else path
        for path in sorted(STUDIES.rglob("*.toml"))
    ],
    ids=lambda path: path.stem,
)
def test_a_shipped_study_validates_and_is_named_like_its_file(path):
    record = load(path).record
    assert record.name == path.stem
    assert record.title
    assert record.figure["kind"]


def test_every_figure_of_the_paper_has_its_study_and_so_have_its_conclusions():
    assert {path.stem for path in (STUDIES / "paper").glob("*.toml")} >= PAPER


@pytest.mark.parametrize(
    ("name", "clearance", "ratio"), [("a", 2.9e-5, 15.0), ("b", 2.9e-5, 3.0), ("c", 2.9e-4, 3.0)]
)
def test_the_sections_are_those_of_the_caption_of_figure_12(name, clearance, ratio):
    record = load(STUDIES / "paper" / f"fig12{name}.toml").record
    assert record.kind == "section"
    assert record.mechanism.joint("B").clearance == clearance
    assert record.mechanism.drive.gear_ratio == ratio
