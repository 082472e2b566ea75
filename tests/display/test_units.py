"""Display units: the table, and the choice by magnitude."""

import math

import numpy as np
import pytest

from jointplay.display.number_text import TABLE, measure, plain, shown
from jointplay.figures.drawing.derived import Degrees
from jointplay.figures.drawing.timebase import stretch


@pytest.mark.parametrize(
    ("value", "units", "expected"),
    [
        (2.9e-5, "m", 29.0),
        (2.9e-3, "m", 2.9),
        (-3.0, "m", -3.0),
        (np.pi, "rad", 180.0),
        (0.05, "m s-1", 50.0),
        (0.05, "m/s", 50.0),
        (314.0, "rad s-1", 314.0),
        (1e4, "N", 1e4),
        (0.4, "1", 0.4),
        (7.0, "furlong", 7.0),
    ],
)
def test_values_as_shown(value, units, expected):
    assert value * shown([value, np.nan], units).factor == pytest.approx(expected)


def test_symbols():
    symbols = [shown(2.9e-5, units).symbol for units in ("m", "rad", "rad s-1", "N", "N m", "1", "furlong")]
    assert symbols == ["µm", "deg", "rad/s", "N", "N·m", "\N{EN DASH}", "furlong"]


@pytest.mark.parametrize(("units", "words"), [("m", "0 m"), ("s", "0 s"), ("m/s", "0 m/s"), ("rad", "0 deg")])
def test_nothing_is_in_the_unit_and_no_part_of_it(units, words):
    assert measure(0.0, units) == words
    assert measure(1e-9, "m") == "0.001 µm"


@pytest.mark.parametrize("units", TABLE)
def test_every_magnitude_has_a_unit(units):
    for values in ([], [0.0], [np.nan], [1e-30], [1e30], [np.inf]):
        assert shown(values, units).factor > 0


def test_degree_ticks_are_parts_of_a_turn():
    assert set(np.diff(Degrees().tick_values(-180, 180))) == {90}
    assert set(np.diff(Degrees().tick_values(0, 25 * 360))) == {1800}
    assert set(np.diff(Degrees().tick_values(-35, 82))) == {30}


def test_stretch_goes_on_beyond_the_knots():
    knots, values = np.array([0.0, 1.0, 2.0]), np.array([0.0, 3.0, 4.0])
    np.testing.assert_allclose(stretch([-1.0, 0.5, 3.0], knots, values), [-2.0, 1.5, 6.0])


@pytest.mark.parametrize(
    ("value", "expected"),
    [(1234567.0, "1.23457 × 10⁶"), (0.1 + 0.2, "0.3"), (-2e-7, "−2 × 10⁻⁷"), (math.nan, "–")],
)
def test_a_number_has_six_digits_unless_others_are_asked_for(value, expected):
    assert plain(value) == expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (3650.0, "3650"),
        (-98764.0, "−98760"),
        (99999.6, "1 × 10⁵"),
        (0.00125, "0.00125"),
        (2.5e7, "2.5 × 10⁷"),
    ],
)
def test_a_number_that_a_person_writes_in_full_has_no_power(value, expected):
    assert plain(value, 4) == expected
