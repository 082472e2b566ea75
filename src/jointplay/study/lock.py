"""A lock that ends with its process, so that one run at a time writes a journal."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jointplay.errors import InputError, Problem


class Busy(InputError):
    """Another run of the same study is writing its journal."""


@contextmanager
def lock(path: Path, shown: Path) -> Iterator[None]:
    """Hold a lock, a file, until the block ends, or the process, however that ends.

    `shown` names in the message what is locked.

    Raises
    ------
    Busy
        When another process holds it.
    """
    try:
        import fcntl
    except ImportError:  # no POSIX: two runs at once are then not told apart
        yield
        return
    with open(path, "a+") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            expected = f"one run at a time is accepted; process {file.read().strip()} is at it"
            raise Busy([Problem("journal", str(shown), expected)]) from None
        file.truncate(0)
        file.write(f"{os.getpid()} on {os.uname().nodename}")
        file.flush()
        yield
