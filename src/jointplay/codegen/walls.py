"""A rigid wall as a constraint, for bodies that rest on it.

What holds a gap closed is a contact that sticks in the gap's rate: N.z + d gap/dt = 0 with N = d gap/d q,
whose force F_t along N is an unknown (codegen.dynamics). The wall pushes where F_t < 0.
"""

from sympy import Integer, Symbol

from ..equations.system import TIME, Contact, Reset
from .tape import Tape


def holding(tape: Tape, reset: Reset, positions: tuple[Symbol, ...], speeds: tuple[Symbol, ...]) -> Contact:
    """The wall of a reset as a contact without a law, whose v_t is the rate of the gap."""
    slopes = [tape.derivative(reset.guard, q) for q in positions]
    normal = [tape.let(f"N_{reset.name}_{i}", slope) for i, slope in enumerate(slopes)]
    moved = sum((n * z for n, z in zip(normal, speeds, strict=False)), Integer(0))
    rate = tape.let(f"rate_{reset.name}", moved + tape.derivative(reset.guard, TIME))
    row = (*normal, *[Integer(0)] * (len(speeds) - len(normal)))
    u, v_n = (Symbol(f"{word}_{reset.name}", real=True) for word in ("u", "v"))
    return Contact(reset.name, u, v_n, Integer(0), (), v_t=rate, tangential=row)
