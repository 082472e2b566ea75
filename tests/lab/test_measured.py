"""Measured numbers of the documentation: each is on file with the study that it was measured with."""

import csv
from collections import Counter
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = spec_from_file_location("measured", ROOT / "docs" / "measured.py")
measured = module_from_spec(SCRIPT)
SCRIPT.loader.exec_module(measured)
NUMBERS = measured.stored()


def marks(page):
    """Study and name of every marked number of a page."""
    return [mark[1].split(".") for mark in measured.MARK.finditer(page.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("page", measured.PAGES, ids=lambda page: page.name)
def test_marked_numbers_are_those_on_file(page):
    text = page.read_text(encoding="utf-8")
    assert text.count("<!--=") == len(marks(page)) == text.count("<!--/-->")
    assert measured.marked(text, NUMBERS) == text, "run docs/measured.py"


@pytest.mark.parametrize("study", NUMBERS)
def test_the_studies_are_those_that_were_measured(study):
    expected = f"run the study {study} anew, then docs/measured.py with the folder of its result"
    assert NUMBERS[study]["study"] == measured.study_digest(study), expected


def test_nothing_is_on_file_that_no_page_states_and_no_study_gives():
    stated = {study for page in measured.PAGES for study, _ in marks(page)}
    assert stated == set(NUMBERS) == set(measured.STUDIES)


def test_numbers_of_results_that_come_with_the_project_are_theirs():
    found = {
        path.stem: measured.measured(path.stem, path)
        for path in (ROOT / "results" / "paper").glob("*.nc")
        if path.stem in measured.STUDIES
    }
    assert found
    assert {study: NUMBERS[study] for study in found} == found


def test_the_page_of_the_tests_counts_the_broken_lines_that_they_notice():
    rows = list(csv.DictReader((ROOT / "tests" / "mutation" / "sample.csv").open(newline="")))
    kernels, others = Counter(), Counter()
    for row in rows:
        place = kernels if {"method", "codegen", "equations"} & {*row["file"].split("/")} else others
        place[{"timeout": "killed"}.get(row["verdict"], row["verdict"])] += 1
    told = (
        f"Of the sample's {len(rows)} lines {kernels.total()} are of `method`, `codegen` and `equations`: "
        f"{kernels['killed']} of these are noticed, and {kernels['survived']} are explained. Of the other "
        f"{others.total()}, {others['killed']} are noticed, and each of the {others['survived']} that are "
        "not is explained."
    )
    assert told in " ".join((ROOT / "docs" / "testing.md").read_text(encoding="utf-8").split())
    assert kernels.keys() | others.keys() <= {"killed", "survived"}
    assert all(row["explanation"] for row in rows if row["verdict"] == "survived")


@pytest.mark.nightly
def test_a_study_run_anew_gives_the_numbers_on_file(tmp_path):
    from jointplay.cli import main

    (study,) = (ROOT / "studies").rglob("periodic_orbit_12b.toml")
    assert main(["run", str(study), "--out", str(tmp_path), "--no-figure"]) == 0
    assert measured.measured(study.stem, tmp_path / f"{study.stem}.nc") == NUMBERS[study.stem]
