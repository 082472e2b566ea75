"""Divergence, fields of exponents and basins: what is stored is what is drawn."""

import matplotlib.colors
import numpy as np
import pytest
import xarray as xr
from matplotlib.lines import Line2D

from jointplay import figures
from jointplay.display.errors import InputError
from jointplay.figures.analyses.basins import COLOURS
from jointplay.figures.analyses.parameter_map import signs
from tests.figures.support.synthetic import STATUS, flag_words

X = {"units": "1", "long_name": "journal centre over clearance, x"}
Y = {"units": "rad", "long_name": "crank angle"}


def divergence(growth=0.5, level=0.1):
    turn = np.arange(21.0)
    mean = np.minimum(np.log(1e-9) + 1.2 * turn, np.log(level))
    distance = np.exp(mean)[None, None] * np.array([0.5, 1.0, 2.0])[None, :, None]
    data = {
        "distance": (("reference", "neighbour", "turn"), distance, {"units": "1"}),
        "mean_log_distance": ("turn", mean, {"units": "1"}),
        "fitted_log_distance": ("turn", np.where((turn > 1) & (turn < 12), mean, np.nan), {"units": "1"}),
        "growth": ((), growth),
        "growth_standard_error": ((), 0.034),
        "saturation": ((), level),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    return xr.Dataset(data, {"turn": turn}, {"kind": "sensitivity"})


def field(low=-1.0):
    values = np.linspace(low, 2.0, 12).reshape(4, 3)
    values[0, 0] = np.nan
    status = np.where(np.isnan(values), 3, 0).astype(np.int8)
    dims = ("journal_x", "crank_angle")
    data = {
        "finite_time_exponent": (dims, 10 * values, {"units": "s-1"}),
        "finite_time_exponent_per_turn": (dims, values, {"units": "1"}),
        "field_turns": ((), 3),
        "node_status": (dims, status, flag_words(STATUS, "outcome")),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    coords = {
        "journal_x": ("journal_x", np.arange(4.0), X),
        "crank_angle": ("crank_angle", np.arange(3.0), Y),
    }
    return xr.Dataset(data, coords, {"kind": "sensitivity"})


def basins(count=2):
    dims, number = ("journal_x", "crank_angle"), np.arange(1, count + 1)
    labels = np.arange(12).reshape(4, 3) % (count + 1)
    hits = np.bincount(labels.ravel(), minlength=count + 1)[1:]
    status = np.where(labels == 0, 3, 0).astype(np.int8)
    points = np.full((count, 3, 2), np.nan)
    points[:, 0] = np.stack([number, np.full(count, np.pi / 4)], -1)
    data = {
        "attractor": (dims, labels.astype(np.int32), {"units": "1"}),
        "node_status": (dims, status, flag_words(STATUS, "outcome")),
        "period": ("number", number % 3),
        "count": ("number", hits),
        "fraction": ("number", hits / 12),
        "fraction_standard_error": ("number", np.full(count, 0.02)),
        "fraction_none": ((), 1 - hits.sum() / 12),
        "section_plane": (("number", "point", "axis"), points),
        "boundary_dimension": ((), 1.63),
        "uncertainty_exponent_standard_error": ((), 0.04),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    coords = {
        "journal_x": ("journal_x", np.arange(4.0), X),
        "crank_angle": ("crank_angle", np.arange(3.0), Y),
    }
    return xr.Dataset(data, coords | {"number": number}, {"kind": "basins"})


def names(figure):
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


@pytest.mark.long
def test_every_neighbour_the_mean_and_the_fit_are_drawn():
    data = divergence()
    figure = figures.draw(data)
    (ax,) = figure.axes
    assert ax.get_yscale() == "log"
    drawn = [line.get_ydata() for line in ax.lines]
    for line, stored in zip(drawn[:3], data.distance.values[0], strict=True):
        np.testing.assert_array_equal(line, stored)
    np.testing.assert_allclose(drawn[3], np.exp(data.mean_log_distance.values))
    np.testing.assert_allclose(drawn[4], np.exp(data.fitted_log_distance.values))
    assert ax.lines[3].get_linewidth() > 2 * ax.lines[0].get_linewidth()
    assert names(figure) == ["neighbours", "mean logarithm", "growth 0.500 ± 0.034 per turn", "stays at 0.1"]


def test_a_long_legend_stands_inside_the_picture():
    data = divergence(-0.001234567, 1.234e-5).assign(growth_standard_error=((), 3.4e-7))
    figure = figures.draw(data)
    figure.draw_without_rendering()
    (box,) = (each.get_window_extent() for each in figure.legends)
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1


def test_what_is_not_known_is_not_drawn():
    figure = figures.draw(divergence(np.nan, np.nan), {"neighbours": False})
    assert names(figure) == ["mean logarithm"]


def mesh(figure):
    return figure.axes[0].collections[0]


def test_a_field_has_its_first_coordinate_along_x():
    data = field()
    figure = figures.draw(data)
    drawn = mesh(figure).get_array()
    np.testing.assert_array_equal(drawn.mask, np.isnan(data.finite_time_exponent_per_turn.values.T))
    np.testing.assert_array_equal(
        drawn.compressed(), data.finite_time_exponent_per_turn.values.T[~drawn.mask]
    )
    ax, bar = figure.axes
    assert ax.get_xlabel().startswith("Journal centre over clearance, x")
    assert ax.get_ylabel() == "Crank angle (deg)"
    assert ax.get_ylim()[1] == pytest.approx(np.degrees(2.5))
    assert bar.get_ylabel() == "Exponent per turn, over 3 turns"
    assert ax.get_title(loc="left") == "chatter: 1"
    assert len(bar.lines) == 1


def test_a_field_per_second_has_units_and_no_line_at_zero_without_signs():
    figure = figures.draw(field(0.1), per="second")
    assert figure.axes[1].get_ylabel() == "Exponent, over 3 turns (s-1)"
    assert not figure.axes[1].lines


def test_basins_have_a_colour_an_entry_and_a_mark_each():
    data = basins()
    figure = figures.draw(data)
    np.testing.assert_array_equal(mesh(figure).get_array().ravel(), data.attractor.values.T.ravel())
    assert names(figure) == [
        "1: period 1, 33.3 ± 2.0 %",
        "2: period 2, 33.3 ± 2.0 %",
        "none (chatter: 4)",
    ]
    marks = [line for line in figure.axes[0].lines if line.get_markeredgecolor() == "white"]
    assert [line.get_markerfacecolor() for line in marks] == list(COLOURS[:2])
    assert [line.get_xydata().tolist() for line in marks] == [[[1.0, 45.0]], [[2.0, 45.0]]]
    assert figure.axes[0].get_title(loc="left") == "Boundary's dimension 1.630 ± 0.040"
    assert not figures.draw(data, {"points": False}).axes[0].lines


def test_more_attractors_than_colours_are_counted():
    figure = figures.draw(basins(10))
    assert names(figure)[-2:] == ["2 more", "none (chatter: 2)"]
    assert len(names(figure)) == len(COLOURS) + 2
    assert mesh(figure).get_array().max() == len(COLOURS) + 1


def test_attractors_differ_in_lightness_from_the_next():
    light = [np.dot([0.3, 0.59, 0.11], [int(c[i : i + 2], 16) / 255 for i in (1, 3, 5)]) for c in COLOURS]
    assert np.abs(np.diff(light)).min() > 0.3
    assert np.diff(sorted(light)).min() > 0.1  # and from all others


def test_the_sign_of_an_exponent_is_told_in_grey():
    grey = signs()(np.linspace(0, 1, 256))[:, :3] @ [0.3, 0.59, 0.11]
    assert grey[:128].min() > grey[128:].max() + 0.1
    assert np.all(np.diff(grey[:128]) >= 0)
    assert np.all(np.diff(grey[128:]) <= 0)


def test_what_is_drawn_by_itself_is_what_there_is():
    assert figures.usual_kind(field()) == "field"
    assert figures.usual_kind(divergence()) == "divergence"
    assert figures.usual_kind(field().assign(divergence().data_vars)) == "divergence"


@pytest.mark.parametrize(
    ("data", "options"),
    [
        (field(), {"kind": "divergence"}),
        (divergence(), {"kind": "field"}),
        (divergence(), {"kind": "basins"}),
        (field(), {"per": "minute"}),
        (basins(), {"points": 3}),
        (divergence(), {"neighbours": "all"}),
    ],
)
def test_what_cannot_be_drawn_is_refused(data, options):
    with pytest.raises(InputError, match="figure"):
        figures.draw(data, options)


def coexisting():
    """Two motions over a clearance, the second from the third value on; some starts do not settle."""
    dims, x = ("clearance", "identity"), np.linspace(1e-4, 2e-4, 5)
    there = np.array([[True, n > 1] for n in range(5)])
    points = np.where(there[..., None], np.array([0.2, -0.4])[None, :, None] + 0.01 * np.arange(3), np.nan)
    share = np.where(there, np.array([0.7, 0.2]), np.nan)
    growth = np.where(there, np.array([-0.4, 0.3]), np.nan)[..., None]
    data = {
        "journal_x": ((*dims, "point"), 1e-4 * points, {"units": "m", "long_name": "journal centre, x"}),
        "period": (dims, np.where(there, np.array([1, 0]), -1), {"units": "1"}),
        "fraction": (dims, share, {"units": "1"}),
        "fraction_unsettled": ("clearance", np.full(5, 0.1), {"units": "1"}),
        "section_exponent_per_turn": ((*dims, "multiplier"), growth, {"units": "1"}),
        "section_standard_error_per_turn": ((*dims, "multiplier"), 0.01 + 0 * growth, {"units": "1"}),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    coords = {
        "clearance": ("clearance", x, {"units": "m", "long_name": "clearance"}),
        "identity": ("identity", np.array([1, 2]), {"units": "1"}),
    }
    return xr.Dataset(data, coords, {"kind": "attractors"})


def test_attractors_have_points_and_bands_in_one_colour():
    above, middle, below = figures.draw(coexisting()).axes
    for n, line in enumerate(above.lines):
        x, y = line.get_data()
        assert len(x) == 15 - 6 * n
        assert y == pytest.approx(np.tile([[20, 21, 22], [-40, -39, -38]][n], len(x) // 3))
    bands = [each.get_facecolor()[0] for each in below.collections]
    assert [line.get_color() for line in above.lines] == [matplotlib.colors.to_hex(c) for c in bands[:2]]
    heights = [each.get_paths()[0].get_extents().ymax for each in below.collections]
    assert heights == pytest.approx([0.7, 0.9, 1.0])
    assert len(middle.lines) == 3
    assert below.get_xlim() == pytest.approx((87.5, 212.5))
    named = [line for line in above.figure.legends[0].findobj(Line2D) if line.get_marker() != "None"]
    looks = [[(line.get_marker(), line.get_color()) for line in each] for each in (above.lines, named)]
    assert looks[0] == looks[1], "the legend names bands and points"


def test_motions_without_a_period_share_a_colour_and_a_name():
    """Windows part chaos into motions with numbers of their own; the reader is shown one."""
    data = coexisting().sel(identity=[1, 2, 2]).assign_coords(identity=[1, 2, 3])
    above = figures.draw(data).axes[0]
    first, second, third = (line.get_color() for line in above.lines)
    assert second == third != first
    words = [text.get_text() for text in above.figure.legends[0].get_texts()]
    assert words == ["1: period 1", "no period", "not settled"]


def test_attractors_need_a_result_of_that_kind():
    with pytest.raises(InputError, match="kind attractors"):
        figures.draw(basins(), kind="attractors")


def tipped():
    """Two motions and three kinds of knock, of which one does not tip the second."""
    dims = ("number", "knock")
    data = {
        "knock_size": (dims, np.array([[0.2, 0.1, 3e-5], [0.4, np.nan, 5e-5]]), {"units": "1"}),
        "knock_units": ("knock", np.array(["N m s", "N m s", "m"])),
        "knock_reaches": (dims, np.array([[2, 2, 2], [1, -1, 1]]), {"units": "1"}),
        "knock_confirmed": (dims, np.array([[1, 0, 1], [1, 0, 1]]), {"units": "1"}),
        "period": ("number", np.array([1, 0]), {"units": "1"}),
        "fraction_reached": (("number", "within"), np.array([[0.1, 0.5], [0.0, 0.4]]), {"units": "1"}),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    coords = {"number": [1, 2], "knock": ["impulse:crank", "impulse:coupler", "shift:B"], "within": [8, 16]}
    return xr.Dataset(data, coords, {"kind": "tipping"})


def test_knocks_have_a_bar_for_each_motion_in_their_units():
    impulses, shifts, times = figures.draw(tipped()).axes
    heights = [bar.get_height() for bar in impulses.patches]
    assert heights == pytest.approx([0.2, 0.1, 0.4, np.nan], nan_ok=True)
    assert [bar.get_height() for bar in shifts.patches] == pytest.approx([30, 50])
    assert [text.get_text() for text in impulses.texts] == ["\u21922", "\u21922?", "\u21921", "none"]
    assert [label.get_text() for label in impulses.get_xticklabels()] == ["crank", "coupler"]
    named = [(ax.get_ylabel().replace("\n", " "), ax.get_xlabel()) for ax in (impulses, shifts)]
    wanted = ("Smallest angular impulse (N m s)", "Link"), ("Smallest shift of the journal (µm)", "Joint")
    assert named == [*wanted]
    assert [line.get_ydata().tolist() for line in times.lines] == [[0.1, 0.5], [0.0, 0.4]]
