"""Kernels as numba compiles them: plain Python, by the marks and words of .interface."""

from functools import cache
from inspect import isfunction
from types import FunctionType, ModuleType

import numba
from numba import types
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
)

from .interface import OPTIONS, TRAJECTORY, WORK, Array, Record, Signature
from .numba_private import INLINED, INNER, RAISES, UNCOUNTED, Ahead, AttributeTemplate, alloca_once, ir

# One policy for every kernel: free of the interpreter's lock, IEEE division, no reference counting (a kernel
# allocates nothing and keeps nothing). Of the fast-math licences only those are taken that keep NaN and
# infinity meaningful: contraction to fused multiply-add, reciprocals, signed zero.
POLICY = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "arcp", "nsz"}, **UNCOUNTED}
OPTIONS_OF = {"compiled": {}, "inner": INNER, "inlined": INLINED | INNER, "spliced": {"inline": "always"}}
WORD = ir.IntType(64)


class RecordType(types.Type):
    """A `Record`: its address."""

    def __init__(self, record: Record):
        self.record = record
        super().__init__(f"{record.kind.__module__}.{record.kind.__name__}")

    @property
    def mangling_args(self):
        return self.record.kind.__name__, ()


@register_model(RecordType)
class _RecordModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, WORD.as_pointer())


@cache
def typed(what):
    """Type of an argument in numba's words, from the words of .interface."""
    if what is None:
        return types.none
    if isinstance(what, Array):
        return types.Array(getattr(types, what.number), what.axes, "C")
    if isinstance(what, Record):
        return RecordType(what)
    if isinstance(what, Signature):
        return types.ExternalFunctionPointer(signed(what), None)
    return getattr(types, what)


def signed(signature: Signature):
    """A signature in numba's words."""
    return typed(signature.gives)(*map(typed, signature.takes))


@infer_getattr
class _Part(AttributeTemplate):
    key = RecordType

    def generic_resolve(self, kind, name):
        what = kind.record.fields.get(name)
        return None if what is None else typed(what)


@lower_getattr_generic(RecordType)
def _part(context, builder, kind, value, name):
    """A part of a record: loaded where it is used, and the same all the time that a call lasts."""
    what, at = kind.record.fields[name], kind.record.places[name]
    return _loaded(context, builder, what, builder.gep(value, [WORD(at)], inbounds=True))


def _loaded(context, builder, what, place):
    """A value whose words are at a place."""
    if not isinstance(what, Array):
        return _word(builder, place, context.get_value_type(typed(what)))
    kind = typed(what)
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    data = _word(builder, place, context.get_data_type(kind.dtype).as_pointer())
    lengths = [
        _word(builder, builder.gep(place, [WORD(1 + i)], inbounds=True), WORD) for i in range(what.axes)
    ]
    strides, count = [WORD(size)], lengths[-1]
    for length in lengths[-2::-1]:
        strides.insert(0, builder.mul(strides[0], lengths[len(lengths) - len(strides)], flags=("nsw",)))
        count = builder.mul(count, length, flags=("nsw",))
    return _array(builder, context.get_value_type(kind), count, size, data, lengths, strides)


def _array(builder, form, count, size, data, lengths, strides):
    """Numba's structure of an array."""
    parts = [form.elements[0](None), form.elements[1](None), count, WORD(size), data]
    whole = ir.Constant(form, ir.Undefined)
    for i, part in enumerate(parts):
        whole = builder.insert_value(whole, part, i)
    for i, each in enumerate((lengths, strides)):
        for axis, number in enumerate(each):
            whole = builder.insert_value(whole, number, (5 + i, axis))
    return whole


def _word(builder, place, form):
    found = builder.load(builder.bitcast(place, form.as_pointer()))
    found.set_metadata("invariant.load", builder.module.add_metadata([]))
    return found


@intrinsic
def _until(typing, options, end, h_max):
    def code(context, builder, signature, values):
        old, new = values[0], alloca_once(builder, WORD, OPTIONS.places[""])
        for at in range(OPTIONS.places[""]):
            word = builder.load(builder.gep(old, [WORD(at)], inbounds=True))
            builder.store(word, builder.gep(new, [WORD(at)], inbounds=True))
        for name, value in (("t_end", values[1]), ("h_max", values[2])):
            place = builder.gep(new, [WORD(OPTIONS.places[name])], inbounds=True)
            builder.store(value, builder.bitcast(place, value.type.as_pointer()))
        return new

    return options(options, types.float64, types.float64), code


def _nth(record: Record):
    """The instruction that finds a record by its number in a table (interface.table)."""

    @intrinsic
    def nth(typing, words, n):
        def code(context, builder, signature, values):
            whole = context.make_array(signature.args[0])(context, builder, values[0])
            return builder.gep(whole.data, [builder.mul(values[1], WORD(record.places[""]))], inbounds=True)

        return typed(record)(words, types.int64), code

    return nth


OWN = {"until": _until}
OWN |= {"work_at": _nth(WORK), "trajectory_at": _nth(TRAJECTORY), "options_at": _nth(OPTIONS)}


class Compiler:
    """Marked functions as functions of numba, each made once, with the functions that it calls.

    Parameters
    ----------
    make : callable
        Makes a function of numba of a plain one and options.
    """

    def __init__(self, make):
        self._make, self._made, self._scopes = make, {}, {}

    def __call__(self, written):
        """A marked function, ready to be compiled."""
        if written not in self._made:
            self._made[written] = self._of(written)
        return self._made[written]

    def _of(self, written):
        if written.how == "instruction":
            from .lanes.lane_instructions import INSTRUCTIONS

            return (INSTRUCTIONS | OWN)[written.__name__]
        scope = self._scope(written.__globals__)
        code = written.__code__, scope, written.__name__, written.__defaults__, written.__closure__
        copy = FunctionType(*code)
        copy.__module__, copy.__qualname__ = written.__module__, written.__qualname__
        return self._make(copy, POLICY | OPTIONS_OF[written.how])

    def _scope(self, names: dict) -> dict:
        """Names as a module has them, with marked objects compiled."""
        if id(names) not in self._scopes:
            found = self._scopes[id(names)] = {}
            for name, value in names.items():
                found[name] = self._value(value)
        return self._scopes[id(names)]

    def _value(self, value):
        if isfunction(value) and hasattr(value, "how"):
            return self(value)
        if isinstance(value, ModuleType) and any(map(_is_marked, vars(value).values())):
            copy = ModuleType(value.__name__)
            vars(copy).update(self._scope(vars(value)))
            return copy
        return value


def _is_marked(value):
    return isfunction(value) and hasattr(value, "how")


def object_code(module, cpu: str, features: str, level: int = 3) -> bytes:
    """Object code of a module's UNIT, with a symbol for each of its functions."""
    ahead = Ahead(cpu, features, level)
    compiler = Compiler(lambda written, options: ahead.function(written, options | INNER))
    entries = {
        name: (compiler(getattr(module, name)), signed(signature), _Entry(signed(signature)))
        for name, signature in module.UNIT.items()
    }
    return ahead.object(entries)


class _Entry:
    """A function by the C convention, around one as numba calls it."""

    def __init__(self, signature):
        self.signature = signature

    def __call__(self, context, name, described):
        """The module of a function called `name` around the one that numba describes so."""
        module, convention = context.create_module(name), context.call_conv
        kind = convention.get_function_type(described.restype, described.argtypes)
        inner = ir.Function(module, kind, described.llvm_func_name)
        takes, gives = map(context.get_value_type, self.signature.args), self.signature.return_type
        own = ir.Function(module, ir.FunctionType(context.get_value_type(gives), takes), name)
        builder = ir.IRBuilder(own.append_basic_block("entry"))
        status, found = convention.call_function(
            builder, inner, described.restype, described.argtypes, own.args
        )
        with builder.if_then(status.is_error, likely=False):  # nowhere, as Ahead.object sees to
            builder.call(ir.Function(module, ir.FunctionType(ir.VoidType(), []), RAISES), [])
            builder.unreachable()
        builder.ret(found)
        return module


ready = Compiler(lambda copy, options: numba.njit(**options)(copy))  # for what is compiled in this process
