"""What cells have in common beside their numbers: names, dimensions and attributes, kept once a process.

The datasets of a sweep's cells differ in their values and, now and then, in their sizes. So an answer holds
its values, and a layout that it shares with every other answer of the same: in memory, and within a part of
the journal, where a pickle writes an object once.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np

PARTS = ("variables", "coords")


class Field(NamedTuple):
    """A variable but for its values; `part` is one of `PARTS`."""

    part: str
    name: str
    dims: tuple[str, ...]
    attrs: Mapping[str, Any]

    @property
    def names_places(self) -> bool:
        """Whether it may say what the places along its own dimension are called."""
        return self.part == "coords" and self.dims == (self.name,)


class Layout:
    """Names, dimensions and attributes of a dataset; never changed, and the same object where it is equal.

    Parameters
    ----------
    fields : tuple of Field
        Its variables and coordinates, in their order.
    attrs : mapping
        Its own attributes.
    """

    def __init__(self, fields: tuple[Field, ...], attrs: Mapping[str, Any]) -> None:
        self.fields, self.attrs = fields, attrs

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._pickled,)

    @cached_property
    def _pickled(self) -> bytes:
        """Itself, made once: every part of a journal holds it."""
        return pickle.dumps(([(*field[:3], dict(field.attrs)) for field in self.fields], dict(self.attrs)))

    @cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """Where the size of each dimension is seen: number of a field, and its axis."""
        found: dict[str, tuple[int, int]] = {}
        for i, field in enumerate(self.fields):
            for axis, dim in enumerate(field.dims):
                found.setdefault(dim, (i, axis))
        return found


class Plain(NamedTuple):
    """A dataset as plain values: arrays in the order of the layout's fields."""

    layout: Layout
    values: Sequence[np.ndarray]


_known: WeakValueDictionary[Any, Layout] = WeakValueDictionary()


def shared(fields: list[tuple[str, str, tuple[str, ...], dict[str, Any]]], attrs: dict[str, Any]) -> Layout:
    """The layout of these fields, as (part, name, dims, attributes), and attributes of the whole."""
    key = (tuple((*field[:3], _frozen(field[3])) for field in fields), _frozen(attrs))
    found = _known.get(key)
    if found is None:
        own = tuple(Field(*field[:3], _kept(field[3])) for field in fields)
        found = _known[key] = Layout(own, _kept(attrs))
    return found


@lru_cache(maxsize=64)
def _unpickled(pickled: bytes) -> Layout:
    return shared(*pickle.loads(pickled))


def thawed(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of attributes that may be changed."""
    return {key: np.array(value) if isinstance(value, np.ndarray) else value for key, value in attrs.items()}


def _kept(attrs: Mapping[str, Any]) -> Mapping[str, Any]:
    own = thawed(attrs)
    for value in own.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return MappingProxyType(own)


def _frozen(attrs: Mapping[str, Any]) -> tuple[Any, ...]:
    """Attributes as something that can be looked up: the same only if types and bits are."""
    return tuple((key, value if type(value) is str else _bits(value)) for key, value in attrs.items())


def _bits(value: Any) -> tuple[Any, ...]:
    if isinstance(value, np.ndarray | np.generic):
        return type(value), value.dtype.str, value.shape, value.tobytes()
    return type(value), repr(value)
