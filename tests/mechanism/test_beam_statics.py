"""Deflections at rest, summed up from modes, against closed forms of a simply supported beam.

Static modal amplitudes are η_i = Q_i/ω_i². Cubic elements are exact at their nodes; sine modes leave a tail.
"""

import numpy as np
import pytest

from jointplay.solver.mechanism.parts.beam import line_density, modal, stiffness
from tests.mechanism.bars import COUPLER, bar

LENGTH = COUPLER["length"]
EXACT = [{"elements": n} for n in (2, 4, 8)]
SINES = {"shapes": "sine", "modes": 40}
exact_at_nodes = pytest.mark.parametrize("beam", EXACT, ids=lambda beam: f"{beam['elements']} elements")


def at_rest(forces, shape, link):
    """Give Σ Q_i φ_i/ω_i², with forces and shape by the name of what modes give."""
    modes = modal(link)
    return float(np.sum(getattr(modes, forces) * getattr(modes, shape) / modes.frequency**2))


def sag(link, share):
    """Give w l⁴/EI times a share, of the load w = ρA × 1 m/s² that a uniform acceleration makes."""
    return share * line_density(link) * LENGTH**4 / stiffness(link)


@exact_at_nodes
def test_sag_under_a_uniform_load(beam):
    link = bar(**beam)
    assert at_rest("force", "gauge", link) == pytest.approx(sag(link, 5 / 384), rel=1e-9)
    assert at_rest("force", "slope_start", link) * LENGTH == pytest.approx(sag(link, 1 / 24), rel=1e-9)


@exact_at_nodes
def test_sag_under_the_triangular_load_of_an_angular_acceleration(beam):
    """y = w₀ x (7l⁴ − 10 l²x² + 3x⁴)/(360 l EI), of a load that rises to w₀ = ρA l × 1 rad/s² at the end."""
    for fraction in (0.25, 0.5) if beam["elements"] > 2 else (0.5,):
        link = bar(**beam, gauge=fraction)
        share = fraction * (7 - 10 * fraction**2 + 3 * fraction**4) / 360
        assert at_rest("moment", "gauge", link) == pytest.approx(sag(link, share) * LENGTH, rel=1e-9)
    ends = {"slope_start": 7 / 360, "slope_end": -8 / 360}
    for slope, share in ends.items():
        assert at_rest("moment", slope, link) == pytest.approx(sag(link, share), rel=1e-9)


@exact_at_nodes
def test_a_moment_on_an_end(beam):
    """A moment of 1 on the far end turns it by l/3EI, the origin by −l/6EI, and lifts the middle −l²/16EI."""
    link = bar(**beam)
    unit = LENGTH / stiffness(link)
    assert at_rest("slope_end", "slope_end", link) == pytest.approx(unit / 3, rel=1e-9)
    assert at_rest("slope_end", "slope_start", link) == pytest.approx(-unit / 6, rel=1e-9)
    assert at_rest("slope_end", "gauge", link) == pytest.approx(-unit * LENGTH / 16, rel=1e-9)
    assert at_rest("slope_start", "slope_start", link) == pytest.approx(unit / 3, rel=1e-9)


def test_sine_modes_leave_a_tail_that_shrinks():
    """Left out are terms beyond n: of the sag below 1/4n⁴ of its first, of an end's own turn 6/π²n of it."""
    link = bar(**SINES)
    assert at_rest("force", "gauge", link) == pytest.approx(sag(link, 5 / 384), rel=0.25 / 40**4)
    turn = at_rest("slope_end", "slope_end", link) / (LENGTH / stiffness(link) / 3)
    assert turn == pytest.approx(1 - 6 / (np.pi**2 * 40.5), rel=1e-5)


def test_the_first_modes_carry_most_of_the_sag():
    first = at_rest("force", "gauge", bar(modes=1)) / at_rest("force", "gauge", bar())
    assert first == pytest.approx(1, abs=0.01)
    assert first != pytest.approx(1, abs=1e-3)
