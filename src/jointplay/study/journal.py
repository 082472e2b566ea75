"""The journal of a sweep: what is finished lies on the disk, part by part, before anything is put together.

A journal is a folder. ``journal.json`` says which code computed what is in it, ``lock`` is held by the run
that writes, and each file ``*.part`` holds some finished cells: a line, a SHA-256 checksum, an index (key
and status of each cell) and the answers. A part is written under a temporary name, flushed and renamed, so
that it is there whole or not at all; one that its checksum does not fit is left aside and its cells run
again. A cell is known by its key, the hash of all that decides its answer, so that a study with further
values finds those it has. Files ``*.at`` name the cells that workers are at.

Parts are pickles: a journal is a working folder of one's own, and not to be taken from strangers.
"""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import shutil
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from jointplay.analysis.words import STATUS
from jointplay.codegen import cache
from jointplay.errors import InputError, Problem
from jointplay.study import provenance
from jointplay.study.store import replaced

FORMAT = 1
MAGIC = b"jointplay journal part 1\n"
HEADER, LOCK = "journal.json", "lock"
ROOMS = ("analysis", "mechanism")  # beside those that the kernels' digest covers
CRASHED = STATUS.index("crashed")
Entry = dict[str, Any]


class Busy(InputError):
    """Another run of the same study is writing its journal."""


def key_of(*parts: Any) -> str:
    """Hash of plain values; numbers by their shortest text that gives them back."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), default=_plain)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump"):
        return value.model_dump(mode="json")
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
        with _lock(self.folder / LOCK, self.folder):
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
        found = self.header()
        if found.get("code") != code():
            told = found.get("kernel_digest", "unknown")
            expected = (
                f"cells of the same code are accepted (kernels {cache.digest()}, code {code()}); these were "
                f"computed by another (kernels {told}); `jointplay run --fresh` drops them, and --out DIR "
                "leaves them where they are"
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
        return sum(int(path.name.split("-")[0]) for path in self.parts())

    def index(self) -> dict[str, int]:
        """Status of each finished cell by its key; what is damaged is left out, and named in `damaged`."""
        found: dict[str, int] = {}
        for stream in self._sound():
            found |= dict(pickle.load(stream))
        return found

    def load(self, keys: Iterable[str]) -> dict[str, Entry]:
        """Answers of the cells with these keys, as far as they are there."""
        wanted, found = set(keys), {}
        for stream in self._sound():
            there = [key for key, _ in pickle.load(stream)]
            if wanted.intersection(there):
                answers = zip(there, pickle.load(stream), strict=True)
                found |= {key: answer for key, answer in answers if key in wanted}
        return found

    def _sound(self) -> Iterator[BinaryIO]:
        for path in self.parts():
            content = path.read_bytes()
            start = len(MAGIC) + 32
            body = content[start:]
            if MAGIC + hashlib.sha256(body).digest() == content[:start]:
                yield BytesIO(body)
            else:
                self.damaged.add(path.name)

    def write(self, entries: Mapping[str, Entry]) -> None:
        """Add a part."""
        if entries:
            write_part(self.folder, entries)

    def keep_only(self, keys: Iterable[str]) -> None:
        """Rewrite what is there as one part, without the cells of other keys and what is damaged.

        A run that is killed here leaves cells twice, with the same answers, or some that it meant to drop.
        """
        old, entries = self.parts(), self.load(keys)
        self.write(entries)
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
            found.append(path.read_text())
            path.unlink(missing_ok=True)
        return [key for key in found if key]

    def writer(self) -> str | None:
        """Who holds the journal now; None if nobody does."""
        path = self.folder / LOCK
        try:
            with _lock(path, self.folder):
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


def header() -> dict[str, Any]:
    """What a journal says of the code that computed its cells."""
    software = {"version": provenance.version("jointplay"), "git": provenance.git_describe()}
    told = {"format": FORMAT, "kernel_digest": cache.digest(), "code": code()}
    return told | {"software": software, "environment": provenance.environment()}


def write_part(folder: Path, entries: Mapping[str, Entry]) -> None:
    """Write finished cells as one part, whole or not at all."""
    stream = BytesIO()
    pickle.dump([(key, int(answer["status"])) for key, answer in entries.items()], stream, protocol=5)
    pickle.dump(list(entries.values()), stream, protocol=5)
    body = stream.getvalue()
    with replaced(folder / f"{len(entries)}-{uuid.uuid4().hex}.part") as temporary:
        temporary.write_bytes(MAGIC + hashlib.sha256(body).digest() + body)


@contextmanager
def _lock(path: Path, shown: Path) -> Iterator[None]:
    """Hold a lock that ends with the process, however that ends."""
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
