"""Vector operations on lane rows against what their text says, at places that are no multiple of a row."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.method.compiler import ready
from jointplay.solver.method.interface import compiled as marked
from jointplay.solver.method.lanes import lanes
from jointplay.solver.method.memory import lane_rows

PLACES = [(0, 8, 16, 24), (40, 8, 24, 0), (3, 21, 11, 45), (55, 0, 47, 20), (8, 16, 16, 40), (30, 5, 40, 12)]
COUNTS = (0, 1, 5)


@ready
@marked
def compiled(which, w, source, table, pairs, factor, to, a, b, c):
    """Carry out one of the operations."""
    other, third = 0.3, 2.5
    begin, end = 1, len(pairs)
    if which == 0:
        lanes.matvec(w, to, source, a, table)
    elif which == 1:
        lanes.position_row(w, to, factor, other, a, table, source)
    elif which == 2:
        lanes.add_matvec(w, to, c, factor, a, table)
    elif which == 3:
        lanes.axpy(w, to, factor, a)
    elif which == 4:
        lanes.sparse_dot(w, to, source, pairs, begin, end)
    elif which == 5:
        lanes.subtract_products(w, to, pairs, begin, end)
    elif which == 6:
        lanes.complex_multiply(w, to, a)
    elif which == 7:
        lanes.complex_fma(w, to, a, b)
    else:
        lanes.complex_sum(w, to, factor, a, other, b, third)


def as_read(which, w, source, table, pairs, factor, to, a, b, c):
    """The same by the functions as they read."""
    end = len(pairs)
    (
        lambda: lanes.matvec(w, to, source, a, table),
        lambda: lanes.position_row(w, to, factor, 0.3, a, table, source[:8]),
        lambda: lanes.add_matvec(w, to, c, factor, a, table),
        lambda: lanes.axpy(w, to, factor, a),
        lambda: lanes.sparse_dot(w, to, source, pairs, 1, end),
        lambda: lanes.subtract_products(w, to, pairs, 1, end),
        lambda: lanes.complex_multiply(w, to, a),
        lambda: lanes.complex_fma(w, to, a, b),
        lambda: lanes.complex_sum(w, to, factor, a, 0.3, b, 2.5),
    )[which]()


NAMES = [
    *("matvec", "position_row", "add_matvec", "axpy", "sparse_dot"),
    *("subtract_products", "complex_multiply", "complex_fma", "complex_sum"),
]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("places", PLACES)
def test_operation(name, places):
    """Rows are read whole before any of them is written, so that they may overlap."""
    which, random = NAMES.index(name), np.random.default_rng(NAMES.index(name))
    w, source, table = random.normal(size=64), random.normal(size=64), random.normal(size=64)
    to, *_, squares = places
    for count in COUNTS if name in ("sparse_dot", "subtract_products") else (1,):
        others = [at for at in range(57) if abs(at - to) >= 8]
        pairs = np.array([-99, *random.choice(others, 2 * count)])
        both = w.copy(), w.copy()
        for operation, buffer in zip((compiled, as_read), both, strict=True):
            operation(which, buffer, source, table, pairs, -1.7, *places)
        assert both[0] == pytest.approx(both[1], rel=1e-13, abs=1e-13)
        changed = {*range(to, to + 8), *(range(squares, squares + 8) if name == "add_matvec" else ())}
        assert set(np.flatnonzero(both[0] != w)) == (
            set() if name == "subtract_products" and not count else changed
        )


def test_every_operation_is_tested():
    assert {name for name, value in vars(lanes).items() if hasattr(value, "how")} == {*NAMES}


def test_complex_rows_are_real_parts_then_imaginary_parts():
    w = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0] * 3)
    row = np.array([1 + 5j, 2 + 6j, 3 + 7j, 4 + 8j])
    pairs = np.array([0, 8, 16])
    for which, expected in (
        (5, row - row * row),
        (6, row * row),
        (7, row + row * row),
        (8, -1.4 * row + 2.5),
    ):
        found = w.copy()
        compiled(which, found, w, w, pairs, -1.7, 0, 8, 16, 0)
        assert found[:4] + 1j * found[4:8] == pytest.approx(expected)


def test_rows_begin_at_a_cache_line():
    for n in range(9):
        rows = [lane_rows(n) for _ in range(5)]
        assert [len(row) for row in rows] == [8 * n] * 5
        assert not n or {row.ctypes.data % 64 for row in rows} == {0}
