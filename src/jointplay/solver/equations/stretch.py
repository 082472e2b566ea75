"""Elastic links that stretch: modes along the link, u(x, t) = sum_a psi_a(x) zeta_a(t), besides bending ones.

Reference: virtual work with the point of the link at P_j + (x + u) e_j + y n_j (y: equations.beam), exact in
this kinematics; stiffness is linear, that of a bar. psi_a(0) = 0, int rho A psi_a psi_b = delta_ab. With
A_a = int rho A psi_a (`along`), B_a = int rho A x psi_a (`lever`), G_ia = int rho A phi_i psi_a, A_j the
acceleration of the link's origin, alpha = A.zeta and y = G^T eta:

    on zeta_a       A_a A_j.e_j + zeta_a'' - y_a a_j - w_j^2 (B_a + zeta_a) - 2 w_j y_a' + Omega_a^2 zeta_a
                        = -g A_a sin theta_j
    on eta_i        (G zeta)_i a_j + 2 w_j (G zeta')_i
    on theta_j      alpha A_j.n_j + (G zeta).eta'' - y.zeta'' + (2 B.zeta + |zeta|^2) a_j
                        + 2 w_j (B + zeta).zeta' = -g alpha cos theta_j
    on the origin   (alpha'' - w_j^2 alpha) e_j + (a_j alpha + 2 w_j alpha') n_j.

The far end moves with the link's line: what is joined there sees the length l + sum_a psi_a(l) zeta_a.
Assumptions: small strains; axial force does not stiffen the bending (linear stiffness), nor does bending
shorten the link. Units: zeta in m kg^1/2.
"""

from collections.abc import Iterable, Iterator

from sympy import Expr, Integer

from .coordinates import Coordinates, Freedom
from .structure import Beam
from .system import number

Origin = Iterable[tuple[Freedom, Expr, Expr]]
ZERO = Integer(0)


def _each(beam: Beam, word: str) -> list[tuple[Freedom, Expr]]:
    return [(mode, number(f"{word}_{beam.link}_{mode[2]}")) for mode in beam.stretches]


def combined(beam: Beam, word: str, values: dict[Freedom, Expr]) -> Expr:
    """Sum over the modes along of a number times a coordinate, speed or acceleration."""
    return sum((factor * values[mode] for mode, factor in _each(beam, word)), ZERO)


def _crossed(beam: Beam, i: int, values: dict[Freedom, Expr]) -> Expr:
    """Sum over the modes along of G_ia times a coordinate or speed."""
    pairs = ((mode, number(f"G_{beam.link}_{i}_{mode[2]}")) for mode in beam.stretches)
    return sum((G * values[mode] for mode, G in pairs), ZERO)


def _swung(beam: Beam, a: int, values: dict[Freedom, Expr]) -> Expr:
    """Sum over the modes across of G_ia times a coordinate or speed."""
    return sum((number(f"G_{beam.link}_{i}_{a}") * values[beam.link, i] for i in range(beam.modes)), ZERO)


def inertia(beam: Beam, c: Coordinates, origin: Origin) -> Iterator[tuple[Freedom, Freedom, Expr]]:
    """Entries that the modes add to the mass matrix over all freedoms, each pair once."""
    j, zeta = beam.link, [c.position[mode] for mode in beam.stretches]
    alpha = combined(beam, "along", c.position)
    for mode, A in _each(beam, "along"):
        yield mode, mode, Integer(1)
        yield mode, j, -_swung(beam, mode[2], c.position)
        for k, _, along in origin:
            yield mode, k, A * along
    for i in range(beam.modes):
        yield (j, i), j, _crossed(beam, i, c.position)
    yield j, j, 2 * combined(beam, "lever", c.position) + sum((z**2 for z in zeta), ZERO)
    for k, across, _ in origin:
        yield j, k, alpha * across * (2 if k == j else 1)


def force(
    beam: Beam, c: Coordinates, origin: Origin, sway: tuple[Expr, Expr], weight: tuple[Expr, Expr]
) -> Iterator[tuple[Freedom, Expr]]:
    """Forces on the modes along, and their contributions to the other freedoms.

    `sway` is the part of the origin's acceleration that needs none of a freedom's, `weight` gravity against
    its direction, both along n_j and along e_j.
    """
    j, w = beam.link, c.speed[beam.link]
    across, along = (one + other for one, other in zip(sway, weight, strict=True))
    for (mode, A), (_, B) in zip(_each(beam, "along"), _each(beam, "lever"), strict=True):
        a = mode[2]
        yield mode, w**2 * (B + c.position[mode]) + 2 * w * _swung(beam, a, c.speed) - A * along
        yield mode, -number(f"axial_{j}_{a}") * c.position[mode]
        if beam.damped:
            yield mode, -number(f"axial_c_{j}_{a}") * c.speed[mode]
    for i in range(beam.modes):
        yield (j, i), -2 * w * _crossed(beam, i, c.speed)
    turning = sum((c.position[mode] * c.speed[mode] for mode in beam.stretches), ZERO)
    alpha, rate = combined(beam, "along", c.position), combined(beam, "along", c.speed)
    yield j, -2 * w * (combined(beam, "lever", c.speed) + turning) - alpha * across
    for k, n, e in origin:
        yield k, w**2 * alpha * e - 2 * w * rate * n


def momentum_rate(beam: Beam, c: Coordinates, axis: int) -> Expr:
    """Rate of the momentum that stretching adds to the link's."""
    j, w = beam.link, c.speed[beam.link]
    alpha, rate, rise = (combined(beam, "along", x) for x in (c.position, c.speed, c.acceleration))
    return (rise - w**2 * alpha) * c.e(j)[axis] + (c.acceleration[j] * alpha + 2 * w * rate) * c.n(j)[axis]


def squares(beam: Beam, word: str, values: dict[Freedom, Expr], share: Expr) -> Expr:
    """Sum over the modes of a number times the square of a coordinate or speed, times a share of it."""
    return sum((share * factor * values[mode] ** 2 for mode, factor in _each(beam, word)), ZERO)
