"""Operations on whole lane rows (lanes) as vector instructions."""

from numba import types
from numba.extending import intrinsic

from ..numba_private import alloca_once_value, for_range_slice, ir
from . import lanes

FUSED = ("contract",)
INDEX, LANE = ir.IntType(64), ir.IntType(32)


class Rows:
    """Builder of the instructions of one operation: loads, stores and sums of rows."""

    def __init__(self, context, builder, kinds, values):
        self.builder, self.values = builder, values
        self.data = {
            i: context.make_array(kind)(context, builder, value).data
            for i, (kind, value) in enumerate(zip(kinds, values, strict=True))
            if isinstance(kind, types.Array)
        }

    def place(self, array, offset, width, by=0):
        """Pointer to `width` numbers from an offset in an array argument on."""
        at = self.builder.add(offset, ir.Constant(INDEX, by))
        pointer = self.builder.gep(self.data[array], [at])
        return self.builder.bitcast(pointer, ir.VectorType(ir.DoubleType(), width).as_pointer())

    def load(self, place):
        """The numbers at a place."""
        found = self.builder.load(place)
        found.align = 8
        return found

    def store(self, value, place):
        """Write numbers to a place."""
        self.builder.store(value, place).align = 8

    def index(self, array, offset, by=0):
        """An entry of an array of integers."""
        at = self.builder.add(offset, ir.Constant(INDEX, by))
        return self.builder.load(self.builder.gep(self.data[array], [at]))

    def spread(self, scalar):
        """Eight times one number."""
        empty = ir.Constant(ir.VectorType(ir.DoubleType(), 8), ir.Undefined)
        one = self.builder.insert_element(empty, scalar, ir.Constant(LANE, 0))
        return self.builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(LANE, 8), [0] * 8))

    def plus(self, total, a, b, minus=False):
        """Total + a b (or - a b); a b alone where there is no total yet."""
        term = self.builder.fmul(a, b, flags=FUSED)
        if total is None:
            return term
        join = self.builder.fsub if minus else self.builder.fadd
        return join(total, term, flags=FUSED)

    def matrix(self, source, at, table):
        """Eight numbers of an array argument times a lane-to-lane matrix."""
        total = None
        for j in range(8):
            number = self.load(self.place(source, at, 1, j))
            scalar = self.builder.extract_element(number, ir.Constant(LANE, 0))
            column = self.load(self.place(table, ir.Constant(INDEX, 8 * j), 8))
            total = self.plus(total, self.spread(scalar), column)
        return total

    def complex(self, at):
        """Places and values of the halves of a complex row of the first argument."""
        places = [self.place(0, at, 4, half) for half in (0, 4)]
        return places, [self.load(place) for place in places]


def _compiled(plain, kinds, build):
    """The operation `plain` as an intrinsic: argument kinds by letter (i, f; a: any array), instructions."""
    fixed = {"i": types.int64, "f": types.float64}

    def typed(*given):
        arguments = [fixed.get(kind, actual) for kind, actual in zip(kinds, given[1:], strict=True)]

        def code(context, builder, signature, values):
            build(Rows(context, builder, signature.args, values), *values)
            return context.get_dummy_value()

        return types.void(*arguments), code

    names = plain.__code__.co_varnames[: plain.__code__.co_argcount]
    scope = {"typed": typed}
    exec(
        f"def {plain.__name__}(context, {', '.join(names)}):\n    return typed(context, {', '.join(names)})",
        scope,
    )
    return intrinsic(scope[plain.__name__])


def _build_matvec(rows, w, to, source, at, table):
    rows.store(rows.matrix(2, at, 4), rows.place(0, to, 8))


def _build_position_row(rows, w, to, h, speed, at, table, nodes):
    start = rows.load(rows.place(6, ir.Constant(INDEX, 0), 8))
    total = rows.plus(rows.matrix(0, at, 5), rows.spread(speed), start)
    rows.store(rows.builder.fmul(rows.spread(h), total, flags=FUSED), rows.place(0, to, 8))


def _build_add_matvec(rows, w, to, squares, factor, at, table):
    z = rows.matrix(0, at, 5)
    place, sums = rows.place(0, to, 8), rows.place(0, squares, 8)
    rows.store(rows.builder.fadd(rows.load(place), z, flags=FUSED), place)
    scaled = rows.builder.fmul(rows.spread(factor), z, flags=FUSED)
    rows.store(rows.plus(rows.load(sums), scaled, scaled), sums)


def _build_axpy(rows, w, to, factor, at):
    place = rows.place(0, to, 8)
    rows.store(rows.plus(rows.load(place), rows.spread(factor), rows.load(rows.place(0, at, 8))), place)


def _build_sparse_dot(rows, w, to, numbers, pairs, begin, end):
    builder = rows.builder
    total = alloca_once_value(builder, ir.Constant(ir.VectorType(ir.DoubleType(), 8), [0.0] * 8))
    with for_range_slice(builder, begin, end, ir.Constant(INDEX, 2)) as (o, _):
        number = rows.load(rows.place(2, rows.index(3, o), 1))
        scalar = rows.spread(builder.extract_element(number, ir.Constant(LANE, 0)))
        row = rows.load(rows.place(0, rows.index(3, o, 1), 8))
        builder.store(rows.plus(builder.load(total), scalar, row), total)
    rows.store(builder.load(total), rows.place(0, to, 8))


def _build_subtract_products(rows, w, to, pairs, begin, end):
    builder, (places, old) = rows.builder, rows.complex(to)
    zero = ir.Constant(ir.VectorType(ir.DoubleType(), 4), [0.0] * 4)
    # four sums side by side: a chain of one is twice as slow
    sums = [alloca_once_value(builder, value) for value in (*old, zero, zero)]
    with for_range_slice(builder, begin, end, ir.Constant(INDEX, 2)) as (o, _):
        (_, (a, b)), (_, (c, d)) = (rows.complex(rows.index(2, o, i)) for i in (0, 1))
        terms = ((a, c, True), (a, d, True), (b, d, False), (b, c, True))
        for total, (x, y, minus) in zip(sums, terms, strict=True):
            builder.store(rows.plus(builder.load(total), x, y, minus), total)
    for i, place in enumerate(places):
        rows.store(builder.fadd(builder.load(sums[i]), builder.load(sums[i + 2]), flags=FUSED), place)


def _build_complex_multiply(rows, w, to, a):
    (places, (x, y)), (_, (c, d)) = rows.complex(to), rows.complex(a)
    rows.store(rows.plus(rows.plus(None, x, c), y, d, True), places[0])
    rows.store(rows.plus(rows.plus(None, x, d), y, c), places[1])


def _build_complex_fma(rows, w, to, a, b):
    (places, (x, y)), (_, (p, q)), (_, (c, d)) = (rows.complex(at) for at in (to, a, b))
    rows.store(rows.plus(rows.plus(x, p, c), q, d, True), places[0])
    rows.store(rows.plus(rows.plus(y, p, d), q, c), places[1])


def _build_complex_sum(rows, w, to, x, a, y, b, z):
    builder, real = rows.builder, ir.Constant(ir.VectorType(ir.DoubleType(), 8), [1.0] * 4 + [0.0] * 4)
    total = builder.fmul(rows.spread(z), real, flags=FUSED)
    for number, at in ((x, a), (y, b)):
        total = rows.plus(total, rows.spread(number), rows.load(rows.place(0, at, 8)))
    rows.store(total, rows.place(0, to, 8))


INSTRUCTIONS = {
    each.__name__: _compiled(each, kinds, build)
    for each, kinds, build in (
        (lanes.matvec, "aiaia", _build_matvec),
        (lanes.position_row, "aiffiaa", _build_position_row),
        (lanes.add_matvec, "aiifia", _build_add_matvec),
        (lanes.axpy, "aifi", _build_axpy),
        (lanes.sparse_dot, "aiaaii", _build_sparse_dot),
        (lanes.subtract_products, "aiaii", _build_subtract_products),
        (lanes.complex_multiply, "aii", _build_complex_multiply),
        (lanes.complex_fma, "aiii", _build_complex_fma),
        (lanes.complex_sum, "aififif", _build_complex_sum),
    )
}
