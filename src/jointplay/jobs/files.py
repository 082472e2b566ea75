"""Files that are there whole or not at all, and locks that end with their process."""

from __future__ import annotations

import glob
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from jointplay.display.errors import InputError, Problem
from jointplay.solver.codegen.place import gone

MOMENT = 10.0  # s without a block written


class Busy(InputError):
    """Another run of the same study is writing its journal."""


@contextmanager
def replaced(path: Path, flush: bool = True) -> Iterator[Path]:
    """Give a temporary name in the folder of `path`; on success move the file there, else remove it.

    Without `flush` it is there whole after a kill at any moment, but may not be after a power cut.
    """
    temporary = temporary_name(path)
    try:
        yield temporary
        if flush:
            _flush(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    with suppress(OSError):  # some file systems cannot sync a folder; the file itself is safe
        if flush:
            _flush(path.parent)


def temporary_name(path: Path) -> Path:
    """The temporary name of a file."""
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def clear_leftovers(path: Path) -> None:
    """Remove the temporary files that killed processes have left of a file.

    A file system may be shared with other machines, whose processes are not seen here: what was written to a
    moment ago stays.
    """
    for other in path.parent.glob(f".{glob.escape(path.name)}.*.tmp"):
        maker = other.name.removesuffix(".tmp").rpartition(".")[2]
        with suppress(OSError):
            if maker.isdecimal() and gone(int(maker)) and time.time() - other.stat().st_mtime > MOMENT:
                other.unlink()


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def lock(path: Path, shown: Path) -> Iterator[None]:
    """Hold a lock file until the block or the process ends; `Busy`, naming `shown`, where another has it."""
    try:
        import fcntl
    except ImportError:  # no POSIX: two runs at once are then not noticed
        yield
        return
    with open(path, "a+", errors="replace") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            expected = f"one run at a time is accepted; process {file.read().strip()} is running it"
            raise Busy([Problem("journal", str(shown), expected)]) from None
        file.truncate(0)
        file.write(f"{os.getpid()} on {os.uname().nodename}")
        file.flush()
        yield
