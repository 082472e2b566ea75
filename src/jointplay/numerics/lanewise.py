"""Functions of one lane, compiled as operations on whole rows of eight.

    @lanewise
    def name(w, i):
        x = w[8 + i] * 2.0
        w[16 + i] = x if x > 0.0 else w[0 + i]

is called as name(w). It may assign, choose (x if c else y), and call functions: those that do no more than
itself, or return early, are written out, and all others but roots are called lane by lane. A loop over the
lanes would be compiled to the same instructions once the compiler has proved that it may, after many times as
long.
"""

import ast
import builtins
import math
import operator
import sys
from functools import cache

import numba
from numba import float64, types
from numba.extending import intrinsic

from .compiler import ready
from .interface import interpreted
from .numba_private import ir

LANES = 8
ROW = ir.VectorType(ir.DoubleType(), LANES)
PLACE = ir.IntType(64)
ARITHMETIC = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
ORDER = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!="}
STRAIGHT = (ast.Assign, ast.If, ast.Return, ast.Expr, ast.Pass)
OF_ROWS = {math.sqrt: "llvm.sqrt.v8f64", abs: "llvm.fabs.v8f64"}


def lanewise(function):
    """Apply a straight-line function of rows `w` and lane `i` to all lanes."""
    if interpreted():
        return plain(function)

    def typed(context, w):
        def code(context, builder, signature, values):
            data = context.make_array(signature.args[0])(context, builder, values[0]).data
            _Body(context, builder, function, data).run()
            return context.get_dummy_value()

        return types.void(w), code

    typed.__name__ = function.__name__
    return intrinsic(typed)


def plain(function):
    """The same as a loop, where nothing is compiled."""

    def apply(w):
        for i in range(LANES):
            function(w, i)

    return apply


@cache
def _functions(module: str) -> dict[str, ast.FunctionDef]:
    """Functions of a module, parsed."""
    tree = ast.parse(sys.modules[module].__loader__.get_source(module))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def _node(function):
    return _functions(function.__module__)[function.__name__]


class _Body:
    """One function as it is written down: its names, each a row, and the rows in memory."""

    def __init__(self, context, builder, function, data=None, names=()):
        self.context, self.builder, self.data = context, builder, data
        self.scope, self.names = function.__globals__, dict(names)
        self.node = _node(function)

    def run(self, statements=None):
        """Write down statements; what the function returns."""
        statements = self.node.body if statements is None else statements
        for n, each in enumerate(statements):
            if isinstance(each, ast.Return):
                return self.value(each.value)
            if isinstance(each, ast.If):
                rest = [*each.orelse, *statements[n + 1 :]]
                return self.builder.select(self.value(each.test), self.run(each.body), self.run(rest))
            if isinstance(each, ast.Assign):
                self.assign(each)
            elif not isinstance(each, ast.Expr | ast.Pass):
                raise NotImplementedError(ast.unparse(each))
        return None

    def assign(self, node):
        """Bind names, or store rows."""
        parts = [(target, node.value) for target in node.targets]
        if isinstance(node.value, ast.Tuple):
            parts = list(zip(node.targets[0].elts, node.value.elts, strict=True))
        found = [(target, self.value(value)) for target, value in parts]
        for target, value in found:
            if isinstance(target, ast.Name):
                self.names[target.id] = value
            else:
                self.builder.store(value, self.place(target)).align = 8

    def place(self, node):
        """Pointer to the row whose number of this lane is w[start + i]."""
        if not (isinstance(node, ast.Subscript) and isinstance(node.slice, ast.BinOp)):
            raise NotImplementedError(ast.unparse(node))
        start = ir.Constant(PLACE, node.slice.left.value)
        return self.builder.bitcast(self.builder.gep(self.data, [start]), ROW.as_pointer())

    def value(self, node):
        """What an expression gives, in all lanes."""
        return getattr(self, f"_{type(node).__name__}")(node)

    def _Constant(self, node):
        return ir.Constant(ROW, [float(node.value)] * LANES)

    def _Name(self, node):
        if node.id in self.names:
            return self.names[node.id]
        return ir.Constant(ROW, [float(self.scope[node.id])] * LANES)

    def _Subscript(self, node):
        found = self.builder.load(self.place(node))
        found.align = 8
        return found

    def _BinOp(self, node):
        left, right = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow):
            return self.each(operator.pow, left, right)
        return getattr(self.builder, ARITHMETIC[type(node.op)])(left, right)

    def _UnaryOp(self, node):
        if not isinstance(node.op, ast.USub):
            raise NotImplementedError(ast.unparse(node))
        return self.builder.fneg(self.value(node.operand))

    def _Compare(self, node):
        values = [self.value(each) for each in (node.left, *node.comparators)]
        found = None
        for op, left, right in zip(node.ops, values, values[1:], strict=False):
            kind = self.builder.fcmp_unordered if isinstance(op, ast.NotEq) else self.builder.fcmp_ordered
            one = kind(ORDER[type(op)], left, right)
            found = one if found is None else self.builder.and_(found, one)
        return found

    def _BoolOp(self, node):
        join = self.builder.and_ if isinstance(node.op, ast.And) else self.builder.or_
        first, *rest = (self.value(each) for each in node.values)
        for each in rest:
            first = join(first, each)
        return first

    def _IfExp(self, node):
        return self.builder.select(self.value(node.test), self.value(node.body), self.value(node.orelse))

    def _Call(self, node):
        name, values = node.func.id, [self.value(each) for each in node.args]
        function = self.scope.get(name, getattr(builtins, name, None))
        if function in (min, max):
            return self.extreme("<" if function is min else ">", values)
        if function in OF_ROWS:
            kind = ir.FunctionType(ROW, [ROW])
            return self.builder.call(self.declared(OF_ROWS[function], kind), values)
        written = hasattr(function, "how")  # another of the method's
        if written and all(isinstance(each, STRAIGHT) for each in _node(function).body):
            names = zip(function.__code__.co_varnames, values, strict=False)
            return _Body(self.context, self.builder, function, names=names).run()
        return self.each(numba.typeof(ready(function)) if written else function, *values)

    def extreme(self, order, values):
        """As Python's min and max: another value is taken only where it is beyond."""
        found = values[0]
        for each in values[1:]:
            found = self.builder.select(self.builder.fcmp_ordered(order, each, found), each, found)
        return found

    def declared(self, name, kind):
        """An instruction that LLVM has as a function."""
        module = self.builder.module
        return module.globals.get(name) or ir.Function(module, kind, name)

    def each(self, function, *values):
        """A function of numbers, lane by lane."""
        signature = float64(*[float64] * len(values))
        if isinstance(function, types.Callable):
            signature = function.get_call_type(self.context.typing_context, signature.args, {})
        call = self.context.get_function(function, signature)
        found = ir.Constant(ROW, ir.Undefined)
        for i in range(LANES):
            lane = ir.Constant(ir.IntType(32), i)
            one = call(self.builder, [self.builder.extract_element(value, lane) for value in values])
            found = self.builder.insert_element(found, one, lane)
        return found
