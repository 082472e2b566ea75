"""Which of numba's undocumented parts, that the package uses, a release of numba has taken away."""

import ast
import importlib
import re
from pathlib import Path

import numba
import pytest

import jointplay
from jointplay.numerics import numba_private

PACKAGE = Path(jointplay.__file__).parent
FILE = PACKAGE / "numerics" / "numba_private.py"
PRIVATE = re.compile(
    r"numba\.(core|experimental|np|cpython)\b|\bllvmlite\.ir\b|from llvmlite import|_nrt|forceinline|"
    r"no_cpython_wrapper|no_cfunc_wrapper|\.entry_point\b|\._cache = "
)


def imported():
    """Names that the file imports, with their modules."""
    nodes = [node for node in ast.parse(FILE.read_text()).body if isinstance(node, ast.ImportFrom)]
    return [(node.module, alias.name) for node in nodes for alias in node.names]


def options():
    """Compiler options that the file names."""
    return {
        option: value
        for name, each in vars(numba_private).items()
        if name.isupper()
        for option, value in each.items()
    }


def test_they_stand_in_one_file():
    files = [path for path in PACKAGE.rglob("*.py") if PRIVATE.search(path.read_text(encoding="utf-8"))]
    assert files == [FILE]


@pytest.mark.parametrize(("module", "name"), imported())
def test_it_is_there(module, name):
    assert hasattr(importlib.import_module(module), name)


@pytest.mark.parametrize("option", ["_nrt", "no_cpython_wrapper", "no_cfunc_wrapper", "forceinline"])
def test_the_option_is_known(option):
    found = numba.njit(**{option: options()[option]})(lambda x: x + 1.0)
    assert found.compile(numba.float64(numba.float64)) is not None
    with pytest.raises(KeyError):
        numba.njit(no_such_option=True)(lambda x: x).compile((numba.float64,))


def test_every_option_is_tested():
    assert set(options()) == {"_nrt", "no_cpython_wrapper", "no_cfunc_wrapper", "forceinline"}


@pytest.fixture
def half():
    function = numba.njit(lambda x: 0.5 * x)
    function.compile(numba.float64(numba.float64))
    return function


def test_a_function_has_an_address(half):
    from jointplay.numerics.numba_private import address

    assert address(half, numba.float64(numba.float64)) > 0


def test_a_cache_is_asked_before_a_function_is_compiled_and_told_after():
    from jointplay.numerics.numba_private import keep

    class Cache:
        said = ()

        def load_overload(self, signature, context):
            self.said = ("asked",)

        def save_overload(self, signature, data):
            self.said = (*self.said, "told")

    function, cache = numba.njit(lambda x: x + 2.0), Cache()
    keep(function, cache)
    assert function(1.0) == 3.0
    assert cache.said == ("asked", "told")


def test_what_the_cache_over_sealed_files_replaces_is_there():
    from jointplay.codegen.kernels import Kernels
    from numba.core.caching import CompileResultCacheImpl, FunctionCache

    assert hasattr(CompileResultCacheImpl, "_locator_classes")
    assert hasattr(FunctionCache, "_impl_class")
    made = Kernels(test_it_is_there)
    assert {"_impl", "_cache_file", "_name"} <= set(vars(made)) | set(dir(made))
    assert callable(made.load_overload)


def test_functions_are_compiled_to_object_code_of_a_processor_by_name():
    from jointplay.numerics import modal_response
    from jointplay.numerics.compiler import object_code

    one, other = (object_code(modal_response, cpu, "") for cpu in ("x86-64-v2", "x86-64-v3"))
    assert one[:4] == other[:4] == b"\x7fELF"
    assert one != other, "of other instructions"
    assert object_code(modal_response, "x86-64-v3", "") == other, "the same each time"


def test_code_that_may_raise_an_error_is_refused():
    """A function that Python cannot ask how it ended must not end early."""
    from types import SimpleNamespace

    from jointplay.numerics.compiler import object_code
    from jointplay.numerics.interface import INT, REAL, Signature, inlined

    @inlined
    def power(x, n):
        return x**n

    unit = SimpleNamespace(power=power, UNIT={"power": Signature(REAL, (REAL, INT))})
    with pytest.raises(RuntimeError, match="reaches for Python"):
        object_code(unit, "", "")
