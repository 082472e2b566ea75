"""Elastic links: transverse modes of a beam in the link's floating frame, y(x, t) = sum_i phi_i(x) eta_i(t).

Reference: the model, section 4. Euler-Bernoulli beam, zero deflection at both ends, modes normalised so that
int rho A phi_i phi_j = delta_ij. With S_i = int rho A phi_i, I_i = int rho A x phi_i, sigma = S.eta, and A_j
the acceleration of the link's origin, virtual work gives, beside the rigid terms,

    on eta_i        S_i A_j.n_j + I_i a_j + eta_i'' - w_j^2 eta_i + 2 xi omega_i eta_i' + omega_i^2 eta_i
                        = -g S_i cos theta_j + moments on the end slopes
    on theta_j      I.eta'' - sigma A_j.e_j + |eta|^2 a_j + 2 w_j eta.eta' = g sigma sin theta_j
    on the origin   S.eta'' n_j - (2 w_j sigma' + a_j sigma) e_j - w_j^2 sigma n_j.

`order` "paper" keeps only what is linear in eta'' and the beam's own vibration, as equations (3)-(12) of
Chunmei et al. (2002) do: S.eta'', I.eta'', and no w_j^2 eta_i. Assumptions: small deflections, no stretch but
that of equations.stretch, the drive acts on the link's frame. Units: eta in m kg^1/2.
"""

from collections.abc import Iterator

from sympy import Expr, Integer

from . import stretch
from .chain import GRAVITY, height
from .coordinates import Coordinates, Freedom
from .structure import Beam, Linkage
from .system import number


def _each(beam: Beam, word: str) -> list[Expr]:
    return [number(f"{word}_{beam.link}_{i}") for i in range(beam.modes)]


def modes(beam: Beam) -> list[Freedom]:
    """The beam's freedoms."""
    return [(beam.link, i) for i in range(beam.modes)]


def combined(beam: Beam, word: str, values: dict[Freedom, Expr]) -> Expr:
    """Sum over the modes of a number (S, I, …) times a coordinate, speed or acceleration."""
    pairs = zip(_each(beam, word), modes(beam), strict=True)
    return sum((factor * values[mode] for factor, mode in pairs), Integer(0))


def _origin(beam: Beam, c: Coordinates) -> Iterator[tuple[Freedom, Expr, Expr]]:
    """Freedoms that move the link's origin, with the parts of their unit motion along n_j and along e_j."""
    j = beam.link
    for k in beam.arms:
        L = number(f"L_{j}_{k}")
        yield k, L * c.cos(k, j), -L * c.sin(k, j)
    for axis in (0, 1) if beam.chain is not None else ():
        yield (beam.chain, axis), c.n(j)[axis], c.e(j)[axis]


def inertia(structure: Linkage, beam: Beam, c: Coordinates) -> Iterator[tuple[Freedom, Freedom, Expr]]:
    """Entries that the modes add to the mass matrix over all freedoms, each pair once."""
    j = beam.link
    for mode, S, I in zip(modes(beam), _each(beam, "S"), _each(beam, "I"), strict=True):
        yield mode, mode, Integer(1)
        yield mode, j, I
        for k, across, _ in _origin(beam, c):
            yield mode, k, S * across
    if structure.order == "consistent":
        sigma = combined(beam, "S", c.position)
        yield j, j, sum(c.position[mode] ** 2 for mode in modes(beam))
        for k, _, along in _origin(beam, c):
            yield j, k, -sigma * along * (2 if k == j else 1)
    if beam.axial:
        yield from stretch.inertia(beam, c, list(_origin(beam, c)))


def _sway(beam: Beam, c: Coordinates) -> tuple[Expr, Expr]:
    """Parts of the origin's acceleration that need none of a freedom's, along n_j and along e_j."""
    j, squares = beam.link, [(k, number(f"L_{beam.link}_{k}") * c.speed[k] ** 2) for k in beam.arms]
    across = -sum((square * c.sin(k, j) for k, square in squares), Integer(0))
    return across, -sum((square * c.cos(k, j) for k, square in squares), Integer(0))


def excitation(structure: Linkage, beam: Beam, c: Coordinates) -> Iterator[tuple[Freedom, Expr]]:
    """Loads that bend a straight beam: inertia of the frame's motion, and gravity."""
    weight = GRAVITY * height(structure, c.n(beam.link)) if structure.gravity else Integer(0)
    for mode, S in zip(modes(beam), _each(beam, "S"), strict=True):
        yield mode, -S * (_sway(beam, c)[0] + weight)


def force(structure: Linkage, beam: Beam, c: Coordinates) -> Iterator[tuple[Freedom, Expr]]:
    """Forces on the modes, and their contributions to the other freedoms."""
    j, consistent = beam.link, structure.order == "consistent"
    w = c.speed[j]
    yield from excitation(structure, beam, c)
    for mode, stiffness, drag in zip(modes(beam), _each(beam, "k"), _each(beam, "c"), strict=True):
        spun = w**2 * c.position[mode] if consistent else Integer(0)
        yield mode, spun - stiffness * c.position[mode] - (drag * c.speed[mode] if beam.damped else 0)
    if not consistent:
        return
    sigma, rate = combined(beam, "S", c.position), combined(beam, "S", c.speed)
    turning = sum(c.position[mode] * c.speed[mode] for mode in modes(beam))
    heave = GRAVITY * height(structure, c.e(j)) if structure.gravity else Integer(0)
    yield j, sigma * (_sway(beam, c)[1] + heave) - 2 * w * turning
    for k, across, along in _origin(beam, c):
        yield k, 2 * w * rate * along + w**2 * sigma * across
    if beam.axial:
        weight = GRAVITY * height(structure, c.n(j)) if structure.gravity else Integer(0)
        yield from stretch.force(beam, c, list(_origin(beam, c)), _sway(beam, c), (weight, heave))


def strain_energy(beam: Beam, c: Coordinates) -> Expr:
    """sum_i omega_i^2 eta_i^2 / 2, and the same of modes of stretch."""
    half = Integer(1) / 2
    return _squares(beam, "k", c.position, half) + stretch.squares(beam, "axial", c.position, half)


def weight_energy(structure: Linkage, beam: Beam, c: Coordinates) -> Expr:
    """Gravity's energy of the deflection."""
    bent = height(structure, c.n(beam.link)) * combined(beam, "S", c.position)
    return GRAVITY * (bent + height(structure, c.e(beam.link)) * stretch.combined(beam, "along", c.position))


def dissipated_power(beam: Beam, c: Coordinates) -> Expr:
    """Power that structural damping takes."""
    one = Integer(1)
    return _squares(beam, "c", c.speed, one) + stretch.squares(beam, "axial_c", c.speed, one)


def _squares(beam: Beam, word: str, values: dict[Freedom, Expr], share: Expr) -> Expr:
    """Sum over the modes of a number times the square of a coordinate or speed, times a share of it."""
    pairs = zip(_each(beam, word), modes(beam), strict=True)
    return sum((share * factor * values[mode] ** 2 for factor, mode in pairs), Integer(0))


def momentum_rate(structure: Linkage, beam: Beam, c: Coordinates, axis: int) -> Expr:
    """Rate of the momentum that the deflection adds to the link's."""
    j, bend = beam.link, combined(beam, "S", c.acceleration)
    total = bend * c.n(j)[axis]
    if structure.order == "consistent":
        w, sigma, rate = c.speed[j], combined(beam, "S", c.position), combined(beam, "S", c.speed)
        along = 2 * w * rate + c.acceleration[j] * sigma
        total -= along * c.e(j)[axis] + w**2 * sigma * c.n(j)[axis]
    return total + stretch.momentum_rate(beam, c, axis) if beam.axial else total


def deflections(structure: Linkage, c: Coordinates) -> Iterator[tuple[str, Expr]]:
    """Deflection at the gauge of each link, by name; of a rigid one 0."""
    beams = {beam.link: beam for beam in structure.beams}
    for k in structure.links:
        yield f"deflection:{k}", combined(beams[k], "gauge", c.position) if k in beams else Integer(0)
