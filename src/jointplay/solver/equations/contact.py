"""Geometry of a joint with play.

Reference: Chunmei, Yang, Ling and Ling (2002), equations (13)-(18), derived anew from virtual work. With
r = journal centre - bearing centre, rho = |r|, r^ = r/rho and t^ across it,

    u = rho - e,     v_n = r'.r^ = sum_k N_k w_k,     v_t = r'.t^ + (w_p - w_q) R - w_q rho = sum_k T_k w_k,
    N_k = D_k n_k.r^,  T_k = D_k n_k.t^ + (R on the journal's link) - (R + rho on the bearing's link),
    Q_k = -N_k F_n - T_k F_t          (force F on the bearing, -F on the journal).

Where the link of journal or bearing bends, its end turns with theta_k plus the end slope: the spin terms of
v_t, and so the friction moment, act on the slope's modes as on w_k.

At rho = 0 the direction is undefined and the joint is free; TINY keeps the division finite there. Contact
begins and ends at rho^2 - e^2 = 0: rho has a kink where the journal flies past the bearing's centre, and no
polynomial follows it there.
"""

from dataclasses import dataclass

from sympy import Expr, Float, Integer, Symbol, atan2, sqrt

from .coordinates import Coordinates, Freedom, dot
from .structure import Clearance
from .system import number

TINY = Float(1e-200)


@dataclass(frozen=True)
class Geometry:
    """Symbols of a contact's geometry and the assignments that define them, in order.

    `r` and `rho` are the journal's displacement and its size, u = rho - e; a corner's is across the guide.
    `direction` and `across` are those of F_n and F_t on the bearing, `angle` that of `direction`. `gap` is
    what is watched in the place of u (None: u), `wall` the gap of a rigid bearing and `steep` -dwall/du;
    `slide` and its rate are those of a slider. `on_drive` are dv_n/dz and dv_t/dz of the driven link,
    `pushed` dv_n/dz and `spun` dv_t/dz of every freedom.
    """

    definitions: tuple[tuple[Symbol, Expr], ...]
    r: tuple[Expr, Expr]
    rho: Expr
    direction: tuple[Expr, Expr]
    across: tuple[Expr, Expr]
    angle: Expr
    u: Symbol
    gap: Expr | None
    wall: Expr
    steep: Expr
    v_n: Symbol
    v_t: Symbol
    normal: tuple[Expr, ...]
    tangential: tuple[Expr, ...]
    on_drive: tuple[Expr, Expr]
    pushed: dict[Freedom, Expr]
    spun: dict[Freedom, Expr]
    slide: tuple[Expr, Expr] | None = None


def column(
    joint: Clearance, c: Coordinates, along: tuple[Expr, Expr], spin: dict[Freedom, Expr]
) -> dict[Freedom, Expr]:
    """Derivatives of `along`.r' plus spins with respect to the speed of every freedom."""
    found: dict[Freedom, Expr] = {}
    for k in joint.arms:
        D = number(f"D_{joint.owner}_{k}")
        found[k] = D * c.longer(k) * dot(c.n(k), along)
        found |= {mode: D * share * dot(c.e(k), along) for mode, share in c.stretch.get(k, {}).items()}
    for f, sign in joint.bases:
        for axis in (0, 1):
            found[f, axis] = sign * along[axis]
    for k, arm in spin.items():
        found[k] = found.get(k, Integer(0)) + arm
    return found


def _spins(joint: Clearance, c: Coordinates, R: Expr, rho: Expr) -> dict[Freedom, Expr]:
    """Parts of v_t from the turning of journal and bearing: of their links and the links' end slopes."""
    found: dict[Freedom, Expr] = {}
    for link, end, arm in zip((joint.journal, joint.bearing), joint.ends, (R, -R - rho), strict=True):
        if link != "ground":
            found[link] = arm
        slopes = [(mode, f"{end}_{link}_{mode[1]}") for mode in c.speed if mode[:1] == (link,)]
        found |= {mode: arm * number(name) for mode, name in slopes}
    return found


def geometry(joint: Clearance, c: Coordinates, driven: str) -> Geometry:
    """Write a joint's penetration, speeds, and their derivatives by speed."""
    name, defs = joint.name, []

    def let(symbol: str, value: Expr) -> Symbol:
        defs.append((Symbol(f"{symbol}_{name}", real=True), value))
        return defs[-1][0]

    r = tuple(let(f"r{'xy'[axis]}", between(joint, c, axis)) for axis in (0, 1))
    rho = let("rho", sqrt(r[0] ** 2 + r[1] ** 2 + TINY))
    unit = let("cos", r[0] / rho), let("sin", r[1] / rho)
    across = (-unit[1], unit[0])
    spin = _spins(joint, c, number(f"R_{name}"), rho)
    columns = [column(joint, c, unit, {}), column(joint, c, across, spin)]
    v_n, rows_n = speed(let, c, columns[0], "N", "vn")
    v_t, rows_t = speed(let, c, columns[1], "T", "vt")
    e = number(f"e_{name}")
    u, gap = let("u", rho - e), r[0] ** 2 + r[1] ** 2 - e**2
    return Geometry(
        definitions=tuple(defs),
        r=r,
        rho=rho,
        direction=unit,
        across=across,
        angle=atan2(r[1], r[0]),
        u=u,
        gap=gap,
        wall=-gap / (2 * e),  # e - rho where it closes, and smooth everywhere
        steep=rho / e,
        v_n=v_n,
        v_t=v_t,
        normal=rows_n,
        tangential=rows_t,
        on_drive=on_drive(columns, c, driven),
        pushed=columns[0],
        spun=columns[1],
    )


def between(joint: Clearance, c: Coordinates, axis: int) -> Expr:
    """The vector from the bearing's point to the journal's, along an axis."""
    return (
        number(f"r{'xy'[axis]}0_{joint.owner}")
        + sum(number(f"D_{joint.owner}_{k}") * c.longer(k) * c.e(k)[axis] for k in joint.arms)
        + sum(sign * c.position[f, axis] for f, sign in joint.bases)
    )


def on_drive(columns: list[dict[Freedom, Expr]], c: Coordinates, driven: str) -> tuple[Expr, ...]:
    """Coefficients of the driven link's speed in the speeds of these columns."""
    return tuple(
        sum((entry * c.leads[k].get(driven, 0) for k, entry in each.items()), Integer(0)) for each in columns
    )


def speed(let, c: Coordinates, column: dict[Freedom, Expr], letter: str, word: str):
    """Name the entries of a column and the relative speed that they make; and the row over the unknowns."""
    row, total = [Integer(0)] * len(c.speeds), Integer(0)
    for place, (freedom, entry) in enumerate(column.items()):
        named = let(f"{letter}{place}", entry)
        total += named * c.speed[freedom]
        for i, part in c.parts[freedom]:
            row[i] += part * named
    return let(word, total), tuple(row)
