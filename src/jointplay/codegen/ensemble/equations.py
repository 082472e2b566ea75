"""The text of a structure's equations for eight trajectories at once (rows: numerics.ensemble.layout).

    prepare(w)    what follows from parameters alone
    jacobian(w)   d rate / d state at the predicted late stage
    rates(w)      rates, times h, and guards at all stages
    finish(w)     the same at the last stage alone
    base(w)       the same at the base point, for lanes that are NEW there

All lanes take the equations of slip, where masks tell contact from flight: M a_0 = Q - N F_n - T F_t. Lanes
that stick choose a = a_0 - y dF instead, with y = M^-1 T and dF = (T a_0 + T' w) / (T y), so that
T a + T' w = 0. Their Jacobian is that of a_0 less y (T da_0 + d(T' w)) / (T y), where what only positions
change of T and dF is left out: of the order of h^2 in Newton's matrix, whose iteration shows what that costs.
"""

from sympy import Expr, Integer, Symbol

from ...equations.system import System
from ...numerics.ensemble import layout as rows
from ...numerics.ensemble.radau import LATE, NODES, STAGES, A
from ..dynamics import Dynamics, dot
from ..source import Layout, Program, expression, importing, used
from ..tape import FLOW
from .text import at, choose, function, lanes, rotation, stage, total

HEADER = '''"""Generated from the equations, for eight trajectories at once; do not edit."""
from math import sqrt, tanh

from jointplay.numerics.ensemble.layout import CALL
from jointplay.numerics.interface import entry, inner

'''
N = range(rows.N)
ENTRIES = [(k, i) for k in N for i in range(2 * rows.N)]  # of the Jacobian


def text(system: System) -> str:
    """Source of the module of a system (of a structure that is `known`)."""
    writer, dynamics = Writer(system), Dynamics(system, "touch")
    bodies = [_rate(writer, dynamics), _slopes(writer, dynamics), writer.prepare(), *_functions()]
    size = f"ROWS = {writer.first + len(writer.constants)}\n"
    return importing(HEADER + size + "\n\n" + "\n\n\n".join(bodies) + "\n")


class Writer:
    """Bodies of one structure, at the point X, Y; `constants` are rows of what parameters alone make."""

    def __init__(self, system: System):
        self.system, self.layout = system, Layout(system)
        self.constants: dict[Expr, int] = {}
        self.first = rows.NUMBERS + len(system.parameters)

    def body(self, name: str, program: Program, stores: dict[int, str]) -> str:
        """A function that stores in rows what has these names; of lanes that stick, with `held_` before."""
        program, loads = self._hoisted(program)
        names = {str(symbol) for symbol, _ in program}
        lines = [f"stick = {at(rows.MASK, 2)}", *loads, *self._point(program)]
        lines += [f"{symbol} = {expression(value)}" for symbol, value in program]
        for row, value in stores.items():
            chosen = f"held_{value} if stick > 0.0 else {value}" if f"held_{value}" in names else value
            lines.append(f"{at(row)} = {chosen}")
        return "\n".join(["@inner", f"def {name}(w):", *lanes(*lines)])

    def _hoisted(self, program: Program) -> tuple[Program, list[str]]:
        """The program without what parameters alone make, and the lines that load this."""
        parameters, known, rest = {*self.system.parameters}, {}, []
        for symbol, value in program:
            closed = value.xreplace(known)
            if closed.free_symbols and closed.free_symbols <= parameters and "out_" not in str(symbol):
                known[symbol] = closed
            else:
                rest.append((symbol, value))
        lines = []
        for symbol in used(rest, known):
            place = self.constants.setdefault(known[symbol], len(self.constants))
            lines.append(f"{symbol} = {at(self.first, place)}")
        return rest, lines

    def _point(self, program: Program) -> list[str]:
        """Parameters, masks and the state that a program reads."""
        system = self.system
        places = {s: at(rows.NUMBERS, k) for k, s in enumerate(system.parameters)}
        places |= {s: at(rows.MASK, k) for s, k in self.layout.masks.items()}
        places |= {s: at(rows.Y, k) for k, s in enumerate(system.speeds)}
        places |= {s: f"{at(rows.POSITION, k)} + {at(rows.X, k)}" for k, s in enumerate(system.positions)}
        lines = [f"{s} = {places[s]}" for s in used(program, places)]
        for angle in system.angles:
            if used(program, (angle.sin, angle.cos)):
                k = system.positions.index(angle.position)
                lines += rotation(angle.sin, angle.cos, k, at(rows.X, k))
        return lines

    def prepare(self) -> str:
        """Subexpressions of parameters alone."""
        lines = self._point([(Symbol("constant"), value) for value in self.constants])
        lines += [f"{at(self.first, k)} = {expression(value)}" for value, k in self.constants.items()]
        return function("prepare", lanes(*(lines or ["pass"])))


def _rate(writer: Writer, dynamics: Dynamics) -> str:
    """Accelerations and guards: gap (or u), normal force, sliding speed, cone."""
    contact, a = writer.system.contacts[0], dynamics.a
    results = {f"out_a{k}": a[k] for k in N}
    results |= {"out_g0": contact.u if contact.gap is None else contact.gap, "out_g1": contact.F_n}
    if contact.sticks:
        column, share = _grip(dynamics)
        drag = dynamics.tape.let("held_F", (dot(contact.tangential, a) + _bias(dynamics)) * share)
        results |= {f"held_out_a{k}": a[k] - column[k] * drag for k in N}
        results |= {"out_g2": contact.v_t, "out_g3": Integer(0)}
        results["held_out_g3"] = (contact.limit * contact.F_n) ** 2 - (contact.drag + drag) ** 2
    stores = {rows.RATE + k: f"out_a{k}" for k in N}
    stores |= {rows.WATCHED + g: f"out_g{g}" for g in range(4) if f"out_g{g}" in results}
    return writer.body("rate", dynamics.tape.program(results), stores)


def _slopes(writer: Writer, dynamics: Dynamics) -> str:
    """d rate / d state."""
    contact, tape, results = writer.system.contacts[0], dynamics.tape, {}
    turning = [tape.derivative(_bias(dynamics), w) for w in writer.system.speeds] if contact.sticks else []
    found = dynamics.jacobian()
    entries = {place: found.get(place, Integer(0)) for place in ENTRIES}
    if contact.sticks:
        column, share = _grip(dynamics)
        for i in range(2 * rows.N):
            J = [entries[k, i] for k in N]
            drag = tape.let(f"held_F{i}", (dot(contact.tangential, J) + [0, 0, 0, *turning][i]) * share)
            results |= {f"held_out_{k}_{i}": J[k] - column[k] * drag for k in N}
    results |= {f"out_{k}_{i}": value for (k, i), value in entries.items()}
    stores = {rows.JACOBIAN + 2 * rows.N * k + i: f"out_{k}_{i}" for k, i in ENTRIES}
    return writer.body("slopes", tape.program(results), stores)


def _grip(dynamics: Dynamics) -> tuple[list[Expr], Expr]:
    """y = M^-1 T and 1 / (T y)."""
    T = dynamics.system.contacts[0].tangential
    column = dynamics.inverse_mass(list(T), "column")
    return column, dynamics.tape.let("grip", 1 / dot(T, column))


def _bias(dynamics: Dynamics) -> Expr:
    """T' w: what of v_t' needs no acceleration."""
    contact = dynamics.system.contacts[0]
    return dynamics.tape.derivative(contact.v_t, FLOW) + contact.drift


def _fetch(j: int) -> list[str]:
    """X and Y at stage j: increments of the angles, speeds."""
    lines = []
    for k in N:
        z = [stage(rows.Z, n, k) for n in range(STAGES)]
        moved = total(A[j], z)
        lines.append(
            f"{at(rows.X, k)} = {at(rows.H)} * ({float(NODES[j])!r} * {at(rows.SPEED, k)} + {moved})"
        )
        lines.append(f"{at(rows.Y, k)} = {at(rows.SPEED, k)} + {z[j]}")
    return lines


def _take(j: int) -> list[str]:
    """Rates times h, and guards, of stage j."""
    lines = [f"{stage(rows.F, j, k)} = {at(rows.H)} * {at(rows.RATE, k)}" for k in N]
    return lines + [f"{at(rows.WATCHES, 4 * j + g)} = {at(rows.WATCHED, g)}" for g in range(4)]


def _functions() -> list[str]:
    """Functions that the loop calls: rates and slopes at the points of a step."""
    rates = [*lanes(*_fetch(0)), "    rate(w)"]
    for j in range(STAGES):
        rates += lanes(*_take(j), *_fetch((j + 1) % STAGES)) + ["    rate(w)"] * (j < STAGES - 1)
    here = [f"{at(rows.X, k)} = 0.0" for k in N] + [f"{at(rows.Y, k)} = {at(rows.SPEED, k)}" for k in N]
    taken = [f"fresh = {at(rows.NEW)}"]
    for k in N:
        taken += choose(at(rows.ACCELERATION, k), at(rows.RATE, k), "fresh > 0.0")
    for g in range(4):
        taken += choose(at(rows.GUARD, g), at(rows.WATCHED, g), "fresh > 0.0")
    return [
        function("jacobian", [*lanes(*_fetch(LATE)), "    slopes(w)"]),
        function("rates", rates),
        function("finish", [*lanes(*_fetch(STAGES - 1)), "    rate(w)"]),
        function("base", [*lanes(*here), "    rate(w)", *lanes(*taken, f"{at(rows.NEW)} = 0.0")]),
    ]
