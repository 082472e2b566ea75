"""Freedoms of a linkage: which speeds there are, which of them are unknown, and how the others follow.

A freedom is the angle of a link (its name), a coordinate of a floating chain's base (chain, axis), or an
elastic mode (link, number). Its speed and acceleration are combinations of the unknown ones,

    z = sum_i P_i z_i,     a = sum_i P_i a_i + bias,

with P = 1 for an unknown, none for a prescribed motion, and the transmission functions of the loop where a
closed four-bar leaves the crank alone free. So one set of tables serves every case: mass matrix and forces
are written over all freedoms and projected here.
"""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field

from sympy import Expr, Integer, Symbol, atan2

from .drives import DRIVES
from .structure import Linkage
from .system import TIME, Angle, accelerations, number

Freedom = Hashable


@dataclass(frozen=True)
class Direction:
    """Sine and cosine of an angle that follows from others."""

    sin: Symbol
    cos: Symbol

    @property
    def value(self) -> Expr:
        return atan2(self.sin, self.cos)


@dataclass(frozen=True)
class Coordinates:
    """Symbols of a linkage's motion, by freedom; `positions` and `speeds` are the unknown ones, in order.

    `imposed` are accelerations of unknowns that no force changes, by their places.
    """

    angle: dict[str, Angle | Direction] = field(default_factory=dict)
    position: dict[Freedom, Symbol] = field(default_factory=dict)
    speed: dict[Freedom, Expr] = field(default_factory=dict)
    acceleration: dict[Freedom, Expr] = field(default_factory=dict)
    parts: dict[Freedom, tuple[tuple[int, Expr], ...]] = field(default_factory=dict)
    bias: dict[Freedom, Expr] = field(default_factory=dict)
    positions: list[Symbol] = field(default_factory=list)
    speeds: list[Symbol] = field(default_factory=list)
    definitions: list[tuple[Symbol, Expr]] = field(default_factory=list)
    imposed: dict[int, Expr] = field(default_factory=dict)

    def e(self, k: str) -> tuple[Expr, Expr]:
        """Unit vector along link k."""
        return self.angle[k].cos, self.angle[k].sin

    def n(self, k: str) -> tuple[Expr, Expr]:
        """Unit vector across link k."""
        return -self.angle[k].sin, self.angle[k].cos

    def cos(self, k: str, m: str) -> Expr:
        """cos(theta_k - theta_m)."""
        return dot(self.e(k), self.e(m)) if k != m else Integer(1)

    def sin(self, k: str, m: str) -> Expr:
        """sin(theta_k - theta_m)."""
        return dot(self.e(k), self.n(m)) if k != m else Integer(0)

    def free(self, freedom: Freedom, position: Symbol, speed: Symbol) -> None:
        """Add an unknown."""
        place = len(self.speeds)
        self.position[freedom], self.speed[freedom] = position, speed
        self.acceleration[freedom] = accelerations(place + 1)[place]
        self.parts[freedom], self.bias[freedom] = ((place, Integer(1)),), Integer(0)
        self.positions.append(position)
        self.speeds.append(speed)

    def given(self, freedom: Freedom, speed: Expr, acceleration: Expr) -> None:
        """Add a freedom whose motion is prescribed."""
        self.speed[freedom], self.acceleration[freedom] = speed, acceleration
        self.parts[freedom], self.bias[freedom] = (), acceleration

    def impose(self, freedom: Freedom, acceleration: Expr) -> None:
        """Make an unknown that was added last one whose acceleration is prescribed."""
        self.imposed[len(self.speeds) - 1] = self.let(f"imposed_{freedom}", acceleration)
        self.given(freedom, self.speed[freedom], self.imposed[len(self.speeds) - 1])

    def follow(self, freedom: Freedom, leader: Freedom, ratio: Expr, bias: Expr) -> None:
        """Add a freedom with the speed `ratio` times the leader's, and `bias` beside that in acceleration."""
        self.speed[freedom] = ratio * self.speed[leader]
        self.acceleration[freedom] = ratio * self.acceleration[leader] + bias
        self.parts[freedom] = tuple((i, ratio * part) for i, part in self.parts[leader])
        self.bias[freedom] = ratio * self.bias[leader] + bias

    def let(self, name: str, value: Expr) -> Symbol:
        """Name a value that is computed before all else."""
        self.definitions.append((Symbol(name, real=True), value))
        return self.definitions[-1][0]

    def mass(self, entries: dict[tuple[Freedom, Freedom], Expr]) -> dict[tuple[int, int], Expr]:
        """Lower triangle of the mass matrix over the unknowns, from one over all freedoms (pairs once)."""
        found: dict[tuple[int, int], Expr] = {}
        for (k, m), entry in entries.items():
            for i, part in self.parts[k]:
                for j, other in self.parts[m]:
                    twice = 2 if k != m and i == j else 1
                    place = (max(i, j), min(i, j))
                    found[place] = found.get(place, Integer(0)) + twice * part * other * entry
        return found

    def kinetic_energy(self, entries: Iterable[tuple[Freedom, Freedom, Expr]]) -> Expr:
        """Half the quadratic form in the speeds that entries of the mass matrix make."""
        return sum(
            (entry * self.speed[k] * self.speed[m] / (2 if k == m else 1) for k, m, entry in entries),
            Integer(0),
        )

    def force(
        self, forces: dict[Freedom, Expr], entries: dict[tuple[Freedom, Freedom], Expr]
    ) -> tuple[Expr, ...]:
        """Forces on the unknowns, from those on all freedoms less the inertia of prescribed accelerations."""
        total = dict(forces)
        for (k, m), entry in entries.items():
            for one, other in {(k, m), (m, k)}:
                total[one] = total.get(one, Integer(0)) - entry * self.bias[other]
        found = [Integer(0)] * len(self.speeds)
        for freedom, force in total.items():
            for i, part in self.parts[freedom]:
                found[i] += part * force
        return tuple(found)


def dot(a: tuple[Expr, Expr], b: tuple[Expr, Expr]) -> Expr:
    """Scalar product of two plane vectors."""
    return a[0] * b[0] + a[1] * b[1]


def coordinates(structure: Linkage) -> Coordinates:
    """Name the freedoms: elastic modes first (M is then eliminated without fill), angles, bases."""
    c = Coordinates()
    for beam in structure.beams:
        for i in range(beam.modes):
            name = f"{beam.link}_{i}"
            if structure.relaxed:
                c.given((beam.link, i), number(f"rate_{name}"), number(f"acc_{name}"))
            else:
                c.free((beam.link, i), Symbol(f"eta_{name}", real=True), Symbol(f"deta_{name}", real=True))
    for k in structure.links:
        if structure.loop and k != structure.driven:
            continue
        if structure.drive == "speed" and k == structure.driven and not structure.loop:
            c.angle[k] = Angle(k, None, number("Omega"), number("theta_0"))
            c.given(k, number("Omega"), Integer(0))
        else:
            c.angle[k] = Angle(k, Symbol(f"theta_{k}", real=True))
            c.free(k, c.angle[k].position, Symbol(f"w_{k}", real=True))
            drive = DRIVES[structure.drive]
            if drive.acceleration and k == structure.driven:
                c.impose(k, drive.acceleration(TIME, *map(number, drive.letters)))
    for f in range(len(structure.floats)):
        for axis in (0, 1):
            x = "xy"[axis]
            c.free((f, axis), Symbol(f"{x}_{f}", real=True), Symbol(f"v{x}_{f}", real=True))
    return c
