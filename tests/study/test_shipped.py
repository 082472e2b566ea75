"""The studies that come with the project."""

from pathlib import Path

import pytest

from jointplay.study.file import load

STUDIES = Path(__file__).parents[2] / "studies"
PAPER = {"fig03a", "fig04", "fig05b", "fig07", "fig10", "fig11a", "fig11b", "fig12a", "fig12b", "fig12c"}


@pytest.mark.parametrize("path", sorted(STUDIES.rglob("*.toml")), ids=lambda path: path.stem)
def test_a_shipped_study_validates_and_is_named_like_its_file(path):
    record = load(path).record
    assert record.name == path.stem
    assert record.title
    assert record.figure["kind"]


def test_every_figure_of_the_paper_that_a_rigid_mechanism_can_answer_has_its_study():
    assert {path.stem for path in (STUDIES / "paper").glob("*.toml")} >= PAPER


@pytest.mark.parametrize(
    ("name", "clearance", "ratio"), [("a", 2.9e-5, 15.0), ("b", 2.9e-5, 3.0), ("c", 2.9e-4, 3.0)]
)
def test_the_sections_are_those_of_the_caption_of_figure_12(name, clearance, ratio):
    record = load(STUDIES / "paper" / f"fig12{name}.toml").record
    assert record.kind == "section"
    assert record.mechanism.joint("B").clearance == clearance
    assert record.mechanism.drive.gear_ratio == ratio
