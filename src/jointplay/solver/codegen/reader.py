"""Reader of the small Python that generated texts, and the method's loops, are written in.

    numbers      floats and integers; arithmetic, comparisons, `and`, `or`, `not`, x if c else y
    arrays       arguments and constants: a[i], a[i] = x, a[i] += x, a slice handed on, len(a)
    functions    those of `FUNCTIONS`, min, max; others of the text; those that it imports from the method
    choice       if, else, return; loops for … in range(…), while

A back end (codegen.instructions, jointplay_page.script.translate) is a subclass of `Reader`: it says what an
operation becomes, and declares what else it reads by a method of that name. What no method reads is refused
with its line, never guessed at; so is what back ends would disagree about.
"""

from __future__ import annotations

import ast
import builtins
import importlib
import math
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, reduce
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

ARITHMETIC = {  # LLVM's names for floats and for integers; JavaScript's sign, how strongly it binds there
    ast.BitAnd: ("", "", "&", 0),
    ast.Add: ("fadd", "add", "+", 1),
    ast.Sub: ("fsub", "sub", "-", 1),
    ast.Mult: ("fmul", "mul", "*", 2),
    ast.Div: ("fdiv", "", "/", 2),
}
ORDER = {  # LLVM's word, JavaScript's sign
    ast.Lt: ("lt", "<"),
    ast.LtE: ("le", "<="),
    ast.Gt: ("gt", ">"),
    ast.GtE: ("ge", ">="),
    ast.Eq: ("eq", "=="),
    ast.NotEq: ("ne", "!="),
}
FUNCTIONS = {  # LLVM's names for numbers and for rows, JavaScript's; "": none
    math.sqrt: ("llvm.sqrt.f64", "llvm.sqrt.v8f64", "Math.sqrt"),
    abs: ("llvm.fabs.f64", "llvm.fabs.v8f64", "Math.abs"),
    math.copysign: ("llvm.copysign.f64", "llvm.copysign.v8f64", "runtime.copysign"),
    math.sin: ("llvm.sin.f64", "", "Math.sin"),
    math.cos: ("llvm.cos.f64", "", "Math.cos"),
    math.exp: ("llvm.exp.f64", "", "Math.exp"),
    math.log: ("llvm.log.f64", "", "Math.log"),
    math.tanh: ("tanh", "", "Math.tanh"),  # of the system's mathematical library
    math.tan: ("", "", "Math.tan"),
    math.atan2: ("", "", "Math.atan2"),
}
FUNCTIONS |= {np.sqrt: FUNCTIONS[math.sqrt], np.log: FUNCTIONS[math.log], math.fabs: FUNCTIONS[abs]}


class RefusedError(NotImplementedError):
    """Code that a back end does not write: its place, and its text."""


@dataclass(frozen=True, eq=False)
class Text:
    """A module: its name, its functions by name, and values of the other names."""

    name: str
    functions: dict[str, ast.FunctionDef]
    scope: Mapping[str, Any]
    generated: bool = True

    @classmethod
    def of(cls, source: str, name: str = "text") -> Text:
        """A generated text: all but its functions is executed."""
        tree = ast.parse(source)
        rest = [each for each in tree.body if not isinstance(each, ast.FunctionDef)]
        scope: dict[str, Any] = {}
        exec(compile(ast.Module(rest, []), name, "exec"), scope)
        return cls(name, _functions(tree), scope)

    def value(self, name: str) -> Any:
        """Value of a global name, the definition of an own function; KeyError of others."""
        if name in self.functions:
            return self.functions[name]
        return self.scope[name] if name in self.scope else vars(builtins)[name]

    def defined(self, value: Any) -> tuple[Text, ast.FunctionDef] | None:
        """Text and definition of a function, here or in the method; None of one not written in Python."""
        if isinstance(value, ast.FunctionDef):
            return self, value
        value = getattr(value, "py_func", value)
        if not isinstance(value, FunctionType):
            return None
        text = imported(value.__module__)
        found = text.functions.get(value.__name__)
        return (text, found) if found else None


def _functions(tree: ast.Module) -> dict[str, ast.FunctionDef]:
    return {each.name: each for each in tree.body if isinstance(each, ast.FunctionDef)}


@lru_cache(maxsize=256)
def imported(module: str) -> Text:
    """A module of the method."""
    found = importlib.import_module(module)
    tree = ast.parse(found.__loader__.get_source(module))
    return Text(module.rpartition(".")[2], _functions(tree), vars(found), generated=False)


def decorators(node: ast.FunctionDef) -> set[str]:
    """Names of a function's decorators."""
    named = (each.func if isinstance(each, ast.Call) else each for each in node.decorator_list)
    return {each.id for each in named if isinstance(each, ast.Name)}


class Reader:
    """Reading of one function: a method for each kind of statement and expression, by its name in `ast`.

    Values are the back end's; all that is known of one here is its `text`. `names` are those that have a
    value. A back end has methods for _If, _IfExp, _While and _Return, and says what becomes of the rest:

        _number(x), _outer(x)                 a written number; a constant or array from outside
        _item(node), _part(array, first, end), _length(array)
        _negated(x), _denied(x), _power(x, n), _binary(op, x, y), _compared(op, x, y), _joined(op, values)
        _applied(names, values)               a function of `FUNCTIONS`
        _extreme(order, x, y)                 y where it is beyond x, else x
        _own(text, function, values)          a call of a function that is written in Python
        _store(targets, x)                    assignment of one value
        _counted(node, first, last, step)     a loop over a range
        _several(node, n), _kept(x)           values for several targets, found before any is set
        _done(x)                              a call for what it does
        _over(node)                           a loop over anything else
    """

    names: dict[str, Any]

    def __init__(self, text: Text, node: ast.FunctionDef) -> None:
        self.text, self.node, self.at = text, node, node
        given = node.args
        if given.vararg or given.kwarg or given.kwonlyargs or given.defaults:
            raise self.refuse("arguments that are not plain")
        every = [each for suite in suites(node) for each in suite]
        self.given = [each.arg for each in given.args]
        self.bound = [*dict.fromkeys([*self.given, *assigned(every)])]
        self.loops = assigned(each for each in every if isinstance(each, ast.For))
        for each in every:
            if isinstance(each, ast.For | ast.While):
                if each.orelse:
                    raise self.refuse("", each)
            elif names := self.loops.keys() & assigned([each]).keys():
                raise self.refuse(f"the loop's variable {min(names)} set here", each)

    def refuse(self, what: str = "", node: ast.AST | None = None) -> RefusedError:
        """The error that names unreadable code and its place; without words the code being read is shown."""
        node = node or self.at
        what = what or f"{type(node).__name__} ({ast.unparse(node)[:200]})"
        where = f"{self.text.name}.py:{getattr(node, 'lineno', self.node.lineno)} in {self.node.name}"
        return RefusedError(f"{where}: {what} is not in the language that is read here")

    def read(self, node: ast.AST) -> Any:
        """Read a statement or an expression."""
        before, self.at = self.at, node
        method = getattr(self, f"_{type(node).__name__}", None)
        if method is None:
            raise self.refuse()
        found = method(node)
        self.at = before
        return found

    def value(self, node: ast.expr) -> Any:
        """Value of an expression."""
        if (found := self.read(node)) is None:
            raise self.refuse("a call without a value", node)
        return found

    # Statements

    def suite(self, statements: list[ast.stmt]) -> None:
        """Statements, one after the other."""
        for each in statements:
            self.read(each)

    def _Pass(self, node: ast.Pass) -> None:
        pass

    def _Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            self._done(self.read(node.value))
        elif not (isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)):
            raise self.refuse()

    def _Assign(self, node: ast.Assign) -> None:
        first, *more = node.targets
        if more or not isinstance(first, ast.Tuple):
            self.store(node.targets, self.value(node.value))
            return
        for target, value in zip(first.elts, self._several(node.value, len(first.elts)), strict=True):
            if not (isinstance(target, ast.Name) and target.id == "_"):
                self.store([target], value)

    def store(self, targets: list[ast.expr], value: Any) -> None:
        """Assignment of one value to names, and to places of arrays."""
        self._store([self.target(each) for each in targets], value)

    def target(self, node: ast.expr) -> ast.expr:
        """Target of an assignment: a name, or a place of an array."""
        whole = isinstance(node, ast.Subscript) and not isinstance(node.slice, ast.Slice)
        if not whole and not isinstance(node, ast.Name):
            raise self.refuse("", node)
        return node

    def _several(self, node: ast.expr, count: int) -> list[Any]:
        if not isinstance(node, ast.Tuple) or len(node.elts) != count:
            raise self.refuse()
        return [self._kept(self.value(each)) for each in node.elts]

    def _AugAssign(self, node: ast.AugAssign) -> None:
        self.store([node.target], self.operated(node.op, self.value(node.target), node.value))

    def _For(self, node: ast.For) -> None:
        if not isinstance(node.target, ast.Name) or node.target.id in self.names.keys() - {"_"}:
            raise self.refuse()
        match node.iter:
            case ast.Call(ast.Name("range"), [_, *_] as ends, []) if len(ends) < 4:
                self._ranged(node, [self.value(each) for each in ends])
            case _:
                self._over(node)
        self.names.pop(node.target.id, None)  # languages disagree about its value after the loop

    def _ranged(self, node: ast.For, values: list[Any]) -> None:
        step = values.pop().text if len(values) == 3 else "1"
        if not re.fullmatch(r"-?[1-9]\d*", step):
            raise self.refuse("a step that is no written number")
        first, last = values if len(values) == 2 else (self._number(0), *values)
        self._counted(node, first, last, int(step))

    def _over(self, node: ast.For) -> None:
        raise self.refuse()

    def _done(self, found: Any) -> None:
        pass

    def _kept(self, value: Any) -> Any:
        return value

    # Expressions

    def known(self, node: ast.expr) -> Any:
        """Value of a name, or of names with dots, from outside the function."""
        with suppress(KeyError, AttributeError, RefusedError):  # the last: of what stands before a dot
            if isinstance(node, ast.Name) and node.id not in self.bound:
                return self.text.value(node.id)
            if isinstance(node, ast.Attribute) and isinstance(owner := self.known(node.value), ModuleType):
                return getattr(owner, node.attr)
        raise self.refuse(f"the name {ast.unparse(node)}, which has no value here,", node)

    def _Constant(self, node: ast.Constant) -> Any:
        return self._number(node.value)

    def _Name(self, node: ast.Name) -> Any:
        return self.names[node.id] if node.id in self.names else self._outer(self.known(node))

    def _Attribute(self, node: ast.Attribute) -> Any:
        return self._outer(self.known(node))

    def _Subscript(self, node: ast.Subscript) -> Any:
        if not isinstance(node.slice, ast.Slice):
            return self._item(node)
        array, (lower, upper) = self.value(node.value), (node.slice.lower, node.slice.upper)
        if node.slice.step is not None:
            raise self.refuse()
        first = self.place(lower) if lower else self._number(0)
        return self._part(array, first, self.place(upper) if upper else None)

    def place(self, node: ast.expr) -> Any:
        """A place in an array; none is counted from its end."""
        if isinstance(node, ast.UnaryOp | ast.Slice | ast.Starred):
            raise self.refuse("", node)
        return self.value(node)

    def _UnaryOp(self, node: ast.UnaryOp) -> Any:
        value = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            return self._denied(value)
        if isinstance(node.op, ast.Invert):
            raise self.refuse()
        return self._negated(value) if isinstance(node.op, ast.USub) else value

    def _BinOp(self, node: ast.BinOp) -> Any:
        return self.operated(node.op, self.value(node.left), node.right)

    def operated(self, op: ast.operator, left: Any, right: ast.expr) -> Any:
        """An operation of two numbers."""
        exponent = right.value if isinstance(right, ast.Constant) else None
        if isinstance(op, ast.Pow) and isinstance(exponent, int):
            return self._power(left, exponent)
        return self._binary(type(op), left, self.value(right))

    def _Compare(self, node: ast.Compare) -> Any:
        values = [self.value(each) for each in (node.left, *node.comparators)]
        pairs = zip(node.ops, values, values[1:], strict=False)
        return self._joined(ast.And, [self._compared(type(op), left, right) for op, left, right in pairs])

    def _BoolOp(self, node: ast.BoolOp) -> Any:
        return self._joined(type(node.op), [self.value(each) for each in node.values])

    # Calls

    def _Call(self, node: ast.Call) -> Any:
        if node.keywords:
            raise self.refuse()
        return self.called(self.callee(node.func), [self.value(each) for each in node.args])

    def callee(self, node: ast.expr) -> Any:
        """The function that is called."""
        return self.known(node)

    def called(self, function: Any, values: list[Any]) -> Any:
        """Result of a call."""
        if function is len and len(values) == 1:
            return self._length(values[0])
        if (function is min or function is max) and values:
            order = ast.Lt if function is min else ast.Gt  # another value is taken only where it is beyond
            return reduce(lambda found, each: self._extreme(order, found, each), values)
        if callable(function) and function in FUNCTIONS:
            return self._applied(FUNCTIONS[function], values)
        if (found := self.text.defined(function)) is not None:
            return self._own(*found, values)
        raise self.refuse()


def suites(node: ast.FunctionDef) -> list[list[ast.stmt]]:
    """The suites of a function: its own, and the suites of the statements in it."""
    found = [node.body]
    for suite in found:  # which grows meanwhile
        parts = (getattr(each, part, None) for each in suite for part in ("body", "orelse"))
        found += [part for part in parts if part]
    return found


def assigned(statements: Iterable[ast.stmt]) -> dict[str, None]:
    """Names that statements assign themselves, in order."""
    found = [getattr(each, "targets", None) or [getattr(each, "target", None)] for each in statements]
    parts = (part for targets in found for each in targets for part in getattr(each, "elts", [each]))
    return {each.id: None for each in parts if isinstance(each, ast.Name) and each.id != "_"}
