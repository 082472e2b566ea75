"""Rigid open chains: mass matrix, velocity terms, gravity, kinetic and potential energy, pin reactions.

Reference: virtual work on P_j = base + sum_k L_jk e_k (the model, section 1), with constant tables

    H_kl = sum_j m_j L_jk L_jl + m_l s_l L_lk + m_k s_k L_kl + delta_kl J_k
    mu_k = sum_j m_j L_jk + m_k s_k
    M_kl = H_kl cos(theta_k - theta_l),  Q_k = -sum_l H_kl sin(theta_k - theta_l) w_l^2 - g mu_k cos theta_k
    floating base:  M_bb = sum m,  M_bk = mu_k n_k,  Q_b = sum_k mu_k e_k w_k^2 - g sum m on y,

gravity along -y; in any other direction its parts along n_k and the axes stand for cos theta_k and for y.

Assumptions: plane motion, rigid links, mass centres on the link's line. Units: SI.
"""

from collections.abc import Iterator

from sympy import Expr, Integer

from .coordinates import Coordinates, Freedom, dot
from .structure import Linkage, Pin
from .system import number

GRAVITY = number("g")
AXES = ((Integer(1), Integer(0)), (Integer(0), Integer(1)))


def inertia(structure: Linkage, c: Coordinates) -> Iterator[tuple[Freedom, Freedom, Expr]]:
    """Entries of the mass matrix over all freedoms, each pair once."""
    for k, m in structure.couplings:
        yield k, m, number(f"H_{k}_{m}") * c.cos(k, m)
    for f, links in enumerate(structure.floats):
        for axis in (0, 1):
            yield (f, axis), (f, axis), number(f"m_{f}")
            for k in links:
                yield (f, axis), k, number(f"mu_{k}") * c.n(k)[axis]


def force(structure: Linkage, c: Coordinates) -> Iterator[tuple[Freedom, Expr]]:
    """Velocity terms and gravity on link angles and bases."""
    for k, m in structure.couplings:
        if k != m:
            H, sin = number(f"H_{k}_{m}"), c.sin(k, m)
            yield k, -H * sin * c.speed[m] ** 2
            yield m, H * sin * c.speed[k] ** 2
    for f, links in enumerate(structure.floats):
        for axis in (0, 1):
            for k in links:
                yield (f, axis), number(f"mu_{k}") * c.e(k)[axis] * c.speed[k] ** 2
    if structure.gravity:
        for k in structure.links:
            yield k, -GRAVITY * number(f"mu_{k}") * height(structure, c.n(k))
        for f in range(len(structure.floats)):
            for axis in (0, 1) if structure.tilted else (1,):
                yield (f, axis), -GRAVITY * number(f"m_{f}") * height(structure, AXES[axis])


def height(structure: Linkage, vector: tuple[Expr, Expr]) -> Expr:
    """Part of a vector that points against gravity."""
    return dot((number("up_x"), number("up_y")), vector) if structure.tilted else vector[1]


def potential_energy(structure: Linkage, c: Coordinates) -> Expr:
    """V = g sum_k mu_k sin theta_k + g m y of floating bases, where gravity points along -y."""
    V = sum((number(f"mu_{k}") * height(structure, c.e(k)) for k in structure.links), Integer(0))
    bases = (height(structure, (c.position[f, 0], c.position[f, 1])) for f in range(len(structure.floats)))
    V += sum((number(f"m_{f}") * base for f, base in enumerate(bases)), Integer(0))
    return GRAVITY * V


def beyond(structure: Linkage, pin: Pin, c: Coordinates, axis: int) -> Expr:
    """Rate of momentum minus weight of all that moves beyond an ideal pin: sum m (a + g y)."""
    total = Integer(0)
    for k in pin.arms:
        moment = number(f"mu_{pin.name}_{k}")
        total += moment * (c.n(k)[axis] * c.acceleration[k] - c.e(k)[axis] * c.speed[k] ** 2)
    for chain, mass in pin.bases:
        total += number(mass) * c.acceleration[chain, axis]
    weight = number(f"m_{pin.name}") * GRAVITY * height(structure, AXES[axis])
    return total + weight if structure.gravity else total
