"""Loops of the method compiled ahead, for a kind of processor that most machines are: part of a release.

    python -m jointplay.solver.codegen.prebuilt [FOLDER]

compiles every loop for `LEVEL`, whose results are those of any processor that multiplies and adds in one
operation, into one file, since loops have much in common. It opens with the hash of the method's sources, of
the system and of its content: of other sources, or damaged, it is as if it were not there, and a loop is
compiled at its first use.
"""

from __future__ import annotations

import hashlib
import lzma
import os
import sys
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from ..method.interface import interpreted
from . import place

LEVEL = "x86-64-v3"
NEEDED = ("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")  # of a processor for that
FOLDER, NAME = Path(__file__).with_name("ready"), "loops.xz"
METHOD = Path(__file__).parent.parent / "method"


def units() -> list[str]:
    """Names of all loops of the method: modules below `jointplay.solver.method` that have a UNIT."""
    paths = sorted(METHOD.rglob("*.py"))
    found = [
        path for path in paths if any(line.startswith("UNIT = ") for line in path.read_text().split("\n"))
    ]
    return [".".join(path.relative_to(METHOD).with_suffix("").parts) for path in found]


def found(name: str) -> bytes | None:
    """Object code of a loop that was compiled ahead of these sources, where this processor can run it."""
    return _loops(FOLDER / NAME).get(name) if _suits() else None


@lru_cache(maxsize=1)
def _loops(path: Path) -> dict[str, bytes]:
    """Object code by the names of loops; of a file that is not whole, or of other sources, none."""
    try:
        seal, _, packed = path.read_bytes().partition(b"\n")
    except OSError:
        return {}
    if seal != _seal(packed):
        return {}
    left, codes = lzma.decompress(packed), {}
    while left:
        head, _, left = left.partition(b"\n")
        name, size = head.decode().split()
        codes[name], left = left[: int(size)], left[int(size) :]
    return codes


def write(folder: Path, names: Iterable[str]) -> Path:
    """Compile loops for `LEVEL` into one file."""
    from importlib import import_module

    from ..method.compiler import object_code

    parts = []
    for name in names:
        code = object_code(import_module(f"jointplay.solver.method.{name}"), LEVEL, "")
        parts.append(f"{name} {len(code)}\n".encode() + code)
    packed = lzma.compress(b"".join(parts), preset=9 | lzma.PRESET_EXTREME)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / NAME
    path.write_bytes(_seal(packed) + b"\n" + packed)
    return path


@lru_cache(maxsize=1)
def _suits() -> bool:
    """Whether the processor suits the prebuilt code, and the environment names no other."""
    overridden = any(f"NUMBA_CPU_{word}" in os.environ for word in ("NAME", "FEATURES"))
    features = place.llvm().get_host_cpu_features()
    return not (overridden or interpreted()) and all(features.get(each, False) for each in NEEDED)


@lru_cache(maxsize=1)
def _sources() -> bytes:
    """Hash of the method's sources, and of the system whose conventions its code keeps."""
    total = hashlib.sha256(f"{LEVEL} {place.target().triple}\n".encode())
    for path in sorted(METHOD.rglob("*.py")):
        total.update(f"{path.relative_to(METHOD).as_posix()}\n".encode() + path.read_bytes())
    return total.digest()


def _seal(packed: bytes) -> bytes:
    return hashlib.sha256(_sources() + packed).hexdigest().encode()


if __name__ == "__main__":
    path = write(Path(*sys.argv[1:2] or [FOLDER]), units())
    sys.stdout.write(f"{path}  {path.stat().st_size / 1000:.0f} kB\n")
