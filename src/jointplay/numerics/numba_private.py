"""Parts of numba beside its documented interface that are used here; a release of numba may change any of it.

Nothing else in the package reaches for these. tests/numerics/test_numba_private.py tells which one is gone;
what then breaks, and what to do, is said here of each.
"""

# Vector instructions (numerics.lanes), each of which stands there in plain Python too, far slower.
from llvmlite import ir as ir

# The cache over sealed files (codegen.kernels). Without them it needs another way to be asked before a
# function is compiled, and told after.
from numba.core.caching import CompileResultCacheImpl as CompileResultCacheImpl
from numba.core.caching import FunctionCache as FunctionCache
from numba.core.caching import _CacheLocator as _CacheLocator
from numba.core.cgutils import alloca_once_value as alloca_once_value  # vector instructions, as above
from numba.core.cgutils import for_range_slice as for_range_slice
from numba.core.registry import cpu_target
from numba.core.serialize import dumps as dumps  # of compiled functions, for that cache
from numba.experimental.function_type import _get_wrapper_address

# No reference counting, which takes a third of a kernel's time and which no kernel needs. Without the option
# all is right, and slower.
UNCOUNTED = {"_nrt": False}
# No doors to Python and C for what compiled code alone calls: they are a third of the time to compile.
INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# The compiler's own judgement would leave calls that hand over seven numbers for each array.
INLINED = {"forceinline": True}


def keep(function, cache) -> None:
    """Give a compiled function another cache than numba's. Without this every process compiles all anew."""
    function._cache = cache


def address(function, signature) -> int:
    """Where a compiled function lies in memory.

    Handed over so, it costs a call from Python less than the function itself, which would do as well.
    """
    return _get_wrapper_address(function, signature)


def only_version(function):
    """The code of a compiled function with one signature, as a plain built-in function.

    It saves the search for the version that fits the arguments; the function itself would do as well.
    """
    (version,) = function.overloads.values()
    return version.entry_point


def target() -> tuple[str, str, str]:
    """Triple, name and features of the processor that is compiled for, with NUMBA_CPU_NAME and others heeded.

    The provenance of results names it; without it, llvmlite.binding knows the processor of this machine.
    """
    return cpu_target.target_context.codegen().magic_tuple()
