"""Generated texts as machine code against themselves as plain Python, number by number and bit by bit.

Written without licences of arithmetic (fused multiply-add, reciprocals), instructions do what Python does, so
every bit is the same, in rows of lanes too. Sines and powers are those of one library on both sides.
"""

from __future__ import annotations

import inspect
import math
import zlib

import numpy as np
import pytest

from jointplay import catalog
from jointplay.codegen import cache, objects
from jointplay.codegen.ensemble import hindrance
from jointplay.codegen.generated import Function, _address
from jointplay.codegen.instructions import RefusedError, written
from jointplay.mechanism.assemble import assemble
from tests.codegen.samples import ARGUMENTS, oscillator
from tests.support import one_lane
from tests.support.laws_grid import GUIDED, PAIRS, mechanism
from tests.support.plain import run

LARGE = 20000  # numbers in an array: more than any text reads
LINKAGES = ("chunmei2002", "slider_crank", "watt", "quick_return")
LAWS = [("four_bar", *PAIRS[k], False) for k in (2, 4, 5, 6)] + [("guide", *GUIDED[0], False)]
LAWS += [("four_bar", "restitution", "none", False), ("slider_crank", "hertz", "stribeck", True)]


def models():
    for name in (*ARGUMENTS, "lorenz", "duffing", "jerk"):
        yield name, lambda name=name: oscillator(name)
    for name in LINKAGES:
        yield name, lambda name=name: assemble(catalog.NAMES[name]())
    for cell in LAWS:
        yield "-".join(map(str, cell)), lambda cell=cell: assemble(mechanism(*cell))


MODELS = dict(models())


def texts(model):
    """Every text of a model's structure: its own, derivatives, algebra, and those in lanes."""
    structure, made = model.structure, cache._from_equations
    yield "module", (own := made("module", structure))
    sizes = run(own).SIZES
    yield "variation", made("variation", structure, sizes["first"], bool(sizes["planned"]))
    if not sizes["planned"]:
        yield "algebra", cache._writer("algebra").text(sizes["positions"], sizes["speeds"])
    if not hindrance(structure):
        yield "ensemble", made("ensemble.equations", structure)


def reference(text):
    """A text as Python, with functions of the system's mathematical library, as machine code has them."""

    def number(function):
        def found(*values):
            try:
                return np.float64(function(*values))
            except ValueError:
                return np.float64(np.nan)
            except OverflowError:
                return np.float64(np.inf)

        return found

    module = run(text)
    scope = next(
        each.__globals__ for each in vars(module).values() if getattr(each, "__module__", "") is None
    )
    for name in ("sin", "cos", "tanh", "exp", "log", "ln"):
        if name in scope:
            scope[name] = number(getattr(math, name.replace("ln", "log")))
    return module


def compiled(text, licences=""):
    """The functions of a text as machine code, by name, and the kinds of their arguments."""
    instructions, entries, outside = written(text, licences)
    library = objects.Library(objects.emit(instructions), {name: _address(name) for name in outside})
    return {name: (Function(library, name, kinds), kinds[1:]) for name, kinds in entries.items()}


def arguments(kinds, names, seed):
    """Numbers for a call: any for arrays, small for integers, lengths between 0 and 1."""
    random, found = np.random.default_rng(seed), []
    for kind, name in zip(kinds, names, strict=True):
        if kind == "i":
            found.append(int(random.integers(0, 8)))
        elif kind == "f":
            found.append(float(random.uniform(0.1, 1.0)))
        else:
            values = random.uniform(0.2, 2.0, LARGE) if name == "p" else random.normal(size=LARGE)
            if name == "m":
                values = random.integers(0, 2, LARGE).astype(float)
            found.append(values)
    return found


def differences(text, seeds=range(3)):
    """Functions of a text whose numbers are not those of its Python, to the bit."""
    plain, found = reference(text), []
    for name, (function, kinds) in compiled(text).items():
        expected = getattr(plain, name)
        names = expected.__code__.co_varnames
        for seed in seeds:
            ours = arguments(kinds, names[: len(kinds)], [seed, zlib.crc32(name.encode())])
            theirs = [each.copy() if isinstance(each, np.ndarray) else each for each in ours]
            with np.errstate(all="ignore"):
                values = function(*ours), expected(*theirs)
            pairs = [values] if kinds and values[1] is not None else []
            pairs += [(a, b) for a, b in zip(ours, theirs, strict=True) if isinstance(a, np.ndarray)]
            if not all(np.array_equal(a, b, equal_nan=True) for a, b in pairs):
                found.append(name)
                break
    return found


LONG = ("slider_crank-hertz-stribeck-True", "guide-kelvin_voigt-coulomb-False")  # half a minute each


@pytest.mark.parametrize("positions", [1, 3])
def test_code_in_lanes_of_a_size_does_what_its_text_says(positions):
    """The method's algebra, and tangents: of angles and of what is none, with contacts, jumps and loops."""
    turning = (1.0, 0.0, 1.0)[:positions]
    algebra = cache._writer("ensemble.algebra").text(turning, 2, 1, 1, 0)
    tangents = cache._writer("ensemble.tangent").text(positions)
    assert differences(algebra) == differences(tangents) == []


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long) if name in LONG else name for name in MODELS]
)
def test_machine_code_does_what_its_text_says(name):
    wrong = {kind: differences(text) for kind, text in texts(MODELS[name]())}
    assert not any(wrong.values()), wrong


STRANGE = {
    "with open('x') as f: pass": "with open",
    "w[0] = [1.0][0]": "[1.0]",
    "w[0] = print(1.0)": "print",
    "w[0] = 'text'": "'text'",
    "w[0] = w[0:2:2]": "0:2:2",
    "x = 1.0\n    if w[0] > 0.0:\n        x = 1\n        x = w\n    w[1] = x": "x",
    "w[0] = x": "x",
    "if w[0] > 0.0:\n        return 1.0": "a way without a value",
    "if w[0] > 0.0:\n        return 1.0\n    return 2": "return 2",
    "w[w[0]] = 1.0": "a place that is no integer",
    "w[0] = not w[0]": "not w[0]",
    "w[0] = g(w[0])": "g",
    "for x in w:\n        pass": "for x in w",
}


@pytest.mark.parametrize("body", STRANGE)
def test_what_it_cannot_write_it_refuses_by_name(body):
    with pytest.raises(RefusedError) as refused:
        written(f"def f(w):\n    {body}\n")
    assert STRANGE[body] in str(refused.value)


def test_a_function_that_calls_itself_is_refused():
    with pytest.raises(RefusedError, match="g calls itself"):
        written("def g(x):\n    return g(x)\n\ndef f(w):\n    w[0] = g(w[0])\n")


@pytest.mark.parametrize("given", [np.zeros(4)[::2], np.zeros(4, dtype=int), np.zeros((2, 2))])
def test_arrays_that_lie_otherwise_are_not_taken(given):
    function, _ = compiled("def f(w):\n    w[0] = 1.0\n")["f"]
    with pytest.raises(TypeError, match="arrays of floats"):
        function(given)


def test_control_flow_and_integers():
    text = """
def f(variant, w, h):
    n = len(w)
    total, k = 0.0, 0
    while k < n:
        if k == 2 and variant > 0:
            total += 10.0
        else:
            total -= w[k] ** 3
        k += 1
    for j in range(n - 1, 0, -2):
        total = total * 2.0 + w[j] if w[j] > h else total
    w[0] = total + g(w[1:3], n)
    return total


def g(part, n):
    return part[1] ** -2 + n
"""
    scope = {}
    exec(text, scope)
    function, kinds = compiled(text)["f"]
    assert kinds == "iaf"
    for variant in (0, 1):
        ours = np.array([0.5, -1.25, 3.0, 0.75, 2.5])
        theirs = ours.copy()
        assert function(variant, ours, 0.6) == scope["f"](variant, theirs, 0.6)
        assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("processor", ["x86-64", "x86-64-v3"])
def test_code_for_another_processor_does_the_same(processor):
    kind = objects.target()._replace(cpu=processor, features="")
    _, text = next(texts(MODELS["chunmei2002"]()))
    instructions, entries, _ = written(text, "")
    here, there = (objects.Library(objects.emit(instructions, each)) for each in (objects.target(), kind))
    found = []
    for library in (here, there):
        function = Function(library, "rate", entries["rate"])
        given = arguments(entries["rate"][1:], ("variant", "w", "s", "p", "m"), 1)
        function(1, *given[1:])
        found.append(given[1])
    assert np.array_equal(*found)


STRANGE_NUMBERS = np.array([0.0, -0.0, 1.0, np.inf, -np.inf, np.nan, 1e-300, -2.0])


def test_every_lane_has_what_plain_python_gives():
    source = inspect.getsource(one_lane.written).replace("def written", "@lanewise\ndef part")
    imports = ("from math import copysign, cos, sqrt", "from tests.support.one_lane import SHARE, bounded")
    imports += ("from tests.support.one_lane import level_of, root, solved",)
    run, _ = compiled("\n".join([*imports, source, "def run(w):", "    part(w)", ""]))["run"]
    random = np.random.default_rng(3)
    for _ in range(20):
        w = np.zeros((23, 8))
        w[:4] = random.normal(size=(4, 8))
        w[0] = random.permutation(STRANGE_NUMBERS)
        w[1], w[3] = np.where(random.random((2, 8)) < 0.3, w[[0, 2]], w[[1, 3]])
        mine, plain = w.ravel().copy(), w.ravel().copy()
        run(mine)
        with np.errstate(all="ignore"):
            one_lane.looped(plain)
        np.testing.assert_allclose(mine, plain, rtol=1e-14, atol=1e-290)
