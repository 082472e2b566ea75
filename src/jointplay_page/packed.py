"""Numbers in a page: arrays in base64, single precision; JSON that no text can break out of."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np

INTEGERS = ("<i1", "<i2", "<i4")


def array(values: Any, real: str = "<f4") -> dict[str, Any]:
    """Return an array for a page: its shape, its type and its bytes in base64; texts as a list."""
    values = np.asarray(values)
    if values.dtype.kind not in "fiub":
        known, places = np.unique(values.astype(str), return_inverse=True)
        return {"texts": known.tolist()} | array(places.reshape(values.shape))
    ends = [values.min(initial=0), values.max(initial=0)]
    whole = [
        kind for kind in INTEGERS if values.dtype.kind != "f" and not any(ends != np.clip(ends, *reach(kind)))
    ]
    kind = whole[0] if whole else real
    raw = np.ascontiguousarray(values, dtype=kind).tobytes()
    return {"type": kind, "shape": list(values.shape), "bytes": base64.b64encode(raw).decode()}


def reach(kind: str) -> tuple[int, int]:
    """Return the smallest and largest number of a type."""
    return np.iinfo(kind).min, np.iinfo(kind).max


def size(packed: dict[str, Any]) -> int:
    """Return the bytes that an array takes before base64."""
    return len(packed["bytes"]) * 3 // 4


def text(data: Any) -> str:
    """Return JSON that can stand in an HTML page; numbers that are not finite as null."""
    plain = json.dumps(_finite(data), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        plain = plain.replace(character, f"\\u{ord(character):04x}")
    return plain


def _finite(data: Any) -> Any:
    if isinstance(data, dict):
        return {str(key): _finite(each) for key, each in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(each) for each in data]
    data = data.item() if isinstance(data, np.generic) else data
    return None if isinstance(data, float) and not np.isfinite(data) else data
