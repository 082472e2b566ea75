"""The seal of a result: a digest of all that is in it, by which one that was changed afterwards is known."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

SEAL = "seal"  # the attribute that holds it
CLOCKS = ("wall_time",)  # whose values differ between runs that are otherwise the same


def sealed(dataset: xr.Dataset) -> xr.Dataset:
    """A copy of a result that holds the seal of its present content."""
    return dataset.assign_attrs({SEAL: _digest(dataset)})


def intact(dataset: Any) -> bool:
    """Whether a result is as this version of the program sealed it, on the disk or in memory."""
    seal = getattr(dataset, "attrs", {}).get(SEAL)
    return isinstance(seal, str) and seal == _digest(dataset)


def _digest(dataset: xr.Dataset) -> str:
    total = hashlib.sha256(version("jointplay").encode())
    for part in _parts(dataset):
        total.update(part)
    return total.hexdigest()[:16]


def _parts(dataset: xr.Dataset) -> Iterator[bytes]:
    """Content in an order of its own, in forms that a file gives back as they were."""
    yield repr(_plain(dataset.attrs)).encode()
    for name in sorted(map(str, dataset.variables)):
        variable = dataset.variables[name]
        values = np.asarray(variable.values)
        text = values.dtype.kind in "OU"
        kind = "text" if text else values.dtype.str
        yield repr((name, variable.dims, values.shape, kind, _plain(variable.attrs))).encode()
        if name not in CLOCKS:
            yield repr(values.tolist()).encode() if text else np.ascontiguousarray(values).tobytes()


def _plain(attributes: Mapping[Any, Any]) -> list[tuple[str, Any]]:
    """Attributes by name, numbers as lists of numbers; the seal is no part of what it is a digest of."""
    return sorted((str(name), np.ravel(each).tolist()) for name, each in attributes.items() if name != SEAL)
