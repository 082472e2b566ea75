"""Larger groups of loops: links that close together and not two at a time (Assur's class III and up).

Equations: m closures r_j = 0 (equations.loops.loop) for 2 m unknowns phi, angles and slides. No closed form
is worth writing. Each unknown has a memory instead, near which it is: cosine C and sine S of an angle, or a
slide. From there Newton's method,

    phi <- phi - J^-1 r(phi),    J at the memory,    cos, sin <- (cos - sin d, sin + cos d)/sqrt(1 + d^2),

takes `STEPS` steps, so that the closure is exact to rounding, since memories are as exact as the integration.
They only choose the branch: nothing else depends on them (`system.Root`), and they follow what they led to,

    C' = -sin phi phi' + kappa (cos phi - C),    kappa (`settling`) five times the nominal speed,

so that errors of the integration do not pile up. J^-1 is by cofactors, which needs no pivots: it is singular
where the mechanism is, not in between. What does not close is no number.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

from sympy import Expr, Float, Integer, Symbol, sqrt

from ..coordinates import Coordinates, Direction, Freedom, dot, guess
from ..structure import Closure, Linkage
from ..system import Root, number
from .vectors import ZERO, Vector, Vectors, turn

STEPS = 3
OPEN = Float(1e-3)  # of the arms: more than this is left open before the last step where nothing closes
NOTHING = Float(1e-300)  # of a number too small to matter, unless it is none

Places = Mapping[Freedom, tuple[Expr, ...]]
Matrix = tuple[tuple[Expr, ...], ...]


def position(structure: Linkage, closures: tuple[Closure, ...], c: Coordinates) -> None:
    """Add the angles and slides that close loops together."""
    name, unknowns = closures[0].name, closures[0].unknowns
    places = {u: _unit(u, guess(u), c) for u in unknowns}
    inverse: Matrix = ()
    for step in range(STEPS):
        here = _at(structure, places, c, f"_{step}_{name}")
        vectors = [Vectors(structure, here, closure) for closure in closures]
        gaps = _gaps(vectors, here)
        inverse = inverse or _inverse(_jacobian(vectors, here), here)
        steps = [_less(row, gaps) for row in inverse]
        if step == STEPS - 1:
            arms = [number(f"D_{each.name}_{k}") for each in closures for k in each.arms]
            closes = sqrt(OPEN**2 * sum(arm**2 for arm in arms) - sum(gap**2 for gap in gaps))
            steps = [each + NOTHING * closes for each in steps]
        steps = [here.let(f"step_{_word(u)}", each) for u, each in zip(unknowns, steps, strict=True)]
        places = {u: _moved(u, places[u], d, here) for u, d in zip(unknowns, steps, strict=True)}
    symbols, held, values = {}, {}, []
    for i, (u, place) in enumerate(places.items()):
        if isinstance(u, str):
            cos, sin = (c.let(f"{letter}_{u}", value) for letter, value in zip("cs", place, strict=True))
            c.angle[u], values = Direction(sin, cos), [*values, cos, sin]
            symbols |= {sin: (i, cos), cos: (i, -sin)}
        else:
            c.position[u] = c.let(f"slide_{u[1]}", *place)
            symbols[c.position[u]], values = (i, Integer(1)), [*values, c.position[u]]
        held[u] = tuple(Symbol(f"held_{symbol}", real=True) for symbol in values[-len(place) :])
    stand_ins = tuple(symbol for place in held.values() for symbol in place)
    c.definitions.extend(zip(stand_ins, values, strict=True))
    here = _at(structure, held, c, f"_held_{name}")
    gaps = _gaps([Vectors(structure, here, closure) for closure in closures], here)
    here = _at(structure, {u: values_of(u, c) for u in unknowns}, c, f"_{name}")
    vectors = [Vectors(structure, here, closure) for closure in closures]
    c.inverse[unknowns] = _inverse(_jacobian(vectors, here), here)
    c.roots.append(Root(symbols, tuple(gaps), c.inverse[unknowns], stand_ins))


def values_of(u: Freedom, c: Coordinates) -> tuple[Expr, ...]:
    """Cosine and sine of an angle, or a slide."""
    return c.e(u) if isinstance(u, str) else (c.position[u],)


def remember(closures: tuple[Closure, ...], c: Coordinates) -> None:
    """Add the rates of a group's memories; a dyad has none."""
    for u in closures[0].unknowns if len(closures) > 1 else ():
        values, w = values_of(u, c), c.speed[u]
        rates = (-values[1] * w, values[0] * w) if isinstance(u, str) else (w,)
        for symbol, value, rate in zip(guess(u), values, rates, strict=True):
            c.imposed[c.speeds.index(symbol)] = rate + number("settling") * (value - symbol)


class Inverse:
    """Solves J phi = b for the unknowns of closures, b a vector of each."""

    def __init__(self, loop: list[Vectors], c: Coordinates) -> None:
        unknowns, columns = loop[0].of.unknowns, [r.columns() for r in loop]
        self.rows = c.inverse[unknowns]
        far = Integer(0)  # 1 / (|row| |column|) is the sine of a column's angle to all others
        for u, row in zip(unknowns, self.rows, strict=True):
            column = sum((dot(v, v) for v in (each.get(u, ZERO) for each in columns)), Integer(0))
            far += sum((entry**2 for entry in row), Integer(0)) * column
        c.folds.append(1 / far)

    def less(self, b: list[Vector]) -> list[Expr]:
        """The unknowns for -b."""
        return [_less(row, [value for vector in b for value in vector]) for row in self.rows]


def forces(loop: list[Vectors], needed: Mapping[Freedom, Expr]) -> list[Vector]:
    """Forces on the bearings of cut joints: J^T F = -R."""
    inverse, unknowns = loop[0].c.inverse[loop[0].of.unknowns], loop[0].of.unknowns
    R = [needed[u] for u in unknowns]
    values = [_less(column, R) for column in zip(*inverse, strict=True)]
    return [(values[2 * j], values[2 * j + 1]) for j in range(len(loop))]


def _word(u: Freedom) -> str:
    return u if isinstance(u, str) else f"slide_{u[1]}"


def _less(row: tuple[Expr, ...], b: list[Expr]) -> Expr:
    return -sum((entry * value for entry, value in zip(row, b, strict=True)), Integer(0))


def _unit(u: Freedom, place: tuple[Expr, ...], c: Coordinates) -> tuple[Expr, ...]:
    if not isinstance(u, str):
        return place
    size = c.let(f"size_{u}", sqrt(place[0] ** 2 + place[1] ** 2))
    return place[0] / size, place[1] / size


def _moved(u: Freedom, place: tuple[Expr, ...], d: Expr, c: Coordinates) -> tuple[Expr, ...]:
    """The angle's cosine and sine turned by atan d, or the slide shifted."""
    if not isinstance(u, str):
        return (place[0] + d,)
    cos, sin = place
    size = c.let(f"size_{u}", sqrt(1 + d**2))
    return (cos - sin * d) / size, (sin + cos * d) / size


def _at(structure: Linkage, places: Places, c: Coordinates, mark: str) -> Coordinates:
    """The coordinates with unknowns at given places."""
    here = replace(c, angle={**c.angle}, position={**c.position}, mark=mark)
    for u, place in places.items():
        named = [here.let(f"{'cs'[i]}_{_word(u)}", value) for i, value in enumerate(place)]
        if isinstance(u, str):
            here.angle[u] = Direction(*reversed(named))
        else:
            (here.position[u],) = named
    for slide in structure.slides:
        if slide.link not in here.angle and slide.guide in here.angle:
            turn(slide, here)
    return here


def _gaps(vectors: list[Vectors], c: Coordinates) -> list[Expr]:
    """Both components of every closure's vector."""
    return [c.let(f"gap_{x}_{r.of.name}", g) for r in vectors for x, g in zip("xy", r.value(), strict=True)]


def _jacobian(vectors: list[Vectors], c: Coordinates) -> list[list[Expr]]:
    """Their derivatives by the unknowns."""
    rows = []
    for r in vectors:
        columns = r.columns()
        for axis, x in enumerate("xy"):
            entries = ((u, columns.get(u, ZERO)[axis]) for u in r.of.unknowns)
            rows.append([c.let(f"J{x}_{r.of.name}_{_word(u)}", entry) for u, entry in entries])
    return rows


def _inverse(J: list[list[Expr]], c: Coordinates) -> Matrix:
    """Adjugate over determinant."""
    whole = tuple(range(len(J)))

    @cache
    def minor(rows: tuple[int, ...], columns: tuple[int, ...]) -> Expr:
        if not rows:
            return Integer(1)
        total = Integer(0)
        for k, column in enumerate(columns):
            rest = columns[:k] + columns[k + 1 :]
            total += (-1) ** k * J[rows[0]][column] * minor(rows[1:], rest)
        return c.let("_".join(["minor", *map(str, rows), "of", *map(str, columns)]), total)

    def without(i: int) -> tuple[int, ...]:
        return whole[:i] + whole[i + 1 :]

    det = minor(whole, whole)
    return tuple(
        tuple(c.let(f"I_{i}_{j}", (-1) ** (i + j) * minor(without(j), without(i)) / det) for j in whole)
        for i in whole
    )
