"""Sheets of compared figures: same axes, same units, from stored results alone."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import jointplay as jp
from jointplay import figures
from jointplay.display.errors import InputError
from jointplay_lab.reproduce import SHEETS, write_sheets

ROOT = Path(__file__).parents[2]
RESULTS, STUDIES = ROOT / "results" / "paper", ROOT / "studies" / "paper"


def test_results_on_one_sheet_have_one_scale_that_holds_all():
    ideal, loose = (jp.open(RESULTS / f"fig05{letter}.nc") for letter in "ba")
    figure = jp.figure([ideal, loose])
    first, second = (place.axes for place in figure.subfigs)
    for one, other in zip(first, second, strict=True):
        assert [*one.get_xlim(), *one.get_ylim()] == [*other.get_xlim(), *other.get_ylim()]
        for ax in (one, other):
            low, high = ax.get_ylim()
            drawn = np.concatenate([line.get_ydata() for line in ax.lines])
            assert low <= np.nanmin(drawn) <= np.nanmax(drawn) <= high


def test_results_of_unlike_size_are_shown_in_one_unit():
    narrow, wide = (jp.open(RESULTS / f"fig12{letter}.nc") for letter in "ac")
    figure = jp.figure([narrow, wide], kind="poincare_section", joint="B")
    labels = [{ax.get_ylabel() for ax in row} for row in zip(*(p.axes for p in figure.subfigs), strict=True)]
    assert [len(row) for row in labels] == [1, 1]
    assert jp.figure(narrow, kind="poincare_section").axes[1].get_ylabel() not in labels[1]


def test_sections_of_two_clearances_have_the_eccentricity_over_them_in_common():
    both = [jp.open(RESULTS / f"fig12{letter}.nc") for letter in "ac"]
    panels = [place.axes[1] for place in jp.figure(both, kind="poincare_section", joint="B").subfigs]
    assert {ax.get_xlabel() for ax in panels} == {"Eccentricity over clearance"}
    for ax, section, clearance in zip(panels, both, (29e-6, 290e-6), strict=True):
        x = ax.lines[0].get_xdata()
        assert x == pytest.approx(section["eccentricity"].sel(joint="B").values / clearance)
    assert "(µm)" in jp.figure(both[0], kind="poincare_section").axes[1].get_xlabel()


def test_only_results_are_compared():
    with pytest.raises(InputError, match="list of results"):
        jp.figure([jp.open(RESULTS / "fig12a.nc"), 3])


def test_a_sheet_is_written_where_all_its_results_are_there_and_one_is_new(tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "sheet_of", lambda parts: Figure(figsize=(len(parts), 1)))
    for name in ("fig12a", "fig12b", "fig12c", "fig03a"):
        shutil.copy(RESULTS / f"{name}.nc", tmp_path)
    assert write_sheets(STUDIES, tmp_path, ["fig03a", "fig04"]) == []
    written = write_sheets(STUDIES, tmp_path, ["fig12b"])
    assert [path.name for path in written] == ["fig12.pdf", "fig12.png"]
    assert all((STUDIES / f"{part}.toml").exists() for parts in SHEETS.values() for part in parts)
