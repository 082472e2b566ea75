"""Equations in the form that lanes follow: positions, each with a speed.

A phase of the forcing is an angle that turns at a speed which stays, so that a section at a phase is one at
an angle; time is the first phase over its speed, or that of a clock. A state of first order is the speed of a
position on which nothing depends. A linkage has this form already, but for a crank whose speed is imposed.
"""

from dataclasses import replace

from sympy import Integer, Symbol

from ...equations.system import TIME, Angle, Contact, System
from ...method.lanes import CLOCK

NONE = Integer(0)


def laid_out(system: System) -> tuple[System, int]:
    """The system as lanes follow it, and the number of its phases, which come before its positions."""
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
        resets=tuple(replace(each, guard=each.guard.xreplace(time)) for each in system.resets),
    )
    return laid, first
