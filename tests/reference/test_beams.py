"""The second program's bending links are the textbook's beams: matrices, frequencies, damping, deflection."""

from __future__ import annotations

import math

import numpy as np
import pytest

from .four_bar import Beam

COUPLER = 0.181, 0.1743  # length and mass


def textbook(beam, length, mass):
    """Consistent mass, stiffness, S and I of Hermite elements from the closed forms of textbooks."""
    count, per_length = beam.elements, mass / length
    h, (bending, _) = length / count, beam.stiffness(length, mass)
    M, K, S, I = *np.zeros((2, 2 * count + 2, 2 * count + 2)), *np.zeros((2, 2 * count + 2))
    m = [
        [156, 22 * h, 54, -13 * h],
        [0, 4 * h * h, 13 * h, -3 * h * h],
        [0, 0, 156, -22 * h],
        [0, 0, 0, 4 * h * h],
    ]
    k = [[12, 6 * h, -12, 6 * h], [0, 4 * h * h, -6 * h, 2 * h * h], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h * h]]
    area = np.array([h / 2, h**2 / 12, h / 2, -(h**2) / 12])
    moment = np.array([3 / 20, h / 30, 7 / 20, -h / 20])
    for e in range(count):
        at = slice(2 * e, 2 * e + 4)
        for whole, part in ((M, per_length * h / 420 * np.array(m)), (K, bending / h**3 * np.array(k))):
            whole[at, at] += np.triu(part) + np.triu(part, 1).T
        S[at] += per_length * area
        I[at] += per_length * (e * h * area + h * h * moment)
    keep = [i for i in range(2 * count + 2) if i not in (0, 2 * count)]
    return M[np.ix_(keep, keep)], K[np.ix_(keep, keep)], S[keep], I[keep]


@pytest.mark.parametrize("elements", [1, 2, 5])
def test_particles_make_the_textbook_beam(elements):
    beam = Beam(elements=elements)
    row = beam.row(*COUPLER)
    M, K, S, I = textbook(beam, *COUPLER)
    assert row.inertia == pytest.approx(M, rel=1e-12, abs=1e-12 * M.max())
    assert row.stiffness == pytest.approx(K, rel=1e-12, abs=1e-12 * K.max())
    assert row.weight @ row.across == pytest.approx(S, rel=1e-12, abs=1e-12 * S.max())
    assert (row.weight * row.x) @ row.across == pytest.approx(I, rel=1e-12, abs=1e-12 * I.max())


def test_frequencies_are_a_pinned_bar_s():
    """First frequency (pi/l)^2 sqrt(EI/rho A); section 4 quotes it for the coupler and the crank."""
    for link, length, mass, quoted in (("coupler", *COUPLER, 4.9e3), ("crank", 0.03, 0.4489, 7e5)):
        beam = Beam(elements=24)
        row, (bending, _) = beam.row(length, mass), beam.stiffness(length, mass)
        exact = [(k * math.pi / length) ** 2 * math.sqrt(bending * length / mass) for k in (1, 2, 3)]
        assert row.frequency[:3] == pytest.approx(exact, rel=1e-4), link
        assert row.frequency[0] == pytest.approx(quoted, rel=0.03), link


def test_damping_is_that_share_of_every_mode():
    """Roots of s^2 M + s C + K are omega (-xi +- i sqrt(1 - xi^2))."""
    row = Beam(xi=0.3).row(*COUPLER)
    n = row.size
    inverse = np.linalg.inv(row.inertia)
    flow = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ row.stiffness, -inverse @ row.damping]])
    roots = np.linalg.eigvals(flow)
    assert np.sort(np.abs(roots))[::2] == pytest.approx(row.frequency, rel=1e-7)
    assert -roots.real / np.abs(roots) == pytest.approx(0.3, rel=1e-7)


@pytest.mark.parametrize("elements", [2, 4])
def test_static_deflection_is_the_closed_form(elements):
    """Even load q: 5 q l^4 / 384 EI in the middle; load growing to q at the far end: 5 q l^4 / 768 EI."""
    beam, (length, mass) = Beam(elements=elements), COUPLER
    row = beam.row(length, mass)
    gauss = row.weight * length / mass
    even, growing = gauss @ row.across, (gauss * row.x / length) @ row.across
    unit = length**4 / beam.stiffness(length, mass)[0]
    assert row.middle @ np.linalg.solve(row.stiffness, even) == pytest.approx(5 / 384 * unit, rel=1e-12)
    assert row.middle @ np.linalg.solve(row.stiffness, growing) == pytest.approx(5 / 768 * unit, rel=1e-12)
