"""Common subexpressions of a program: the ones that SymPy's `cse` finds, named in its order.

All variants of a structure have most of their expressions in common, so that an expression's sign is asked
for once in all of them; and what holds nothing that is named is left as it is, where SymPy builds it anew.
"""

from collections.abc import Iterator
from functools import lru_cache

from sympy import Add, Expr, Integer, Mul, Pow, Symbol
from sympy.simplify.cse_main import Unevaluated, match_common_args

MINUS = Integer(-1)


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
