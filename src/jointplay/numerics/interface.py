"""How compiled code is made and what a structure's module must supply.

One policy for every kernel: cached on disk, free of the interpreter's lock, IEEE division, no reference
counting (a kernel allocates nothing and keeps nothing; counting cost a third of its time). Of the fast-math
licences only those are taken that keep NaN and infinity meaningful: contraction to fused multiply-add,
reciprocals, signed zero.

Between compiled functions an integer written out in a call makes a version of the callee for that very
number: pass a variable or a float.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np
from numba import float64, int64, typeof, types, void

from jointplay import numerics

from . import numba_private
from .memory import Options, trajectory, work

POLICY = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "arcp", "nsz"},
    **numba_private.UNCOUNTED,
}

vector = float64[::1]
WORK = typeof(work(1, 1, 1, 1, 1, 1, 1))
TRAJECTORY = typeof(trajectory(np.zeros(1), np.zeros(1), 1, 1, 0, 0))
OPTIONS = typeof(Options(*(field(0) for field in Options.__annotations__.values())))

SIGNATURES = {
    "rate": void(int64, vector, vector, vector, vector),
    "jacobian": void(int64, vector, vector, vector, vector),
    "contacts": void(int64, vector, vector, vector, vector),
    "trig": void(vector, vector),
    "reset": void(int64, vector, vector),
    "extrapolate": void(vector, vector, float64, float64),
    "rest": void(vector),
    "move": void(vector, vector, float64),
    "factor": void(int64, vector, vector, float64),
    "newton": float64(int64, vector, vector, vector, vector, float64),
    "estimate": float64(int64, vector, vector, vector, vector, float64),
    "variation": void(int64, vector, vector, vector, vector),
    "vary": void(vector, vector),
    "divergence": void(vector),
    "gradient": void(int64, vector, vector, vector, vector),
    "turned": void(int64, vector, vector, vector),
}


class Functions(NamedTuple):
    """Functions that the flow calls: a structure's (codegen.module), and the method's algebra for its size.

    The algebra is written out by size (codegen.algebra), or goes by a plan (codegen.elimination).
    What happens at rigid walls (wall_flow.at_wall) is compiled only for structures that have some.
    """

    rate: Callable
    jacobian: Callable
    contacts: Callable
    trig: Callable
    reset: Callable
    extrapolate: Callable
    rest: Callable
    move: Callable
    factor: Callable
    newton: Callable
    estimate: Callable
    at_wall: Callable


class AtPoint(NamedTuple):
    """Functions of a structure at one point, for events (codegen.module)."""

    rate: Callable
    contacts: Callable
    trig: Callable
    reset: Callable


class Variations(NamedTuple):
    """Derivatives of a structure's functions, for tangents (codegen.variation)."""

    variation: Callable
    vary: Callable
    divergence: Callable
    gradient: Callable
    turned: Callable


def _typed(kind):
    return types.NamedTuple([types.FunctionType(SIGNATURES[name]) for name in kind._fields], kind)


AT_POINT = _typed(AtPoint)
SIGNATURES["at_wall"] = void(AT_POINT, int64, int64, WORK, TRAJECTORY, OPTIONS)
FUNCTIONS, VARIATIONS = _typed(Functions), _typed(Variations)


class Pointer(types.WrapperAddressProtocol):
    """A compiled function as a bare address, which costs a call from Python less than the function itself."""

    def __init__(self, function, signature):
        self._signature = signature
        self._function = function  # keeps the code alive
        self._address = getattr(function, "address", 0) or numba_private.address(function, self._signature)

    def __wrapper_address__(self) -> int:
        return self._address

    def signature(self):
        return self._signature


def pointers(*modules, kind=Functions, signatures=SIGNATURES):
    """The functions of modules as a loop takes them: addresses; themselves where nothing is compiled."""
    functions = {
        name: getattr(module, name) for module in modules for name in kind._fields if hasattr(module, name)
    }
    return kind(**{name: address(function, signatures[name]) for name, function in functions.items()})


def address(function, signature):
    """A compiled function as another one takes it; itself where nothing is compiled."""
    return function if numba.config.DISABLE_JIT else Pointer(function, signature)


@lru_cache(maxsize=64)
def direct(function):
    """A compiled function with one signature, without the search for the version that fits its arguments."""
    plain = numba.config.DISABLE_JIT or hasattr(function, "address")
    return function if plain else numba_private.only_version(function)


def _compiles(**options):
    """Make a decorator that compiles by the policy, and keeps what it compiled where that is arranged."""

    def decorate(function):
        made = numba.njit(**POLICY, **options)(function)
        if numerics.kept is not None and not numba.config.DISABLE_JIT:
            numba_private.keep(made, numerics.kept(function))
        return made

    return decorate


compiled = _compiles()
inner = _compiles(**numba_private.INNER)  # called by compiled code alone
handed = _compiles(**numba_private.HANDED)  # the same by address
inlined = _compiles(**numba_private.INLINED, **numba_private.INNER)  # what is called once an attempt
spliced = _compiles(inline="always")  # the same before types are known: long bodies compile faster


def entry(signature, how=compiled):
    """Compile at import, with an explicit signature: what a structure and the method call of each other."""

    def compile_now(function):
        made = how(function)
        if not numba.config.DISABLE_JIT:
            made.compile(signature)
            made.disable_compile()
        return made

    return compile_now


@entry(SIGNATURES["at_wall"], handed)
def at_wall(f, guard, at, k, x, o):
    """Do nothing, and never be called: what structures without rigid walls have for wall_flow.at_wall."""
