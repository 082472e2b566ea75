"""The text of a structure's module: everything that the flow asks of a system, as numba source.

rate(variant, w, s, p, m)         rates, guards, resets, section, powers of eight increments, into w
jacobian(variant, s, p, m, J)     d rate / d state at the base point, row by row; of many unknowns, the values
                                  of a plan, whose algebra then stands here too (codegen.plan)
contacts(variant, s, p, m, out)   six numbers a contact: u, v_n, v_t, F_n (the law's), F_t, v_t'
trig(s, p)                        sines and cosines of the base point
reset(k, s, p)                    the jump of the k-th reset
CONTACTS, RESETS                  their names; of a contact with the flags PULLS, STICKS
OUTPUTS, PROGRAM                  recorded quantities (codegen.outputs)
"""

import re

from sympy import Expr, Integer

from ..equations.system import System
from ..numerics.modes import PULLS, STICKS
from . import outputs, plan
from .dynamics import Dynamics, variants
from .source import Layout, lanes, point, statements, used

HEADER = '''"""Generated from the equations; do not edit."""
from math import cos, sin, sqrt, tanh

from jointplay.numerics.interface import SIGNATURES, compiled, entry

'''


def text(system: System) -> str:
    """Source of the module of a system."""
    solved = {variant: Dynamics(system, variant) for variant in variants(system)}
    large = len(system.speeds) > plan.LARGEST_DENSE
    plans = [plan.Plan.of(dynamics) for dynamics in solved.values()] if large else []
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
    parts += [_choice("contacts", "s, p, m, out", contacts, first=1), _trig(layout), _reset(layout)]
    if large:
        parts.append(plan.text(plans, len(system.positions), layout.rows["time"]))
    parts.append(outputs.text(system))
    return "\n".join(parts)


def _sizes(layout: Layout, plans: list[plan.Plan]) -> dict[str, int]:
    system = layout.system
    return {
        "positions": len(system.positions),
        "speeds": len(system.speeds),
        "angles": len(system.angles),
        "contacts": len(system.contacts),
        "resets": len(system.resets),
        "sections": int(system.section is not None),
        "powers": len(system.powers),
        "first": layout.rows["time"],
        "guards": layout.rows["guard"],
        "rows": layout.rows["end"],
        "planned": int(bool(plans)),
        "jacobian": max((len(each.values) for each in plans), default=len(system.speeds) * len(layout.state)),
    }


def _names(system: System) -> str:
    flags = {c.name: PULLS * c.pulls + STICKS * c.sticks for c in system.contacts}
    return f"CONTACTS = {flags!r}\nRESETS = {[reset.name for reset in system.resets]!r}\n\n"


def _rate(layout: Layout, dynamics: Dynamics, variant: str) -> str:
    """Rates and all else that is watched, by lanes."""
    system, rows = layout.system, layout.rows
    results, stores = {}, {}

    def store(name, value, row):
        results[name], stores[name] = value, row

    for k, a in enumerate(dynamics.a):
        store(f"out_rate_{k}", a, rows["rate"] + k)
    for j in range(len(system.contacts)):
        for place, value in guards(dynamics, j, variant).items():
            store(f"out_guard_{j}_{place}", value, rows["guard"] + 4 * j + place)
    for k, reset in enumerate(system.resets):
        store(f"out_reset_{k}", reset.guard, rows["reset"] + k)
    if system.section is not None:
        store("out_section", system.section, rows["section"])
    for k, power in enumerate(system.powers.values()):
        store(f"out_power_{k}", power, rows["power"] + k)
    return lanes(f"rate_{variant}", layout, dynamics.tape.program(results), stores)


def guards(dynamics: Dynamics, j: int, variant: str) -> dict[int, Expr]:
    """Guards of a contact by place: 0 gap or u, 1 the law's F_n, 2 v_t, 3 the cone (f F_n)^2 - F_t^2."""
    contact = dynamics.system.contacts[j]
    found = {0: contact.u if contact.gap is None else contact.gap}
    if not contact.pulls or (contact.sticks and variant == "stick"):
        found[1] = contact.F_n
    if contact.sticks and variant != "free":
        found[2] = contact.v_t
    if contact.sticks and variant == "stick":
        found[3] = (contact.coulomb * dynamics.F_n[j]) ** 2 - dynamics.F_t[j] ** 2
    return found


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
    results, stores = {}, {}
    for j, contact in enumerate(layout.system.contacts):
        v_t, creep = (contact.v_t, dynamics.creep(j)) if contact.v_t is not None else (Integer(0), Integer(0))
        for place, value in enumerate((contact.u, contact.v_n, v_t, contact.F_n, dynamics.F_t[j], creep)):
            results[f"out_{j}_{place}"], stores[f"out_{j}_{place}"] = value, 6 * j + place
    program = dynamics.tape.program(results)
    return point(f"contacts_{variant}", layout, program, stores, "s, p, m, out", "out")


def _choice(name: str, arguments: str, functions: list[str], first: int = 0) -> str:
    """A function of the variant, 0 free, 1 slip, 2 stick, that holds the bodies of several (a call costs)."""
    lines = [f"{_door(name)}\ndef {name}(variant, {arguments}):"]
    for number, function in enumerate(functions, start=first):
        body = _renamed(function.rstrip(), number).split("\n")[1:]
        lines += [f"    if variant == {number}:", *(f"    {line}" for line in body)]
    return "\n".join(lines if functions else [*lines, "    pass"]) + "\n\n"


def _renamed(function: str, number: int) -> str:
    """Its local names with a number, so that none is assigned twice: such names cost time to compile."""
    names = "|".join(sorted(set(re.findall(r"^ +(\w+) =", function, re.M))))
    return re.sub(rf"\b({names})\b", rf"\1__{number}", function) if names else function


def _door(name: str) -> str:
    return f'@entry(SIGNATURES["{name}"])'


def _trig(layout: Layout) -> str:
    lines = [_door("trig"), "def trig(s, p):"]
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


def _reset(layout: Layout) -> str:
    parts, lines = [], [_door("reset"), "def reset(k, s, p):"]
    for k, jump in enumerate(layout.system.resets):
        program = [(f"new_{z}", value) for z, value in jump.speeds.items()]
        stores = {f"new_{z}": layout.base[z] for z in jump.speeds}
        parts.append("@compiled\n" + point(f"reset_{k}", layout, program, stores, "s, p", "s") + "\n")
        lines.append(f"    if k == {k}:\n        reset_{k}(s, p)")
    return "\n".join([*parts, *(lines if parts else [*lines, "    pass"])]) + "\n"
