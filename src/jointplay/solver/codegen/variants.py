"""Variants of a system, and its contacts and rigid walls in each.

A mask says by numbers what a contact does. A wall on which a body rests is a contact that sticks in the
gap's rate: N.z + d gap/dt = 0 with N = d gap/d q, whose force F_t along N is an unknown (codegen.dynamics).
The wall pushes where F_t < 0. Where it is rough, a second such contact holds the sliding speed of a body that
sticks to it; of one that slips, the force along N brings friction with it.
"""

from dataclasses import dataclass

from sympy import Expr, Integer, Symbol

from ..equations.system import TIME, Contact, Reset, System
from ..method.codes import Variant
from .tape import Tape

VARIANTS = Variant.words()


@dataclass(frozen=True)
class Mask:
    """A contact's mode as numbers: symbols, or constants where only one value can occur."""

    touch: Expr
    slip: Expr
    stick: Expr


def variants(system: System) -> tuple[str, ...]:
    """The variants that a system can be in."""
    if not system.contacts and not system.resets:
        return VARIANTS[:1]
    return VARIANTS if any(contact.sticks for contact in system.contacts) or system.rubs else VARIANTS[:2]


def masks(system: System, variant: str) -> list[Mask]:
    """Masks of every contact and wall, then of the friction of each guide's rough walls (`rubbing`).

    A lone contact needs only slip. `any` keeps all, `touch` all but stick.
    """
    held = [*system.contacts, *(reset for reset in system.resets if not reset.moves)]
    alone = len(held) == 1 and variant not in ("any", "touch")
    result = []
    for contact in system.contacts:
        touch, slip, stick = (
            Symbol(f"{word}_{contact.name}", real=True) for word in ("touch", "slip", "stick")
        )
        if variant == "free":
            touch = slip = stick = Integer(0)
        elif variant in ("slip", "touch") or not contact.sticks:
            touch, stick = (Integer(1) if alone else touch), Integer(0)
        elif alone:
            touch, stick = Integer(1), Integer(1)
        result.append(Mask(touch, slip, stick))
    result += [_resting(each.name, "free" if each.moves else variant) for each in system.resets]
    held = (sum(shares(walls, variant), Integer(0)) for walls in guides(system))
    return result + [Mask(Integer(0), Integer(0), stick) for stick in held]


def guides(system: System) -> list[list[Reset]]:
    """Rough walls, walls of one guide together."""
    found: dict[str, list[Reset]] = {}
    for wall in (reset for reset in system.resets if reset.rough):
        found.setdefault(wall.guide or f"{wall.name} alone", []).append(wall)
    return [*found.values()]


def sticking(wall: Reset) -> Symbol:
    """Whether a body sticks to a rough wall, as a number."""
    return Symbol(f"stick_{wall.name}", real=True)


def shares(walls: list[Reset], variant: str) -> list[Expr]:
    """Share of each rough wall of a guide: 1 of the first to which a body sticks, 0 of the others."""
    found, free = [], Integer(int(variant in ("stick", "any")))
    for wall in walls:
        found.append(free * sticking(wall))
        free *= 1 - sticking(wall)
    return found


def slipping(wall: Reset, variant: str) -> Expr:
    """Sense in which a body slips on a rough wall, as a number; 0: it does not."""
    return Integer(0) if variant == "free" else Symbol(f"slip_{wall.name}", real=True)


def _resting(wall: str, variant: str) -> Mask:
    """Mask of a rigid wall: it holds a resting body where it is touched."""
    held = Integer(0) if variant == "free" else Symbol(f"touch_{wall}", real=True)
    return Mask(Integer(0), Integer(0), held)


def holding(tape: Tape, reset: Reset, system: System) -> Contact:
    """The wall of a reset as a contact without a law, whose v_t is the rate of the gap.

    An imposed motion is no part of its row: it moves the wall, and no force of that moves it.
    """
    speeds, imposed = system.speeds, system.imposed
    u, v_n = (Symbol(f"{word}_{reset.name}", real=True) for word in ("u", "v"))
    if reset.moves:
        zero, still = Integer(0), (Integer(0),) * len(speeds)
        return Contact(reset.name, u, v_n, zero, (), v_t=zero, tangential=still)
    slopes = [tape.derivative(reset.gap, q) for q in system.positions]
    normal = [tape.let(f"N_{reset.name}_{i}", slope) for i, slope in enumerate(slopes)]
    moved = sum((n * z for n, z in zip(normal, speeds, strict=False)), Integer(0))
    rate = tape.let(f"rate_{reset.name}", moved + tape.derivative(reset.gap, TIME))
    row = (*normal, *[Integer(0)] * (len(speeds) - len(normal)))
    drift = sum((row[i] * acceleration for i, acceleration in imposed.items()), Integer(0))
    row = tuple(Integer(0) if i in imposed else entry for i, entry in enumerate(row))
    return Contact(reset.name, u, v_n, Integer(0), (), v_t=rate, tangential=row, drift=drift)


def rubbing(walls: list[Reset], variant: str) -> Contact:
    """The friction of a guide's rough walls as a contact without a law: it holds v_t where a body sticks."""
    name, sticks = f"rub_{walls[0].name}", shares(walls, variant)
    u, v_n = (Symbol(f"{word}_{name}", real=True) for word in ("u", "v"))
    v_t, drift = (
        sum((stick * value for stick, value in zip(sticks, each, strict=True)), Integer(0))
        for each in ([wall.v_t for wall in walls], [wall.drift for wall in walls])
    )
    columns = zip(*(wall.tangential for wall in walls), strict=True)
    row = tuple(sum((s * t for s, t in zip(sticks, each, strict=True)), Integer(0)) for each in columns)
    return Contact(name, u, v_n, Integer(0), (), v_t=v_t, tangential=row, drift=drift)
