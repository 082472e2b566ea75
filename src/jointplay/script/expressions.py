"""Expressions of the kernels' Python as JavaScript.

What is accepted: numbers, arithmetic, comparisons (in chains too), `and`, `or`, `not`, bit operations, calls
of named functions, entries and slices of arrays. An array of two dimensions is a list of rows in JavaScript,
so that both of x[i] and x[i, j] mean what they mean here; a slice is a view, as here. `and` and `or` give
truth values. Operands that are operations themselves stand in parentheses.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass
from keyword import kwlist
from string import ascii_letters
from types import ModuleType
from typing import Any

import numpy as np

from jointplay.numerics import lanes

OPERATIONS = ast.BinOp | ast.UnaryOp | ast.Compare | ast.BoolOp | ast.IfExp
BINARY = {ast.BitAnd: ("&", 0), ast.Add: ("+", 1), ast.Sub: ("-", 1), ast.Mult: ("*", 2), ast.Div: ("/", 2)}
CALLED = "", 3  # an operation that is a call here, which binds strongest
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


@dataclass(frozen=True)
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

    names: dict[str, str]
    scope: Callable[[str], Any]
    named: Callable[[Any], str | None]
    where: Callable[[ast.AST], str]

    def refuse(self, node: ast.AST, why: str = "") -> UntranslatableError:
        """Say what is not translated, and where."""
        what = why or f"{type(node).__name__} ({ast.unparse(node)})"
        return UntranslatableError(f"{self.where(node)}: {what} is not in the subset that is translated")

    def __call__(self, node: ast.expr) -> str:
        """Translate an expression."""
        found = getattr(self, f"_{type(node).__name__.lower()}", None)
        if found is None:
            raise self.refuse(node)
        return found(node)

    def operand(self, node: ast.expr) -> str:
        """Translate an expression that is part of an operation."""
        return f"({self(node)})" if isinstance(node, OPERATIONS) else self(node)

    def truth(self, node: ast.expr) -> str:
        """Translate an expression whose truth matters: NaN is true here, as it is there not."""
        logical = isinstance(node, ast.Compare | ast.BoolOp) or isinstance(getattr(node, "op", None), ast.Not)
        return self(node) if logical else f"{self.operand(node)} != 0"

    def value(self, node: ast.expr) -> Any:
        """Value of a name, or of names with dots, outside the function; KeyError if there is none."""
        if isinstance(node, ast.Name) and node.id not in self.names:
            return self.scope(node.id)
        if isinstance(node, ast.Attribute) and isinstance(owner := self.value(node.value), ModuleType):
            return getattr(owner, node.attr)
        raise KeyError(ast.unparse(node))

    def _constant(self, node: ast.Constant) -> str:
        text = "null" if node.value is None else literal(node.value)
        if text is None:
            raise self.refuse(node)
        return text

    def _name(self, node: ast.Name | ast.Attribute) -> str:
        if isinstance(node, ast.Name) and node.id in self.names:
            return self.names[node.id]
        try:
            value = self.value(node)
        except KeyError:
            raise self.refuse(node, f"the name {ast.unparse(node)}") from None
        text = (literal(value) if np.ndim(value) == 0 else None) or self.named(value)
        if text is None:
            raise self.refuse(node)
        return f"({text})" if text.startswith("-") else text

    def _attribute(self, node: ast.Attribute) -> str:
        if isinstance(node.value, ast.Name) and node.value.id in self.names:
            return f"{self.names[node.value.id]}.{node.attr}"
        return self._name(node)

    def _subscript(self, node: ast.Subscript) -> str:
        array = self.operand(node.value)
        if isinstance(node.slice, ast.Slice):
            ends = [node.slice.lower or ast.Constant(0), node.slice.upper]
            if node.slice.step is not None:
                raise self.refuse(node)
            return f"{array}.subarray({', '.join(self._place(e) for e in ends if e is not None)})"
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return array + "".join(f"[{self._place(place)}]" for place in places)

    def _place(self, node: ast.expr) -> str:
        if isinstance(node, ast.UnaryOp | ast.Slice | ast.Starred):
            raise self.refuse(node)
        return self(node)

    def _unaryop(self, node: ast.UnaryOp) -> str:
        if isinstance(node.op, ast.Not):
            return f"!({self.truth(node.operand)})"
        if isinstance(node.op, ast.UAdd):
            return self(node.operand)
        if isinstance(node.op, ast.USub):
            return f"-{self.operand(node.operand)}"
        raise self.refuse(node)

    def _binop(self, node: ast.BinOp) -> str:
        if isinstance(node.op, ast.Pow):
            if isinstance(node.right, ast.Constant) and node.right.value == 2:
                return f"runtime.square({self(node.left)})"
            return f"Math.pow({self(node.left)}, {self(node.right)})"
        if isinstance(node.op, ast.FloorDiv | ast.Mod):
            name = "quotient" if isinstance(node.op, ast.FloorDiv) else "remainder"
            return f"runtime.{name}({self(node.left)}, {self(node.right)})"
        if type(node.op) not in BINARY:
            raise self.refuse(node)
        sign, binds = BINARY[type(node.op)]
        return f"{self._side(node.left, binds)} {sign} {self._side(node.right, binds + 1)}"

    def _side(self, node: ast.expr, least: int) -> str:
        """One side of an operation, without parentheses where it binds at least so strongly."""
        strong = isinstance(node, ast.BinOp) and BINARY.get(type(node.op), CALLED)[1] >= least
        return self(node) if strong else self.operand(node)

    def _compare(self, node: ast.Compare) -> str:
        operands, parts = [node.left, *node.comparators], []
        if any(isinstance(each, ast.Call) for middle in operands[1:-1] for each in ast.walk(middle)):
            raise self.refuse(node)  # it would be called twice
        for left, op, right in zip(operands, node.ops, operands[1:], strict=False):
            parts.append(self._pair(node, left, op, right))
        return parts[0] if len(parts) == 1 else " && ".join(f"({part})" for part in parts)

    def _pair(self, node: ast.Compare, left: ast.expr, op: ast.cmpop, right: ast.expr) -> str:
        here = self.operand(left)
        if isinstance(op, ast.In) and isinstance(right, ast.Tuple) and isinstance(left, ast.Name):
            return " || ".join(f"{here} == {self.operand(each)}" for each in right.elts)
        none = isinstance(right, ast.Constant) and right.value is None
        if isinstance(op, ast.Is | ast.IsNot) and none:
            return f"{here} {'===' if isinstance(op, ast.Is) else '!=='} null"
        if type(op) not in COMPARISONS:
            raise self.refuse(node)
        return f"{here} {COMPARISONS[type(op)]} {self.operand(right)}"

    def _boolop(self, node: ast.BoolOp) -> str:
        sign = " && " if isinstance(node.op, ast.And) else " || "
        return sign.join(f"({self.truth(each)})" for each in node.values)

    def _ifexp(self, node: ast.IfExp) -> str:
        return f"{self.truth(node.test)} ? {self.operand(node.body)} : {self.operand(node.orelse)}"

    def _call(self, node: ast.Call) -> str:
        if node.keywords or any(isinstance(each, ast.Starred) for each in node.args):
            raise self.refuse(node)
        if isinstance(node.func, ast.Name) and node.func.id in ("min", "max", "len", "float"):
            return self._built_in(node)
        if fields := self._fields_of(node.func):  # a named tuple
            pairs = (f"{name}: {self(each)}" for name, each in zip(fields, node.args, strict=True))
            return f"{{ {', '.join(pairs)} }}"
        return f"{self._called(node)}({', '.join(map(self, node.args))})"

    def _fields_of(self, node: ast.expr) -> tuple[str, ...]:
        """Fields of the kind of named tuple that is made here; none of any other function."""
        try:
            kind = self.value(node)
        except KeyError:
            return ()
        return kind._fields if isinstance(kind, type) and issubclass(kind, tuple) else ()

    def _built_in(self, node: ast.Call) -> str:
        name, first = node.func.id, node.args[0]
        if name == "float" and isinstance(first, ast.Constant) and isinstance(first.value, str):
            return f"({literal(float(first.value))})"
        if name == "float":
            return f"({self(first)})"
        if name == "len":
            return f"{self.operand(first)}.length"
        text = self(first)
        for other in node.args[1:]:
            text = f"runtime.{name}({text}, {self(other)})"
        return text

    def _called(self, node: ast.Call) -> str:
        """Name of the function that is called."""
        owner = node.func.value if isinstance(node.func, ast.Attribute) else node.func
        if isinstance(owner, ast.Name) and owner.id in self.names:  # handed over
            return self(node.func)
        try:
            function = self.value(node.func)
        except KeyError:
            raise self.refuse(node, f"the function {ast.unparse(node.func)}") from None
        name = CALLS.get(function) if callable(function) else None
        if (name := name or self.named(function)) is None:
            raise self.refuse(node, f"the function {ast.unparse(node.func)}")
        return name
