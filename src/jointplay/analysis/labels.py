"""Variables of results: dimensions, units, names, words of codes, and values from the answers of cells."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
else:

    class _Xarray:
        """xarray, which takes long to import, imported when something of it is first asked for."""

        def __getattr__(self, name: str) -> Any:
            return getattr(import_module("xarray"), name)

    xr = _Xarray()


def flags(meanings: Sequence[str], dtype: Any = np.int8) -> dict[str, Any]:
    """CF attributes of an integer code."""
    values = np.arange(len(meanings), dtype=dtype)
    return {"units": "1", "flag_values": values, "flag_meanings": " ".join(meanings)}


def ended(status: int, began: float) -> dict[str, Any]:
    """Status of an analysis and its wall time, since `began` by `time.perf_counter`."""
    return {"status": status, "wall_time": time.perf_counter() - began}


def units(linkage: bool) -> dict[str, str]:
    """Units of lengths and speeds: a test system's have none."""
    return {"length": "m", "speed": "m s-1"} if linkage else {"length": "1", "speed": "1"}


PLANE = "plane"  # stands for the dimensions of a plane whose axes a result has of its own
KEPT = object()  # what a run that failed still tells
OF = {"name": "the quantity", "units": "its units", "squared": "its units squared"}
OF |= units(linkage=True)
OF["per_hertz"] = "its units squared per hertz"  # as long as there is no quantity


@dataclass(frozen=True)
class Out:
    """A variable of a result.

    Parameters
    ----------
    dims : str or tuple of str
        Its dimensions, of a scalar (); `PLANE` stands for those of the plane (or axis) that it is over.
    long_name, units : str
        As in the file; ``{name}`` and ``{units}`` are those of the quantity that the result is of. A text has
        no units.
    about, comment : str
        What the documentation says beside the long name; the comment stands in the file too.
    flags : tuple of str
        Words of an integer code.
    missing : object
        Where a run failed, of a code its word; `KEPT`: what there is until then.
    at : mapping
        The entry along each of its own dimensions that the figure of a sweep shows.
    """

    dims: str | tuple[str, ...]
    long_name: str
    units: str = "1"
    about: str = ""
    comment: str = ""
    flags: tuple[str, ...] = ()
    missing: Any = math.nan
    at: Mapping[str, Any] = field(default_factory=dict)

    @property
    def axes(self) -> tuple[str, ...]:
        """Its dimensions."""
        return (self.dims,) if isinstance(self.dims, str) else self.dims

    def variable(
        self, values: Any, of: Mapping[str, str] = OF, plane: Sequence[str] = (), words: Sequence[str] = ()
    ) -> tuple[Any, Any, dict[str, Any]]:
        """Dimensions, values and attributes; of a `plane` with these axes, of codes with these `words`."""
        dims = tuple(name for dim in self.axes for name in (plane if dim == PLANE else (dim,)))
        if words:
            return dims, values, {"long_name": self.long_name} | flags(words, np.int32)
        return dims, np.asarray(values, dtype=np.int8) if self.flags else values, self.attributes(of)

    def attributes(self, of: Mapping[str, str] = OF) -> dict[str, Any]:
        """Attributes, of a result of that quantity."""
        name = {"long_name": self.long_name.format_map(of)}
        note = {"comment": self.comment} if self.comment else {}
        if self.flags:
            return name | flags(self.flags) | note
        return ({"units": self.units.format_map(of)} if self.units else {}) | name | note

    def none(self, shape: tuple[int, ...]) -> np.ndarray:
        """Values of a run that failed."""
        return np.full(shape, self.flags.index(self.missing) if self.flags else self.missing)


def along(outs: Mapping[str, Out], *dims: str) -> dict[str, Out]:
    """The same variables, along further dimensions."""
    return {name: replace(out, dims=(*dims, *out.axes)) for name, out in outs.items()}


def columns(
    outs: Mapping[str, Out], answers: Sequence[Mapping[str, Any]], shape: tuple[int, ...] = (-1,)
) -> dict[str, np.ndarray]:
    """Values of each variable from the answers of cells, in that shape; as missing where a cell has none."""
    found = {}
    for name, out in outs.items():
        none = out.none(())
        values = [answer.get(name, none.item()) for answer in answers]
        found[name] = np.array(values, dtype=str if none.dtype.kind == "U" else none.dtype).reshape(shape)
    return found
