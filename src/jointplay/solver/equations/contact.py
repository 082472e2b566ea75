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

Geometry of a slider's corner in a guide with play.

Derived from virtual work. The slider is a block of half length a and half height b about the journal's point;
the guide has the direction d, the normal n, and faces at +-(b + e) from its line. With l, m along and across
the slider, f = +-1 at its front or rear, s = +-1 at its upper or lower side, p = f a l + s b m from the
journal's point to the corner, r from the guide's point to the journal's, and w_p, w_q the speeds of slider
and guide,

    u = s y - b - e,    y = n.(r + p),    v_n = s y',    y' = n.r' + (d.p) w_p - x w_q,
                        x = d.(r + p),    v_t = x',      x' = d.r' - (n.p) w_p + y w_q,
    Q_k = -F_n dv_n/dz_k - F_t dv_t/dz_k        (force F_n s n + F_t d on the guide, at the corner).

u grows past the face, and is smooth everywhere. Each corner is a contact of its own: two on one face carry a
slider that rests on it, two on opposite faces one that is jammed. Assumptions: faces are straight, and longer
than the slider's way; slider and guide are rigid; a corner is sharp. The displacement that is recorded is the
corner's way across the guide towards its face from where it is when slider and guide are in line.
"""

from dataclasses import dataclass
from typing import Any

from sympy import Expr, Float, Integer, Symbol, atan2, sqrt

from .coordinates import Coordinates, Freedom, dot
from .structure import Clearance
from .system import number

TINY = Float(1e-200)

AXES = (Integer(1), Integer(0)), (Integer(0), Integer(1))


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
    speeds = _speeds(let, c, columns, driven)
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
        **speeds,
    )


def between(joint: Clearance, c: Coordinates, axis: int) -> Expr:
    """The vector from the bearing's point to the journal's, along an axis."""
    return (
        number(f"r{'xy'[axis]}0_{joint.owner}")
        + sum(number(f"D_{joint.owner}_{k}") * c.longer(k) * c.e(k)[axis] for k in joint.arms)
        + sum(sign * c.position[f, axis] for f, sign in joint.bases)
    )


def _speeds(let, c: Coordinates, columns: list[dict[Freedom, Expr]], driven: str) -> dict[str, Any]:
    """The fields of a `Geometry` that speeds along and across make."""
    v_n, normal = _speed(let, c, columns[0], "N", "vn")
    v_t, tangential = _speed(let, c, columns[1], "T", "vt")
    leads = (
        sum((entry * c.leads[k].get(driven, 0) for k, entry in each.items()), Integer(0)) for each in columns
    )
    return {
        "v_n": v_n,
        "v_t": v_t,
        "normal": normal,
        "tangential": tangential,
        "on_drive": tuple(leads),
        "pushed": columns[0],
        "spun": columns[1],
    }


def _speed(let, c: Coordinates, column: dict[Freedom, Expr], letter: str, word: str):
    """Name the entries of a column and the relative speed that they make; and the row over the unknowns."""
    row, total = [Integer(0)] * len(c.speeds), Integer(0)
    for place, (freedom, entry) in enumerate(column.items()):
        named = let(f"{letter}{place}", entry)
        total += named * c.speed[freedom]
        for i, part in c.parts[freedom]:
            row[i] += part * named
    return let(word, total), tuple(row)


def corner_geometry(joint: Clearance, c: Coordinates, driven: str) -> Geometry:
    """Write a corner's penetration, speeds, and their derivatives by speed."""
    front, side = joint.corner
    defs: list[tuple[Symbol, Expr]] = []

    def let(symbol: str, value: Expr, of: str = joint.name) -> Symbol:
        defs.append((Symbol(f"{symbol}_{of}", real=True), value))
        return defs[-1][0]

    def shared(symbol: str, value: Expr) -> Symbol:
        return let(symbol, value, joint.owner)

    a, b, e = (number(f"{letter}_{joint.owner}") for letter in ("ha", "hb", "e"))
    d = _line(joint, "d", joint.bearing, c, shared)
    l = _line(joint, "j", joint.journal, c, shared)
    n = (-d[1], d[0])
    r = tuple(shared(f"r{word}", between(joint, c, axis)) for axis, word in enumerate("xy"))
    slide, rise = shared("along", dot(d, r)), shared("rise", dot(n, r))
    cos, sin = shared("cos", dot(d, l)), shared("sin", dot(n, l))
    p_x = let("px", front * a * cos - side * b * sin)
    p_y = let("py", front * a * sin + side * b * cos)
    normal = (side * n[0], side * n[1])
    columns = [
        column(joint, c, normal, _corner_spins(joint, side * p_x, -side * (slide + p_x))),
        column(joint, c, d, _corner_spins(joint, -p_y, rise + p_y)),
    ]
    speeds = _speeds(let, c, columns, driven)
    u = let("u", side * (rise + p_y) - b - e)
    spins = _corner_spins(joint, Integer(1), Integer(-1))
    turning = sum((sign * c.speed[k] for k, sign in spins.items()), Integer(0))
    return Geometry(
        definitions=tuple(defs),
        r=((u + e) * normal[0], (u + e) * normal[1]),
        rho=u + e,
        direction=normal,
        across=d,
        angle=atan2(normal[1], normal[0]),
        u=u,
        gap=None,
        wall=-u,
        steep=Integer(1),
        **speeds,
        slide=(slide, speeds["v_t"] + p_y * turning),
    )


def _line(joint: Clearance, word: str, link: str, c: Coordinates, let) -> tuple[Expr, Expr]:
    """Unit vector along the guide, or the slider."""
    cos, sin = (number(f"{word}{letter}_{joint.owner}") for letter in "cs")
    along, across = AXES if link == "ground" else (c.e(link), c.n(link))
    return tuple(let(f"{word}{'xy'[i]}", cos * along[i] + sin * across[i]) for i in (0, 1))


def _corner_spins(joint: Clearance, journal: Expr, bearing: Expr) -> dict[Freedom, Expr]:
    """Contributions of the turning of slider and guide, by their links."""
    pairs = (joint.journal, journal), (joint.bearing, bearing)
    return {link: arm for link, arm in pairs if link != "ground"}
