"""Freedoms of a linkage: their speeds, the unknown ones among them, and the rates of the others.

A freedom is the angle of a link (its name), a coordinate of a chain's base (chain, axis), the slide of a
prismatic joint (None, joint), or an elastic mode, across (link, number) or along (None, link, number). Its
speed and acceleration are combinations of the unknown ones,

    z = sum_i P_i z_i,     a = sum_i P_i a_i + bias,

with P = 1 for an unknown, none for a prescribed motion, and the transmission functions of loops and slides
where a freedom follows others. So one set of tables serves every case: mass matrix and forces are written
over all freedoms and projected here.
"""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field
from functools import partial

from sympy import Expr, Integer, Symbol, atan2

from .drives import DRIVES
from .structure import Linkage
from .system import TIME, Angle, Root, accelerations, number

Freedom = Hashable


@dataclass(frozen=True)
class Direction:
    """Sine and cosine of an angle that follows from others."""

    sin: Expr
    cos: Expr

    @property
    def value(self) -> Expr:
        """The angle itself, rad."""
        return atan2(self.sin, self.cos)


@dataclass(frozen=True)
class Coordinates:
    """Symbols of a linkage's motion, by freedom; `positions` and `speeds` are the unknown ones, in order.

    `leads` says how a speed follows from the unknown and prescribed ones, `own` what the acceleration has
    beside theirs, `drift` what prescribed accelerations give it. `tree` says how a freedom follows from
    angles and slides when no loop is closed. `imposed` are accelerations of unknowns that no force changes,
    by their places. `stretch` says by how much a mode along lengthens a link, over its length. `folds` are
    squared sines of the angle between the columns of each loop, 0 at its dead centre. `roots` and `inverse`
    are of larger groups of loops (equations.loops.groups), the latter by their unknowns; `mark` ends the
    names of what is computed more than once.
    """

    angle: dict[Freedom, Angle | Direction] = field(default_factory=dict)
    position: dict[Freedom, Expr] = field(default_factory=dict)
    speed: dict[Freedom, Expr] = field(default_factory=dict)
    acceleration: dict[Freedom, Expr] = field(default_factory=dict)
    parts: dict[Freedom, tuple[tuple[int, Expr], ...]] = field(default_factory=dict)
    bias: dict[Freedom, Expr] = field(default_factory=dict)
    drift: dict[Freedom, Expr] = field(default_factory=dict)
    leads: dict[Freedom, dict[Freedom, Expr]] = field(default_factory=dict)
    own: dict[Freedom, Expr] = field(default_factory=dict)
    tree: dict[Freedom, dict[Freedom, Expr]] = field(default_factory=dict)
    positions: list[Symbol] = field(default_factory=list)
    speeds: list[Symbol] = field(default_factory=list)
    definitions: list[tuple[Symbol, Expr]] = field(default_factory=list)
    imposed: dict[int, Expr] = field(default_factory=dict)
    stretch: dict[str, dict[Freedom, Expr]] = field(default_factory=dict)
    folds: list[Expr] = field(default_factory=list)
    roots: list[Root] = field(default_factory=list)
    inverse: dict[tuple[Freedom, ...], tuple[tuple[Expr, ...], ...]] = field(default_factory=dict)
    mark: str = ""

    def e(self, k: Freedom) -> tuple[Expr, Expr]:
        """Unit vector along link k, or along a guide."""
        return self.angle[k].cos, self.angle[k].sin

    def n(self, k: Freedom) -> tuple[Expr, Expr]:
        """Unit vector across it."""
        return -self.angle[k].sin, self.angle[k].cos

    def longer(self, k: str) -> Expr:
        """Length of link k over that of the unstretched one: 1, but for a link that stretches."""
        return 1 + _combined(self.stretch.get(k, {}), self.position)

    def longer_rate(self, k: str) -> Expr:
        """Its rate."""
        return _combined(self.stretch.get(k, {}), self.speed)

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
        self._leader(freedom, Integer(0))
        self.positions.append(position)
        self.speeds.append(speed)

    def given(self, freedom: Freedom, speed: Expr, acceleration: Expr) -> None:
        """Add a freedom whose motion is prescribed."""
        self.speed[freedom], self.acceleration[freedom] = speed, acceleration
        self.parts[freedom], self.bias[freedom] = (), acceleration
        self._leader(freedom, acceleration)

    def _leader(self, freedom: Freedom, drift: Expr) -> None:
        self.leads[freedom] = self.tree[freedom] = {freedom: Integer(1)}
        self.own[freedom], self.drift[freedom] = Integer(0), drift

    def impose(self, freedom: Freedom, acceleration: Expr) -> None:
        """Make an unknown one whose acceleration is prescribed."""
        place = self.speeds.index(self.speed[freedom])
        self.imposed[place] = self.let(f"imposed_{freedom}", acceleration)
        self.given(freedom, self.speed[freedom], self.imposed[place])

    def follow(self, freedom: Freedom, ratios: dict[Freedom, Expr], own: Expr, closes: bool = False) -> None:
        """Add a freedom whose speed is a sum of ratios times others', with `own` added in acceleration.

        `closes` says that it follows by a loop, so that the tree has it as an unknown.
        """
        sum_of = partial(_combined, ratios)
        self.leads[freedom] = lead = _merged(ratios, self.leads)
        self.tree[freedom] = {freedom: Integer(1)} if closes else _merged(ratios, self.tree)
        self.speed[freedom] = sum_of(self.speed)
        self.acceleration[freedom] = sum_of(self.acceleration) + own
        self.own[freedom] = sum_of(self.own) + own
        self.drift[freedom] = sum_of(self.drift)
        self.parts[freedom] = tuple((i, lead[d] * part) for d in lead for i, part in self.parts[d])
        self.bias[freedom] = self.own[freedom] + self.drift[freedom]

    def let(self, name: str, value: Expr) -> Expr:
        """Name a value that is computed before all else, unless it is a number or has a name."""
        if value.is_Atom:
            return value
        self.definitions.append((Symbol(f"{name}{self.mark}", real=True), value))
        return self.definitions[-1][0]

    def mass(self, entries: dict[tuple[Freedom, Freedom], Expr]) -> dict[tuple[int, int], Expr]:
        """Lower triangle of the mass matrix over the unknowns, from one over all freedoms (pairs once)."""
        found: dict[tuple[int, int], Expr] = {}
        for (k, m), entry in entries.items():
            for i, part in self.parts[k]:
                for j, other in self.parts[m]:
                    if k == m and j > i:
                        continue  # its mirror image is taken
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
        """Forces on the unknowns: forces on all freedoms less the inertia of prescribed accelerations."""
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


def _combined(ratios: dict[Freedom, Expr], values: dict[Freedom, Expr]) -> Expr:
    return sum((ratio * values[leader] for leader, ratio in ratios.items()), Integer(0))


def _merged(ratios: dict[Freedom, Expr], leads: dict[Freedom, dict[Freedom, Expr]]) -> dict[Freedom, Expr]:
    found: dict[Freedom, Expr] = {}
    for leader, ratio in ratios.items():
        for first, part in leads[leader].items():
            found[first] = found.get(first, Integer(0)) + ratio * part
    return found


def coordinates(structure: Linkage) -> Coordinates:
    """Name the freedoms: elastic modes first (M is then eliminated without fill), angles, bases; memories."""
    c = Coordinates()
    for beam in structure.beams:
        for i in range(beam.modes):
            name = f"{beam.link}_{i}"
            if structure.relaxed:
                c.given((beam.link, i), number(f"rate_{name}"), number(f"acc_{name}"))
            else:
                c.free((beam.link, i), Symbol(f"eta_{name}", real=True), Symbol(f"deta_{name}", real=True))
        for mode in beam.stretches:
            name = f"{beam.link}_{mode[2]}"
            c.free(mode, Symbol(f"zeta_{name}", real=True), Symbol(f"dzeta_{name}", real=True))
            c.stretch.setdefault(beam.link, {})[mode] = number(f"stretch_{name}")
    dependent = structure.dependent
    for k in structure.links:
        if k in dependent:
            continue
        if structure.drive == "speed" and k == structure.driven and not structure.held:
            c.angle[k] = Angle(k, None, number("Omega"), number("theta_0"))
            c.given(k, number("Omega"), Integer(0))
        else:
            c.angle[k] = Angle(k, Symbol(f"theta_{k}", real=True))
            c.free(k, c.angle[k].position, Symbol(f"w_{k}", real=True))
            drive = DRIVES[structure.drive]
            if drive.acceleration and k == structure.driven:
                c.impose(k, drive.acceleration(TIME, *map(number, drive.letters)))
    for f in structure.floating:
        for axis in (0, 1):
            x = "xy"[axis]
            c.free((f, axis), Symbol(f"{x}_{f}", real=True), Symbol(f"v{x}_{f}", real=True))
    for slide in structure.slides:
        if slide.freedom not in dependent:
            names = (Symbol(f"{word}_{slide.name}", real=True) for word in ("slide", "vslide"))
            c.free(slide.freedom, *names)
    c.speeds.extend(approach(joint.name) for joint in structure.joints if joint.remembers)
    c.speeds.extend(bristle(joint.name) for joint in structure.joints if joint.bends)
    c.speeds.extend(symbol for unknown in structure.guessed for symbol in guess(unknown))
    return c


def approach(joint: str) -> Symbol:
    """The speed with which a contact began: no freedom has it, and it stays until the next one begins."""
    return Symbol(f"approach_{joint}", real=True)


def bristle(joint: str) -> Symbol:
    """The deflection of a joint's bristles: no freedom has it, and it changes in contact alone."""
    return Symbol(f"bristle_{joint}", real=True)


def guess(unknown: Freedom) -> tuple[Symbol, ...]:
    """Guess of an unknown of a larger group of loops: cosine and sine of an angle, or a slide."""
    names = [f"c_{unknown}", f"s_{unknown}"] if isinstance(unknown, str) else [f"slide_{unknown[1]}"]
    return tuple(Symbol(f"guess_{name}", real=True) for name in names)
