"""Dyads: two links at a time that close a loop, in closed form (Assur groups of class II).

With F what the known part of the closure's vector lacks,

    two angles             D_1 e_1 + D_2 e_2 = F       two circles,
    angle, fixed guide     D_1 e_1 + sigma s d = F     a circle and a line,
    angle, own guide       (rho + i p) d = F           rho = along + sigma s, p constant: it turns with 1,
    two slides             sigma_1 s_1 d_1 + sigma_2 s_2 d_2 = F,

each with at most one square root, whose sign (`side`) is the branch. What is linear in the two unknowns u, v
follows by Cramer's rule from J_u and J_v; where these are parallel is a dead centre.
"""

from collections.abc import Mapping

from sympy import Expr, sqrt

from ..coordinates import Coordinates, Direction, Freedom, dot
from ..structure import Closure, Linkage, Slide
from ..system import number
from .vectors import Vector, Vectors, across, cross, plus, scaled


def position(structure: Linkage, closure: Closure, c: Coordinates) -> None:
    """Add the angles and slides that close a loop."""
    known = Vectors(structure, c, closure).value(without=closure.unknowns)
    F = tuple(c.let(f"far_{x}_{closure.name}", -value) for x, value in zip("xy", known, strict=True))
    angles = [u for u in closure.unknowns if isinstance(u, str)]
    slides = {s.freedom: (s, sign) for s, sign in Vectors(structure, c, closure).slides}
    moved = [slides[u] for u in closure.unknowns if u in slides]
    if len(angles) == 2:
        _two_circles(closure, F, angles, c)
    elif not angles:
        _two_lines(moved, F, c)
    elif structure.frame(moved[0][0].link) == angles[0]:
        _own_guide(closure, F, angles[0], *moved[0], c)
    else:
        _circle_and_line(closure, F, angles[0], *moved[0], c)


def _point(c: Coordinates, k: str, v: Vector, length: Expr) -> None:
    c.angle[k] = Direction(c.let(f"s_{k}", v[1] / length), c.let(f"c_{k}", v[0] / length))


def _two_circles(closure: Closure, F: Vector, angles: list[str], c: Coordinates) -> None:
    name, (x, y) = closure.name, F
    one, two = (
        number(f"{word}_{name}") * c.longer(k) for word, k in zip(("one", "two"), angles, strict=True)
    )
    side = number(f"side_{name}")
    gap2 = c.let(f"gap2_{name}", x**2 + y**2)
    gap = c.let(f"gap_{name}", sqrt(gap2))
    along = c.let(f"along_{name}", (gap2 + (one - two) * (one + two)) / (2 * gap))
    # Heron's product keeps digits where the triangle is nearly flat
    heron = (one + two - gap) * (gap - one + two) * (gap + one - two) * (gap + one + two)
    height = c.let(f"across_{name}", side * sqrt(heron) / (2 * gap))
    bx = c.let(f"reach_x_{name}", (along * x - height * y) / gap)
    by = c.let(f"reach_y_{name}", (along * y + height * x) / gap)
    for k, v in zip(angles, ((bx, by), (x - bx, y - by)), strict=True):
        _point(c, k, v, number(f"D_{name}_{k}") * c.longer(k))


def _circle_and_line(closure: Closure, F: Vector, k: str, slide: Slide, sign: int, c: Coordinates) -> None:
    name, d, n = closure.name, c.e(slide.freedom), c.n(slide.freedom)
    one, side = number(f"one_{name}") * c.longer(k), number(f"side_{name}")
    height = c.let(f"across_{name}", dot(F, n))
    along = c.let(f"along_{name}", side * sqrt((one - height) * (one + height)))
    c.position[slide.freedom] = c.let(f"slide_{slide.name}", sign * (dot(F, d) - along))
    _point(c, k, plus(scaled(along, d), n, height), number(f"D_{name}_{k}") * c.longer(k))


def _own_guide(closure: Closure, F: Vector, k: str, slide: Slide, sign: int, c: Coordinates) -> None:
    name, (x, y) = closure.name, F
    along, p, side = (number(f"{word}_{name}") for word in ("one", "two", "side"))
    cos, sin = number(f"dc_{slide.name}"), number(f"ds_{slide.name}")
    gap2 = c.let(f"gap2_{name}", x**2 + y**2)
    gap = c.let(f"gap_{name}", sqrt(gap2))
    rho = c.let(f"along_{name}", side * sqrt((gap - p) * (gap + p)))
    c.position[slide.freedom] = c.let(f"slide_{slide.name}", sign * (rho - along))
    dx, dy = x * rho + y * p, y * rho - x * p
    _point(c, k, (dx * cos + dy * sin, dy * cos - dx * sin), gap2)


def _two_lines(moved: list[tuple[Slide, int]], F: Vector, c: Coordinates) -> None:
    d, e = (c.e(slide.freedom) for slide, _ in moved)
    det = cross(d, e)
    for (slide, sign), value in zip(moved, (cross(F, e), cross(d, F)), strict=True):
        c.position[slide.freedom] = c.let(f"slide_{slide.name}", sign * value / det)


class Cramer:
    """Solves J_u u + J_v v = b for the two unknowns of a closure."""

    def __init__(self, r: Vectors, c: Coordinates) -> None:
        (u, v), columns = r.of.unknowns, r.columns()
        self.J_u, self.J_v = columns[u], columns[v]
        self.det = c.let(f"fold_{r.of.name}", cross(self.J_u, self.J_v))
        c.folds.append(self.det**2 / (dot(self.J_u, self.J_u) * dot(self.J_v, self.J_v)))

    def less(self, b: list[Vector]) -> tuple[Expr, Expr]:
        """The unknowns for -b."""
        (column,) = b
        return -cross(column, self.J_v) / self.det, -cross(self.J_u, column) / self.det


def force(r: Vectors, needed: Mapping[Freedom, Expr]) -> Vector:
    """Force on the bearing of the cut joint, by the needs of the two unknowns' equations."""
    columns = r.columns()
    u, v = r.of.unknowns
    x, y = across(plus(scaled(needed[u], columns[v]), columns[u], -needed[v]))
    det = cross(columns[u], columns[v])
    return x / det, y / det
