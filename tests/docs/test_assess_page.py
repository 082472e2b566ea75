"""The page of `assess` in the documentation is what a run prints."""

import re
from pathlib import Path

import pytest

import jointplay as jp
from jointplay.analysis.assessment.page import page
from jointplay.study.file import load

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "studies" / "assess" / "assess_slider_crank.toml"
NUMBER = re.compile(r"\d+(?:\.\d+)?")
NEAR = 0.02  # of a number: counts of values looked at differ a little between processors


@pytest.fixture(scope="module")
def made():
    record = load(str(STUDY)).record
    given = record.keywords() | {"budget": 1e6, "n_jobs": 2}
    found = jp.assess(record.mechanism, **given)
    return page(found.assign_attrs(title=record.title))


def words(line):
    """The line with its numbers left out, and spaces that align columns."""
    return re.sub(r"\s+", " ", NUMBER.sub("#", line)).strip()


@pytest.mark.nightly
def test_the_page_is_what_a_run_prints(made):
    text = (ROOT / "docs" / "analyses.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```\w*\n(.*?)^```$", text, re.S | re.M)
    (block,) = (block for block in blocks if "What it hangs on" in block)
    printed = filter(str.strip, made.splitlines())
    for line in filter(str.strip, block.splitlines()):  # of which the page leaves some out
        other = next((other for other in printed if words(other) == words(line)), None)
        assert other, line
        numbers = ([float(each) for each in NUMBER.findall(text)] for text in (line, other))
        assert next(numbers) == pytest.approx(next(numbers), rel=NEAR)
