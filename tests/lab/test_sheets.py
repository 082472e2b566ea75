"""Sheets of compared figures: same axes, same units, from stored results alone."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import jointplay as jp
from jointplay import figures
from jointplay.display.errors import InputError
from jointplay_lab import reproduce
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


def written(name, tmp_path, monkeypatch):
    """A sheet as `reproduce` draws it of the stored results."""
    found = {}
    monkeypatch.setattr(reproduce, "write_figure", lambda figure, path: found.setdefault(path.stem, figure))
    monkeypatch.setattr(reproduce, "SHEETS", {name: SHEETS[name]})
    write_sheets(STUDIES, RESULTS, SHEETS[name].parts)
    return found[name]


def test_steady_forces_stand_beside_each_other_on_one_scale(tmp_path, monkeypatch):
    figure = written("fig05_06", tmp_path, monkeypatch)
    panels = [ax for place in figure.subfigs for ax in place.axes]
    assert len(panels) == 4
    assert len({(*ax.get_xlim(), *ax.get_ylim()) for ax in panels}) == 1
    rigid, elastic = (np.max(panels[n].lines[0].get_ydata()) for n in (1, 3))
    assert panels[0].get_ylim()[1] > rigid > elastic > 30
    boxes = [ax.get_window_extent() for ax in panels]
    assert boxes[1].x0 > boxes[0].x1
    assert [boxes[n].y0 for n in (0, 2)] == pytest.approx([boxes[n].y0 for n in (1, 3)])


def test_damping_is_seen_where_both_curves_lie_in_one_panel(tmp_path, monkeypatch):
    figure = written("fig08_09b", tmp_path, monkeypatch)
    for ax, (first, last) in zip(figure.axes, [(0.0, 0.01), (0.01, 0.02)], strict=True):
        free, damped = ax.lines
        assert free.get_color() != damped.get_color()
        assert free.get_linewidth() > damped.get_linewidth()
        assert len(ax.child_axes) == 1
        for line, name in ((free, "fig08"), (damped, "fig09b")):
            stored = jp.open(RESULTS / f"{name}.nc").deflection.sel(link="coupler")
            part = stored.where((stored.time >= first) & (stored.time <= last), drop=True)
            assert line.get_ydata() == pytest.approx(1e6 * part.values)
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert [word[-8:] for word in words] == ["(Fig. 8)", "Fig. 9b)"]


def test_a_single_section_has_the_limits_that_are_asked_for():
    data, options = jp.open(RESULTS / "fig12b.nc"), {"xlim": [2e-5, 3e-5], "ylim": [-0.1, 0.2]}
    panel = jp.figure(data, kind="poincare_section", **options).axes[1]
    assert (*panel.get_xlim(), *panel.get_ylim()) == pytest.approx((20, 30, -100, 200))
    with pytest.raises(InputError, match=r"figure\.xlim"):
        jp.figure(data, kind="poincare_section", xlim=[1, 0])


def test_only_results_are_compared():
    with pytest.raises(InputError, match="list of results"):
        jp.figure([jp.open(RESULTS / "fig12a.nc"), 3])


def test_a_sheet_is_written_where_all_its_results_are_there_and_one_is_new(tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "sheet_of", lambda parts, **_: Figure(figsize=(len(parts), 1)))
    for name in ("fig12a", "fig12b", "fig12c", "fig03a"):
        shutil.copy(RESULTS / f"{name}.nc", tmp_path)
    assert write_sheets(STUDIES, tmp_path, ["fig03a", "fig04"]) == []
    written = write_sheets(STUDIES, tmp_path, ["fig12b"])
    assert [path.name for path in written] == ["fig12.pdf", "fig12.png"]
    assert all((STUDIES / f"{part}.toml").exists() for sheet in SHEETS.values() for part in sheet.parts)
