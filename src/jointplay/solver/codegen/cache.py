"""Compiled code: the loops of the method, and modules generated for structures.

Generated modules are named by the hash of their text, and found by the structure that they belong to without
deriving its equations again. The least recently used of many are forgotten, machine code and all, once
nothing calls them.

The method itself is compiled to object code (method.compiler) in a process of its own, beside what the one
does that needs it, and loaded by every process alike, without numba.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import subprocess
import sys
import tempfile
import threading
from functools import lru_cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import IO, Any

from ..equations.structure import Linkage, Oscillator
from ..method.interface import Compiled, interpreted
from . import generated, place, prebuilt
from .place import digest as digest

# this very package, and no path that leads to it: a folder on the path brings all that lies there
CHILD = """
import importlib, sys
from importlib.util import module_from_spec, spec_from_file_location
spec = spec_from_file_location("jointplay", sys.argv[1])
sys.modules["jointplay"] = module_from_spec(spec)
spec.loader.exec_module(sys.modules["jointplay"])
importlib.import_module("jointplay.solver.codegen.cache").build(sys.argv[2])
"""
KEPT = 256  # generated modules in memory at most
_compiling: dict[str, tuple[subprocess.Popen, IO[str]]] = {}
_loops: dict[str, SimpleNamespace] = {}
_lock = threading.Lock()


def prepare(name: str) -> None:
    """Begin to compile a loop of the method in the background, if no process ever has."""
    with _lock:
        if not (interpreted() or name in _loops or name in _compiling) and _found(name) is None:
            _start(name)


def method(name: str) -> SimpleNamespace:
    """The compiled functions of a loop of the method: the functions of its module's UNIT.

    Parameters
    ----------
    name : str
        Of a module of `jointplay.solver.method` that has a UNIT.
    """
    with _lock:
        if name not in _loops:
            _loops[name] = _loaded(name)
        return _loops[name]


def build(name: str) -> bytes:
    """Compile a loop for this processor in this process, and keep it."""
    from ..method.compiler import object_code

    place.compiling(name)
    kind = place.target()
    code = object_code(_module_of(name), kind.cpu, kind.features)
    place.write(_file(name), code)
    return code


def _module_of(name: str) -> ModuleType:
    return importlib.import_module(f"jointplay.solver.method.{name}")


def _file(name: str) -> str:
    return f"{name}.{place.target().digest}.o"


def _found(name: str) -> bytes | None:
    """Object code of a loop that has been compiled before: by an earlier process, or ahead, then kept."""
    code = place.read(_file(name))
    if code is None and (code := prebuilt.found(name)) is not None:
        place.write(_file(name), code)
    return code


def _loaded(name: str) -> SimpleNamespace:
    module = _module_of(name)
    if interpreted():
        return SimpleNamespace(**{each: getattr(module, each) for each in module.UNIT})
    code = _found(name) if name not in _compiling else None
    library = place.Library(_compiled(name) if code is None else code)
    functions = {
        each: Compiled(library.address(each), signature, library) for each, signature in module.UNIT.items()
    }
    return SimpleNamespace(**functions)


def _compiled(name: str) -> bytes:
    """Object code of a loop, compiled in a process of its own, which may have begun; else in this one."""
    if name not in _compiling:
        _start(name)
    if name in _compiling and _ended_well(*_compiling.pop(name)) and (code := _found(name)) is not None:
        return code
    place.say(f"{name} of the method is compiled in this process")
    return build(name)


def _start(name: str) -> None:
    """Start a process that compiles a loop."""
    place.compiling(name)
    path = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))  # empty: the current folder
    own = {"PYTHONPATH": os.pathsep.join(path), "PYTHONSAFEPATH": "1", place.HANDED: str(place.folder())}
    command = [sys.executable, "-c", CHILD, str(Path(__file__).parents[2] / "__init__.py"), name]
    said = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115 (closed when the process has ended)
    try:
        child = subprocess.Popen(command, env=os.environ | own, stdout=subprocess.DEVNULL, stderr=said)
        _compiling[name] = child, said
        threading.Thread(target=child.wait, daemon=True).start()  # else it stays when it has ended, defunct
    except OSError as error:
        place.say(f"no process to compile in can be started ({error})")


def _ended_well(child: subprocess.Popen, said: IO[str]) -> bool:
    """Wait for a process that compiles, and pass on its messages."""
    try:
        code = child.wait()
    except BaseException:  # such as Ctrl-C
        child.terminate()
        raise
    with said:
        said.seek(0)
        lines = said.read().splitlines()
    for line in lines:
        if line.startswith(place.PREFIX):
            place.say(line.removeprefix(place.PREFIX))
    if code:
        place.say(f"a process that compiles failed, exit code {code}: {lines[-1] if lines else 'no word'}")
    return code == 0


def structure_module(structure) -> ModuleType:
    """The compiled functions of a structure; equations are derived only if they never were."""
    return _module("module", structure)


def variation_module(structure, directions: tuple[tuple[str, ...], ...] = ()) -> ModuleType:
    """The compiled derivatives of a structure, for tangents.

    `directions`: names of the numbers that change along each (codegen.variation).
    """
    sizes = structure_module(structure).SIZES
    return _module("variation", structure, sizes["first"], bool(sizes["planned"]), directions)


def ensemble_module(structure) -> ModuleType:
    """The compiled equations of a structure (that is `ensemble.known`) for eight trajectories at once."""
    return _module("lanes.equations", structure)


def ensemble_tangents(positions: int) -> ModuleType:
    """The compiled code that carries a tangent with each of eight trajectories of so many positions."""
    return _module("lanes.tangent", positions)


def algebra_module(n_q: int, n: int) -> ModuleType:
    """The compiled algebra of the method for n_q positions and n speeds."""
    return _module("algebra", n_q, n)


def ensemble_algebra(turning: tuple[float, ...], *sizes: int) -> ModuleType:
    """The compiled algebra of the method for eight trajectories at once (codegen.lanes.algebra)."""
    return _module("lanes.algebra", turning, *sizes)


@lru_cache(maxsize=KEPT)
def _module(writer: str, *given: Any) -> ModuleType:
    """The module that a writer of this package makes of a structure or of sizes, kept once it is loaded.

    What is given decides the text, since the digest decides the writer: neither changes within a process.
    """
    key = f"{writer} {given!r}"
    name = place.read(f"{_short(key)}.name")
    if name is None or place.read(f"{name.decode()}.py") is None:
        place.compiling(key)
        source = _text(writer, *given)
        name = f"k{_short(source)}".encode()
        place.write(f"{name.decode()}.py", source.encode())
        place.write(f"{_short(key)}.name", name)
    module = generated.load(name.decode(), method)
    place.settle()
    return module


def _text(writer: str, *given: Any) -> str:
    """The text of a module; writers are loaded late, since most of them need SymPy."""
    written = importlib.import_module(f".{writer}", __package__).text
    if isinstance(given[0], Linkage | Oscillator):
        from ..equations.write import system

        given = system(given[0]), *given[1:]
    return written(*given)


def _short(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
