"""Loads: forces at points of links and torques on links, that vary with time or with an angle.

    f = f_0 + sum_n (a_n cos n phi + b_n sin n phi),    phi = nu t, or a link's angle,

on a force's point P along a unit vector d, fixed or turning with the link: Q_z = f d.dP/dz, power f d.P'; on
a link's angle: Q = f, power f w. Sines of multiples follow from sin phi and cos phi by addition. Source:
virtual work.
"""

from collections.abc import Iterator

from sympy import Expr, Integer

from .coordinates import Coordinates
from .loops import vectors
from .springs import Action
from .structure import Course, Load
from .system import Angle, number


def phase(course: Course) -> Angle:
    """The phase nu t of a course over time."""
    return Angle(f"phase_{course.name}", None, number(f"nu_{course.name}"))


def value(course: Course, c: Coordinates) -> Expr:
    """The value of a course: its mean and its harmonics."""
    total = number(f"mean_{course.name}")
    if not course.orders:
        return total
    for _, a, b, cos, sin in _harmonics(course, c):
        total += a * cos + b * sin
    return c.let(f"f_{course.name}", total)


def derivatives(course: Course, c: Coordinates, most: int) -> list[Expr]:
    """A course over time, and its derivatives by the time up to so many."""
    nu, found = number(f"nu_{course.name}"), [number(f"mean_{course.name}"), *[Integer(0)] * most]
    for n, a, b, cos, sin in _harmonics(course, c) if course.orders else ():
        for k in range(most + 1):
            found[k] += a * cos + b * sin
            a, b = n * nu * b, -n * nu * a
    return found


def _harmonics(course: Course, c: Coordinates) -> Iterator[tuple[int, Expr, Expr, Expr, Expr]]:
    """Order, amplitudes, cosine and sine of each harmonic."""
    name, angle = course.name, phase(course) if course.timed else c.angle[course.link]
    cos, sin = angle.cos, angle.sin
    for n in range(1, max(course.orders) + 1):
        if n in course.orders:
            yield n, number(f"a_{name}_{n}"), number(f"b_{name}_{n}"), cos, sin
        cos, sin = cos * angle.cos - sin * angle.sin, sin * angle.cos + cos * angle.sin
        cos, sin = c.let(f"cos_{name}_{n + 1}", cos), c.let(f"sin_{name}_{n + 1}", sin)


def action(load: Load, c: Coordinates) -> Action:
    """Action of a load."""
    name, f = load.course.name, value(load.course, c)
    if load.span is None:
        return Action(f, {load.link: Integer(1)}, power=f * c.speed[load.link])
    x, y = number(f"dx_{name}"), number(f"dy_{name}")
    if load.turning:
        e, n = c.e(load.link), c.n(load.link)
        x, y = x * e[0] + y * n[0], x * e[1] + y * n[1]
    column = vectors.column(load.span, c, (x, y))
    return Action(f, column, ((load.link, (f * x, f * y)),), power=f * vectors.rate(column, c))
