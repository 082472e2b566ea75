"""From Python to JavaScript: the functions that kernels are written in, and all that they call.

The subset is what numba compiles of them: straight functions with positional arguments, `if`, `while`, `for`
over ranges and arrays, assignments (of tuples too), named tuples as arguments, module constants, functions
handed over. Whatever else stands there is refused with its file and line, never guessed at: so a kernel
cannot leave the subset unseen. What comes out runs on Float64Array and Int32Array, beside helpers in
runtime.js.

A function is named MODULE$NAME, so that no local name can hide it. Names of constants become their values,
arrays stand once under their own names.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from types import ModuleType
from typing import Any

import numpy as np

from jointplay.script.expressions import BINARY, Expressions, UntranslatableError, literal, safe, short

WORDS = {ast.Pass: "", ast.Break: "break", ast.Continue: "continue"}


@dataclass(frozen=True)
class Unit:
    """A module: the word before its functions' names, its text, the values of its global names.

    What is generated is long, and its local names are shortened.
    """

    word: str
    text: str
    scope: Mapping[str, Any] = field(compare=False, repr=False)
    generated: bool = True

    @cached_property
    def functions(self) -> dict[str, ast.FunctionDef]:
        """Functions of the module by name."""
        return {each.name: each for each in ast.parse(self.text).body if isinstance(each, ast.FunctionDef)}


@lru_cache(maxsize=256)
def unit_of(module: str) -> Unit:
    """A module that has been imported."""
    found = importlib.import_module(module)
    return Unit(module.rpartition(".")[2], inspect.getsource(found), vars(found), generated=False)


def generated(word: str, text: str) -> Unit:
    """A generated text whose functions are not compiled here: only its imports and constants are executed."""
    kept = [each for each in ast.parse(text).body if not isinstance(each, ast.FunctionDef)]
    scope: dict[str, Any] = {}
    exec(compile(ast.Module(kept, []), word, "exec"), scope)
    return Unit(word, text, scope)


class Script:
    """JavaScript of functions and of all that they call, gathered as they are asked for."""

    def __init__(self) -> None:
        self._done: dict[str, str] = {}
        self._arrays: dict[int, tuple[str, np.ndarray]] = {}

    @property
    def text(self) -> str:
        """All that was translated so far."""
        arrays = [f"const {name} = {_array(values)};" for name, values in self._arrays.values()]
        return "\n".join([*arrays, *self._done.values()]) + "\n"

    def function(self, unit: Unit, name: str) -> str:
        """Translate a function, once; its name.

        Raises
        ------
        UntranslatableError
            Naming the line and what stands there.
        """
        full = f"{unit.word}${name}"
        if full not in self._done:
            self._done[full] = ""  # it may call itself
            self._done[full] = Function(self, unit, unit.functions[name]).text
        return full

    def named(self, unit: Unit, value: Any) -> str | None:
        """Name of a global function or array; None of anything else."""
        if isinstance(value, np.ndarray):
            return self._array_name(unit, value)
        value = getattr(value, "py_func", value)
        if not inspect.isfunction(value):
            return None
        return self.function(unit_of(value.__module__), value.__name__)

    def _array_name(self, unit: Unit, value: np.ndarray) -> str:
        if id(value) not in self._arrays:
            (name,) = [name for name, other in unit.scope.items() if other is value][:1]
            self._arrays[id(value)] = f"{name}${len(self._arrays)}", value
        return self._arrays[id(value)][0]


def _array(values: np.ndarray) -> str:
    kind = "Int32Array" if values.dtype.kind == "i" else "Float64Array"
    return f"new {kind}([{', '.join(literal(v) or 'NaN' for v in values.ravel())}])"


class Function:
    """Translation of one function."""

    def __init__(self, script: Script, unit: Unit, node: ast.FunctionDef) -> None:
        self._script, self._unit, self._node, self._temporaries = script, unit, node, 0
        arguments = node.args
        if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.defaults:
            raise UntranslatableError(f"{self._where(node)}: arguments that are not plain")
        self._given = [each.arg for each in arguments.args]
        bound = [each.id for each in ast.walk(node) if isinstance(each, ast.Name) and _stored(each)]
        self._bound = [name for name in dict.fromkeys(bound) if name != "_"]
        names = dict.fromkeys([*self._given, *self._bound])
        self._names = {name: short(i) if unit.generated else safe(name) for i, name in enumerate(names)}
        self._translate = Expressions(self._names, self._value, self._named, self._where)
        self._check_loops()

    def _where(self, node: ast.AST) -> str:
        return f"{self._unit.word}.py:{node.lineno} in {self._node.name}"

    def _value(self, name: str) -> Any:
        if name in self._unit.functions:
            return self._unit.functions[name]
        if name in self._unit.scope:
            return self._unit.scope[name]
        built_in = self._unit.scope.get("__builtins__") or __builtins__
        return (built_in if isinstance(built_in, dict) else vars(built_in))[name]

    def _named(self, value: Any) -> str | None:
        if isinstance(value, ast.FunctionDef):  # of the unit that is being translated
            return self._script.function(self._unit, value.name)
        return None if isinstance(value, ModuleType) else self._script.named(self._unit, value)

    def _check_loops(self) -> None:
        """Refuse to read or set a loop's variable where the two languages disagree about it."""
        loops = [each for each in ast.walk(self._node) if isinstance(each, ast.For)]
        for name in {each.target.id for each in loops if isinstance(each.target, ast.Name)} - {"_"}:
            inside = {
                id(n) for each in loops if each.target.id == name for s in each.body for n in ast.walk(s)
            }
            heads = {id(each.target) for each in loops}
            for each in ast.walk(self._node):
                met = isinstance(each, ast.Name) and each.id == name and id(each) not in heads
                if met and (id(each) not in inside or _stored(each)):
                    raise self._translate.refuse(each, f"the loop's variable {name} here")

    @property
    def text(self) -> str:
        """The function in JavaScript."""
        loops = {each.target.id for each in ast.walk(self._node) if isinstance(each, ast.For)}
        own = [self._names[name] for name in self._bound if name not in loops and name not in self._given]
        given = ", ".join(self._names[name] for name in self._given)
        head = f"function {self._unit.word}${self._node.name}({given}) {{"
        names = [f"  let {', '.join(own)};"] if own else []
        lines = [head, *names, *self._block(self._node.body, 1), "}"]
        return "\n".join(map(_dense, lines) if self._unit.generated else lines)

    def _block(self, nodes: list[ast.stmt], depth: int) -> list[str]:
        lines = []
        for node in nodes:
            if isinstance(node, ast.Pass | ast.Break | ast.Continue):
                lines += ["  " * depth + f"{WORDS[type(node)]};"]
                continue
            found = getattr(self, f"_{type(node).__name__.lower()}", None)
            if found is None:
                raise self._translate.refuse(node, type(node).__name__)
            lines += [line if line.startswith("  ") else "  " * depth + line for line in found(node, depth)]
        return lines

    def _expr(self, node: ast.Expr, depth: int) -> list[str]:
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            return []
        if not isinstance(node.value, ast.Call):
            raise self._translate.refuse(node)
        return [f"{self._translate(node.value)};"]

    def _return(self, node: ast.Return, depth: int) -> list[str]:
        if isinstance(node.value, ast.Tuple):
            return [f"return [{', '.join(map(self._translate, node.value.elts))}];"]
        return [f"return {self._translate(node.value)};" if node.value else "return;"]

    def _if(self, node: ast.If, depth: int) -> list[str]:
        lines = [f"if ({self._translate.truth(node.test)}) {{", *self._block(node.body, depth + 1)]
        if len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
            first, *rest = self._if(node.orelse[0], depth)
            return [*lines, f"}} else {first}", *rest]
        if node.orelse:
            lines += ["} else {", *self._block(node.orelse, depth + 1)]
        return [*lines, "}"]

    def _while(self, node: ast.While, depth: int) -> list[str]:
        if node.orelse:
            raise self._translate.refuse(node, "while … else")
        test = self._translate.truth(node.test)
        return [f"while ({test}) {{", *self._block(node.body, depth + 1), "}"]

    def _for(self, node: ast.For, depth: int) -> list[str]:
        if node.orelse or not isinstance(node.target, ast.Name):
            raise self._translate.refuse(node, "this kind of for")
        name = self._temporary() if node.target.id == "_" else self._names[node.target.id]
        body = self._block(node.body, depth + 1)
        if isinstance(node.iter, ast.Call) and ast.unparse(node.iter.func) == "range":
            return [self._range(node.iter, name), *body, "}"]
        if not isinstance(node.iter, ast.Name | ast.Attribute):
            raise self._translate.refuse(node.iter)
        array, at = self._translate(node.iter), self._temporary()
        head = f"for (let {at} = 0; {at} < {array}.length; {at} += 1) {{"
        return [head, "  " * (depth + 1) + f"const {name} = {array}[{at}];", *body, "}"]

    def _range(self, node: ast.Call, name: str) -> str:
        ends = [self._translate(each) for each in node.args]
        begin, end = ("0", ends[0]) if len(ends) == 1 else ends[:2]
        by, last = ends[2] if len(ends) == 3 else "1", self._temporary()
        if node.keywords or not re.fullmatch(r"-?[1-9]\d*", by):
            raise self._translate.refuse(node)
        change, sign = ("-=", ">") if by[0] == "-" else ("+=", "<")
        head = f"let {name} = {begin}, {last} = {end}; {name} {sign} {last}; {name} {change} {by.lstrip('-')}"
        return f"for ({head}) {{"

    def _temporary(self) -> str:
        self._temporaries += 1
        return f"t${self._temporaries}"

    def _augassign(self, node: ast.AugAssign, depth: int) -> list[str]:
        target = self._target(node.target)
        if type(node.op) in BINARY:
            sign, _ = BINARY[type(node.op)]
            return [f"{target} {sign}= {self._translate(node.value)};"]
        if any(isinstance(each, ast.Call) for each in ast.walk(node.target)):
            raise self._translate.refuse(node)  # it would be called twice
        whole = ast.copy_location(ast.BinOp(node.target, node.op, node.value), node)
        return [f"{target} = {self._translate(whole)};"]

    def _assign(self, node: ast.Assign, depth: int) -> list[str]:
        first, *more = node.targets
        if isinstance(first, ast.Tuple):
            if more:
                raise self._translate.refuse(node)
            return self._unpacked(node, first.elts)
        return [f"{' = '.join(map(self._target, node.targets))} = {self._translate(node.value)};"]

    def _unpacked(self, node: ast.Assign, targets: list[ast.expr]) -> list[str]:
        """Several targets: of a call's results, or of as many values, all of them found before any is set."""
        wanted = [(i, t) for i, t in enumerate(targets) if not (isinstance(t, ast.Name) and t.id == "_")]
        if isinstance(node.value, ast.Tuple) and len(node.value.elts) == len(targets):
            names = [self._temporary() for _ in targets]
            values = zip(names, map(self._translate, node.value.elts), strict=True)
            lines = [f"const {name} = {value};" for name, value in values]
            return lines + [f"{self._target(t)} = {names[i]};" for i, t in wanted]
        if not isinstance(node.value, ast.Call):
            raise self._translate.refuse(node)
        found = self._temporary()
        lines = [f"const {found} = {self._translate(node.value)};"]
        return lines + [f"{self._target(t)} = {found}[{i}];" for i, t in wanted]

    def _target(self, node: ast.expr) -> str:
        whole = isinstance(node, ast.Subscript) and not isinstance(node.slice, ast.Slice)
        if not isinstance(node, ast.Name) and not whole:
            raise self._translate.refuse(node)
        return self._translate(node)


def _dense(line: str) -> str:
    """A line without what only readers need."""
    return re.sub(r" (\*|/|=) ", r"\1", line.strip())


def _stored(node: ast.Name) -> bool:
    return isinstance(node.ctx, ast.Store)
