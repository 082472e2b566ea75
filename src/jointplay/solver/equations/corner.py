"""Geometry of a slider's corner in a guide with play.

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

from sympy import Expr, Integer, Symbol, atan2

from . import contact
from .contact import Geometry
from .coordinates import Coordinates, Freedom, dot
from .structure import Clearance
from .system import number

AXES = (Integer(1), Integer(0)), (Integer(0), Integer(1))


def geometry(joint: Clearance, c: Coordinates, driven: str) -> Geometry:
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
    r = tuple(shared(f"r{word}", contact.between(joint, c, axis)) for axis, word in enumerate("xy"))
    slide, rise = shared("along", dot(d, r)), shared("rise", dot(n, r))
    cos, sin = shared("cos", dot(d, l)), shared("sin", dot(n, l))
    p_x = let("px", front * a * cos - side * b * sin)
    p_y = let("py", front * a * sin + side * b * cos)
    normal = (side * n[0], side * n[1])
    columns = [
        contact.column(joint, c, normal, _spins(joint, side * p_x, -side * (slide + p_x))),
        contact.column(joint, c, d, _spins(joint, -p_y, rise + p_y)),
    ]
    v_n, rows_n = contact.speed(let, c, columns[0], "N", "vn")
    v_t, rows_t = contact.speed(let, c, columns[1], "T", "vt")
    u = let("u", side * (rise + p_y) - b - e)
    spins = _spins(joint, Integer(1), Integer(-1))
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
        v_n=v_n,
        v_t=v_t,
        normal=rows_n,
        tangential=rows_t,
        on_drive=contact.on_drive(columns, c, driven),
        pushed=columns[0],
        spun=columns[1],
        slide=(slide, v_t + p_y * turning),
    )


def _line(joint: Clearance, word: str, link: str, c: Coordinates, let) -> tuple[Expr, Expr]:
    """Unit vector along the guide, or the slider."""
    cos, sin = (number(f"{word}{letter}_{joint.owner}") for letter in "cs")
    along, across = AXES if link == "ground" else (c.e(link), c.n(link))
    return tuple(let(f"{word}{'xy'[i]}", cos * along[i] + sin * across[i]) for i in (0, 1))


def _spins(joint: Clearance, journal: Expr, bearing: Expr) -> dict[Freedom, Expr]:
    """Contributions of the turning of slider and guide, by their links."""
    pairs = (joint.journal, journal), (joint.bearing, bearing)
    return {link: arm for link, arm in pairs if link != "ground"}
