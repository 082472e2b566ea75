"""Loops of the method as object code: self-contained, loaded without numba, called with records."""

import ctypes
import os
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest

from jointplay.solver.codegen import cache, place
from jointplay.solver.method.interface import INT, REAL, Array, Compiled, Record, Signature, interpreted

pytestmark = pytest.mark.skipif(interpreted(), reason="nothing is compiled")
OUTSIDE = {
    "cos",
    "exp",
    "hypot",
    "log",
    "memcpy",
    "memmove",
    "memset",
    "pow",
    "sin",
    "sincos",
    "sqrt",
    "tanh",
}
LOADED = """
import sys
from jointplay.solver.codegen import cache
loop = cache.method({name!r})
print(sorted(vars(loop)), sorted(set(sys.modules) & {{"numba", "scipy", "sympy"}}))
"""


def undefined(code: bytes) -> set[str]:
    """Names that a relocatable ELF file of 64 bits takes from elsewhere."""

    def number(at: int, size: int) -> int:
        return int.from_bytes(code[at : at + size], "little")

    first, size, count = number(40, 8), number(58, 2), number(60, 2)
    found = set()
    for section in range(first, first + count * size, size):
        if number(section + 4, 4) != 2:  # no table of symbols
            continue
        begin, length, names = number(section + 24, 8), number(section + 32, 8), number(section + 40, 4)
        strings = number(first + names * size + 24, 8)
        for at in range(begin + 24, begin + length, 24):
            if number(at + 6, 2) == 0:
                name = strings + number(at, 4)
                found.add(code[name : code.index(b"\0", name)].decode())
    return found


@pytest.mark.parametrize(
    "name", ["flow", "tangents.tangent_flow", "walls.wall_flow", "lanes.flow", "lanes.lane", "lanes.attempts"]
)
def test_object_code_needs_nothing_but_mathematics(name):
    cache.method(name)
    place.settle()
    code = place.read(cache._file(name))
    assert undefined(code) <= OUTSIDE
    assert len(code) < 300_000


@pytest.mark.parametrize("name", ["flow", "lanes.flow"])
def test_loading_needs_no_numba(name):
    cache.method(name)
    place.settle()
    own = os.environ | {place.HANDED: str(place.folder())}
    code = LOADED.format(name=name)
    done = subprocess.run([sys.executable, "-c", code], env=own, capture_output=True, text=True, check=True)
    assert done.stdout == "['flow'] []\n"


class Sample(NamedTuple):
    """All that a record may hold."""

    table: np.ndarray
    n: int
    h: float
    row: np.ndarray


SAMPLE = Sample(np.arange(6.0).reshape(2, 3), 7, 0.5, np.arange(4))
RECORD = Record.of(SAMPLE)


def test_a_record_is_words_one_after_another():
    assert RECORD.places == {"table": 0, "n": 3, "h": 4, "row": 5, "": 7}
    words = np.frombuffer(RECORD.pack(SAMPLE), dtype=np.int64)
    assert words.tolist()[1:4] == [2, 3, 7]
    assert words[4:5].view(float)[0] == 0.5
    assert words[[0, 5]].tolist() == [SAMPLE.table.ctypes.data, SAMPLE.row.ctypes.data]
    assert words[6] == 4


@pytest.mark.parametrize(
    "wrong",
    [
        {"table": np.zeros((3, 2)).T},
        {"table": np.zeros(6)},
        {"row": np.zeros(4)},
        {"row": np.zeros(8, dtype=np.int64)[::2]},
        {"row": np.zeros(4, dtype=np.int32)},
    ],
)
def test_another_kind_of_array_is_refused(wrong):
    with pytest.raises(TypeError, match="not an array of"):
        RECORD.pack(SAMPLE._replace(**wrong))


READS = """
define double @reads(ptr %record, i64 %n, {ptr, ptr, i64, i64, ptr, [2 x i64], [2 x i64]} %array) {
  %place = getelementptr i64, ptr %record, i64 4
  %h = load double, ptr %place
  %data = extractvalue {ptr, ptr, i64, i64, ptr, [2 x i64], [2 x i64]} %array, 4
  %at = getelementptr double, ptr %data, i64 %n
  %x = load double, ptr %at
  %y = fadd double %x, %h
  %columns = extractvalue {ptr, ptr, i64, i64, ptr, [2 x i64], [2 x i64]} %array, 5, 1
  %z = sitofp i64 %columns to double
  %sum = fadd double %y, %z
  ret double %sum
}
"""


def test_a_call_hands_over_records_numbers_and_arrays():
    library = place.Library(place.emit(READS))
    given = Signature(REAL, (RECORD, INT, Array(axes=2)))
    reads = Compiled(library.address("reads"), given, library)
    assert reads(SAMPLE, 5, 10.0 * SAMPLE.table) == 50.0 + 0.5 + 3.0
    with pytest.raises((ValueError, TypeError, ctypes.ArgumentError)):
        reads(SAMPLE, 5)
