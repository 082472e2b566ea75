"""Generated source as instructions of LLVM: a module's text in, its intermediate representation out.

The generated texts (codegen.module, algebra, variation, ensemble) are plain Python and run as such where
nothing is compiled. They keep to the small language of codegen.reader, so no compiler of Python is needed.

A function of one lane that is marked `lanewise`, straight lines that read and write w[… + i], becomes
operations on rows of eight numbers. Within rows `x if c else y` chooses lane by lane, with both values
computed, and functions without a vector form are called for one lane after the other. A loop over the lanes,
`for i in range(8)`, is one, which LLVM turns into the same instructions.

Of the licences of fast arithmetic those are given that method.interface gives: contraction to fused
multiply-add, reciprocals, signed zero.

Functions that others call by address are in the binary interface of the method's function pointers: an array
is a struct of seven words by value (two unused, length, size of an item, address, shape, stride). Arrays that
are handed to one call do not overlap.
"""

from __future__ import annotations

import ast
import struct
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from .reader import ARITHMETIC, ORDER, Reader, RefusedError, Text, assigned, decorators, suites

FAST = "contract arcp nsz"  # licences of arithmetic
ARRAY = "{ptr, ptr, i64, i64, ptr, [1 x i64], [1 x i64]}"
INTEGERS = {"variant", "k", "j", "guard"}  # arguments that are no arrays
NUMBERS = {"h", "start", "ratio"}
TYPES = {"f": "double", "i": "i64", "b": "i1"}
ITEMS = {"f": "double", "i": "i64"}
ROW = 8  # lanes of a function that is marked `lanewise`


class Value(NamedTuple):
    """An operand: its kind (f: float, i: integer, b: truth), and its number of lanes (0: one number)."""

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
    """Instructions of a module's text, its arithmetic with the licences of method.interface, or others.

    Raises
    ------
    RefusedError
        When the text leaves the language of codegen.reader.
    """
    return Module(Text.of(source), licences).finished()


class Module:
    """The instructions of one text, function by function as they are needed."""

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
        """A function for arguments of given kinds: its name, and the kind of its result (v: nothing)."""
        key = (text, node.name, given)
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
        if "lanewise" in decorators(node):
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


def _literal(kind: str, value: Any) -> str:
    if kind == "f":
        return "0x" + struct.pack(">d", float(value)).hex().upper()
    return str(int(value))


class Body(Reader):
    """The instructions of one function, for arguments of given kinds."""

    def __init__(self, module: Module, text: Text, node: ast.FunctionDef, kinds: tuple[tuple, ...]) -> None:
        super().__init__(text, node)
        self.module, self.returns, self.count = module, "", 0
        self.lines: list[str] = []
        self.slots: dict[str, str] = {}  # names that several suites assign, and their kinds
        self.lane, self.width = None, 0  # the name that counts lanes, where rows are worked on; their width
        self.ended = False  # whether nothing more is reached in this block
        arguments = list(self.given)
        if "lanewise" in decorators(node):
            self.lane, self.width = arguments.pop(), ROW
        if len(arguments) != len(kinds):
            raise self.refuse(f"{len(kinds)} arguments in place of {len(arguments)}")
        self.arguments = list(zip(arguments, kinds, strict=True))
        self.names = {
            name: Array(kind[1], f"%{name}", f"%n.{name}") if kind[0] == "a" else Value(kind[0], f"%{name}")
            for name, kind in self.arguments
        }
        self.shared = _shared(node)
        for name in self.shared.intersection(arguments):
            self.put(name, self.names[name])
        self.suite(node.body)
        if not self.ended:
            if self.returns not in ("", "v"):
                raise self.refuse("a way without a value", node)
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
        """Begin a block, to which jumps lead."""
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

    # Statements

    def suite(self, statements: list[ast.stmt]) -> None:
        """Statements, one after the other, as far as they are reached."""
        for each in statements:
            if self.ended:
                raise self.refuse("what is never reached", each)
            self.read(each)

    def _store(self, targets: list[ast.expr], value: Value | Array) -> None:
        for target in targets:
            if isinstance(target, ast.Name):
                self.put(target.id, value)
            else:
                self.write(target, value)

    def _Return(self, node: ast.Return) -> None:
        if self.width or node.value is None:
            raise self.refuse()
        found = self.read(node.value)
        kind, line = ("v", "ret void") if found is None else (found.kind, f"ret {found.type} {found.text}")
        if self.returns not in ("", kind):
            raise self.refuse()
        self.returns, self.ended = kind, True
        self.emit(line)

    def _If(self, node: ast.If) -> None:
        if self.width:
            raise self.refuse()
        n, test = self.label(), self.truth(node.test)
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
        test = self.truth(node.test)
        self.emit(f"br i1 {test.text}, label %{n}.body, label %{n}.end")
        self._loop(n, node.body, lambda: self.jump(f"{n}.test"))

    def _counted(self, node: ast.For, first: Value, last: Value, step: int) -> None:
        if self.width:
            raise self.refuse()
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

        self._loop(n, node.body, again, **{node.target.id: at})

    def _loop(self, n: str, body: list[ast.stmt], again: Callable[[], None], **running: Value) -> None:
        before = dict(self.names)
        self.block(f"{n}.body")
        self.names |= running
        self.suite(body)
        again()
        self.names = before
        self.block(f"{n}.end")

    def write(self, target: ast.Subscript, value: Value | Array) -> None:
        """Write to a place of an array."""
        array, pointer, width = self.pointer(target)
        if width:
            value = self.spread(self.as_float(value), width)
        elif array.kind == "f":
            value = self.as_float(value)
        if isinstance(value, Array) or value.kind != array.kind:
            raise self.refuse()
        self.emit(f"store {value.type} {value.text}, ptr {pointer}, align 8")

    def put(self, name: str, value: Value | Array) -> None:
        """Bind a name."""
        if name not in self.shared:
            self.names[name] = value
            return
        if isinstance(value, Array) or value.width:
            raise self.refuse(f"{name} in several suites")
        kind = self.slots.setdefault(name, value.kind)
        if kind == "f":
            value = self.as_float(value)
        if value.kind != kind:
            raise self.refuse(f"{name} of several kinds")
        self.emit(f"store {value.type} {value.text}, ptr %slot.{name}")

    # Places in arrays

    def array(self, value: Value | Array) -> Array:
        """The value, which has to be an array."""
        if not isinstance(value, Array):
            raise self.refuse("what is no array")
        return value

    def _length(self, array: Value | Array) -> Value:
        return Value("i", self.array(array).length)

    def _part(self, array: Value | Array, first: Value, end: Value | None) -> Array:
        if end is None:
            raise self.refuse()
        array, length = self.array(array), self._binary(ast.Sub, end, first)
        return Array(array.kind, self.element(array, first), length.text)

    def element(self, array: Array, at: Value) -> str:
        """Pointer to an item."""
        if at.kind != "i":
            raise self.refuse("a place that is no integer")
        if at.text == "0":
            return array.pointer
        return self.made(
            "p", f"getelementptr inbounds {ITEMS[array.kind]}, ptr {array.pointer}, i64 {at.text}"
        ).text

    def pointer(self, node: ast.Subscript) -> tuple[Array, str, int]:
        """An array, a pointer into it, and the number of its lanes."""
        array, index = self.array(self.value(node.value)), node.slice
        if not self.width or not _names(index, self.lane):
            return array, self.element(array, self.place(index)), 0
        start = _before_lane(index, self.lane)
        if start is None:
            raise self.refuse()
        return array, self.element(array, Value("i", "0") if start == 0 else self.value(start)), self.width

    def _item(self, node: ast.Subscript) -> Value:
        array, pointer, width = self.pointer(node)
        kind = Value(array.kind, "", width)
        return self.made(array.kind, f"load {kind.type}, ptr {pointer}, align 8", width)

    # Expressions

    def _number(self, found: Any) -> Value:
        if isinstance(found, bool) or not isinstance(found, int | float | np.integer | np.floating):
            raise self.refuse()
        kind = "i" if isinstance(found, int | np.integer) else "f"
        return Value(kind, _literal(kind, found))

    def _outer(self, found: Any) -> Value | Array:
        return self.module.constant(found) if isinstance(found, np.ndarray) else self._number(found)

    def _Name(self, node: ast.Name) -> Value | Array:
        if node.id in self.slots:
            kind = self.slots[node.id]
            return self.made(kind, f"load {TYPES[kind]}, ptr %slot.{node.id}")
        return super()._Name(node)

    def _negated(self, value: Value) -> Value:
        if value.kind == "i":
            return self._binary(ast.Sub, Value("i", "0"), value)
        value = self.as_float(value)
        return self.made("f", f"fneg {self.module.licences} {value.type} {value.text}", value.width)

    def truth(self, node: ast.expr) -> Value:
        """The value of an expression that has to be a truth."""
        if (found := self.value(node)).kind != "b":
            raise self.refuse("a number as a truth", node)
        return found

    def _denied(self, value: Value) -> Value:
        if value.kind != "b" or value.width:
            raise self.refuse()
        return self.made("b", f"xor i1 {value.text}, true")

    def _binary(self, op: type[ast.operator], left: Value, right: Value) -> Value:
        if isinstance(left, Array) or isinstance(right, Array) or "b" in (left.kind, right.kind):
            raise self.refuse()
        floats, integers, *_ = ARITHMETIC.get(op, ("", ""))
        if integers and left.kind == right.kind == "i":
            return self.whole(integers, left.text, right.text)
        left, right = self.as_float(left), self.as_float(right)
        if op is ast.Pow:
            return self.each("llvm.pow.f64", [left, right])
        if not floats:
            raise self.refuse()
        left, right = self.level(left, right)
        line = f"{floats} {self.module.licences} {left.type} {left.text}, {right.text}"
        return self.made("f", line, left.width)

    def whole(self, name: str, left: str, right: str) -> Value:
        """An operation of integers, done here where both are written out."""
        if left.lstrip("-").isdigit() and right.lstrip("-").isdigit():
            a, b = int(left), int(right)
            return Value("i", str({"add": a + b, "sub": a - b, "mul": a * b}[name]))
        return self.made("i", f"{name} nsw i64 {left}, {right}")

    def _power(self, base: Value, exponent: int) -> Value:
        base, found, left = self.as_float(base), None, abs(exponent)
        one = self.spread(Value("f", _literal("f", 1.0)), base.width)
        while left:
            if left & 1:
                found = base if found is None else self._binary(ast.Mult, found, base)
            left >>= 1
            base = self._binary(ast.Mult, base, base) if left else base
        found = one if found is None else found
        return self._binary(ast.Div, one, found) if exponent < 0 else found

    def _compared(self, op: type[ast.cmpop], left: Value, right: Value) -> Value:
        if op not in ORDER or isinstance(left, Array) or isinstance(right, Array):
            raise self.refuse()
        order, _ = ORDER[op]
        if left.kind == right.kind == "i":
            signed = order if order in ("eq", "ne") else f"s{order}"
            return self.made("b", f"icmp {signed} i64 {left.text}, {right.text}")
        left, right = self.level(self.as_float(left), self.as_float(right))
        sure = "une" if order == "ne" else f"o{order}"
        line = f"fcmp {self.module.licences} {sure} {left.type} {left.text}, {right.text}"
        return self.made("b", line, left.width)

    def _joined(self, op: type[ast.boolop], values: list[Value]) -> Value:
        if any(each.kind != "b" for each in values):
            raise self.refuse()
        found, *rest = values
        for each in rest:
            left, right = self.level(found, each)
            how = "and" if op is ast.And else "or"
            found = self.made("b", f"{how} {left.type} {left.text}, {right.text}", left.width)
        return found

    def _IfExp(self, node: ast.IfExp) -> Value:
        test = self.truth(node.test)
        if not test.width and not self.width and (_reads(node.body) or _reads(node.orelse)):
            return self._branched(test, node)
        return self.chosen(test, self.value(node.body), self.value(node.orelse))

    def chosen(self, test: Value, yes: Value, no: Value) -> Value:
        """One of two values."""
        if yes.kind != no.kind:
            yes, no = self.as_float(yes), self.as_float(no)
        yes, no = self.level(yes, no, least=test.width)
        line = f"select {test.type} {test.text}, {yes.type} {yes.text}, {no.type} {no.text}"
        return self.made(yes.kind, line, yes.width)

    def _branched(self, test: Value, node: ast.IfExp) -> Value:
        """One of two values of which only the chosen may be computed."""
        n = self.label()
        self.emit(f"br i1 {test.text}, label %{n}.then, label %{n}.else")
        slot = f"choice.{n}"
        for label, each in (("then", node.body), ("else", node.orelse)):
            self.block(f"{n}.{label}")
            value = self.as_float(self.value(each))
            self.emit(f"store double {value.text}, ptr %slot.{slot}")
            self.jump(f"{n}.end")
        self.slots[slot] = "f"
        self.block(f"{n}.end")
        return self.made("f", f"load double, ptr %slot.{slot}")

    # Calls

    def _own(self, text: Text, function: ast.FunctionDef, values: list[Value | Array]) -> Value | None:
        if "lanewise" in decorators(function) and self.width:
            raise self.refuse()
        if text is not self.module.text and function.name in text.scope.get("UNIT", ()):
            return self._outside(text, function, values)
        if self.width and not any(isinstance(each, Array) for each in values):
            if _straight(function) and any(each.width for each in values):
                return self._spliced(text, function, values)
            values = [self.as_float(each) for each in values]
            return self._by_lane(values, lambda one: self._inside(text, function, one))
        if any(not isinstance(each, Array) and each.width for each in values):
            raise self.refuse()
        return self._inside(text, function, values)

    def _inside(self, text: Text, function: ast.FunctionDef, values: Iterable) -> Value | None:
        kinds = tuple(("a", v.kind) if isinstance(v, Array) else (v.kind,) for v in values)
        name, returns = self.module.function(text, function, kinds)
        handed = ", ".join(
            f"ptr {v.pointer}, i64 {v.length}" if isinstance(v, Array) else f"{v.type} {v.text}"
            for v in values
        )
        if returns == "?":
            raise self.refuse(f"{function.name} calls itself")
        if returns == "v":
            self.emit(f"call void @{name}({handed})")
            return None
        licences = self.module.licences if returns == "f" else ""
        return self.made(returns, f"call {licences} {TYPES[returns]} @{name}({handed})")

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

    def _applied(self, names: tuple[str, ...], values: list[Value]) -> Value:
        one, rows, _ = names
        if not one:
            raise self.refuse()
        values = self.level(*map(self.as_float, values))
        return self.call(rows, values) if rows and values[0].width else self.each(one, values)

    def _extreme(self, order: type[ast.cmpop], found: Value, other: Value) -> Value:
        return self.chosen(self._compared(order, other, found), other, found)

    def call(self, name: str, values: list[Value]) -> Value:
        """A function from outside."""
        width, type_ = values[0].width, values[0].type
        self.module.declare(name, type_, *(each.type for each in values))
        handed = ", ".join(f"{each.type} {each.text}" for each in values)
        return self.made("f", f"call {self.module.licences} {type_} @{name}({handed})", width)

    def each(self, name: str, values: list[Value]) -> Value:
        """A function of numbers, lane by lane where a value is a row."""
        return self._by_lane(values, lambda numbers: self.call(name, numbers))

    def _by_lane(self, values: list[Value], call: Callable[[list[Value]], Value]) -> Value:
        values = self.level(*values)
        if not (width := values[0].width):
            return call(values)
        found = Value("f", "poison", width)
        for i in range(width):
            parts = [self.made("f", f"extractelement {v.type} {v.text}, i32 {i}") for v in values]
            one = call(parts)
            if one is None or one.kind != "f":
                raise self.refuse("no number of a lane")
            line = f"insertelement {found.type} {found.text}, double {one.text}, i32 {i}"
            found = self.made("f", line, width)
        return found

    def _spliced(self, text: Text, function: ast.FunctionDef, values: list[Value]) -> Value:
        """A straight function of the method, written out on rows."""
        mine = dict(vars(self))
        super().__init__(text, function)
        self.names, self.lane = dict(zip(self.given, values, strict=True)), None
        found = self._result(function.body)
        vars(self).update(mine | {"count": self.count})
        return found

    def _result(self, statements: list[ast.stmt]) -> Value:
        for n, each in enumerate(statements):
            if isinstance(each, ast.Return):
                return self.value(each.value)
            if isinstance(each, ast.If):
                test, before = self.truth(each.test), dict(self.names)
                yes = self._result(each.body)
                self.names = dict(before)
                return self.chosen(test, yes, self._result([*each.orelse, *statements[n + 1 :]]))
            self.suite([each])
        raise self.refuse("no result", self.node)

    # Kinds

    def as_float(self, value: Value) -> Value:
        """A number as a float."""
        if isinstance(value, Array) or value.kind == "b":
            raise self.refuse(f"{value} is no number")
        if value.kind == "f":
            return value
        if value.text.lstrip("-").isdigit():
            return Value("f", _literal("f", int(value.text)))
        return self.made("f", f"sitofp i64 {value.text} to double")

    def level(self, *values: Value, least: int = 0) -> list[Value]:
        """Values over as many lanes as the widest of them."""
        width = max(least, *(each.width for each in values))
        return [self.spread(each, width) for each in values]

    def spread(self, value: Value, width: int) -> Value:
        """A number in all lanes."""
        if value.width == width:
            return value
        if value.width:
            raise self.refuse("rows of several widths")
        row, plain = Value(value.kind, "", width).type, TYPES[value.kind]
        if not value.text.startswith("%"):
            return Value(value.kind, f"<{', '.join([f'{plain} {value.text}'] * width)}>", width)
        one = self.made(value.kind, f"insertelement {row} poison, {plain} {value.text}, i32 0", width)
        zeros = f"<{width} x i32> zeroinitializer"
        return self.made(value.kind, f"shufflevector {row} {one.text}, {row} poison, {zeros}", width)


def _shared(node: ast.FunctionDef) -> set[str]:
    """Names that are assigned in several suites; arguments count as one."""
    seen = Counter(each.arg for each in node.args.args)
    for suite in suites(node):
        seen.update([*assigned(each for each in suite if not isinstance(each, ast.For))])
    return {name for name, times in seen.items() if times > 1}


def _before_lane(node: ast.expr, lane: str | None) -> ast.expr | int | None:
    """Term added to the lane's number in a place, 0 if nothing; None of any other place."""
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
