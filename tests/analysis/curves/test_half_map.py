"""The half map of a symmetric orbit: its derivatives in a number that changes how long half a turn takes."""

import math

import numpy as np
import pytest

from jointplay import CrankAngle, catalog
from jointplay.analysis.curves.grazing import HalfMap, halved
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.orbits.shooting import newton
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.directions import along

FREQUENCY, STATE = 1.2, np.array([0.4, -0.3])


def section(model):
    return section_map(model, CrankAngle(angle=0.7), 1)


def model(frequency):
    return assemble(catalog.duffing(amplitude=0.3, frequency=frequency), None, "phase")


def half(frequency):
    return HalfMap(**vars(section(model(frequency))), signs=-np.ones(2))


def test_the_forcings_frequency_moves_both_ends_of_half_a_turn():
    directions = along(model, FREQUENCY, begin=lambda each: section(each).begin)
    assert directions.periods == pytest.approx([-math.tau / FREQUENCY**2], rel=1e-9)
    assert directions.begins == pytest.approx([-0.7 / FREQUENCY**2], rel=1e-9)
    found = half(FREQUENCY).image(STATE, directions=directions)
    assert found.times == pytest.approx([-math.pi / FREQUENCY**2], rel=1e-9)
    h = 1e-5
    ends = [half(FREQUENCY + side * h).image(STATE).state for side in (1, -1)]
    exact = (ends[0] - ends[1]) / (2 * h) / half(FREQUENCY).scale
    assert found.along[:, 0] == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize(("start", "mirrored"), [([0.0, 0.0], True), ([1.0, 0.0], False)])
def test_an_orbit_that_is_its_own_mirror_image_is_one_of_the_half_map(start, mirrored):
    """The saddle between the wells is; the motion in one of them is not."""
    orbit = newton(section(assemble(catalog.duffing(amplitude=0.05), None, "phase")), np.array(start))
    assert orbit.status == 0
    found = halved(orbit, 1e-8)
    assert (found is not None) == mirrored
    if mirrored:
        assert found.state == pytest.approx(orbit.state, abs=1e-8)
        assert found.map.signs.tolist() == [-1, -1]
        P = found.image.derivative
        assert pytest.approx(orbit.image.derivative, rel=1e-6) == P @ P
