"""Interface of compiled code: marks, types of arguments, and functions that a structure's module supplies.

Functions here are plain Python, and stay so: a decorator marks how one is compiled (method.compiler), which
happens elsewhere, to object code (codegen.cache). What a function takes is said in a few words of its own:

    INT, REAL      a number of 64 bits
    Array          an array without gaps, by the place of its numbers and the length of each axis
    Record         a named tuple, by the address of its parts, one after another; no part is ever exchanged
    Signature      a function, by its address

A compiled function is called by the C convention with these, where an array goes as numba's structure of one
(seven words for one axis, two more for each further one). A `UNIT` of a module names those of its functions
that are called from Python or by address, and their signatures; it is compiled, kept and loaded as one.

Between compiled functions an integer written out in a call makes a version of the callee for that very
number: pass a variable or a float.
"""

import ctypes
import os
import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .memory import Options, trajectory, work

INT, REAL = "int64", "float64"


def interpreted() -> bool:
    """Whether nothing is compiled: kernels run as the Python that they are written in.

    So they do too where places in arrays are to be checked.
    """
    flags = (os.environ.get(f"NUMBA_{name}", "0") for name in ("DISABLE_JIT", "BOUNDSCHECK"))
    return any(flag not in ("", "0") for flag in flags)


class Array(NamedTuple):
    """An array: kind of its numbers, as NumPy names it, and axes."""

    number: str = REAL
    axes: int = 1

    def words(self, value: np.ndarray) -> tuple[int, ...]:
        """Place and lengths, as a record has them.

        Raises
        ------
        TypeError
            When it is another kind of array: what is compiled would read beside it.
        """
        if value.dtype != self.number or value.ndim != self.axes or not value.flags.c_contiguous:
            raise TypeError(f"{self}: not an array of {value.dtype} with shape {value.shape}")
        return (value.__array_interface__["data"][0], *value.shape)


class Signature(NamedTuple):
    """A function: the type of its result (None: nothing), and types of its arguments."""

    gives: Any
    takes: tuple


class Record:
    """A kind of named tuple, as compiled code takes it.

    Parameters
    ----------
    kind : type
        The named tuple.
    fields : mapping
        What each of its fields is.
    """

    def __init__(self, kind: type, fields: Mapping[str, Any]):
        self.kind, self._fields = kind, fields

    @classmethod
    def of(cls, sample: NamedTuple) -> "Record":
        """The kind of a named tuple of arrays and numbers."""
        return cls(type(sample), {name: _seen(value) for name, value in sample._asdict().items()})

    @cached_property
    def fields(self) -> dict[str, Any]:
        """Type of each field, in order."""
        return {name: self._fields[name] for name in self.kind._fields}

    @cached_property
    def places(self) -> dict[str, int]:
        """Offset of each field, in words of 64 bits; at the end, under an empty name, the size."""
        found, at = {}, 0
        for name, what in self.fields.items():
            found[name], at = at, at + (1 + what.axes if isinstance(what, Array) else 1)
        return found | {"": at}

    @cached_property
    def _packed(self) -> Callable[..., bytes]:
        words = ("q" * (1 + f.axes) if isinstance(f, Array) else "d" if f == REAL else "q" for f in self)
        return struct.Struct("=" + "".join(words)).pack

    def __iter__(self):
        return iter(self.fields.values())

    def pack(self, value: tuple) -> bytes:
        """The words of a tuple of this kind, which must outlive their use."""
        words = []
        for what, part in zip(self, value, strict=True):
            if isinstance(what, Array):
                words += what.words(part)
            else:
                words.append(part.address if isinstance(what, Signature) else part)
        return self._packed(*words)


def table(record: Record, values: Sequence[tuple]):
    """Tuples of one kind as compiled code finds them by number (`work_at` …): their words, a row of each.

    The tuples must outlive their use.
    """
    if interpreted():
        return list(values)
    words = b"".join(map(record.pack, values))
    return np.frombuffer(words, dtype=np.int64).reshape(len(values), record.places[""])


def _seen(value) -> Any:
    return Array(value.dtype.name, value.ndim) if isinstance(value, np.ndarray) else _NUMBERS[type(value)]


_NUMBERS = {int: INT, float: REAL}


def void(*takes) -> Signature:
    """A function that gives back nothing."""
    return Signature(None, takes)


vector = Array()
WORK = Record.of(work(1, 1, 1, 1, 1, 1, 1))
TRAJECTORY = Record.of(trajectory(np.zeros(1), np.zeros(1), 1, 1, 0, 0))
OPTIONS = Record.of(Options(*(field(0) for field in Options.__annotations__.values())))

SIGNATURES = {
    "rate": void(INT, vector, vector, vector, vector),
    "jacobian": void(INT, vector, vector, vector, vector),
    "contacts": void(INT, vector, vector, vector, vector),
    "trig": void(vector, vector),
    "reset": void(INT, vector, vector),
    "extrapolate": void(vector, vector, REAL, REAL),
    "rest": void(vector),
    "move": void(vector, vector, REAL),
    "factor": void(INT, vector, vector, REAL),
    "linearised": void(INT, vector, vector),
    "newton": Signature(REAL, (INT, vector, vector, vector, vector, REAL)),
    "estimate": Signature(REAL, (INT, vector, vector, vector, vector, REAL)),
    "variation": void(INT, vector, vector, vector, vector),
    "vary": void(vector, vector),
    "divergence": void(vector),
    "gradient": void(INT, vector, vector, vector, vector),
    "reset_slopes": void(INT, vector, vector, vector),
}


class Functions(NamedTuple):
    """Functions that the flow calls: a structure's (codegen.module), and the method's algebra for its size.

    The algebra is written out by size (codegen.algebra), or goes by a plan (codegen.elimination).
    What happens at rigid walls (wall_flow.at_wall) is compiled only for structures that have some.
    """

    rate: Callable
    jacobian: Callable
    contacts: Callable
    trig: Callable
    reset: Callable
    extrapolate: Callable
    rest: Callable
    move: Callable
    factor: Callable
    newton: Callable
    estimate: Callable
    linearised: Callable
    at_wall: Callable


class Variations(NamedTuple):
    """Derivatives of a structure's functions, for tangents (codegen.variation)."""

    variation: Callable
    vary: Callable
    divergence: Callable
    gradient: Callable
    reset_slopes: Callable


FUNCTIONS, VARIATIONS = Record(Functions, SIGNATURES), Record(Variations, SIGNATURES)
SIGNATURES["at_wall"] = void(FUNCTIONS, INT, INT, WORK, TRAJECTORY, OPTIONS)


_PLAIN = {INT: ctypes.c_int64, REAL: ctypes.c_double}


class Compiled:
    """A compiled function of a unit, called from Python with named tuples, numbers and None.

    Parameters
    ----------
    address : int
        Where it lies.
    signature : Signature
        What it takes: records, numbers and addresses.
    owner : object
        Kept as long as the function is, so that the code stays where it is.
    """

    def __init__(self, address: int, signature: Signature, owner: Any):
        self.address, self.signature, self._owner = address, signature, owner
        gives = None if signature.gives is None else _PLAIN[signature.gives]
        takes = [word for what in signature.takes for word in _kinds(what)]
        self._call = ctypes.CFUNCTYPE(gives, *takes)(address)

    def __call__(self, *values):
        """Call it, with the interpreter's lock released."""
        takes = zip(self.signature.takes, values, strict=True)
        return self._call(*[word for what, value in takes for word in _words(what, value)])


def _kinds(what) -> tuple:
    """The words of an argument, as ctypes names them."""
    if isinstance(what, Array):
        return (ctypes.c_int64,) * (5 + 2 * what.axes)
    return (_PLAIN[what] if isinstance(what, str) else ctypes.c_void_p,)


def _words(what, value) -> tuple:
    """A value as a compiled function takes it."""
    if isinstance(what, Record):
        return (what.pack(value),)
    if isinstance(what, Array):
        place, *lengths = what.words(value)
        return (0, 0, value.size, value.itemsize, place, *lengths, *value.strides)
    return (value.address if isinstance(what, Signature) else value,)


def pointers(*modules, kind=Functions):
    """The functions of modules as a loop takes them."""
    return kind(**{n: getattr(module, n) for module in modules for n in kind._fields if hasattr(module, n)})


def _marks(how):
    """Make a decorator that marks the form in which a function is compiled."""

    def mark(function):
        function.how = how
        return function

    return mark


compiled = _marks("compiled")
inner = _marks("inner")
inlined = _marks("inlined")  # what is called once an attempt
spliced = _marks("spliced")  # the same before types are known: long bodies compile faster
instruction = _marks("instruction")  # written as instructions in another file, beside its meaning in Python


@instruction
def until(options, end, h_max):
    """Options of a run with another end and longest step."""
    return options._replace(t_end=end, h_max=h_max)


@instruction
def work_at(words, n):
    """Work by its number in a table."""
    return words[n]


@instruction
def trajectory_at(words, n):
    """Trajectory by its number in a table."""
    return words[n]


@instruction
def options_at(words, n):
    """Options by their number in a table."""
    return words[n]


def at_wall(functions, guard, at, work, motion, options):
    """Do nothing, and never be called: stands for wall_flow.at_wall in structures without rigid walls."""


at_wall.address = 0
