"""Form of the equations of motion that code generation takes.

A system has positions q and speeds z with

    q_i' = z_i  (i < number of positions),      M(q) z' = Q(t, q, z) - sum_j (N_j F_n,j + T_j F_t,j),

so that second-order mechanics and first-order test systems (no positions, M = I) are one form. Sines and
cosines of angles are symbols of their own; an angle is a position, or a prescribed phase (rate times time),
or a sum of both.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache

from sympy import Expr, Integer, Symbol

TIME = Symbol("t", real=True)


@dataclass(frozen=True)
class Angle:
    """An angle whose sine and cosine occur: `position` + `rate` * t + `offset`."""

    name: str
    position: Symbol | None = None
    rate: Expr = Integer(0)
    offset: Expr = Integer(0)

    @property
    def sin(self) -> Symbol:
        """Its sine, as a symbol."""
        return number(f"s_{self.name}")

    @property
    def cos(self) -> Symbol:
        """Its cosine, as a symbol."""
        return number(f"c_{self.name}")

    @property
    def value(self) -> Expr:
        """The angle itself, rad."""
        return (self.position if self.position is not None else Integer(0)) + self.rate * TIME + self.offset


@dataclass(frozen=True)
class Contact:
    """One unilateral contact: penetration u, speeds v_n and v_t, force law F_n(u, v_n), friction.

    `normal` and `tangential` are N_k = dv_n/dz_k and T_k = dv_t/dz_k, one a speed. `coulomb` is the
    friction coefficient while a law with true sticking slips, which may depend on v_t, and `limit` that up to
    which it sticks; `drag` is the part of F_t that is a smooth law; `drift` the part of dv_t/dt that
    prescribed accelerations make. `gap` is what is watched for roots in the place of u, of the same sign,
    where u itself is not smooth along a motion; `push` what is watched in the place of F_n, of the same sign
    where u > 0. `entry` gives speeds their new values where contact begins, `exit` where it ends; `rates` are
    what they gain a second, as forces on them, while it lasts. Corners of a slider have a `face` in common.
    The force of friction acts along T, or `acts_along` where its sign is a switch's, which slides where v_t
    is kept at 0.
    """

    name: str
    u: Symbol
    v_n: Symbol
    F_n: Expr
    normal: tuple[Expr, ...]
    pulls: bool = True
    v_t: Symbol | None = None
    tangential: tuple[Expr, ...] = ()
    coulomb: Expr | None = None
    drag: Expr = Integer(0)
    stored: Expr = Integer(0)
    gap: Expr | None = None
    drift: Expr = Integer(0)
    limit: Expr | None = None
    push: Expr | None = None
    entry: dict[Symbol, Expr] = field(default_factory=dict)
    exit: dict[Symbol, Expr] = field(default_factory=dict)
    rates: dict[Symbol, Expr] = field(default_factory=dict)
    face: str = ""
    acts_along: tuple[Expr, ...] = ()

    @property
    def sticks(self) -> bool:
        """Whether its friction has true sticking."""
        return self.limit is not None

    @property
    def pressed(self) -> Expr:
        """The watched expression with the sign of the force."""
        return self.F_n if self.push is None else self.push


@dataclass(frozen=True)
class Reset:
    """A jump of the state: where `guard` falls through zero, each speed of `speeds` takes its new value.

    With a `restitution` r the jump is that of an impulse along the gap's gradient N instead, after which the
    gap opens r times as fast as it closed (Newton): z+ = z - (1 + r) M^-1 N (N.z) / (N.M^-1 N). One that
    `moves` the state is no wall: nothing rests on it, and any speed may stand in its guard. A wall with a
    friction coefficient `coulomb` has the sliding speed v_t, its row `tangential` and `drift` as a contact
    has them; corners of a slider have a `guide` in common. `drawn` is what the drive's speed has in the rates
    of the gap and of v_t. In an impact and at rest the gap is `met`, if given: without kinks as modes.
    """

    name: str
    guard: Expr
    speeds: dict[Symbol, Expr] = field(default_factory=dict)
    restitution: Expr | None = None
    moves: bool = False
    coulomb: Expr | None = None
    v_t: Symbol | None = None
    tangential: tuple[Expr, ...] = ()
    drift: Expr = Integer(0)
    guide: str = ""
    drawn: tuple[Expr, Expr] = (Integer(0), Integer(0))
    met: Expr | None = None

    @property
    def gap(self) -> Expr:
        """Its gap as it stands, whatever the modes."""
        return self.guard if self.met is None else self.met

    @property
    def rough(self) -> bool:
        """Whether it is a wall with friction."""
        return self.coulomb is not None


@dataclass(frozen=True)
class Root:
    """Unknowns that solve g = 0: however computed, they have the root's derivatives, -J^-1 dg.

    `symbols` are computed from unknowns: each with the number of its own and the derivative by it.
    `residuals` are g with the stand-ins `held` in their place, which nothing moves; `inverse` is J^-1.
    """

    symbols: dict[Symbol, tuple[int, Expr]]
    residuals: tuple[Expr, ...]
    inverse: tuple[tuple[Expr, ...], ...]
    held: tuple[Symbol, ...]


@dataclass(frozen=True)
class System:
    """Equations of motion, ready for code generation. See the module's text for the form.

    `directions` are those along which parameters change (`directed`), by a symbol each. `folds` are numbers
    that fall to 0 where the equations end, as at a dead centre, like squares of the time that is left.
    `imposed` are accelerations of unknowns that neither force nor impulse changes, by their places. `draws`
    is the work that a drive of imposed speed does per change of each speed in an impact: 0 where there is no
    such drive, or no work is wanted. `answering` are the numbers of a drive whose torque answers its speed.
    It `bends` where a guard is no polynomial of the state, and so may turn faster than the state does.
    """

    positions: tuple[Symbol, ...]
    speeds: tuple[Symbol, ...]
    parameters: tuple[Symbol, ...]
    definitions: tuple[tuple[Symbol, Expr], ...]
    mass: dict[tuple[int, int], Expr] | None
    force: tuple[Expr, ...]
    angles: tuple[Angle, ...] = ()
    contacts: tuple[Contact, ...] = ()
    resets: tuple[Reset, ...] = ()
    powers: dict[str, Expr] = field(default_factory=dict)
    outputs: dict[str, Expr] = field(default_factory=dict)
    section: Expr | None = None
    folds: tuple[Expr, ...] = ()
    directions: dict[Symbol, dict[Symbol, Expr]] = field(default_factory=dict)
    roots: tuple[Root, ...] = ()
    imposed: dict[int, Expr] = field(default_factory=dict)
    draws: tuple[Expr, ...] = ()
    answering: tuple[Symbol, ...] = ()
    bends: bool = False

    @property
    def rubs(self) -> int:
        """Number of resets that are watched for slip and sticking: all where one is rough, else none."""
        return len(self.resets) if any(reset.rough for reset in self.resets) else 0


@lru_cache(maxsize=20000)
def number(name: str) -> Symbol:
    """The symbol of a real number, such as a parameter."""
    return Symbol(name, real=True)


def directed(system: System, directions: tuple[tuple[str, ...], ...]) -> System:
    """The system with directions: along each, named parameters change at rates that are parameters too."""
    named = {
        number(f"direction_{j}"): {number(name): number(f"way_{j}_{name}") for name in names}
        for j, names in enumerate(directions)
    }
    rates = tuple(rate for each in named.values() for rate in each.values())
    return replace(system, parameters=system.parameters + rates, directions=named)


def accelerations(n: int) -> tuple[Symbol, ...]:
    """Symbols that stand for the n solved accelerations in outputs and powers."""
    return tuple(number(f"a_{k}") for k in range(n))


def rubbing(wall) -> Symbol:
    """Symbol that stands for the solved friction of a rough wall."""
    return Symbol(f"Fr_{wall.name}", real=True)


def traction(contact) -> tuple[Symbol, Symbol]:
    """Symbols that stand for the solved normal and tangential force of a contact in outputs and powers."""
    return Symbol(f"Fn_{contact.name}", real=True), Symbol(f"Ft_{contact.name}", real=True)
