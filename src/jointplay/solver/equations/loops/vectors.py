"""Vectors of a linkage cut open: sums of arms and slides, r0 + sum_k D_k e_k + sum_s sigma s d.

A link that stretches (equations.stretch) has D_k times its lengthening, whose modes are among the freedoms.
A span is a place, or a place less another: const + sum_k D_k e_k + sum of bases. Source: virtual work,
d.delta r = sum_k D_k n_k.d delta theta_k (and d on bases) for a unit vector d.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from sympy import Expr, Integer

from ..coordinates import Coordinates, Direction, Freedom, dot
from ..structure import Closure, Linkage, Slide, Span
from ..system import number

Vector = tuple[Expr, Expr]
ONE = Integer(1)


def across(v: Vector) -> Vector:
    """The vector turned by a quarter."""
    return -v[1], v[0]


def cross(a: Vector, b: Vector) -> Expr:
    """Third component of the vector product."""
    return dot(across(a), b)


def plus(a: Vector, b: Vector, factor: Expr = ONE) -> Vector:
    """The vector a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1]


ZERO = (Integer(0), Integer(0))


@dataclass(frozen=True)
class Vectors:
    """Sums of arms and slides, r0 + sum_k D_k e_k + sum_s sigma s d, of the joint that `of` names."""

    structure: Linkage
    c: Coordinates
    of: Slide | Closure

    @property
    def slides(self) -> Iterator[tuple[Slide, int]]:
        """Slides in the sum, with signs; of a slide itself, it alone."""
        named = {slide.name: slide for slide in self.structure.slides}
        pairs = ((self.of.name, self.of.sign),) if isinstance(self.of, Slide) else self.of.slides
        return ((named[name], sign) for name, sign in pairs)

    def _arm(self, k: str) -> Vector:
        return scaled(number(f"D_{self.of.name}_{k}") * self.c.longer(k), self.c.e(k))

    def _run(self, slide: Slide, sign: int) -> Vector:
        return scaled(sign * self.c.position[slide.freedom], self.c.e(slide.freedom))

    def value(self, without: tuple[Freedom, ...] = ()) -> Vector:
        """The sum, without the parts that some freedoms turn or shift."""
        r = number(f"rx0_{self.of.name}"), number(f"ry0_{self.of.name}")
        for k in self.of.arms:
            r = plus(r, self._arm(k)) if self.structure.frame(k) not in without else r
        for slide, sign in self.slides:
            r = plus(r, self._run(slide, sign)) if slide.freedom not in without else r
        return r

    def columns(self, frames: bool = True) -> dict[Freedom, Vector]:
        """Derivatives by angles and slides; by the angle of each link alone, or of all that turn with it."""
        found: dict[Freedom, Vector] = {}

        def add(link: str, v: Vector) -> None:
            freedom = self.structure.frame(link) if frames else link
            if freedom != "ground":
                found[freedom] = plus(found.get(freedom, ZERO), across(v))

        for k in self.of.arms:
            add(k, self._arm(k))
            for mode, share in self.c.stretch.get(k, {}).items():
                found[mode] = scaled(number(f"D_{self.of.name}_{k}") * share, self.c.e(k))
        for slide, sign in self.slides:
            add(slide.guide, self._run(slide, sign))
            found[slide.freedom] = scaled(Integer(sign), self.c.e(slide.freedom))
        return found

    def centripetal(self) -> Vector:
        """Second derivative by time where no angle and no slide accelerates: Coriolis terms of slides too."""
        total, speed = ZERO, self.c.speed
        for k in self.of.arms:
            w = speed.get(self.structure.frame(k), Integer(0))
            total = plus(total, self._arm(k), -(w**2))
            longer = number(f"D_{self.of.name}_{k}") * self.c.longer_rate(k)
            total = plus(total, self.c.n(k), 2 * w * longer)
        for slide, sign in self.slides:
            w = speed.get(self.structure.frame(slide.link), Integer(0))
            total = plus(total, self._run(slide, sign), -(w**2))
            total = plus(total, self.c.n(slide.freedom), 2 * sign * w * speed[slide.freedom])
        return total


def scaled(factor: Expr, v: Vector) -> Vector:
    """A multiple of a vector."""
    return factor * v[0], factor * v[1]


def turn(slide: Slide, c: Coordinates) -> None:
    """Directions of a link on a guide, and of the guide."""
    d = number(f"dc_{slide.name}"), number(f"ds_{slide.name}")
    if slide.guide == "ground":
        c.angle[slide.link] = Direction(number(f"s_{slide.link}"), number(f"c_{slide.link}"))
        c.angle[slide.freedom] = Direction(d[1], d[0])
        return
    by = number(f"turn_c_{slide.link}"), number(f"turn_s_{slide.link}")
    for who, name, (cos, sin) in ((slide.link, slide.link, by), (slide.freedom, f"guide_{slide.name}", d)):
        x, y = c.e(slide.guide)
        s, r = c.let(f"s_{name}", y * cos + x * sin), c.let(f"c_{name}", x * cos - y * sin)
        c.angle[who] = Direction(s, r)


def vector(span: Span, c: Coordinates) -> Vector:
    """The vector of a span."""
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
