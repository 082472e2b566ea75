"""How compiled code is made and what a structure's module must supply.

One policy for every kernel: cached on disk, free of the interpreter's lock, IEEE division, no reference
counting (a kernel allocates nothing and keeps nothing; counting cost a third of its time). Of the fast-math
licences only those are taken that keep NaN and infinity meaningful: contraction to fused multiply-add,
reciprocals, signed zero.

Between compiled functions an integer written out in a call makes a version of the callee for that very
number: pass a variable or a float.
"""

import os
from collections.abc import Callable
from typing import NamedTuple

import numba
from numba import float64, int64, types, void
from numba.experimental.function_type import _get_wrapper_address

if "JOINTPLAY_KERNELS" in os.environ:  # a folder named by the digest of every source: set by codegen.cache
    numba.config.CACHE_DIR = os.environ["JOINTPLAY_KERNELS"]

POLICY = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "arcp", "nsz"},
    "_nrt": False,
}

vector = float64[::1]

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
    """What the flow calls: functions of a structure (codegen.module), and the method's algebra for it.

    The algebra is written out by size (codegen.algebra), or goes by the structure's plan (codegen.plan).
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


class Variations(NamedTuple):
    """What tangents need beside that: derivatives of a structure's functions (codegen.variation)."""

    variation: Callable
    vary: Callable
    divergence: Callable
    gradient: Callable
    turned: Callable


def _typed(kind):
    return types.NamedTuple([types.FunctionType(SIGNATURES[name]) for name in kind._fields], kind)


FUNCTIONS, VARIATIONS = _typed(Functions), _typed(Variations)


class Pointer(types.WrapperAddressProtocol):
    """A compiled function as a bare address, which costs a call from Python less than the function itself."""

    def __init__(self, function, signature):
        self._signature = signature
        self._function = function  # keeps the code alive
        self._address = _get_wrapper_address(function, self._signature)

    def __wrapper_address__(self) -> int:
        return self._address

    def signature(self):
        return self._signature


def pointers(*modules, kind=Functions, signatures=SIGNATURES):
    """The functions of modules as a loop takes them: addresses; themselves where nothing is compiled."""
    found = {
        name: getattr(module, name) for module in modules for name in kind._fields if hasattr(module, name)
    }
    if not numba.config.DISABLE_JIT:
        found = {name: Pointer(function, signatures[name]) for name, function in found.items()}
    return kind(**found)


def direct(function):
    """A compiled function with one signature, without the search for the version that fits its arguments."""
    if numba.config.DISABLE_JIT:
        return function
    (version,) = function.overloads.values()
    return version.entry_point


compiled = numba.njit(**POLICY)
# called by compiled code alone: the doors to Python would be a third of the time to compile
inner = numba.njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **POLICY)
# once an attempt: a call hands over seven numbers for each array
inlined = numba.njit(forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True, **POLICY)
spliced = numba.njit(inline="always", **POLICY)  # the same before types are known: long bodies compile faster


def entry(signature):
    """Compile at import, with an explicit signature: the doors between a structure and the method."""
    return numba.njit(signature, **POLICY)
