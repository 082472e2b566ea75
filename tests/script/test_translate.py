"""Kernels in JavaScript: the same numbers as in Python, and a refusal of what is not in the subset."""

import ast
import inspect
from importlib.resources import files

import numpy as np
import pytest

from jointplay.codegen import cache
from jointplay.script.translate import Script, UntranslatableError, unit_of

from . import kernels
from .in_node import needs_node, ran

MODULES = (
    *("control", "doubts", "events", "flow", "frame", "impacts", "modes", "polynomial", "record"),
    *("saltation", "sections", "sparse", "step", "tangent", "wall_flow", "walls"),
)
X = [1.25, -3.0, 2.0, float("nan")]
CALLED = ("whole_numbers", "order", "loops", "views", "changed")
REFUSED = {
    "no_list": "ListComp",
    "no_keyword": "Call",
    "no_name": "the function unknown",
    "no_default": "arguments",
    "no_second_call": "AugAssign",
    "no_slice": "Subscript",
    "no_end": "UnaryOp",
    "no_late_variable": "the loop's variable i",
    "no_text": "JoinedStr",
    "no_try": "Try",
}


def in_javascript(calls, tmp_path):
    script, unit = Script(), unit_of("tests.script.kernels")
    for name in (*CALLED, "tables", "handed"):
        script.function(unit, name)
    runtime = (files("jointplay.script") / "runtime.js").read_text()
    return ran(runtime + script.text, [], calls, tmp_path)


@needs_node
def test_kernels_give_the_same_numbers(tmp_path):
    calls = [
        f"kernels${name}(Float64Array.from(X), out = new Float64Array(8)); all.push(out);" for name in CALLED
    ]
    calls = "\n".join(
        [
            "const X = [1.25, -3, 2, NaN], all = []; let out;",
            *calls,
            "const rows = [Float64Array.of(1, 2), Float64Array.of(3, 4)];",
            "kernels$tables(rows, out = new Float64Array(8)); all.push(out);",
            "kernels$handed((v) => 3 * v, Float64Array.from(X), out = new Float64Array(8)); all.push(out);",
            "return all;",
        ]
    )
    found = np.array(in_javascript(calls, tmp_path), dtype=float)
    expected = np.zeros((len(CALLED) + 2, 8))
    for row, name in zip(expected, CALLED, strict=False):
        getattr(kernels, name)(np.array(X), row)
    kernels.tables(np.array([[1.0, 2.0], [3.0, 4.0]]), expected[-2])
    kernels.handed(lambda v: 3 * v, np.array(X), expected[-1])
    np.testing.assert_allclose(found, expected, rtol=1e-15)


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_in_the_subset_is_refused_by_line(name):
    with pytest.raises(UntranslatableError) as refused:
        Script().function(unit_of("tests.script.kernels"), name)
    begin = inspect.getsourcelines(getattr(kernels, name))[1]
    place, _, why = str(refused.value).partition(" in ")
    assert place.startswith("kernels.py:")
    assert begin <= int(place.rpartition(":")[2]) <= begin + 5
    assert name in why
    assert REFUSED[name] in why


@pytest.mark.parametrize("name", MODULES)
def test_every_kernel_of_the_method_is_in_the_subset(name):
    cache.method("tangent_flow")
    unit = unit_of(f"jointplay.numerics.{name}")
    kernel, entries = {"compiled", "inner", "inlined", "spliced"}, {"run", "at_wall"}
    names = [
        each.name
        for each in unit.functions.values()
        if kernel & {d.id for d in each.decorator_list if isinstance(d, ast.Name)} or each.name in entries
    ]
    assert names
    script = Script()
    for each in names:
        script.function(unit, each)
        assert f"function {name}${each}(" in script.text
