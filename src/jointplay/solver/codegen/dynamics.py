"""Solved dynamics of a system as straight-line programs: accelerations, contact forces and their Jacobian.

A system is solved in one of three variants, so that a model does not pay for what is absent: `free`
(nothing touches), `slip` (contacts push, friction is a law) and `stick` (some tangential forces are
unknowns that keep v_t at rest). Within the last two, contacts are told apart by masks: touch kappa_j, slip
direction sigma_j, stick eta_j. In both of them what rests on a rigid wall is held as what sticks is
(codegen.variants).

The unknowns are the accelerations a and the tangential forces F_t of

    M a + sum_j T_j F_t,j = Q - sum_j N_j F_n,j,
    eta_j (T_j.a + T_j'.w) + (1 - eta_j) (kappa_j (sigma_j f(v_t) F_n,j + drag_j) - F_t,j) = 0,

solved by M = L D L^T and the Schur complement S = T M^-1 T^T. The Jacobian solves the same matrix for the
derivatives of the residual.

Two corners i, j of a slider in line with its guide have one and the same row T: the motion knows the sum of
their forces alone. Where both stick, v_t,i' = EASE S_ii c_i (c_i F_t,i - c_j F_t,j) takes the place of 0 in
their rows, (c_i, c_j) along (F_n,j, -F_n,i): so they share the force as they share the load, and v_t,i' is 0
to rounding. Tilted by more than sqrt(EASE) or so, they stick each for itself.

A rough wall on which a body slips has the unknown force along N - sigma f T instead of N, and a switch that
slides along what it changes in the rates: S is T M^-1 T'^T then, with T' the directions of the forces, T the
rows of what they hold.

The mass matrix solved straight-line, and small systems.
"""

from collections.abc import Iterator
from functools import cached_property

from sympy import Add, Expr, Float, Integer, Symbol

from ..equations.system import TIME, Contact, Reset, System, accelerations, rubbing, traction
from . import variants
from .tape import Tape

EASE, TINY = Float(1e-9), Float(1e-100)  # TINY, N^2: its square is a number still


def eased(
    tape: Tape, contacts: list[Contact], i: int, sticks: list[Expr], pushes: list[Expr], own: Expr
) -> dict[int, Expr]:
    """Coefficients in v_t,i' of the F_t of contact i and of the other on its face, `own` being S_ii."""
    for j, other in enumerate(contacts):
        if j != i and other.face and other.face == contacts[i].face:
            c_j, c_i = pushes[i], pushes[j]
            size = tape.let(f"ease_{i}", EASE * sticks[j] * own / (c_i**2 + c_j**2 + TINY))
            return {i: size * c_i**2, j: -size * c_i * c_j}
    return {}


class Dynamics:
    """A system solved in one variant: `tape` holds the program, `a`, `F_n`, `F_t` the results."""

    def __init__(self, system: System, variant: str):
        self.system, self.tape = system, Tape(system)
        self.masks = variants.masks(system, variant)
        self.held = [j for j, mask in enumerate(self.masks) if mask.stick != 0]
        self.inverse_mass = InverseMass(self.tape, system)
        walls = [variants.holding(self.tape, reset, system) for reset in system.resets]
        self.variant, self.guides = variant, variants.guides(system)
        rubs = [variants.rubbing(guide, variant) for guide in self.guides]
        self.contacts = [*system.contacts, *walls, *rubs]
        names = [traction(contact) for contact in self.contacts]
        self.F_n = [
            self.tape.define(name, mask.touch * contact.F_n)
            for (name, _), contact, mask in zip(names, self.contacts, self.masks, strict=True)
        ]
        self.slipping = [self._friction(j) for j in range(len(names))]
        bias = [self.masks[j].stick * self._bias(j) + self._released(j, self.slipping[j]) for j in self.held]
        a, held = self._solve(self._pushed(), bias, "sol")
        forces = dict(enumerate(self.slipping)) | held
        self.F_t = [self.tape.define(name, forces[j]) for j, (_, name) in enumerate(names)]
        symbols = accelerations(len(system.speeds))
        self.a = [self.tape.define(symbol, value) for symbol, value in zip(symbols, a, strict=True)]
        for wall in (wall for guide in self.guides for wall in guide):
            self.tape.define(rubbing(wall), self.friction(wall))

    @property
    def abrupt(self) -> set[Symbol]:
        """Symbols that amplify errors of speeds: accelerations, friction, walls' forces, a drive's law."""
        return {*self.a, *self.F_t, *self.system.answering}

    def rub(self, wall: Reset) -> int:
        """Place among the contacts of the friction of a rough wall's guide."""
        (place,) = (g for g, guide in enumerate(self.guides) if wall in guide)
        return len(self.system.contacts) + len(self.system.resets) + place

    def friction(self, wall: Reset) -> Expr:
        """Friction of a rough wall: the force that holds, or sigma f times the push."""
        rub, push = self.rub(wall), -self.F_t[len(self.system.contacts) + self.system.resets.index(wall)]
        guide = self.guides[rub - len(self.system.contacts) - len(self.system.resets)]
        share = variants.shares(guide, self.variant)[guide.index(wall)]
        return share * self.F_t[rub] + variants.slipping(wall, self.variant) * wall.coulomb * push

    def _friction(self, j: int) -> Expr:
        """F_t while contact j slips: kappa (sigma f F_n + drag)."""
        contact, mask = self.contacts[j], self.masks[j]
        slip = mask.slip * contact.coulomb * self.F_n[j] if contact.sticks else Integer(0)
        return self.tape.let(f"Fs_{contact.name}", slip + mask.touch * contact.drag)

    def _released(self, j: int, force: Expr) -> Expr:
        """The share of a contact's friction row that is not sticking."""
        return (1 - self.masks[j].stick) * force

    def _bias(self, j: int) -> Expr:
        """T_j'.w: the part of v_t' that needs no unknown acceleration."""
        return self._drifting(self.contacts[j])

    def _drifting(self, contact: Contact | Reset) -> Expr:
        v_t, drift = contact.v_t, contact.drift
        pairs = zip(self.system.positions, self.system.speeds, strict=False)
        moved = sum((self.tape.derivative(v_t, q) * w for q, w in pairs), Integer(0))
        return moved + self.tape.derivative(v_t, TIME) + drift

    def _pushed(self) -> list[Expr]:
        """Q_k - sum_j (N_j,k F_n,j + T_j,k F_t,j), the held tangential forces left out."""
        Q = list(self.system.force)
        for j, contact in enumerate(self.contacts):
            pairs = [(contact.normal, self.F_n[j])]
            if j not in self.held:
                pairs.append((contact.acts_along or contact.tangential, self.slipping[j]))
            for row, F in pairs:
                Q = [q - entry * F for q, entry in zip(Q, row, strict=True)] if row else Q
            for symbol, rate in contact.rates.items():
                Q[self.system.speeds.index(symbol)] += self.masks[j].touch * rate
        return [self.tape.let(f"Q_{k}", value) for k, value in enumerate(Q)]

    def _solve(self, push: list[Expr], hold: list[Expr], name: str) -> tuple[list[Expr], dict[int, Expr]]:
        """Accelerations and held forces for right-hand sides of the two rows (see the module's text)."""
        a = self.inverse_mass(push, name)
        right = [
            self.tape.let(f"{name}_h{j}", self.masks[j].stick * dot(self._row(j), a) + value)
            for j, value in zip(self.held, hold, strict=True)
        ]
        forces = eliminate(self.tape, self._complement, right, f"{name}_F")
        for y, F in zip(self._columns, forces, strict=True):
            a = [value - entry * F for value, entry in zip(a, y, strict=True)]
        a = [self.tape.let(f"{name}_a{k}", value) for k, value in enumerate(a)]
        return a, dict(zip(self.held, forces, strict=True))

    def _row(self, j: int) -> tuple[Expr, ...]:
        return self.contacts[j].tangential

    def _direction(self, j: int) -> tuple[Expr, ...]:
        """Direction of the force of a held contact: its way, or its row, with friction at a rough wall."""
        wall = dict(enumerate(self.system.resets, start=len(self.system.contacts))).get(j)
        if wall is None or not wall.rough:
            return self.contacts[j].acts_along or self._row(j)
        drawn = variants.slipping(wall, self.variant) * wall.coulomb
        pairs = zip(self._row(j), wall.tangential, strict=True)
        return tuple(self.tape.let(f"dir{j}_{i}", n - drawn * t) for i, (n, t) in enumerate(pairs))

    @cached_property
    def _columns(self) -> list[list[Expr]]:
        """M^-1 T'_j of the held contacts."""
        return [self.inverse_mass(list(self._direction(j)), f"col{j}") for j in self.held]

    @cached_property
    def _responses(self) -> list[list[Expr]]:
        """M^-1 T_j of the held contacts."""
        if not self.guides and not any(contact.acts_along for contact in self.contacts):
            return self._columns
        return [self.inverse_mass(list(self._row(j)), f"row{j}") for j in self.held]

    @cached_property
    def _complement(self) -> list[list[Expr]]:
        """eta T M^-1 T^T + (1 - eta) I over the held contacts."""
        return [
            [
                self.tape.let(
                    f"S_{i}_{j}",
                    self.masks[i].stick * (dot(self._row(i), y) + self._ease(i).get(j, 0))
                    + self._released(i, int(i == j)),
                )
                for j, y in zip(self.held, self._columns, strict=True)
            ]
            for i in self.held
        ]

    def creep(self, j: int) -> Expr:
        """v_t' of contact j in this variant."""
        return self.slide(self.contacts[j]) - self._eased(j, self.F_t)

    def restoring(self, j: int) -> Expr:
        """Decrease of v_t' by a unit of the force of held contact j."""
        return dot(self._row(j), self._columns[self.held.index(j)])

    def slide(self, contact: Contact | Reset) -> Expr:
        """v_t' of a contact or a rough wall, by the accelerations."""
        return dot(contact.tangential, self.a) + self._drifting(contact)

    def _ease(self, i: int) -> dict[int, Expr]:
        """Coefficients in v_t,i' of the F_t of contact i and the other on its face, while that one sticks."""
        if i not in self.held:
            return {}
        place, sticks = self.held.index(i), [self.masks[j].stick for j in self.held]
        contacts, pushes = ([each[j] for j in self.held] for each in (self.contacts, self.F_n))
        found = eased(self.tape, contacts, place, sticks, pushes, self.restoring(i))
        return {self.held[j]: value for j, value in found.items()}

    def _eased(self, i: int, forces) -> Expr:
        return sum((entry * forces[j] for j, entry in self._ease(i).items()), Integer(0))

    def jacobian(self) -> dict[tuple[int, int], Expr]:
        """d a_k / d x_i, x the positions, the speeds, then directions; closes the tape to other derivatives.

        Those of what follows from the accelerations alone can be taken still.
        """
        entries, variables = {}, self.variables
        for i, push, hold in self._slopes(variables):
            if any(value != 0 for value in push + hold):
                column, held = self._solve(push, hold, f"J{i}")
                entries |= {(k, i): value for k, value in enumerate(column)}
                forces = {self.F_t[j]: value for j, value in held.items()}
                self.tape.solved(variables[i], dict(zip(self.a, column, strict=True)) | forces)
        return entries

    @property
    def variables(self) -> tuple[Symbol, ...]:
        """Positions, speeds, directions."""
        return (*self.system.positions, *self.system.speeds, *self.system.directions)

    def held_slopes(self, variables: tuple[Symbol, ...]) -> dict[tuple[int, int], Expr]:
        """d F_t,j / d x_i of held contacts; closes the tape to further derivatives."""
        result = {}
        for i, push, hold in self._slopes(variables):
            forces = self._holding(push, hold, f"H{i}")
            result |= {(j, i): F for j, F in zip(self.held, forces, strict=True)}
        return result

    def residual_jacobian(self) -> tuple[dict[tuple[int, int], Expr], dict[tuple[int, int], Expr]]:
        """d (Q - M a)_k / d x_i at fixed a, by positions, and by speeds and directions; held forces follow.

        Of M^-1 times these, `jacobian` is the sum. Closes the tape to further derivatives.
        """
        result: tuple[dict, dict] = ({}, {})
        n_q = len(self.system.positions)
        for i, push, hold in self._slopes(self.variables):
            column = self._held_back(push, hold, f"B{i}")
            part, place = (result[0], i) if i < n_q else (result[1], i - n_q)
            part |= {(k, place): value for k, value in enumerate(column) if value != 0}
        return result

    def _slopes(self, variables: tuple[Symbol, ...]) -> Iterator[tuple[int, list[Expr], list[Expr]]]:
        """Derivatives of both rows at fixed accelerations and held forces, one variable after the other.

        After the last one these take their solved values.
        """
        hats = [Symbol(f"hat_{symbol}", real=True) for symbol in self.a]
        grip = {j: Symbol(f"hat_{self.F_t[j]}", real=True) for j in self.held}
        push, hold = self._residual(hats, grip)
        for i, x in enumerate(variables):
            yield i, *([self.tape.derivative(value, x) for value in row] for row in (push, hold))
        solved = [*self.a, *(self.F_t[j] for j in grip)]
        for hat, value in zip([*hats, *grip.values()], solved, strict=True):
            self.tape.define(hat, value)

    def _held_back(self, push: list[Expr], hold: list[Expr], name: str) -> list[Expr]:
        """`push` less the held forces that keep sticking contacts at rest against it."""
        if not any(value != 0 for value in push + hold):
            return push
        for j, F in zip(self.held, self._holding(push, hold, name), strict=True):
            push = [value - entry * F for value, entry in zip(push, self._direction(j), strict=True)]
        return push

    def _holding(self, push: list[Expr], hold: list[Expr], name: str) -> list[Expr]:
        """Held forces for right-hand sides of the two rows, without the accelerations."""
        right = [
            self.masks[j].stick * dot(y, push) + value
            for j, y, value in zip(self.held, map(tuple, self._responses), hold, strict=True)
        ]
        return eliminate(self.tape, self._complement, right, f"{name}_F")

    def _residual(self, a: list[Symbol], grip: dict[int, Symbol]) -> tuple[list[Expr], list[Expr]]:
        """Both rows as functions of the state, at given accelerations and held forces."""
        push = self._pushed()
        for (i, j), entry in self.inverse_mass.entries.items():
            push[i] -= entry * a[j]
            if i != j:
                push[j] -= entry * a[i]
        for j, F in grip.items():
            push = [value - entry * F for value, entry in zip(push, self._direction(j), strict=True)]
        hold = [
            self.masks[j].stick * (dot(self._row(j), a) + self._bias(j) - self._eased(j, grip))
            + self._released(j, self.slipping[j])
            for j in self.held
        ]
        return push, hold


class InverseMass:
    """M = L D L^T written out, zeros skipped; calling it substitutes. The identity without a mass."""

    def __init__(self, tape: Tape, system: System):
        self.tape, self.n = tape, len(system.speeds)
        self.entries = {
            place: tape.let("M_{}_{}".format(*place), m) for place, m in (system.mass or {}).items()
        }
        self.L: dict[tuple[int, int], Expr] = {}
        self.pivot: list[Expr] = [Integer(1)] * self.n
        rest = dict(self.entries)
        for j in range(self.n if rest else 0):
            self.pivot[j] = tape.let(f"iD_{j}", 1 / rest[j, j])
            below = [i for i in range(j + 1, self.n) if (i, j) in rest]
            for i in below:
                self.L[i, j] = tape.let(f"L_{i}_{j}", rest[i, j] * self.pivot[j])
            for i, k in ((i, k) for i in below for k in below if k <= i):
                rest[i, k] = tape.let(
                    f"M_{i}_{k}_{j}", rest.get((i, k), Integer(0)) - self.L[i, j] * rest[k, j]
                )
        if not rest and system.mass is None:
            self.entries = {(k, k): Integer(1) for k in range(self.n)}

    def __call__(self, b: list[Expr], name: str) -> list[Expr]:
        x: list[Expr] = []
        for i, value in enumerate(b):
            below = Add(*[factor * x[c] for (r, c), factor in self.L.items() if r == i])
            x.append(self.tape.let(f"{name}_f{i}", value - below))
        x = [value * pivot for value, pivot in zip(x, self.pivot, strict=True)]
        for i in reversed(range(self.n)):
            above = Add(*[factor * x[r] for (r, c), factor in self.L.items() if c == i])
            x[i] = self.tape.let(f"{name}_{i}", x[i] - above)
        return x


def dot(row: tuple[Expr, ...], x: list[Expr]) -> Expr:
    """Sum of products."""
    return Add(*[entry * value for entry, value in zip(row, x, strict=True)])


def eliminate(tape: Tape, matrix: list[list[Expr]], right: list[Expr], name: str) -> list[Expr]:
    """Solve a small system by elimination without pivoting (near positive definite, or unit rows)."""
    A, b = [list(row) for row in matrix], list(right)
    n = len(b)
    for j in range(n):
        for i in range(j + 1, n):
            factor = tape.let(f"{name}_m{i}{j}", A[i][j] / A[j][j])
            A[i] = [tape.let(f"{name}_A{i}{k}{j}", A[i][k] - factor * A[j][k]) for k in range(n)]
            b[i] = tape.let(f"{name}_b{i}{j}", b[i] - factor * b[j])
    for i in reversed(range(n)):
        b[i] = tape.let(f"{name}{i}", (b[i] - sum(A[i][k] * b[k] for k in range(i + 1, n))) / A[i][i])
    return b
