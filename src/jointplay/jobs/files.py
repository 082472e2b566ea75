"""Files that are there whole or not at all, and locks that end with their process."""

from __future__ import annotations

import glob
import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from jointplay.display.errors import InputError, Problem
from jointplay.solver.codegen.place import flush_names, gone

MOMENT = 10.0  # s without a block written
UNREAD = 1 << 20  # byte of a lock file beyond its text


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
            with open(temporary, "r+b") as file:  # Windows flushes only what may be written
                os.fsync(file.fileno())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    if flush:
        flush_names(path.parent)


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


@contextmanager
def lock(path: Path, shown: Path) -> Iterator[None]:
    """Hold a lock file until the block or the process ends; `Busy`, naming `shown`, where another has it."""
    with open(path, "a+", encoding="utf-8", errors="replace") as file:
        try:
            _take(file.fileno())
        except (BlockingIOError, PermissionError):
            file.seek(0)
            expected = f"one run at a time is accepted; process {file.read().strip()} is running it"
            raise Busy([Problem("journal", str(shown), expected)]) from None
        file.truncate(0)
        file.write(f"{os.getpid()} on {platform.node()}")
        file.flush()
        yield


def _take(file: int) -> None:
    """Lock an open file until it is closed; raise where another process has it."""
    try:
        import fcntl
    except ImportError:
        import msvcrt  # of Windows, where a byte that is locked cannot be read: one that nobody reads

        os.lseek(file, UNREAD, os.SEEK_SET)
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
    else:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
