"""Somebody's own equations as text: the grammar, what it refuses, and the equations that it makes."""

from __future__ import annotations

import math
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import Symbol, symbols

from jointplay.display.errors import InputError
from jointplay.solver.equations.own import own
from jointplay.solver.equations.own.grammar import ACCEPTED, number, parse
from jointplay.solver.equations.own.written import Oscillator, Touch, Wall
from jointplay.solver.equations.system import Angle, Reset, System
from jointplay.solver.equations.system import number as numbered
from jointplay.solver.mechanism.own.own_parts import written
from tests.support.plain import Point, plain
from tests.support.plain import module as generated

NAMES = {"x": 0.7, "y": -1.3, "long_name": 2.5}


@pytest.mark.parametrize(
    "text",
    [
        *("-x**2", "2**-x", "2**3**2", "-2**-2", "1 - 2 - 3", "8/4/2", "2*x/3*y", "x - -y", "+x", "--x"),
        *("(x + y)*(x - y)", "1.5e-3*x + .5", "long_name**0.5", "2e3", "x*(y)", "abs(y)", "max(x, y, 0.1)"),
        *("min(x, y)", "sqrt(x)*exp(-x)", "log(long_name)", "tanh(y)", "sin(x)**2 + cos(x)**2", "tan(x)"),
    ],
)
def test_values_are_those_of_python(text):
    functions = {name: getattr(math, name) for name in ["sin", "cos", "tan", "sqrt", "exp", "log", "tanh"]}
    assert number(text, NAMES) == eval(text, {**functions, **NAMES})


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a b", "column 3"),
        ("x^2", r"a power is \*\*"),
        ("(1 + x", r"\) is needed at column 7"),
        ("sin x", "column 5"),
        ("max(x)", "2 to 9 arguments"),
        ("x if y else 0", "column 3"),
        ("x == y", "column 3"),
        ("__import__('os')", "column 1"),
        ("x.real", "column 2"),
        ("ω*t", "letters of names are a to z"),
        ("1e999", "a float can hold"),
        ("(" * 200 + "1" + ")" * 200, "50 deep"),
        ("1" + "+1" * 999, "at most 250 operations one upon the other"),
        ("x" * 3000, "2000 characters"),
        ("", "the end"),
    ],
)
def test_what_is_no_expression_is_refused_with_its_place(text, said):
    with pytest.raises(InputError, match=said):
        parse(text)


@pytest.mark.parametrize(
    "text", ["1/0", "9**9**9**9", "log(0)", "sqrt(-1)", "(-1)**0.5", "log((-2)**0.5)", "exp(1e9)"]
)
def test_without_a_finite_value(text):
    with pytest.raises(InputError, match="finite"):
        number(text, {})


@pytest.mark.nightly
@given(st.text(alphabet="x1.e+-*/(), sincotaxm^_=[]'ω\n", max_size=40) | st.text(max_size=40))
def test_any_text_is_an_expression_or_is_refused(text):
    try:
        tree = parse(text)
    except InputError:
        return
    with suppress(InputError):
        number(text, dict.fromkeys(tree.names, 1.5))
    writer = own._Writer(Oscillator((), ("x",), tuple(sorted(tree.names - {"x", "t"})), ("x",)))
    with suppress(InputError):  # what has no finite real value, such as 0/0
        writer.moving(text)


def test_expressions_of_sympy_are_text_to_the_last_bit():
    x, y = symbols("x y")
    assert written(0.1 + x**2 / 3 - abs(y)) == "0.1 - abs(y) + x**2/3"
    assert number(written(x / 3 + 0.1234567890123456789), {"x": 1.0}) == 1 / 3 + 0.1234567890123456789
    assert written(0.1) == "0.1"
    with pytest.raises(InputError, match=ACCEPTED.replace("*", "\\*").replace("+", "\\+")):
        parse(written(Symbol("x") > 1))


PAIR = Oscillator(
    ("y",),
    ("v",),
    ("gap", "restitution"),
    ("sin(t)",),
    period="2*pi",
    impacts=(
        Wall("upper", "gap/2 - y", jump=(("v", "-restitution*v"),)),
        Wall("lower", "gap/2 + y", jump=(("v", "-restitution*v"),)),
    ),
)


def test_own_equations_cost_nothing():
    """The impact pair as text gives the very code of one that is written with symbols."""
    y, v = symbols("y v", real=True)
    d, r, phase = numbered("gap"), numbered("restitution"), Angle("phase", None, 1 + 0 * y)
    walls = tuple(Reset(name, d / 2 - side * y, {v: -r * v}) for name, side in (("upper", 1), ("lower", -1)))
    outputs = {"state:y": y, "state:v": v, "phase": phase.value}
    outputs |= {f"gap:{reset.name}": reset.guard for reset in walls}
    by_hand = System((y,), (v,), (d, r), (), None, (phase.sin,), (phase,), resets=walls, outputs=outputs)
    assert generated.text(own.system(PAIR)) == generated.text(by_hand)


def test_names_that_generated_code_has_for_itself():
    """Every such name as a state or parameter gives what plain names give."""
    taken = [
        "w",
        "s",
        "p",
        "m",
        "i",
        "d",
        "lambda",
        "sin_",
        "k0",
        "a_0",
        "touch_wall",
        "out",
        "J",
        "own_p",
        "max_1",
    ]
    for name in taken:
        other, plainly = (
            Oscillator(
                ("q",),
                ("z",),
                (each,),
                (f"-{each}*q + cos(z)",),
                contacts=(Touch("wall", "q - 1", "9*depth"),),
            )
            for each in (name, "stiff")
        )
        rates = [Point(plain(each), [2.5], (1.5, 0.3), ("contact",)).rate() for each in (other, plainly)]
        assert (rates[0] == rates[1]).all()
        assert rates[0][0, 0] == pytest.approx(-2.5 * 1.5 + math.cos(0.3) - 9 * 0.5)


@pytest.mark.parametrize("state", [(0.7, 2.0), (-0.7, 2.0)])
def test_kinks_are_switches(state):
    """|x|, sign, max and min of a state: one switch each, whose mode is the sign; slopes with it."""
    given = Oscillator((), ("x", "y"), ("a",), ("abs(x - a)*y + sign(x - a)", "max(x, a) - min(a, x)*y"))
    modes = tuple("contact" if state[0] > 0.1 else "free" for _ in range(3))
    f = plain(given)
    assert list(f.CONTACTS) == ["fold"]
    point = Point(f, [0.1], state, modes[:1])
    x, y = state
    expected = abs(x - 0.1) * y + math.copysign(1, x - 0.1), max(x, 0.1) - min(0.1, x) * y
    assert point.rate()[:, 0] == pytest.approx(expected)
    side = math.copysign(1, x - 0.1)
    slopes = [[side * y, abs(x - 0.1)], [(1 if side > 0 else 0) - (0 if side > 0 else 1) * y, -min(0.1, x)]]
    assert point.jacobian() == pytest.approx(np.array(slopes))


def test_a_lone_contact_is_open_while_a_body_rests_on_a_wall():
    """The variant in which something touches is that of the wall too: the contact's mode still counts."""
    stop, floor = Touch("stop", "q - 1", "50*depth"), Wall("floor", "q", restitution="0.5")
    f = plain(Oscillator(("q",), ("v",), (), ("-1",), contacts=(stop,), impacts=(floor,)))
    for stop_mode, wall_mode, rate in (
        ("free", "free", -1.0),
        ("contact", "free", 39.0),
        ("free", "stick", 0.0),
    ):
        point = Point(f, [], (0.2, 0.0), (stop_mode, wall_mode))
        point.variant, point.m[5] = 1, 0.0
        point.m[3] = float(wall_mode == "stick")
        assert point.rate()[0, 0] == pytest.approx(rate, abs=1e-14)


def test_a_quantity_that_is_not_there():
    with pytest.raises(InputError, match=r"section\.quantity"):
        own.system(Oscillator((), ("x",), (), ("-x",), section="z"))
