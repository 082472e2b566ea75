"""A straight-line program as symbols: assignments, derivatives, live symbols, common subexpressions.

Differentiation is forward mode on the program: the derivative of an assigned symbol is itself assigned once
and shared, so that a Jacobian reuses what the force has computed. Sines and cosines differentiate by the
chain rule of their angle, roots of equations by theirs.

Common subexpressions of a program: the ones that SymPy's `cse` finds, named in its order.

All variants of a structure have most of their expressions in common, so that an expression's sign is asked
for once in all of them; and what holds nothing that is named is left as it is, where SymPy builds it anew.
"""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import count
from operator import attrgetter

from sympy import Add, Expr, Integer, Mul, Pow, Symbol, sympify
from sympy.simplify.cse_main import Unevaluated, match_common_args

from ..equations.system import Root, System, number

FLOW = Symbol("flow", real=True)

MINUS = Integer(-1)


# A structure's variants have most of their expressions in common.
@lru_cache(maxsize=20000)
def read(value: Expr) -> list[Symbol]:
    """Symbols in an expression, by name."""
    return sorted(value.free_symbols, key=attrgetter("name"))


@lru_cache(maxsize=20000)
def partial(value: Expr, s: Symbol) -> Expr:
    """d value / d s as if all other symbols were constants."""
    if value.is_Add:
        return Add(*[partial(term, s) for term in value.args if s in term.free_symbols])
    if value.is_Mul:
        factors = [(i, factor) for i, factor in enumerate(value.args) if s in factor.free_symbols]
        return Add(*[Mul(*value.args[:i], partial(each, s), *value.args[i + 1 :]) for i, each in factors])
    return value.diff(s)


class Tape:
    """Assignments in the order in which they were made, with derivatives memoised."""

    def __init__(self, system: System):
        self.values: dict[Symbol, Expr] = {}
        self._named: dict[Expr, Symbol] = {}
        self._slopes: dict[tuple[Symbol, Symbol], Expr] = {}
        # the flow changes every position at its speed, speeds not at all
        self._directions = {
            FLOW: dict(zip(system.positions, system.speeds, strict=False))
        } | system.directions
        self._trig = {a.sin: (a, a.cos) for a in system.angles} | {a.cos: (a, -a.sin) for a in system.angles}
        self._roots = {s: (root, *of) for root in system.roots for s, of in root.symbols.items()}
        self._held = {s for root in system.roots for s in root.held}
        for symbol, value in system.definitions:
            self.define(symbol, value)

    def define(self, symbol: Symbol, value: Expr) -> Expr:
        """Assign a value to a given symbol; a constant is given back as itself, so that it can simplify."""
        self.values[symbol] = sympify(value)
        return self.values[symbol] if self.values[symbol].is_Number else symbol

    def let(self, name: str, value: Expr) -> Expr:
        """Name a value, unless it is a number, a symbol, or named already."""
        value = sympify(value)
        if value.is_Number or value.is_Symbol:
            return value
        if value not in self._named:
            self._named[value] = self.define(number(name), value)
        return self._named[value]

    def derivative(self, value: Expr, x: Symbol) -> Expr:
        """d value / d x through every assignment (x: a position, a speed, time, `FLOW`, or a direction)."""
        slopes = [(s, self._slope(s, x)) for s in read(sympify(value))]
        return Add(*[partial(value, s) * slope for s, slope in slopes if slope])

    def _slope(self, s: Symbol, x: Symbol) -> Expr:
        along = self._directions.get(x, {x: Integer(1)})
        if s in along:
            return along[s]
        if s in self._trig:
            angle, other = self._trig[s]
            return other * self.derivative(angle.value, x)
        if s not in self.values or s in self._held:
            return Integer(0)
        if s in self._roots:
            return self._rooted(*self._roots[s], x)
        if (s, x) not in self._slopes:
            self._slopes[s, x] = self.let(f"d_{s.name}_d_{x.name}", self.derivative(self.values[s], x))
        return self._slopes[s, x]

    def _rooted(self, root: Root, place: int, factor: Expr, x: Symbol) -> Expr:
        """d symbol / d x = factor times -(J^-1 dg/dx)_place."""
        moved = [self.derivative(g, x) for g in root.residuals]
        pairs = zip(root.inverse[place], moved, strict=True)
        total = -sum((entry * slope for entry, slope in pairs), Integer(0))
        return factor * self.let(f"d_root_{root.held[0]}_{place}_d_{x}", total)

    def solved(self, x: Symbol, slopes: dict[Expr, Expr]) -> None:
        """Take these derivatives along x as known."""
        self._slopes |= {(s, x): slope for s, slope in slopes.items() if s.is_Symbol}

    def program(self, results: dict[str, Expr]) -> list[tuple[Symbol, Expr]]:
        """Assignments that `results` need, common subexpressions taken out, in an order that can be executed.

        Results appear under symbols of their own names.
        """
        wanted = {Symbol(name): sympify(value) for name, value in results.items()}
        live = self.behind(wanted.values())
        assigned = {s: self.values[s] for s in self.values if s in live} | wanted
        found, reduced = shared(list(assigned.values()), map(number, map("k{}".format, count())))
        return _in_order(dict(found) | dict(zip(assigned, reduced, strict=True)))

    def behind(self, roots: Iterable[Expr]) -> set[Symbol]:
        """Symbols that some expressions need, in them or behind assigned symbols."""
        live: set[Symbol] = set()
        queue = [s for value in roots for s in read(value)]
        while queue:
            s = queue.pop()
            if s not in live:
                live.add(s)
                queue += read(self.values[s]) if s in self.values else []
        return live


def _in_order(assigned: dict[Symbol, Expr]) -> list[tuple[Symbol, Expr]]:
    """Assignments sorted so that each comes after the ones it uses (depth first)."""
    done: dict[Symbol, Expr] = {}

    def visit(s: Symbol) -> None:
        if s in done or s not in assigned:
            return
        for t in read(assigned[s]):
            visit(t)
        done[s] = assigned[s]

    for s in assigned:
        visit(s)
    return list(done.items())


def shared(values: list[Expr], names: Iterator[Symbol]) -> tuple[list[tuple[Symbol, Expr]], list[Expr]]:
    """Subexpressions that occur more than once, each by a name, and the values in terms of these."""
    forms = _forms(values)
    repeated, found, named = _repeated(values, forms), [], {}

    def reduced(expr):
        if not expr.args:
            return expr
        if expr in named:
            return named[expr]
        form = forms.get(expr, expr)
        args = tuple(map(reduced, form.args))
        new = form if args == form.args and form is expr else form.func(*args)
        if expr not in repeated:
            return new
        named[expr] = next(names)
        found.append((named[expr], new))
        return named[expr]

    return found, [reduced(value) for value in values]


def _forms(values: list[Expr]) -> dict[Expr, Unevaluated]:
    """Other forms of expressions: negatives, inverses, sums and products of terms that several share."""
    forms, adds, muls, seen = {}, {}, {}, set()

    def visit(expr: Expr) -> None:
        if not expr.args or expr in seen:
            return
        seen.add(expr)
        for arg in expr.args:
            visit(arg)
        opposite = _opposite(expr)
        if opposite is not None:
            forms[expr] = Unevaluated(Mul, (MINUS, opposite))
            seen.add(opposite)
            expr = opposite
        if expr.is_Mul:
            muls[expr] = None
        elif expr.is_Add:
            adds[expr] = None
        elif expr.is_Pow and _negative(expr.exp):
            forms[expr] = Unevaluated(Pow, (Pow(expr.base, -expr.exp), MINUS))

    for value in values:
        visit(value)
    match_common_args(Add, adds, forms)
    match_common_args(Mul, muls, forms)
    return forms


def _repeated(values: list[Expr], forms: dict[Expr, Unevaluated]) -> set[Expr]:
    seen, repeated = set(), set()

    def visit(expr) -> None:
        if not expr.args:
            return
        if expr in seen:
            repeated.add(expr)
            return
        seen.add(expr)
        for arg in forms.get(expr, expr).args:
            visit(arg)

    for value in values:
        visit(value)
    return repeated


@lru_cache(maxsize=20000)
def _opposite(expr: Expr) -> Expr | None:
    """The negative of an expression with a minus sign in front, unless that is a symbol."""
    if not _negative(expr):
        return None
    opposite = -expr
    return opposite if opposite.args else None


@lru_cache(maxsize=20000)
def _negative(expr: Expr) -> bool:
    """Whether an expression counts as one with a minus sign in front."""
    if not expr.is_Add:
        first = expr.args[0] if expr.is_Mul else expr
        return first.is_Number and bool(first.is_negative)
    more = 2 * sum(map(_negative, expr.args)) - len(expr.args)
    return more > 0 or (more == 0 and expr.sort_key() < (-expr).sort_key())
