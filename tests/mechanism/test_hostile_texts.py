"""Hostile texts as own equations: refused when the system is made, or written down in bounded work.

Work is counted, in calls of functions, and the written module's length; what it calls is known to it.
"""

import ast
import builtins
import random
import sys

import pytest

from jointplay.display.errors import InputError
from jointplay.solver.codegen import module
from jointplay.solver.equations.own.grammar import LARGEST, parse, size, too_large
from jointplay.solver.equations.own.own import system as equations
from jointplay.solver.mechanism.records import Servo, System

CALLS, LENGTH = 6_000_000, 400_000  # each several times the most that any text below takes
PLACES = (
    "rate",
    "output",
    "guard",
    "gap",
    "depth",
    "force",
    "jump",
    "coefficient",
    "state",
    "mass",
    "forcing",
)
NAMES, NUMBERS = (
    ("x", "v", "y", "a", "b", "t"),
    ("0", "1", "-1", "2", "0.5", "1e300", "1e-300", "64", "9999", "pi"),
)
ONE, TWO = ("sin", "cos", "tan", "sqrt", "exp", "log", "tanh", "abs", "sign", "-"), ("+", "-", "*", "/", "**")


def product(count):
    return "*".join(f"(x + {i})" for i in range(1, count))


def nested(name, count):
    return f"{name}(" * count + "x" + ")" * count


UNREAL = [  # no finite real value, whatever the names stand for
    *(
        "x/0",
        "0/0",
        "x/(y - y)",
        "1/(x - x)",
        "(x - x)/(x - x)",
        "x**(1/0)",
        "1/sqrt(0)",
        "1/sin(0)",
        "tan(pi/2)",
    ),
    *("sqrt(-1)*x", "(-1)**0.5*x", "(-8)**(1/3)", "sqrt(-x**2 - 1)", "(-x**2)**0.5", "(0 - 1)**x", "(-2)**x"),
    *("log(0)*x", "log(-1)*x", "log(log(log(2)))*x", "log(-x**2 - 1)", "0**-1", "0**-x**2", "sqrt(-x**2)"),
    *("9**9**9**9", "9**9**9**9*x", "pi**pi**pi**pi*x", "exp(1000)*x", "exp(exp(exp(100)))*x", "1e308*10*x"),
    *("1e200**2*x", "2**99999*x", "exp(9**9)*x", "1e200*x*1e200"),
    *("1e300*x", "exp(max(1 - x, pi*1e300))"),  # their squares are none
]
SOUND = [  # valid, though not as they stand
    *(
        "sqrt(x**2)",
        "(x**2)**0.5",
        "sqrt((x - 1)**2)",
        "sqrt(x**4 + 2*x**2 + 1)",
        "sqrt(sqrt(x**4))",
        "(x**6)**(1/6)",
    ),
    *(
        "abs(abs(abs(x)))",
        "sign(sign(x))",
        "log(exp(x))",
        "exp(log(x))",
        "sqrt(x)**2",
        "sqrt(x**2*v**2)",
        "log(x**2)",
    ),
    *(
        "max(x, v, y, a, b, 1, 2, x*v, x*y)",
        "max(max(x, v), max(y, a))",
        "min(x, x)",
        "max(1, 2)*x",
        "2**-900*x",
    ),
    *(
        "abs(x + abs(v + abs(y + abs(x*v))))",
        "x**9999",
        "x**-99",
        "x**x**x**x",
        "(x + v)**64",
        "abs(x)**abs(v)",
    ),
    *(
        product(12),
        nested("sin", 12),
        nested("tanh", 12),
        "+".join(["x"] * 240),
        "+".join(f"abs(x - {i})" for i in range(40)),
    ),
    "cos(tanh((a - y)/(min(-1, b, x, a) - a*b)))",
]
ENDLESS = [
    *(product(200), "*".join(["(x + max(x, v, y, a, b, 1, 2, 3, 4))"] * 40)),
    *("+".join(f"abs(x - {i})" for i in range(60)), "max(" * 30 + "x" + ", v)" * 30, "+".join(["x"] * 400)),
    *("(" * 60 + "x" + ")" * 60, "-" * 60 + "x", "x**" * 60 + "x", "max(x)", "x" * 3000, "+x" * 999),
]


def grown(dice, depth):
    """A random expression."""
    if depth == 0 or dice.random() < 0.1:
        return dice.choice(NAMES if dice.random() < 0.6 else NUMBERS)
    kind = dice.random()
    if kind < 0.4:
        return f"({grown(dice, depth - 1)}){dice.choice(TWO)}({grown(dice, depth - 1)})"
    if kind < 0.85:
        return f"{dice.choice(ONE)}({grown(dice, depth - 1)})"
    parts = ", ".join(grown(dice, depth - 1) for _ in range(dice.randint(2, 9)))
    return f"{dice.choice(('max', 'min'))}({parts})"


def system(text, place):
    """A system with the text somewhere."""
    given = {
        "states": {"x": "0.7", "v": "0.3", "y": "0.2"},
        "parameters": {"a": 2.0, "b": 0.5},
        "rates": {"x": "v", "v": "-x", "y": "-y + 0*sin(t)"},
        "forcing": "2*pi",
    }
    contact = {"name": "c", "depth": "x - 1", "force": "depth"}
    rubbing = {"name": "r", "speed": "v", "normal": "1", "coefficient": "0.2"}
    given |= {
        "rate": {"rates": given["rates"] | {"v": text}},
        "output": {"outputs": {"o": text}},
        "guard": {"switches": [{"name": "s", "on": text}], "rates": given["rates"] | {"v": "-x + s"}},
        "gap": {"impacts": [{"name": "w", "gap": text, "restitution": "0.5"}]},
        "depth": {"contacts": [contact | {"depth": text}]},
        "force": {"contacts": [contact | {"force": text}]},
        "jump": {"jumps": [{"name": "j", "guard": "5 - x", "jump": {"v": text}}]},
        "coefficient": {"friction": [rubbing | {"coefficient": text}]},
        "state": {"states": given["states"] | {"y": text}},
        "mass": {"mass": {"v": {"v": text}}},
        "forcing": {"forcing": text},
    }[place]
    return System(**given)


def counted(call):
    """What a call gives, and the number of functions that it called."""
    calls = 0

    def count(_frame, event, _argument):
        nonlocal calls
        calls += event in ("call", "c_call")

    sys.setprofile(count)
    try:
        return call(), calls
    finally:
        sys.setprofile(None)


def unknown_names(source):
    """Names that a module loads, and neither it nor Python defines."""
    nodes = list(ast.walk(ast.parse(source)))
    known = {each.id for each in nodes if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
    known |= {each.arg for each in nodes if isinstance(each, ast.arg)} | {*dir(builtins)}
    known |= {each.name for each in nodes if isinstance(each, ast.FunctionDef)}
    known |= {a.asname or a.name for each in nodes if isinstance(each, ast.ImportFrom) for a in each.names}
    return {each.id for each in nodes if isinstance(each, ast.Name)} - known


def written(text, place):
    """The module of a system with the text, or its problems where it is refused."""
    try:
        return module.text(equations(system(text, place).structure()))
    except InputError as error:
        return error.problems


def fares(text, place, count=lambda call: (call(), 0)):
    """Whether a text is accepted, after checking what is made of it."""
    source, calls = count(lambda: written(text, place))
    assert calls < CALLS, (text, calls)
    if not isinstance(source, str):
        assert all(problem.key and problem.expected for problem in source)
        return False
    assert unknown_names(source) == set(), text
    assert len(source) < LENGTH, (text, len(source))
    return True


@pytest.mark.parametrize("text", UNREAL)
def test_what_has_no_finite_real_form_is_refused(text):
    assert not any(fares(text, place) for place in PLACES)


@pytest.mark.parametrize("text", SOUND)
def test_what_is_sound_is_written(text):
    assert fares(text, "rate", counted)
    assert fares(text, "output")


@pytest.mark.parametrize("text", ENDLESS)
def test_what_would_be_endless_is_refused(text):
    assert not any(fares(text, place, counted) for place in PLACES)


@pytest.mark.parametrize("text", [product(40), nested("sin", 30)])
def test_what_has_many_slopes_is_refused_as_a_guard_alone(text):
    assert fares(text, "rate")
    assert not any(fares(text, place, counted) for place in ("gap", "depth", "guard"))


@pytest.mark.parametrize(
    "text",
    [
        "abs(log((tan(a)*x)**(abs(x)**v)))",  # a power of a negative number, within another function
        "tan(max(sqrt(tan(v)), log(b)**log(y)))",
        "sign(sin(min(exp(sin(-1)), tan(exp(1e300))))/abs(min(x, t) - abs(y)))",  # the tangent of no number
    ],
)
def test_what_is_real_in_places_alone_is_refused_or_written(text):
    for place in PLACES:
        fares(text, place)


@pytest.mark.parametrize("seed", range(8))
def test_random_texts_are_refused_or_written(seed):
    dice = random.Random(seed)
    for _ in range(12):
        fares(grown(dice, dice.randint(1, 5)), dice.choice(PLACES))


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(100, 200))
def test_many_random_texts_are_refused_or_written(seed):
    dice = random.Random(seed)
    for _ in range(30):
        fares(grown(dice, dice.randint(1, 6)), dice.choice(PLACES))


@pytest.mark.parametrize("seed", range(2))
def test_the_size_that_is_reckoned_with_bounds_that_of_slopes(seed):
    from sympy import Symbol

    from jointplay.solver.equations.own.own import smooth

    dice, names = random.Random(seed), {name: Symbol(name, real=True) for name in NAMES}
    for _ in range(6):
        text = " + ".join(
            f"{product(dice.randint(2, 9))}*{nested('exp', dice.randint(1, 5))}" for _ in range(2)
        )
        made = smooth(text, names)
        slope = made.diff(names["x"])
        assert slope.count_ops() <= 4 * size(text).slope
        assert slope.diff(names["x"]).count_ops() <= 4 * size(text).bend


def test_what_is_too_large_says_by_how_much():
    assert not too_large(product(10), bends=True)
    said = too_large(product(60), bends=True)
    assert said.startswith(
        f"at most {LARGEST:,} operations are accepted of an expression written out with its slopes and"
    )


def test_the_root_of_a_square_is_its_size_with_a_located_kink():
    given = equations(system("sqrt(x**2) - abs(x)", "rate").structure())
    x = given.positions[0]
    assert [contact.u for contact in given.contacts] == [x]
    assert given.force[0] == 0


@pytest.mark.parametrize("text", ["sqrt(angle**2)", "t/0", "sqrt(-1)*t", product(200).replace("x", "t")])
def test_a_servo_is_fed_with_what_has_a_smooth_real_form(text):
    assert parse(text)
    with pytest.raises(InputError, match="feedforward"):
        Servo(link="crank", stiffness=1.0, damping=0.1, nominal_speed=1.0, feedforward=text)
