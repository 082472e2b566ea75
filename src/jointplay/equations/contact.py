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

from sympy import Expr, Float, Integer, Symbol, sqrt

from .coordinates import Coordinates, Freedom, dot
from .structure import Clearance
from .system import number

TINY = Float(1e-200)


@dataclass(frozen=True)
class Geometry:
    """Symbols of a joint's geometry and the assignments that define them, in order.

    `on_drive` are dv_n/dz and dv_t/dz of the driven link, `pushed` dv_n/dz and `spun` dv_t/dz of every
    freedom.
    """

    definitions: tuple[tuple[Symbol, Expr], ...]
    r: tuple[Symbol, Symbol]
    rho: Symbol
    direction: tuple[Symbol, Symbol]
    u: Symbol
    gap: Expr
    v_n: Symbol
    v_t: Symbol
    normal: tuple[Expr, ...]
    tangential: tuple[Expr, ...]
    on_drive: tuple[Expr, Expr]
    pushed: dict[Freedom, Expr]
    spun: dict[Freedom, Expr]


def _column(
    joint: Clearance, c: Coordinates, along: tuple[Expr, Expr], spin: dict[Freedom, Expr]
) -> dict[Freedom, Expr]:
    """Derivatives of `along`.r' plus spins with respect to the speed of every freedom."""
    column: dict[Freedom, Expr] = {}
    for k in joint.arms:
        D = number(f"D_{joint.name}_{k}")
        column[k] = D * c.longer(k) * dot(c.n(k), along)
        column |= {mode: D * share * dot(c.e(k), along) for mode, share in c.stretch.get(k, {}).items()}
    for f, sign in joint.bases:
        for axis in (0, 1):
            column[f, axis] = sign * along[axis]
    for k, arm in spin.items():
        column[k] = column.get(k, Integer(0)) + arm
    return column


def _spins(joint: Clearance, c: Coordinates, R: Expr, rho: Expr) -> dict[Freedom, Expr]:
    """Parts of v_t from the turning of journal and bearing: of their links and those links' end slopes."""
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

    r = tuple(
        let(
            f"r{'xy'[axis]}",
            number(f"r{'xy'[axis]}0_{name}")
            + sum(number(f"D_{name}_{k}") * c.longer(k) * c.e(k)[axis] for k in joint.arms)
            + sum(sign * c.position[f, axis] for f, sign in joint.bases),
        )
        for axis in (0, 1)
    )
    rho = let("rho", sqrt(r[0] ** 2 + r[1] ** 2 + TINY))
    unit = let("cos", r[0] / rho), let("sin", r[1] / rho)
    across = (-unit[1], unit[0])
    spin = _spins(joint, c, number(f"R_{name}"), rho)
    columns = [_column(joint, c, unit, {}), _column(joint, c, across, spin)]
    v_n, rows_n = _speed(let, c, columns[0], "N", "vn")
    v_t, rows_t = _speed(let, c, columns[1], "T", "vt")
    u, gap = let("u", rho - number(f"e_{name}")), r[0] ** 2 + r[1] ** 2 - number(f"e_{name}") ** 2
    prescribed = tuple(
        sum((entry * c.leads[k].get(driven, 0) for k, entry in column.items()), Integer(0))
        for column in columns
    )
    return Geometry(tuple(defs), r, rho, unit, u, gap, v_n, v_t, rows_n, rows_t, prescribed, *columns)


def _speed(let, c: Coordinates, column: dict[Freedom, Expr], letter: str, word: str):
    """Name the entries of a column and the relative speed that they make; and the row over the unknowns."""
    row, total = [Integer(0)] * len(c.speeds), Integer(0)
    for place, (freedom, entry) in enumerate(column.items()):
        named = let(f"{letter}{place}", entry)
        total += named * c.speed[freedom]
        for i, part in c.parts[freedom]:
            row[i] += part * named
    return let(word, total), tuple(row)
