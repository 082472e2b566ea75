"""The text of a structure's equations for eight trajectories at once (rows: numerics.ensemble.layout).

    prepare(w)    what follows from parameters alone
    jacobian(w)   d rate / d state at the point X, Y
    rates(w)      rates, times h, and guards at all stages
    finish(w)     the same at the last stage alone
    base(w)       the same at the base point, for lanes that are NEW there

All lanes take the equations of slip, where masks tell contact from flight: M a_0 = Q - N F_n - T F_t. Lanes
that stick choose a = a_0 - y dF instead, with y = M^-1 T and dF = (T a_0 + T' w) / (T y), so that
T a + T' w = 0. Their Jacobian is that of a_0 less y (T da_0 + d(T' w)) / (T y), where what only positions
change of T and dF is left out: of the order of h^2 in Newton's matrix, whose iteration shows what that costs.
"""

from dataclasses import replace

from sympy import Expr, Integer, Symbol

from ...equations.system import System
from ...numerics.ensemble import layout as rows
from ...numerics.ensemble.radau import STAGES
from ...numerics.modes import FORCE, GAP
from ..dynamics import Dynamics, dot
from ..module import guards
from ..source import Layout, Program, expression, importing, used
from ..tape import FLOW
from .form import laid_out
from .text import at, choose, fetch, function, lanes, rotation, stage

HEADER = '''"""Generated from the equations, for eight trajectories at once; do not edit."""
from math import cos, sin, sqrt, tanh

from jointplay.numerics.ensemble.layout import CALL
from jointplay.numerics.interface import inner
from jointplay.numerics.interface import SIGNATURES, compiled, entry

'''


def text(system: System) -> str:
    """Source of the module of a system (of a structure that is `known`)."""
    laid, phases = laid_out(system)
    system = replace(
        laid, resets=()
    )  # where a state jumps, the loop lets the structure's own functions do so
    gaps = {4 * (len(system.contacts) + k) + GAP: each.guard for k, each in enumerate(laid.resets)}
    writer, dynamics = Writer(system, phases), Dynamics(system, _variant(system))
    bodies = [_rate(writer, dynamics, gaps), _slopes(writer, dynamics), writer.prepare()]
    bodies += _functions(len(system.positions), [*range(4 * len(system.contacts)), *gaps])
    size = f"ROWS = {writer.first + len(writer.constants)}\n"
    size += f"PHASES = {[angle.name for angle in system.angles[:phases]]!r}\n"
    return importing(HEADER + size + "\n\n" + "\n\n\n".join(bodies) + "\n")


def _variant(system: System) -> str:
    """Equations that all lanes take: those of slip, or with several contacts that of sticking."""
    several = len(system.contacts) > 1 and any(contact.sticks for contact in system.contacts)
    return "stick" if several else "touch"


def _lone(system: System) -> bool:
    """Whether the one contact sticks by a choice after the equations of slip."""
    return len(system.contacts) == 1 and system.contacts[0].sticks


class Writer:
    """Bodies of one structure, at the point X, Y; `constants` are rows of what parameters alone make.

    The first positions are so many `phases`.
    """

    def __init__(self, system: System, phases: int):
        self.system, self.layout, self.phases = system, Layout(system), phases
        self.constants: dict[Expr, int] = {}
        self.first = rows.NUMBERS + len(system.parameters)

    def body(self, name: str, program: Program, stores: dict[int, str], own: bool = True) -> str:
        """A function that stores in rows what has these names; of lanes that stick, with `held_` before.

        Not its `own`: other lanes keep what is there.
        """
        if own:
            program, loads = self._hoisted(program)
        else:
            loads = [f"{value} = {at(row)}" for row, value in stores.items()]
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
        n = len(system.positions)
        places |= {s: at(rows.Y, k) for k, s in enumerate(system.speeds[:n])}
        places |= {s: at(rows.MEMORY, k) for k, s in enumerate(system.speeds[n:])}
        places |= {s: f"{at(rows.POSITION, k)} + {at(rows.X, k)}" for k, s in enumerate(system.positions)}
        lines = [f"{s} = {places[s]}" for s in used(program, places)]
        for angle in system.angles:
            if used(program, (angle.sin, angle.cos)):
                k = system.positions.index(angle.position)
                lines += rotation(angle.sin, angle.cos, k, at(rows.X, k), k < self.phases)
        return lines

    def prepare(self) -> str:
        """Subexpressions of parameters alone."""
        lines = self._point([(Symbol("constant"), value) for value in self.constants])
        lines += [f"{at(self.first, k)} = {expression(value)}" for value, k in self.constants.items()]
        return function("prepare", lanes(*(lines or ["pass"])))


def _rate(writer: Writer, dynamics: Dynamics, gaps: dict[int, Expr]) -> str:
    """Accelerations and guards (codegen.module.guards), `gaps` those of jumps."""
    system, a = writer.system, dynamics.a
    N, variant = range(len(system.positions)), _variant(system).replace("touch", "slip")
    results = {f"out_a{k}": a[k] for k in N}
    for j, contact in enumerate(system.contacts):
        watched = guards(dynamics, j, variant) | ({FORCE: contact.pressed} if contact.sticks else {})
        results |= {f"out_g{4 * j + g}": value for g, value in watched.items()}
    results |= {f"out_g{g}": value for g, value in gaps.items()}
    if _lone(system):
        contact, (column, share) = system.contacts[0], _grip(dynamics)
        drag = dynamics.tape.let("held_F", (dot(contact.tangential, a) + _bias(dynamics)) * share)
        results |= {f"held_out_a{k}": a[k] - column[k] * drag for k in N}
        results["out_g3"] = Integer(0)
        results["held_out_g3"] = (contact.limit * contact.F_n) ** 2 - (contact.drag + drag) ** 2
    stores = {rows.RATE + k: f"out_a{k}" for k in N}
    stores |= {rows.WATCHED + g: f"out_g{g}" for g in range(rows.GUARDS) if f"out_g{g}" in results}
    return writer.body("rate", dynamics.tape.program(results), stores)


def _slopes(writer: Writer, dynamics: Dynamics) -> str:
    """d rate / d state."""
    system, tape, results = writer.system, dynamics.tape, {}
    lone, n = _lone(system), len(system.positions)
    speeds, N = system.speeds[:n], range(n)
    turning = [0] * n + ([tape.derivative(_bias(dynamics), w) for w in speeds] if lone else [])
    found = dynamics.jacobian()
    entries = {(k, i): found.get((k, i), Integer(0)) for k in N for i in range(2 * n)}
    if lone:
        column, share = _grip(dynamics)
        for i in range(2 * n):
            J = [entries[k, i] for k in N]
            drag = tape.let(f"held_F{i}", (dot(system.contacts[0].tangential[:n], J) + turning[i]) * share)
            results |= {f"held_out_{k}_{i}": J[k] - column[k] * drag for k in N}
    results |= {f"out_{k}_{i}": value for (k, i), value in entries.items()}
    return writer.body("slopes", tape.program(results), _places(n))


def held(system: System) -> str:
    """Source of a module: held(w), d rate / d state where the one contact sticks, nothing left out.

    What only positions change of T and dF, which Newton's matrix does without, tangents need.
    """
    if not _lone(system):
        return importing(HEADER + function("held", ["    pass"]) + "\n")
    writer, dynamics, n = Writer(system, 0), Dynamics(system, "stick"), len(system.positions)
    found, N = dynamics.jacobian(), range(n)
    results = {f"held_out_{k}_{i}": found.get((k, i), Integer(0)) for k in N for i in range(2 * n)}
    body = writer.body("exact", dynamics.tape.program(results), _places(n), own=False)
    return importing(HEADER + body + "\n\n\n" + function("held", ["    exact(w)"]) + "\n")


def _places(n: int) -> dict[int, str]:
    """Rows of d rate / d state, and the names of their entries."""
    shift = rows.N - n  # of the speeds' columns
    pairs = ((k, i) for k in range(n) for i in range(2 * n))
    return {rows.JACOBIAN + 2 * rows.N * k + i + shift * (i >= n): f"out_{k}_{i}" for k, i in pairs}


def _grip(dynamics: Dynamics) -> tuple[list[Expr], Expr]:
    """y = M^-1 T and 1 / (T y)."""
    T = dynamics.system.contacts[0].tangential
    column = dynamics.inverse_mass(list(T), "column")
    return column, dynamics.tape.let("grip", 1 / dot(T, column))


def _bias(dynamics: Dynamics) -> Expr:
    """T' w: what of v_t' needs no acceleration."""
    contact = dynamics.system.contacts[0]
    return dynamics.tape.derivative(contact.v_t, FLOW) + contact.drift


def _take(n: int, watched: list[int], j: int) -> list[str]:
    """Rates times h, and guards, of stage j."""
    lines = [f"{stage(rows.F, j, k)} = {at(rows.H)} * {at(rows.RATE, k)}" for k in range(n)]
    watches = rows.WATCHES + rows.GUARDS * j
    return lines + [f"{at(watches, g)} = {at(rows.WATCHED, g)}" for g in watched]


def _functions(n: int, watched: list[int]) -> list[str]:
    """Functions that the loop calls: rates and slopes at the points of a step."""
    N, rates = range(n), [*lanes(*fetch(n, 0)), "    rate(w)"]
    for j in range(STAGES):
        following = fetch(n, (j + 1) % STAGES)
        rates += lanes(*_take(n, watched, j), *following) + ["    rate(w)"] * (j < STAGES - 1)
    here = [f"{at(rows.X, k)} = 0.0" for k in N] + [f"{at(rows.Y, k)} = {at(rows.SPEED, k)}" for k in N]
    taken = [f"fresh = {at(rows.NEW)}"]
    for k in N:
        taken += choose(at(rows.ACCELERATION, k), at(rows.RATE, k), "fresh > 0.0")
    for g in watched:
        taken += choose(at(rows.GUARD, g), at(rows.WATCHED, g), "fresh > 0.0")
    return [
        function("jacobian", ["    slopes(w)"]),
        function("rates", rates),
        function("finish", [*lanes(*fetch(n, STAGES - 1)), "    rate(w)"]),
        function("base", [*lanes(*here), "    rate(w)", *lanes(*taken, f"{at(rows.NEW)} = 0.0")]),
    ]
