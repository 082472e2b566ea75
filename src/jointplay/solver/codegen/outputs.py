"""Recorded quantities as a program over arrays: written once a structure, run in the parts needed.

Quantities are not computed while a motion is followed, but afterwards, from the recorded states and modes,
by NumPy. The program is data: assignments with what each reads, so that only what the asked quantities need
is executed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from types import CodeType, ModuleType

import numpy as np

from .lambert import LAMBERT

FUNCTIONS = {"sqrt": np.sqrt, "sin": np.sin, "cos": np.cos, "atan2": np.arctan2, "tanh": np.tanh}
FUNCTIONS |= {"exp": np.exp, "copysign": np.copysign, "log": np.log, "compiled": lambda f: f}
exec(LAMBERT, FUNCTIONS)


def text(system) -> str:
    """The program as source of constants: OUTPUTS (name: symbol), PROGRAM (symbol, expression, reads).

    ABRUPT are the outputs that depend on accelerations, or on forces that answer a speed as these do.
    """
    from ..equations.system import TIME
    from .dynamics import Dynamics
    from .source import expression
    from .tape import read

    dynamics = Dynamics(system, "any")
    names = {name: f"out_{i}" for i, name in enumerate(system.outputs)}
    behind = ((name, dynamics.tape.behind([value])) for name, value in system.outputs.items())
    abrupt = tuple(name for name, symbols in behind if symbols & dynamics.abrupt)
    program = dynamics.tape.program({symbol: system.outputs[name] for name, symbol in names.items()})
    rows = [(str(s), expression(value), tuple(x.name for x in read(value))) for s, value in program]
    angles = [(str(x), f"{f}({expression(a.value)})", _reads(a)) for a in system.angles for f, x in _trig(a)]
    lines = ",\n".join(f"    {row!r}" for row in angles + rows)
    state = [str(s) for s in (TIME, *system.positions, *system.speeds)]
    parameters = [str(s) for s in system.parameters]
    found = {"STATE": state, "PARAMETERS": parameters, "OUTPUTS": names, "ABRUPT": abrupt}
    return "".join(f"{name} = {each!r}\n" for name, each in found.items()) + f"PROGRAM = (\n{lines},\n)\n"


def _trig(angle):
    return ("sin", angle.sin), ("cos", angle.cos)


def _reads(angle) -> tuple[str, ...]:
    return tuple(sorted(map(str, angle.value.free_symbols)))


def evaluate(
    module: ModuleType, names: Iterable[str], given: Mapping[str, np.ndarray | float]
) -> dict[str, np.ndarray]:
    """Values of named quantities.

    Parameters
    ----------
    module : module
        A structure's module.
    names : iterable of str
        Keys of its OUTPUTS.
    given : mapping
        Value of every symbol of its STATE and PARAMETERS, and of the masks touch_j, slip_j, stick_j; arrays
        of one shape or numbers; complex ones give complex values.

    Returns
    -------
    dict of str to ndarray
    """
    names = tuple(names)
    scope = FUNCTIONS | given
    with np.errstate(invalid="ignore"):  # beyond where a law ends there is no number
        exec(_needed(module, names), scope)
    values = {name: np.asarray(scope[module.OUTPUTS[name]]) for name in names}
    return {name: each if each.dtype.kind == "c" else each.astype(float) for name, each in values.items()}


@lru_cache(maxsize=256)
def _needed(module: ModuleType, names: tuple[str, ...]) -> CodeType:
    """The part of the program that some quantities need, compiled."""
    return compile("\n".join(needed(module, names)[0]), module.__name__, "exec")


def needed(module: ModuleType, names: Iterable[str]) -> tuple[list[str], set[str]]:
    """The assignments of the program that some quantities need, in order, and the symbols in them."""
    wanted, steps = {module.OUTPUTS[name] for name in names}, []
    for symbol, source, reads in reversed(module.PROGRAM):
        if symbol in wanted:
            wanted.update(reads)
            steps.append(f"{symbol} = {source}")
    return steps[::-1], wanted
