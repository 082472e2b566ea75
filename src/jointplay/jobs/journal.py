"""The journal of a study: finished cells on the disk, part by part.

A journal is a folder. ``journal.json`` says which code computed what is in it, ``lock`` is held by the run
that writes, and each file ``*.part`` holds finished cells, in frames. A part is written under a temporary
name and renamed, so that it is there whole or not at all; a frame that its checksum does not fit, or that
other code computed, is left aside and its cells run again. A cell is known by its key, the hash of all that
decides its answer, so that a study with further values finds those it has. Files ``*.at`` name the cells that
workers are at. Files of other names are somebody else's, and stay as they are.

Frames, of which a part of the journal consists, each with a checksum.

A frame is a line, the length of its body (8 bytes), a SHA-256 checksum of both, and the body: two values
(`jointplay.jobs.values`), the index (who computed it; key and status of each cell) and the answers. Frames
stand one after another, so that parts are joined by joining their bytes, and one that is damaged does not
touch the others.
"""

from __future__ import annotations

import hashlib
import json
import mmap
import os
import re
import uuid
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from jointplay.display.errors import InputError, Problem
from jointplay.jobs import origin, values
from jointplay.jobs.columns import packed, unpacked
from jointplay.jobs.files import Busy, lock, replaced
from jointplay.jobs.job import CRASHED, KEY, Entry, Job, remaining
from jointplay.jobs.origin import Origin, own
from jointplay.solver.codegen import cache
from jointplay.solver.method.codes import Status

HEADER, LOCK = "journal.json", "lock"
PART, AT = r"(\d+)-[0-9a-f]{32}\.part", r"\d+-[0-9a-f]{8}\.at"
TEMPORARY = rf"\.({PART}|{re.escape(HEADER)})\.\d+\.tmp"
SHOWN = 8  # names of files in a line
DIED = "the worker process died twice at this cell, as when memory runs out"

FORMAT = 3
MAGIC = f"jointplay journal part {FORMAT}\n".encode()
HEAD = len(MAGIC) + 8 + 32  # bytes before a body
BROKEN = (ValueError, TypeError, LookupError, AttributeError)  # what bytes that are no frame may raise


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
        """Hold the journal for writing; `fresh`: drop its content.

        `InputError` where another run holds it, or other code wrote it.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        with lock(self.folder / LOCK, self.folder):
            for path in self._files(f"{TEMPORARY}|{AT}" + (f"|{PART}|{re.escape(HEADER)}" if fresh else "")):
                path.unlink(missing_ok=True)
            self._check()
            yield self

    def _files(self, names: str) -> list[Path]:
        """Files of the folder whose whole names match a pattern."""
        there = os.listdir(self.folder) if self.folder.is_dir() else ()
        paths = (self.folder / name for name in sorted(there) if re.fullmatch(names, name))
        return [path for path in paths if path.is_file()]

    def unknown_files(self) -> list[str]:
        """Names in the folder that no file of a journal has."""
        own = {path.name for path in self._files(f"{TEMPORARY}|{AT}|{PART}|{re.escape(HEADER)}|{LOCK}")}
        return sorted({*os.listdir(self.folder)} - own) if self.folder.is_dir() else []

    def notes(self, keys: Iterable[str]) -> Iterator[str]:
        """Lines about damaged, foreign and unknown files, and about the cells with these keys."""
        aside = {
            "damaged part(s) set aside; their cells run again": self.damaged,
            "part(s) of other code set aside": self.foreign,
            "file(s) ignored that are no part of a journal": self.unknown_files(),
        }
        for reason, names in aside.items():
            if names:
                more = ", ..." if len(names) > SHOWN else ""
                yield f"{len(names)} {reason}: {', '.join(sorted(names)[:SHOWN])}{more}"
        if line := origin.mixed(self.kinds(keys)):
            yield line

    def kinds(self, keys: Iterable[str]) -> set[str]:
        """Kinds of processors on which the cells with these keys ran, as far as they have been seen."""
        return {self.processors[key] for key in keys if key in self.processors}

    def _check(self) -> None:
        """Write the header of a new journal; refuse one of other code."""
        path = self.folder / HEADER
        if not path.exists() and not self.parts():
            with replaced(path) as temporary:
                temporary.write_text(json.dumps(header(), indent=1), encoding="utf-8")
        self.check_code()

    def check_code(self) -> None:
        """Refuse a journal of other code, whose cells could not be distinguished from this code's."""
        if expected := self.other_code():
            raise InputError([Problem("journal", str(self.folder), expected)])

    def other_code(self) -> str | None:
        """Message on a journal that other code wrote; None if this code did, or if there is none."""
        found, own = self.header(), _code()
        if not self.folder.exists() or all(found.get(key) == own[key] for key in ("code", "format")):
            return None
        return (
            f"cells of the same code are accepted ({_shown(own)}); these were computed by another "
            f"({_shown(found)}); `jointplay run --fresh` drops them, and --out DIR leaves them where they are"
        )

    def header(self) -> dict[str, Any]:
        """The journal's own file on the code that wrote it; empty where it cannot be read."""
        try:
            header = json.loads((self.folder / HEADER).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return {}
        return header if isinstance(header, dict) else {}

    def parts(self) -> list[Path]:
        """Files of finished cells."""
        return self._files(PART)

    def count(self) -> int:
        """Number of cells that are written, by the names of the parts alone."""
        matches = (re.fullmatch(PART, name) for name in os.listdir(self.folder))
        return sum(int(match[1]) for match in matches if match)

    def index(self) -> dict[str, int]:
        """Status of each finished cell by its key; damaged parts are left out, and named in `damaged`."""
        index: dict[str, int] = {}
        for frame in self._sound():
            index |= {key: status for key, status in frame.index.items() if key not in index}
        return index

    def answers(self, keys: Iterable[str]) -> Iterator[tuple[str, Entry]]:
        """Answers of the cells with these keys, as far as they are there: each once."""
        left = set(keys)
        for frame in self._sound():
            if mine := left & frame.index.keys():
                answers = [pair for pair in frame.answers() if pair[0] in mine]
                left -= mine
                yield from answers

    def load(self, keys: Iterable[str]) -> dict[str, Entry]:
        """The same answers, in memory."""
        return dict(self.answers(keys))

    def remaining(self, jobs: Sequence[Job], index: Mapping[str, int] | None = None) -> list[Job]:
        """Unfinished rest of some jobs, by the journal's `index` where it is known already."""
        chained = [key for job in jobs if len(job.keys) > 1 for key in job.keys]
        answers = self.load(chained) if chained else {}
        return remaining(jobs, self.index() if index is None else index, answers)

    def _sound(self) -> Iterator[Frame]:
        """Frames that are sound and of this code."""
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

    def mark_crashed(self, key: str, say: Callable[[str], None]) -> dict[str, Entry]:
        """Write, and return, the answer of a cell at which its worker died again."""
        answers: dict[str, Entry] = {key: {"status": CRASHED, "trouble": DIED}}
        say(f"cell marked as crashed: {DIED}")
        self.write(answers)
        return answers

    def take(self, other: Journal, keys: Iterable[str]) -> set[str]:
        """Copy the cells with these keys from another journal; the keys that it has."""
        wanted = other.index().keys() & set(keys)
        if wanted:
            with replaced(new_part(self.folder, len(wanted))) as temporary, open(temporary, "wb") as file:
                for body in other._only(wanted):
                    file.write(head_of(body))
                    file.write(body)
        return wanted

    def _only(self, wanted: set[str]) -> Iterator[bytes | bytearray]:
        """Bodies of frames with the cells of these keys: unchanged where no other cell is in them."""
        left = set(wanted)
        for frame in self._sound():
            mine = left & frame.index.keys()
            left -= mine
            if len(mine) == len(frame.index):
                yield frame.body
            elif mine:
                yield body_of({key: entry for key, entry in frame.answers() if key in mine}, frame.origin)

    def keep_only(self, keys: Iterable[str]) -> None:
        """Make one part of all parts, without the cells of other keys and without damaged frames.

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
        """Take the keys of the cells at which workers died."""
        keys = []
        for path in self._files(AT):
            keys.append(path.read_text(errors="replace")[:KEY].strip())
            path.unlink(missing_ok=True)
        return [key for key in keys if key]

    def places(self) -> Iterator[tuple[float, str]]:
        """How much is done of each cell that workers are at, and where it stands, in their words."""
        for path in self._files(AT):
            with suppress(OSError, ValueError):  # it has just ended, or is being written
                fraction, _, place = path.read_text(errors="replace")[KEY:].strip().partition(" ")
                yield float(fraction), place

    def writer(self) -> str | None:
        """The process that holds the journal now; None if none does."""
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


def _shown(header: Mapping[str, Any]) -> str:
    names = {"kernels": "kernel_digest", "code": "code", "format": "format"}
    return ", ".join(f"{name} {header.get(key, 'unknown')}" for name, key in names.items())


def refuse_lost(count: int) -> None:
    """Raise an `OSError` where the answers of some cells are not there."""
    if count:
        raise OSError(f"the answers of {count} cells cannot be read back; run again")


def _code() -> dict[str, Any]:
    """The format of a journal, and digests of the code that computes its cells."""
    return {"format": FORMAT, "kernel_digest": cache.digest(), "code": origin.code()}


def header() -> dict[str, Any]:
    """Content of the journal's own file: the code that computes its cells, and where."""
    software = {"version": origin.version("jointplay"), "git": origin.git_describe()}
    return _code() | {"software": software, "environment": origin.environment()}


class Frame(NamedTuple):
    """A sound frame: its part, its origin, the status of each cell by key, all bytes but the head."""

    part: Path
    origin: Origin
    index: dict[str, int]
    body: bytearray

    @classmethod
    def of(cls, part: Path, body: bytearray) -> Frame:
        """Read the index of a body; `ValueError` where it has none."""
        match values.read(body):
            case [str(code), str(processor), [*keys], [*ends]] if _is_index(keys, ends):
                return cls(part, Origin(code, processor), dict(zip(keys, ends, strict=True)), body)
        raise ValueError("no index")

    def answers(self) -> Iterator[tuple[str, Entry]]:
        """The answers of its cells; `OSError` where they are unreadable although the checksum fits."""
        with suppress(*BROKEN):
            answers = unpacked(*values.read(memoryview(self.body)[values.length(self.body) :]))
            if [answer["status"] for answer in answers] == list(self.index.values()):
                return zip(self.index, answers, strict=True)
        raise OSError(f"{self.part} holds no answers of cells; `jointplay run --fresh` drops it")


def _is_index(keys: list[Any], ends: list[Any]) -> bool:
    known = all(isinstance(key, str) for key in keys) and all(type(end) is int for end in ends)
    return known and len({*keys}) == len(keys) and {*ends} <= {*Status}


def body_of(entries: Mapping[str, Entry], origin: Origin) -> bytes:
    """The body of a frame with these cells."""
    index = (*origin, list(entries), [int(answer["status"]) for answer in entries.values()])
    return values.written(index) + values.written(packed(list(entries.values())))


def head_of(body: bytes | bytearray) -> bytes:
    """The bytes before a body: a line, its length, the checksum."""
    length = len(body).to_bytes(8, "big")
    checksum = hashlib.sha256(length)
    checksum.update(body)
    return MAGIC + length + checksum.digest()


def frames(path: Path, damaged: set[str]) -> Iterator[Frame]:
    """The sound frames of a part; its name is added to `damaged` where it has others."""
    with path.open("rb") as file:
        at, end = 0, file.seek(0, os.SEEK_END)
        while at >= 0 and (at < end or not end):
            file.seek(at)
            head = file.read(HEAD)
            length = int.from_bytes(head[len(MAGIC) : len(MAGIC) + 8], "big")
            body = bytearray(length if at + HEAD + length <= end else 0)
            file.readinto(body)
            if frame := _frame(path, head, body):
                yield frame
                at += HEAD + length
            else:
                damaged.add(path.name)
                at = _next_frame(file, at + 1) if end else -1


def _frame(part: Path, head: bytes, body: bytearray) -> Frame | None:
    """The frame of a body, if it is sound."""
    with suppress(ValueError):
        return Frame.of(part, body) if head_of(body) == head else None
    return None


def _next_frame(file: BinaryIO, start: int) -> int:
    """Offset at which the next frame may begin; -1 if there is none."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return content.find(MAGIC, start)


def write_part(folder: Path, entries: Mapping[str, Entry], origin: Origin | None = None) -> None:
    """Write finished cells as one part, whole or not at all; by default this process computed them.

    Not flushed, as many are written: a power cut may cut those of the last half minute short, which their
    checksums show.
    """
    with replaced(new_part(folder, len(entries)), flush=False) as temporary:
        body = body_of(entries, origin or own())
        temporary.write_bytes(head_of(body) + body)


def new_part(folder: Path, cells: int) -> Path:
    """A new name for a part of so many cells."""
    return folder / f"{cells}-{uuid.uuid4().hex}.part"
