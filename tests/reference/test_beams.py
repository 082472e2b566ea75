"""The reference's beam is the textbook's: matrices, frequencies, damping, static deflection."""

from __future__ import annotations

import math

import numpy as np
import pytest

from .beams import Beam, Line
from .textbook import textbook


@pytest.mark.parametrize("elements", [1, 2, 5])
def test_particles_make_the_textbook_beam(elements):
    line = Line(Beam(elements=elements), 0.181, 0.1743)
    M, K, S, I = textbook(line, 0.1743)
    assert line.inertia == pytest.approx(M, rel=1e-12, abs=1e-12 * M.max())
    assert line.stiffness == pytest.approx(K, rel=1e-12, abs=1e-12 * K.max())
    assert line.weight @ line.shape == pytest.approx(S, rel=1e-12, abs=1e-12 * S.max())
    assert (line.weight * line.x) @ line.shape == pytest.approx(I, rel=1e-12, abs=1e-12 * I.max())


def test_frequencies_are_a_pinned_bar_s():
    """First frequency (pi/l)^2 sqrt(EI/rho A); section 4 quotes it for the coupler and the crank."""
    for link, length, mass, quoted in (("coupler", 0.181, 0.1743, 4.9e3), ("crank", 0.03, 0.4489, 7e5)):
        line = Line(Beam(elements=24), length, mass)
        exact = [(k * math.pi / length) ** 2 * math.sqrt(line.bending * length / mass) for k in (1, 2, 3)]
        assert line.frequency[:3] == pytest.approx(exact, rel=1e-4), link
        assert line.frequency[0] == pytest.approx(quoted, rel=0.03), link


def test_damping_is_that_share_of_every_mode():
    """Roots of s^2 M + s C + K are omega (-xi +- i sqrt(1 - xi^2))."""
    line = Line(Beam(xi=0.3), 0.181, 0.1743)
    n = line.size
    inverse = np.linalg.inv(line.inertia)
    flow = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ line.stiffness, -inverse @ line.damping]])
    roots = np.linalg.eigvals(flow)
    assert np.sort(np.abs(roots))[::2] == pytest.approx(line.frequency, rel=1e-7)
    assert -roots.real / np.abs(roots) == pytest.approx(0.3, rel=1e-7)


@pytest.mark.parametrize("elements", [2, 4])
def test_static_deflection_is_the_closed_form(elements):
    """Even load q: 5 q l^4 / 384 EI in the middle; load growing to q at the far end: 5 q l^4 / 768 EI."""
    line = Line(Beam(elements=elements), 0.181, 0.1743)
    gauss = line.weight * line.length / 0.1743
    even, growing = gauss @ line.shape, (gauss * line.x / line.length) @ line.shape
    unit = line.length**4 / line.bending
    assert line.middle @ np.linalg.solve(line.stiffness, even) == pytest.approx(5 / 384 * unit, rel=1e-12)
    assert line.middle @ np.linalg.solve(line.stiffness, growing) == pytest.approx(5 / 768 * unit, rel=1e-12)
