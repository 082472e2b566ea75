"""Errors in what a user gave: every problem at once, with its key path, the value and what is accepted.

Only the standard library is imported here, so that the command line can start and fail fast; pydantic's
errors and models are read by their attributes alone.
"""

from __future__ import annotations

import difflib
import numbers
import reprlib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any


class _Nothing:
    """Stands for a value that was not given."""

    def __repr__(self) -> str:
        return "nothing"


NOTHING = _Nothing()
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = 120


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
    expected: str

    def __str__(self) -> str:
        key = self.key if self.key.isprintable() and self.key == self.key.strip() else repr(self.key)
        return f"{key or 'input'}: got {_shown(self.given)}; {self.expected}"


class InputError(ValueError):
    """The input is wrong; `problems` lists everything that is wrong with it.

    Parameters
    ----------
    problems : iterable of Problem
        At least one.
    root : str, optional
        The part of every key that names the thing being built; `under` puts another in its place.
    """

    def __init__(self, problems: Iterable[Problem], root: str = "") -> None:
        self.problems: list[Problem] = list({str(problem): problem for problem in problems}.values())
        self.root = root
        super().__init__(self.problems, root)  # what pickle hands back to __init__, in a worker or here

    def __str__(self) -> str:
        return "\n".join(map(str, self.problems))

    def under(self, root: str) -> InputError:
        """Give the same problems with their keys under another root, such as ``mechanism``."""
        tails = (problem.key.removeprefix(self.root) for problem in self.problems)
        moved = (replace(p, key=join(root, tail)) for p, tail in zip(self.problems, tails, strict=True))
        return InputError(moved, root)


def refuse(given: Any, expected: str, key: str = "") -> InputError:
    """Make the error of one problem; inside a record's validator the key is relative to the field."""
    return InputError([Problem(key, given, expected)])


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Suggest the nearest known name, as `` did you mean 'clearance'?``; empty if none is near."""
    near = difflib.get_close_matches(str(word), list(known), n=1, cutoff=0.6)
    return f" did you mean {near[0]!r}?" if near else ""


def unknown(key: str, given: Any, word: object, known: Iterable[str], what: str = "key") -> Problem:
    """Describe a name that is not known.

    Parameters
    ----------
    key, given
        As in `Problem`.
    word : str
        The unknown name itself.
    known : iterable of str
        The names that exist.
    what : str
        What the name should be the name of: ``key``, ``link``, ``joint``, ...
    """
    known = list(known)
    names = ", ".join(known) if known else "none"
    return Problem(key, given, f"no such {what}:{did_you_mean(word, known)} accepted: {names}")


def join(root: str, tail: str) -> str:
    """Join two parts of a key path: ``links[0]`` and ``mass`` to ``links[0].mass``."""
    tail = tail.removeprefix(".")
    return root + tail if not root or not tail or tail.startswith("[") else f"{root}.{tail}"


def from_pydantic(error: Any, model: Any = None, root: str = "") -> InputError:
    """Turn a pydantic ``ValidationError`` into an `InputError`.

    Parameters
    ----------
    error : pydantic.ValidationError
        What pydantic raised.
    model : type, optional
        The model that was validated: gives the known keys, and nouns and units of its fields.
    root : str, optional
        Put before every key, as ``mechanism`` in ``mechanism.links[0].mass``.
    """
    from jointplay.accepted import problems

    details = error.errors(include_url=False)
    return InputError((problem for detail in details for problem in problems(detail, model, root)), root)


def _shown(given: Any) -> str:
    if getattr(given, "ndim", None) == 0 and hasattr(given, "item"):
        given = given.item()
    return repr(given) if isinstance(given, numbers.Number) else _SHORT.repr(given)
