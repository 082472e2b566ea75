"""Expressions as text: a grammar of its own makes trees of them, and nothing in them is run.

    sum = ["+" | "-"] term {("+" | "-") term}       term = factor {("*" | "/") factor}
    factor = ("+" | "-") factor | power             power = atom ["**" factor]
    atom = number | name | name "(" sum {"," sum} ")" | "(" sum ")"

Precedence is Python's: ``-x**2`` is -(x²), and ``2**-x`` is accepted. A tree becomes whatever its operations
are given as: numbers, or SymPy's expressions (equations.own).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from ..errors import InputError, refuse

FUNCTIONS = {  # and how many arguments each takes, at least and at most
    **dict.fromkeys(("sin", "cos", "tan", "sqrt", "exp", "log", "tanh", "abs", "sign"), (1, 1)),
    **dict.fromkeys(("max", "min"), (2, 9)),
}
CONSTANTS = {"pi": math.pi}
LONGEST, DEEPEST = 2000, 50  # characters of a text, brackets and signs within one another
ACCEPTED = "numbers, names, + - * / ** and brackets are accepted"
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
_TOKEN = re.compile(
    rf"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|({_NAME.pattern})|(\*\*|[-+*/(),]))"
)
_BINARY = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow}
_NUMBERS = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "tanh")},
    "abs": abs,
    "sign": lambda x: math.copysign(1.0, x),
    "max": max,
    "min": min,
}


class Tree(NamedTuple):
    """An operation or function of `parts`; with none a ``number`` or ``name``, whose `value` it is."""

    operation: str
    parts: tuple[Tree, ...] = ()
    value: Any = None

    @property
    def names(self) -> set[str]:
        """Names that occur, but for functions and constants."""
        own = {self.value} - CONSTANTS.keys() if self.operation == "name" else set()
        return own.union(*(part.names for part in self.parts))

    def made_of(self, names: Mapping[str, Any], functions: Mapping[str, Callable], number: Callable) -> Any:
        """What the tree is, of given names, functions and maker of numbers."""
        if self.operation == "number":
            return number(self.value)
        if self.operation == "name":
            return names[self.value] if self.value in names else number(CONSTANTS[self.value])
        parts = [part.made_of(names, functions, number) for part in self.parts]
        if self.operation == "negative":
            return -parts[0]
        return {**_BINARY, **functions}[self.operation](*parts)


def is_name(text: str) -> bool:
    """Whether a text can be a name: a letter, then letters, digits and _."""
    return _NAME.fullmatch(text) is not None


@lru_cache(maxsize=4096)
def parse(text: str) -> Tree:
    """Make a tree of an expression.

    Raises
    ------
    InputError
        Where the text is none, with the column.
    """
    if len(text) > LONGEST:
        raise refuse(text, f"an expression of at most {LONGEST} characters is accepted")
    reader = _Reader(text)
    tree = reader.sum(0)
    if reader.kind != "end":
        raise reader.wrong("an operator")
    return tree


def number(text: str, names: Mapping[str, float]) -> float:
    """Value of an expression of numbers.

    Raises
    ------
    InputError
        If it has no finite value there.
    """
    try:
        value = parse(text).made_of(names, _NUMBERS, float)
        if not isinstance(value, complex) and math.isfinite(value):
            return float(value)
    except (ArithmeticError, ValueError) as error:
        if isinstance(error, InputError):
            raise
    raise refuse(text, "an expression with a finite value is accepted: with these numbers it has none")


class _Reader:
    """Reads a text token by token; `kind` and `token` are those at hand."""

    def __init__(self, text: str) -> None:
        self.text, self.end = text, 0
        self.next()

    def next(self) -> None:
        self.start = self.end + len(self.text[self.end :]) - len(self.text[self.end :].lstrip())
        if self.start == len(self.text):
            self.kind = self.token = "end"
            return
        found = _TOKEN.match(self.text, self.end)
        if found is None:
            raise self.wrong("another sign", "a name" if self.text[self.start].isalpha() else "")
        self.end, self.token = found.end(), found[found.lastindex]
        self.kind = ("number", "name", "sign")[found.lastindex - 1]

    def wrong(self, wanted: str, what: str = "") -> InputError:
        at = self.text[self.start :][:12] or "the end"
        more = " (letters of names are a to z)" if what else ""
        more = " (a power is **)" if at[0] == "^" else more
        return refuse(
            self.text, f"{wanted} is needed at column {self.start + 1}, where {at!r} stands; {ACCEPTED}{more}"
        )

    def took(self, *signs: str) -> str:
        """The sign at hand if it is one of these, which is then passed; empty otherwise."""
        if self.kind != "sign" or self.token not in signs:
            return ""
        sign = self.token
        self.next()
        return sign

    def sum(self, depth: int) -> Tree:
        return self._chain(("+", "-"), lambda: self._chain(("*", "/"), lambda: self.factor(depth)))

    def _chain(self, signs: tuple[str, ...], part: Callable[[], Tree]) -> Tree:
        tree, count = part(), 0
        while sign := self.took(*signs):
            tree, count = Tree(sign, (tree, part())), count + 1
            if count > LONGEST // 8:
                raise refuse(self.text, f"sums and products of at most {LONGEST // 8} parts are accepted")
        return tree

    def factor(self, depth: int) -> Tree:
        if depth > DEEPEST:
            raise refuse(self.text, f"brackets and signs at most {DEEPEST} deep are accepted")
        if sign := self.took("+", "-"):
            inner = self.factor(depth + 1)
            return inner if sign == "+" else Tree("negative", (inner,))
        base = self.atom(depth + 1)
        return Tree("**", (base, self.factor(depth + 1))) if self.took("**") else base

    def atom(self, depth: int) -> Tree:
        kind, token = self.kind, self.token
        if kind == "number":
            self.next()
            return self.numeral(token)
        if kind == "name":
            self.next()
            return self.call(token, depth) if token in FUNCTIONS else Tree("name", value=token)
        if not self.took("("):
            raise self.wrong("a number, a name or a bracket")
        inner = self.sum(depth)
        self.close()
        return inner

    def numeral(self, token: str) -> Tree:
        value = int(token) if token.isdigit() and len(token) < 16 else float(token)
        if not math.isfinite(value):
            raise refuse(self.text, f"a number that a float can hold is accepted, not {token}")
        return Tree("number", value=value)

    def call(self, name: str, depth: int) -> Tree:
        if not self.took("("):
            raise self.wrong(f"( after the function {name}")
        parts, (least, most) = [self.sum(depth)], FUNCTIONS[name]
        while self.took(","):
            parts.append(self.sum(depth))
        if not least <= len(parts) <= most:
            count = "one argument" if most == 1 else f"{least} to {most} arguments"
            raise refuse(self.text, f"{count} of {name} is accepted, not {len(parts)}")
        self.close()
        return Tree(name, tuple(parts))

    def close(self) -> None:
        if not self.took(")"):
            raise self.wrong(")")
