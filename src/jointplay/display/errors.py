"""Errors in a user's input: every problem at once, with its key path, its value and the accepted ones.

Only the standard library is needed here, so that the command line can start and fail fast; pydantic's
errors and models are read by their attributes alone.

The seal of a result: a digest of all that is in it, by which one that was changed afterwards is known.
"""

from __future__ import annotations

import difflib
import numbers
import reprlib
import sys
import traceback
import warnings
from collections import UserString
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.metadata import version
from itertools import islice, takewhile
from typing import TYPE_CHECKING, Any

from jointplay.display.number_text import typed

if TYPE_CHECKING:
    import xarray as xr

SEAL = "seal"  # the attribute that holds it
CLOCKS = ("wall_time",)  # whose values differ between runs that are otherwise the same


class _Nothing:
    """Placeholder of a value that was not given."""

    def __repr__(self) -> str:
        return "nothing"


NOTHING = _Nothing()


class _Short(reprlib.Repr):
    def repr_float(self, x: float, level: int) -> str:
        rounded = float(f"{x:.15g}")
        return typed(rounded, 0) if "e" in repr(rounded) else repr(rounded)

    def repr_int(self, x: int, level: int) -> str:  # Python itself refuses to write thousands of digits
        digits = int(x.bit_length() / 3.3219)
        return repr(x) if abs(x) < 10**self.maxlong else f"<a number of {digits} digits>"

    def repr_Dataset(self, x, level: int) -> str:  # xarray's own runs over many lines
        return f"<Dataset of kind {x.attrs.get('kind')!r}>"

    def repr_DataArray(self, x, level: int) -> str:
        return f"<DataArray {x.name!r}>"


_SHORT = _Short()


_SHORT.maxstring = _SHORT.maxother = 120


PARTLY = 3  # names suggested that have the unknown one as a part


SHOWN = 100  # problems that a message names one by one


@dataclass(frozen=True)
class Problem:
    """One thing wrong with the input.

    Parameters
    ----------
    key : str
        Where it is, such as ``mechanism.links[0].mass``.
    given : object
        The value found there; `NOTHING` where a value is missing.
    expected : str
        What would be accepted there, as a sentence in plain English with units.
    """

    key: str
    given: Any
    expected: str | UserString

    def __str__(self) -> str:
        key = self.key if self.key.isprintable() and self.key == self.key.strip() else repr(self.key)
        expected = " ".join(str(self.expected).splitlines())  # names in files of others may have line breaks
        return f"{key or 'input'}: got {_shown(self.given)}; {expected}"


class InputError(ValueError):
    """The input is wrong; `problems` lists every problem, and the text the first hundred of them.

    Parameters
    ----------
    problems : iterable of Problem
        At least one.
    root : str, optional
        The part of every key that names the thing being built; `under` puts another in its place.
    more : int, optional
        How many problems there are beside these, where there are too many to list.
    """

    def __init__(self, problems: Iterable[Problem], root: str = "", more: int = 0) -> None:
        rest = iter(problems)  # to compare more of them than are shown would take long
        shown = {str(problem): problem for problem in islice(rest, SHOWN)}
        self.problems: list[Problem] = [*shown.values(), *rest]
        self.root, self.more = root, more
        super().__init__(self.problems, root, more)  # what pickle hands back to __init__, in a worker or here

    @property
    def count(self) -> int:
        """Number of problems."""
        return len(self.problems) + self.more

    def __str__(self) -> str:
        left = self.count - len(self.problems[:SHOWN])
        return "\n".join([*map(str, self.problems[:SHOWN]), *([f"and {left} more"] if left else [])])

    def under(self, root: str) -> InputError:
        """Give the same problems with their keys under another root, such as ``mechanism``."""
        tails = (problem.key.removeprefix(self.root) for problem in self.problems)
        moved = (replace(p, key=join(root, tail)) for p, tail in zip(self.problems, tails, strict=True))
        return InputError(moved, root, self.more)


class ModelWarning(UserWarning):
    """A result is computed, but lies beyond the range that its model describes."""


def warn(text: str) -> dict[str, str]:
    """Warn the first caller outside this package, by a `ModelWarning`; the text as a result's attribute."""
    frames = (frame.f_globals.get("__name__", "") for frame, _ in traceback.walk_stack(sys._getframe(1)))
    inside = takewhile(lambda name: name.startswith("jointplay."), frames)
    warnings.warn(text, ModelWarning, stacklevel=2 + sum(1 for _ in inside))
    return {"warning": text}


def refuse(given: Any, expected: str, key: str = "") -> InputError:
    """Make the error of one problem; inside a record's validator the key is relative to the field."""
    return InputError([Problem(key, given, expected)])


def raise_any(problems: Iterable[Problem], root: str = "") -> None:
    """Raise an `InputError` of these problems, where there are any."""
    if found := list(problems):
        raise InputError(found, root)


def problems_of(call: Callable[..., Any], *given: Any) -> list[Problem]:
    """Problems for which a call refuses its arguments; none where it takes them."""
    try:
        call(*given)
    except InputError as error:
        return error.problems
    return []


@contextmanager
def of_a_result(given: Any, but: Callable[[Exception], bool] = lambda error: False) -> Iterator[None]:
    """Turn an error in showing a result that was changed since it was computed into an `InputError`.

    Files of others, of other versions, and datasets changed in Python lack what code counts on in more ways
    than could be asked for beforehand. In a result that is as it was sealed an error is a fault of this
    program, and stays as it is, as do those for which `but` is true. The error that came is the cause of the
    one that is raised.
    """
    try:
        yield
    except (InputError, OSError, MemoryError):
        raise
    except Exception as error:
        if but(error) or intact(given):
            raise
        why = " ".join(f"{type(error).__name__}: {error}".split())[: _SHORT.maxother]
        expected = (
            "a result as this version computes it is accepted; this one is damaged, changed, or of another"
        )
        raise refuse(given, f"{expected} version ({why})", "result") from error


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Suggest the nearest known name, or names with this part, as `` did you mean 'clearance'?``."""
    if not isinstance(word, str):
        return ""
    known = list(known)
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.6)
    near = near or [name for name in known if word.lower() in name.lower().split("_")][:PARTLY]
    return f" did you mean {' or '.join(map(repr, near))}?" if near else ""


def unknown(key: str, given: Any, word: object, known: Iterable[str], what: str = "key") -> Problem:
    """Describe a name that is not known.

    Parameters
    ----------
    key, given
        As in `Problem`.
    word : str
        The unknown name itself.
    known : iterable of str
        The names that exist; of a `Table`, what of other packages cannot be loaded is told too.
    what : str
        What it should name: ``key``, ``link``, ``joint``, ...
    """
    return Problem(key, given, _NoSuch(what, word, list(known), getattr(known, "broken", {})))


def with_keys(key: str, words: Iterable[Any] | None) -> Iterator[tuple[str, Any]]:
    """Key and word of every entry of a list under a key."""
    return ((f"{key}[{i}]", word) for i, word in enumerate(words or ()))


def strangers(words: Iterable[tuple[str, Any]], known: Any, what: str = "key") -> Iterator[Problem]:
    """Problems of those words, each with its key, that are none of the known ones."""
    return (unknown(key, word, word, known, what) for key, word in words if word not in known)


def also_known(problem: Problem, names: Iterable[str] = (), without: Iterable[str] = ()) -> Problem:
    """Give the same problem, of a key that is not known, with more known keys, or without some."""
    said = problem.expected
    if not isinstance(said, _NoSuch) or said.what != "key" or said.word != problem.key:
        return problem
    known = [name for name in dict.fromkeys([*names, *said.known]) if name not in [*without]]
    return unknown(problem.key, problem.given, said.word, known)


def no_attribute(whose: str, name: str, known: Iterable[str]) -> AttributeError:
    """Make the error of a name that a module does not have, with the nearest that it has."""
    near, broken = did_you_mean(name, known), getattr(known, "broken", {})
    text = f"{whose} has no attribute {name!r}{near and ':'}{near}"
    text = "; ".join([text, *(f"not loaded: {point}: {why}" for point, why in broken.items())])
    return AttributeError(text, name=name, obj=None)  # or else a traceback says the nearest name again


class _NoSuch(UserString):
    """Message on an unknown name; composed only when it is read, as comparing names takes long."""

    def __init__(self, what: str, word: object, known: list[str], broken: Mapping[str, str]) -> None:
        self.what, self.word, self.known, self.broken = what, word, known, broken

    @cached_property
    def data(self) -> str:
        names = ", ".join(self.known) if self.known else "none"
        near = did_you_mean(self.word, self.known)
        said = f"there is no such {self.what};{near} {'These' if near else 'these'} are accepted: {names}"
        return "; ".join([said, *(f"not loaded: {point}: {why}" for point, why in self.broken.items())])


def join(root: str, tail: str) -> str:
    """Join two parts of a key path: ``links[0]`` and ``mass`` to ``links[0].mass``."""
    tail = tail.removeprefix(".")
    return root + tail if not root or not tail or tail.startswith("[") else f"{root}.{tail}"


def _shown(given: Any) -> str:
    if getattr(given, "ndim", None) == 0 and hasattr(given, "item"):
        given = given.item()
    plain = isinstance(given, numbers.Number) and not isinstance(given, int)
    return repr(given) if plain and not isinstance(given, float) else _SHORT.repr(given)


def sealed(dataset: xr.Dataset) -> xr.Dataset:
    """A copy of a result that holds the seal of its present content."""
    return dataset.assign_attrs({SEAL: _digest(dataset)})


def intact(dataset: Any) -> bool:
    """Whether a result is as this version of the program sealed it, on the disk or in memory."""
    seal = getattr(dataset, "attrs", {}).get(SEAL)
    return isinstance(seal, str) and seal == _digest(dataset)


def _digest(dataset: xr.Dataset) -> str:
    import hashlib

    total = hashlib.sha256(version("jointplay").encode())
    for part in _parts(dataset):
        total.update(part)
    return total.hexdigest()[:16]


def _parts(dataset: xr.Dataset) -> Iterator[bytes]:
    """Content in an order of its own, in forms that a file gives back as they were."""
    import numpy as np

    yield repr(_plain(dataset.attrs)).encode()
    for name in sorted(map(str, dataset.variables)):
        variable = dataset.variables[name]
        values = np.asarray(variable.values)
        text = values.dtype.kind in "OU"
        kind = "text" if text else values.dtype.str
        yield repr((name, variable.dims, values.shape, kind, _plain(variable.attrs))).encode()
        if name not in CLOCKS:
            yield repr(values.tolist()).encode() if text else np.ascontiguousarray(values).tobytes()


def _plain(attributes: Mapping[Any, Any]) -> list[tuple[str, Any]]:
    """Attributes by name, numbers as lists of numbers; the seal is no part of what it is a digest of."""
    import numpy as np

    return sorted((str(name), np.ravel(each).tolist()) for name, each in attributes.items() if name != SEAL)
