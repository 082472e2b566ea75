"""Picture of exponents: running means with their bands, the table, and numbers with their errors in words."""

import math

import numpy as np
import pytest
import xarray as xr

from jointplay import figures
from jointplay.display.errors import InputError
from jointplay.display.number_text import plain, with_error
from jointplay.figures.analyses import lyapunov
from tests.figures.support.synthetic import STATUS, flag_words

ONE = {"units": "1", "long_name": "number"}


def exponents(values=(1.7, 1e-5, -2.9, -90.0, -np.inf), turning=True, twin=True, correlations=None):
    """Running means that settle as 1/n, errors of a tenth of the distance still to go."""
    values, blocks = np.array(values), 40
    approach = 1 + 1 / np.arange(1, blocks + 1)[:, None]
    trace = np.where(np.isfinite(values), values * approach, np.nan)
    errors = np.where(np.isfinite(values), 0.02, np.nan)
    rate = {"units": "s-1", "long_name": "Lyapunov exponent"}
    data = {
        "lyapunov_exponent": ("exponent", values, rate),
        "lyapunov_standard_error": ("exponent", errors, rate),
        "batch_correlation": (
            "exponent",
            np.zeros(len(values)) if correlations is None else correlations,
            ONE,
        ),
        "lyapunov_trace": (("block", "exponent"), trace, rate),
        "lyapunov_trace_error": (("block", "exponent"), 0.1 * np.abs(trace), rate),
        "block_time": ("block", 2.0 * np.arange(1, blocks + 1), {"units": "s", "long_name": "time"}),
        "sum_residual": ((), math.nan, rate),
        "mean_divergence": ((), -90.0, rate),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    if turning:
        data["turn_period"] = ((), 0.5, {"units": "s", "long_name": "mean period of a turn"})
    if twin:
        names = {"growth": 0.86, "growth_standard_error": 0.05, "growth_difference": 0.2}
        data |= {
            "section_exponent": ("multiplier", [1.7], rate),
            "section_standard_error": ("multiplier", [0.02], rate),
        }
        data |= {name: ((), value, ONE) for name, value in names.items()}
    return xr.Dataset(data, {"exponent": np.arange(1, len(values) + 1)}, {"kind": "lyapunov"})


def words(ax):
    return [text.get_text() for text in ax.texts]


def curves(ax):
    """The lines of exponents, without the zero line."""
    return [line for line in ax.lines if len(line.get_xdata()) > 2]


@pytest.mark.parametrize(("per", "factor"), [("turn", 0.5), ("second", 1.0), (None, 0.5)])
def test_running_means(per, factor):
    data = exponents()
    traces, _ = figures.draw(data, per=per).axes
    assert len(curves(traces)) == data.sizes["exponent"]
    for line, stored in zip(curves(traces), data.lyapunov_trace.values.T, strict=True):
        np.testing.assert_allclose(line.get_ydata(), factor * stored)
        np.testing.assert_allclose(
            line.get_xdata(), data.block_time / factor if factor != 1 else data.block_time
        )
    assert any(
        np.all(np.asarray(line.get_ydata()) == 0) for line in traces.lines if line not in curves(traces)
    )
    low, high = traces.get_ylim()
    assert low < -90 * factor
    assert high > 1.7 * factor
    assert traces.get_yscale() == "symlog"


def test_bands_are_a_standard_error_on_either_side():
    data = exponents((0.9, -0.4))
    traces, _ = figures.draw(data, per="second").axes
    for band, mean, error in zip(
        traces.collections, data.lyapunov_trace.values.T, data.lyapunov_trace_error.values.T, strict=True
    ):
        heights = band.get_paths()[0].vertices[:, 1]
        assert heights.max() == pytest.approx((mean + error).max())
        assert heights.min() == pytest.approx((mean - error).min())
    assert traces.get_yscale() == "linear"
    low, high = traces.get_ylim()
    assert low < -0.4 < 0.9 < high


def test_table():
    _, table = figures.draw(exponents(correlations=[0.1, 0.5, -0.6, np.nan, np.nan]), per="second").axes
    found = words(table)
    for value in ("1.700 ± 0.020", "−2.900 ± 0.020", "−90.000 ± 0.020", "−∞", "0.10", "0.50*", "−0.60", "–"):
        assert value in found
    notes = found[-1]
    assert "*Successive batches" in notes
    assert "Twin trajectories: 0.860 ± 0.050" in notes
    assert "Section's map, largest: 0.850 ± 0.010 per turn" in notes
    assert "0.2 standard errors from the section's map" in notes
    plain_notes = words(figures.draw(exponents(twin=False)).axes[1])[-1]
    assert "*" not in plain_notes
    assert "Twin" not in plain_notes


@pytest.mark.parametrize("beyond", [0.0, 1e-3])
def test_the_note_on_batches_stands_below_where_a_star_is_above(beyond):
    correlations = [lyapunov.LIMIT + beyond, *np.zeros(4)]
    *rows, notes = words(figures.draw(exponents(correlations=correlations)).axes[1])
    assert ("0.32*" in rows, "*Successive batches" in notes) == (bool(beyond), bool(beyond))


def test_labels_do_not_cover_one_another():
    """Lines that end together share one."""
    close = words(figures.draw(exponents((1.0, -0.30, -0.301)), per="second").axes[0])
    assert close == ["$\\lambda_{1}$", "$\\lambda_{2,3}$"]


def test_fewer_exponents():
    assert len(curves(figures.draw(exponents(), exponents=2).axes[0])) == 2
    assert len(curves(figures.draw(exponents(), exponents=99).axes[0])) == 5


def test_what_nothing_turns_is_counted_in_seconds():
    data = exponents(turning=False, twin=False)
    assert "1/s" in figures.draw(data).axes[0].get_ylabel()
    with pytest.raises(InputError, match=r"figure\.per"):
        figures.draw(data, per="turn")


def test_a_run_without_exponents_says_so():
    data = exponents((math.nan, math.nan)).isel(block=slice(0))
    data["status"] = ((), np.int8(2), flag_words(STATUS, "outcome"))
    figure = figures.draw(data)
    assert "step_limit" in figure.get_suptitle()
    assert words(figure.axes[0]) == ["No samples in this run"]


@pytest.mark.parametrize(
    ("value", "error", "expected"),
    [
        (1.7418, 0.0418, "1.742 ± 0.042"),
        (-438.435, 0.026, "−438.435 ± 0.026"),
        (1e-8, 1.2e-6, "(0.0 ± 1.2) × 10⁻⁶"),
        (0.5, 3e-9, "0.50000 ± 3 × 10⁻⁹"),
        (-379564.5, 31.0, "−379564 ± 31"),
        (0.25, 0.0, "0.25"),
        (math.nan, 1.0, "–"),
        (-math.inf, math.nan, "−∞"),
    ],
)
def test_numbers_with_errors(value, error, expected):
    assert with_error(value, error) == expected


def test_plain_numbers():
    assert [plain(x, 2) for x in (0.0, -1.234, 6.1e-14, math.nan)] == ["0", "−1.2", "6.1 × 10⁻¹⁴", "–"]
