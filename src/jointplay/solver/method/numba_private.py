"""Parts of numba outside its documented interface that are used here; a release may change any of it.

Nothing else in the package reaches for these. tests/method/test_numba_private.py tells which one is gone;
what then breaks, and what to do, is said here of each.
"""

import llvmlite.binding as binding

# Instructions that are written down one by one (method.lanes.lane_instructions, method.compiler).
from llvmlite import ir as ir
from numba.core.cgutils import alloca_once as alloca_once
from numba.core.cgutils import alloca_once_value as alloca_once_value  # vector instructions, as above
from numba.core.cgutils import for_range_slice as for_range_slice

# Compiling to object code: a target whose functions are put together, and optimised, once all are there.
# Without it every function is compiled alone, and once more in each that calls it.
from numba.core.codegen import CPUCodegen, CPUCodeLibrary
from numba.core.llvm_bindings import create_pass_builder
from numba.core.registry import CPUDispatcher, cpu_target
from numba.core.typing.templates import AttributeTemplate as AttributeTemplate  # parts of records

# No reference counting, which takes a third of a kernel's time and which no kernel needs. Without the option
# all is right, and slower.
UNCOUNTED = {"_nrt": False}
# No entries from Python and C for what compiled code alone calls: they are a third of the time to compile.
INNER = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# The compiler's own judgement would leave calls that hand over seven numbers for each array.
INLINED = {"forceinline": True}

RAISES = "jointplay.raises"  # what an entry calls where a function ended with an error


def only_version(function):
    """The code of a compiled function with one signature, without the search for the version that fits."""
    (version,) = function.overloads.values()
    return version.entry_point


class _Library(CPUCodeLibrary):
    """A function's own code, as it comes: callers and callees are joined in `Ahead.object`."""

    def add_llvm_module(self, module):
        self._final_module.link_in(module)

    def finalize(self):
        self._finalized = True


class _Codegen(CPUCodegen):
    """Code of a processor by its name and features; nothing is loaded into this process."""

    _library_class = _Library

    def __init__(self, cpu, features):
        self.cpu, self.features = cpu, features
        super().__init__("jointplay")

    def _customize_tm_options(self, options):
        own = {"cpu": self.cpu, "features": self.features, "jit": True}
        options.update(own | {"reloc": "default", "codemodel": "jitdefault"})  # loaded anywhere

    def _customize_tm_features(self):
        return self.features

    def _add_module(self, module):
        pass


class Ahead:
    """Numba as a compiler to object code.

    Parameters
    ----------
    cpu, features : str
        The processor, as LLVM names it, and what it can do beside.
    level : int
        Of optimisation.
    """

    def __init__(self, cpu: str, features: str, level: int = 3):
        own, self._level = _Codegen(cpu, features), level
        changed = {"aot_mode": True, "get_executable": lambda *_: [].append}
        self.context = cpu_target.target_context.subtarget(_internal_codegen=own, **changed)

        class Dispatcher(CPUDispatcher):
            targetdescr = _Target(self.context)

        self._dispatcher = Dispatcher

    def function(self, written, options: dict):
        """A function to be compiled when another one that is calls it."""
        return self._dispatcher(written, targetoptions=options)

    def object(self, entries: dict) -> bytes:
        """Object code of functions by the names that they get, each with its signature in numba's words.

        `entries` gives of each the function, its signature, and what is written around it (compiler.entry).
        """
        whole, seen, own = None, set(), self.context.codegen()
        for name, (function, signature, around) in entries.items():
            function.compile(signature)
            (found,) = function.overloads.values()
            parts = [around(self.context, name, found.fndesc), *_reached(found.library)]
            for part in parts:
                if part not in seen:
                    seen.add(part)
                    if whole is None:
                        whole = _module(part).clone()
                    else:
                        whole.link_in(_module(part), preserve=True)
        for each in [*whole.functions, *whole.global_variables]:
            if not each.is_declaration and each.name not in entries:
                each.linkage = "internal"
        builder = create_pass_builder(own._tm, opt=self._level, loop_vectorize=True, slp_vectorize=False)
        passes = builder.getModulePassManager()
        passes.run(whole, builder)
        last = binding.create_new_module_pass_manager()  # what no function gives back, none is asked for
        last.add_ipsccp_pass()
        last.add_simplify_cfg_pass()
        last.add_global_dead_code_eliminate_pass()
        last.run(whole, builder)
        kept = [each.name for each in [*whole.functions, *whole.global_variables] if _of_python(each)]
        if kept:
            raise RuntimeError(f"a compiled function reaches for Python: {kept}")
        return own._tm.emit_object(whole)


class _Target:
    """Attributes that a dispatcher needs of its target."""

    options = cpu_target.options

    def __init__(self, context):
        self.target_context = context

    @property
    def typing_context(self):
        return cpu_target.typing_context


def _of_python(symbol) -> bool:
    """Whether code with such a symbol needs an interpreter: it may raise an error, or need an object."""
    named = any(word in symbol.name for word in (RAISES, "picklebuf", "numba.dynamic"))
    return named or symbol.name.startswith(("Py", "_Py", "NRT", "numba_"))


def _module(part):
    """Code of a function, of one that numba itself wrote, or of an entry as text."""
    if isinstance(part, _Library):
        return part._final_module
    return (
        part._get_module_for_linking()
        if isinstance(part, CPUCodeLibrary)
        else binding.parse_assembly(str(part))
    )


def _reached(library) -> list:
    """A function's library and all whose functions it calls, callers first: uncalled ones are dropped."""
    found = {}

    def visit(each):
        if each not in found:
            for other in each._linking_libraries:
                visit(other)
            found[each] = None

    visit(library)
    return list(found)[::-1]
