"""One number for each cell of a sweep: what is stored is drawn, what is lacking is seen."""

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import PolyCollection, QuadMesh

from jointplay import figures
from jointplay.display.errors import InputError
from tests.figures.support.synthetic import STATUS, flag_words

AXES = {
    "gear_ratio": (np.array([2.0, 4.0, 6.0]), {"units": "1", "long_name": "gear ratio"}),
    "friction": (np.array([0.0, 0.3]), {"units": "1", "long_name": "friction coefficient"}),
    "clearance": (np.geomspace(1e-5, 1.6e-4, 5), {"units": "m", "long_name": "radial clearance"}),
}
VERDICTS = {"flag_values": np.array([-1, 0, 1], np.int8), "flag_meanings": "undecided regular chaotic"}
CHATTER, CRASHED = 3, 6


def swept(*dims, spoilt=False, kind="lyapunov"):
    """A sweep of two exponents; spoilt: cell 1 failed, 2 crashed, 3 has no value, 4 failed and has one."""
    shape = tuple(AXES[dim][0].size for dim in dims)
    cells = np.arange(np.prod(shape))
    values, status = np.stack([cells - 1.5, -cells - 2.0], -1), np.zeros(cells.size, np.int8)
    if spoilt:
        values[1:4], status[[1, 2, 4]] = np.nan, (CHATTER, CRASHED, CHATTER)
    values, status = values.reshape(*shape, 2), status.reshape(shape)
    inner, ends = (*dims, "exponent"), flag_words(STATUS, "how the cell ended")
    data = {
        "lyapunov_exponent_per_turn": (
            inner,
            values,
            {"units": "1", "long_name": "Lyapunov exponent a turn"},
        ),
        "lyapunov_standard_error_per_turn": (inner, np.full_like(values, 0.25), {"units": "1"}),
        "lyapunov_trace": ((*dims, "block", "exponent"), np.zeros((*shape, 3, 2)), {"units": "s-1"}),
        "period_time": (dims, 1e-3 * (cells.reshape(shape) + 1), {"units": "s", "long_name": "period"}),
        "impacts": (dims, np.where(status, -1, 7), {"units": "1", "long_name": "impacts"}),
        "verdict": (dims, (values[..., 0] > 0).astype(np.int8), VERDICTS | {"long_name": "verdict"}),
        "trouble": (dims, np.full(shape, "")),
        "status": ((), status[status != 0][0] if spoilt else np.int8(0), ends),
        "cell_status": (dims, status, ends),
    }
    coords = {dim: (dim, *AXES[dim]) for dim in dims} | {"exponent": [1, 2]}
    return xr.Dataset(data, coords, {"kind": kind, "swept": " ".join(dims)})


def cases():
    data = swept("clearance").rename(clearance="case").drop_vars("case")
    ratio, clearance = (
        ("case", [3.0, 9.0, 6.0, 1.0, 2.0], AXES["gear_ratio"][1]),
        ("case", *AXES["clearance"]),
    )
    number = ("case", np.arange(5), {"units": "1", "long_name": "number of the case"})
    return data.assign_coords(case=number, gear_ratio=ratio, clearance=clearance).assign_attrs(swept="case")


def refused(dataset, **options):
    with pytest.raises(InputError) as caught:
        figures.draw(dataset, **options)
    return str(caught.value)


def curve(ax):
    """The first line with more than marks, without the one at zero."""
    return next(line for line in ax.lines if line.get_linestyle() != "None" and len(line.get_xdata()) > 2)


def marks(ax):
    """Where the marks below the curves stand, by their shape."""
    low = [line for line in ax.lines if line.get_transform() != ax.transData and line.get_marker() != "None"]
    return {line.get_marker(): np.asarray(line.get_xdata()).tolist() for line in low}


def entries(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def meshes(figure):
    return [m for ax in figure.axes for m in ax.collections if isinstance(m, QuadMesh) and ax.get_ylabel()]


def test_a_curve_shows_the_largest_exponent_with_its_errors_over_a_logarithmic_axis():
    figure = figures.draw(swept("clearance"))
    (ax,) = figure.axes
    np.testing.assert_allclose(curve(ax).get_xdata(), 1e6 * AXES["clearance"][0])
    np.testing.assert_array_equal(curve(ax).get_ydata(), np.arange(5) - 1.5)
    assert (ax.get_xscale(), ax.get_xlabel()) == ("log", "Radial clearance (µm)")
    assert ax.get_ylabel().replace("\n", " ") == "Largest Lyapunov exponent per turn"
    bars = next(each for each in ax.collections if len(each.get_segments()) == 5)
    heights = [np.ptp(segment[:, 1]) for segment in bars.get_segments()]
    np.testing.assert_allclose(heights, 2 * 2 * 0.25)
    assert entries(figure) == ["bars: ± 2 standard errors"]


def test_cells_without_a_number_are_told_apart_below_a_curve():
    figure = figures.draw(swept("clearance", spoilt=True))
    (ax,) = figure.axes
    x = 1e6 * AXES["clearance"][0]
    assert marks(ax) == {"x": [x[1]], "s": [x[2]], "o": [x[3]]}
    (doubtful,) = (line for line in ax.lines if line.get_marker() == "+")
    assert (doubtful.get_xdata(), doubtful.get_ydata()) == ([x[4]], [2.5])
    assert entries(figure) == ["failed", "crashed", "no value", "failed, with a value"]
    assert "in 3 of 5" in figure.get_suptitle()


def test_an_entry_and_a_cut_are_chosen_by_at():
    data = swept("gear_ratio", "clearance")
    (ax,) = figures.draw(data, at={"exponent": 2, "gear_ratio": 3.6}).axes
    np.testing.assert_array_equal(curve(ax).get_ydata(), -np.arange(5, 10) - 2.0)
    assert "exponent 2" in ax.get_ylabel()
    (ax,) = figures.draw(data, at={"exponent": "largest", "gear_ratio": 2}).axes
    np.testing.assert_array_equal(curve(ax).get_ydata(), np.maximum(np.arange(5) - 1.5, -np.arange(5) - 2.0))


def test_two_parameters_make_a_map_and_along_one_of_them_curves():
    data = swept("gear_ratio", "clearance")
    figure = figures.draw(data)
    (mesh,) = meshes(figure)
    np.testing.assert_array_equal(mesh.get_array(), (np.arange(15) - 1.5).reshape(3, 5))
    assert mesh.axes.get_xlabel() == "Radial clearance (µm)"
    assert mesh.axes.get_ylabel() == "Gear ratio"
    assert mesh.norm.vmin == -mesh.norm.vmax  # colours of a signed number meet at 0
    curves = figures.draw(data, along="gear_ratio", at={"clearance": 1e-5})
    np.testing.assert_array_equal(curve(curves.axes[0]).get_ydata(), [-1.5, 3.5, 8.5])
    figure = figures.draw(data, along="clearance")
    assert entries(figure) == ["Gear ratio 2", "Gear ratio 4", "Gear ratio 6"]


def test_cells_without_a_number_have_faces_of_their_own_in_a_map():
    figure = figures.draw(swept("gear_ratio", "clearance", spoilt=True))
    (mesh,) = meshes(figure)
    faces = [each for each in mesh.axes.collections if isinstance(each, PolyCollection)]
    found = {mpl.colors.to_hex(f.get_facecolor()[0]): f.get_paths()[0].vertices.mean(0)[0] for f in faces}
    middles = 1e6 * AXES["clearance"][0]
    assert list(found) == ["#ffffff", "#000000", "#f2f2f2"]
    assert all(
        low < place < high for place, low, high in zip(found.values(), middles, middles[2:], strict=False)
    )
    assert np.ma.getmaskarray(mesh.get_array()).sum() == 3
    assert entries(figure) == ["failed", "crashed", "no value", "failed, with a value"]


def test_a_third_parameter_makes_panels_of_one_scale_in_the_units_shown():
    figure = figures.draw(swept("friction", "gear_ratio", "clearance"), quantity="period_time")
    panels = [ax for ax in figure.axes if ax.get_title(loc="left")]
    assert [ax.get_title(loc="left") for ax in panels] == [
        "Friction coefficient 0",
        "Friction coefficient 0.3",
    ]
    drawn = [next(m for m in ax.collections if isinstance(m, QuadMesh)) for ax in panels]
    np.testing.assert_allclose(np.concatenate([m.get_array().ravel() for m in drawn]), np.arange(1.0, 31.0))
    assert {(m.norm.vmin, m.norm.vmax) for m in drawn} == {(1.0, 30.0)}
    assert any(ax.get_xlabel() == "Period (ms)" for ax in figure.axes)


def test_cases_stand_side_by_side_with_their_values_below():
    (ax,) = figures.draw(cases()).axes
    assert [label.get_text() for label in ax.get_xticklabels()][:2] == ["3\n10", "9\n20"]
    assert ax.get_xlabel() == "Gear ratio\nRadial clearance (µm)"
    (ax,) = figures.draw(cases(), along="gear_ratio").axes
    np.testing.assert_array_equal(curve(ax).get_xdata(), [1, 2, 3, 6, 9])
    np.testing.assert_array_equal(curve(ax).get_ydata(), [1.5, 2.5, -1.5, 0.5, -0.5])


def test_words_stand_for_verdicts_and_no_number_for_the_padding_of_counts():
    (ax,) = figures.draw(swept("clearance"), quantity="verdict").axes
    assert [label.get_text() for label in ax.get_yticklabels()] == ["undecided", "regular", "chaotic"]
    (ax,) = figures.draw(swept("clearance", spoilt=True), quantity="impacts").axes
    np.testing.assert_array_equal(curve(ax).get_ydata(), [7, np.nan, np.nan, 7, np.nan])


def test_verdicts_without_words_are_drawn_as_numbers():
    data = swept("clearance")
    del data["verdict"].attrs["flag_meanings"]
    (ax,) = figures.draw(data, quantity="verdict").axes
    np.testing.assert_array_equal(curve(ax).get_ydata(), [0, 0, 1, 1, 1])
    assert "regular" not in [label.get_text() for label in ax.get_yticklabels()]


def test_the_colours_of_a_map_of_verdicts_are_named_by_their_words():
    data = swept("gear_ratio", "clearance").rename(verdict="kind_of_motion")
    data["kind_of_motion"].attrs["flag_meanings"] = "not_decided regular chaotic"
    _, bar = figures.draw(data, quantity="kind_of_motion").axes
    ticks = dict(zip(bar.get_xticks(), (label.get_text() for label in bar.get_xticklabels()), strict=True))
    assert ticks == {-1: "not decided", 0: "regular", 1: "chaotic"}


def test_quartiles_reach_around_a_median_and_multipliers_have_a_modulus():
    quarters = np.array([[0.1, 0.5, 0.9], [0.2, 0.3, 0.8]])
    data = swept("friction", kind="chaos_test").assign(
        chaos_indicator_quartile=(("friction", "quartile"), quarters)
    )
    (ax,) = figures.draw(data.assign_coords(quartile=[0.25, 0.5, 0.75])).axes
    ends = next(each for each in ax.collections).get_segments()
    np.testing.assert_allclose([segment[:, 1] for segment in ends], quarters[:, [0, 2]])
    parts = np.array([[[0.3, 0.4], [-0.2, 0.0]], [[0.1, 0.0], [0.0, -2.0]]])
    dims = ("friction", "multiplier", "part")
    data = swept("friction", kind="periodic_orbit").assign(floquet_multiplier=(dims, parts))
    (ax,) = figures.draw(data.assign_coords(multiplier=[1, 2], part=["real", "imaginary"])).axes
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [0.5, 2.0])


@pytest.mark.parametrize("kind", ["basins", "tipping"])
def test_the_usual_number_of_motions_is_that_of_the_most_frequent_one(kind):
    """Each cell has motions of its own, in any order; a study is not refused after it was computed."""
    shares = np.array([[0.7, 0.3, np.nan], [0.4, 0.6, np.nan]])
    data = swept("friction", kind=kind).assign(fraction=(("friction", "number"), shares))
    data = data.assign(fraction_reached=(("friction", "number", "within"), shares[..., None] * [0.5, 1.0]))
    (ax,) = figures.draw(data.assign_coords(number=[1, 2, 3], within=[8, 16])).axes
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [0.7, 0.6])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            {"quantity": "verdct"},
            "figure.quantity: got 'verdct'; there is no such quantity; did you mean 'verdict'?",
        ),
        (
            {"quantity": "lyapunov_trace"},
            "figure.at.block: got nothing; an entry along block is accepted: 0, 1, 2",
        ),
        ({"at": {"exponent": 3}}, "figure.at.exponent: got 3; an entry along exponent is accepted: 1, 2"),
        (
            {"at": {"exponnt": 1}},
            "figure.at.exponnt: got 1; there is no such dimension; did you mean 'exponent'?",
        ),
        ({"at": {"clearance": "small"}}, "figure.at.clearance: got 'small'; a value of clearance"),
        ({"kind": "sweep", "at": 2}, "figure.at: got 2; a table"),
        (
            {"along": "claerance"},
            "figure.along: got 'claerance'; there is no such varied parameter; did you mean",
        ),
        ({"column": "triple"}, "figure.column: got 'triple'"),
        ({"kind": "lyapunov"}, "result: got 'a sweep over gear_ratio, clearance'; one cell is drawn"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_what_can(options, said):
    assert said in refused(swept("gear_ratio", "clearance"), **options)


def test_what_is_no_sweep_and_has_no_usual_number_is_refused():
    one = swept("clearance").isel(clearance=0).drop_vars("clearance")
    assert "with [vary]" in refused(one, kind="sweep")
    assert "figure.quantity: got nothing; one of" in refused(swept("clearance", kind="section"), kind="sweep")
    assert "one cell is drawn" in refused(swept("clearance", kind="section"))
    many = swept("gear_ratio", "clearance").isel(gear_ratio=[0, 1, 2, 0, 1])
    assert "so that at most 4 curves are left" in refused(many, along="clearance")
