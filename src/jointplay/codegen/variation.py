"""Derivatives of a structure's functions, for the flow of tangents: a module of its own.

variation(variant, w, s, p, m)    d rate / d state of eight increments, into rows of w behind the structure's
vary(w, d)                        rates of a tangent: those derivatives times (d + its increments)
gradient(guard, s, p, m, out)     d guard / d (time, state) at the base point; guards as in the lane rows,
                                  those of resets last
turned(k, s, p, out)              d (new speeds) / d (time, state) of the k-th reset, row by row

Only scenes that ask for tangents have it written and compiled. The lane buffer is laid out as the
structure's own, and longer by one row for each entry of d rate / d state.
"""

from collections.abc import Iterator

from sympy import Expr, Integer, Symbol

from ..equations.system import TIME, System
from .dynamics import Dynamics, variants
from .module import HEADER
from .source import LANES, Layout, lanes, point

Entries = dict[tuple[int, int], Expr]


def text(system: System, first: int) -> str:
    """Source of the module of a system whose lane rows begin, with that of time, at `first`."""
    layout = Layout(system, first)
    names = variants(system)
    entries, parts = set(), [HEADER]
    for name in names:
        dynamics = Dynamics(system, name)
        found = dynamics.jacobian()
        entries |= {place for place, value in found.items() if value != 0}
        parts.append("@compiled\n" + _variation(layout, dynamics, name, found) + "\n")
    parts.append(_choice("variation", "variant, w, s, p, m", [f"variation_{name}" for name in names]))
    parts.append(_vary(layout, sorted(entries)))
    gradients = list(_gradients(layout))
    parts += [code for _, code in gradients]
    parts.append(
        _choice("gradient", "guard, s, p, m, out", [f"gradient_{g}" for g, _ in gradients], gradients)
    )
    parts += [_turned(layout, k) for k in range(len(system.resets))]
    parts.append(_choice("turned", "k, s, p, out", [f"turned_{k}" for k in range(len(system.resets))]))
    return "\n".join(parts)


def _row(layout: Layout, k: int, i: int) -> int:
    """Lane row of d rate_k / d x_i."""
    return layout.rows["end"] + k * len(layout.state) + i


def _variation(layout: Layout, dynamics: Dynamics, name: str, found: Entries) -> str:
    places = [(k, i) for k in range(len(dynamics.a)) for i in range(len(layout.state))]
    results = {f"J_{k}_{i}": found.get((k, i), Integer(0)) for k, i in places}
    stores = {f"J_{k}_{i}": _row(layout, k, i) for k, i in places}
    return lanes(f"variation_{name}", layout, dynamics.tape.program(results), stores)


def _vary(layout: Layout, entries: list[tuple[int, int]]) -> str:
    """Rates of a tangent, the zeros of every variant left out."""
    state, rate, n = layout.rows["state"], layout.rows["rate"], len(layout.system.speeds)
    columns = sorted({i for _, i in entries})
    lines = ['@entry(SIGNATURES["vary"])', "def vary(w, d):", *(f"    d_{i} = d[{1 + i}]" for i in columns)]
    lines.append(f"    for i in range({LANES}):")
    lines += [f"        x_{i} = d_{i} + w[{8 * (state + i)} + i]" for i in columns]
    for k in range(n):
        terms = [f"w[{8 * _row(layout, k, i)} + i] * x_{i}" for kk, i in entries if kk == k]
        lines.append(f"        w[{8 * (rate + k)} + i] = {' + '.join(terms) or '0.0'}")
    return "\n".join(lines) + "\n\n"


def _gradients(layout: Layout) -> Iterator[tuple[int, str]]:
    """Number and function of every guard."""
    system = layout.system
    for j, contact in enumerate(system.contacts):
        gap = contact.u if contact.gap is None else contact.gap
        plain = {0: gap, 1: contact.F_n} | ({2: contact.v_t} if contact.sticks else {})
        for place, value in plain.items():
            yield 4 * j + place, _gradient(layout, 4 * j + place, value)
        if contact.sticks:
            yield 4 * j + 3, _cone(layout, j)
    for k, reset in enumerate(system.resets):
        g = 4 * len(system.contacts) + k
        yield g, _gradient(layout, g, reset.guard)


def _variables(layout: Layout) -> tuple[Symbol, ...]:
    return (TIME, *layout.state)


def _gradient(layout: Layout, g: int, value: Expr) -> str:
    tape = Dynamics(layout.system, variants(layout.system)[-1]).tape
    return _at_point(layout, f"gradient_{g}", "s, p, m, out", "out", tape, _slopes(layout, tape, value))


def _slopes(layout: Layout, tape, value: Expr) -> list[Expr]:
    return [tape.derivative(value, x) for x in _variables(layout)]


def _cone(layout: Layout, j: int) -> str:
    """(f F_n)^2 - F_t^2 while contact j sticks: the slope of F_t is solved for."""
    dynamics = Dynamics(layout.system, "stick")
    tape, f = dynamics.tape, layout.system.contacts[j].coulomb
    normal = _slopes(layout, tape, dynamics.F_n[j])
    _, held = dynamics.slopes(_variables(layout))
    slopes = [
        2 * f**2 * dynamics.F_n[j] * slope - 2 * dynamics.F_t[j] * held.get((j, i), Integer(0))
        for i, slope in enumerate(normal)
    ]
    return _at_point(layout, f"gradient_{4 * j + 3}", "s, p, m, out", "out", tape, slopes)


def _turned(layout: Layout, k: int) -> str:
    tape, jump = Dynamics(layout.system, "free").tape, layout.system.resets[k]
    new = [jump.speeds.get(z, z) for z in layout.system.speeds]
    slopes = [slope for value in new for slope in _slopes(layout, tape, value)]
    return _at_point(layout, f"turned_{k}", "s, p, out", "out", tape, slopes)


def _at_point(layout: Layout, name: str, arguments: str, out: str, tape, values: list[Expr]) -> str:
    """A function that writes values at the base point to places 0, 1, … of an array."""
    program = tape.program({f"out_{i}": value for i, value in enumerate(values)})
    stores = {f"out_{i}": i for i in range(len(values))}
    return "@compiled\n" + point(name, layout, program, stores, arguments, out) + "\n"


def _choice(name: str, arguments: str, functions: list[str], numbers: list | None = None) -> str:
    """A function that picks one of several by its first argument."""
    which, *rest = arguments.split(", ")
    numbers = [g for g, _ in numbers] if numbers is not None else range(len(functions))
    lines = [f'@entry(SIGNATURES["{name}"])', f"def {name}({arguments}):"]
    for number, function in zip(numbers, functions, strict=True):
        lines.append(f"    if {which} == {number}:\n        {function}({', '.join(rest)})")
    return "\n".join(lines if functions else [*lines, "    pass"]) + "\n\n"
