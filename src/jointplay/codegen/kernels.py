"""Numba's cache of compiled functions, over files that are believed only as they were written.

Numba unpickles what it finds, numbers the data files of a function, and lets two processes that compile
different versions of it at once write the same number, so that one of them finds the other's code. Here a
data file is named by its content, and the index of a function names those of its versions.
"""

from __future__ import annotations

import hashlib
import linecache
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from ..numerics.numba_private import CompileResultCacheImpl, FunctionCache, _CacheLocator, dumps
from . import place

WRITTEN_DOWN = ("jointplay.numerics.", "jointplay.codegen.generated.")  # modules that the digest tells apart
_loads_only = ContextVar("loads_only", default=False)


class MissingError(Exception):
    """A function that was to be loaded is not in the cache, or not whole."""


@contextmanager
def loads_only() -> Iterator[None]:
    """Compile nothing inside: raise `MissingError` instead."""
    token = _loads_only.set(True)
    try:
        yield
    finally:
        _loads_only.reset(token)


class _Locator(_CacheLocator):
    """Looks for no folder: files have names only."""

    def __init__(self, function: Callable, file: str) -> None:
        self._known = function.__module__.startswith(WRITTEN_DOWN)
        self._py_file, self._line = file, function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Callable, file: str) -> _Locator:
        return cls(function, file)

    def ensure_cache_path(self) -> None:
        pass

    def get_cache_path(self) -> str:
        return ""

    def get_source_stamp(self) -> str:
        text = "" if self._known else "".join(linecache.getlines(self._py_file))
        return hashlib.sha256(text.encode()).hexdigest()

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Results(CompileResultCacheImpl):
    _locator_classes = (_Locator,)


class Kernels(FunctionCache):
    """The cache of one compiled function.

    Parameters
    ----------
    function : callable
        The function as it was written.
    """

    _impl_class = _Results

    def __init__(self, function: Callable) -> None:
        super().__init__(function)
        self._module = function.__module__
        name = f"{function.__module__}.{function.__qualname__}-{function.__code__.co_firstlineno}"
        self._cache_file = _Files(name.replace("<locals>.", ""), self._impl.locator.get_source_stamp())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load a version; None where it has to be compiled."""
        try:
            found = super().load_overload(sig, target_context)
        except MemoryError:
            raise
        except Exception as error:  # files as they were written, but not for this machine
            self._cache_file.forget(error)
            found = None
        if found is None and _loads_only.get():
            raise MissingError(self._name)
        if found is None:
            place.compiling(self._module)
        return found


class _Files:
    """The index of a function, ``NAME.nbi``, and a data file for each of its versions, ``NAME.HASH.nbc``."""

    def __init__(self, name: str, stamp: object) -> None:
        self._name, self._stamp = name, stamp

    def load(self, key: Any) -> Any:
        file = self._index().get(key)
        data = None if file is None else place.read(file)
        return None if data is None else pickle.loads(data)

    def save(self, key: Any, result: Any) -> None:
        data = dumps(result)
        file = f"{self._name}.{hashlib.sha256(data).hexdigest()[:16]}.nbc"
        place.write(file, data)
        self._write(self._index() | {key: file})

    def flush(self) -> None:
        self._write({})

    def forget(self, why: Exception) -> None:
        place.discard(place.folder() / f"{self._name}.nbi", f"cannot be loaded ({why})")

    def _index(self) -> dict[Any, str]:
        data = place.read(f"{self._name}.nbi")
        stamp, files = (self._stamp, {}) if data is None else pickle.loads(data)
        return files if stamp == self._stamp else {}

    def _write(self, files: dict[Any, str]) -> None:
        place.write(f"{self._name}.nbi", dumps((self._stamp, files)))
