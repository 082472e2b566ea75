"""The code and the processor that computed a cell, which decide its bits; versions of software."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
from functools import lru_cache
from importlib import metadata
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from jointplay.solver.codegen import cache
from jointplay.solver.extensions import published

PACKAGE = Path(__file__).resolve().parents[1]
FOLDERS = (  # beside those that the kernels' digest covers
    "jointplay/analysis",
    "jointplay/solver/mechanism",
    "jointplay/solver/motion",
)
DECIDING = tuple(f"jointplay.{table}" for table in ("laws", "frictions", "mechanisms", "kinds"))
CODE = (*SOURCE_SUFFIXES, *EXTENSION_SUFFIXES)


class Origin(NamedTuple):
    """Digest of the code, and kind of processor, that computed a cell."""

    code: str
    processor: str


@lru_cache(maxsize=1)
def code() -> str:
    """Digest of all code that decides a cell's answer: kernels, analyses, mechanisms, others' packages."""
    total = hashlib.sha256(cache.digest().encode())
    places = {folder: PACKAGE.parent / folder for folder in FOLDERS}
    for name, place in sorted((places | others()).items()):
        for path in _files(place):
            total.update(f"{name} {path.relative_to(place)}\n".encode() + path.read_bytes())
    return total.hexdigest()[:16]


def others() -> dict[str, Path]:
    """Packages that publish laws, mechanisms or kinds of study: a folder, or the file of a single module."""
    modules = {point.module for group in DECIDING for point in published(group)}
    found = dict(map(_package, modules))
    return {name: place for name, place in found.items() if place and place != PACKAGE}


def _package(module: str) -> tuple[str, Path | None]:
    """Name and place of a module's outermost package, which is not imported; None where there is none."""
    name, *rest = module.split(".")
    spec = find_spec(name)
    while spec and spec.origin is None and rest:  # a namespace, which many packages share
        name = f"{name}.{rest.pop(0)}"
        spec = find_spec(name)
    if spec is None or not spec.has_location:
        return name, None
    place = Path(str(spec.origin)).resolve()
    return name, place.parent if place.name == "__init__.py" else place


def _files(place: Path) -> list[Path]:
    """Files of code in a folder; of a file, itself."""
    return sorted(path for path in (place, *place.rglob("*")) if path.is_file() and path.name.endswith(CODE))


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
    from jointplay.solver.codegen.objects import target

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
