"""Work and precision: errors as stored over both measures of work; what disagrees stands apart."""

import numpy as np
import pytest
import xarray as xr

from jointplay import figures
from jointplay.display.errors import InputError
from jointplay_lab.figures.work_precision import decades
from tests.figures.support.synthetic import response

AGREEMENT = {
    "flag_values": np.arange(4, dtype=np.int8),
    "flag_meanings": "same other_events other_state no_end",
}


def works(confirmed=1) -> xr.Dataset:
    """Two solvers at three tolerances; the second has other events first, and no end at last."""
    table = ("solver", "rtol")
    error = np.array([[1e-6, 1e-8, 1e-10], [1e-4, 1e-6, np.nan]])
    data = {
        "error": (table, error, {"units": "1"}),
        "cpu_time": (table, np.array([[1e-3, 2e-3, 3e-3], [1e-2, 2e-2, np.nan]]), {"units": "s"}),
        "evaluations": (table, np.array([[1e3, 2e3, 3e3], 3 * [np.nan]]), {"units": "1"}),
        "agreement": (table, np.array([[0, 0, 0], [1, 0, 3]], dtype=np.int8), AGREEMENT),
        "truth_difference": ((), 1e-9, {"units": "1"}),
        "truth_confirmed": ((), np.int8(confirmed)),
        "status": ((), np.int8(0), {"flag_values": np.int8([0, 1]), "flag_meanings": "ok diverged"}),
    }
    coords = {"solver": ["jointplay", "heyoka"], "rtol": [1e-6, 1e-8, 1e-10]}
    return xr.Dataset(data, coords, {"kind": "work_precision"})


@pytest.mark.long
def test_errors_are_drawn_over_time_and_over_evaluations():
    data = works()
    times, evaluations = figures.draw(data).axes
    for ax in (times, evaluations):
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    ours = times.lines[0]
    np.testing.assert_allclose(ours.get_xdata(), 1e3 * data.cpu_time.values[0])
    np.testing.assert_array_equal(ours.get_ydata(), data.error.values[0])
    np.testing.assert_array_equal(evaluations.lines[0].get_xdata(), data.evaluations.values[0])
    assert evaluations.lines[2].get_xdata().size == 0  # a solver without evaluations


@pytest.mark.long
def test_runs_with_other_events_stand_apart():
    figure = figures.draw(works())
    line, hollow = figure.axes[0].lines[2:4]
    assert line.get_ydata().tolist() == [1e-6]
    assert hollow.get_ydata().tolist() == [1e-4]
    assert (hollow.get_markerfacecolor(), hollow.get_linestyle()) == ("white", "None")
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["jointplay", "heyoka", "other events or end"]


@pytest.mark.nightly
def test_what_is_not_known_is_shaded_and_said():
    panel = figures.draw(works()).axes[0]
    (band,) = panel.patches
    assert band.get_y() + band.get_height() == pytest.approx(1e-9)
    assert panel.get_title(loc="left") == "(a)"
    assert not figures.draw(works().assign(truth_difference=0.0)).axes[0].patches
    said = figures.draw(works(confirmed=0)).axes[0].get_title(loc="left")
    assert "no second" in said.replace("\n", " ")


@pytest.mark.parametrize(
    ("column", "shape"), [("single", (88, 142)), pytest.param("double", (180, 86), marks=pytest.mark.long)]
)
def test_both_widths(column, shape):
    figure = figures.draw(works(), column=column)
    assert tuple(np.round(figure.get_size_inches() * 25.4)) == shape


def test_what_does_not_fit_is_refused():
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(response(section=False), kind="work_precision")
    with pytest.raises(InputError, match="column"):
        figures.draw(works(), column="triple")


@pytest.mark.parametrize(
    ("given", "shown"), [((3e3, 8e4), (1e3, 8e4)), ((2.0, 8.0), (1.0, 10.0)), ((0.5, 20), (0.5, 20))]
)
def test_two_powers_of_ten_are_always_on_the_axis(given, shown):
    assert decades(*given) == pytest.approx(shown)
