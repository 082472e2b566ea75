"""Expressions as text: a grammar of its own makes trees of them, and nothing in them is run.

    sum = ["+" | "-"] term {("+" | "-") term}       term = factor {("*" | "/") factor}
    factor = ("+" | "-") factor | power             power = atom ["**" factor]
    atom = number | name | name "(" sum {"," sum} ")" | "(" sum ")"

Precedence is Python's: ``-x**2`` is -(x²), and ``2**-x`` is accepted. A tree becomes whatever its operations
are given as: numbers, or SymPy's expressions (equations.own.own).
"""

from __future__ import annotations

import itertools
import math
import operator
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import lru_cache, reduce
from typing import Any, NamedTuple

from ....display.errors import InputError, refuse

FUNCTIONS = {  # and how many arguments each takes, at least and at most
    **dict.fromkeys(("sin", "cos", "tan", "sqrt", "exp", "log", "tanh", "abs", "sign"), (1, 1)),
    **dict.fromkeys(("max", "min"), (2, 9)),
}
CONSTANTS = {"pi": math.pi}
LARGEST = 10_000  # operations of an expression written out with its slopes, and where needed with theirs
LONGEST, DEEPEST = 2000, 50  # characters of a text, brackets and signs within one another
TALLEST = LONGEST // 8  # operations one upon the other: each takes some of Python's stack
BRANCHES, FLAGS = 256, 4  # sides of kinks, and switches, with which an expression is looked at
ROUNDED = 1e-12  # of the size of its terms, whose sum is 0 then
ZERO = (
    "an expression is accepted that is 0 at instants alone, as signs and guards need: this one is 0 over a "
    "stretch; in the place of sign(max(x, 0)), max(sign(x), 0) is accepted"
)
PLAIN = 100.0  # orders of magnitude below which products of numbers are far from overflow
ACCEPTED = "numbers, names, + - * / ** and brackets are accepted"
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
_TOKEN = re.compile(
    rf"\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|({_NAME.pattern})|(\*\*|[-+*/(),]))"
)
_BINARY = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow}


def _power(base: float, exponent: float) -> float:
    value = base**exponent
    if isinstance(value, complex):
        raise ValueError  # of a negative number
    return value


_NUMBERS = {
    "**": _power,
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

    def deeper_than(self, most: int) -> bool:
        """Whether more than so many operations stand one upon the other."""
        level: list[Tree] = [self]
        for _ in range(most + 1):
            level = [part for tree in level for part in tree.parts]
        return bool(level)

    def made_of(self, names: Mapping[str, Any], functions: Mapping[str, Callable], number: Callable) -> Any:
        """The tree as an object, made of given names, functions and maker of numbers."""
        if self.operation == "number":
            return number(self.value)
        if self.operation == "name":
            return names[self.value] if self.value in names else number(CONSTANTS[self.value])
        parts = [part.made_of(names, functions, number) for part in self.parts]
        if self.operation == "negative":
            return -parts[0]
        return {**_BINARY, **functions}[self.operation](*parts)


class Size(NamedTuple):
    """Operations of an expression written out, of its slopes together, and of theirs; and its kinks."""

    value: int
    slope: int
    bend: int
    kinks: int = 0

    def __add__(self, other: Size) -> Size:  # type: ignore[override]
        return Size(*(a + b for a, b in zip(self, other, strict=True)))

    def copied(self, times: int) -> Size:
        """The size of so many copies, whose kinks are the same."""
        return Size(times * self.value, times * self.slope, times * self.bend, self.kinks)


@lru_cache(maxsize=4096)
def size(text: str) -> Size:
    """Give the size of an expression: of its value and of its slopes, written out as equations."""
    return _size(parse(text))


def _size(tree: Tree) -> Size:
    if not tree.parts:
        return Size(1, int(tree.operation == "name"), 0)
    parts = [_size(part) for part in tree.parts]
    if tree.operation in ("max", "min"):  # two by two, each with a sign between them
        return _compared(parts)
    total = sum(parts[1:], parts[0])
    if tree.operation in ("+", "-", "negative"):
        return total._replace(value=total.value + 1)
    if tree.operation in ("*", "/", "**"):  # the slope of each factor, beside all others
        factors = _factors(tree)
        each = [_size(factor) for factor in factors] if len(factors) > 2 else parts
        value, count = total.value + 1, len(each)
        slope = sum(part.slope + value for part in each if part.slope)
        bend = sum(part.bend + 2 * count * (part.slope + value) for part in each if part.slope)
        return Size(value, slope, bend, total.kinks)
    if tree.operation in ("abs", "sign"):
        return parts[0].copied(2)._replace(kinks=total.kinks + 1)
    value, slope = total.value + 1, total.slope and total.value + total.slope + 1
    return Size(value, slope, slope and 2 * (value + total.slope) + total.bend, total.kinks)


def _factors(tree: Tree) -> list[Tree]:
    """Factors of a product, which are multiplied one after the other."""
    if tree.operation not in ("*", "/"):
        return [tree]
    found: list[Tree] = []
    while tree.operation in ("*", "/"):
        found.append(tree.parts[1])
        tree = tree.parts[0]
    return [*found, tree]


def _compared(parts: list[Size]) -> Size:
    if len(parts) == 1:
        return parts[0]
    half = (len(parts) + 1) // 2
    both = (_compared(parts[:half]) + _compared(parts[half:])).copied(3)
    return both._replace(value=both.value + 4, kinks=both.kinks + 1)


def too_large(text: str, bends: bool = False) -> str:
    """Describe the accepted expressions instead of one with endless equations; empty if they are not.

    Parameters
    ----------
    text : str
        A right one.
    bends : bool
        Whether slopes of its slopes are needed, as of the guard of an event.
    """
    own = size(text)
    operations = max(own.value, own.slope, own.bend if bends else 0)
    if operations <= LARGEST:
        return ""
    slopes = "its slopes and theirs" if bends else "its slopes"
    most = f"at most {LARGEST:,} operations are accepted of an expression written out with {slopes}"
    return f"{most}, not some {operations:.2g}: fewer factors and brackets make it shorter"


@lru_cache(maxsize=4096)
def constants_finite(text: str) -> bool:
    """Whether all that an expression makes of numbers alone has a finite real value."""
    try:
        _constant(parse(text))
    except (ArithmeticError, ValueError):
        return False
    return True


def _constant(tree: Tree) -> float | None:
    """The value of a tree of numbers; None of one with names, whose parts have been checked."""
    if not tree.parts:
        return None if tree.names else float(CONSTANTS.get(tree.value, tree.value))
    parts = [_constant(part) for part in tree.parts]
    if None in parts:
        return None
    value = -parts[0] if tree.operation == "negative" else {**_BINARY, **_NUMBERS}[tree.operation](*parts)
    if not math.isfinite(value):
        raise ArithmeticError
    return value


def flat(text: str, tells: bool = False, switches: Collection[str] = ()) -> bool:
    """Whether an expression has the sign of what is 0 over a stretch; or, where it `tells` events, is so.

    That is looked for at two points, on either side of each kink, with `switches` in either position, 0 or 1.
    """
    trees = [*_signed(parse(text)), *[parse(text)] * tells]
    return any(_vanishes(tree, switches) for tree in trees)


def _signed(tree: Tree) -> Iterator[Tree]:
    """Arguments of signs in a tree."""
    yield from tree.parts if tree.operation == "sign" else ()
    for part in tree.parts:
        yield from _signed(part)


def _terms(tree: Tree) -> Iterator[Tree]:
    """Terms of a sum."""
    if tree.operation in ("+", "-"):
        first, second = tree.parts
        yield from _terms(first)
        yield from _terms(second if tree.operation == "+" else Tree("negative", (second,)))
    elif tree.operation == "negative":
        yield from (Tree("negative", (each,)) for each in _terms(tree.parts[0]))
    else:
        yield tree


def _vanishes(tree: Tree, switches: Collection[str]) -> bool:
    names, terms = sorted(tree.names), [*_terms(tree)]
    flags = [name for name in names if name in switches][:FLAGS]
    for sign, ends in itertools.product((1, -1), itertools.product((0.0, 1.0), repeat=len(flags))):
        point = {name: sign * (1 + (i + 3) ** -0.5) for i, name in enumerate(names)}
        path: list[float] = []
        for _ in range(BRANCHES):
            values = _on_sides(terms, point | dict(zip(flags, ends, strict=True)), path)
            if abs(sum(values)) <= ROUNDED * sum(map(abs, values)):
                return True
            while path and path[-1] < 0:
                path.pop()
            if not path:
                break
            path[-1] = -1.0
    return False


def _on_sides(terms: Iterable[Tree], point: Mapping[str, float], path: list[float]) -> list[float]:
    """Values of terms at a point, each kink on the next side of a path, then on side 1; [1] if undefined."""
    known: dict[float, float] = {}

    def side(value: float) -> float:
        if abs(value) not in known:
            path.extend([1.0] * (len(path) == len(known)))
            known[abs(value)] = path[len(known)]
        return known[abs(value)] if value >= 0 else -known[abs(value)]

    def larger(a: float, b: float) -> float:
        return a if side(a - b) > 0 else b

    own = _NUMBERS | {"abs": lambda x: side(x) * x, "sign": side, "max": lambda *each: reduce(larger, each)}
    own |= {"min": lambda *each: -reduce(larger, (-one for one in each))}
    try:
        return [term.made_of(point, own, float) for term in terms]
    except (ArithmeticError, ValueError):
        return [1.0]


def plainly_real(tree: Tree) -> bool:
    """Whether an expression has finite real values for certain, for most values of its names."""
    return _orders(tree) <= PLAIN


def _orders(tree: Tree) -> float:
    """Orders of magnitude that numbers can bring into an expression; infinite where it may be undefined."""
    if tree.operation == "number":
        return abs(math.log10(tree.value)) if tree.value else 0.0
    if tree.operation == "name":
        return 1.0 if tree.value in CONSTANTS else 0.0
    parts, last = sum(map(_orders, tree.parts)), tree.parts[-1]
    by_number = last.operation == "number" and last.value
    if tree.operation == "/" and not by_number and last.operation != "name":
        return math.inf
    if tree.operation in ("sqrt", "log", "tan") and last.operation != "name":
        return math.inf
    if tree.operation == "**":
        whole = last.operation == "number" and isinstance(last.value, int)
        return last.value * parts if whole else math.inf
    return parts if tree.names or tree.operation in _BINARY or tree.operation == "negative" else math.inf


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
    if tree.deeper_than(TALLEST):
        raise refuse(text, f"at most {TALLEST} operations one upon the other are accepted")
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
        if math.isfinite(value):
            return float(value)
    except (ArithmeticError, ValueError) as error:
        if isinstance(error, InputError):
            raise
    raise refuse(text, "an expression with a finite value is accepted: with these numbers it has none")


class _Reader:
    """Reads a text token by token; `kind` and `token` are the current ones."""

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
        tree = part()
        while sign := self.took(*signs):
            tree = Tree(sign, (tree, part()))
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
