"""What a release consists of agrees with itself: version, changelog, citation, and the paper's references."""

import re
import tomllib
from pathlib import Path

import pytest

import jointplay as jp
from tests.lowest import constraints

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
PAPER = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere():
    version = PROJECT["project"]["version"]
    assert version == jp.__version__
    cited = re.findall(r"^ *version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    assert cited == [version, version]
    assert re.findall(r"^## (\S+)", CHANGELOG, re.M)[0] == version


def test_the_changelog_is_read_in_minutes_and_earlier_versions_have_a_day():
    assert len(CHANGELOG.split()) <= 1500
    first, *earlier = re.findall(r"^## \S+ \((.+)\)$", CHANGELOG, re.M)
    assert first
    assert earlier
    assert all(re.fullmatch(r"\d{4}-\d\d-\d\d", day) for day in earlier)


def test_each_source_of_the_sdist_is_there():
    for name in PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]:
        assert list(ROOT.glob(name.removeprefix("/"))), name


def test_the_paper_cites_what_its_bibliography_has():
    known = re.findall(r"^@\w+\{(\w+),$", (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8"), re.M)
    assert set(re.findall(r"@(\w+)", PAPER)) == set(known)
    assert len(PAPER.split()) <= 1250


@pytest.mark.parametrize("bound", list(constraints(PROJECT["project"])))
def test_each_dependency_has_a_lower_bound_that_is_tried(bound):
    assert re.fullmatch(r"[\w-]+==\d+(\.\d+)+", bound)
