"""Generated modules: their texts lie in the cache folder, and run only as they were written.

Of a text its constants are executed; its functions are machine code (codegen.instructions), kept as an object
file beside it. Where nothing is compiled ($NUMBA_DISABLE_JIT), or places in arrays are checked
($NUMBA_BOUNDSCHECK), the whole text is a module of plain Python.
"""

from __future__ import annotations

import ast
import ctypes
import importlib
import marshal
import sys
from collections.abc import Callable
from functools import cache
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from ...codegen import place
from ...method.interface import interpreted

WORDS = 7  # of an array, in a call by address
FLOAT = np.dtype(float)


def load(name: str, method: Callable) -> ModuleType:
    """The module of a text that was written under a name; `method` is cache.method."""
    if interpreted():
        return importlib.import_module(f"{__name__}.{name}")
    module = ModuleType(f"{__name__}.{name}", "Constants of a generated text, and its functions compiled.")
    exec(_constants(name), vars(module))
    library, entries = _compiled(name, method)
    for function, kinds in entries.items():
        setattr(module, function, Function(library, function, kinds))
    return module


def source(module: ModuleType) -> str:
    """The text of a generated module, of which compiled functions hold nothing."""
    return _text(module.__name__.rpartition(".")[2])


def _text(name: str) -> str:
    text = place.read(f"{name}.py")
    if text is None:
        raise ModuleNotFoundError(f"{name} is not in the kernel cache", name=f"{__name__}.{name}")
    return "\n" + text.decode()  # the first line of the file is its seal


def _constants(name: str) -> CodeType:
    """Definitions of a text, apart from functions, that need no import."""
    if (kept := _kept(f"{name}.constants")) is not None:
        return kept
    tree = ast.parse(_text(name))
    assigned = (each for each in tree.body if isinstance(each, ast.Assign))
    plain = [each for each in assigned if not any(isinstance(part, ast.Call) for part in ast.walk(each))]
    code = compile(ast.Module(plain, []), str(place.folder() / f"{name}.py"), "exec")
    place.write(f"{name}.constants", marshal.dumps(code))
    return code


def _kept(file: str) -> Any:
    """Content kept in a file; None where there is none, or none that this Python can load."""
    if (data := place.read(file)) is None:
        return None
    try:
        return marshal.loads(data)
    except (EOFError, ValueError, TypeError) as error:
        place.discard(place.folder() / file, f"cannot be loaded ({error})")
        return None


def _compiled(name: str, method: Callable) -> tuple[place.Library, dict[str, str]]:
    """The functions of a text in memory, and the kinds of their arguments (`Function`)."""
    file = f"{name}.{place.target().digest}.o"
    if (kept := _kept(file)) is None:
        from ..instructions import written

        place.compiling(name)
        instructions, entries, outside = written(_text(name))
        kept = entries, outside, place.emit(instructions)
        place.write(file, marshal.dumps(kept))
    entries, outside, code = kept
    return place.Library(code, {each: _address(each, method) for each in outside}), entries


@cache
def _address(name: str, method: Callable) -> int:
    """Address of a function of the method that generated code calls by name."""
    module, _, function = name.rpartition(".")
    return getattr(method(module.removeprefix("jointplay.solver.method.")), function).address


class Function:
    """A compiled function of a generated text: an address for compiled code, a call for Python.

    Parameters
    ----------
    library : Library
        Where it is.
    name : str
        Its name there.
    kinds : str
        What it returns (v: nothing, f: a number, b: a truth), then of each argument a letter (a: an array of
        floats, f: a number, i: an integer).
    """

    __slots__ = ("__name__", "_call", "_kinds", "_library", "address")
    RETURNED = {"v": ctypes.c_void_p, "f": ctypes.c_double, "b": ctypes.c_bool}  # noqa: RUF012
    TAKEN = {"a": (ctypes.c_ssize_t,) * WORDS, "f": (ctypes.c_double,), "i": (ctypes.c_ssize_t,)}  # noqa: RUF012

    def __init__(self, library: place.Library, name: str, kinds: str) -> None:
        self.__name__, self._library, self._kinds = name, library, kinds[1:]
        self.address = library.address(name)
        taken = [word for kind in self._kinds for word in self.TAKEN[kind]]
        self._call = ctypes.PYFUNCTYPE(self.RETURNED[kinds[0]], *taken)(self.address)

    def __call__(self, *arguments: Any) -> Any:
        words: list[Any] = []
        for kind, given in zip(self._kinds, arguments, strict=True):
            if kind == "a":
                if given.dtype != FLOAT or given.ndim != 1 or not given.flags.c_contiguous:
                    raise TypeError(f"{self.__name__}: arrays of floats that lie together are taken")
                n = len(given)
                words += (0, 0, n, 8, given.__array_interface__["data"][0], n, 8)
            else:
                words.append(given)
        return self._call(*words)

    def __repr__(self) -> str:
        return f"<compiled function {self.__name__}>"


class _Written(MetaPathFinder, InspectLoader):
    """Finds and loads texts as modules of Python; their bytecode is kept with them."""

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        package, _, name = fullname.rpartition(".")
        if package != __name__ or place.read(f"{name}.py") is None:
            return None
        return spec_from_file_location(fullname, place.folder() / f"{name}.py", loader=self)

    def get_source(self, fullname: str) -> str:
        return _text(fullname.rpartition(".")[2])

    def get_code(self, fullname: str) -> CodeType:
        name = fullname.rpartition(".")[2]
        if (kept := place.read(f"{name}.pyc")) is not None:
            return marshal.loads(kept)
        code = self.source_to_code(self.get_source(fullname), str(place.folder() / f"{name}.py"))
        place.write(f"{name}.pyc", marshal.dumps(code))
        return code

    def is_package(self, fullname: str) -> bool:
        return False


sys.meta_path.insert(0, _Written())
