"""From Python to JavaScript: the functions that kernels are written in, and all that they call.

The language is that of codegen.reader and more of what numba compiles: tuples that a function returns, loops
over arrays, `break` and `continue`, named tuples as arguments, functions handed over, arrays of two
dimensions. These are lists of rows in JavaScript, so that both of x[i] and x[i, j] mean what they mean here;
a slice is a view, as here. `and` and `or` give truth values. What comes out runs on Float64Array and
Int32Array, beside helpers in runtime.js.

A function is named MODULE$NAME, so that no local name can hide it. Names of constants become their values,
arrays stand once under their own names. What is generated is long, and its local names are shortened.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from keyword import kwlist
from string import ascii_letters
from typing import Any, NamedTuple

import numpy as np

from jointplay.solver.codegen.reader import ARITHMETIC, ORDER, Reader, Text
from jointplay.solver.method.lanes import lanes

HELPERS = (
    *("matvec", "position_row", "add_matvec", "axpy", "sparse_dot", "subtract_products"),
    *("complex_multiply", "complex_fma", "complex_sum"),
)
CALLS = {getattr(lanes, name): f"runtime.{name}" for name in HELPERS} | {int: "Math.trunc", float: ""}
WORDS = {  # of the language; those of Python are more
    *kwlist,
    *("case", "catch", "const", "debugger", "default", "delete", "do", "enum", "eval", "export"),
    *("extends", "false", "function", "implements", "instanceof", "interface", "let", "new"),
    *("null", "package", "private", "protected", "public", "static", "super", "switch", "this"),
    *("throw", "true", "typeof", "var", "void", "arguments", "undefined", "NaN", "Infinity"),
    *("Math", "runtime"),
}
BY_CALL = {ast.Pow: "Math.pow", ast.FloorDiv: "runtime.quotient", ast.Mod: "runtime.remainder"}
IDENTITY = {ast.Is: "===", ast.IsNot: "!=="}  # with None
WEAK, CALL, WHOLE = -1, 3, 4  # how strongly an expression binds, beside signs (codegen.reader.ARITHMETIC)


class Code(NamedTuple):
    """An expression: its text, its binding strength as a side of an operation, whether it is a truth."""

    text: str
    binds: int = WHOLE
    logical: bool = False

    def side(self, least: int = WHOLE) -> str:
        """Text as part of an operation: in parentheses unless it binds so strongly."""
        return self.text if self.binds >= least else f"({self.text})"

    @property
    def truth(self) -> str:
        """Text of it as a truth value: NaN is true here, as it is there not."""
        return self.text if self.logical else f"{self.side()} != 0"


class Script:
    """JavaScript of functions and of all that they call, gathered as they are needed."""

    def __init__(self) -> None:
        self._done: dict[str, str] = {}
        self._arrays: dict[int, tuple[str, np.ndarray]] = {}

    @property
    def text(self) -> str:
        """All that was translated so far."""
        arrays = [f"const {name} = {_array(values)};" for name, values in self._arrays.values()]
        return "\n".join([*arrays, *self._done.values()]) + "\n"

    def function(self, text: Text, name: str) -> str:
        """Translate a function, once; its name.

        Raises
        ------
        RefusedError
            Naming the line and what stands there.
        """
        full = f"{text.name}${name}"
        if full not in self._done:
            self._done[full] = ""  # it may call itself
            self._done[full] = Function(self, text, text.functions[name]).written
        return full

    def array(self, text: Text, value: np.ndarray) -> str:
        """Name of a global array."""
        if id(value) not in self._arrays:
            (name,) = [name for name, other in text.scope.items() if other is value][:1]
            self._arrays[id(value)] = f"{name}${len(self._arrays)}", value
        return self._arrays[id(value)][0]


def _array(values: np.ndarray) -> str:
    kind = "Int32Array" if values.dtype.kind == "i" else "Float64Array"
    return f"new {kind}([{', '.join(_literal(v) or 'NaN' for v in values.ravel())}])"


class Function(Reader):
    """Translation of one function."""

    def __init__(self, script: Script, text: Text, node: ast.FunctionDef) -> None:
        super().__init__(text, node)
        self._script, self._temporaries, self._lines, self._depth = script, 0, [], 0
        called = [short(i) if text.generated else _safe(name) for i, name in enumerate(self.bound)]
        self._called = dict(zip(self.bound, called, strict=True))
        self.names = {name: Code(each) for name, each in self._called.items() if name not in self.loops}
        own = [code.text for name, code in self.names.items() if name not in self.given]
        given = ", ".join(self.names[name].text for name in self.given)
        with self._braces(f"function {text.name}${node.name}({given})"):
            if own:
                self._emit(f"let {', '.join(own)};")
            self.suite(node.body)

    @property
    def written(self) -> str:
        """The function in JavaScript."""
        return "\n".join(map(_dense, self._lines) if self.text.generated else self._lines)

    def _emit(self, line: str) -> None:
        self._lines.append("  " * self._depth + line)

    @contextmanager
    def _braces(self, head: str, end: str = "}") -> Iterator[None]:
        self._emit(f"{head} {{")
        self._depth += 1
        yield
        self._depth -= 1
        if end:
            self._emit(end)

    def _temporary(self) -> str:
        self._temporaries += 1
        return f"t${self._temporaries}"

    # Statements

    def _done(self, found: Code) -> None:
        self._emit(f"{found.text};")

    def _Break(self, node: ast.Break) -> None:
        self._emit("break;")

    def _Continue(self, node: ast.Continue) -> None:
        self._emit("continue;")

    def _Return(self, node: ast.Return) -> None:
        if isinstance(node.value, ast.Tuple):
            self._emit(f"return [{', '.join(self.value(each).text for each in node.value.elts)}];")
        else:
            self._emit(f"return {self.value(node.value).text};" if node.value else "return;")

    def _If(self, node: ast.If, head: str = "if") -> None:
        with self._braces(f"{head} ({self.value(node.test).truth})", end=""):
            self.suite(node.body)
        match node.orelse:
            case [ast.If() as other]:
                self._If(other, "} else if")
            case [_, *_]:
                with self._braces("} else"):
                    self.suite(node.orelse)
            case _:
                self._emit("}")

    def _While(self, node: ast.While) -> None:
        with self._braces(f"while ({self.value(node.test).truth})"):
            self.suite(node.body)

    def _counted(self, node: ast.For, first: Code, last: Code, step: int) -> None:
        name, end = self._running(node), self._temporary()
        change, sign = ("+=", "<") if step > 0 else ("-=", ">")
        start = f"let {name} = {first.text}, {end} = {last.text}"
        with self._braces(f"for ({start}; {name} {sign} {end}; {name} {change} {abs(step)})"):
            self.suite(node.body)

    def _over(self, node: ast.For) -> None:
        if not isinstance(node.iter, ast.Name | ast.Attribute):
            raise self.refuse()
        array, name, at = self.value(node.iter).text, self._running(node), self._temporary()
        with self._braces(f"for (let {at} = 0; {at} < {array}.length; {at} += 1)"):
            self._emit(f"const {name} = {array}[{at}];")
            self.suite(node.body)

    def _running(self, node: ast.For) -> str:
        """The name of a loop's variable, which is one of the loop alone."""
        name = self._called.get(node.target.id) or self._temporary()
        self.names[node.target.id] = Code(name)
        return name

    def _kept(self, value: Code) -> Code:
        name = self._temporary()
        self._emit(f"const {name} = {value.text};")
        return Code(name)

    def _several(self, node: ast.expr, count: int) -> list[Code]:
        if not isinstance(node, ast.Call):
            return super()._several(node, count)
        found = self._kept(self.value(node)).text
        return [Code(f"{found}[{i}]") for i in range(count)]

    def _store(self, targets: list[ast.expr], value: Code) -> None:
        named = " = ".join(self.value(each).text for each in targets)
        self._emit(f"{named} = {value.text};")

    def _AugAssign(self, node: ast.AugAssign) -> None:
        if type(node.op) in ARITHMETIC:
            sign, value = ARITHMETIC[type(node.op)][2], self.value(node.value).text
            self._emit(f"{self.value(self.target(node.target)).text} {sign}= {value};")
        elif any(isinstance(each, ast.Call) for each in ast.walk(node.target)):
            raise self.refuse()  # it would be called twice
        else:
            super()._AugAssign(node)

    # Expressions

    def _number(self, found: Any) -> Code:
        if (text := "null" if found is None else _literal(found)) is None:
            raise self.refuse()
        return Code(text)

    def _outer(self, found: Any) -> Code:
        if isinstance(found, np.ndarray):
            return Code(self._script.array(self.text, found))
        if text := _literal(found):
            return Code(f"({text})" if text.startswith("-") else text)
        if (defined := self.text.defined(found)) is None:
            raise self.refuse()
        text, function = defined
        return Code(self._script.function(text, function.name))

    def _Attribute(self, node: ast.Attribute) -> Code:
        if isinstance(node.value, ast.Name) and node.value.id in self.names:
            return Code(f"{self.names[node.value.id].text}.{node.attr}")
        return super()._Attribute(node)

    def _item(self, node: ast.Subscript) -> Code:
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return Code(self.value(node.value).side() + "".join(f"[{self.place(each).text}]" for each in places))

    def _part(self, array: Code, first: Code, end: Code | None) -> Code:
        return _call(f"{array.side()}.subarray", *(each for each in (first, end) if each))

    def _length(self, array: Code) -> Code:
        return Code(f"{array.side()}.length")

    def _negated(self, value: Code) -> Code:
        return Code(f"-{value.side()}", WEAK)

    def _denied(self, value: Code) -> Code:
        return Code(f"!({value.truth})", WEAK, logical=True)

    def _power(self, base: Code, exponent: int) -> Code:
        if exponent == 2:
            return _call("runtime.square", base, binds=CALL)
        return self._binary(ast.Pow, base, self._number(exponent))

    def _binary(self, op: type[ast.operator], left: Code, right: Code) -> Code:
        if op in BY_CALL:
            return _call(BY_CALL[op], left, right, binds=CALL)
        if op not in ARITHMETIC:
            raise self.refuse()
        _, _, sign, binds = ARITHMETIC[op]
        return Code(f"{left.side(binds)} {sign} {right.side(binds + 1)}", binds)

    def _Compare(self, node: ast.Compare) -> Code:
        (op, *_), (right, *_) = node.ops, node.comparators
        if isinstance(op, ast.In) and isinstance(right, ast.Tuple) and isinstance(node.left, ast.Name):
            left = self.value(node.left)
            same = (f"{left.text} == {self.value(each).side()}" for each in right.elts)
            return Code(" || ".join(same), WEAK, logical=True)
        if any(isinstance(each, ast.Call) for middle in node.comparators[:-1] for each in ast.walk(middle)):
            raise self.refuse()  # it would be called twice
        return super()._Compare(node)

    def _compared(self, op: type[ast.cmpop], left: Code, right: Code) -> Code:
        if op not in ORDER and not (op in IDENTITY and right.text == "null"):
            raise self.refuse()
        sign = IDENTITY[op] if op in IDENTITY else ORDER[op][1]
        return Code(f"{left.side()} {sign} {right.side()}", WEAK, logical=True)

    def _joined(self, op: type[ast.boolop], values: list[Code]) -> Code:
        if len(values) == 1:
            return values[0]
        sign = " && " if op is ast.And else " || "
        return Code(sign.join(f"({each.truth})" for each in values), WEAK, logical=True)

    def _IfExp(self, node: ast.IfExp) -> Code:
        test, yes, no = (self.value(each) for each in (node.test, node.body, node.orelse))
        return Code(f"{test.truth} ? {yes.side()} : {no.side()}", WEAK)

    # Calls

    def _Call(self, node: ast.Call) -> Code:
        match node:
            case ast.Call(ast.Name("float"), [ast.Constant(str(word))]):
                return self._outer(float(word))
        return super()._Call(node)

    def callee(self, node: ast.expr) -> Any:
        """The function that is called; of one that is handed over its name."""
        owner = node.value if isinstance(node, ast.Attribute) else node
        handed = isinstance(owner, ast.Name) and owner.id in self.names
        return self.value(node) if handed else super().callee(node)

    def called(self, function: Any, values: list[Code]) -> Code:
        """Result of a call; a named tuple becomes an object."""
        if isinstance(function, Code):
            return _call(function.text, *values)
        if callable(function) and function in CALLS:
            return _call(CALLS[function], *values)
        if isinstance(function, type) and len(fields := getattr(function, "_fields", ())) == len(values) > 0:
            pairs = (f"{name}: {each.text}" for name, each in zip(fields, values, strict=True))
            return Code(f"{{ {', '.join(pairs)} }}")
        return super().called(function, values)

    def _applied(self, names: tuple[str, ...], values: list[Code]) -> Code:
        return _call(names[-1], *values)

    def _extreme(self, order: type[ast.cmpop], found: Code, other: Code) -> Code:
        return _call("runtime.min" if order is ast.Lt else "runtime.max", found, other)

    def _own(self, text: Text, function: ast.FunctionDef, values: list[Code]) -> Code:
        return _call(self._script.function(text, function.name), *values)


def _call(name: str, *values: Code, binds: int = WHOLE) -> Code:
    return Code(f"{name}({', '.join(each.text for each in values)})", binds)


def _dense(line: str) -> str:
    """A line without spaces that only readers need."""
    return re.sub(r" (\*|/|=) ", r"\1", line.strip())


def _safe(name: str) -> str:
    """A local name, which must be no word of the language."""
    return f"{name}_" if name in WORDS else name


def short(number: int) -> str:
    """The shortest local names, one after the other: a … Z, aa, …, with `_` behind words of the language."""
    name = ""
    while number >= 0:
        number, letter = divmod(number, len(ascii_letters))
        name, number = ascii_letters[letter] + name, number - 1
    return _safe(name)


def _literal(value: Any) -> str | None:
    """A number; None for anything else, and for numbers that JavaScript cannot hold."""
    value = value.item() if isinstance(value, np.generic) else value
    exact = isinstance(value, float | bool) or (isinstance(value, int) and abs(value) <= 2**53)
    return json.dumps(value) if exact else None
