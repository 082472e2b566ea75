"""Derivatives of a structure's functions, for the flow of tangents: a module of its own.

variation(variant, w, s, p, m)    d rate / d state of eight increments, into rows of w behind the structure's
vary(w, d)                        rates of a tangent: those derivatives times (d + its increments)
divergence(w)                     trace of d rate / d speeds, into the last row of w
gradient(guard, s, p, m, out)     d guard / d (time, state) at the base point; guards as in the lane rows,
                                  those of resets last; then, of walls that `resets.pushes` names, by fours:
                                  the gap's rate, that times r, v_t, the friction coefficient
reset_slopes(k, s, p, out)        d (new speeds) / d (time, state) of the k-th reset, row by row; beyond the
                                  last, of coming to rest on the walls; then of contacts that a law remembers,
                                  and of unit impulses
ROWS                              rows of w: the structure's own, then those of its derivatives

Only models that ask for tangents have it written and compiled. Of few unknowns the rows hold d rate / d state
itself; of many (codegen.elimination) the residual's B = d (Q - M a) / d state and the factors of
M = L D L^T, and rates are M^-1 B times a tangent.

Of a system with directions (equations.system.directed) a tangent d can be that of a state as numbers change
along the j-th, counted from 1: d[0] = j, and 0 of any other tangent. Then

    vary          adds d rate / d direction, and writes the rates of the works into the rows before the last
    gradient      has d guard / d direction at the end, one number for each
    reset_slopes  has at the end, for each direction, d (new positions) where it rests on a wall (else 0), and
                  d (new speeds); then, where there are powers, d (the drive's work) / d (time, state,
                  directions)
"""

from collections.abc import Iterator

from sympy import Expr, Integer, Symbol

from ..equations.system import TIME, System, directed
from .dynamics import Dynamics
from .module import HEADER, pressed
from .resets import drive_work, jumped, pushed, pushes, remembered, settled
from .source import LANES, Layout, dispatch, entry, importing, lanes, point
from .variants import sticking, variants

Entries = dict[tuple[int, int], Expr]


def text(system: System, method: int, planned: bool, directions: tuple[tuple[str, ...], ...] = ()) -> str:
    """Source of the module of a system; `method` rows of w are the method's own, as in its structure's."""
    system = directed(system, directions) if directions else system
    layout, names = Layout(system, method), variants(system)
    solved = {name: Dynamics(system, name) for name in names}
    entries = {name: _residual(each) if planned else each.jacobian() for name, each in solved.items()}
    entries = {name: found | _powers(solved[name]) for name, found in entries.items()}
    factors = solved[names[0]].inverse_mass if planned else None
    rows = _Rows(
        layout, sorted({p for found in entries.values() for p, v in found.items() if v != 0}), factors
    )
    parts = [HEADER, f"ROWS = {rows.end}\n\n"]
    parts += ["@compiled\n" + _variation(rows, solved[name], name, entries[name]) + "\n" for name in names]
    parts.append(
        dispatch("variation", "variant, w, s, p, m", {k: f"variation_{name}" for k, name in enumerate(names)})
    )
    parts += [_vary(rows), _divergence(rows)]
    gradients = dict(_gradients(layout))
    parts += gradients.values()
    parts.append(dispatch("gradient", "guard, s, p, m, out", {g: f"gradient_{g}" for g in gradients}))
    jumps = [
        k for k in range(2 * len(system.resets)) if k >= len(system.resets) or not system.resets[k].rough
    ]
    jumps += [*remembered(system), *pushes(system)]
    parts += [_reset_slopes(layout, k) for k in jumps]
    parts.append(dispatch("reset_slopes", "k, s, p, out", {k: f"reset_slopes_{k}" for k in jumps}))
    return importing("\n".join(parts))


def _residual(dynamics: Dynamics) -> Entries:
    """d (Q - M a)_k / d x_i, positions and then speeds."""
    by_position, by_speed = dynamics.residual_jacobian()
    shift = len(dynamics.system.positions)
    return by_position | {(k, shift + i): value for (k, i), value in by_speed.items()}


def _powers(dynamics: Dynamics) -> Entries:
    """d power / d x_i behind the rates' derivatives, where there are directions."""
    system, tape = dynamics.system, dynamics.tape
    if not system.directions:
        return {}
    powers = enumerate(system.powers.values(), start=len(system.speeds))
    pairs = ((k, i, power, x) for k, power in powers for i, x in enumerate(dynamics.variables))
    return {(k, i): tape.let(f"dP_{k}_{i}", tape.derivative(power, x)) for k, i, power, x in pairs}


class _Rows:
    """Rows of w behind the structure's own: entries d / d x_i by (k, i), factors of M, powers, divergence."""

    def __init__(self, layout: Layout, entries: list[tuple[int, int]], factors):
        self.layout, self.entries, self.factors = layout, entries, factors
        self.n, self.n_x = len(layout.system.speeds), len(layout.state)
        self.begin = layout.rows["end"]
        self.width = self.n_x + len(layout.system.directions)
        self.powers = range(self.n, self.n + len(layout.system.powers) * (self.width > self.n_x))
        count = self.begin + self.powers.stop * self.width
        self.L, self.pivot = {}, {}
        if factors is not None:
            self.L = {place: count + k for k, place in enumerate(sorted(factors.L))}
            scaled = [k for k, v in enumerate(factors.pivot) if v != 1]
            self.pivot = {k: count + len(self.L) + place for place, k in enumerate(scaled)}
        self.divergence = count + len(self.L) + len(self.pivot) + len(self.powers)
        self.end = self.divergence + 1

    def entry(self, k: int, i: int) -> int:
        """Row of d / d x_i of the k-th rate (or residual), or power."""
        return self.begin + k * self.width + i

    def varied(self, k: int) -> int:
        """Row of a tangent's k-th rate, or power."""
        return self.layout.rows["rate"] + k if k < self.n else self.divergence - self.powers.stop + k

    def solved(self) -> list[str]:
        """Lane statements: r_0 … r_n become M^-1 r; none where the entries are rates already."""
        lines = [f"r_{i} -= {_at(row)} * r_{j}" for (i, j), row in sorted(self.L.items())]
        lines += [f"r_{k} *= {_at(row)}" for k, row in self.pivot.items()]
        return lines + [
            f"r_{j} -= {_at(row)} * r_{i}" for (i, j), row in sorted(self.L.items(), reverse=True)
        ]


def _at(row: int) -> str:
    return f"w[{8 * row} + i]"


def _variation(rows: _Rows, dynamics: Dynamics, name: str, found: Entries) -> str:
    results = {f"J_{k}_{i}": found.get((k, i), Integer(0)) for k, i in rows.entries}
    stores = {f"J_{k}_{i}": rows.entry(k, i) for k, i in rows.entries}
    for (i, j), row in rows.L.items():
        results[f"L_{i}_{j}_out"], stores[f"L_{i}_{j}_out"] = dynamics.inverse_mass.L[i, j], row
    for k, row in rows.pivot.items():
        results[f"D_{k}_out"], stores[f"D_{k}_out"] = dynamics.inverse_mass.pivot[k], row
    return lanes(f"variation_{name}", rows.layout, dynamics.tape.program(results), stores)


def _vary(rows: _Rows) -> str:
    """Rates of a tangent, the zeros of every variant left out."""
    columns, state = sorted({i for _, i in rows.entries if i < rows.n_x}), rows.layout.rows["state"]
    body, written = [f"x_{i} = d_{i} + {_at(state + i)}" for i in columns], range(rows.powers.stop)
    for k in written:
        terms = [f"{_at(rows.entry(k, i))} * x_{i}" for kk, i in rows.entries if kk == k and i < rows.n_x]
        body.append(f"r_{k} = {' + '.join(terms) or '0.0'}")
    driven = rows.width > rows.n_x
    body += [] if driven else rows.solved()
    body += [f"{_at(rows.varied(k))} = r_{k}" for k in written]
    text = _lane_function("vary", "w, d", [f"d_{i} = d[{1 + i}]" for i in columns], body)
    return text.rstrip() + "\n" + "\n".join(_driven(rows)) + "\n\n" if driven else text


def _driven(rows: _Rows) -> list[str]:
    """Lines that add a direction's driven terms: a loop for each, so that places in w are known."""
    lines = []
    for i in range(rows.n_x, rows.width):
        pairs = [(rows.varied(k), rows.entry(k, i)) for k, ii in rows.entries if ii == i]
        body = [f"            {_at(to)} += {_at(row)}" for to, row in pairs]
        if body:
            lines += [f"    if d[0] == {i - rows.n_x + 1}.0:", f"        for i in range({LANES}):", *body]
    if rows.factors is not None:
        body = [f"r_{k} = {_at(rows.varied(k))}" for k in range(rows.n)] + rows.solved()
        body += [f"{_at(rows.varied(k))} = r_{k}" for k in range(rows.n)]
        lines += [f"    for i in range({LANES}):", *(f"        {line}" for line in body)]
    return lines


def _divergence(rows: _Rows) -> str:
    """Trace: of the rates' entries; or, column by column, of M^-1 B."""
    shift, total = rows.n_x - rows.n, _at(rows.divergence)
    diagonal = [_at(rows.entry(k, shift + k)) for k in range(rows.n) if (k, shift + k) in rows.entries]
    if rows.factors is None:
        return _lane_function("divergence", "w", [], [f"{total} = {' + '.join(diagonal) or '0.0'}"])
    rate = rows.layout.rows["rate"]
    body = [f"r_{k} = w[{8 * rows.entry(k, shift)} + 8 * c + i]" for k in range(rows.n)]
    body += rows.solved()
    body += [f"{_at(rate + k)} = r_{k}" for k in range(rows.n)]
    body.append(f"{total} += w[{8 * rate} + 8 * c + i]")
    lines = [*entry("divergence", "w"), f"    for i in range({LANES}):", f"        {total} = 0.0"]
    lines += [f"    for c in range({rows.n}):"]
    lines += [f"        for i in range({LANES}):", *(f"            {line}" for line in body)]
    return "\n".join(lines) + "\n\n"


def _lane_function(name: str, arguments: str, head: list[str], body: list[str]) -> str:
    lines = [*entry(name, arguments), *(f"    {line}" for line in head), f"    for i in range({LANES}):"]
    return "\n".join([*lines, *(f"        {line}" for line in body)]) + "\n\n"


def _gradients(layout: Layout) -> Iterator[tuple[int, str]]:
    """Number and function of every guard."""
    system = layout.system
    for j, contact in enumerate(system.contacts):
        gap = contact.u if contact.gap is None else contact.gap
        plain = {0: gap, 1: contact.pressed} | ({2: contact.v_t} if contact.sticks else {})
        for place, value in plain.items():
            yield 4 * j + place, _gradient(layout, 4 * j + place, value)
        if contact.sticks:
            yield 4 * j + 3, _cone(layout, j)
    for k in range(len(system.resets)):
        yield 4 * len(system.contacts) + k, _wall(layout, k)
    first = 4 * len(system.contacts) + len(system.resets)
    for k in range(system.rubs):
        if system.resets[k].rough:
            yield first + k, _rub(layout, first + k, k)
    for k in dict.fromkeys(k for k, _ in pushes(system).values()):
        for place in range(4 if system.resets[k].rough else 2):
            g = first + system.rubs + 4 * k + place
            yield g, _met(layout, g, k, place)


def _met(layout: Layout, g: int, k: int, place: int) -> str:
    """Gradient of a number on which impulses on the k-th wall depend."""
    dynamics, wall = Dynamics(layout.system, "free"), layout.system.resets[k]
    rate = dynamics.contacts[len(layout.system.contacts) + k].v_t
    value = (rate, wall.restitution * rate, wall.v_t, wall.coulomb)[place]
    slopes = _slopes(layout, dynamics.tape, value)
    return _at_point(layout, f"gradient_{g}", "s, p, m, out", "out", dynamics.tape, slopes)


def _variables(layout: Layout) -> tuple[Symbol, ...]:
    return (TIME, *layout.state, *layout.system.directions)


def _gradient(layout: Layout, g: int, value: Expr) -> str:
    tape = Dynamics(layout.system, variants(layout.system)[-1]).tape
    return _at_point(layout, f"gradient_{g}", "s, p, m, out", "out", tape, _slopes(layout, tape, value))


def _slopes(layout: Layout, tape, value: Expr) -> list[Expr]:
    return [tape.derivative(value, x) for x in _variables(layout)]


def _cone(layout: Layout, j: int) -> str:
    """(f_s F_n)^2 - F_t^2 while contact j sticks: the slope of F_t is solved for."""
    dynamics = Dynamics(layout.system, "stick")
    tape, f = dynamics.tape, layout.system.contacts[j].limit
    normal, limits = (_slopes(layout, tape, value) for value in (dynamics.F_n[j], f))
    held = dynamics.held_slopes(_variables(layout))
    slopes = [
        2 * f**2 * dynamics.F_n[j] * slope - 2 * dynamics.F_t[j] * held.get((j, i), Integer(0))
        for i, slope in enumerate(normal)
    ]
    for i in range(1 + len(layout.state), len(slopes)):
        slopes[i] += 2 * f * dynamics.F_n[j] ** 2 * limits[i]
    return _at_point(layout, f"gradient_{4 * j + 3}", "s, p, m, out", "out", tape, slopes)


def _wall(layout: Layout, k: int) -> str:
    """Gradient of the k-th reset's guard: of its gap; while the wall holds, of its push."""
    dynamics = Dynamics(layout.system, variants(layout.system)[-1])
    j = len(layout.system.contacts) + k
    gap = _slopes(layout, dynamics.tape, layout.system.resets[k].guard)
    force, held = dynamics.held_slopes(_variables(layout)), dynamics.masks[j].stick
    slopes = [(1 - held) * slope - held * force.get((j, i), Integer(0)) for i, slope in enumerate(gap)]
    g = 4 * len(layout.system.contacts) + k
    return _at_point(layout, f"gradient_{g}", "s, p, m, out", "out", dynamics.tape, slopes)


def _rub(layout: Layout, g: int, k: int) -> str:
    """v_t at the k-th reset, a rough wall; while a body sticks to it, the cone of its guide."""
    dynamics, first = Dynamics(layout.system, "stick"), len(layout.system.contacts)
    tape, resets, wall = dynamics.tape, layout.system.resets, layout.system.resets[k]
    slip, limits = (_slopes(layout, tape, value) for value in (wall.v_t, wall.coulomb))
    rub, push = dynamics.rub(wall), pressed(dynamics, wall)
    forces, stick, f = dynamics.held_slopes(_variables(layout)), sticking(wall), wall.coulomb
    walls = [
        (first + resets.index(each), sticking(each)) for each in dynamics.guides[rub - first - len(resets)]
    ]
    slopes = []
    for i, (slide, limit) in enumerate(zip(slip, limits, strict=True)):
        more = sum((-share * forces.get((j, i), Integer(0)) for j, share in walls), Integer(0))
        edge = 2 * f * push * (f * more + limit * push) - 2 * dynamics.F_t[rub] * forces.get((rub, i), 0)
        slopes.append(stick * edge + (1 - stick) * slide)
    return _at_point(layout, f"gradient_{g}", "s, p, m, out", "out", tape, slopes)


def _reset_slopes(layout: Layout, k: int) -> str:
    dynamics, resets = Dynamics(layout.system, "free"), layout.system.resets
    tape = dynamics.tape
    if k in pushes(layout.system):
        jump = pushed(dynamics, *pushes(layout.system)[k])
    elif k >= 2 * len(resets):
        jump = remembered(layout.system)[k]
    else:
        jump = jumped(dynamics, k) if k < len(resets) else settled(dynamics, k - len(resets))
    new = [jump.get(z, z) for z in layout.system.speeds]
    slopes = [tape.derivative(value, x) for value in new for x in (TIME, *layout.state)]
    new = [jump.get(q, q) for q in layout.system.positions] + new
    slopes += [tape.derivative(value, x) for x in layout.system.directions for value in new]
    if layout.system.directions and layout.system.powers:
        slopes += _slopes(layout, tape, drive_work(dynamics, k))
    return _at_point(layout, f"reset_slopes_{k}", "s, p, out", "out", tape, slopes)


def _at_point(layout: Layout, name: str, arguments: str, out: str, tape, values: list[Expr]) -> str:
    """A function that writes values at the base point to places 0, 1, … of an array."""
    program = tape.program({f"out_{i}": value for i, value in enumerate(values)})
    stores = {f"out_{i}": i for i in range(len(values))}
    return "@compiled\n" + point(name, layout, program, stores, arguments, out) + "\n"
