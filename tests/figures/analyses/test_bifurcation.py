"""Bifurcation diagrams and maps: what is drawn is what is stored, in friendly units."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from jointplay import figures
from jointplay.display.errors import InputError
from jointplay.figures.analyses.bifurcation import diagram
from jointplay.figures.drawing import style, sweep_axes
from jointplay.kinds import KINDS
from tests.figures.support.synthetic import response
from tests.support.wrong import refused

MEANINGS = "ok diverged step_limit chatter not_converged bad_parameters crashed not_run interrupted"
CLEARANCES = np.geomspace(1e-5, 9e-4, 5)


def named(dims, values, units, name):
    return dims, values, {"units": units, "long_name": name}


def sweep(directions=("up", "down"), starts=1, exponents=1, over=("clearance",)):
    """A made-up result: every value tells where it is stored."""
    sizes = {"gear_ratio": 3, "clearance": 5, "direction": len(directions), "start": starts, "point": 4}
    dims = (*over, "direction", "start")

    def numbers(*more):
        shape = [sizes.get(dim, 2 if dim == "link" else exponents) for dim in (*dims, *more)]
        return np.arange(np.prod(shape), dtype=float).reshape(shape)

    bad = numbers().astype(np.int8) * 0
    variables = {
        "journal_x": named(
            (*dims, "point", "joint"), numbers("point")[..., None] * 1e-6, "m", "journal centre, x"
        ),
        "angle": named((*dims, "point", "link"), numbers("point", "link") * 1e-3, "rad", "link angle"),
        "period": named(dims, np.resize([1, 2, 0, -1, 12], numbers().shape), "1", "period"),
        "impacts": named((*dims, "joint"), numbers()[..., None], "1", "contacts begun per turn"),
        "smallest_missed_gap": named((*dims, "joint"), numbers()[..., None] * 1e-6, "m", "smallest gap"),
        "status": ((), np.int8(0), {"flag_values": np.arange(9), "flag_meanings": MEANINGS}),
        "cell_status": (dims, bad, {"flag_values": np.arange(9), "flag_meanings": MEANINGS}),
    }
    if exponents:
        values = np.sin(numbers("exponent"))
        variables["lyapunov_exponent_per_turn"] = named((*dims, "exponent"), values, "1", "exponent a turn")
        variables["lyapunov_standard_error_per_turn"] = named(
            (*dims, "exponent"), 0.1 + 0 * values, "1", "standard error"
        )
    coords = {
        "clearance": named("clearance", CLEARANCES, "m", "radial clearance"),
        "gear_ratio": named("gear_ratio", np.array([1.0, 2.0, 3.0]), "1", "gear ratio"),
        "direction": list(directions),
        "start": np.arange(starts),
        "point": np.arange(4),
        "exponent": np.arange(1, exponents + 1),
        "joint": ["B"],
        "link": ["crank", "coupler"],
    }
    used = {dim for each in variables.values() for dim in each[0]}
    found = xr.Dataset(variables, {k: v for k, v in coords.items() if k in used}, {"kind": "bifurcation"})
    return found if starts > 1 else found.isel(start=0, drop=True)


def clouds(ax):
    """Lines that are points."""
    return [line for line in ax.lines if line.get_linestyle() == "None"]


def test_points_are_those_stored_in_friendly_units_on_a_logarithmic_axis():
    data = sweep()
    ax, _ = figures.draw(data).axes
    down, up = clouds(ax)
    for line, way in ((down, "down"), (up, "up")):
        stored = data.journal_x.sel(direction=way, joint="B").values
        np.testing.assert_allclose(line.get_ydata(), 1e6 * stored.ravel())
        np.testing.assert_allclose(line.get_xdata(), np.repeat(1e6 * CLEARANCES, 4))
        assert line.get_rasterized()
    assert down.get_color() != up.get_color()
    assert down.get_markersize() > up.get_markersize()
    assert ax.get_xscale() == "log"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["upward", "downward"]
    assert "µm" in ax.get_ylabel()


def test_a_point_without_value_is_left_out():
    data = sweep(("up",))
    data.journal_x[1, 0, 2, 0] = np.nan
    ax, _ = figures.draw(data).axes
    assert clouds(ax)[0].get_xdata().size == 19
    assert ax.get_legend() is None


def test_exponents_have_bands_of_two_errors_and_a_line_at_zero():
    data = sweep(("up",), exponents=2)
    above, ax = figures.draw(data).axes
    zero, first, second = ax.lines
    assert set(zero.get_ydata()) == {0.0}
    for k, line in enumerate((first, second)):
        stored = data.lyapunov_exponent_per_turn.values[:, 0, k]
        np.testing.assert_array_equal(line.get_ydata(), stored)
        band = ax.collections[k].get_paths()[0].get_extents()
        assert (band.y0, band.y1) == pytest.approx((stored.min() - 0.2, stored.max() + 0.2))
    assert ax.get_shared_x_axes().joined(ax, above)
    assert "exponents" in ax.get_ylabel()


def test_without_exponents_there_is_one_panel_and_with_periods_one_more():
    assert len(figures.draw(sweep(exponents=0)).axes) == 1
    assert len(figures.draw(sweep(exponents=0), period=True).axes) == 2
    _, _, ax = figures.draw(sweep(("up",)), period=True).axes
    drawn = clouds(ax)[0].get_ydata()
    np.testing.assert_array_equal(drawn, [1, 2, 32, np.nan, 12])
    assert [text.get_text() for text in ax.get_yticklabels()][-1] == "none"


def test_contacts_lost_are_those_of_the_joint_that_loses_most():
    data = sweep(("up",)).isel(joint=[0, 0]).assign_coords(joint=["A", "B"])
    with pytest.raises(InputError, match=r"figure\.separations: got True; false"):
        figures.draw(data, separations=True)
    data["separations"] = data.impacts * xr.DataArray([1.0, 2.0], dims="joint")
    _, _, ax = figures.draw(data, separations=True).axes
    np.testing.assert_array_equal(clouds(ax)[0].get_ydata(), [0.0, 2.0, 4.0, 6.0, 8.0])


def test_another_quantity_link_direction_and_start():
    data = sweep(starts=2)
    figure = figures.draw(data, quantity="angle", link="coupler", direction="down", start=1)
    (line,) = clouds(figure.axes[0])
    stored = data.angle.sel(direction="down", start=1, link="coupler").values
    np.testing.assert_allclose(line.get_ydata(), np.degrees(stored.ravel()))
    assert "coupler" in figure.axes[0].get_ylabel()
    both = figures.draw(data.sel(direction=["up"]))
    assert [text.get_text() for text in both.axes[0].get_legend().get_texts()] == ["start 0", "start 1"]
    assert len({line.get_color() for line in clouds(both.axes[0])}) == 2


def test_a_line_beyond_the_axis_has_no_label(tmp_path):
    """Its label's place, of millions of metres, is none that a picture has."""
    figure = figures.draw(sweep(), limits=[[1e-4, "here"], [3e30, "far away"]])
    assert [text.get_text() for text in figure.axes[0].texts] == ["here"]
    figure.savefig(tmp_path / "diagram.png")


def test_limits_stand_where_they_are_said_to_with_their_labels():
    figure = figures.draw(sweep(), limits=[[1e-4, "here"], 3e-4])
    for ax in figure.axes:
        upright = [line for line in ax.lines if line.get_color() == style.WARNING]
        assert [line.get_xdata()[0] for line in upright] == pytest.approx([100, 300])
    assert [text.get_text() for text in figure.axes[0].texts] == ["here"]


def test_a_diagram_can_be_drawn_over():
    data, figure = sweep(("up",)), Figure()
    ax = figure.subplots()
    frame = diagram(ax=ax, dataset=data, quantity="angle", link="crank")
    assert frame.parameter == "clearance"
    assert frame.x.factor == 1e6
    assert frame.y.symbol == "deg"
    assert frame.quantity.dims == ("clearance", "direction", "point")


def test_of_two_parameters_the_first_is_held():
    data = sweep(("up",), over=("gear_ratio", "clearance"))
    figure = figures.draw(data, kind="bifurcation", at=2.2)
    stored = data.journal_x.sel(gear_ratio=2.0).values
    np.testing.assert_allclose(clouds(figure.axes[0])[0].get_ydata(), 1e6 * stored.ravel())
    assert figure.axes[0].get_title(loc="left") == "(a) Gear ratio 2"


def test_a_map_shows_what_is_stored():
    data = sweep(("up", "down"), over=("gear_ratio", "clearance"))
    figure = figures.draw(data, kind="parameter_map", direction="down")
    exponent, period, impacts = (
        ax for ax in figure.axes if ax.get_xscale() == "log" and ax.get_ylim()[0] < 1
    )
    stored = data.sel(direction="down")
    mesh = exponent.collections[0]
    np.testing.assert_allclose(mesh.get_array().ravel(), stored.lyapunov_exponent_per_turn.values.ravel())
    assert mesh.norm.vmin == -mesh.norm.vmax < 0
    np.testing.assert_allclose(impacts.collections[0].get_array().ravel(), stored.impacts.values.ravel())
    classes = {1: 1, 2: 2, 0: 10, 12: 9}
    expected = [classes.get(value, np.nan) for value in stored.period.values.ravel()]
    np.testing.assert_array_equal(period.collections[0].get_array().filled(np.nan).ravel(), expected)
    assert exponent.get_xlim() == pytest.approx((10 / 90**0.125, 900 * 90**0.125))
    assert exponent.get_ylim() == (0.5, 3.5)


@pytest.mark.nightly
def test_what_an_adaptive_map_did_not_compute_is_hatched():
    data = sweep(("up",), over=("gear_ratio", "clearance"))
    done = np.ones((3, 5), dtype=np.int8)
    assert not figures.draw(data.assign(computed=(data.period.dims[:2], done))).legends
    done[1, 2:4] = 0
    figure = figures.draw(data.assign(computed=(data.period.dims[:2], done)))
    for ax in (each for each in figure.axes if each.get_xscale() == "log" and each.get_ylim()[0] < 1):
        colours, hatched = ax.collections
        assert (colours.get_hatch(), hatched.get_hatch() is None) == (None, False)
        assert np.argwhere(hatched.get_array() == 1).tolist() == [[1, 2], [1, 3]]
        assert colours.get_array().count() >= hatched.get_array().count() == 2
    assert "not computed" in figure.legends[0].get_texts()[0].get_text()


def test_a_motion_that_forgets_its_start_has_the_lowest_colour_and_is_not_missing():
    data = sweep(("up",), over=("gear_ratio", "clearance"))
    exponents = data.lyapunov_exponent_per_turn
    exponents.values.ravel()[:2] = -np.inf, np.nan
    figure = figures.draw(data, kind="parameter_map", maps=[exponents.name])
    mesh = figure.axes[0].collections[0]
    assert mesh.get_array().ravel()[0] < mesh.norm.vmin
    assert mesh.get_array().mask.ravel()[:3].tolist() == [False, True, False]


def test_a_map_of_other_variables_in_their_units():
    data = sweep(("up",), over=("gear_ratio", "clearance"), exponents=2)
    figure = figures.draw(
        data, kind="parameter_map", maps=["smallest_missed_gap", "lyapunov_exponent_per_turn"], exponent=2
    )
    first, second = (ax for ax in figure.axes if ax.collections and ax.get_ylim()[0] == 0.5)
    np.testing.assert_allclose(first.collections[0].get_array().ravel(), np.arange(15.0))
    stored = data.lyapunov_exponent_per_turn.values[..., 0, 1]
    np.testing.assert_allclose(second.collections[0].get_array().ravel(), stored.ravel())
    assert any("µm" in ax.get_xlabel() for ax in figure.axes)


def test_failed_points_are_counted():
    data = sweep(exponents=0)
    data.cell_status[2, 1] = 3
    data["status"] = data["status"] * 0 + 3
    data["status"].attrs = data.cell_status.attrs
    assert "in 1 of 10: contacts followed" in figures.draw(data).get_suptitle()


def test_borders_of_cells():
    np.testing.assert_allclose(sweep_axes.edges(np.array([1.0, 2.0, 3.0])), [0.5, 1.5, 2.5, 3.5])
    np.testing.assert_allclose(
        sweep_axes.edges(np.array([1.0, 10.0, 100.0])), 10 ** np.array([-0.5, 0.5, 1.5, 2.5])
    )
    assert sweep_axes.edges(np.array([2.0])).tolist() == [1.0, 3.0]
    assert sweep_axes.is_log(np.geomspace(1, 9, 4))
    assert not sweep_axes.is_log(np.linspace(1, 9, 4))
    assert not sweep_axes.is_log(np.linspace(-1, 9, 4))


def test_wrong_options_are_told_with_what_is_accepted():
    data = sweep(starts=2)
    assert "journal_x" in refused(figures.draw, data, quantity="journal_z")["figure.quantity"]
    assert "up, down" in refused(figures.draw, data, direction="reset")["figure.direction"]
    assert "0 to 1" in refused(figures.draw, data, start=2)["figure.start"]
    assert "one parameter" in refused(figures.draw, data, at=1.0)["figure.at"]
    assert set(refused(figures.draw, data, limits=[[1.0, 2.0]])) == {"figure.limits"}
    assert set(refused(figures.draw, data, period=1)) == {"figure.period"}
    assert "two parameters" in refused(figures.draw, data, kind="parameter_map")["figure.kind"]
    assert "kind bifurcation" in refused(figures.draw, response(), kind="bifurcation")["figure.kind"]
    grid = sweep(("up",), over=("gear_ratio", "clearance"))
    assert (
        "smallest_missed_gap"
        in refused(figures.draw, grid, kind="parameter_map", maps=["impact"])["figure.maps[0]"]
    )
    assert "1 to 1" in refused(figures.draw, grid, kind="parameter_map", exponent=2)["figure.exponent"]
    assert set(refused(figures.draw, grid, kind="parameter_map", maps=[])) == {"figure.maps"}


def test_two_parameters_are_drawn_as_a_map_unless_an_option_asks_for_a_diagram():
    both = sweep(("reset",), over=("clearance", "gear_ratio"))
    assert figures.usual_kind(both) == "parameter_map"
    assert figures.usual_kind(both, ["at"]) == "bifurcation"
    assert figures.usual_kind(sweep()) == "bifurcation"
    names = figures.suited(KINDS["bifurcation"])
    assert [figures.usual(names, (), over) for over in (1, 2)] == ["bifurcation", "parameter_map"]
