"""How compiled code is made and what a structure's module must supply.

One policy for every kernel: cached on disk, free of the interpreter's lock, IEEE division, no reference counting (a
kernel allocates nothing and keeps nothing; counting cost a third of its time). Of the fast-math licences only those are
taken that keep NaN and infinity meaningful: contraction to fused multiply-add, reciprocals, signed zero.

Between compiled functions an integer written out in a call makes a version of the callee for that very number: pass a
variable or a float.
"""

import os

import numba
from numba import float64, int64, types, void

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
integers = int64[::1]

SIGNATURES = {
    "rate": void(int64, vector, vector, vector, vector),
    "jacobian": void(int64, vector, vector, vector, vector),
    "contacts": void(int64, vector, vector, vector, vector),
    "trig": void(vector, vector),
    "reset": void(int64, vector, vector),
    "extrapolate": void(vector, vector, float64, float64),
    "rest": void(vector),
    "move": void(vector, vector, float64),
    "factor": void(vector, vector, float64),
    "newton": float64(vector, vector, vector, float64),
    "estimate": float64(vector, vector, vector, vector, float64),
}

POINTERS = tuple(types.FunctionType(signature) for signature in SIGNATURES.values())

compiled = numba.njit(**POLICY)
inlined = numba.njit(forceinline=True, **POLICY)


def entry(signature):
    """Compile at import, with an explicit signature: the doors between a structure and the method."""
    return numba.njit(signature, **POLICY)
