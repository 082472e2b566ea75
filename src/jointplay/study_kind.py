"""What the program has to know of a kind of study beside its keywords: the record of a row of `kinds`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

LENGTH = "{turns} turns after {transient} dropped turns"


@dataclass(frozen=True)
class Shown:
    """Default quantity in the figure of a whole sweep.

    Parameters
    ----------
    name : str
        A variable of the result at each point.
    entries : tuple of (str, object)
        The entry that is taken along each of its own dimensions.
    title : str
        Its title, where the variable's own name will not do.
    """

    name: str
    entries: tuple[tuple[str, Any], ...] = ()
    title: str = ""


@dataclass(frozen=True)
class Kind:
    """A kind of study.

    Parameters
    ----------
    name : str
        As study files and results call it.
    home : str
        Where its analysis function is, as ``package.module:function``; a leading dot stands for this package.
    figures : tuple of str
        Figures of its result; the default is the first whose variables it has. A figure can add itself.
    length : str
        Length of a study of this kind, in a line, with its keywords in braces.
    shown : tuple of Shown
        Default quantities of a sweep's figure; the first whose variable the result has is taken.
    recorded : str
        Where the function is that names the recorded quantities, given ``record`` and the mechanism.
    varies : bool
        Whether a study of this kind may have a table `[vary]`.
    tangents : bool
        Whether tangents are propagated, so that their code is compiled before workers start.
    kept : bool
        Whether an interrupted run keeps what it has computed so far as a result.
    table, summary : str
        Where the functions are that write a result as text: a whole table for a file; its answer, in one to
        three lines. Empty: no table; of the answer, the number that a sweep shows.
    verdict : str
        Where the function is that says the answer of each cell of a sweep in a word, such as ``chaotic``.
    slow : int
        Rank among studies that run side by side: the larger, the earlier it begins.
    example : mapping of str to mapping
        What a new study of this kind sets (`jointplay new`) beside defaults: tables by name.
    """

    name: str
    home: str
    figures: tuple[str, ...] = ()
    length: str = LENGTH
    shown: tuple[Shown, ...] = ()
    recorded: str = ".analysis.quantities:recorded"
    varies: bool = True
    tangents: bool = False
    kept: bool = False
    table: str = ""
    summary: str = ""
    verdict: str = ""
    slow: int = 0
    example: Mapping[str, Mapping[str, Any]] = field(default_factory=dict, hash=False)

    @property
    def function(self) -> Callable[..., Any]:
        """The analysis function."""
        return load(self.home)


def load(home: str) -> Any:
    """Import what stands at a place such as ``.analysis.simulate:simulate``."""
    module, _, name = home.partition(":")
    return getattr(import_module(module, __package__), name)
