"""Frequencies of a pinned beam against (nπ/l)² √(EI/ρA), and the order at which elements reach it."""

import numpy as np
import pytest

from jointplay.solver.mechanism.parts.beam import modal
from tests.mechanism.bars import BARS, COUPLER, CRANK, ROCKER, bar, frequency


@pytest.mark.parametrize("data", BARS, ids=lambda data: data["name"])
def test_sine_modes_have_the_exact_frequencies(data):
    found = modal(bar(data, shapes="sine", modes=6)).frequency
    assert found == pytest.approx([frequency(data, n) for n in range(1, 7)], rel=1e-13)


@pytest.mark.parametrize(
    ("mode", "elements"), [(1, (2, 3, 4, 6, 8)), (2, (4, 6, 8, 12)), (3, (6, 8, 12, 16))]
)
def test_elements_converge_at_fourth_order(mode, elements):
    found = np.array([modal(bar(elements=n)).frequency[mode - 1] for n in elements])
    error = found / frequency(COUPLER, mode) - 1
    assert np.all(error > 0), "a Rayleigh quotient is never below the exact frequency"
    order = -np.polyfit(np.log(elements), np.log(error), 1)[0]
    assert order == pytest.approx(4, abs=0.1)


def test_two_elements_are_the_papers_four_tenths_of_a_percent_high():
    assert modal(bar()).frequency[0] / frequency(COUPLER, 1) - 1 == pytest.approx(0.004, abs=1e-4)


@pytest.mark.parametrize(("data", "about"), [(COUPLER, 4899.6), (CRANK, 7.03e5), (ROCKER, 18664)])
def test_first_frequencies_of_the_papers_links(data, about):
    assert modal(bar(data, shapes="sine")).frequency[0] == pytest.approx(about, rel=2e-4)


def test_a_square_section_is_stiffer():
    ratio = modal(bar(section="square")).frequency / modal(bar()).frequency
    assert ratio == pytest.approx(np.sqrt(np.pi / 3), rel=1e-12)


def test_material_and_section_enter_as_the_formula_says():
    plain = modal(bar()).frequency
    assert modal(bar(modulus=4 * 2.1e11)).frequency == pytest.approx(2 * plain, rel=1e-12)
    thin = modal(bar(density=4 * 7800.0)).frequency  # of the same mass, so a quarter of the area
    assert thin == pytest.approx(plain / 4, rel=1e-12)
    assert modal(bar(second_moment=1.2129e-9)).frequency == pytest.approx(plain, rel=1e-4)
    area = 0.1743 / (7800 * 0.181)
    assert modal(bar(area=area / 4)).frequency == pytest.approx(plain / 2, rel=1e-12)


def test_fewer_modes_are_the_first_ones():
    assert modal(bar(elements=3, modes=2)).frequency == pytest.approx(modal(bar(elements=3)).frequency[:2])
    assert modal(bar(elements=3)).frequency.shape == (6,)
    assert modal(bar(shapes="sine")).frequency.shape == (4,)
