"""Ideal loops and slides: what follows from the free coordinates, group by group.

Reference: a loop cut at a revolute joint closes if the vector from bearing to journal vanishes,

    r = r0 + sum_k D_k e_k + sum_s sigma s d = 0             (links k, slides s along guides d).

Two scalar equations, two unknowns: a dyad (Assur group of class II). With F what the known part lacks,

    two angles             D_1 e_1 + D_2 e_2 = F       two circles,
    angle, fixed guide     D_1 e_1 + sigma s d = F     a circle and a line,
    angle, own guide       (rho + i p) d = F           rho = along + sigma s, p constant: it turns with 1,
    two slides             sigma_1 s_1 d_1 + sigma_2 s_2 d_2 = F,

each with at most one square root, whose sign (`side`) is the branch. Speeds and accelerations of the two
unknowns u, v solve J_u u' + J_v v' = -J_known z and the same with centripetal terms, by Cramer's rule. The
force on the bearing of the cut joint closes their equations, J_u.F = -R_u, J_v.F = -R_v, R what these lack.

A link on a guide has the guide's angle but for a constant; its chain's base is the same kind of sum.
Singular where J_u and J_v are parallel, a dead centre. Deflections do not move the joints; a link that
stretches (equations.stretch) has D_k times its lengthening, whose modes are among the known freedoms.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sympy import Expr, Integer, sqrt

from .coordinates import Coordinates, Direction, Freedom, dot
from .structure import Closure, Linkage, Slide
from .system import number

Vector = tuple[Expr, Expr]
ONE = Integer(1)


def across(v: Vector) -> Vector:
    """The vector turned by a quarter."""
    return -v[1], v[0]


def cross(a: Vector, b: Vector) -> Expr:
    """Third component of the vector product."""
    return dot(across(a), b)


def _plus(a: Vector, b: Vector, factor: Expr = ONE) -> Vector:
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
        """The sum, without what some freedoms turn or shift."""
        r = number(f"rx0_{self.of.name}"), number(f"ry0_{self.of.name}")
        for k in self.of.arms:
            r = _plus(r, self._arm(k)) if self.structure.frame(k) not in without else r
        for slide, sign in self.slides:
            r = _plus(r, self._run(slide, sign)) if slide.freedom not in without else r
        return r

    def columns(self, frames: bool = True) -> dict[Freedom, Vector]:
        """Derivatives by angles and slides; by the angle of each link alone, or of all that turn with it."""
        found: dict[Freedom, Vector] = {}

        def add(link: str, v: Vector) -> None:
            freedom = self.structure.frame(link) if frames else link
            if freedom != "ground":
                found[freedom] = _plus(found.get(freedom, ZERO), across(v))

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
            total = _plus(total, self._arm(k), -(w**2))
            longer = number(f"D_{self.of.name}_{k}") * self.c.longer_rate(k)
            total = _plus(total, self.c.n(k), 2 * w * longer)
        for slide, sign in self.slides:
            w = speed.get(self.structure.frame(slide.link), Integer(0))
            total = _plus(total, self._run(slide, sign), -(w**2))
            total = _plus(total, self.c.n(slide.freedom), 2 * sign * w * speed[slide.freedom])
        return total


def scaled(factor: Expr, v: Vector) -> Vector:
    """A multiple of a vector."""
    return factor * v[0], factor * v[1]


def complete(structure: Linkage, c: Coordinates) -> None:
    """Add all that follows: links on guides, bases of their chains, and the two unknowns of each closure."""
    _settle(structure, c)
    for closure in structure.closures:
        _position(structure, closure, c)
        _settle(structure, c)
        _motion(Vectors(structure, c, closure), c)
        _settle(structure, c)


def _settle(structure: Linkage, c: Coordinates) -> None:
    """Add directions, speeds and bases of links on guides, as far as their guides are known."""
    for slide in structure.slides:
        fixed, frame = slide.guide == "ground", structure.frame(slide.link)
        if slide.link not in c.angle and (fixed or slide.guide in c.angle):
            _turn(slide, c)
        if slide.link not in c.speed and (frame == "ground" or frame in c.speed):
            c.follow(slide.link, {} if frame == "ground" else {frame: Integer(1)}, Integer(0))
        ready = {slide.link, slide.freedom, *slide.arms} | ({(slide.inner, 0)} - {(None, 0)})
        if (slide.chain, 0) not in c.speed and ready <= c.speed.keys():
            _base(Vectors(structure, c, slide), c)


def _turn(slide: Slide, c: Coordinates) -> None:
    """Directions of a link on a guide, and of the guide."""
    d = number(f"dc_{slide.name}"), number(f"ds_{slide.name}")
    if slide.guide == "ground":
        c.angle[slide.link] = Direction(number(f"s_{slide.link}"), number(f"c_{slide.link}"))
        c.angle[slide.freedom] = Direction(d[1], d[0])
        return
    turn = number(f"turn_c_{slide.link}"), number(f"turn_s_{slide.link}")
    for who, name, (cos, sin) in ((slide.link, slide.link, turn), (slide.freedom, f"guide_{slide.name}", d)):
        x, y = c.e(slide.guide)
        s, r = c.let(f"s_{name}", y * cos + x * sin), c.let(f"c_{name}", x * cos - y * sin)
        c.angle[who] = Direction(s, r)


def _base(r: Vectors, c: Coordinates) -> None:
    """Position and motion of the base of a sliding link's chain."""
    slide, columns, value, bend = r.of, r.columns(), r.value(), r.centripetal()
    for axis, x in enumerate("xy"):
        below = (slide.inner, axis)
        started = c.position[below] if slide.inner is not None else Integer(0)
        base = (slide.chain, axis)
        c.position[base] = c.let(f"{x}_{slide.chain}", started + value[axis])
        ratios = {k: c.let(f"{x}_{slide.chain}_{_word(k)}", column[axis]) for k, column in columns.items()}
        ratios |= {below: Integer(1)} if slide.inner is not None else {}
        c.follow(base, ratios, c.let(f"gamma_{x}_{slide.chain}", bend[axis]))


def _word(freedom: Freedom) -> str:
    return (
        freedom if isinstance(freedom, str) else "_".join(str(part) for part in freedom if part is not None)
    )


def _motion(r: Vectors, c: Coordinates) -> None:
    """Speeds and accelerations of a closure's unknowns."""
    (u, v), columns = r.of.unknowns, r.columns()
    J_u, J_v = columns.pop(u), columns.pop(v)
    det = c.let(f"fold_{r.of.name}", cross(J_u, J_v))
    c.folds.append(det**2 / (dot(J_u, J_u) * dot(J_v, J_v)))
    led: dict[Freedom, Vector] = {}
    rest = ZERO
    for k, column in columns.items():
        rest = _plus(rest, column, c.own[k])
        for leader, lead in c.leads[k].items():
            led[leader] = _plus(led.get(leader, ZERO), column, lead)
    ratios: dict[Freedom, dict[Freedom, Expr]] = {u: {}, v: {}}
    for leader, column in led.items():
        ratios[u][leader] = c.let(f"G_{_word(u)}_{_word(leader)}", -cross(column, J_v) / det)
        ratios[v][leader] = c.let(f"G_{_word(v)}_{_word(leader)}", -cross(J_u, column) / det)
    for k in (u, v):
        c.speed[k] = sum((ratio * c.speed[leader] for leader, ratio in ratios[k].items()), Integer(0))
    bend = _plus(rest, r.centripetal())
    for k, value in ((u, -cross(bend, J_v) / det), (v, -cross(J_u, bend) / det)):
        c.follow(k, ratios[k], c.let(f"gamma_{_word(k)}", value), closes=True)


def closing_force(r: Vectors, needed: dict[Freedom, Expr]) -> Vector:
    """Force on the bearing of the cut joint, by what the two unknowns' equations need."""
    columns = r.columns()
    u, v = r.of.unknowns
    x, y = across(_plus(scaled(needed[u], columns[v]), columns[u], -needed[v]))
    det = cross(columns[u], columns[v])
    return x / det, y / det


def moment(
    structure: Linkage,
    slide: Slide,
    c: Coordinates,
    needed: Callable[[Freedom], Expr],
    closing: list[tuple[Vectors, Vector]],
) -> Expr:
    """Moment that a guide must give to its link, about the base: what turning it with all it carries needs.

    `needed` is what joints must supply on each freedom, `closing` are the closures with their forces.
    """
    turned = [k for k in structure.links if structure.turns_with(k, slide.link)]

    def moved(r: Vectors) -> Vector:
        columns, total = r.columns(frames=False), ZERO
        for k in turned:
            total = _plus(total, columns.get(k, ZERO))
        return total

    total, bases = sum((needed(k) for k in turned), Integer(0)), {}
    for each in structure.slides:
        bases[each.chain] = _plus(bases.get(each.inner, ZERO), moved(Vectors(structure, c, each)))
    for chain, column in bases.items():
        total += dot(column, (needed((chain, 0)), needed((chain, 1)))) if column != ZERO else 0
    return total + sum((dot(moved(r), F) for r, F in closing), Integer(0))


def _position(structure: Linkage, closure: Closure, c: Coordinates) -> None:
    """Angles and slides that close a loop."""
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
    _point(c, k, _plus(scaled(along, d), n, height), number(f"D_{name}_{k}") * c.longer(k))


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
