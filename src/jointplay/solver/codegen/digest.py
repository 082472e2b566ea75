"""Digest of all that decides compiled code: its sources, and the versions and flags that shape it.

Numba notices an edit in a function's own file only, and would answer with stale numbers after an edit
elsewhere. So everything that decides is digested, laws that other packages publish among it, and what is
compiled lies in a folder of that name: an edit is another folder.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from ..extensions import code_files, packages

SOURCES = ("equations", "codegen", "method")
FLAGS = (
    *("NUMBA_BOUNDSCHECK", "NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_DISABLE_JIT"),
    *("NUMBA_LOOP_VECTORIZE", "NUMBA_SLP_VECTORIZE", "NUMBA_ENABLE_AVX", "NUMBA_DISABLE_INTEL_SVML"),
)
SETTINGS = ".numba_config.yaml"  # of the current folder: numba reads flags there as well


@lru_cache(maxsize=1)
def digest() -> str:
    """Digest of every source, version and flag that shapes compiled code (16 hexadecimal digits)."""
    solver, total = Path(__file__).parent.parent, hashlib.sha256()
    for room in SOURCES:
        for path in sorted((solver / room).rglob("*.py")):
            total.update(f"{path.relative_to(solver)}\n".encode() + path.read_bytes())
    for name, place in sorted(packages("jointplay.laws", "jointplay.frictions").items()):
        for path in code_files(place):
            total.update(f"{name} {path.relative_to(place.parent)}\n".encode() + path.read_bytes())
    versions = [f"{name} {_version(name)}" for name in ("numba", "llvmlite", "numpy", "sympy")]
    flags = [f"{name}={os.environ.get(name, '')}" for name in FLAGS]
    total.update("\n".join([*versions, *flags, platform.machine(), sys.version]).encode())
    if os.path.isfile(SETTINGS):
        total.update(Path(SETTINGS).read_bytes())
    return total.hexdigest()[:16]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"
