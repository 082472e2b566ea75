"""Values as bytes and back, with nothing in them that could run: a JSON text, and arrays as in memory.

Known are what JSON has, NumPy's numbers, and its arrays of numbers or texts.
In the text an object with an empty key stands for one that JSON has not. Tuples come back as lists. Bytes
that say anything else are refused.
"""

from __future__ import annotations

import json
import re
import sys
from functools import lru_cache, partial
from io import BytesIO
from math import prod
from typing import Any

import numpy as np

KIND = re.compile(r"[<>|](?:b1|[iu][1248]|f[248]|c(?:8|16)|U[1-9]\d{0,7})")
STEP, ALIGN = 8, 16  # bytes of a length; where arrays begin


def written(value: Any) -> bytes:
    """Make bytes of a value: how many these are, how long the text is, the text, the arrays.

    Raises
    ------
    TypeError
        When there is something in it that is not known.
    """
    arrays = BytesIO()
    text = json.dumps(value, default=partial(_told, arrays), separators=(",", ":")).encode()
    head = _filled(len(text).to_bytes(2 * STEP, "big") + text)
    total = len(head) + arrays.tell()
    return b"".join((total.to_bytes(STEP, "big"), head[STEP:], arrays.getbuffer()))


def _filled(piece: bytes) -> bytes:
    return piece + bytes(-len(piece) % ALIGN)


def _told(arrays: BytesIO, value: Any) -> dict[str, Any]:
    """What the text says in place of a value that JSON does not know."""
    kind = value.dtype.str if isinstance(value, np.ndarray | np.generic) else type(value).__name__
    if not KIND.fullmatch(kind):
        raise TypeError(f"a journal holds no values of the kind {kind}")
    word, at = "array" if isinstance(value, np.ndarray) else "number", arrays.tell()
    arrays.write(_filled(value.tobytes()))
    return {"": word, "kind": kind, "shape": value.shape, "at": at}


def length(data: bytes | bytearray) -> int:
    """How many bytes stand for the value with which `data` begins, by their own account."""
    return int.from_bytes(data[:STEP], "big")


def read(data: bytes | memoryview) -> Any:
    """Give the value back that bytes stand for; its arrays are views of them.

    Raises
    ------
    ValueError
        When they stand for none.
    """
    end = 2 * STEP + int.from_bytes(data[STEP : 2 * STEP], "big")
    arrays = memoryview(data)[end + -end % ALIGN :]
    try:
        return json.loads(bytes(data[2 * STEP : end]), object_hook=partial(_made, arrays))
    except (RecursionError, TypeError, LookupError, AttributeError, OverflowError) as error:
        raise ValueError(f"no value of a journal ({error})") from error


def _made(arrays: memoryview, told: dict[str, Any]) -> Any:
    """The value that an object of the text stands for."""
    word = told.get("")
    if word is None:
        return told
    if word == "array":
        return _array(arrays, _kind(told["kind"]), told["shape"], told["at"])
    if word == "number":
        return _array(arrays, _kind(told["kind"]), [], told["at"])[()]
    raise ValueError(f"a journal holds no {word!r}")


@lru_cache(maxsize=256)
def _kind(text: str) -> np.dtype:
    if not KIND.fullmatch(text):
        raise ValueError(f"a journal holds no values of the kind {text!r}")
    return np.dtype(text)


def _array(arrays: memoryview, kind: np.dtype, shape: list[int], at: int) -> np.ndarray:
    if 0 in shape:
        return np.empty(shape, kind)
    if min(shape, default=0) < 0:
        raise ValueError(f"a journal holds no array of the shape {shape}")
    found = np.frombuffer(arrays, kind, prod(shape), at)
    if kind.kind == "U" and found.view(f"{kind.str[0]}u4").max() > sys.maxunicode:
        raise ValueError("a journal holds no characters beyond Unicode")
    return found.reshape(shape)
