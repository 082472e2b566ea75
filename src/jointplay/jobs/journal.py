"""The journal of a sweep: what is finished lies on the disk, part by part, before anything is put together.

A journal is a folder. ``journal.json`` says which code computed what is in it, ``lock`` is held by the run
that writes, and each file ``*.part`` holds finished cells, in frames. A part is written under a temporary
name and renamed, so that it is there whole or not at all; a frame that its checksum does not fit, or that
other code computed, is left aside and its cells run again. A cell is known by its key, the hash of all that
decides its answer, so that a study with further values finds those it has. Files ``*.at`` name the cells that
workers are at. Files of other names are somebody else's, and stay as they are.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from jointplay.codegen import cache
from jointplay.errors import InputError, Problem
from jointplay.jobs import origin
from jointplay.jobs.files import Busy, lock, replaced
from jointplay.jobs.frames import FORMAT, Frame, body_of, frames, head_of, new_part, write_part
from jointplay.jobs.job import Entry

HEADER, LOCK = "journal.json", "lock"
PART, AT = r"(\d+)-[0-9a-f]{32}\.part", r"\d+-[0-9a-f]{8}\.at"
TEMPORARY = rf"\.({PART}|{re.escape(HEADER)})\.\d+\.tmp"
SHOWN = 8  # names of files


class Journal:
    """Finished cells of a study on the disk.

    Parameters
    ----------
    folder : path-like
        Where; made by `held`.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self.damaged: set[str] = set()  # parts, in the whole or in frames
        self.foreign: set[str] = set()  # parts with frames of other code
        self.processors: dict[str, str] = {}  # on what kind each cell ran

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
            for path in self._files(f"{TEMPORARY}|{AT}" + (f"|{PART}|{re.escape(HEADER)}" if fresh else "")):
                path.unlink(missing_ok=True)
            self._check()
            yield self

    def _files(self, names: str) -> list[Path]:
        """Files of the folder whose whole names are such."""
        there = os.listdir(self.folder) if self.folder.is_dir() else ()
        paths = (self.folder / name for name in sorted(there) if re.fullmatch(names, name))
        return [path for path in paths if path.is_file()]

    def strangers(self) -> list[str]:
        """Names of what lies in the folder and is no file of a journal."""
        own = {path.name for path in self._files(f"{TEMPORARY}|{AT}|{PART}|{re.escape(HEADER)}|{LOCK}")}
        return sorted({*os.listdir(self.folder)} - own) if self.folder.is_dir() else []

    def notes(self, keys: Iterable[str]) -> Iterator[str]:
        """Say, in a line each, what is strange about the journal and the cells with these keys."""
        aside = {
            "damaged part(s) left aside, their cells run again": self.damaged,
            "part(s) of other code left aside": self.foreign,
            "file(s) ignored that no journal has": self.strangers(),
        }
        for told, names in aside.items():
            if names:
                more = ", ..." if len(names) > SHOWN else ""
                yield f"{len(names)} {told}: {', '.join(sorted(names)[:SHOWN])}{more}"
        if told := origin.mixed(self.kinds(keys)):
            yield told

    def kinds(self, keys: Iterable[str]) -> set[str]:
        """Kinds of processors on which the cells with these keys ran, as far as they have been seen."""
        return {self.processors[key] for key in keys if key in self.processors}

    def _check(self) -> None:
        """Refuse cells of other code; note what code this is where there is none yet."""
        path = self.folder / HEADER
        if not path.exists() and not self.parts():
            with replaced(path) as temporary:
                temporary.write_text(json.dumps(header(), indent=1), encoding="utf-8")
        self.check_code()

    def check_code(self) -> None:
        """Refuse a journal that other code wrote, as its cells could not be told from this code's."""
        if expected := self.other_code():
            raise InputError([Problem("journal", str(self.folder), expected)])

    def other_code(self) -> str | None:
        """Say that other code wrote the journal; None if this did, or if there is none."""
        found, own = self.header(), {"kernel_digest": cache.digest(), "code": origin.code(), "format": FORMAT}
        if not self.folder.exists() or all(found.get(each) == own[each] for each in ("code", "format")):
            return None
        return (
            f"cells of the same code are accepted ({_which(own)}); these were computed by another "
            f"({_which(found)}); `jointplay run --fresh` drops them, and --out DIR leaves them where they are"
        )

    def header(self) -> dict[str, Any]:
        """What wrote the journal; empty where that cannot be read."""
        try:
            found = json.loads((self.folder / HEADER).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return {}
        return found if isinstance(found, dict) else {}

    def parts(self) -> list[Path]:
        """Files of finished cells."""
        return self._files(PART)

    def count(self) -> int:
        """Cells that are written, by the names of the parts alone."""
        found = (re.fullmatch(PART, name) for name in os.listdir(self.folder))
        return sum(int(each[1]) for each in found if each)

    def index(self) -> dict[str, int]:
        """Status of each finished cell by its key; what is damaged is left out, and named in `damaged`."""
        found: dict[str, int] = {}
        for frame in self._sound():
            found |= {key: status for key, status in frame.index.items() if key not in found}
        return found

    def answers(self, keys: Iterable[str]) -> Iterator[tuple[str, Entry]]:
        """Go through the answers of the cells with these keys, as far as they are there: each once."""
        left = set(keys)
        for frame in self._sound():
            if mine := left & frame.index.keys():
                found = [pair for pair in frame.answers() if pair[0] in mine]
                left -= mine
                yield from found

    def load(self, keys: Iterable[str]) -> dict[str, Entry]:
        """Answers of the cells with these keys, as far as they are there."""
        return dict(self.answers(keys))

    def _sound(self) -> Iterator[Frame]:
        """Each frame that is sound and of this code."""
        for path in self.parts():
            for frame in frames(path, self.damaged):
                if frame.origin.code != origin.code():
                    self.foreign.add(path.name)
                    continue
                for key in frame.index:
                    self.processors[key] = frame.origin.processor
                yield frame

    def write(self, entries: Mapping[str, Entry], by: origin.Origin | None = None) -> None:
        """Add a part; this process computed it, unless another origin is given."""
        if entries:
            write_part(self.folder, entries, by)

    def take(self, other: Journal, keys: Iterable[str]) -> set[str]:
        """Add the cells with these keys of another journal, as far as they are there; which there were."""
        wanted = other.index().keys() & set(keys)
        if wanted:
            with replaced(new_part(self.folder, len(wanted))) as temporary, open(temporary, "wb") as file:
                for body in other._only(wanted):
                    file.write(head_of(body))
                    file.write(body)
        return wanted

    def _only(self, wanted: set[str]) -> Iterator[bytes | bytearray]:
        """Bodies with the cells of these keys: as they are, where no other cell is in them."""
        left = set(wanted)
        for frame in self._sound():
            mine = left & frame.index.keys()
            left -= mine
            if len(mine) == len(frame.index):
                yield frame.body
            elif mine:
                yield body_of({key: each for key, each in frame.answers() if key in mine}, frame.origin)

    def keep_only(self, keys: Iterable[str]) -> None:
        """Make one part of what is there, without the cells of other keys and what is damaged.

        Parts of other code stay, as they are not this code's to drop.
        A run that is killed here leaves cells twice, with the same answers, or some that it meant to drop.
        """
        old = self.parts()
        self.take(self, keys)
        for path in old:
            if path.name not in self.foreign:
                path.unlink(missing_ok=True)

    def compact(self) -> None:
        """Make one part of many."""
        if len(self.parts()) > 1 or self.damaged:
            self.keep_only(self.index())

    def in_flight(self) -> list[str]:
        """Keys of the cells that workers were at when they ended without a word; forgotten hereby."""
        found = []
        for path in self._files(AT):
            found.append(path.read_text(errors="replace").strip())
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
                return path.read_text(errors="replace").strip()
            return "unknown"
        except OSError:
            return None


def _which(told: Mapping[str, Any]) -> str:
    names = {"kernels": "kernel_digest", "code": "code", "format": "format"}
    return ", ".join(f"{name} {told.get(key, 'unknown')}" for name, key in names.items())


def refuse_lost(count: int) -> None:
    """Raise an `OSError` where the answers of some cells are not there."""
    if count:
        raise OSError(f"the answers of {count} cells cannot be read back; run again")


def header() -> dict[str, Any]:
    """What a journal says of the code that computed its cells."""
    software = {"version": origin.version("jointplay"), "git": origin.git_describe()}
    told = {"format": FORMAT, "kernel_digest": cache.digest(), "code": origin.code()}
    return told | {"software": software, "environment": origin.environment()}
