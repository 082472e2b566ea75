"""The text of a structure's equations for eight trajectories at once (rows: method.lanes.layout).

    prepare(w)    what follows from parameters alone
    jacobian(w)   d rate / d state at the point X, Y
    rates(w)      rates, times h, and guards at all stages
    finish(w)     the same at the last stage alone
    base(w)       the same at the base point, for lanes that are NEW there

All lanes take the equations of slip, where masks tell contact from flight: M a_0 = Q - N F_n - T F_t. Only
where a contact sticks in some lane are those gone over again that are `held`: a = a_0 - Y dF with Y = M^-1 T
and (T Y) dF = T a_0 + T' w over the contacts that stick, so that T a + T' w = 0. Lanes in which none sticks
keep what they have, so that their numbers do not depend on others.
"""

from collections.abc import Callable
from dataclasses import replace

from sympy import Expr, Integer, Symbol

from ...equations.system import TIME, Angle, Contact, System
from ...method.lanes import CLOCK
from ...method.lanes import layout as rows
from ...method.lanes.radau import STAGES
from ...method.modes import CONE, FORCE
from ..dynamics import Dynamics, dot, eased, eliminate
from ..module import guards
from ..source import Layout, Program, expression, importing, used
from ..tape import FLOW
from .text import at, choose, fetch, function, lanes, rotation, stage

HEADER = '''"""Generated from the equations, for eight trajectories at once; do not edit."""
from math import cos, sin, sqrt, tanh

from jointplay.solver.method.interface import inner
from jointplay.solver.method.lanes.lanewise import lanewise
from jointplay.solver.method.interface import compiled

'''

NONE = Integer(0)


def text(system: System) -> str:
    """Source of the module of a system (of a structure that is `known`)."""
    laid, phases = laid_out(system)
    system = replace(
        laid, resets=()
    )  # where a state jumps, the loop lets the structure's own functions do so
    gaps = {4 * len(system.contacts) + k: each.guard for k, each in enumerate(laid.resets)}
    writer, dynamics = Writer(system, phases), Dynamics(system, "touch")
    bodies = [*_rates(writer, dynamics, gaps), _slopes(writer, "slopes", dynamics)]
    sticks = bool(writer.sticking)
    if sticks:
        bodies += [_rate_held(writer, dynamics), _slopes(writer, "slopes_held", Dynamics(system, "stick"))]
        bodies += [writer.sticks(), writer.held_rates()]
    bodies.append(writer.prepare())
    watched = [*range(4 * len(system.contacts)), *gaps, *(rows.FOLD + k for k in range(len(system.folds)))]
    bodies += _functions(len(system.positions), watched, sticks)
    size = f"ROWS = {writer.first + len(writer.constants)}\n"
    size += f"PHASES = {[angle.name for angle in system.angles[:phases]]!r}\n"
    return importing(HEADER + size + "\n\n" + "\n\n\n".join(bodies) + "\n")


class Writer:
    """Bodies of one structure, whose first positions are so many `phases`.

    `constants` are rows of what parameters alone make, `sticking` contacts that may stick.
    """

    def __init__(self, system: System, phases: int):
        self.system, self.layout, self.phases = system, Layout(system), phases
        self.constants: dict[Expr, int] = {}
        self.first = rows.NUMBERS + len(system.parameters)
        self.sticking = [j for j, contact in enumerate(system.contacts) if contact.sticks]

    def body(self, name: str, program: Program, stores: dict[int, str], j: int | None = None) -> str:
        """A function that stores values in rows: of the point X, Y, or of stage j.

        What is `held_` is of lanes where a contact sticks: others keep what is there.
        """
        program, lines = self._hoisted(program)
        place = at if j is None else _named
        lines += [] if j is None else fetch(len(self.system.positions), j, _named)
        lines += self._point(program, place)
        lines += [f"{symbol} = {expression(value)}" for symbol, value in program]
        for row, value in stores.items():
            held = value.startswith("held_")
            lines += choose(at(row), value, f"{self._stuck()} > 0.0") if held else [f"{at(row)} = {value}"]
        return _inner(name, lanes(*lines))

    def _hoisted(self, program: Program) -> tuple[Program, list[str]]:
        """The program without values of parameters alone, and the lines that load these."""
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

    def _point(self, program: Program, place: Callable[[int, int], str] = at) -> list[str]:
        """Parameters, masks and the state that a program reads, X and Y from their `place`."""
        system = self.system
        places = {s: at(rows.NUMBERS, k) for k, s in enumerate(system.parameters)}
        places |= {s: at(rows.MASK, k) for s, k in self.layout.masks.items()}
        n = len(system.positions)
        places |= {s: place(rows.Y, k) for k, s in enumerate(system.speeds[:n])}
        places |= {s: at(rows.MEMORY, k) for k, s in enumerate(system.speeds[n:])}
        moved = enumerate(system.positions)
        places |= {s: f"{at(rows.POSITION, k)} + {place(rows.X, k)}" for k, s in moved}
        places |= {s: at(rows.RATE, k) for k, s in enumerate(_slipped(system))}
        lines = [f"{s} = {places[s]}" for s in used(program, places)]
        for angle in system.angles:
            if used(program, (angle.sin, angle.cos)):
                k = system.positions.index(angle.position)
                lines += rotation(angle.sin, angle.cos, k, place(rows.X, k), k < self.phases)
        return lines

    def prepare(self) -> str:
        """Subexpressions of parameters alone."""
        lines = self._point([(Symbol("constant"), value) for value in self.constants])
        lines += [f"{at(self.first, k)} = {expression(value)}" for value, k in self.constants.items()]
        return function("prepare", lanes(*(lines or ["pass"])))

    def _stuck(self) -> str:
        """Text for the number of contacts that stick in a lane."""
        return " + ".join(at(rows.MASK, 3 * j + 2) for j in self.sticking)

    def sticks(self) -> str:
        """A function that says whether any contact sticks in any lane."""
        each = f"        most = max(most, {self._stuck()})"  # which no function of one lane can tell
        lines = ["    most = 0.0", "    for i in range(0, 8):", each, "    return most > 0.0"]
        return _inner("sticks", lines)

    def held_rates(self) -> str:
        """A function that goes over the stages' rates and cones again, for lanes where a contact sticks."""
        n, lines = len(self.system.positions), []
        for j in range(STAGES):
            found = {stage(rows.F, j, k): (at(rows.RATE, k), f"{at(rows.H)} * ") for k in range(n)}
            slipped = [f"{rate} = {place} / {at(rows.H)}" for place, (rate, _) in found.items()]
            cones = [4 * c + CONE for c in self.sticking]
            watches = rows.WATCHES + rows.GUARDS * j
            found |= {at(watches, g): (at(rows.WATCHED, g), "") for g in cones}
            chosen = [f"stuck = {self._stuck()}"]
            for place, (value, factor) in found.items():
                chosen += choose(place, factor + value, "stuck > 0.0")
            lines += [*lanes(*fetch(n, j), *slipped), "    rate_held(w)", *lanes(*chosen)]
        return _inner("rates_held", lines)


def _inner(name: str, lines: list[str]) -> str:
    """A function that others of the module call."""
    return function(name, lines, "@inner")


def _named(row: int, k: int) -> str:
    """Name of a row's value, where it need not be stored."""
    return f"row_{row + k}"


def _slipped(system: System) -> list[Symbol]:
    """Accelerations by the equations of slip."""
    return [Symbol(f"slipped_{k}", real=True) for k in range(len(system.positions))]


def _rates(writer: Writer, dynamics: Dynamics, gaps: dict[int, Expr]) -> list[str]:
    """Accelerations and guards (codegen.module.guards), `gaps` of jumps: at a point, at each stage."""
    watched = dict(gaps)
    watched |= {rows.FOLD + k: fold for k, fold in enumerate(dynamics.system.folds)}
    for j, contact in enumerate(dynamics.system.contacts):
        more = {FORCE: contact.pressed, CONE: Integer(0)} if contact.sticks else {}
        watched |= {4 * j + g: value for g, value in (guards(dynamics, j, "slip") | more).items()}
    found = {f"out_a{k}": a for k, a in enumerate(dynamics.a)}
    program = dynamics.tape.program(found | {f"out_g{g}": value for g, value in watched.items()})
    stores = {rows.RATE + k: name for k, name in enumerate(found)}
    bodies = [writer.body("rate", program, stores | {rows.WATCHED + g: f"out_g{g}" for g in watched})]
    for j in range(STAGES):
        stores = {rows.F + rows.N * j + k: f"{at(rows.H)} * {name}" for k, name in enumerate(found)}
        stores |= {rows.WATCHES + rows.GUARDS * j + g: f"out_g{g}" for g in watched}
        bodies.append(writer.body(f"rate_{j}", program, stores, j))
    return bodies


def _rate_held(writer: Writer, dynamics: Dynamics) -> str:
    """Accelerations and cones where contacts stick, by the accelerations that are found without that."""
    system, tape, slipped = dynamics.system, dynamics.tape, _slipped(dynamics.system)
    contacts = [system.contacts[j] for j in writer.sticking]
    lone = len(system.contacts) == 1
    masks = [Integer(1) if lone else Symbol(f"stick_{contact.name}", real=True) for contact in contacts]
    rows_T = [contact.tangential[: len(slipped)] for contact in contacts]
    Y = [  # of the speeds alone: no force moves what laws remember
        dynamics.inverse_mass(list(system.contacts[j].tangential), f"column{j}")[: len(slipped)]
        for j in writer.sticking
    ]
    TY, creep, pushes = [], [], [dynamics.F_n[j] for j in writer.sticking]
    for i, (mask, contact, T) in enumerate(zip(masks, contacts, rows_T, strict=True)):
        drift = tape.derivative(contact.v_t, FLOW) + contact.drift  # what of v_t' needs no acceleration
        creep.append(tape.let(f"creep{i}", mask * (dot(T, slipped) + drift)))
        ease = eased(tape, contacts, i, masks, pushes, dot(T, Y[i]))
        entries = [mask * (dot(T, y) + ease.get(j, 0)) + (1 - mask) * int(i == j) for j, y in enumerate(Y)]
        TY.append([tape.let(f"TY{i}_{j}", entry) for j, entry in enumerate(entries)])
    a, results = slipped, {}
    for j, y, dF in zip(writer.sticking, Y, eliminate(tape, TY, creep, "dF"), strict=True):
        a = [value - entry * dF for value, entry in zip(a, y, strict=True)]
        contact = system.contacts[j]
        cone = (contact.limit * dynamics.F_n[j]) ** 2 - (contact.drag + dF) ** 2
        results[rows.WATCHED + 4 * j + CONE] = cone
    results |= {rows.RATE + k: value for k, value in enumerate(a)}
    program = tape.program({f"held_out_{row}": value for row, value in results.items()})
    return writer.body("rate_held", program, {row: f"held_out_{row}" for row in results})


def _slopes(writer: Writer, name: str, dynamics: Dynamics) -> str:
    """d rate / d state; of `slopes_held` where contacts stick."""
    n, found = len(writer.system.positions), dynamics.jacobian()
    prefix, shift = "held_out_" if name == "slopes_held" else "out_", rows.N - n  # of the speeds' columns
    pairs = [(k, i) for k in range(n) for i in range(2 * n)]
    places = {pair: rows.JACOBIAN + 2 * rows.N * pair[0] + pair[1] + shift * (pair[1] >= n) for pair in pairs}
    program = dynamics.tape.program(
        {f"{prefix}{places[pair]}": found.get(pair, Integer(0)) for pair in pairs}
    )
    return writer.body(name, program, {row: f"{prefix}{row}" for row in places.values()})


def _functions(n: int, watched: list[int], sticks: bool) -> list[str]:
    """Functions that the loop calls: rates and slopes at the points of a step."""
    here = [f"{at(rows.X, k)} = 0.0" for k in range(n)]
    here += [f"{at(rows.Y, k)} = {at(rows.SPEED, k)}" for k in range(n)]
    taken = [f"fresh = {at(rows.NEW)}"]
    for k in range(n):
        taken += choose(at(rows.ACCELERATION, k), at(rows.RATE, k), "fresh > 0.0")
    for g in watched:
        taken += choose(at(rows.GUARD, g), at(rows.WATCHED, g), "fresh > 0.0")

    def whole(name: str) -> list[str]:
        return ["    if sticks(w):", f"        {name}_held(w)"] * sticks

    rate = ["    rate(w)", *whole("rate")]
    return [
        function("jacobian", ["    slopes(w)", *whole("slopes")]),
        function("rates", [*(f"    rate_{j}(w)" for j in range(STAGES)), *whole("rates")]),
        function("finish", [*lanes(*fetch(n, STAGES - 1)), *rate]),
        function("base", [*lanes(*here), *rate, *lanes(*taken, f"{at(rows.NEW)} = 0.0")]),
    ]


def laid_out(system: System) -> tuple[System, int]:
    """The system as lanes follow it, and the number of its phases, which come before its positions.

    Lanes follow positions, each with a speed. A phase of the forcing is an angle that turns at a speed which
    stays, so that a section at a phase is one at an angle; time is the first phase over its speed, or that of
    a clock. A state of first order is the speed of a position on which nothing depends. A linkage has this
    form already, but for a crank whose speed is imposed.
    """
    turning = tuple(angle for angle in system.angles if angle.position is not None)
    angles = tuple(angle for angle in system.angles if angle.position is None)
    if turning and not angles:
        return system, 0
    if not turning and (not angles or angles[0].name != "phase"):
        angles = (Angle(CLOCK), *angles)
    turned = [
        replace(a, position=Symbol(f"turn_{a.name}", real=True), rate=NONE, offset=NONE) for a in angles
    ]
    turns = tuple(angle.position for angle in turned)
    rates = tuple(Symbol(f"rate_{angle.name}", real=True) for angle in angles)
    first, still = len(turns), (NONE,) * len(turns)
    summed = () if turning else system.speeds[len(system.positions) :]  # else a law remembers them
    unused = tuple(Symbol(f"sum_{z}", real=True) for z in summed)
    time = {TIME: turns[0] / rates[0]}

    def moved(contact: Contact) -> Contact:
        names = ("u", "v_n", "F_n", "v_t", "coulomb", "limit")
        given = {name: getattr(contact, name) for name in names}
        given = {name: value.xreplace(time) for name, value in given.items() if value is not None}
        rows = {name: getattr(contact, name) for name in ("normal", "tangential")}
        return replace(contact, **given, **{name: (*still, *row) for name, row in rows.items() if row})

    mass = {(i + first, j + first): m.xreplace(time) for (i, j), m in (system.mass or {}).items()}
    laid = replace(
        system,
        positions=(*turns, *system.positions, *unused),
        speeds=(*rates, *system.speeds),
        mass=mass | {(k, k): Integer(1) for k in range(first)} if mass else None,
        force=(*still, *(value.xreplace(time) for value in system.force)),
        angles=(*turned, *turning),
        contacts=tuple(map(moved, system.contacts)),
        resets=tuple(
            replace(each, guard=each.guard.xreplace(time), met=each.gap.xreplace(time))
            for each in system.resets
        ),
    )
    return laid, first
