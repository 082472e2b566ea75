"""Machine code: instructions into object code, object code into functions by address.

Nothing here knows numba. The processor is this machine's, or the one that $NUMBA_CPU_NAME and
$NUMBA_CPU_FEATURES name; instructions are optimised as numba does it: loops are vectorised, straight lines
not (which would change last digits).
"""

from __future__ import annotations

import hashlib
import os
from functools import lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import llvmlite.binding


class Target(NamedTuple):
    """A kind of processor: LLVM's triple, its name, its features."""

    triple: str
    cpu: str
    features: str

    @property
    def digest(self) -> str:
        """A short name of it, for files."""
        return hashlib.sha256("\n".join(self).encode()).hexdigest()[:8]


@lru_cache(maxsize=1)
def llvm() -> ModuleType:
    """llvmlite's binding, initialized; loaded late, since a check needs nothing of it."""
    import llvmlite.binding as binding

    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    return binding


@lru_cache(maxsize=1)
def target() -> Target:
    """The processor that is compiled for."""
    named = os.environ.get("NUMBA_CPU_NAME")
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if features is None:
        features = "" if named else llvm().get_host_cpu_features().flatten()
    return Target(llvm().get_process_triple(), named or llvm().get_host_cpu_name(), features)


def _machine(kind: Target) -> llvmlite.binding.TargetMachine:
    return (
        llvm()
        .Target.from_triple(kind.triple)
        .create_target_machine(
            cpu=kind.cpu, features=kind.features, opt=3, reloc="default", codemodel="jitdefault", jit=True
        )
    )


def emit(instructions: str, kind: Target | None = None) -> bytes:
    """Object code of instructions (LLVM's text), for a kind of processor (default: `target()`)."""
    machine = _machine(kind or target())
    module = llvm().parse_assembly(instructions)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    module.verify()
    options = llvm().create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization, options.slp_vectorization = True, False
    builder = llvm().create_pass_builder(machine, options)
    builder.getModulePassManager().run(module, builder)
    return machine.emit_object(module)


class Library:
    """Object code in memory, as long as this object lives.

    `outside` are addresses of functions that it calls by name.
    """

    def __init__(self, code: bytes, outside: dict[str, int] | None = None) -> None:
        for name, address in (outside or {}).items():
            llvm().add_symbol(name, address)
        # an engine of its own, which owns its machine, so that the code goes with this object
        self._engine = llvm().create_mcjit_compiler(llvm().parse_assembly(""), _machine(target()))
        self._engine.add_object_file(llvm().ObjectFileRef.from_data(code))
        self._engine.finalize_object()

    def address(self, name: str) -> int:
        """Address of a function; 0 where there is none of this name."""
        return self._engine.get_function_address(name)
