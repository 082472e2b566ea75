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
    """Encode a value: number of bytes, length of the text, the text, the arrays.

    `TypeError` where something in it cannot be encoded.
    """
    arrays = BytesIO()
    text = json.dumps(value, default=partial(_encoded, arrays), separators=(",", ":")).encode()
    head = _filled(len(text).to_bytes(2 * STEP, "big") + text)
    total = len(head) + arrays.tell()
    return b"".join((total.to_bytes(STEP, "big"), head[STEP:], arrays.getbuffer()))


def _filled(piece: bytes) -> bytes:
    return piece + bytes(-len(piece) % ALIGN)


def _encoded(arrays: BytesIO, value: Any) -> dict[str, Any]:
    """The object of the text that stands for a value that JSON does not have."""
    kind = value.dtype.str if isinstance(value, np.ndarray | np.generic) else type(value).__name__
    if not KIND.fullmatch(kind):
        raise TypeError(f"a journal holds no values of the kind {kind}")
    word, at = "array" if isinstance(value, np.ndarray) else "number", arrays.tell()
    arrays.write(_filled(value.tobytes()))
    return {"": word, "kind": kind, "shape": value.shape, "at": at}


def length(data: bytes | bytearray) -> int:
    """Number of bytes of the encoded value with which `data` begins."""
    return int.from_bytes(data[:STEP], "big")


def read(data: bytes | memoryview) -> Any:
    """Decode a value; its arrays are views of the bytes. `ValueError` where they encode none."""
    end = 2 * STEP + int.from_bytes(data[STEP : 2 * STEP], "big")
    arrays = memoryview(data)[end + -end % ALIGN :]
    try:
        return json.loads(bytes(data[2 * STEP : end]), object_hook=partial(_decoded, arrays))
    except (RecursionError, TypeError, LookupError, AttributeError, OverflowError) as error:
        raise ValueError(f"no value of a journal ({error})") from error


def _decoded(arrays: memoryview, item: dict[str, Any]) -> Any:
    """The value for which an object of the text stands."""
    word = item.get("")
    if word is None:
        return item
    if word == "array":
        return _array(arrays, _kind(item["kind"]), item["shape"], item["at"])
    if word == "number":
        return _array(arrays, _kind(item["kind"]), [], item["at"])[()]
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
    array = np.frombuffer(arrays, kind, prod(shape), at)
    if kind.kind == "U" and array.view(f"{kind.str[0]}u4").max() > sys.maxunicode:
        raise ValueError("a journal holds no characters beyond Unicode")
    return array.reshape(shape)
