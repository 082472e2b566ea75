"""The text of a structure's module: everything that the flow needs of a system, as numba source.

rate(variant, w, s, p, m)         rates, guards, resets, section, powers of eight increments, into w
jacobian(variant, s, p, m, J)     d rate / d state at the base point, row by row; of many unknowns, the values
                                  of a plan, whose algebra then stands here too (codegen.elimination)
contacts(variant, s, p, m, out)   six numbers a contact: u, v_n, v_t, F_n (the law's; or what has its sign),
                                  F_t, v_t'; then of each reset: gap, inverse of the mass that an impact
                                  meets (0: of no account; below 0: there is no wall, the state jumps), the
                                  gap's rate, the drive's work per impulse (0 where none is wanted), F_t, the
                                  rate's own rate (codegen.variants); then, where walls are rough, of each
                                  reset: friction coefficient, restitution, v_t, the drive's work per impulse
                                  along T, friction, v_t'
trig(s, p)                        sines and cosines of the base point
reset(k, s, p)                    the jump of the k-th reset; beyond the last, coming to rest on the walls;
                                  beyond these, contacts that a law remembers: beginnings, then ends; last,
                                  unit impulses along N, then along T, on walls that `resets.pushes` names
CONTACTS, RESETS                  their names; of a contact with its flags (method.modes)
OUTPUTS, ABRUPT, PROGRAM          recorded quantities (codegen.outputs)
"""

import re

from sympy import Expr, Integer

from ..equations.system import Reset, System
from ..method.modes import (
    CONE,
    FORCE,
    FORCELESS,
    GAP,
    IN_FLIGHT,
    PULLS,
    REMEMBERS,
    SHARES,
    SLIDE,
    SLIPPING,
    STICKS,
    SWITCHES,
)
from . import elimination, outputs, resets
from .dynamics import Dynamics
from .source import Layout, entry, importing, lanes, point, statements, used
from .variants import sticking, variants

HEADER = '''"""Generated from the equations; do not edit."""
from math import cos, sin, sqrt, tanh

from jointplay.solver.method.interface import compiled

'''


def text(system: System) -> str:
    """Source of the module of a system."""
    solved = {variant: Dynamics(system, variant) for variant in variants(system)}
    large = len(system.speeds) > elimination.LARGEST_DENSE
    plans = [elimination.Plan.of(dynamics) for dynamics in solved.values()] if large else []
    layout = Layout(system, max((each.rows for each in plans), default=0))
    parts = [HEADER, f"SIZES = {_sizes(layout, plans)!r}", _names(system)]
    rates, jacobians, contacts = [], [], []
    for v, (variant, dynamics) in enumerate(solved.items()):
        rates.append(_rate(layout, dynamics, variant))
        if variant != "free":
            contacts.append(_contacts(layout, dynamics, variant))
        entries = dict(enumerate(plans[v].values)) if large else _dense(layout, dynamics)
        jacobians.append(_jacobian(layout, dynamics, variant, entries))
    parts += [_choice("rate", "w, s, p, m", rates), _choice("jacobian", "s, p, m, J", jacobians)]
    parts += [
        _choice("contacts", "s, p, m, out", contacts, first=SLIPPING),
        _trig(layout),
        resets.text(layout),
    ]
    if large:
        parts.append(elimination.text(plans, len(system.positions), layout.rows["time"]))
    parts.append(outputs.text(system))
    return importing("\n".join(parts))


def _sizes(layout: Layout, plans: list[elimination.Plan]) -> dict[str, int]:
    system = layout.system
    return {
        "positions": len(system.positions),
        "speeds": len(system.speeds),
        "angles": len(system.angles),
        "contacts": len(system.contacts),
        "resets": len(system.resets),
        "rubs": system.rubs,
        "bends": int(system.bends),
        "folds": len(system.folds),
        "sections": int(system.section is not None),
        "powers": len(system.powers),
        "first": layout.rows["time"],
        "guards": layout.rows["guard"],
        "rows": layout.rows["end"],
        "planned": int(bool(plans)),
        "jacobian": max((len(each.values) for each in plans), default=len(system.speeds) * len(layout.state)),
    }


def _names(system: System) -> str:
    flags = {
        c.name: PULLS * c.pulls
        + STICKS * c.sticks
        + REMEMBERS * bool(c.entry)
        + SHARES * (c.sticks and bool(c.face))
        + SWITCHES * bool(c.acts_along)
        + FORCELESS * (not c.sticks and not any(c.normal))
        for c in system.contacts
    }
    return f"CONTACTS = {flags!r}\nRESETS = {[reset.name for reset in system.resets]!r}\n\n"


def _rate(layout: Layout, dynamics: Dynamics, variant: str) -> str:
    """Rates and all else that is watched, by lanes."""
    system, rows = layout.system, layout.rows
    results, stores = {}, {}

    def store(name, value, row):
        results[name], stores[name] = value, row

    for k, a in enumerate(dynamics.a):
        store(f"out_rate_{k}", a, rows["rate"] + k)
    for k, fold in enumerate(system.folds):
        store(f"out_fold_{k}", fold, rows["fold"] + k)
    for j in range(len(system.contacts)):
        for place, value in guards(dynamics, j, variant).items():
            store(f"out_guard_{j}_{place}", value, rows["guard"] + 4 * j + place)
    for k in range(len(system.resets)):
        store(f"out_reset_{k}", watched(dynamics, k), rows["reset"] + k)
    for k in range(system.rubs):
        store(f"out_rub_{k}", rubbed(dynamics, k), rows["rub"] + k)
    if system.section is not None:
        store("out_section", system.section, rows["section"])
    for k, power in enumerate(system.powers.values()):
        store(f"out_power_{k}", power, rows["power"] + k)
    return lanes(f"rate_{variant}", layout, dynamics.tape.program(results), stores)


def guards(dynamics: Dynamics, j: int, variant: str) -> dict[int, Expr]:
    """Guards of a contact: gap or u, the law's F_n or its sign, v_t, the cone (f_s F_n)^2 - F_t^2.

    Of a switch that slides, in the place of F_n what its force takes off v_t' (method.modes).
    """
    contact = dynamics.system.contacts[j]
    found = {GAP: contact.u if contact.gap is None else contact.gap}
    if not contact.pulls or (contact.sticks and variant == "stick"):
        found[FORCE] = dynamics.restoring(j) if contact.acts_along else contact.pressed
    if contact.sticks and variant != "free":
        found[SLIDE] = contact.v_t
    if contact.sticks and variant == "stick":
        found[CONE] = (contact.limit * dynamics.F_n[j]) ** 2 - dynamics.F_t[j] ** 2
    return found


def watched(dynamics: Dynamics, k: int) -> Expr:
    """Guard of the k-th reset: its gap; while the wall holds, its push."""
    j, gap = len(dynamics.system.contacts) + k, dynamics.system.resets[k].guard
    held = dynamics.masks[j].stick
    return (1 - held) * gap - held * dynamics.F_t[j]


def rubbed(dynamics: Dynamics, k: int) -> Expr:
    """Guard of the k-th reset's friction: v_t, or the cone (f push)^2 - friction^2 while a body sticks."""
    wall = dynamics.system.resets[k]
    if not wall.rough or dynamics.variant == "free":
        return Integer(1)
    if dynamics.variant == "slip":
        return wall.v_t
    push, held = pressed(dynamics, wall), dynamics.F_t[dynamics.rub(wall)]
    return sticking(wall) * ((wall.coulomb * push) ** 2 - held**2) + (1 - sticking(wall)) * wall.v_t


def pressed(dynamics: Dynamics, wall: Reset) -> Expr:
    """Push on all walls of a guide to which a body sticks, as the rough wall is one of them."""
    resets, first = dynamics.system.resets, len(dynamics.system.contacts)
    guide = dynamics.guides[dynamics.rub(wall) - first - len(resets)]
    return sum((-sticking(each) * dynamics.F_t[first + resets.index(each)] for each in guide), Integer(0))


def _dense(layout: Layout, dynamics: Dynamics) -> dict[int, Expr]:
    """Every entry of d rate / d state, by place."""
    width, entries = len(layout.state), dynamics.jacobian()
    places = ((k, i) for k in range(len(dynamics.a)) for i in range(width))
    return {k * width + i: entries.get((k, i), Integer(0)) for k, i in places}


def _jacobian(layout: Layout, dynamics: Dynamics, variant: str, entries: dict[int, Expr]) -> str:
    results = {f"J_{place}": value for place, value in entries.items()}
    stores = {f"J_{place}": place for place in entries}
    return point(f"jacobian_{variant}", layout, dynamics.tape.program(results), stores, "s, p, m, J", "J")


def _contacts(layout: Layout, dynamics: Dynamics, variant: str) -> str:
    results, stores, last = {}, {}, len(layout.system.contacts)
    for k, wall in ((k, wall) for k, wall in enumerate(layout.system.resets) if wall.rough):
        creep = dynamics.slide(wall)
        drawn = resets.drawn(dynamics, k, across=True)
        values = (wall.coulomb, wall.restitution, wall.v_t, drawn, dynamics.friction(wall), creep)
        at = 6 * (last + len(layout.system.resets) + k)
        results |= {f"out_rub_{k}_{place}": value for place, value in enumerate(values)}
        stores |= {f"out_rub_{k}_{place}": at + place for place in range(6)}
    for j, contact in enumerate(dynamics.contacts[: last + len(layout.system.resets)]):
        v_t, creep = (contact.v_t, dynamics.creep(j)) if contact.v_t is not None else (Integer(0), Integer(0))
        u, v_n, pressed = (contact.u, contact.v_n, contact.pressed) if j < last else _met(dynamics, j - last)
        for place, value in enumerate((u, v_n, v_t, pressed, dynamics.F_t[j], creep)):
            results[f"out_{j}_{place}"], stores[f"out_{j}_{place}"] = value, 6 * j + place
    program = dynamics.tape.program(results)
    return point(f"contacts_{variant}", layout, program, stores, "s, p, m, out", "out")


def _met(dynamics: Dynamics, k: int) -> tuple[Expr, Expr, Expr]:
    """Gap of the k-th reset, the inverse N.M^-1 N of the mass that an impact meets, the drive's work."""
    reset = dynamics.system.resets[k]
    if reset.restitution is None:
        return reset.gap, Integer(-int(reset.moves)), Integer(0)
    return reset.gap, resets.impulse(dynamics, k)[1], resets.drawn(dynamics, k)


def _choice(name: str, arguments: str, functions: list[str], first: int = IN_FLIGHT) -> str:
    """A function of the variant that holds the bodies of several, from variant `first` on (a call costs)."""
    lines = entry(name, f"variant, {arguments}")
    for number, function in enumerate(functions, start=first):
        body = _renamed(function.rstrip(), number).split("\n")[1:]
        lines += [f"    if variant == {number}:", *(f"    {line}" for line in body)]
    return "\n".join(lines if functions else [*lines, "    pass"]) + "\n\n"


def _renamed(function: str, number: int) -> str:
    """Its local names with a number, so that none is assigned twice: such names cost time to compile."""
    names = set(re.findall(r"^ +(\w+) =", function, re.M))
    return re.sub(r"\b[^\W\d]\w*\b", lambda word: word[0] + f"__{number}" * (word[0] in names), function)


def _trig(layout: Layout) -> str:
    lines = entry("trig", "s, p")
    for angle in layout.system.angles:
        program = [(angle.sin, angle.value)]
        lines += [f"    {x} = s[{layout.base[x]}]" for x in used(program, layout.base)]
        for i, x in enumerate(layout.system.parameters):
            lines += [f"    {x} = p[{i}]"] if used(program, (x,)) else []
        lines += statements([(angle.sin, angle.value)], "    ")
        lines += [
            f"    s[{layout.base[angle.cos]}] = cos({angle.sin})",
            f"    s[{layout.base[angle.sin]}] = sin({angle.sin})",
        ]
    return "\n".join(lines if layout.system.angles else [*lines, "    pass"]) + "\n\n"
