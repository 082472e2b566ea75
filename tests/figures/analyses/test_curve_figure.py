"""Curves in two parameters: through their points, in their directions, over a map of the same plane."""

import numpy as np
import pytest

import jointplay as jp
from jointplay import figures
from jointplay.display.errors import InputError
from jointplay.figures.drawing.artists import through
from tests.figures.analyses.test_bifurcation import sweep
from tests.figures.support.synthetic_branches import branches, curves


def test_a_parabola_is_drawn_between_its_points_too():
    (ax,) = figures.draw(curves()).axes
    x, y = ax.lines[0].get_data()
    assert len(x) > 60
    assert x == pytest.approx(10 * (3 - (y - 3) ** 2), abs=1e-9)  # a cubic is exact on it
    assert ax.lines[1].get_xdata() == pytest.approx(30.0)
    assert ax.get_xlabel() == "Radial clearance (\N{MICRO SIGN}m)"
    named = {handle.get_label(): handle.get_marker() for handle in ax.figure.legends[0].legend_handles}
    assert named["fold doubling"] == "o"


def test_a_cusp_has_no_loop():
    t = np.linspace(-1, 1, 8)
    path = through(np.stack([t**3, t**2], -1), np.stack([3 * t**2, 2 * t], -1))
    assert np.all(np.diff(path[:, 0]) > 0)
    assert path[:, 1].min() >= 0


def test_over_a_map_the_last_parameter_lies_along_x():
    diagram = sweep(("reset",), over=("clearance", "gear_ratio"))
    ax = figures.draw(curves(), over=diagram).axes[0]
    assert "Gear ratio" in ax.get_xlabel()
    x, y = ax.lines[0].get_data()
    assert y == pytest.approx(10 * (3 - (x - 3) ** 2), abs=1e-9)


def test_another_number_of_the_map_lies_underneath():
    diagram = sweep(("reset",), over=("clearance", "gear_ratio"))
    period, impacts = (figures.draw(curves(), over=diagram, shown=name) for name in ("period", "impacts"))
    named = [figure.axes[1].get_xlabel().strip() for figure in (period, impacts)]
    assert named == ["Period (turns; 0: none)", "Contacts begun per turn"]
    with pytest.raises(InputError, match=r"figure\.shown.*impacts"):
        figures.draw(curves(), over=diagram, shown="contacts")


@pytest.mark.parametrize(
    ("kind", "words"), [("grazing", "two grazings"), ("doubling_grazing", "doubling and grazing")]
)
def test_where_curves_meet_is_told_by_both(kind, words):
    found = curves()
    found["meeting_kind"].attrs["flag_meanings"] = kind
    assert words in [text.get_text() for text in figures.draw(found).legends[0].get_texts()]


def test_a_curve_is_seen_on_a_dark_map():
    dark = sweep(("reset",), over=("clearance", "gear_ratio"))
    assert all(line.get_path_effects() for line in figures.draw(curves(), over=dark).axes[0].lines[:2])


def test_what_it_cannot_be_drawn_of_or_over():
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(branches(), kind="curve")
    with pytest.raises(InputError, match=r"figure\.over"):
        figures.draw(curves(), over=sweep(("reset",), over=("clearance", "friction")))


def test_its_answer():
    told = str(jp.summary(curves()))
    assert "fold, 9 points: radial clearance 20 \N{MICRO SIGN}m to 30 \N{MICRO SIGN}m" in told
    assert "fold doubling at (30 \N{MICRO SIGN}m, 3)" in told
