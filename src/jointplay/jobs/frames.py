"""Frames, of which a part of the journal consists, each with a checksum.

A frame is a line, the length of its body (8 bytes), a SHA-256 checksum of both, and the body: two values
(`jointplay.jobs.values`), the index (who computed it; key and status of each cell) and the answers. Frames
stand one after another, so that parts are joined by joining their bytes, and one that is damaged does not
touch the others.
"""

from __future__ import annotations

import hashlib
import mmap
import os
import uuid
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from jointplay.jobs import values
from jointplay.jobs.columns import packed, unpacked
from jointplay.jobs.files import replaced
from jointplay.jobs.job import Entry
from jointplay.jobs.origin import Origin, own
from jointplay.solver.method.codes import Status

FORMAT = 3
MAGIC = f"jointplay journal part {FORMAT}\n".encode()
HEAD = len(MAGIC) + 8 + 32  # bytes before a body
BROKEN = (ValueError, TypeError, LookupError, AttributeError)  # what bytes that are no frame may raise


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
