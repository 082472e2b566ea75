"""Vectors of a linkage, const + sum_k D_k e_k + sum of bases: a place, or a place less another.

Source: virtual work, d.delta r = sum_k D_k n_k.d delta theta_k (and d on bases) for a unit vector d.
"""

from sympy import Expr, Integer

from ..coordinates import Coordinates, Freedom, dot
from ..structure import Span
from ..system import number

Vector = tuple[Expr, Expr]


def vector(span: Span, c: Coordinates) -> Vector:
    """The vector itself."""
    x, y = number(f"x0_{span.name}"), number(f"y0_{span.name}")
    for k in span.arms:
        D, e = number(f"D_{span.name}_{k}"), c.e(k)
        x, y = x + D * e[0], y + D * e[1]
    for f, sign in span.bases:
        x, y = x + sign * c.position[f, 0], y + sign * c.position[f, 1]
    return x, y


def column(span: Span, c: Coordinates, along: Vector) -> dict[Freedom, Expr]:
    """Derivatives of along.r' with respect to the speed of every freedom."""
    found: dict[Freedom, Expr] = {k: number(f"D_{span.name}_{k}") * dot(c.n(k), along) for k in span.arms}
    return found | {(f, axis): sign * along[axis] for f, sign in span.bases for axis in (0, 1)}


def rate(entries: dict[Freedom, Expr], c: Coordinates) -> Expr:
    """The speed that a column makes with the freedoms' speeds."""
    return sum((entry * c.speed[freedom] for freedom, entry in entries.items()), Integer(0))
