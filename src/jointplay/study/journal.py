"""The journal of a sweep: what is finished lies on the disk, part by part, before anything is put together.

A journal is a folder. ``journal.json`` says which code computed what is in it, ``lock`` is held by the run
that writes, and each file ``*.part`` holds finished cells, in frames. A part is written under a temporary
name and renamed, so that it is there whole or not at all; a frame that its checksum does not fit is left
aside and its cells run again. A cell is known by its key, the hash of all that decides its answer, so that a
study with further values finds those it has. Files ``*.at`` name the cells that workers are at.

Parts are pickles: a journal is a working folder of one's own, and not to be taken from strangers.
"""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any

from jointplay.analysis.words import STATUS
from jointplay.codegen import cache
from jointplay.errors import InputError, Problem
from jointplay.study import provenance
from jointplay.study.frames import FORMAT, Entry, Index, bodies, body_of, head_of, new_part, write_part
from jointplay.study.lock import Busy, lock
from jointplay.study.pack import unpacked
from jointplay.study.store import replaced

HEADER, LOCK = "journal.json", "lock"
KEY = 32  # letters of a key
ROOMS = ("analysis", "mechanism")  # beside those that the kernels' digest covers
CRASHED = STATUS.index("crashed")


def key_of(*parts: Any) -> str:
    """Hash of plain values; numbers by their shortest text that gives them back."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY]


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump_json"):
        return value.model_dump_json()
    return value.tolist() if hasattr(value, "tolist") else repr(value)


@lru_cache(maxsize=1)
def code() -> str:
    """Digest of all code that decides what a cell answers: kernels, analyses, mechanisms."""
    total = hashlib.sha256(cache.digest().encode())
    for room in ROOMS:
        for path in sorted((provenance.PACKAGE / room).rglob("*.py")):
            total.update(f"{path.relative_to(provenance.PACKAGE)}\n".encode() + path.read_bytes())
    return total.hexdigest()[:16]


class Journal:
    """Finished cells of a study on the disk.

    Parameters
    ----------
    folder : path-like
        Where; made by `held`.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self.damaged: set[str] = set()

    @contextmanager
    def held(self, fresh: bool = False) -> Iterator[Journal]:
        """Hold the journal for writing; `fresh`: drop what is in it.

        Raises
        ------
        InputError
            When another run holds it, or other code wrote it.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        with lock(self.folder / LOCK, self.folder):
            if fresh:
                self._drop(("*.part", "*.damaged", HEADER))
            self._drop((".*.tmp", "*.at"))
            self._check()
            yield self

    def _drop(self, patterns: Iterable[str]) -> None:
        for path in [path for pattern in patterns for path in self.folder.glob(pattern)]:
            path.unlink(missing_ok=True)

    def _check(self) -> None:
        """Refuse cells of other code; note what code this is where there is none yet."""
        path = self.folder / HEADER
        if not path.exists() and not any(self.folder.glob("*.part")):
            with replaced(path) as temporary:
                temporary.write_text(json.dumps(header(), indent=1), encoding="utf-8")
        self.check_code()

    def check_code(self) -> None:
        """Refuse a journal that other code wrote, as its cells could not be told from this code's."""
        found, own = self.header(), {"kernel_digest": cache.digest(), "code": code(), "format": FORMAT}
        if any(found.get(each) != own[each] for each in ("code", "format")):
            expected = (
                f"cells of the same code are accepted ({_which(own)}); these were computed by another "
                f"({_which(found)}); `jointplay run --fresh` drops them, and --out DIR leaves them where "
                "they are"
            )
            raise InputError([Problem("journal", str(self.folder), expected)])

    def header(self) -> dict[str, Any]:
        """What wrote the journal; empty where that cannot be read."""
        try:
            found = json.loads((self.folder / HEADER).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}
        return found if isinstance(found, dict) else {}

    def parts(self) -> list[Path]:
        """Files of finished cells."""
        return sorted(self.folder.glob("*.part"))

    def count(self) -> int:
        """Cells that are written, by the names of the parts alone."""
        names = (name for name in os.listdir(self.folder) if name.endswith(".part"))
        return sum(int(name.split("-")[0]) for name in names)

    def index(self) -> dict[str, int]:
        """Status of each finished cell by its key; what is damaged is left out, and named in `damaged`."""
        found: dict[str, int] = {}
        for told, _ in self._sound():
            found |= {key: status for key, status in told if key not in found}
        return found

    def answers(self, keys: Iterable[str]) -> Iterator[tuple[str, Entry]]:
        """Go through the answers of the cells with these keys, as far as they are there: each once."""
        left = set(keys)
        for told, stream in self._sound():
            mine = left.intersection(key for key, _ in told)
            if mine:
                left -= mine
                both = zip(told, unpacked(*pickle.load(stream)), strict=True)
                yield from ((key, answer) for (key, _), answer in both if key in mine)

    def load(self, keys: Iterable[str]) -> dict[str, Entry]:
        """Answers of the cells with these keys, as far as they are there."""
        return dict(self.answers(keys))

    def _sound(self) -> Iterator[tuple[Index, BytesIO]]:
        """Index of each frame that is sound, and the rest of it."""
        for path in self.parts():
            for body in bodies(path, self.damaged):
                stream = BytesIO(body)
                yield pickle.load(stream), stream

    def write(self, entries: Mapping[str, Entry]) -> None:
        """Add a part."""
        if entries:
            write_part(self.folder, entries)

    def take(self, other: Journal, keys: Iterable[str]) -> set[str]:
        """Add the cells with these keys of another journal, as far as they are there; which there were."""
        wanted = other.index().keys() & set(keys)
        if wanted:
            with replaced(new_part(self.folder, len(wanted))) as temporary, open(temporary, "wb") as file:
                for body in other._only(wanted):
                    file.write(head_of(body))
                    file.write(body)
        return wanted

    def _only(self, wanted: set[str]) -> Iterator[bytes]:
        """Bodies with the cells of these keys: as they are, where no other cell is in them."""
        left = set(wanted)
        for told, stream in self._sound():
            mine = left.intersection(key for key, _ in told)
            left -= mine
            if len(mine) == len(told):
                yield stream.getvalue()
            elif mine:
                both = zip(told, unpacked(*pickle.load(stream)), strict=True)
                yield body_of({key: answer for (key, _), answer in both if key in mine})

    def keep_only(self, keys: Iterable[str]) -> None:
        """Make one part of what is there, without the cells of other keys and what is damaged.

        A run that is killed here leaves cells twice, with the same answers, or some that it meant to drop.
        """
        old = self.parts()
        self.take(self, keys)
        for path in old:
            path.unlink(missing_ok=True)

    def compact(self) -> None:
        """Make one part of many."""
        if len(self.parts()) > 1 or self.damaged:
            self.keep_only(self.index())

    def in_flight(self) -> list[str]:
        """Keys of the cells that workers were at when they ended without a word; forgotten hereby."""
        found = []
        for path in sorted(self.folder.glob("*.at")):
            found.append(path.read_text().strip())
            path.unlink(missing_ok=True)
        return [key for key in found if key]

    def writer(self) -> str | None:
        """Who holds the journal now; None if nobody does."""
        path = self.folder / LOCK
        try:
            with lock(path, self.folder):
                return None
        except Busy:
            with suppress(OSError):
                return path.read_text().strip()
            return "unknown"
        except OSError:
            return None

    def remove(self) -> None:
        """Delete the whole folder."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _which(told: Mapping[str, Any]) -> str:
    names = {"kernels": "kernel_digest", "code": "code", "format": "format"}
    return ", ".join(f"{name} {told.get(key, 'unknown')}" for name, key in names.items())


def refuse_lost(count: int) -> None:
    """Raise an `OSError` where the answers of some cells are not there."""
    if count:
        raise OSError(f"the answers of {count} cells cannot be read back; run again")


def header() -> dict[str, Any]:
    """What a journal says of the code that computed its cells."""
    software = {"version": provenance.version("jointplay"), "git": provenance.git_describe()}
    told = {"format": FORMAT, "kernel_digest": cache.digest(), "code": code()}
    return told | {"software": software, "environment": provenance.environment()}
