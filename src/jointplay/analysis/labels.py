"""Labelled variables of datasets, made of tables of values, units and long names."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointplay.analysis.quantities import STATUS

ENDED = "how the run ended"


def flags(meanings: Sequence[str], dtype: Any = np.int8) -> dict[str, Any]:
    """CF attributes of an integer code."""
    values = np.arange(len(meanings), dtype=dtype)
    return {"units": "1", "flag_values": values, "flag_meanings": " ".join(meanings)}


def described(table: Mapping[str, tuple[Any, Any, str, str]]) -> dict[str, Any]:
    """Variables of a dataset from their dimensions, values, units and long names."""
    return {key: (dims, v, {"units": u, "long_name": text}) for key, (dims, v, u, text) in table.items()}


def number(dims: Any, values: Any, units: str, text: str) -> tuple[Any, Any, dict[str, Any]]:
    """A variable with its units and long name."""
    return dims, values, {"units": units, "long_name": text}


def labelled(rows: Mapping[str, tuple[Any, str, str]], dims: str | tuple[str, ...] = ()) -> dict[str, Any]:
    """Variables over the same dimensions, of name: (values, units, long name)."""
    return {
        name: number(dims, np.asarray(values), units, text) for name, (values, units, text) in rows.items()
    }


def coded(
    dims: str | tuple[str, ...], values: Any, text: str = ENDED, meanings: tuple[str, ...] = STATUS
) -> tuple:
    """A variable of integer codes with their meanings, statuses if none are given."""
    return dims, np.asarray(values, dtype=np.int8), {"long_name": text} | flags(meanings)


def outcome(status: int, began: float, text: str = ENDED) -> dict[str, Any]:
    """Status of an analysis and its wall time, since `began` by `time.perf_counter`."""
    return {"status": coded((), status, text)} | labelled(
        {"wall_time": (time.perf_counter() - began, "s", "wall time of the run")}
    )


def ended(status: int, began: float) -> dict[str, Any]:
    """The same as values."""
    return {"status": status, "wall_time": time.perf_counter() - began}


def column(answers: Sequence[Mapping[str, Any]], key: str, missing: Any, dtype: Any = float) -> np.ndarray:
    """One entry of the answer of each cell, `missing` where a cell has none."""
    return np.array([answer.get(key, missing) for answer in answers], dtype=dtype)


PLANE = "plane"  # stands for the dimensions of a plane whose axes a result has of its own
KEPT = object()  # what a run that failed still tells
OF = {"name": "the quantity", "units": "its units", "squared": "its units squared"}
OF |= {"length": "m", "speed": "m s-1"}  # which a test system's lengths have not
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
    about : str
        What the documentation says beside the long name.
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
        if self.flags:
            return coded(dims, values, self.long_name, self.flags)
        name = self.long_name.format_map(of)
        if not self.units:
            return dims, values, {"long_name": name}
        return number(dims, values, self.units.format_map(of), name)

    def none(self, shape: tuple[int, ...]) -> np.ndarray:
        """Values of a run that failed."""
        return np.full(shape, self.flags.index(self.missing) if self.flags else self.missing)
