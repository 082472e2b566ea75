"""Kernels in JavaScript: the same numbers as in Python; all of the method has a translation."""

import ast
from importlib.resources import files

import numpy as np
import pytest

from jointplay.solver.codegen import cache
from jointplay.solver.codegen.reader import FUNCTIONS, imported
from jointplay_page.script.translate import Script

from . import kernels
from .in_node import needs_node, ran

MODULES = (
    *(
        "control",
        "events",
        "flow",
        "modes",
        "polynomial",
        "record",
        "sparse",
        "step",
    ),
    *("tangents.saltation", "tangents.tangent"),
    *("walls.impacts", "walls.wall_flow", "walls.walls"),
)
X = [1.25, -3.0, 2.0, float("nan")]
CALLED = ("whole_numbers", "order", "loops", "views", "changed")


def in_javascript(calls, tmp_path):
    script, unit = Script(), imported("tests.script.kernels")
    for name in (*CALLED, "tables", "handed"):
        script.function(unit, name)
    runtime = (files("jointplay_page.script") / "runtime.js").read_text()
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


@pytest.mark.parametrize("name", MODULES)
def test_every_kernel_of_the_method_is_in_the_subset(name):
    cache.method("tangents.tangent_flow")
    unit = imported(f"jointplay.solver.method.{name}")
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
        assert f"function {name.rpartition('.')[2]}${each}(" in script.text


@needs_node
def test_functions_of_node_are_within_two_units_of_the_last_place(tmp_path):
    x = np.random.default_rng(1).uniform(0.01, 30.0, 400)
    names = {names[-1]: function for function, names in FUNCTIONS.items() if names[-1].startswith("Math.")}
    names["Math.pow"] = pow
    program = "return data.names.map((name) => data.x.map((x) => eval(name)(x, 1.5)));"
    found = ran("", {"names": [*names], "x": x.tolist()}, program, tmp_path)
    for (name, function), numbers in zip(names.items(), found, strict=True):
        given = (1.5,) if name in ("Math.pow", "Math.atan2") else ()
        expected = np.array([function(float(each), *given) for each in x])
        np.testing.assert_array_max_ulp(np.array(numbers, float), expected, maxulp=2)
