"""Paths between samples: how near they come to the motion, and what they leave alone."""

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator

from jointplay import figures
from jointplay.figures.drawing.artists import BETWEEN, MOST, akima, smooth
from tests.figures.support.synthetic import response, section

SHARES = np.arange(1, BETWEEN) / BETWEEN


def circle(samples: int):
    turns = np.linspace(0.0, 4.0, 4 * samples + 1)
    return turns, np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns), np.ones(turns.size, dtype=bool)


def test_ten_samples_a_vibration_miss_its_circle_by_a_hundredth():
    x, y, _ = smooth(*circle(10))
    radius = np.hypot(x, y)[16:-16]  # splines know less at the ends
    assert np.abs(radius - 1).max() < 0.01  # straight lines: 0.05
    assert len(x) == 8 * 40 + 1


def test_slopes_are_those_of_modified_akima_splines():
    numbers = np.random.default_rng(5)
    times = np.cumsum(numbers.uniform(0.1, 2.0, 40))
    points = np.stack([numbers.standard_normal(40), np.r_[np.zeros(12), numbers.standard_normal(28)]], -1)
    known = Akima1DInterpolator(times, points, method="makima")
    np.testing.assert_allclose(akima(times, points), known(times, 1), rtol=0, atol=1e-12)
    x, y, _ = smooth(times, *points.T, np.zeros(40, dtype=bool))
    drawn = np.stack([x, y], -1)
    dense = known(np.concatenate([times, (times[:-1, None] + np.diff(times)[:, None] * SHARES).ravel()]))
    missed = np.min(np.abs(drawn[:, None] - dense[None]).max(axis=-1), axis=1)
    assert len(drawn) > 200
    assert missed.max() < 1e-12


def test_samples_stay_where_they_are_and_straight_paths_as_they_are():
    t, x, y, contact = circle(12)
    drawn = {*zip(*smooth(t, x, y, contact)[:2], strict=True)}
    assert {*zip(x, y, strict=True)} <= drawn
    assert smooth(t, t, 2 * t, contact)[0].size == t.size
    gap = np.where(t < 1, np.nan, y)
    assert smooth(t, x, gap, contact)[0] is x


def test_contact_begins_where_the_circle_is_crossed():
    t = np.linspace(0.0, 1.0, 9)
    x, y = 0.8 + 0.4 * t, np.zeros(9)
    contact = x > 1.05  # a sample late
    points, _, touching = smooth(t, x, y, contact, lambda x, _: x - 1.0)
    assert touching[points < 1.0].sum() == 0
    assert touching[(points > 1.0) & (points > x[~contact].max())].all()


@pytest.mark.parametrize("samples", [21, MOST + 1])
def test_contact_begins_and_ends_at_the_edge_itself(samples):
    t = np.linspace(0.0, 1.0, samples)
    x = np.sin(np.pi * t) * 1.3
    points, _, touching = smooth(t, x, t, x > 1.0, lambda x, _: x - 1.0)
    changes = np.flatnonzero(np.diff(touching))
    assert len(changes) == 2
    assert np.abs(points[[changes[0] + 1, changes[1]]] - 1.0).max() < 1e-12


def test_a_period_is_told_with_its_scatter_and_drawn_as_a_point():
    data = section(300)
    noise = 1e-9 * np.random.default_rng(3).standard_normal(300)
    over = {name: each for name, each in data.items() if "turn" in each.dims}
    fixed = data.assign({name: each * 0 + each.isel(turn=0) for name, each in over.items()})
    noisy = fixed.assign(normal_velocity=fixed["normal_velocity"] * (1 + noise[:, None]))
    figure = figures.draw(noisy)
    told = figure.axes[0].get_title(loc="left").replace("\n", " ")
    assert told == "(a) 300 crossings: period\N{NO-BREAK SPACE}1, all the same"
    low, high = figure.axes[1].get_ylim()
    assert np.ptp(figure.axes[1].lines[0].get_ydata()) < 0.01 * (high - low)
    assert "period" not in figures.draw(data).axes[0].get_title(loc="left")


@pytest.mark.parametrize("power", [7, -9])
def test_powers_of_ten_stand_in_the_labels(power):
    data = response()
    data["normal_force"] = data["normal_force"].copy(data=data["normal_force"].values * 10.0**power)
    ax = figures.draw(data, {"kind": "time_history"}).axes[0]
    assert not ax.yaxis.get_offset_text().get_visible()
    raised = str(power + 1).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))  # forces are some 10 N
    assert f"(10{raised} N)" in ax.get_ylabel().replace("\n", " ")
