"""Equations of a system that is given as text (equations.own.written), in the form of `equations.system`.

With the states x, of which the first are positions q' = z, and M = 1 where no mass matrix is given,

    M x' = f(x, t) + contacts + friction.

The force F of a contact acts as its depth says, -F d depth/d q, and friction likewise against its sliding
speed. Switches are contacts without a force, whose mode, 0 or 1, is a number in the equations. So are |g|,
the sign of g, and the larger and the smaller of two, of an argument g that moves: each of their kinks is an
event, located, with its saltation. In what is evaluated at events alone (jumps, restitution) the sign of g is
taken there and then. Powers of what a kink keeps from falling below 0 are continued there, where rounding may
lead, as in the laws of contact. A switch that slides is friction.

A sine or cosine of a phase (a rate times t, and an offset) is turned from step to step; of any other argument
it is a function as all others are.

A switch that slides: Filippov's motion along its guard, where both modes push towards it.

With rates f = f_0 + s f_1 that are straight in the switch s, which is 1 where its guard h > 0, a convex share
s = (1 + F)/2 of both modes keeps h' = 0:

    f = f_0 + f_1/2 - w F,   w = -f_1/2,   grad h . f = 0,   |F| <= 1.

So it is friction of coefficient 1 in the "speed" h, with F = 1 above and -1 below, but for its direction w,
which is not that of the guard's gradient; it begins and ends as sticking does (method.modes). Of several
that slide at one time each keeps its own guard (Utkin's equivalent control). Reference: Filippov (1988), see
method.modes.
"""

from __future__ import annotations

import keyword
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from sympy import (
    Abs,
    E,
    Expr,
    Float,
    I,
    Integer,
    Rational,
    Symbol,
    cos,
    exp,
    log,
    nan,
    oo,
    pi,
    preorder_traversal,
    sin,
    sqrt,
    zoo,
)
from sympy.printing.str import StrPrinter

from ....display.errors import InputError, Problem, refuse, unknown
from ..cylinders import ROUND
from ..functions import TINY, side, tanh
from ..system import TIME, Angle, Contact, Reset, System, traction
from .grammar import constants_finite, parse
from .written import Jump, Oscillator, Rubbing, Switch, Touch, Wall

# Names that generated code has for itself: what is called so is called otherwise there.
_LETTERS = {*"wspmidJktNSEI", "out", "dd", "ds", "dc", "rate", "jacobian", "contacts", "trig", "reset", "own"}
_WORDS = {"cos", "sin", "sqrt", "tanh", "exp", "log", "copysign", "max", "min", "abs", "range", "lambert"}

_WORDS |= {"compiled", "entry", "math", "numba"}


_FORMED = re.compile(
    r"([A-Za-z]{1,2}|own|out|base|rate|touch|slip|stick|ease|hat|new|sol|gradient|reset)_.*|.*\d_*"
)


_ONE, _NONE, _HALF = Integer(1), Integer(0), Rational(1, 2)


LARGEST = 1e150  # its square is a number still

_NOWHERE = {zoo, nan, oo, -oo, I}


_UNREAL = "an expression with finite real values is accepted: this one has none, whatever its names stand for"


def system(structure: Oscillator) -> System:
    """Write the equations of such a structure, and the quantity that is watched.

    Raises
    ------
    InputError
        If it has no such quantity.
    """
    plain = _Writer(structure).system()
    if structure.section is None:
        return plain
    states = {name.removeprefix("state:"): name for name in plain.outputs}
    if structure.section not in states:
        raise InputError(
            [unknown("section.quantity", structure.section, structure.section, states, "quantity")]
        )
    return replace(plain, section=plain.outputs[states[structure.section]])


def symbol(name: str) -> Symbol:
    """The symbol of a name that somebody has chosen."""
    taken = name in _LETTERS | _WORDS or keyword.iskeyword(name) or _FORMED.fullmatch(name)
    return Symbol(f"own_{name}" if taken else name, real=True)


class _Printer(StrPrinter):
    """SymPy's expressions in the words of the grammar."""

    def _print_Float(self, expr):
        return repr(float(expr))

    def _print_Abs(self, expr):
        return f"abs({self._print(expr.args[0])})"

    def _print_Max(self, expr):
        return f"max({', '.join(map(self._print, expr.args))})"

    def _print_Min(self, expr):
        return f"min({', '.join(map(self._print, expr.args))})"

    def _print_Exp1(self, _expr):
        return "exp(1)"


def as_text(expr: Expr) -> str:
    """An expression of SymPy as text of the grammar; anything else is refused where the text is read."""
    return _Printer({"order": "none"}).doprint(expr)


class _Writer:
    """Makes SymPy's expressions of a structure's text; angles and switches are found on the way."""

    def __init__(self, structure: Oscillator) -> None:
        self.structure, self.angles, self.switches = structure, [], {}
        self.q, self.z = (tuple(map(symbol, names)) for names in (structure.positions, structure.speeds))
        self.parameters = tuple(map(symbol, structure.parameters))
        given = (*structure.positions, *structure.speeds, *structure.parameters)
        self.names = dict(zip(given, self.q + self.z + self.parameters, strict=True)) | {"t": TIME}
        if structure.period:
            period = at_rest(structure.period, self.names)
            self.angles.append(Angle("phase", None, (2 * pi / period).xreplace(NUMBERS)))
        self.names |= {each.name: _mode(each.name) for each in structure.switches}
        self.names |= {each.name: sliding_share(each) for each in structure.switches if each.slides}
        for each in structure.switches:
            if not each.slides:
                self.switches[each.name] = self.moving(each.on)

    def system(self) -> System:
        """All of the equations."""
        given = self.structure
        force = tuple(map(self.moving, given.rates))
        contacts = [self._touch(each) for each in given.contacts]
        contacts += [self._rubbing(each) for each in given.friction]
        for i, each in enumerate(given.switches):
            if each.slides:
                guard = self.moving(each.on)
                row = tuple(guard.diff(z) for z in self.z)
                contacts.append(sliding(given, i, guard, row, force))
        resets = [self._wall(each) for each in given.impacts]
        resets += [
            Reset(
                each.name,
                self.moving(each.guard),
                self._jump(each.jump),
                moves=True,
                met=self.at_once(each.guard),
            )
            for each in given.jumps
        ]
        own = (*given.positions, *given.speeds)
        outputs = {f"state:{name}": self.names[name] for name in own}
        outputs |= {f"state:{name}": self.moving(text) for name, text in given.outputs}
        mass = {(i, j): self.moving(text) for i, j, text in given.mass} or None
        contacts += [self._watched(name, force) for name in self.switches]
        guards = [*(each.u for each in contacts), *(reset.guard for reset in resets)]
        outputs |= {angle.name: angle.value for angle in self.angles}
        outputs |= {f"gap:{reset.name}": reset.gap for reset in resets}
        return System(
            positions=self.q,
            speeds=self.z,
            parameters=self.parameters,
            definitions=(),
            mass=mass,
            force=tuple(middle(rate, given.switches) for rate in force),
            angles=tuple(self.angles),
            contacts=tuple(contacts),
            resets=tuple(resets),
            outputs=outputs,
            bends=not all(guard.is_polynomial(*self.q, *self.z) for guard in guards),
        )

    def moving(self, text: str, **more: Expr) -> Expr:
        """An expression that holds along a motion; `more` are further names."""
        return self._made(text, more, self._located)

    def at_once(self, text: str, **more: Expr) -> Expr:
        """An expression that holds at one instant."""
        return self._made(text, more, side)

    def _made(self, text: str, more: Mapping[str, Expr], sign: Callable, **own: Callable) -> Expr:
        functions = {
            "sin": self._sin,
            "cos": self._cos,
            "tan": lambda x: self._sin(x) / self._cos(x),
        } | (_kinked(sign) | {"sign": lambda x: _signum(x, sign)} | own)
        return real(text, self.names | more, functions, sign).xreplace(NUMBERS)

    def _located(self, argument: Expr) -> Expr:
        """The sign of an argument; of one that moves, by a switch where it passes zero."""
        argument = argument.xreplace(NUMBERS)
        if not argument.free_symbols & {TIME, *self.q, *self.z, *self._waves}:
            return side(argument)
        for name, on in self.switches.items():
            if argument in (on, -on):
                return (2 * _mode(name) - 1) * (1 if argument == on else -1)
        name = "fold" if "fold" not in self.names else f"fold{len(self.switches)}"
        self.switches[name], self.names[name] = argument, _mode(name)
        return 2 * _mode(name) - 1

    @property
    def _waves(self) -> set[Symbol]:
        return {each for angle in self.angles for each in (angle.sin, angle.cos)}

    def _sin(self, argument: Expr) -> Expr:
        angle = self._phase(argument)
        return angle.sin if angle else sin(argument)

    def _cos(self, argument: Expr) -> Expr:
        angle = self._phase(argument)
        return angle.cos if angle else cos(argument)

    def _phase(self, argument: Expr) -> Angle | None:
        """The angle whose value an argument is, if that grows with time alone, and evenly."""
        argument = argument.xreplace(NUMBERS)
        rate, offset = argument.diff(TIME), argument.xreplace({TIME: _NONE})
        moving = {TIME, *self.q, *self.z, *self._waves, *map(_mode, self.switches)}
        if rate == 0 or (rate.free_symbols | offset.free_symbols) & moving:
            return None
        for angle in self.angles:
            if (angle.rate, angle.offset) == (rate, offset):
                return angle
        self.angles.append(Angle(f"phase{len(self.angles)}", None, rate, offset))
        return self.angles[-1]

    def _watched(self, name: str, force: tuple[Expr, ...]) -> Contact:
        """The contact without a force that a switch is."""
        on = self.switches[name]
        rate = self._rate(on) + sum((on.diff(z) * f for z, f in zip(self.z, force, strict=True)), _NONE)
        return Contact(name, on, rate, _ONE, (_NONE,) * len(self.z))

    def _touch(self, given: Touch) -> Contact:
        u = self.moving(given.depth)
        v_n, row = self._rate(u), self._row(u)
        powers = {"**": partial(_onward, u), "sqrt": lambda base: _onward(u, base, _HALF)}

        def sign(argument: Expr) -> Expr:
            """Of a depth it is known while contact lasts."""
            return {u: _ONE, -u: -_ONE}.get(argument) or self._located(argument)

        force = self._made(given.force, {"depth": u, "speed": v_n}, sign, **powers)
        return Contact(given.name, u, v_n, force, row, given.pulls)

    def _rubbing(self, given: Rubbing) -> Contact:
        v_t = self.moving(given.speed)
        row = tuple(v_t.diff(z) for z in self.z)
        slip = self.moving(given.coefficient, speed=v_t)
        limit = self.moving(given.static) if given.static else slip
        still = (_NONE,) * len(self.z)
        normal = self.moving(given.normal)
        return Contact(
            given.name, _ONE, _NONE, normal, still, v_t=v_t, tangential=row, coulomb=slip, limit=limit
        )

    def _wall(self, given: Wall) -> Reset:
        gap, met = self.moving(given.gap), self.at_once(given.gap)
        if not given.jump:
            return Reset(given.name, gap, restitution=self.at_once(given.restitution), met=met)
        return Reset(given.name, gap, self._jump(given.jump), met=met)

    def _jump(self, given: Jump) -> dict[Symbol, Expr]:
        return {self.names[name]: self.at_once(text) for name, text in given}

    def _row(self, value: Expr) -> tuple[Expr, ...]:
        """Slopes by the positions, one a speed."""
        return tuple(value.diff(q) for q in self.q) + (_NONE,) * (len(self.z) - len(self.q))

    def _rate(self, value: Expr) -> Expr:
        """The value's rate by positions and time alone."""
        total = value.diff(TIME) + sum(
            (value.diff(q) * z for q, z in zip(self.q, self.z, strict=False)), _NONE
        )
        for angle in self.angles:
            total += (value.diff(angle.sin) * angle.cos - value.diff(angle.cos) * angle.sin) * angle.rate
        return total


def _mode(name: str) -> Symbol:
    """The mode of a switch as a number, which is the solved force of its contact."""
    return traction(Contact(name, _ONE, _NONE, _ONE, ()))[0]


def smooth(text: str, names: Mapping[str, Expr], more: dict[str, Callable] | None = None) -> Expr:
    """An expression without kinks of these names, and of more functions where given; pi stays exact.

    Raises
    ------
    InputError
        Where it has a kink after all, as the root of a square, or no finite real value anywhere.
    """

    return real(text, names, _SMOOTH | (more or {}), _no_kink(text))


def _no_kink(text: str) -> Callable[[Expr], Expr]:
    def refused(_: Expr) -> Expr:
        raise refuse(text, "an expression without kinks is accepted, and the root of a square has one")

    return refused


def real(
    text: str, names: Mapping[str, Expr], functions: Mapping[str, Callable], sign: Callable[[Expr], Expr]
) -> Expr:
    """The expression that a text makes, if it has finite real values, with |x| as sign(x) x.

    Raises
    ------
    InputError
        Where it has none, whatever the numbers: a division by 0, the root of what is below 0, overflow.
    """
    if not constants_finite(text):  # first: SymPy would look for the sine of a number without end
        raise refuse(text, _UNREAL)
    made = parse(text).made_of(names, functions, _numeral)
    for part in preorder_traversal(made):
        if part in _NOWHERE or (part.is_Number and not math.isfinite(_float(part))):
            raise refuse(text, _UNREAL)
        if part.is_Number and abs(_float(part)) > LARGEST:
            raise refuse(text, f"numbers up to {LARGEST:g} in size are accepted")
        base, exponent = part.as_base_exp() if part.is_Pow else (None, None)
        of_negative = part.args[0] if isinstance(part, log) else base if exponent is not None else None
        if of_negative is not None and of_negative.is_negative and not (exponent and exponent.is_integer):
            raise refuse(text, _UNREAL)
        if exponent is not None and base.is_zero and not exponent.is_positive:
            raise refuse(text, _UNREAL)
    return _without_abs(made, sign)


def _without_abs(value: Expr, sign: Callable[[Expr], Expr]) -> Expr:
    return value.replace(lambda part: isinstance(part, Abs), lambda part: sign(part.args[0]) * part.args[0])


def _float(value: Expr) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _numeral(value: float) -> Expr:
    if value == math.pi:
        return pi
    return Integer(value) if isinstance(value, int) else Float(value)


def _power(base: Expr, exponent: Expr) -> Expr:
    if base.is_Number and exponent.is_Number and not (abs(exponent) <= 64 and abs(base) <= 1e4):
        try:
            power = float(base) ** float(exponent)  # exact powers of large numbers would never end
        except (OverflowError, ZeroDivisionError):
            return zoo
        return zoo if isinstance(power, complex) else Float(power)
    return base**exponent


def _onward(u: Expr, base: Expr, exponent: Expr) -> Expr:
    """A power; of a depth, which rounding may put below 0, continued as in the laws of contact."""
    if base in (u, Abs(u)) and not exponent.is_integer:
        return _continued(u, exponent)
    return _power(base, exponent)


def _continued(base: Expr, exponent: Expr) -> Expr:
    """A broken power of what is not below 0 but by rounding."""
    return base * (base**2 + ROUND**2) ** ((exponent - 1) / 2)


def at_rest(text: str, names: Mapping[str, Expr], kinks: bool = True) -> Expr:
    """An expression of these names in which nothing moves: its kinks are no events.

    Raises
    ------
    InputError
        As `real`.
    """
    fold = side if kinks else _no_kink(text)
    own = {"sin": sin, "cos": cos, "tan": lambda x: sin(x) / cos(x)} | _kinked(fold)
    return real(text, names, own | ({"sign": _signum} if kinks else {}), fold)


def checked(text: str, kinks: bool = True) -> None:
    """Refuse an expression that has finite real values nowhere, or kinks where there may be none.

    Raises
    ------
    InputError
        As `real`.
    """
    names = {name: symbol(name) for name in parse(text).names}
    at_rest(text, names, kinks)


def _signum(argument: Expr, sign: Callable[[Expr], Expr] = side) -> Expr:
    """The sign of an argument, 0 at 0 but where a switch tells it."""
    found = sign(argument)
    return argument / (found * argument + TINY) if found.has(side) else found


def _kinked(sign: Callable[[Expr], Expr]) -> dict[str, Callable]:
    """Functions of the grammar but for sine and cosine, their kinks by a sign."""

    def power(base: Expr, exponent: Expr) -> Expr:
        folded = base.has(side) or any(each.name.startswith("Fn_") for each in base.free_symbols)
        kept = folded and not (exponent.is_integer or exponent.is_negative)
        return _without_abs(_continued(base, exponent) if kept else _power(base, exponent), sign)

    return _SMOOTH | {
        "**": power,
        "sqrt": lambda base: power(base, _HALF),
        "sign": sign,
        "abs": lambda x: sign(x) * x,
        "max": lambda *parts: _compared(parts, sign),
        "min": lambda *parts: _compared(parts, lambda difference: -sign(difference)),
    }


def _compared(parts: tuple[Expr, ...], sign: Callable[[Expr], Expr]) -> Expr:
    """The part whose difference to any other has this sign, halves compared first, so that it stays short."""
    if len(parts) == 1:
        return parts[0]
    half = (len(parts) + 1) // 2
    a, b = _compared(parts[:half], sign), _compared(parts[half:], sign)
    share = (1 + sign(a - b)) / 2
    return share * a + (1 - share) * b


_SMOOTH = {"exp": exp, "log": log, "sqrt": sqrt, "tanh": tanh, "**": _power}


NUMBERS = {pi: Float(math.pi), E: Float(math.e)}


def held(given: Switch) -> Symbol:
    """F of a switch."""
    return traction(Contact(given.name, _ONE, _NONE, _ONE, ()))[1]


def sliding_share(given: Switch) -> Expr:
    """The switch as a number in the equations."""
    return (1 + held(given)) / 2


def middle(rate: Expr, switches: tuple[Switch, ...]) -> Expr:
    """A rate where every F is 0."""
    return rate.xreplace(dict.fromkeys(map(held, switches), _NONE))


def sliding(
    structure: Oscillator, i: int, guard: Expr, row: tuple[Expr, ...], rates: tuple[Expr, ...]
) -> Contact:
    """The i-th switch of a structure, by its guard, the guard's slopes, and the rates of all but positions.

    Raises
    ------
    InputError
        If rates are not straight in what slides, or the switch does not change its guard's rate.
    """
    given, forces = structure.switches[i], set(map(held, structure.switches))
    along = tuple(-rate.diff(held(given)) for rate in rates)
    straight = f"a rate that is straight in all that slides is accepted, as in {given.name}"
    problems = [
        Problem(f"rates.{name}", text, straight)
        for name, text, entry in zip(structure.speeds, structure.rates, along, strict=True)
        if entry.free_symbols & forces
    ]
    if not structure.mass and sum(a * b for a, b in zip(row, along, strict=True)) == 0:
        accepted = "a guard whose own rate the switch changes is accepted: else nothing could keep it at 0"
        problems.append(Problem(f"switches[{i}].on", given.on, accepted))
    if problems:
        raise InputError(problems)
    still = (_NONE,) * len(along)
    friction = {"v_t": guard, "tangential": row, "coulomb": _ONE, "limit": _ONE, "acts_along": along}
    return Contact(given.name, _ONE, _NONE, _ONE, still, **friction)
