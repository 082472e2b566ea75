"""Generated texts as machine code and as JavaScript against themselves as plain Python, bit by bit.

Written without licences of arithmetic (fused multiply-add, reciprocals), instructions do what Python does, so
every bit is the same, in rows of lanes too. Sines and powers are those of one library on both sides. Node has
another, so there others stand in for them on both sides (tests/script/test_translate.py has Node's own).
"""

from __future__ import annotations

import ast
import copy
import inspect
import math
import zlib
from functools import lru_cache
from importlib.resources import files

import numpy as np
import pytest

from jointplay import catalog
from jointplay.solver.codegen import cache, elimination, place
from jointplay.solver.codegen.generated import Function, _address
from jointplay.solver.codegen.instructions import written
from jointplay.solver.codegen.lanes import exclusion
from jointplay.solver.codegen.reader import RefusedError, Text
from jointplay.solver.mechanism.assemble import assemble
from jointplay_page.script.translate import Script
from tests.codegen.samples import oscillator
from tests.method.linear import sparse_plan
from tests.script.in_node import needs_node, ran
from tests.support import one_lane
from tests.support.laws_grid import GUIDED, PAIRS, mechanism
from tests.support.plain import run

LARGE = 20000  # numbers in an array: more than any text reads
LAWS = [("four_bar", *PAIRS[k], False) for k in (2, 4, 5, 6)] + [("guide", *GUIDED[0], False)]
LAWS += [("four_bar", "restitution", "none", False), ("slider_crank", "hertz", "stribeck", True)]


def models():
    for name in catalog.NAMES:
        yield name, lambda name=name: oscillator(name)
    for cell in LAWS:
        yield "-".join(map(str, cell)), lambda cell=cell: assemble(mechanism(*cell))


MODELS = dict(models())


@lru_cache(maxsize=1)
def texts(name):
    """Every text of a model's structure: its own, derivatives, algebra, and those in lanes."""
    structure, made = MODELS[name]().structure, cache._text
    found = {"module": made("module", structure)}
    sizes = run(found["module"]).SIZES
    found["variation"] = made("variation", structure, sizes["first"], bool(sizes["planned"]))
    if not sizes["planned"]:
        found["algebra"] = made("algebra", sizes["positions"], sizes["speeds"])
    if not exclusion(structure):
        found["ensemble"] = made("lanes.equations", structure)
    return found


def library(name):
    """A function of the system's mathematical library, which machine code calls."""
    function = getattr(math, name.replace("ln", "log"))

    def found(*values):
        try:
            return np.float64(function(*values))
        except ValueError:
            return np.float64(np.nan)
        except OverflowError:
            return np.float64(np.inf)

    return found


STAND_INS = {"sin": 0.1, "cos": 0.2, "tanh": 0.3, "exp": 0.4, "log": 0.5}


def stand_in(name):
    """What stands in for such a function: a fraction, which has the same bits everywhere."""
    c = STAND_INS[name.replace("ln", "log")]
    return lambda x: c + x / (1.0 + x * x)


class Powers(ast.NodeTransformer):
    """Powers but squares as calls."""

    def visit_BinOp(self, node):
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow) or ast.unparse(node.right) == "2":
            return node
        return ast.Call(ast.Name("power", ast.Load()), [node.left, node.right], [])


def reference(text, function=library):
    """A text as Python, with functions of a library that the other side has too."""
    if function is stand_in:
        text = ast.unparse(ast.fix_missing_locations(Powers().visit(ast.parse(text))))
    module = run(text)
    scope = next(
        each.__globals__ for each in vars(module).values() if getattr(each, "__module__", "") is None
    )
    scope["power"] = lambda a, b: a * (b + 0.5)
    for name in ("sin", "cos", "tanh", "exp", "log", "ln"):
        if name in scope:
            scope[name] = function(name)
    return module


def compiled(text, licences=""):
    """The functions of a text as machine code, by name, and the kinds of their arguments."""
    instructions, entries, outside = written(text, licences)
    library = place.Library(
        place.emit(instructions), {name: _address(name, cache.method) for name in outside}
    )
    return {name: (Function(library, name, kinds), kinds[1:]) for name, kinds in entries.items()}


def machine_code(text, calls, _):
    functions = compiled(text)
    return [functions[name][0](*given) for name, given in calls]


CALLS = """
const fs = require("fs"), numbers = new Float64Array(new Uint8Array(fs.readFileSync(data.file)).buffer);
for (const [name, c] of Object.entries(data.stand_ins)) Math[name] = (x) => c + x / (1 + x * x);
Math.pow = (a, b) => a * (b + 0.5);
let at = 0;
const taken = (each) => (Array.isArray(each) ? numbers.subarray(at, (at += each[0])) : each);
const returned = data.calls.map(([name, given]) => eval(name)(...given.map(taken)));
fs.writeFileSync(data.file, new Uint8Array(numbers.buffer));
return returned;
"""


def javascript(text, calls, folder):
    script, own, file = Script(), Text.of(text), folder / "numbers"
    arrays = [each for _, given in calls for each in given if isinstance(each, np.ndarray)]
    np.concatenate(arrays).tofile(file)
    named = [
        (
            script.function(own, name),
            [[len(each)] if isinstance(each, np.ndarray) else each for each in given],
        )
        for name, given in calls
    ]
    runtime = (files("jointplay_page.script") / "runtime.js").read_text()
    data = {"file": str(file), "calls": named, "stand_ins": STAND_INS}
    returned = ran(runtime + script.text, data, CALLS, folder)
    for array, found in zip(arrays, np.split(np.fromfile(file), len(arrays)), strict=True):
        array[:] = found
    return returned


OWN = ("module", "variation", "algebra")
BACK_ENDS = {  # which texts they write, how, and what stands there for the functions of a library
    "numbers": (OWN, machine_code, library),
    "rows": (("ensemble",), machine_code, library),
    "JavaScript": (OWN, javascript, stand_in),
}


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


def differences(text, back_end=machine_code, function=library, folder=None):
    """Functions of a text whose numbers are not those of its Python, to the bit.

    Where they call functions of the method, of which each side has its own compiled form, to rounding.
    """
    plain, ours, kinds = reference(text, function), [], written(text).entries
    close = {"rtol": NEAR, "atol": NEAR} if written(text)[2] else {"rtol": 0.0, "atol": 0.0}
    for name in kinds:
        names = getattr(plain, name).__code__.co_varnames
        ours += [
            (
                name,
                arguments(kinds[name][1:], names[: len(kinds[name]) - 1], [seed, zlib.crc32(name.encode())]),
            )
            for seed in range(3)
        ]
    theirs, found = copy.deepcopy(ours), set()
    with np.errstate(all="ignore"):
        returned = back_end(text, ours, folder)
        expected = [getattr(plain, name)(*given) for name, given in theirs]
    for (name, mine), (_, other), *values in zip(ours, theirs, returned, expected, strict=True):
        pairs = [map(float, values)] if kinds[name][0] != "v" else []
        pairs += [pair for pair in zip(mine, other, strict=True) if isinstance(pair[0], np.ndarray)]
        if not all(np.allclose(a, b, **close, equal_nan=True) for a, b in pairs):
            found.add(name)
    return sorted(found)


NEAR = 1e-9  # relative, of what goes through the method's own functions
LONG = (  # half a minute each
    *("slider_crank-hertz-stribeck-True", "guide-kelvin_voigt-coulomb-False"),
    *("ivp_crank", "flores2010", "siconos_four_bar"),
)
TABLE = [
    pytest.param(
        *(name, back_end),
        marks=[pytest.mark.nightly] * (name in LONG or (translated and name not in catalog.NAMES))
        + [needs_node] * translated,
    )
    for name in MODELS
    for back_end in BACK_ENDS
    for translated in [back_end == "JavaScript"]
]


@pytest.mark.long
@pytest.mark.parametrize("positions", [1, 3])
def test_code_in_lanes_of_a_size_does_what_its_text_says(positions):
    """The method's algebra, and tangents: of angles and of what is none, with contacts, jumps and loops."""
    turning = (1.0, 0.0, 1.0)[:positions]
    algebra = cache._text("lanes.algebra", turning, 2, 1, 1, 0)
    tangents = cache._text("lanes.tangent", positions)
    assert differences(algebra) == differences(tangents) == []


def test_functions_of_the_method_are_handed_arrays_by_name():
    plans = [sparse_plan(np.random.default_rng(5), 4, 3, 0.4)]
    text = elimination.text(plans, 4, plans[0].rows)
    assert written(text).outside
    assert differences(text) == []


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "back_end"), TABLE)
def test_every_function_does_what_its_text_says(name, back_end, tmp_path):
    wanted, *how = BACK_ENDS[back_end]
    found = {kind: text for kind, text in texts(name).items() if kind in wanted}
    assert found or back_end == "rows"  # which not all structures have
    wrong = {kind: differences(text, *how, tmp_path) for kind, text in found.items()}
    assert not any(wrong.values()), wrong


STRANGE = {
    "x = 1.0\n    if w[0] > 0.0:\n        x = 1\n        x = w\n    w[1] = x": "x",
    "if w[0] > 0.0:\n        return 1.0": "a way without a value",
    "if w[0] > 0.0:\n        return 1.0\n    return 2": "return 2",
    "return 1.0\n    w[0] = 2.0": "what is never reached",
    "w[w[0]] = 1.0": "a place that is no integer",
    "w[0] = not w[0]": "not w[0]",
    "for x in w:\n        pass": "for x in w",
    "if w[0]:\n        w[1] = 1.0": "a number as a truth",
    "return print": "print",
    "w.fill(0.0)": "the name w",
}
REFUSED_BY_ALL = {
    "with open('x') as f: pass": "With (with open",
    "w[0] = [1.0][0]": "List ([1.0])",
    "return [x + 1.0 for x in w]": "ListComp",
    "return f'{w}'": "JoinedStr",
    "try:\n        w[0] = 1.0\n    finally:\n        w[1] = 1.0": "Try",
    "w[0] = abs(x=w[0])": "Call",
    "w[int(w[0])] //= 2": "int(w[0])",
    "def g(x):\n        pass": "FunctionDef",
    "w[0] = 'text'": "'text'",
    "w[0] = w[0:2:2]": "0:2:2",
    "w[0] = x": "the name x",
    "w[0] = print(w[0])": "print",
    "w[0] = g(w[0])": "the name g",
    "w[-1] = 1.0": "UnaryOp (-1)",
    "w[0:2] = 1.0": "w[0:2]",
    "w[0:2] += 1.0": "w[0:2]",
    "w.size += 1.0": "w.size",
    "for j in range(3):\n        for j in range(2):\n            w[j] = 1.0": "For",
    "a, b = w[0], w[1], w[2]": "a, b",
    "while w[0] > 0.0:\n        w[0] = w[1]\n    else:\n        w[1] = 1.0": "While",
    "for j in range(3):\n        pass\n    else:\n        w[1] = 1.0": "For",
    "for j in range(3):\n        j = 0\n        w[j] = 1.0": "the loop's variable j",
    "for j in range(3):\n        pass\n    w[0] = j": "the name j",
    "for j in range(0, 3, len(w)):\n        w[j] = 1.0": "a step",
}


@pytest.mark.parametrize("body", STRANGE)
def test_what_it_cannot_write_it_refuses_by_name(body):
    with pytest.raises(RefusedError) as refused:
        written(f"def f(w):\n    {body}\n")
    assert STRANGE[body] in str(refused.value)


@pytest.mark.parametrize("back_end", [written, lambda text: Script().function(Text.of(text), "f")])
@pytest.mark.parametrize("body", REFUSED_BY_ALL)
def test_what_languages_do_not_share_every_back_end_refuses(body, back_end):
    with pytest.raises(RefusedError, match=r"text.py:[2-4] in f: ") as refused:
        back_end(f"def f(w):\n    {body}\n")
    assert REFUSED_BY_ALL[body] in str(refused.value)
    with pytest.raises(RefusedError, match=r"text.py:1 in f: arguments that are not plain"):
        back_end("def f(w, x=1.0):\n    pass\n")


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
import math

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
    w[0] = total + g(w[1:3], n) + math.sqrt(w[4])
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


@pytest.mark.nightly
@pytest.mark.parametrize("processor", ["x86-64", "x86-64-v3"])
def test_code_for_another_processor_does_the_same(processor):
    kind = place.target()._replace(cpu=processor, features="")
    text = texts("chunmei2002")["module"]
    instructions, entries, _ = written(text, "")
    here, there = (place.Library(place.emit(instructions, each)) for each in (place.target(), kind))
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
