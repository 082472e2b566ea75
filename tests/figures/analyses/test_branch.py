"""Branches of orbits: as stored, stability by the line; multipliers within the circle or not."""

import numpy as np
import pytest
import xarray as xr

from jointplay import cli, figures
from jointplay.display.errors import InputError
from tests.figures.support.synthetic import response
from tests.figures.support.synthetic_branches import branches, orbit


def finite(line):
    """Points of a line that are drawn."""
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    there = np.isfinite(x) & np.isfinite(y)
    return x[there], y[there]


def curves(ax):
    """Lines without markers, by whether they are solid."""
    drawn = [line for line in ax.lines if line.get_marker() == "None" and finite(line)[0].size]
    return [line for line in drawn if line.get_linestyle() == "-"], [
        line for line in drawn if line.get_linestyle() == "--"
    ]


def test_stable_is_solid_and_unstable_dashed():
    data = branches()
    (ax,) = figures.draw(data, quantity="eccentricity_ratio").axes
    solid, dashed = curves(ax)
    assert len(solid) == 3  # the single orbit, and the doubled one's two turns
    x, y = finite(solid[0])
    np.testing.assert_allclose(x, 1e6 * data.clearance[0, :11])
    np.testing.assert_allclose(y, data.eccentricity_ratio[0, :11, 0, 0])
    x, y = finite(dashed[0])
    np.testing.assert_allclose(x, 1e6 * data.clearance[0, 10:])
    for turn in (0, 1):
        x, y = finite(solid[1 + turn])
        np.testing.assert_allclose(y, data.eccentricity_ratio[1, :8, turn, 0])
        assert solid[1 + turn].get_color() != solid[0].get_color()
    assert ax.get_xlabel() == "Radial clearance (µm)"


def test_a_line_is_interrupted_where_an_impact_passed_the_section():
    (ax,) = figures.draw(branches()).axes
    y = np.asarray(curves(ax)[1][0].get_ydata(), dtype=float)
    gap = np.flatnonzero(np.isnan(y[11:-1]))
    assert gap.size == 1
    assert np.isfinite(y[11 + gap[0] + 1])


def test_special_points_are_where_they_are_stored():
    data = branches()
    (ax,) = figures.draw(data).axes
    marked = {line.get_marker(): finite(line) for line in ax.lines if line.get_marker() != "None"}
    assert set(marked) == {"s", "o", "|"}
    for marker, branch, point in (("s", 0, 10), ("o", 0, 5), ("|", 1, 6)):
        x, y = marked[marker]
        assert x == pytest.approx(1e6 * float(data.clearance[branch, point]))
        stored = data.eccentricity_ratio[branch, point, :, 0].values
        np.testing.assert_allclose(y, stored[np.isfinite(stored)])
    words = [text.get_text() for text in ax.figure.legends[0].get_texts()]
    assert words == ["period 1", "period 2", "stable", "unstable", "fold", "period doubling", "grazing"]


def test_multipliers_below():
    data = branches()
    upper, lower = figures.draw(data, multipliers=True, limits=[[2.5e-5, "known"]]).axes
    solid, dashed = curves(lower)
    np.testing.assert_allclose(finite(dashed[0])[1][1:], np.linspace(0.2, 1.8, 21)[11:])
    assert any(np.allclose(finite(line)[1], 0.5) for line in solid)
    assert "known" in [text.get_text() for text in upper.texts]
    assert lower.get_xlabel() == "Radial clearance (µm)"


def diagram() -> xr.Dataset:
    """A sweep over five clearances, three section points each."""
    swept = np.linspace(2.2e-5, 2.8e-5, 5)
    values = np.linspace(0.1, 0.3, 15).reshape(5, 1, 3, 1)
    dims = ("clearance", "direction", "point", "joint")
    return xr.Dataset(
        {
            "eccentricity_ratio": (dims, values, {"units": "1", "long_name": "eccentricity ratio"}),
            "cell_status": (dims[:2], np.zeros((5, 1), np.int8)),
        },
        {
            "clearance": ("clearance", swept, {"units": "m", "long_name": "radial clearance"}),
            "direction": ["up"],
            "joint": ["B"],
        },
        {"kind": "bifurcation"},
    )


def test_a_detail_holds_what_lies_in_it_and_the_rest_has_logarithms():
    data, (low, high) = branches(), (2.5e-5, 2.8e-5)
    options = {
        "quantity": "eccentricity_ratio",
        "scale": "log",
        "detail": [low, high],
        "limits": [[3e-5, "L"]],
    }
    detail, whole = figures.draw(data, options).axes
    assert (detail.get_xscale(), whole.get_xscale()) == ("linear", "log")
    assert detail.get_xlim() == pytest.approx((1e6 * low, 1e6 * high))
    x, y = (data[name].values[0] for name in ("clearance", "eccentricity_ratio"))
    inside = y[(x >= low) & (x <= high)]
    bottom, top = detail.get_ylim()
    assert 0.1 < (top - bottom) / np.ptp(inside[np.isfinite(inside)]) < 1.4
    assert bottom < np.nanmin(inside) < np.nanmax(inside) < top
    assert whole.get_ylim()[1] >= 1.0
    assert [len(ax.texts) for ax in (detail, whole)] == [0, 1]
    assert not detail.get_ylabel() == whole.get_ylabel() == ""
    detail, whole = figures.draw(data, options | {"detail": [1.0, 2.0]}).axes
    assert [text.get_text() for text in detail.texts] == ["No branch reaches this stretch"]
    assert detail.get_xlim() == pytest.approx((1e6, 2e6))
    assert len(whole.texts) == 1
    for wrong in ({"detail": [1, 0]}, {"scale": "cubic"}):
        with pytest.raises(InputError, match=f"figure.{next(iter(wrong))}"):
            figures.draw(data, options | wrong)
    shifted = data.assign_coords(clearance=data.clearance - 2.5e-5)
    with pytest.raises(InputError, match="above 0"):
        figures.draw(shifted, options | {"detail": None})


def test_the_note_on_a_partial_result_lies_on_nothing_else():
    data = branches()
    data["status"] += 1
    figure = figures.draw(data, kind="continuation", multipliers=True)
    parts = [figure._suptitle, *figure.legends, *figure.axes]
    note, *others = (part.get_window_extent() for part in parts)
    assert not any(note.overlaps(each) for each in others)


def test_over_a_diagram():
    """Points of the sweep and lines of the branches on the same axes, which hold both."""
    sweep = diagram()
    swept, values = sweep.clearance, sweep.eccentricity_ratio.values
    data = branches()
    (ax,) = figures.draw(data, over=sweep).axes
    dots = next(finite(line) for line in ax.lines if line.get_marker() == "o")
    np.testing.assert_allclose(dots[0], 1e6 * np.repeat(swept, 3))
    np.testing.assert_allclose(dots[1], values.ravel())
    np.testing.assert_allclose(finite(curves(ax)[0][0])[0], 1e6 * data.clearance[0, :11])
    assert ax.get_xlim() == pytest.approx((20.0, 30.0))
    points = next(line for line in ax.lines if line.get_marker() == "o")
    assert points.get_zorder() > curves(ax)[0][0].get_zorder(), "the line would hide them"
    assert "bifurcation diagram" in [text.get_text() for text in ax.figure.legends[0].get_texts()]
    other = sweep.rename(clearance="gear_ratio")
    with pytest.raises(InputError, match=r"figure\.over"):
        figures.draw(data, over=other)


def test_over_a_diagram_from_the_command_line(tmp_path, capsys):
    for name, dataset in (("branches", branches()), ("diagram", diagram())):
        dataset.to_netcdf(tmp_path / f"{name}.nc", engine="netcdf4")
    files = {name: str(tmp_path / name) for name in ("branches.nc", "diagram.nc", "x.png")}
    words = ["figure", files["branches.nc"], "--over", files["diagram.nc"], "--out", files["x.png"]]
    assert cli.main(words) == 0
    assert (tmp_path / "x.png").stat().st_size > 10_000
    words = ["figure", files["diagram.nc"], "--over", files["branches.nc"], "--out", files["x.png"]]
    assert cli.main(words) == 2
    assert "over" in capsys.readouterr().err


def test_a_number_of_the_orbit_and_what_does_not_fit():
    (ax,) = figures.draw(branches(), quantity="period_time").axes
    np.testing.assert_allclose(finite(curves(ax)[0][0])[1], 75.0)
    with pytest.raises(InputError, match="did you mean 'period_time'"):
        figures.draw(branches(), quantity="period_tme")
    with pytest.raises(InputError, match=r"figure\.multipliers"):
        figures.draw(branches(), multipliers=1)
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(response(section=False), kind="continuation")
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(response(section=False), kind="floquet")


@pytest.mark.long
def test_multipliers_in_and_out_of_the_circle():
    ax, table = figures.draw(orbit([-1.5, 0.0], [0.3, 0.4], [0.3, -0.4], [1e-13, 0.0])).axes
    inside, outside = (
        {(round(a, 9), round(b, 9)) for a, b in zip(*finite(line), strict=True)} for line in ax.lines[:2]
    )
    assert outside == {(-1.5, 0.0)}
    assert inside == {(0.3, 0.4), (0.3, -0.4), (0.0, 0.0)}
    (circle,) = ax.patches
    assert (circle.center, circle.radius) == ((0, 0), 1)
    words = [text.get_text() for text in table.texts]
    assert "0.3 + 0.4i" in words
    assert "0.3 \N{MINUS SIGN} 0.4i" in words
    assert words.count("< 10⁻¹⁰") == 2
    assert words[-1].startswith("unstable; period 1 turn, 0.5 s\n2 contacts")


def test_a_multiplier_far_outside_is_an_arrow_at_the_edge():
    ax, _ = figures.draw(orbit([50.0, 0.0], [0.1, 0.0])).axes
    assert finite(ax.lines[1])[0].size == 0
    assert len(ax.texts) == 1
    assert ax.get_xlim()[1] < 10


def test_multipliers_of_branches_share_one_panel():
    (ax,) = figures.draw(branches(), kind="floquet").axes
    drawn = sum(finite(line)[0].size for line in ax.lines[:2])
    assert drawn == 2 * 21 + 2 * 8


def test_no_orbit_is_said():
    empty = orbit([np.nan, np.nan]).assign(period=np.nan)
    ax, table = figures.draw(empty).axes
    assert [text.get_text() for text in ax.texts] == ["No orbit was found"]
    assert table.texts[-1].get_text() == "no orbit was found"
