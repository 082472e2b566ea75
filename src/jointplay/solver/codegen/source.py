"""Programs as numba source: eight lanes around one straight-line body, or one point at a time.

Lanes are increments from a base point: row r of the flat buffer `w` is w[8 r : 8 r + 8], and one buffer
holds what is read and what is written, so that the compiler sees that they do not overlap. Sines and
cosines are rotated from the base point's by a polynomial of the increment, exact to rounding for
|increment| <= MAX_TURN.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import factorial

from sympy import Expr, S, Symbol
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.str import StrPrinter

from ..equations.system import TIME, System
from ..method.memory import method_rows
from .lambert import LAMBERT
from .tape import read

LANES = 8
MAX_TURN = 0.75
SIN = [(-1) ** k / factorial(2 * k + 1) for k in range(8)]
COS = [(-1) ** k / factorial(2 * k) for k in range(9)]


class Printer(StrPrinter):
    """Expressions as Python arithmetic: small powers by multiplication, rationals as floats."""

    def _print(self, expr, **kwargs):
        return expr.name if expr.is_Symbol else super()._print(expr, **kwargs)  # soon, as most are

    def parenthesize(self, item, level, strict=False):
        return item.name if item.is_Symbol else super().parenthesize(item, level, strict)

    def _print_Pow(self, expr, rational=False):
        base, power = self.parenthesize(expr.base, PRECEDENCE["Atom"], strict=True), expr.exp
        if power == -1:
            return f"(1.0/{base})"
        if power.is_Integer and abs(power) <= 4:
            product = "*".join([base] * abs(int(power)))
            return f"({product})" if power > 0 else f"(1.0/({product}))"
        if abs(power) == S.Half:
            return f"sqrt({self._print(expr.base)})" if power > 0 else f"(1.0/sqrt({self._print(expr.base)}))"
        return f"({base}**({self._print(power)}))"

    def _print_Max(self, expr):
        return f"max({', '.join(map(self._print, expr.args))})"

    def _print_Heaviside(self, expr):
        return f"(1.0 if {self._print(expr.args[0])} > 0.0 else 0.0)"

    def _print_Float(self, expr):
        return repr(float(expr))

    _print_Half = _print_Rational = _print_Float

    def _print_side(self, expr):
        return f"copysign(1.0, {self._print(expr.args[0])})"

    def _print_power(self, expr):
        base, exponent = (self.parenthesize(x, PRECEDENCE["Atom"], strict=True) for x in expr.args)
        return f"({base}**{exponent})"


expression = Printer({"order": "none"}).doprint


@dataclass(frozen=True)
class Layout:
    """Places of values: the base point `s`, the rows of `w`, the masks `m`.

    `method` is the number of rows at the beginning of `w` that are the method's own; 0: as the written-out
    algebra has them.
    """

    system: System
    method: int = 0

    @property
    def state(self) -> tuple[Symbol, ...]:
        """Positions, then speeds."""
        return self.system.positions + self.system.speeds

    @property
    def base(self) -> dict[Symbol, int]:
        """Places in s: time, positions, speeds, sines, cosines."""
        angles = self.system.angles
        symbols = [TIME, *self.state, *(a.sin for a in angles), *(a.cos for a in angles)]
        return {symbol: place for place, symbol in enumerate(symbols)}

    @property
    def masks(self) -> dict[Symbol, int]:
        """Places in m: touch, slip, stick of each contact, then of each rigid wall."""
        words, parts = ("touch", "slip", "stick"), (*self.system.contacts, *self.system.resets)
        names = [f"{word}_{part.name}" for part in parts for word in words]
        return {Symbol(name, real=True): place for place, name in enumerate(names)}

    @property
    def rows(self) -> dict[str, int]:
        """First row of each block of w, after the method's own."""
        system, row = self.system, {}
        n = len(system.speeds)
        start = self.method or method_rows(n)
        blocks = {
            "time": 1,
            "state": len(self.state),
            "rate": n,
            "fold": len(system.folds),
            "guard": 4 * len(system.contacts),
            "reset": len(system.resets),
            "rub": system.rubs,
            "section": int(system.section is not None),
            "power": len(system.powers),
        }
        for name, size in blocks.items():
            row[name], start = start, start + size
        return row | {"end": start}


Program = list[tuple[Symbol, Expr]]


SELDOM = ("copysign", "exp", "log")  # functions that few laws need


def importing(source: str) -> str:
    """A module's text with the seldom functions that it calls: imported, or written out."""
    if "lambert(" in source:  # after what the text imports
        head, imported, rest = source.partition("import compiled\n\n")
        source = head + imported + LAMBERT + rest
    names = "".join(f"{name}, " for name in SELDOM if f"{name}(" in source)
    return source.replace("from math import ", f"from math import {names}", 1)


def entry(name: str, arguments: str) -> list[str]:
    """Head of a function that the method calls; it is compiled when its address is first needed."""
    return ["@compiled", f"def {name}({arguments}):"]


def dispatch(name: str, arguments: str, functions: dict[int, str]) -> str:
    """A function that calls one of several by number, which is its first argument."""
    which, rest = arguments.split(", ", 1)
    lines = [f"    if {which} == {k}:\n        {function}({rest})" for k, function in functions.items()]
    return "\n".join([*entry(name, arguments), *(lines or ["    pass"])]) + "\n\n"


def used(program: Program, symbols: Iterable[Symbol]) -> list[Symbol]:
    """The `symbols` that the program reads, in their order."""
    found = {symbol for _, value in program for symbol in read(value)}
    return [symbol for symbol in symbols if symbol in found]


def statements(program: Program, indent: str) -> list[str]:
    """The program's assignments as lines."""
    return [f"{indent}{symbol.name} = {expression(value)}" for symbol, value in program]


def _loads(layout: Layout, program: Program) -> list[str]:
    """Parameters and masks that the program reads, as local names."""
    numbers = {symbol: f"p[{i}]" for i, symbol in enumerate(layout.system.parameters)}
    numbers |= {symbol: f"m[{i}]" for symbol, i in layout.masks.items()}
    return [f"    {symbol} = {numbers[symbol]}" for symbol in used(program, numbers)]


def _phase_loads(layout: Layout, program: Program) -> list[Symbol]:
    """Parameters that only the rates of the used angles read."""
    angles = [a for a in layout.system.angles if used(program, (a.sin, a.cos))]
    return sorted(set().union(*(a.rate.free_symbols for a in angles)) if angles else (), key=str)


def lanes(name: str, layout: Layout, program: Program, stores: dict[str, int]) -> str:
    """A function over eight increments: `stores` maps result names to rows of w."""
    body, head = [], _loads(layout, program + [(TIME, s) for s in _phase_loads(layout, program)])
    state_row = layout.rows["state"]
    for symbol in used(program, (TIME, *layout.state)):
        head.append(f"    base_{symbol} = s[{layout.base[symbol]}]")
        row = layout.rows["time"] if symbol == TIME else state_row + layout.state.index(symbol)
        body.append(f"        {symbol} = base_{symbol} + w[{8 * row} + i]")
    for angle in layout.system.angles:
        if used(program, (angle.sin, angle.cos)):
            head += [f"    base_{x} = s[{layout.base[x]}]" for x in (angle.sin, angle.cos)]
            body += _rotation(angle, layout)
    body += statements(program, "        ")
    body += [f"        w[{8 * row} + i] = {result}" for result, row in stores.items()]
    loop = [f"    for i in range({LANES}):", *body] if body else ["    pass"]
    return "\n".join([f"def {name}(w, s, p, m):", *head, *loop]) + "\n"


def _rotation(angle, layout: Layout) -> list[str]:
    """Sine and cosine of base + increment, the increment's own by Taylor polynomials."""
    parts = [f"{expression(angle.rate)} * w[{8 * layout.rows['time']} + i]"] if angle.rate != 0 else []
    if angle.position is not None:
        parts.append(f"w[{8 * (layout.rows['state'] + layout.state.index(angle.position))} + i]")
    s, c = angle.sin, angle.cos
    return [
        f"        d = {' + '.join(parts)}",
        "        dd = d * d",
        f"        ds = d * ({horner(SIN)})",
        f"        dc = {horner(COS)}",
        f"        {s} = base_{s} * dc + base_{c} * ds",
        f"        {c} = base_{c} * dc - base_{s} * ds",
    ]


def horner(coefficients: list[float]) -> str:
    """A polynomial in dd, lowest coefficient first."""
    text = repr(coefficients[-1])
    for value in reversed(coefficients[:-1]):
        text = f"{value!r} + dd * ({text})"
    return text


def point(
    name: str, layout: Layout, program: Program, stores: dict[str, int], arguments: str, out: str
) -> str:
    """A function at the base point: `stores` maps result names to places in the array `out`."""
    head = _loads(layout, program)
    head += [f"    {symbol} = s[{layout.base[symbol]}]" for symbol in used(program, layout.base)]
    body = statements(program, "    ")
    body += [f"    {out}[{place}] = {result}" for result, place in stores.items()]
    return "\n".join([f"def {name}({arguments}):", *head, *(body or ["    pass"])]) + "\n"
