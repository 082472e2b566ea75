"""Rigid open chains: mass matrix, velocity terms, gravity, kinetic and potential energy, pin reactions.

Reference: virtual work on P_j = base + sum_k L_jk e_k (the model, section 1), with constant tables

    H_kl = sum_j m_j L_jk L_jl + m_l s_l L_lk + m_k s_k L_kl + delta_kl J_k
    mu_k = sum_j m_j L_jk + m_k s_k
    M_kl = H_kl cos(theta_k - theta_l),  Q_k = -sum_l H_kl sin(theta_k - theta_l) w_l^2 - g mu_k cos theta_k
    floating base:  M_bb = sum m,  M_bk = mu_k n_k,  Q_b = sum_k mu_k e_k w_k^2 - g sum m on y.

Assumptions: plane motion, rigid links, mass centres on the link's line. Units: SI.
"""

from dataclasses import dataclass

from sympy import Expr, Integer, Symbol

from .structure import Linkage
from .system import Angle, accelerations, number

GRAVITY = number("g")


@dataclass(frozen=True)
class Coordinates:
    """Symbols of a linkage's motion: angle, speed, acceleration of each link; bases of floating chains."""

    angle: dict[str, Angle]
    speed: dict[str, Expr]
    acceleration: dict[str, Expr]
    base: tuple[tuple[Symbol, Symbol], ...]
    base_speed: tuple[tuple[Symbol, Symbol], ...]
    base_acceleration: tuple[tuple[Expr, Expr], ...]
    positions: tuple[Symbol, ...]
    speeds: tuple[Symbol, ...]

    def e(self, k: str) -> tuple[Expr, Expr]:
        """Unit vector along link k."""
        return self.angle[k].cos, self.angle[k].sin

    def n(self, k: str) -> tuple[Expr, Expr]:
        """Unit vector across link k."""
        return -self.angle[k].sin, self.angle[k].cos

    def index(self, speed: Expr) -> int | None:
        """Place of a speed among the unknowns; None where it is prescribed."""
        return self.speeds.index(speed) if speed in self.speeds else None


def coordinates(structure: Linkage) -> Coordinates:
    """Name the unknowns: free link angles first, then x, y of each floating chain."""
    free = [k for k in structure.links if structure.drive != "speed" or k != structure.driven]
    angle, speed, acceleration = {}, {}, {}
    solved = iter(accelerations(len(free) + 2 * len(structure.floats)))
    for k in structure.links:
        if k in free:
            angle[k] = Angle(k, Symbol(f"theta_{k}", real=True))
            speed[k], acceleration[k] = Symbol(f"w_{k}", real=True), next(solved)
        else:
            angle[k] = Angle(k, None, number("Omega"), number("theta_0"))
            speed[k], acceleration[k] = number("Omega"), Integer(0)
    floats = range(len(structure.floats))
    base = tuple((Symbol(f"x_{i}", real=True), Symbol(f"y_{i}", real=True)) for i in floats)
    base_speed = tuple((Symbol(f"vx_{i}", real=True), Symbol(f"vy_{i}", real=True)) for i in floats)
    base_acceleration = tuple((next(solved), next(solved)) for _ in floats)
    positions = [angle[k].position for k in free] + [q for pair in base for q in pair]
    speeds = [speed[k] for k in free] + [v for pair in base_speed for v in pair]
    return Coordinates(
        angle, speed, acceleration, base, base_speed, base_acceleration, tuple(positions), tuple(speeds)
    )


def coupled(structure: Linkage, k: str, m: str) -> Symbol | None:
    """The table entry H_km of the mass matrix, or None where it vanishes identically."""
    for pair in ((k, m), (m, k)):
        if pair in structure.couplings:
            return number(f"H_{pair[0]}_{pair[1]}")
    return None


def _cos_between(c: Coordinates, k: str, m: str) -> Expr:
    a, b = c.angle[k], c.angle[m]
    return a.cos * b.cos + a.sin * b.sin if k != m else Integer(1)


def _sin_between(c: Coordinates, k: str, m: str) -> Expr:
    a, b = c.angle[k], c.angle[m]
    return a.sin * b.cos - a.cos * b.sin


def mass_matrix(structure: Linkage, c: Coordinates) -> dict[tuple[int, int], Expr]:
    """Lower triangle of M over the unknown speeds."""
    entries = {}
    for k in structure.links:
        for m in structure.links:
            H, i, j = coupled(structure, k, m), c.index(c.speed[k]), c.index(c.speed[m])
            if H is not None and i is not None and j is not None and i >= j:
                entries[i, j] = H * _cos_between(c, k, m)
    for f, links in enumerate(structure.floats):
        for axis in (0, 1):
            i = c.index(c.base_speed[f][axis])
            entries[i, i] = number(f"m_{f}")
            for k in links:
                j = c.index(c.speed[k])
                if j is not None:
                    entries[i, j] = number(f"mu_{k}") * c.n(k)[axis]
    return entries


def force(structure: Linkage, c: Coordinates, k: str) -> Expr:
    """Velocity terms and gravity on the angle of link k."""
    Q = Integer(0)
    for m in structure.links:
        H = coupled(structure, k, m)
        if H is not None and m != k:
            Q -= H * _sin_between(c, k, m) * c.speed[m] ** 2
    return Q - GRAVITY * number(f"mu_{k}") * c.angle[k].cos if structure.gravity else Q


def base_force(structure: Linkage, c: Coordinates, f: int, axis: int) -> Expr:
    """Velocity terms and gravity on a floating chain's base point."""
    Q = sum((number(f"mu_{k}") * c.e(k)[axis] * c.speed[k] ** 2 for k in structure.floats[f]), Integer(0))
    return Q - GRAVITY * number(f"m_{f}") if structure.gravity and axis == 1 else Q


def kinetic_energy(structure: Linkage, c: Coordinates) -> Expr:
    """T = sum_kl H_kl cos(theta_k - theta_l) w_k w_l / 2 + floating bases."""
    T = Integer(0)
    for k in structure.links:
        for m in structure.links:
            H = coupled(structure, k, m)
            if H is not None:
                T += H * _cos_between(c, k, m) * c.speed[k] * c.speed[m] / 2
    for f, links in enumerate(structure.floats):
        for axis in (0, 1):
            v = c.base_speed[f][axis]
            T += number(f"m_{f}") * v**2 / 2
            T += sum(number(f"mu_{k}") * c.n(k)[axis] * c.speed[k] * v for k in links)
    return T


def potential_energy(structure: Linkage, c: Coordinates) -> Expr:
    """V = g sum_k mu_k sin theta_k + g m y of floating bases."""
    if not structure.gravity:
        return Integer(0)
    V = sum((number(f"mu_{k}") * c.angle[k].sin for k in structure.links), Integer(0))
    V += sum((number(f"m_{f}") * c.base[f][1] for f in range(len(structure.floats))), Integer(0))
    return GRAVITY * V


def inertia_torque(structure: Linkage, c: Coordinates, k: str) -> Expr:
    """Left side minus right side of link k's equation, without contacts: what a drive must supply."""
    torque = -force(structure, c, k)
    for m in structure.links:
        H = coupled(structure, k, m)
        if H is not None:
            torque += H * _cos_between(c, k, m) * c.acceleration[m]
    for f, links in enumerate(structure.floats):
        if k in links:
            torque += number(f"mu_{k}") * sum(c.n(k)[i] * c.base_acceleration[f][i] for i in (0, 1))
    return torque


def beyond(pin, c: Coordinates, axis: int, gravity: bool) -> Expr:
    """Rate of momentum minus weight of all that moves beyond an ideal pin: sum m (a + g y)."""
    total = Integer(0)
    for k in pin.arms:
        moment = number(f"mu_{pin.name}_{k}")
        total += moment * (c.n(k)[axis] * c.acceleration[k] - c.e(k)[axis] * c.speed[k] ** 2)
    if pin.chain is not None:
        total += number(f"m_{pin.name}") * c.base_acceleration[pin.chain][axis]
    return total + number(f"m_{pin.name}") * GRAVITY if gravity and axis == 1 else total
