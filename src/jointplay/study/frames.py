"""Frames, of which a part of the journal consists: each says by its checksum whether it is sound.

A frame is a line, the length of its body (8 bytes), a SHA-256 checksum of both, and the body: two pickles,
the index (key and status of each cell) and the answers. Frames stand one after another, so that parts are
joined by joining their bytes, and one that is damaged does not touch the others.
"""

from __future__ import annotations

import hashlib
import mmap
import os
import pickle
import uuid
from collections.abc import Iterator, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

from jointplay.study.pack import packed
from jointplay.study.store import replaced

FORMAT = 2
MAGIC = f"jointplay journal part {FORMAT}\n".encode()
HEAD = len(MAGIC) + 8 + 32  # bytes before a body
Entry = dict[str, Any]
Index = list[tuple[str, int]]  # key and status of each cell of a frame


def body_of(entries: Mapping[str, Entry]) -> bytes:
    """The body of a frame with these cells."""
    stream = BytesIO()
    pickle.dump([(key, int(answer["status"])) for key, answer in entries.items()], stream, protocol=5)
    pickle.dump(packed(list(entries.values())), stream, protocol=5)
    return stream.getvalue()


def head_of(body: bytes) -> bytes:
    """What stands before a body."""
    length = len(body).to_bytes(8, "big")
    checksum = hashlib.sha256(length)
    checksum.update(body)
    return MAGIC + length + checksum.digest()


def bodies(path: Path, damaged: set[str]) -> Iterator[bytes]:
    """Bodies of the sound frames of a part; of one with others, the name goes among the damaged."""
    with path.open("rb") as file:
        at, end = 0, file.seek(0, os.SEEK_END)
        while at >= 0 and (at < end or not end):
            file.seek(at)
            head = file.read(HEAD)
            length = int.from_bytes(head[len(MAGIC) : len(MAGIC) + 8], "big")
            body = file.read(length) if at + HEAD + length <= end else b""
            if head_of(body) == head:
                yield body
                at += HEAD + length
            else:
                damaged.add(path.name)
                at = _next_frame(file, at + 1) if end else -1


def _next_frame(file: BinaryIO, start: int) -> int:
    """Where the next frame may begin; -1 if there is none."""
    with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return content.find(MAGIC, start)


def write_part(folder: Path, entries: Mapping[str, Entry]) -> None:
    """Write finished cells as one part, whole or not at all.

    Not flushed, as many are written: of those of the last half minute a power cut may leave some cut short,
    which their checksums tell.
    """
    with replaced(new_part(folder, len(entries)), flush=False) as temporary:
        body = body_of(entries)
        temporary.write_bytes(head_of(body) + body)


def new_part(folder: Path, cells: int) -> Path:
    """The name of a part of so many cells that is not there yet."""
    return folder / f"{cells}-{uuid.uuid4().hex}.part"
