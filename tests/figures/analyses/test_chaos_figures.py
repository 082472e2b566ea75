"""Pictures of 0-1 test, spectrum and dimension: what is stored is what is drawn."""

import math

import numpy as np
import pytest
import xarray as xr

from jointplay import figures
from jointplay.display.errors import InputError
from tests.figures.support.synthetic import STATUS, flag_words, response

ONE = {"units": "1", "long_name": "number"}


def words(ax):
    return [text.get_text() for text in ax.texts]


def judged(chaotic=True, constant=False, count=300):
    random, c = np.random.default_rng(1), np.linspace(0.7, 2.4, 20)
    K = np.zeros(20) if constant else (0.99 if chaotic else 0.02) + 0.01 * random.standard_normal(20)
    lags = np.arange(1, count // 10 + 1)
    path = np.cumsum(random.standard_normal(count) * 1e-4)
    metre = {"units": "m", "long_name": "journal centre relative to the bearing, x, B"}
    data = {
        "sample": ("turn", random.standard_normal(count) * 1e-4, metre),
        "chaos_indicator": ("test_frequency", K, ONE),
        "chaos_indicator_quartile": ("quartile", np.quantile(K, (0.25, 0.5, 0.75)), ONE),
        "walk_x": ("turn", path, metre),
        "walk_y": ("turn", -path, metre),
        "walk_frequency": ((), c[3], ONE),
        "square_displacement": ("lag", 1e-8 * lags, {"units": "m2", "long_name": "mean square displacement"}),
        "verdict": (
            (),
            np.int8(2 if chaotic else 1),
            flag_words(("undecided", "regular", "chaotic"), "verdict"),
        ),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    coords = {"test_frequency": c, "lag": lags, "quartile": [0.25, 0.5, 0.75]}
    return xr.Dataset(data, coords, {"kind": "chaos_test"})


@pytest.mark.parametrize("chaotic", [True, False])
def test_indicator_walk_and_displacement(chaotic):
    data = judged(chaotic)
    figure = figures.draw(data)
    first, walk, grown = figure.axes
    np.testing.assert_array_equal(first.lines[0].get_ydata(), data.chaos_indicator)
    assert ("chaotic" if chaotic else "regular") in first.get_title(loc="left")
    low, high = first.get_ylim()
    assert low < 0
    assert high > 1
    shown = float(walk.lines[0].get_xdata()[7] / data.walk_x[7])
    assert walk.get_xlabel() == {1e3: "p (mm)", 1e6: "p (µm)"}[round(shown)]
    np.testing.assert_allclose(grown.lines[0].get_ydata(), data.square_displacement * shown**2)
    assert "journal centre" in figure.get_suptitle()


def test_one_point_has_no_walk():
    _, walk, grown = figures.draw(judged(False, constant=True)).axes
    for ax in (walk, grown):
        assert not ax.lines
        assert words(ax) == ["Regular: all are one point"]


def test_too_few_samples_have_no_walk():
    data = judged().isel(lag=slice(0))
    data["chaos_indicator"] = data.chaos_indicator * math.nan
    assert words(figures.draw(data).axes[1]) == ["Too few samples"]


def density(units="N2 Hz-1"):
    f = np.linspace(0, 40, 401)
    values = 1e-3 + 5.0 * np.exp(-(((f - 10) / 0.2) ** 2))
    name = "power spectral density of normal contact force, B"
    data = {
        "power_spectral_density": ("frequency", values, {"units": units, "long_name": name}),
        "confidence_factor": ("bound", [0.4, 2.5], ONE),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    coords = {"frequency": f, "order": ("frequency", f / 5), "bound": ["lower", "upper"]}
    return xr.Dataset(data, coords, {"kind": "spectrum"})


@pytest.mark.parametrize(("abscissa", "factor"), [("order", 0.2), ("frequency", 1.0)])
def test_density(abscissa, factor):
    data = density()
    (ax,) = figures.draw(data, abscissa=abscissa).axes
    line = ax.lines[0]
    np.testing.assert_allclose(line.get_xdata(), factor * data.frequency[1:])
    np.testing.assert_allclose(line.get_ydata(), data.power_spectral_density[1:])
    assert ax.get_yscale() == "log"
    assert "N² Hz⁻¹" in ax.get_ylabel()
    assert ax.get_title(loc="left") == "normal contact force, B"


def test_interval():
    """As high as the factor between its ends, above all that is drawn."""
    data = density()
    (ax,) = figures.draw(data).axes
    (bar,) = (each for each in ax.containers if hasattr(each, "has_yerr") and each.has_yerr)
    low, high = bar.lines[2][0].get_segments()[0][:, 1]
    assert high / low == pytest.approx(2.5 / 0.4)
    assert high < ax.get_ylim()[1]


def test_part_of_a_density():
    (ax,) = figures.draw(density(), between=[1, 3]).axes
    x = ax.lines[0].get_xdata()
    assert (x.min(), x.max()) == (pytest.approx(1, abs=0.03), pytest.approx(3, abs=0.03))
    assert words(figures.draw(density(), between=[90, 91]).axes[0]) == ["No samples in this run"]


def counted(value=1.4):
    radius = np.geomspace(1e-3, 1, 40)
    fit = np.array([0.01, 0.3]) if np.isfinite(value) and value else np.full(2, np.nan)
    data = {
        "correlation_sum": ("radius", 0.2 * radius**1.4, ONE),
        "local_slope": ("radius", np.full(40, 1.4), ONE),
        "correlation_dimension": ((), value, ONE),
        "correlation_dimension_spread": ((), 0.03, ONE),
        "correlation_dimension_standard_error": ((), 0.04, ONE),
        "fit_radius": ("bound", fit, ONE),
        "n_points": ((), 3000, ONE),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    return xr.Dataset(data, {"radius": radius}, {"kind": "dimension"})


def test_correlation_sum_and_slope():
    sums, slopes = figures.draw(counted()).axes
    points, fit = sums.lines
    np.testing.assert_allclose(points.get_ydata(), counted().correlation_sum)
    x, y = fit.get_xdata(), fit.get_ydata()
    np.testing.assert_allclose(y, 0.2 * x**1.4)  # the fit lies on the points
    assert 0.01 <= x.min() < x.max() <= 0.3
    assert slopes.get_title(loc="left") == "(b) D = 1.400 ± 0.040"
    np.testing.assert_array_equal(slopes.lines[1].get_ydata(), [1.4, 1.4])


def test_no_slope():
    sums, slopes = figures.draw(counted(math.nan)).axes
    assert len(sums.lines) == len(slopes.lines) == 1
    empty = figures.draw(counted(0.0).isel(radius=slice(0)))
    assert words(empty.axes[0]) == ["Dimension 0: all is one point"]


@pytest.mark.parametrize("kind", ["lyapunov", "chaos_test", "spectrum", "dimension"])
def test_another_result_is_refused(kind):
    with pytest.raises(InputError, match=f"study of kind {kind}"):
        figures.draw(response(), kind=kind)


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"kind": "lyapunov", "per": "hour"}, "figure.per"),
        ({"kind": "lyapunov", "exponents": 0}, "figure.exponents"),
        ({"kind": "spectrum", "abscissa": "time"}, "figure.abscissa"),
        ({"kind": "spectrum", "between": [3, 1]}, "figure.between"),
    ],
)
def test_wrong_options_are_told_before_there_is_a_result(options, key):
    assert [problem.key for problem in figures.problems(options)] == [key]
