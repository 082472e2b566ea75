"""Where compiled kernels and generated modules lie, and how a structure finds its own.

Numba notices an edit in a function's own file only, and would answer with stale numbers after an edit
elsewhere. So every source that shapes a kernel, with the versions and flags that do, is digested, and
everything compiled lies in a folder named by that digest: an edit is another folder. Generated modules are
named by the hash of their text, written whole, and found by the structure that they belong to without
deriving its equations again.

The method itself is compiled in a process of its own and then loaded, by every process alike. In one that has
compiled it, its callees lie in memory a second time, each compiled by itself, and may be called instead; with
other additions fused to multiplications, a chaotic motion would be another one than in the next process.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType

ROOMS = ("equations", "codegen", "numerics")
FLAGS = ("NUMBA_BOUNDSCHECK", "NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_DISABLE_JIT")
GENERATED = "jointplay.codegen.generated"
_compiling: dict[str, subprocess.Popen] = {}
_lock = threading.Lock()


@lru_cache(maxsize=1)
def digest() -> str:
    """Digest of every source, version and flag that shapes compiled code (16 hexadecimal digits)."""
    package, total = Path(__file__).parent.parent, hashlib.sha256()
    for room in ROOMS:
        for path in sorted((package / room).rglob("*.py")):
            total.update(f"{path.relative_to(package)}\n".encode() + path.read_bytes())
    versions = [f"{name} {_version(name)}" for name in ("numba", "llvmlite", "numpy", "sympy")]
    flags = [f"{name}={os.environ.get(name, '')}" for name in FLAGS]
    total.update("\n".join([*versions, *flags, platform.machine(), sys.version]).encode())
    return total.hexdigest()[:16]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def root() -> Path:
    """The folder of all digests: $JOINTPLAY_CACHE, else below $NUMBA_CACHE_DIR or the user's cache folder."""
    if "JOINTPLAY_CACHE" in os.environ:
        return Path(os.environ["JOINTPLAY_CACHE"])
    if "NUMBA_CACHE_DIR" in os.environ:
        return Path(os.environ["NUMBA_CACHE_DIR"]) / "jointplay"
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "jointplay"


@lru_cache(maxsize=1)
def folder() -> Path:
    """The folder of this digest, made if missing; a temporary one where the cache cannot be written."""
    place = root() / digest()
    try:
        place.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=place):
            return place
    except OSError:
        return Path(tempfile.mkdtemp(prefix="jointplay-"))


def activate() -> None:
    """Point the kernels of this process, and of workers that it starts, to their folder."""
    os.environ["JOINTPLAY_KERNELS"] = str(folder())


def prepare(name: str) -> None:
    """Begin to compile a loop of the method beside what this process does, if no process ever has."""
    compiles = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
    known = f"jointplay.numerics.{name}" in sys.modules or _built(name).exists()
    with _lock:
        if known or name in _compiling or not compiles or folder().parent != root():
            return
        paths = [str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")]
        own = {"PYTHONPATH": os.pathsep.join(filter(None, paths)), "JOINTPLAY_CACHE": str(root())}
        _compiling[name] = subprocess.Popen(
            [sys.executable, "-c", f"import jointplay.numerics.{name}"],
            env=os.environ | own,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


def method(name: str) -> ModuleType:
    """A compiled loop of the method (`jointplay.numerics`), loaded from where another process has put it."""
    prepare(name)
    with _lock:
        if name in _compiling and _compiling.pop(name).wait() == 0:
            _built(name).touch()
        return importlib.import_module(f"jointplay.numerics.{name}")  # where that failed: compiled here


def _built(name: str) -> Path:
    return folder() / f"{name}.built"


def structure_module(structure) -> ModuleType:
    """The compiled functions of a structure; equations are derived only if they never were."""
    return _module(f"structure {structure!r}", lambda: _structure_text(structure))


def algebra_module(n_q: int, n: int) -> ModuleType:
    """The compiled algebra of the method for n_q positions and n speeds."""
    return _module(
        f"algebra {n_q} {n}", lambda: importlib.import_module(".algebra", __package__).text(n_q, n)
    )


def variation_module(structure) -> ModuleType:
    """The compiled derivatives of a structure, for those who follow tangents."""
    sizes = structure_module(structure).SIZES
    return _module(f"variation {structure!r}", lambda: _variation_text(structure, sizes))


def ensemble_module(structure) -> ModuleType | None:
    """The compiled equations of a structure for eight trajectories at once; None if they are not made so."""
    module = _module(f"ensemble {structure!r}", lambda: _ensemble_text(structure))
    return module if module.SUITS else None


def ensemble_algebra() -> ModuleType:
    """The compiled algebra of the method for eight trajectories at once."""
    return _module(
        "ensemble algebra", lambda: importlib.import_module(".ensemble.algebra", __package__).text()
    )


def _ensemble_text(structure) -> str:
    from ..equations.write import system
    from .ensemble.equations import suits, text

    equations = system(structure)
    return text(equations) if suits(equations) else "SUITS = False\n"


def _structure_text(structure) -> str:
    from ..equations.write import system
    from .module import text

    return text(system(structure))


def _variation_text(structure, sizes: dict[str, int]) -> str:
    from ..equations.write import system
    from .variation import text

    return text(system(structure), sizes["first"], bool(sizes["planned"]))


@cache
def _named(key: str) -> str | None:
    """Name of the module that was written for a key."""
    path = folder() / f"{hashlib.sha256(key.encode()).hexdigest()[:16]}.name"
    return path.read_text() if path.exists() else None


def _module(key: str, text) -> ModuleType:
    name = _named(key)
    if name is None or not (folder() / f"{name}.py").exists():
        source = text()
        name = "k" + hashlib.sha256(source.encode()).hexdigest()[:16]
        _write(folder() / f"{name}.py", source)
        _write(folder() / f"{hashlib.sha256(key.encode()).hexdigest()[:16]}.name", name)
        _named.cache_clear()
        importlib.invalidate_caches()
    return importlib.import_module(f"{GENERATED}.{name}")


def _write(path: Path, text: str) -> None:
    """Write whole: by a temporary name and a rename, so that another process never reads half."""
    with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".tmp", delete=False) as file:
        file.write(text)
    os.replace(file.name, path)


def _digests() -> list[Path]:
    """Folders that are named as digests are; nothing else below the root is ours."""
    return sorted(
        place for place in root().glob("*") if place.is_dir() and re.fullmatch("[0-9a-f]{16}", place.name)
    )


def entries() -> list[str]:
    """List the digests in the cache with their size; the one in use is marked."""
    result = []
    for place in _digests():
        size = sum(path.stat().st_size for path in place.rglob("*") if path.is_file())
        mark = "in use" if place.name == digest() else "old"
        result.append(f"{place.name}  {size / 1e6:6.1f} MB  {mark}")
    return result


def prune() -> list[str]:
    """Delete the folders of all digests but the one in use; give back their names."""
    old = [place for place in _digests() if place.name != digest()]
    for place in old:
        shutil.rmtree(place, ignore_errors=True)
    return [place.name for place in old]
