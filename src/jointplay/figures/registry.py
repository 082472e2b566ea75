"""The figures by name, and their requirements; a file that marks its function by `picture` adds it.

A figure is a function from a dataset and options, by keyword, to a matplotlib Figure; each has a file here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from inspect import signature
from typing import Any

from jointplay.display.errors import Problem
from jointplay.figures.drawing import Figure, style
from jointplay.kinds import KINDS as STUDIES
from jointplay.kinds import Kind
from jointplay.solver.extensions import Table

Options, Keywords = Mapping[str, Any], Mapping[str, Any]


@dataclass(frozen=True)
class About:
    """Requirements of a figure.

    Parameters
    ----------
    of : tuple of str
        Kinds of study that it suits, beside those whose rows name it.
    needs : tuple of str
        Variables that the result must have.
    pair : bool
        Whether it draws one of two recorded quantities over the other.
    clearance : bool
        Whether it draws a joint with clearance.
    over : int
        Number of varied parameters of which it is the default figure; 0: it does not matter.
    choices : mapping of str to collection of str
        By option: the words that it can be.
    checks : mapping of str to callable
        By option: raises an `InputError` where its value makes no sense, whatever the result.
    least : float
        Width in mm below which its panels and labels have no room.
    fits : callable
        Given the figure's options and a study's keywords: the problems of drawing the one from the other.
    """

    of: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    pair: bool = False
    clearance: bool = False
    over: int = 0
    choices: Mapping[str, Collection[str]] = field(default_factory=dict)
    checks: Mapping[str, Callable[[Any], Any]] = field(default_factory=dict)
    least: float = 20.0
    fits: Callable[[Options, Keywords], Iterator[Problem]] = lambda options, keywords: iter(())


GENERAL = ("width", "font", "ax")  # options that every figure has
KINDS: Table[Callable[..., Figure]] = Table("jointplay.figures", Callable)
ABOUT: dict[str, About] = {}


def picture(**about: Any) -> Callable[[Callable[..., Figure]], Callable[..., Figure]]:
    """Add a function to the figures, in their style, under its own name; keywords as of `About`."""

    def added(draw: Callable[..., Figure]) -> Callable[..., Figure]:
        KINDS[draw.__name__], ABOUT[draw.__name__] = style.paper()(draw), About(**about)
        return KINDS[draw.__name__]

    return added


def suited(row: Kind | None) -> tuple[str, ...]:
    """Figures that suit a result of a kind of study, the usual one first."""
    if row is None:
        return ()
    others = (name for name in KINDS if row.name in ABOUT[name].of)
    return tuple(dict.fromkeys((*row.figures, *others)))


def usual(names: Collection[str], options: Collection[str], over: int) -> str | None:
    """Return the default among figures: made for so many varied parameters, and with the given options."""
    first = sorted(names, key=lambda name: ABOUT[name].over != over if name in ABOUT else True)
    having = (name for name in first if name in KINDS and {*options} <= {*GENERAL, *keywords(name)})
    return next(having, next(iter(names), None))


def keywords(name: str) -> list[str]:
    """Return the options of a figure."""
    return list(signature(KINDS[name]).parameters)[1:]


def suited_to(kind: Any) -> tuple[str, ...]:
    """Figures that suit a result which says that it is of a kind."""
    return suited(STUDIES.get(str(kind)))
