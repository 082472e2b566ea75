"""The code and the processor that computed a cell, which decide its bits; versions of software."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

from jointplay.solver.codegen import cache
from jointplay.solver.extensions import code_files, packages

PACKAGE = Path(__file__).resolve().parents[1]
FOLDERS = (  # beside those that the kernels' digest covers
    "jointplay/analysis",
    "jointplay/solver/mechanism",
    "jointplay/solver/motion",
)
DECIDING = tuple(f"jointplay.{table}" for table in ("laws", "frictions", "mechanisms", "kinds"))


class Origin(NamedTuple):
    """Digest of the code, and kind of processor, that computed a cell."""

    code: str
    processor: str


@lru_cache(maxsize=1)
def code() -> str:
    """Digest of all code that decides a cell's answer: kernels, analyses, mechanisms, others' packages."""
    total = hashlib.sha256(cache.digest().encode())
    places = {folder: PACKAGE.parent / folder for folder in FOLDERS}
    for name, place in sorted((places | packages(*DECIDING)).items()):
        for path in code_files(place):
            total.update(f"{name} {path.relative_to(place)}\n".encode() + path.read_bytes())
    return total.hexdigest()[:16]


def own() -> Origin:
    """Origin of the answers that this process computes."""
    return Origin(code(), processor())


def mixed(kinds: set[str]) -> str | None:
    """A line that says on which kinds of processors cells ran; None where it is one kind."""
    if len(kinds) < 2:
        return None
    names = ", ".join(sorted(kinds))
    return f"{len(kinds)} kinds of processors ({names}): the result is not bit for bit that of one kind"


def environment() -> dict[str, str]:
    """Versions of the software that decides the numbers."""
    packages = {name: version(name) for name in ("numpy", "numba", "llvmlite")}
    return {"python": platform.python_version(), **packages, "platform": platform.platform()}


@lru_cache(maxsize=1)
def processor() -> str:
    """The kind of processor that kernels are compiled for: its name, and a digest of its features.

    NUMBA_CPU_NAME and NUMBA_CPU_FEATURES are heeded.
    """
    from jointplay.solver.codegen.place import target

    triple, name, features = target()
    return f"{name} {hashlib.sha256(f'{triple} {features}'.encode()).hexdigest()[:8]}"


@lru_cache
def version(package: str) -> str:
    """Version of an installed package, or ``unknown``."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"


def git_describe(package: Path = PACKAGE) -> str | None:
    """``git describe --dirty`` when the package runs from its own checkout, else None. Never fails."""
    try:
        checkout = Path(_git(package, "rev-parse", "--show-toplevel"))
        # an installed copy may lie inside somebody else's checkout: that describes another project
        if checkout.resolve() / "src" / package.name != package:
            return None
        return _git(package, "describe", "--always", "--tags", "--dirty")
    except (OSError, ValueError, subprocess.SubprocessError):
        return None


def _git(folder: Path, *arguments: str) -> str:
    # a hook's GIT_DIR would point elsewhere; asking must not write into the checkout's index
    clean = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    answer = subprocess.run(
        ["git", "-C", str(folder), *arguments],
        capture_output=True,
        text=True,
        timeout=10,
        check=True,
        env=clean | {"GIT_OPTIONAL_LOCKS": "0"},
    )
    return answer.stdout.strip()
