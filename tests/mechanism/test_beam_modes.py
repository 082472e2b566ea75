"""Mode shapes of a pinned beam: normalised, orthogonal, mirrored, and the same from elements and sines."""

import numpy as np
import pytest

from jointplay.solver.mechanism.parts.beam import modal, stiffness
from tests.mechanism.bars import BARS, Integrals, bar, sampled

CURVED = ("frequency", "slope_start", "slope_end", "gauge")
SUMMED = ("force", "moment")
each_link = pytest.mark.parametrize("data", BARS, ids=lambda data: data["name"])


@each_link
@pytest.mark.parametrize("elements", [1, 2, 5, 20])
def test_modes_are_orthonormal_in_mass_and_sum_up_as_told(data, elements):
    integrals, modes = Integrals(data, elements), modal(bar(data, elements=elements))
    root = data["mass"] ** 0.5
    assert integrals.of(integrals.shapes, integrals.shapes) == pytest.approx(np.eye(2 * elements), abs=1e-12)
    ones = np.ones((len(integrals.x), 1))
    assert integrals.of(integrals.shapes, ones)[:, 0] == pytest.approx(modes.force, abs=1e-13 * root)
    first = integrals.of(integrals.shapes, integrals.x[:, None])[:, 0]
    assert first == pytest.approx(modes.moment, abs=1e-13 * root * data["length"])


@each_link
def test_one_element_bends_with_its_frequencies_squared(data):
    """∫EI φ_i″ φ_j″ dx = ω_i² δ_ij, from the cubics themselves."""
    link = bar(data, elements=1)
    fractions = np.array([0.1, 0.4, 0.6, 0.9])
    cubics = np.polynomial.polynomial.polyfit(
        fractions * data["length"], sampled(data, fractions, elements=1), 3
    )
    modes, bent = modal(link), [np.polynomial.Polynomial(cubic).deriv(2) for cubic in cubics.T]
    energies = [[(a * b).integ()(data["length"]) * stiffness(link) for b in bent] for a in bent]
    squares = np.outer(modes.frequency, modes.frequency)
    assert np.array(energies) / squares == pytest.approx(np.eye(2), abs=1e-10)


@each_link
@pytest.mark.parametrize("beam", [{"elements": 1}, {"elements": 7}, {"shapes": "sine", "modes": 5}], ids=str)
def test_slopes_are_those_of_the_shapes_and_positive_at_the_origin(data, beam):
    step = 1e-4
    start = sampled(data, [step, 2 * step], **beam)
    end = sampled(data, [1 - step, 1 - 2 * step], **beam)
    modes = modal(bar(data, **beam))
    # One-sided differences of second order, with the deflection 0 at the pin.
    slopes = [(4 * near - far) / (2 * step * data["length"]) for near, far in (start, end)]
    assert slopes[0] == pytest.approx(modes.slope_start, rel=1e-4)
    assert slopes[1] == pytest.approx(-modes.slope_end, rel=1e-4)
    assert np.all(modes.slope_start > 0)


@each_link
def test_elements_and_sines_agree_as_elements_converge(data):
    exact, n = modal(bar(data, shapes="sine", modes=4)), np.arange(1, 5)
    gauge = {"gauge": 0.3}  # where none of these modes has a node
    exact = modal(bar(data, shapes="sine", modes=4, **gauge))
    for elements in (10, 20):
        found, wave = modal(bar(data, elements=elements, modes=4, **gauge)), n * np.pi / elements
        for name in CURVED:
            assert np.all(np.abs(getattr(found, name) / getattr(exact, name) - 1) < wave**4 / 600), name
        for name in SUMMED:
            scale = np.abs(getattr(exact, name)).max()
            assert np.all(np.abs(getattr(found, name) - getattr(exact, name)) < scale * wave**4 / 3000), name


@pytest.mark.parametrize("beam", [{"elements": 2}, {"elements": 5}, {"shapes": "sine", "modes": 6}], ids=str)
def test_a_beam_looks_the_same_from_its_other_end(beam):
    modes = modal(bar(**beam))
    sign = (-1.0) ** np.arange(len(modes.frequency))  # even and odd about the middle, in turn
    there, back = (modal(bar(**beam, gauge=gauge)).gauge for gauge in (0.23, 0.77))
    assert back == pytest.approx(sign * there)
    assert modes.slope_end == pytest.approx(-sign * modes.slope_start)
    length, scale = 0.181, modes.force.max()
    assert modes.force[1::2] == pytest.approx(0, abs=1e-12 * scale)
    assert length * modes.force - modes.moment == pytest.approx(sign * modes.moment, abs=1e-12 * scale)


def test_what_is_cached_cannot_be_spoilt():
    first = modal(bar())
    for values in vars(first).values():
        values[:] = 0
    assert modal(bar()).frequency[0] > 0
