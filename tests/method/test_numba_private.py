"""Which of numba's undocumented parts, that the package uses, a release of numba has taken away."""

import ast
import importlib
import re
from pathlib import Path

import numba
import pytest

import jointplay
from jointplay.solver.method import numba_private

PACKAGE = Path(jointplay.__file__).parent
FILE = PACKAGE / "solver" / "method" / "numba_private.py"
PRIVATE = re.compile(
    r"numba\.(core|experimental|np|cpython)\b|\bllvmlite\.ir\b|from llvmlite import|_nrt|forceinline|"
    r"no_cpython_wrapper|no_cfunc_wrapper|\.entry_point\b"
)


def imported():
    """Names that the file imports, with their modules."""
    nodes = [node for node in ast.parse(FILE.read_text()).body if isinstance(node, ast.ImportFrom)]
    return [(node.module, alias.name) for node in nodes for alias in node.names]


def options():
    """Compiler options that the file names."""
    return {
        option: value
        for each in vars(numba_private).values()
        if isinstance(each, dict) and each is not numba_private.__builtins__
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


def test_the_only_version_of_a_function_is_called_without_a_search():
    half = numba.njit(numba.float64(numba.float64))(lambda x: 0.5 * x)
    found = numba_private.only_version(half)
    assert found is not half
    assert found(3.0) == 1.5


def test_what_the_compiler_to_object_code_replaces_and_asks_for_is_there():
    """A part that is replaced under a name that nobody asks for any more would be without effect, unseen."""
    from numba.core import codegen
    from numba.core.registry import CPUDispatcher, cpu_target

    own = numba_private
    replaced = {codegen.CPUCodeLibrary: own._Library, codegen.JITCPUCodegen: own._Codegen}
    names = {
        (whole, name) for whole, mine in replaced.items() for name in vars(mine) if not name.startswith("__")
    }
    assert {"finalize", "add_llvm_module"} < {name for _, name in names}
    mine = {(codegen.JITCPUCodegen, "cpu"), (codegen.JITCPUCodegen, "features")}
    asked = {(codegen.CPUCodeLibrary, "_get_module_for_linking"), (CPUDispatcher, "targetdescr")}
    assert [each for each in (names - mine) | asked if not hasattr(*each)] == []
    assert {"_final_module", "_linking_libraries"} <= vars(_library()).keys()
    assert callable(cpu_target.target_context.subtarget)
    context = cpu_target.target_context
    assert {"aot_mode", "_internal_codegen"} <= set(dir(context))
    assert callable(context.get_executable)


def _library():
    """Code of a function that numba compiled."""
    function = numba.njit(numba.float64(numba.float64))(lambda x: x + 2.0)
    (found,) = function.overloads.values()
    return found.library


def test_functions_are_compiled_to_object_code_of_a_processor_by_name():
    from jointplay.solver.method import modal_response
    from jointplay.solver.method.compiler import object_code

    one, other = (object_code(modal_response, cpu, "") for cpu in ("x86-64-v2", "x86-64-v3"))
    assert one[:4] == other[:4] == b"\x7fELF"
    assert one != other, "of other instructions"
    assert object_code(modal_response, "x86-64-v3", "") == other, "the same each time"


def test_code_that_may_raise_an_error_is_refused():
    """A function that Python cannot ask how it ended must not end early."""
    from types import SimpleNamespace

    from jointplay.solver.method.compiler import object_code
    from jointplay.solver.method.interface import INT, REAL, Signature, inlined

    @inlined
    def power(x, n):
        return x**n

    unit = SimpleNamespace(power=power, UNIT={"power": Signature(REAL, (REAL, INT))})
    with pytest.raises(RuntimeError, match="reaches for Python"):
        object_code(unit, "", "")
