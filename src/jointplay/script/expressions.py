"""Expressions of the kernels' Python as JavaScript.

What is accepted: numbers, arithmetic, comparisons (in chains too), `and`, `or`, `not`, bit operations, calls
of named functions, entries and slices of arrays. An array of two dimensions is a list of rows in JavaScript,
so that both of x[i] and x[i, j] mean what they mean here; a slice is a view, as here. `and` and `or` give
truth values.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from keyword import kwlist
from string import ascii_letters
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from jointplay.numerics import lanes

ATOM, UNARY, PRODUCT, SUM, COMPARISON, BITS, AND, OR, CHOICE = 20, 15, 13, 12, 10, 8, 5, 4, 3
BINARY = {
    ast.Add: ("+", SUM),
    ast.Sub: ("-", SUM),
    ast.Mult: ("*", PRODUCT),
    ast.Div: ("/", PRODUCT),
    ast.BitAnd: ("&", BITS),
}
COMPARISONS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
PLAIN = ("sqrt", "sin", "cos", "tan", "tanh", "exp", "log", "atan2")
HELPERS = (
    *("matvec", "position_row", "add_matvec", "axpy", "sparse_dot", "subtract_products"),
    *("complex_multiply", "complex_fma", "complex_sum"),
)
CALLS = {getattr(math, name): f"Math.{name}" for name in PLAIN}  # functions by themselves
CALLS |= {getattr(lanes, name): f"runtime.{name}" for name in HELPERS}
CALLS |= {np.log: "Math.log", np.sqrt: "Math.sqrt", abs: "Math.abs", int: "Math.trunc"}
CALLS |= {math.copysign: "runtime.copysign"}
WORDS = {  # of the language; those of Python are more
    *kwlist,
    *("case", "catch", "const", "debugger", "default", "delete", "do", "enum", "eval", "export"),
    *("extends", "false", "function", "implements", "instanceof", "interface", "let", "new"),
    *("null", "package", "private", "protected", "public", "static", "super", "switch", "this"),
    *("throw", "true", "typeof", "var", "void", "arguments", "undefined", "NaN", "Infinity"),
    *("Math", "runtime"),
}


class UntranslatableError(Exception):
    """Something in a function that has no translation: where, and what."""


class Text(NamedTuple):
    """JavaScript of an expression, and how strongly it binds."""

    code: str
    binds: int = ATOM

    def within(self, least: int) -> str:
        """The code as an operand of what binds so strongly."""
        return self.code if self.binds >= least else f"({self.code})"


def safe(name: str) -> str:
    """A local name, which must be no word of the language."""
    return f"{name}_" if name in WORDS else name


def short(number: int) -> str:
    """The shortest local names, one after the other: a … Z, aa, …, with `_` behind words of the language."""
    name = ""
    while number >= 0:
        number, letter = divmod(number, len(ascii_letters))
        name, number = ascii_letters[letter] + name, number - 1
    return safe(name)


def literal(value: Any) -> str | None:
    """A number; None for anything else, and for what JavaScript cannot hold."""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | np.integer):
        return str(int(value)) if abs(value) <= 2**53 else None
    if isinstance(value, float | np.floating):
        special = {math.inf: "Infinity", -math.inf: "-Infinity"}
        return special.get(float(value), "NaN" if math.isnan(value) else repr(float(value)))
    return None


class Expressions:
    """Translation of the expressions of one function.

    Parameters
    ----------
    names : dict of str to str
        Names that the function binds, and what they are called here.
    scope : callable
        Value of a global name; raises KeyError.
    named : callable
        Name, in JavaScript, of a global function or array.
    where : callable
        File and line of a node, for messages.
    """

    def __init__(
        self,
        names: dict[str, str],
        scope: Callable[[str], Any],
        named: Callable[[Any], str | None],
        where: Callable[[ast.AST], str],
    ) -> None:
        self._locals, self._scope, self._named, self._where = names, scope, named, where

    def refuse(self, node: ast.AST, why: str = "") -> UntranslatableError:
        """Say what is not translated, and where."""
        what = why or f"{type(node).__name__} ({ast.unparse(node)})"
        return UntranslatableError(f"{self._where(node)}: {what} is not in the subset that is translated")

    def __call__(self, node: ast.expr) -> Text:
        """Translate an expression."""
        found = getattr(self, f"_{type(node).__name__.lower()}", None)
        if found is None:
            raise self.refuse(node)
        return found(node)

    def truth(self, node: ast.expr) -> Text:
        """Translate an expression whose truth matters: NaN is true here, as it is there not."""
        text = self(node)
        logical = ast.Compare | ast.BoolOp
        if isinstance(node, logical) or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)):
            return text
        return Text(f"{text.within(COMPARISON + 1)} != 0", COMPARISON)

    def value(self, node: ast.expr) -> Any:
        """Value of a name, or of names with dots, outside the function; KeyError if there is none."""
        if isinstance(node, ast.Name) and node.id not in self._locals:
            return self._scope(node.id)
        if isinstance(node, ast.Attribute) and isinstance(owner := self.value(node.value), ModuleType):
            return getattr(owner, node.attr)
        raise KeyError(ast.unparse(node))

    def _constant(self, node: ast.Constant) -> Text:
        if node.value is None:
            return Text("null")
        if (text := literal(node.value)) is None:
            raise self.refuse(node)
        return Text(text)

    def _name(self, node: ast.Name | ast.Attribute) -> Text:
        if isinstance(node, ast.Name) and node.id in self._locals:
            return Text(self._locals[node.id])
        try:
            value = self.value(node)
        except KeyError:
            raise self.refuse(node, f"the name {ast.unparse(node)}") from None
        text = literal(value) if np.ndim(value) == 0 else None
        text = text or self._named(value)
        if text is None:
            raise self.refuse(node)
        return Text(text, UNARY if text.startswith("-") else ATOM)

    def _attribute(self, node: ast.Attribute) -> Text:
        if isinstance(node.value, ast.Name) and node.value.id in self._locals:
            return Text(f"{self._locals[node.value.id]}.{node.attr}")
        return self._name(node)

    def _subscript(self, node: ast.Subscript) -> Text:
        array = self(node.value).within(ATOM)
        if isinstance(node.slice, ast.Slice):
            ends = [node.slice.lower or ast.Constant(0), node.slice.upper]
            if node.slice.step is not None:
                raise self.refuse(node)
            return Text(f"{array}.subarray({', '.join(self._place(e).code for e in ends if e is not None)})")
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return Text(array + "".join(f"[{self._place(place).code}]" for place in places))

    def _place(self, node: ast.expr) -> Text:
        if isinstance(node, ast.UnaryOp | ast.Slice | ast.Starred):
            raise self.refuse(node)
        return self(node)

    def _unaryop(self, node: ast.UnaryOp) -> Text:
        if isinstance(node.op, ast.Not):
            return Text(f"!{self.truth(node.operand).within(UNARY + 1)}", UNARY)
        if isinstance(node.op, ast.UAdd):
            return self(node.operand)
        if isinstance(node.op, ast.USub):
            return Text(f"-{self(node.operand).within(UNARY + 1)}", UNARY)
        raise self.refuse(node)

    def _binop(self, node: ast.BinOp) -> Text:
        left, right = self(node.left), self(node.right)
        if isinstance(node.op, ast.Pow):
            twice = isinstance(node.right, ast.Constant) and node.right.value == 2
            called = f"runtime.square({left.code})" if twice else f"Math.pow({left.code}, {right.code})"
            return Text(called)
        if isinstance(node.op, ast.FloorDiv | ast.Mod):
            name = "quotient" if isinstance(node.op, ast.FloorDiv) else "remainder"
            return Text(f"runtime.{name}({left.code}, {right.code})")
        if type(node.op) not in BINARY:
            raise self.refuse(node)
        sign, binds = BINARY[type(node.op)]
        return Text(f"{left.within(binds)} {sign} {right.within(binds + 1)}", binds)

    def _compare(self, node: ast.Compare) -> Text:
        operands, parts = [node.left, *node.comparators], []
        if any(isinstance(each, ast.Call) for middle in operands[1:-1] for each in ast.walk(middle)):
            raise self.refuse(node)  # it would be called twice
        for left, op, right in zip(operands, node.ops, operands[1:], strict=False):
            parts.append(self._pair(node, left, op, right))
        return parts[0] if len(parts) == 1 else Text(" && ".join(p.within(AND) for p in parts), AND)

    def _pair(self, node: ast.Compare, left: ast.expr, op: ast.cmpop, right: ast.expr) -> Text:
        here = self(left).within(COMPARISON + 1)
        if isinstance(op, ast.In) and isinstance(right, ast.Tuple) and isinstance(left, ast.Name):
            equal = (f"{here} == {self(each).within(COMPARISON + 1)}" for each in right.elts)
            return Text(" || ".join(equal), OR)
        none = isinstance(right, ast.Constant) and right.value is None
        if isinstance(op, ast.Is | ast.IsNot) and none:
            return Text(f"{here} {'===' if isinstance(op, ast.Is) else '!=='} null", COMPARISON)
        if type(op) not in COMPARISONS:
            raise self.refuse(node)
        return Text(f"{here} {COMPARISONS[type(op)]} {self(right).within(COMPARISON + 1)}", COMPARISON)

    def _boolop(self, node: ast.BoolOp) -> Text:
        sign, binds = ("&&", AND) if isinstance(node.op, ast.And) else ("||", OR)
        return Text(f" {sign} ".join(self.truth(each).within(binds + 1) for each in node.values), binds)

    def _ifexp(self, node: ast.IfExp) -> Text:
        test, then, other = self.truth(node.test), self(node.body), self(node.orelse)
        return Text(f"{test.within(CHOICE + 1)} ? {then.within(CHOICE + 1)} : {other.within(CHOICE)}", CHOICE)

    def _call(self, node: ast.Call) -> Text:
        if node.keywords or any(isinstance(each, ast.Starred) for each in node.args):
            raise self.refuse(node)
        if isinstance(node.func, ast.Name) and node.func.id in ("min", "max", "len", "float"):
            return self._built_in(node)
        return Text(f"{self._called(node)}({', '.join(self(each).code for each in node.args)})")

    def _built_in(self, node: ast.Call) -> Text:
        name, first = node.func.id, node.args[0]
        if name == "float" and isinstance(first, ast.Constant) and isinstance(first.value, str):
            return Text(literal(float(first.value)) or "NaN", UNARY)
        text = self(first)
        if name == "float":
            return text
        if name == "len":
            return Text(f"{text.within(ATOM)}.length")
        for other in node.args[1:]:
            text = Text(f"runtime.{name}({text.code}, {self(other).code})")
        return text

    def _called(self, node: ast.Call) -> str:
        """Name of the function that is called."""
        owner = node.func.value if isinstance(node.func, ast.Attribute) else node.func
        if isinstance(owner, ast.Name) and owner.id in self._locals:  # handed over
            return self(node.func).code
        try:
            function = self.value(node.func)
        except KeyError:
            raise self.refuse(node, f"the function {ast.unparse(node.func)}") from None
        name = CALLS.get(function) if callable(function) else None
        if (name := name or self._named(function)) is None:
            raise self.refuse(node, f"the function {ast.unparse(node.func)}")
        return name
