"""Generated source as instructions of LLVM: a module's text in, its intermediate representation out.

The generated texts (codegen.module, algebra, variation, ensemble) are plain Python and run as such where
nothing is compiled. They keep to a small language, so that no compiler of Python is needed:

    numbers      floats and integers; arithmetic, comparisons, `and`, `or`, x if c else y
    arrays       arguments and constants: a[i], a[i] = x, a[i] += x, a slice handed on, len(a)
    functions    of `math`, min, max, abs; others of the text; those of the method that it imports by name
    choice       if, else, return; loops for … in range(…), while

A function of one lane that is marked `lanewise`, straight lines that read and write w[… + i], becomes
operations on rows of eight numbers. Within rows `x if c else y` chooses lane by lane, with both values
computed, and functions without a vector form are called for one lane after the other. A loop over the lanes,
`for i in range(8)`, is one, which LLVM turns into the same instructions.

Anything else is refused by name. Of the licences of fast arithmetic those are given that numerics.interface
gives: contraction to fused multiply-add, reciprocals, signed zero.

Functions that others call by address are in the binary interface of the method's function pointers: an array
is a struct of seven words by value (two unused, length, size of an item, address, shape, stride). Arrays that
are handed to one call do not overlap.
"""

from __future__ import annotations

import ast
import math
import struct
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

FAST = "contract arcp nsz"  # licences of arithmetic
ARRAY = "{ptr, ptr, i64, i64, ptr, [1 x i64], [1 x i64]}"
INTEGERS = {"variant", "k", "j", "guard"}  # arguments that are no arrays
NUMBERS = {"h", "start", "ratio"}
TYPES = {"f": "double", "i": "i64", "b": "i1"}
ITEMS = {"f": "double", "i": "i64"}
ORDER = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}
FLOATING = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
WHOLE = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
OF_ROWS = ("sqrt", "fabs", "copysign")  # functions that LLVM has for rows too
INTRINSIC = (*OF_ROWS, "sin", "cos", "exp", "log")
LIBRARY = ("tanh",)  # of the system's mathematical library
DECORATORS = ("compiled", "inner", "inlined", "spliced", "lanewise")
ROW = 8  # lanes of a function that is marked `lanewise`


class RefusedError(NotImplementedError):
    """Something that generated text may not contain; the message shows it."""


class Value(NamedTuple):
    """An operand: its kind (f: float, i: integer, b: truth), and over how many lanes (0: one number)."""

    kind: str
    text: str
    width: int = 0

    @property
    def type(self) -> str:
        """The type, as LLVM writes it."""
        plain = TYPES[self.kind]
        return f"<{self.width} x {plain}>" if self.width else plain


class Array(NamedTuple):
    """An array: the kind of its items, a pointer, its length."""

    kind: str
    pointer: str
    length: str


@dataclass
class Text:
    """A module's text: its functions by name, and values of the names beside them."""

    functions: dict[str, ast.FunctionDef]
    scope: dict[str, Any]

    @classmethod
    def of(cls, source: str) -> Text:
        """A generated text: all but its functions and decorators is executed."""
        tree = ast.parse(source)
        functions = {each.name: each for each in tree.body if isinstance(each, ast.FunctionDef)}
        rest = [each for each in tree.body if not isinstance(each, ast.FunctionDef)]
        scope: dict[str, Any] = {}
        plain = ast.fix_missing_locations(ast.Module([_undecorated(each) for each in rest], []))
        exec(compile(plain, "generated", "exec"), scope)
        return cls(functions, scope)

    def named(self, name: str) -> tuple[Text, ast.FunctionDef] | None:
        """A function by name, here or in the module of the method from which it was imported."""
        if name in self.functions:
            return self, self.functions[name]
        value = getattr(self.scope.get(name), "py_func", self.scope.get(name))
        return _imported(value.__module__).named(value.__name__) if hasattr(value, "__code__") else None


def _undecorated(node: ast.stmt) -> ast.stmt:
    """An import without what marks functions to be compiled."""
    if isinstance(node, ast.ImportFrom):
        kept = [alias for alias in node.names if alias.name not in DECORATORS]
        return ast.ImportFrom(node.module, kept, node.level) if kept else ast.Pass()
    return node


_read: dict[str, Text] = {}


def _imported(module: str) -> Text:
    if module not in _read:
        found = sys.modules[module]
        tree = ast.parse(found.__loader__.get_source(module))
        functions = {each.name: each for each in tree.body if isinstance(each, ast.FunctionDef)}
        _read[module] = Text(functions, vars(found))
    return _read[module]


class Written(NamedTuple):
    """Instructions of a text.

    Parameters
    ----------
    instructions : str
        As LLVM reads them.
    entries : dict of str to str
        Functions that others may call by address; of each the kind of what it returns, and of each argument,
        as a letter (v: nothing, f, i: numbers, b: truth, a: array of floats).
    outside : list of str
        Functions of the method that are called by these names.
    """

    instructions: str
    entries: dict[str, str]
    outside: list[str]


def written(source: str, licences: str = FAST) -> Written:
    """Instructions of a module's text, its arithmetic with the licences of numerics.interface, or others.

    Raises
    ------
    RefusedError
        When the text leaves the language above.
    """
    return Module(Text.of(source), licences).finished()


class Module:
    """The instructions of one text, function by function as they are asked for."""

    def __init__(self, text: Text, licences: str) -> None:
        self.text, self.licences = text, licences
        self.parts: list[str] = []
        self.declared: dict[str, str] = {}
        self.outside: dict[str, None] = {}  # functions of the method that are called by name, in order
        self.made: dict[tuple, tuple[str, str]] = {}

    def finished(self) -> Written:
        """All of it."""
        called = {
            node.func.id
            for function in self.text.functions.values()
            for node in ast.walk(function)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        entries = {n: self._entry(f) for n, f in self.text.functions.items() if n not in called}
        return Written("\n".join([*self.declared.values(), *self.parts]), entries, [*self.outside])

    def constant(self, numbers: np.ndarray) -> Array:
        """A constant array."""
        kind = "i" if numbers.dtype.kind == "i" else "f"
        flat = numbers.ravel()
        content = ", ".join(f"{ITEMS[kind]} {_literal(kind, x)}" for x in flat)
        key = f"@constant.{kind}.{abs(hash(flat.tobytes())):x}.{len(flat)}"
        self.declared[key] = (
            f"{key} = private unnamed_addr constant [{len(flat)} x {ITEMS[kind]}] [{content}]"
        )
        return Array(kind, key, str(len(flat)))

    def declare(self, name: str, result: str, *arguments: str) -> None:
        """Name a function that is not of this module."""
        self.declared[name] = f"declare {result} @{name}({', '.join(arguments)})"

    def function(self, text: Text, node: ast.FunctionDef, given: tuple[tuple, ...]) -> tuple[str, str]:
        """A function for arguments of given kinds: its name, and the kind of what it returns (v: nothing)."""
        key = (id(text), node.name, given)
        if key not in self.made:
            name = f"own.{len(self.made)}.{node.name}"
            self.made[key] = name, "?"  # a function that calls itself has no kind yet, and is refused
            body = Body(self, text, node, given)
            self.made[key] = name, body.returns
            self.parts.append(body.defined(name))
        return self.made[key]

    def _entry(self, node: ast.FunctionDef) -> str:
        """A function that is called by address, around the one that works; its kinds."""
        names = [each.arg for each in node.args.args]
        if "lanewise" in map(_decorator, node.decorator_list):
            raise RefusedError(f"{node.name}: lanes of a function that none calls")
        kinds = ["i" if n in INTEGERS else "f" if n in NUMBERS else "a" for n in names]
        own, returns = self.function(self.text, node, tuple((k, "f") if k == "a" else (k,) for k in kinds))
        pairs = list(zip(names, kinds, strict=True))
        taken = ", ".join(f"{ARRAY if k == 'a' else TYPES[k]} %{n}" for n, k in pairs)
        lines = []
        for n in (n for n, k in pairs if k == "a"):
            lines += [
                f"  %p.{n} = extractvalue {ARRAY} %{n}, 4",
                f"  %n.{n} = extractvalue {ARRAY} %{n}, 5, 0",
            ]
        handed = ", ".join(f"ptr %p.{n}, i64 %n.{n}" if k == "a" else f"{TYPES[k]} %{n}" for n, k in pairs)
        if returns == "v":
            result, lines = "ptr", [*lines, f"  call void @{own}({handed})", "  ret ptr null"]
        else:
            result = "i8" if returns == "b" else TYPES[returns]
            lines.append(f"  %r = call {TYPES[returns]} @{own}({handed})")
            lines += (
                ["  %rr = zext i1 %r to i8", "  ret i8 %rr"] if returns == "b" else [f"  ret {result} %r"]
            )
        self.parts.append("\n".join([f"define {result} @{node.name}({taken}) {{", *lines, "}"]))
        return returns + "".join(kinds)


def _decorator(node: ast.expr) -> str:
    return node.func.id if isinstance(node, ast.Call) else node.id


def _literal(kind: str, value: Any) -> str:
    if kind == "f":
        return "0x" + struct.pack(">d", float(value)).hex().upper()
    return str(int(value))


@dataclass
class Body:
    """The instructions of one function."""

    module: Module
    text: Text
    node: ast.FunctionDef
    given: tuple[tuple, ...]
    returns: str = ""
    lines: list[str] = field(default_factory=list)
    slots: dict[str, str] = field(default_factory=dict)  # names that several suites assign, and their kinds
    names: dict[str, Any] = field(default_factory=dict)
    lane: str | None = None  # the name that counts lanes, where rows are worked on
    width: int = 0  # of these; 0: numbers are
    ended: bool = False  # whether nothing more is reached in this block
    count: int = 0

    def __post_init__(self) -> None:
        arguments = [each.arg for each in self.node.args.args]
        if "lanewise" in map(_decorator, self.node.decorator_list):
            self.lane, self.width = arguments.pop(), ROW
        self.arguments = list(zip(arguments, self.given, strict=True))
        for name, kind in self.arguments:
            place = Array(kind[1], f"%{name}", f"%n.{name}") if kind[0] == "a" else Value(kind[0], f"%{name}")
            self.names[name] = place
        self.shared = _shared(self.node)
        for name in self.shared & self.names.keys():
            self.put(name, self.names[name])
        self.suite(self.node.body)
        if not self.ended:
            if self.returns not in ("", "v"):
                raise RefusedError(f"{self.node.name}: a way without a value")
            self.returns = "v"
            self.emit("ret void")

    def defined(self, name: str) -> str:
        """The definition, under a name."""
        taken = ", ".join(
            f"ptr noalias nocapture %{n}, i64 %n.{n}" if kind[0] == "a" else f"{TYPES[kind[0]]} %{n}"
            for n, kind in self.arguments
        )
        result = "void" if self.returns == "v" else TYPES[self.returns]
        slots = [f"  %slot.{n} = alloca {TYPES[k]}" for n, k in self.slots.items()]
        head = f"define internal {result} @{name}({taken}) alwaysinline {{"
        return "\n".join([head, "entry:", *slots, *self.lines, "}"])

    # Lines

    def emit(self, line: str) -> None:
        """An instruction without a result."""
        self.lines.append(f"  {line}")

    def made(self, kind: str, instruction: str, width: int = 0) -> Value:
        """The result of an instruction."""
        self.count += 1
        self.emit(f"%t{self.count} = {instruction}")
        return Value(kind, f"%t{self.count}", width)

    def block(self, label: str) -> None:
        """Where jumps lead."""
        self.lines.append(f"{label}:")
        self.ended = False

    def label(self) -> str:
        """A number for the labels of a choice or loop."""
        self.count += 1
        return f"b{self.count}"

    def jump(self, label: str) -> None:
        """Go on there, unless something else was said."""
        if not self.ended:
            self.emit(f"br label %{label}")
            self.ended = True

    def refuse(self, node: ast.AST) -> RefusedError:
        """The error that shows what is not in the language."""
        return RefusedError(f"{self.node.name}, line {getattr(node, 'lineno', 0)}: {ast.unparse(node)[:200]}")

    # Statements

    def suite(self, statements: list[ast.stmt]) -> None:
        """Statements, one after the other."""
        for each in statements:
            if self.ended:
                raise self.refuse(each)
            getattr(self, f"_{type(each).__name__}", self._other)(each)

    def _other(self, node: ast.stmt) -> None:
        raise self.refuse(node)

    def _Pass(self, node: ast.Pass) -> None:
        pass

    def _Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            self.value(node.value, unused=True)
        elif not isinstance(node.value, ast.Constant):
            raise self.refuse(node)

    def _Assign(self, node: ast.Assign) -> None:
        if not isinstance(node.value, ast.Tuple):
            value = self.value(node.value)
            for target in node.targets:
                self.store(target, value)
            return
        (target,) = node.targets
        values = [self.value(each) for each in node.value.elts]
        for each, value in zip(target.elts, values, strict=True):
            self.store(each, value)

    def _AugAssign(self, node: ast.AugAssign) -> None:
        before = self.value(node.target)
        self.store(node.target, self.binary(node.op, before, self.value(node.value), node))

    def _Return(self, node: ast.Return) -> None:
        if self.width or node.value is None:
            raise self.refuse(node)
        found = self.value(node.value, unused=isinstance(node.value, ast.Call))
        kind, line = ("v", "ret void") if found is None else (found.kind, f"ret {found.type} {found.text}")
        if self.returns not in ("", kind):
            raise self.refuse(node)
        self.returns, self.ended = kind, True
        self.emit(line)

    def _If(self, node: ast.If) -> None:
        if self.width:
            raise self.refuse(node)
        n, test = self.label(), self.value(node.test)
        other = f"{n}.else" if node.orelse else f"{n}.end"
        self.emit(f"br i1 {test.text}, label %{n}.then, label %{other}")
        before, ends = dict(self.names), []
        for label, body in (("then", node.body), ("else", node.orelse)):
            if body:
                self.block(f"{n}.{label}")
                self.suite(body)
                ends.append(self.ended)
                self.jump(f"{n}.end")
                self.names = dict(before)
        if not node.orelse or not all(ends):
            self.block(f"{n}.end")
        else:
            self.ended = True

    def _While(self, node: ast.While) -> None:
        n = self.label()
        self.jump(f"{n}.test")
        self.block(f"{n}.test")
        test = self.value(node.test)
        self.emit(f"br i1 {test.text}, label %{n}.body, label %{n}.end")
        self._loop(n, node.body, lambda: self.jump(f"{n}.test"))

    def _For(self, node: ast.For) -> None:
        bounds = node.iter.args if isinstance(node.iter, ast.Call) and node.iter.func.id == "range" else None
        if bounds is None or self.width or node.orelse:
            raise self.refuse(node)
        values = [self.value(each) for each in bounds]
        first, last = (Value("i", "0"), values[0]) if len(values) == 1 else values[:2]
        step = int(values[2].text) if len(values) == 3 else 1
        n, counter = self.label(), f"counter.{node.target.id}.{self.count}"
        self.slots[counter] = "i"
        self.emit(f"store i64 {first.text}, ptr %slot.{counter}")
        self.jump(f"{n}.test")
        self.block(f"{n}.test")
        at = self.made("i", f"load i64, ptr %slot.{counter}")
        test = self.made("b", f"icmp {'slt' if step > 0 else 'sgt'} i64 {at.text}, {last.text}")
        self.emit(f"br i1 {test.text}, label %{n}.body, label %{n}.end")

        def again() -> None:
            if not self.ended:
                after = self.made("i", f"add nsw i64 {at.text}, {step}")
                self.emit(f"store i64 {after.text}, ptr %slot.{counter}")
            self.jump(f"{n}.test")

        return self._loop(n, node.body, again, {node.target.id: at})

    def _loop(
        self, n: str, body: list[ast.stmt], again: Callable[[], None], named: dict | None = None
    ) -> None:
        before = dict(self.names)
        self.block(f"{n}.body")
        self.names |= named or {}
        self.suite(body)
        again()
        self.names = before
        self.block(f"{n}.end")

    def store(self, target: ast.expr, value: Value | Array) -> None:
        """Bind a name, or write to an array."""
        if isinstance(target, ast.Name):
            self.put(target.id, value)
            return
        if not isinstance(target, ast.Subscript) or isinstance(value, Array):
            raise self.refuse(target)
        array, pointer, width = self.place(target)
        if width:
            value = self.spread(self.as_float(value), width)
        elif array.kind == "f":
            value = self.as_float(value)
        if value.kind != array.kind:
            raise self.refuse(target)
        self.emit(f"store {value.type} {value.text}, ptr {pointer}, align 8")

    def put(self, name: str, value: Value | Array) -> None:
        """Bind a name."""
        if name not in self.shared:
            self.names[name] = value
            return
        if isinstance(value, Array) or value.width:
            raise RefusedError(f"{self.node.name}: {name} in several suites")
        kind = self.slots.setdefault(name, value.kind)
        if kind == "f":
            value = self.as_float(value)
        if value.kind != kind:
            raise RefusedError(f"{self.node.name}: {name} of several kinds")
        self.emit(f"store {value.type} {value.text}, ptr %slot.{name}")

    # Places in arrays

    def array(self, node: ast.expr) -> Array:
        """An array: an argument, a constant, a slice of another."""
        if isinstance(node, ast.Name):
            found = self.names.get(node.id)
            if found is None and isinstance(self.text.scope.get(node.id), np.ndarray):
                found = self.module.constant(self.text.scope[node.id])
            if isinstance(found, Array):
                return found
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and not node.slice.step:
            array = self.array(node.value)
            first = self.value(node.slice.lower) if node.slice.lower else Value("i", "0")
            if node.slice.upper is None:
                raise self.refuse(node)
            length = self.binary(ast.Sub(), self.value(node.slice.upper), first, node)
            return Array(array.kind, self.element(array, first), length.text)
        raise self.refuse(node)

    def element(self, array: Array, at: Value) -> str:
        """Pointer to an item."""
        if at.kind != "i":
            raise RefusedError(f"{self.node.name}: a place that is no integer")
        if at.text == "0":
            return array.pointer
        return self.made(
            "p", f"getelementptr inbounds {ITEMS[array.kind]}, ptr {array.pointer}, i64 {at.text}"
        ).text

    def place(self, node: ast.Subscript) -> tuple[Array, str, int]:
        """An array, a pointer into it, and over how many lanes it goes."""
        array, index = self.array(node.value), node.slice
        if not self.width or not _names(index, self.lane):
            return array, self.element(array, self.value(index)), 0
        start = _before_lane(index, self.lane)
        if start is None:
            raise self.refuse(node)
        return array, self.element(array, Value("i", "0") if start == 0 else self.value(start)), self.width

    # Expressions

    def value(self, node: ast.expr, unused: bool = False) -> Any:
        """What an expression gives; None of a call that returns nothing, where that may be."""
        method = getattr(self, f"_value_{type(node).__name__}", None)
        if method is None:
            raise self.refuse(node)
        found = method(node)
        if found is None and not unused:
            raise self.refuse(node)
        return found

    def _value_Constant(self, node: ast.Constant) -> Value:
        return self.number(node.value, node)

    def number(self, found: Any, node: ast.AST) -> Value:
        """A number that is known as instructions are written."""
        if isinstance(found, bool) or not isinstance(found, int | float | np.integer | np.floating):
            raise self.refuse(node)
        kind = "i" if isinstance(found, int | np.integer) else "f"
        return Value(kind, _literal(kind, found))

    def _value_Name(self, node: ast.Name) -> Value | Array:
        if node.id in self.slots:
            kind = self.slots[node.id]
            return self.made(kind, f"load {TYPES[kind]}, ptr %slot.{node.id}")
        if node.id in self.names:
            return self.names[node.id]
        found = self.text.scope.get(node.id)
        if isinstance(found, np.ndarray):
            return self.array(node)
        return self.number(found, node)

    def _value_Attribute(self, node: ast.Attribute) -> Value:
        """A constant of a module that the text imports."""
        owner = self.text.scope.get(node.value.id) if isinstance(node.value, ast.Name) else None
        found = getattr(owner, node.attr, None)
        return self.number(found, node)

    def _value_Subscript(self, node: ast.Subscript) -> Value | Array:
        if isinstance(node.slice, ast.Slice):
            return self.array(node)
        array, pointer, width = self.place(node)
        kind = Value(array.kind, "", width)
        return self.made(array.kind, f"load {kind.type}, ptr {pointer}, align 8", width)

    def _value_UnaryOp(self, node: ast.UnaryOp) -> Value:
        value = self.value(node.operand)
        if isinstance(node.op, ast.UAdd):
            return value
        if isinstance(node.op, ast.USub) and value.kind == "f":
            return self.made("f", f"fneg {self.module.licences} {value.type} {value.text}", value.width)
        if isinstance(node.op, ast.USub) and value.kind == "i":
            return self.binary(ast.Sub(), Value("i", "0"), value, node)
        if isinstance(node.op, ast.Not) and value.kind == "b":
            return self.made("b", f"xor i1 {value.text}, true")
        raise self.refuse(node)

    def _value_BinOp(self, node: ast.BinOp) -> Value:
        left = self.value(node.left)
        exponent = node.right.value if isinstance(node.right, ast.Constant) else None
        if isinstance(node.op, ast.Pow) and isinstance(exponent, int):
            return self.power(left, exponent)
        return self.binary(node.op, left, self.value(node.right), node)

    def binary(self, op: ast.operator, left: Value, right: Value, node: ast.AST) -> Value:
        """An operation of two numbers, or rows."""
        if isinstance(left, Array) or isinstance(right, Array) or "b" in (left.kind, right.kind):
            raise self.refuse(node)
        if left.kind == right.kind == "i" and type(op) in WHOLE:
            return self.whole(WHOLE[type(op)], left.text, right.text)
        left, right = self.as_float(left), self.as_float(right)
        if isinstance(op, ast.Pow):
            return self.each("llvm.pow.f64", [left, right])
        if type(op) not in FLOATING:
            raise self.refuse(node)
        width = max(left.width, right.width)
        left, right = self.spread(left, width), self.spread(right, width)
        return self.made(
            "f", f"{FLOATING[type(op)]} {self.module.licences} {left.type} {left.text}, {right.text}", width
        )

    def whole(self, name: str, left: str, right: str) -> Value:
        """An operation of integers, done here where both are written out."""
        if left.lstrip("-").isdigit() and right.lstrip("-").isdigit():
            a, b = int(left), int(right)
            return Value("i", str({"add": a + b, "sub": a - b, "mul": a * b}[name]))
        return self.made("i", f"{name} nsw i64 {left}, {right}")

    def power(self, base: Value, exponent: int) -> Value:
        """A power by repeated squares."""
        base, found, left = self.as_float(base), None, abs(exponent)
        one = self.spread(Value("f", _literal("f", 1.0)), base.width)
        while left:
            if left & 1:
                found = base if found is None else self.binary(ast.Mult(), found, base, self.node)
            left >>= 1
            base = self.binary(ast.Mult(), base, base, self.node) if left else base
        found = one if found is None else found
        return self.binary(ast.Div(), one, found, self.node) if exponent < 0 else found

    def _value_Compare(self, node: ast.Compare) -> Value:
        values = [self.value(each) for each in (node.left, *node.comparators)]
        found = None
        for op, left, right in zip(node.ops, values, values[1:], strict=False):
            one = self.compared(op, left, right, node)
            found = one if found is None else self.joined("and", found, one)
        return found

    def compared(self, op: ast.cmpop, left: Value, right: Value, node: ast.AST) -> Value:
        """The truth of a comparison; none with a number that is none holds, but that they differ."""
        order = ORDER.get(type(op))
        if order is None or isinstance(left, Array) or isinstance(right, Array):
            raise self.refuse(node)
        if left.kind == right.kind == "i":
            signed = order if order in ("eq", "ne") else f"s{order}"
            return self.made("b", f"icmp {signed} i64 {left.text}, {right.text}")
        left, right = self.as_float(left), self.as_float(right)
        width = max(left.width, right.width)
        left, right = self.spread(left, width), self.spread(right, width)
        sure = "une" if order == "ne" else f"o{order}"
        return self.made(
            "b", f"fcmp {self.module.licences} {sure} {left.type} {left.text}, {right.text}", width
        )

    def joined(self, how: str, left: Value, right: Value) -> Value:
        """Both, or any."""
        width = max(left.width, right.width)
        left, right = self.spread(left, width), self.spread(right, width)
        return self.made("b", f"{how} {left.type} {left.text}, {right.text}", width)

    def _value_BoolOp(self, node: ast.BoolOp) -> Value:
        how = "and" if isinstance(node.op, ast.And) else "or"
        found, *rest = [self.value(each) for each in node.values]
        for each in rest:
            found = self.joined(how, found, each)
        if found.kind != "b":
            raise self.refuse(node)
        return found

    def _value_IfExp(self, node: ast.IfExp) -> Value:
        test = self.value(node.test)
        if test.kind != "b":
            raise self.refuse(node)
        if not test.width and not self.width and (_reads(node.body) or _reads(node.orelse)):
            return self._branched(test, node)
        return self.chosen(test, self.value(node.body), self.value(node.orelse))

    def chosen(self, test: Value, yes: Value, no: Value) -> Value:
        """One of two values."""
        if yes.kind != no.kind:
            yes, no = self.as_float(yes), self.as_float(no)
        width = max(test.width, yes.width, no.width)
        yes, no = self.spread(yes, width), self.spread(no, width)
        return self.made(
            yes.kind, f"select {test.type} {test.text}, {yes.type} {yes.text}, {no.type} {no.text}", width
        )

    def _branched(self, test: Value, node: ast.IfExp) -> Value:
        """One of two values of which only the chosen may be computed."""
        n = self.label()
        self.emit(f"br i1 {test.text}, label %{n}.then, label %{n}.else")
        slot, kinds = f"choice.{n}", []
        for label, each in (("then", node.body), ("else", node.orelse)):
            self.block(f"{n}.{label}")
            value = self.as_float(self.value(each))
            kinds.append(value.kind)
            self.emit(f"store double {value.text}, ptr %slot.{slot}")
            self.jump(f"{n}.end")
        self.slots[slot] = "f"
        self.block(f"{n}.end")
        return self.made("f", f"load double, ptr %slot.{slot}")

    # Calls

    def _value_Call(self, node: ast.Call) -> Value | None:
        if node.keywords:
            raise self.refuse(node)
        name = self._called(node.func)
        if isinstance(name, str):
            return self._built_in(name, node)
        text, function = name
        if "lanewise" in map(_decorator, function.decorator_list) and self.width:
            raise self.refuse(node)
        values = [self.value(each) for each in node.args]
        if text is not self.module.text and function.name in text.scope.get("UNIT", ()):
            return self._outside(text, function, values)
        if self.width and not any(isinstance(each, Array) for each in values):
            if _straight(function) and any(each.width for each in values):
                return self._spliced(text, function, values)
            return self._lane_by_lane(text, function, [self.as_float(each) for each in values])
        if any(not isinstance(each, Array) and each.width for each in values):
            raise self.refuse(node)
        kinds = tuple(("a", v.kind) if isinstance(v, Array) else (v.kind,) for v in values)
        return self._own(text, function, kinds, values)

    def _called(self, node: ast.expr) -> str | tuple[Text, ast.FunctionDef]:
        """A function: a name that is built in, or one that is written here or in the method."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = self.text.scope.get(node.value.id)
            if (found := _imported(owner.__name__).named(node.attr)) is not None:
                return found
        if not isinstance(node, ast.Name):
            raise self.refuse(node)
        if (found := self.text.named(node.id)) is not None:
            return found
        given = self.text.scope.get(node.id)
        if node.id in ("min", "max", "abs", "len") and given is None:
            return node.id
        if given is not None and given is getattr(math, getattr(given, "__name__", ""), None):
            return given.__name__
        if isinstance(given, np.ufunc):
            return given.__name__
        raise self.refuse(node)

    def _own(self, text: Text, function: ast.FunctionDef, kinds: tuple, values: Iterable) -> Value | None:
        name, returns = self.module.function(text, function, kinds)
        handed = ", ".join(
            f"ptr {v.pointer}, i64 {v.length}" if isinstance(v, Array) else f"{v.type} {v.text}"
            for v in values
        )
        if returns == "?":
            raise RefusedError(f"{function.name} calls itself")
        if returns == "v":
            self.emit(f"call void @{name}({handed})")
            return None
        return self.made(
            returns,
            f"call {self.module.licences if returns == 'f' else ''} {TYPES[returns]} @{name}({handed})",
        )

    def _outside(self, text: Text, function: ast.FunctionDef, values: list) -> Value | None:
        """A call of a compiled function of the method by its name, which is resolved where code is loaded."""
        handed = ", ".join(
            f"{ARRAY} {self._struct(v)}" if isinstance(v, Array) else f"{v.type} {v.text}" for v in values
        )
        types = [ARRAY if isinstance(v, Array) else v.type for v in values]
        returns = any(isinstance(each, ast.Return) and each.value for each in ast.walk(function))
        name, result = f"{text.scope['__name__']}.{function.name}", "double" if returns else "ptr"
        self.module.declare(name, result, *types)
        self.module.outside[name] = None
        found = self.made("f", f"call {result} @{name}({handed})")
        return found if returns else None

    def _struct(self, array: Array) -> str:
        """An array as seven words."""
        words = [("ptr", "null", "0"), ("ptr", "null", "1"), ("i64", array.length, "2"), ("i64", "8", "3")]
        words += [("ptr", array.pointer, "4"), ("i64", array.length, "5, 0"), ("i64", "8", "6, 0")]
        found = "poison"
        for type_, word, place in words:
            found = self.made("p", f"insertvalue {ARRAY} {found}, {type_} {word}, {place}").text
        return found

    def _built_in(self, name: str, node: ast.Call) -> Value:
        if name == "len":
            return Value("i", self.array(node.args[0]).length)
        values = [self.value(each) for each in node.args]
        if name in ("min", "max"):
            return self._extreme(ast.Lt() if name == "min" else ast.Gt(), values, node)
        values = [self.as_float(each) for each in values]
        name = "fabs" if name == "abs" else name
        if name in INTRINSIC:
            width = max(each.width for each in values)
            if width and name in OF_ROWS:
                values = [self.spread(each, width) for each in values]
                return self.called(f"llvm.{name}.v{width}f64", values)
            return self.each(f"llvm.{name}.f64", values)
        if name in LIBRARY:
            return self.each(name, values)
        raise self.refuse(node)

    def _extreme(self, op: ast.cmpop, values: list[Value], node: ast.AST) -> Value:
        """As Python's min and max: another value is taken only where it is beyond."""
        found, *rest = values
        for each in rest:
            found = self.chosen(self.compared(op, each, found, node), each, found)
        return found

    def called(self, name: str, values: list[Value]) -> Value:
        """A function from outside."""
        width, type_ = values[0].width, values[0].type
        self.module.declare(name, type_, *(each.type for each in values))
        handed = ", ".join(f"{each.type} {each.text}" for each in values)
        return self.made("f", f"call {self.module.licences} {type_} @{name}({handed})", width)

    def each(self, name: str, values: list[Value]) -> Value:
        """A function of numbers, lane by lane where a value is a row."""
        return self._by_lane(values, lambda numbers: self.called(name, numbers))

    def _lane_by_lane(self, text: Text, function: ast.FunctionDef, values: list[Value]) -> Value:
        kinds = tuple(("f",) for _ in values)
        return self._by_lane(values, lambda numbers: self._own(text, function, kinds, numbers))

    def _by_lane(self, values: list[Value], call: Callable[[list[Value]], Value]) -> Value:
        width = max(each.width for each in values)
        if not width:
            return call(values)
        values = [self.spread(each, width) for each in values]
        found = Value("f", "poison", width)
        for i in range(width):
            parts = [self.made("f", f"extractelement {v.type} {v.text}, i32 {i}") for v in values]
            one = call(parts)
            if one.kind != "f":
                raise RefusedError(f"{self.node.name}: no number of a lane")
            found = self.made(
                "f", f"insertelement {found.type} {found.text}, double {one.text}, i32 {i}", width
            )
        return found

    def _spliced(self, text: Text, function: ast.FunctionDef, values: list[Value]) -> Value:
        """A straight function of the method, written out on rows."""
        mine = self.text, self.names, self.lane
        names = [each.arg for each in function.args.args]
        self.text, self.names, self.lane = text, dict(zip(names, values, strict=True)), None
        found = self._result(function.body, function)
        self.text, self.names, self.lane = mine
        return found

    def _result(self, statements: list[ast.stmt], function: ast.FunctionDef) -> Value:
        for n, each in enumerate(statements):
            if isinstance(each, ast.Return):
                return self.value(each.value)
            if isinstance(each, ast.If):
                test, before = self.value(each.test), dict(self.names)
                yes = self._result(each.body, function)
                self.names = dict(before)
                return self.chosen(test, yes, self._result([*each.orelse, *statements[n + 1 :]], function))
            self.suite([each])
        raise RefusedError(f"{function.name}: no result")

    # Kinds

    def as_float(self, value: Value) -> Value:
        """A number as a float."""
        if isinstance(value, Array) or value.kind == "b":
            raise RefusedError(f"{self.node.name}: {value} is no number")
        if value.kind == "f":
            return value
        if value.text.lstrip("-").isdigit():
            return Value("f", _literal("f", int(value.text)))
        return self.made("f", f"sitofp i64 {value.text} to double")

    def spread(self, value: Value, width: int) -> Value:
        """A number in all lanes."""
        if value.width == width:
            return value
        if value.width:
            raise RefusedError(f"{self.node.name}: rows of several widths")
        row, plain = Value(value.kind, "", width).type, TYPES[value.kind]
        if not value.text.startswith("%"):
            return Value(value.kind, f"<{', '.join([f'{plain} {value.text}'] * width)}>", width)
        one = self.made(value.kind, f"insertelement {row} poison, {plain} {value.text}, i32 0", width)
        zeros = f"<{width} x i32> zeroinitializer"
        return self.made(value.kind, f"shufflevector {row} {one.text}, {row} poison, {zeros}", width)


def _suites(statements: list[ast.stmt]) -> Iterable[list[ast.stmt]]:
    """A suite, and all below it."""
    yield statements
    for each in statements:
        for part in ("body", "orelse"):
            if isinstance(each, ast.If | ast.For | ast.While) and getattr(each, part):
                yield from _suites(getattr(each, part))


def _assigned(statements: list[ast.stmt]) -> set[str]:
    """Names that the statements of a suite assign themselves."""
    found: set[str] = set()
    for each in statements:
        if isinstance(each, ast.Assign | ast.AugAssign):
            targets = each.targets if isinstance(each, ast.Assign) else [each.target]
            for target in targets:
                parts = target.elts if isinstance(target, ast.Tuple) else [target]
                found |= {part.id for part in parts if isinstance(part, ast.Name)}
    return found


def _shared(node: ast.FunctionDef) -> set[str]:
    """Names that are assigned in several suites; arguments count as one."""
    seen: set[str] = {each.arg for each in node.args.args}
    shared: set[str] = set()
    for suite in _suites(node.body):
        names = _assigned(suite)
        shared |= names & seen
        seen |= names
    return shared


def _before_lane(node: ast.expr, lane: str | None) -> ast.expr | int | None:
    """What is added to the lane's number in a place, 0 if nothing; None of any other place."""
    if isinstance(node, ast.Name) and node.id == lane:
        return 0
    plus = isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add) and isinstance(node.right, ast.Name)
    return node.left if plus and node.right.id == lane and not _names(node.left, lane) else None


def _names(node: ast.AST, name: str | None) -> bool:
    return any(isinstance(each, ast.Name) and each.id == name for each in ast.walk(node))


def _reads(node: ast.expr) -> bool:
    return any(isinstance(each, ast.Subscript | ast.Call) for each in ast.walk(node))


def _straight(function: ast.FunctionDef) -> bool:
    """Whether a function assigns, chooses and returns, and no more."""
    return all(
        isinstance(each, ast.Assign | ast.If | ast.Return | ast.Expr | ast.Pass) for each in function.body
    )
