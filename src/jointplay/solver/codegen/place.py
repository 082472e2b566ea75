"""Folders and files of compiled code, and the checks by which they are believed.

What lies there is run: a folder is used only if it is this user's and nobody else can write there. Every file
opens with a seal, the hash of its name and content. One that was cut, altered, swapped or put there by
somebody else is not read any further: it is removed with a line, and whoever asked for it makes it anew.

A file is complete and on the disk before its name shows. Waiting for the disk would lengthen a first run by
some percent, so threads of their own do, one after the other; until then a file is read from memory.

Digest of all that decides compiled code: its sources, and the versions and flags that shape it.

Numba notices an edit in a function's own file only, and would answer with stale numbers after an edit
elsewhere. So everything that decides is digested, laws that other packages publish among it, and what is
compiled lies in a folder of that name: an edit is another folder.

Upkeep of the kernel cache, for the verb ``cache``: list, verify and remove compiled code.

Machine code: instructions into object code, object code into functions by address.

Nothing here knows numba. The processor is this machine's, or the one that $NUMBA_CPU_NAME and
$NUMBA_CPU_FEATURES name; instructions are optimised as numba does it: loops are vectorised, straight lines
not (which would change last digits).
"""

from __future__ import annotations

import atexit
import hashlib
import logging
import os
import platform
import re
import shutil
import stat
import sys
import tempfile
import time
from contextlib import suppress
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from threading import Lock, Thread
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

from ...display.errors import InputError, Problem
from ..extensions import code_files, packages

if TYPE_CHECKING:
    import llvmlite.binding

HANDED = "JOINTPLAY_KERNELS"  # a folder for the processes that this one starts
PREFIX = "kernel cache: "
TEMPORARY = "jointplay-kernels-"  # how folders of one run are named, before the number of its process
POSIX = hasattr(os, "geteuid")  # elsewhere a user's folders are closed to others, and modes say nothing
_user = getattr(os, "geteuid", lambda: 0)
_pending: dict[str, bytes] = {}
_last = Thread()  # the last of the threads that write
_lock = Lock()
SOURCES = ("equations", "codegen", "method")
FLAGS = (
    *("NUMBA_BOUNDSCHECK", "NUMBA_OPT", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_DISABLE_JIT"),
    *("NUMBA_LOOP_VECTORIZE", "NUMBA_SLP_VECTORIZE", "NUMBA_ENABLE_AVX", "NUMBA_DISABLE_INTEL_SVML"),
)
SETTINGS = ".numba_config.yaml"  # of the current folder: numba reads flags there as well
ABANDONED = 3600.0  # s after which nobody goes on writing a file


class UnsoundError(Exception):
    """A file is not as it was written; the text says why."""


@cache
def compiling(what: str) -> None:
    """Log that something is compiled which later runs only load; of each thing once."""
    logging.getLogger("jointplay").info("compiling, once: later runs take seconds")


@cache
def say(line: str) -> None:
    """Print a line for the user of the kernel cache, on stderr; the same only once."""
    if sys.stderr is not None:
        sys.stderr.write(f"{PREFIX}{line}\n")


def root() -> Path:
    """The folder of all digests: $JOINTPLAY_CACHE, else below $NUMBA_CACHE_DIR or the user's cache folder.

    Raises
    ------
    InputError
        When $JOINTPLAY_CACHE is empty.
    OSError
        When there is no home folder.
    """
    if (named := os.environ.get("JOINTPLAY_CACHE")) is not None:
        if not named:
            raise InputError([Problem("JOINTPLAY_CACHE", named, "a folder is accepted; unset: the default")])
        return Path(named).absolute()
    if above := os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME"):
        return Path(above).absolute() / "jointplay"
    try:
        return Path.home() / ".cache" / "jointplay"
    except RuntimeError as error:
        raise OSError(str(error)) from None


@lru_cache(maxsize=1)
def folder() -> Path:
    """The folder of this digest, of this user alone; a temporary one, and a line, where it cannot be had."""
    handed = Path(os.environ.get(HANDED, ""))
    if handed.name == digest() and handed.is_dir() and not fault(handed):
        return handed
    try:
        return _below(root())
    except OSError as error:
        return _temporary(error)


def _below(top: Path) -> Path:
    """Make the folder of this digest; raise OSError where others could change it, or it cannot be written."""
    top.mkdir(0o700, parents=True, exist_ok=True)
    if "JOINTPLAY_CACHE" not in os.environ and top.stat().st_uid == _user():
        top.chmod(0o700)  # named by us; earlier versions left its mode to chance
    if wrong := fault(top.resolve(), shared=True):
        raise PermissionError(f"{top} {wrong}")
    place = top / digest()
    if os.path.lexists(place) and (wrong := fault(place) or ("" if place.is_dir() else "is no folder")):
        discard(place, wrong)
    place.mkdir(0o700, exist_ok=True)
    if wrong := fault(place):
        raise PermissionError(f"{place} {wrong}")
    with tempfile.TemporaryFile(dir=place):
        return place


def _temporary(error: OSError) -> Path:
    for other in Path(tempfile.gettempdir()).glob(f"{TEMPORARY}*-*"):
        maker = other.name.removeprefix(TEMPORARY).partition("-")[0]
        if maker.isdecimal() and gone(int(maker)) and not fault(other):  # it was killed
            shutil.rmtree(other, ignore_errors=True)
    top = Path(tempfile.mkdtemp(prefix=f"{TEMPORARY}{os.getpid()}-"))
    atexit.register(_forget, top, os.getpid())
    place = top / digest()
    place.mkdir(0o700)
    os.environ[HANDED] = str(place)
    say(f"{error}; kernels are compiled for this run alone")
    return place


def gone(process: int) -> bool:
    """Whether a process of this machine has ended, where one may ask; one of another user is there."""
    if not POSIX:  # where the question below would end it
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except (OSError, OverflowError):
        pass
    return False


def _forget(top: Path, maker: int) -> None:
    if os.getpid() == maker:  # and not a fork of it
        shutil.rmtree(top, ignore_errors=True)


def fault(path: Path, shared: bool = False) -> str:
    """Say why the file at a path may be somebody else's, or lead to one; empty if it is this user's alone.

    Parameters
    ----------
    path : Path
        A folder or file.
    shared : bool
        Whether others may use the folder as well, as they do the one for temporary files.
    """
    facts = path.lstat()
    if stat.S_ISLNK(facts.st_mode):
        return "is a link"
    if not POSIX:
        return ""
    if facts.st_uid not in {_user(), 0 if shared else _user()}:
        return f"belongs to another user ({facts.st_uid})"
    sticky = shared and facts.st_mode & stat.S_ISVTX
    return "can be written by others (chmod go-w)" if facts.st_mode & 0o022 and not sticky else ""


def discard(path: Path, why: object) -> None:
    """Remove an unusable file, and say so."""
    say(f"{path} {why}; it is removed and made anew")
    with suppress(OSError):
        remove(path)


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all in it."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def content(path: Path) -> bytes:
    """Content of a file, behind its seal.

    Raises
    ------
    UnsoundError
        When it is not what was written under this name.
    OSError
        When it cannot be read.
    """
    if wrong := fault(path):
        raise UnsoundError(wrong)
    if not path.is_file():
        raise UnsoundError("is no file")
    seal, _, rest = path.read_bytes().partition(b"\n")
    if seal != _seal(path.name, rest):
        raise UnsoundError("is damaged")
    return rest


def _seal(name: str, data: bytes) -> bytes:
    """A comment of Python, so that sources may have it too."""
    return b"# " + hashlib.sha256(f"{digest()}/{name}\n".encode() + data).hexdigest().encode()


def read(name: str) -> bytes | None:
    """Content that was written under a name; None where there is none, or another."""
    if (data := _pending.get(name)) is not None:
        return data
    return believed(folder() / name)


def believed(path: Path) -> bytes | None:
    """Content of a file that is as it was written; any other is removed."""
    try:
        return content(path)
    except FileNotFoundError:
        return None
    except UnsoundError as wrong:
        discard(path, wrong)
    except OSError as error:
        discard(path, f"cannot be read ({error.strerror})")
    return None


def write(name: str, data: bytes) -> None:
    """Keep a file, for this process at once and for others as soon as it is on the disk."""
    global _last
    with _lock:
        _pending[name] = data
        _last = Thread(target=_deliver, args=(name, data, _last))
        _last.start()


def settle() -> None:
    """Wait until all that was written can be read by others."""
    if _last.ident is not None:
        _last.join()


def _deliver(name: str, data: bytes, before: Thread) -> None:
    if before.ident is not None:
        before.join()
    try:
        try:
            _put(folder() / name, data)
        except FileNotFoundError:  # the folder was removed meanwhile, as by `cache prune --all`
            folder.cache_clear()
            _put(folder() / name, data)
    except OSError as error:  # the file stays in memory
        say(f"{folder()} cannot be written ({error.strerror}); the next run compiles again")
        return
    with _lock:
        if _pending.get(name) is data:
            del _pending[name]


def _put(path: Path, data: bytes) -> None:
    """Write whole: by a temporary name and a rename, both of them on the disk when it is over."""
    file = tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False)  # noqa: SIM115 (moved closed)
    try:
        with file:
            file.write(_seal(path.name, data) + b"\n" + data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(file.name, path)
    except BaseException:
        os.unlink(file.name)
        raise
    flush_names(path.parent)


def flush_names(folder: Path) -> None:
    """Have the names in a folder on the disk, where the system can do that."""
    with suppress(OSError):
        above = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(above)
        finally:
            os.close(above)


@lru_cache(maxsize=1)
def digest() -> str:
    """Digest of every source, version and flag that shapes compiled code (16 hexadecimal digits)."""
    solver, total = Path(__file__).parent.parent, hashlib.sha256()
    for room in SOURCES:
        for path in sorted((solver / room).rglob("*.py")):
            total.update(f"{path.relative_to(solver)}\n".encode() + path.read_bytes())
    for name, place in sorted(packages("jointplay.laws", "jointplay.frictions").items()):
        for path in code_files(place):
            total.update(f"{name} {path.relative_to(place.parent)}\n".encode() + path.read_bytes())
    versions = [f"{name} {_version(name)}" for name in ("numba", "llvmlite", "numpy", "sympy")]
    flags = [f"{name}={os.environ.get(name, '')}" for name in FLAGS]
    total.update("\n".join([*versions, *flags, platform.machine(), sys.version]).encode())
    if os.path.isfile(SETTINGS):
        total.update(Path(SETTINGS).read_bytes())
    return total.hexdigest()[:16]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"


def entries() -> list[str]:
    """List the digests in the cache with their size; the one in use is marked."""
    result = []
    for there in _digests():
        size = sum(path.stat().st_size for path in there.rglob("*") if path.is_file())
        mark = "in use" if there.name == digest() else "old"
        result.append(f"{there.name}  {size / 1e6:6.1f} MB  {mark}")
    return result


def prune(everything: bool = False) -> list[str]:
    """Delete the folders of all digests but the one in use, or of that too; give back their names."""
    removed = []
    for there in _digests():
        if there.name == digest() and not everything:
            continue
        try:
            remove(there)
            removed.append(there.name)
        except OSError as error:
            say(f"not removed: {error}")
    return removed


def verify() -> tuple[int, int]:
    """Check every file in use, and remove any that is not as it was written.

    Returns
    -------
    sound, removed : int
        How many files.
    """
    sound = removed = 0
    for path in sorted(folder().iterdir()):
        if path.suffix == ".tmp":  # of a process that writes, or was killed when it did
            if path.lstat().st_mtime < time.time() - ABANDONED:
                discard(path, "was never finished")
        elif believed(path) is not None:
            sound += 1
        else:
            removed += 1
    return sound, removed


def _digests() -> list[Path]:
    """Folders that are named as digests are; nothing else below the root is ours."""
    return sorted(there for there in root().glob("*") if re.fullmatch("[0-9a-f]{16}", there.name))


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
