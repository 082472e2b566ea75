"""A switch that slides: Filippov's motion along its guard, where both modes push towards it.

With rates f = f_0 + s f_1 that are straight in the switch s, which is 1 where its guard h > 0, a convex share
s = (1 + F)/2 of both modes keeps h' = 0:

    f = f_0 + f_1/2 - w F,   w = -f_1/2,   grad h . f = 0,   |F| <= 1.

So it is friction of coefficient 1 in the "speed" h, with F = 1 above and -1 below, but for its direction w,
which is not that of the guard's gradient; it begins and ends as sticking does (method.modes). Of several
that slide at one time each keeps its own guard (Utkin's equivalent control). Reference: Filippov (1988), see
method.modes.
"""

from sympy import Expr, Integer, Symbol

from ....display.errors import InputError, Problem
from ..system import Contact, traction
from .written import Oscillator, Switch

_ONE, _NONE = Integer(1), Integer(0)


def held(given: Switch) -> Symbol:
    """F of a switch."""
    return traction(Contact(given.name, _ONE, _NONE, _ONE, ()))[1]


def share(given: Switch) -> Expr:
    """The switch as a number in the equations."""
    return (1 + held(given)) / 2


def middle(rate: Expr, switches: tuple[Switch, ...]) -> Expr:
    """A rate where every F is 0."""
    return rate.xreplace(dict.fromkeys(map(held, switches), _NONE))


def sliding(
    structure: Oscillator, i: int, guard: Expr, row: tuple[Expr, ...], rates: tuple[Expr, ...]
) -> Contact:
    """The i-th switch of a structure, by its guard, the guard's slopes, and the rates of all but positions.

    Raises
    ------
    InputError
        If rates are not straight in what slides, or the switch does not change its guard's rate.
    """
    given, forces = structure.switches[i], set(map(held, structure.switches))
    along = tuple(-rate.diff(held(given)) for rate in rates)
    straight = f"a rate that is straight in all that slides is accepted, as in {given.name}"
    problems = [
        Problem(f"rates.{name}", text, straight)
        for name, text, entry in zip(structure.speeds, structure.rates, along, strict=True)
        if entry.free_symbols & forces
    ]
    if not structure.mass and sum(a * b for a, b in zip(row, along, strict=True)) == 0:
        accepted = "a guard whose own rate the switch changes is accepted: else nothing could keep it at 0"
        problems.append(Problem(f"switches[{i}].on", given.on, accepted))
    if problems:
        raise InputError(problems)
    still = (_NONE,) * len(along)
    friction = {"v_t": guard, "tangential": row, "coulomb": _ONE, "limit": _ONE, "acts_along": along}
    return Contact(given.name, _ONE, _NONE, _ONE, still, **friction)
