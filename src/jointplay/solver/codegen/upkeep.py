"""Upkeep of the kernel cache, for the verb ``cache``: list, verify and remove compiled code."""

from __future__ import annotations

import re
import time
from pathlib import Path

from . import place
from .digest import digest

ABANDONED = 3600.0  # s after which nobody goes on writing a file


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
            place.remove(there)
            removed.append(there.name)
        except OSError as error:
            place.say(f"not removed: {error}")
    return removed


def verify() -> tuple[int, int]:
    """Check every file in use, and remove any that is not as it was written.

    Returns
    -------
    sound, removed : int
        How many files.
    """
    sound = removed = 0
    for path in sorted(place.folder().iterdir()):
        if path.suffix == ".tmp":  # of a process that writes, or was killed when it did
            if path.lstat().st_mtime < time.time() - ABANDONED:
                place.discard(path, "was never finished")
        elif place.believed(path) is not None:
            sound += 1
        else:
            removed += 1
    return sound, removed


def _digests() -> list[Path]:
    """Folders that are named as digests are; nothing else below the root is ours."""
    return sorted(there for there in place.root().glob("*") if re.fullmatch("[0-9a-f]{16}", there.name))
