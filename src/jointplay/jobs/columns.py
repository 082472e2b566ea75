"""Datasets of cells as columns: their common parts are kept once, apart from their values.

The datasets of a sweep's cells differ in their values and, now and then, in their sizes. So an answer holds
its values, and a layout (names, dimensions, attributes) that it shares with every other answer of the same.
Cells of the same form (layout, sizes, types, labels) differ in their values alone: the journal holds
them packed, an array for each variable of all these cells, and reads and writes them as fast as a few arrays.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from jointplay.jobs import values

PARTS = ("variables", "coords")
Block = tuple[list[int], np.ndarray, list[np.ndarray]]  # which answers, layout, values one after another
Packed = tuple[list[dict[str, Any]], list[Block]]  # answers without their datasets, and these


class Field(NamedTuple):
    """Name, dimensions and attributes of a variable; `part` is one of `PARTS`."""

    part: str
    name: str
    dims: tuple[str, ...]
    attrs: Mapping[str, Any]

    @property
    def is_index(self) -> bool:
        """Whether it is the coordinate of its own dimension, which may hold labels."""
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
        return read, (self.written,)

    @cached_property
    def written(self) -> bytes:
        """The encoded layout, made once, as every frame of a journal holds it."""
        return values.written(([(*field[:3], dict(field.attrs)) for field in self.fields], dict(self.attrs)))

    @cached_property
    def places(self) -> dict[str, tuple[int, int]]:
        """For each dimension the number of a field, and the axis of it that has this dimension."""
        places: dict[str, tuple[int, int]] = {}
        for i, field in enumerate(self.fields):
            for axis, dim in enumerate(field.dims):
                places.setdefault(dim, (i, axis))
        return places


class Plain(NamedTuple):
    """A dataset as plain values: arrays in the order of the layout's fields."""

    layout: Layout
    values: Sequence[np.ndarray]


@dataclass(frozen=True)
class Form:
    """Layout, sizes, types and labels of a dataset: all but its values.

    Parameters
    ----------
    layout : Layout
        Names, dimensions, attributes.
    lengths : tuple of int
        Along ``layout.places``.
    kinds : tuple of dtype
        Of each field.
    named : tuple
        Pairs of a labelled dimension and its labels.
    """

    layout: Layout
    lengths: tuple[int, ...]
    kinds: tuple[np.dtype, ...]
    named: tuple[tuple[str, tuple[str, ...]], ...]

    @classmethod
    def of(cls, dataset: Plain) -> Form:
        """The form of a dataset."""
        layout, values = dataset
        lengths = tuple(values[i].shape[axis] for i, axis in layout.places.values())
        named = tuple(
            (field.name, tuple(array.tolist()))
            for field, array in zip(layout.fields, values, strict=True)
            if field.is_index and array.dtype.kind in "UO"
        )
        return cls(layout, lengths, tuple(array.dtype for array in values), named)

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Length along each dimension."""
        return dict(zip(self.layout.places, self.lengths, strict=True))

    @cached_property
    def labels(self) -> dict[str, tuple[str, ...]]:
        """Labels along the dimensions that have some."""
        return dict(self.named)

    def fields(self, part: str) -> Iterator[tuple[int, Field]]:
        """Variables or coordinates, with their number among all."""
        return ((i, field) for i, field in enumerate(self.layout.fields) if field.part == part)


_known: WeakValueDictionary[Any, Layout] = WeakValueDictionary()


def shared(fields: list[tuple[str, str, tuple[str, ...], dict[str, Any]]], attrs: dict[str, Any]) -> Layout:
    """The layout of these fields, as (part, name, dims, attributes), and attributes of the whole."""
    key = (tuple((*field[:3], _frozen(field[3])) for field in fields), _frozen(attrs))
    layout = _known.get(key)
    if layout is None:
        own = tuple(Field(*field[:3], _read_only(field[3])) for field in fields)
        layout = _known[key] = Layout(own, _read_only(attrs))
    return layout


@lru_cache(maxsize=64)
def read(written: bytes) -> Layout:
    """Decode a layout; `ValueError` where the bytes encode none."""
    match values.read(written):
        case [[*fields], dict(attrs)] if all(map(_is_field, fields)):
            return shared([(part, name, tuple(dims), own) for part, name, dims, own in fields], attrs)
    raise ValueError("no layout of a journal")


def _is_field(item: Any) -> bool:
    match item:
        case [str(part), str(), [*dims], dict()]:
            return part in PARTS and all(isinstance(dim, str) for dim in dims)
    return False


def thawed(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of attributes that may be changed."""
    return {key: np.array(value) if isinstance(value, np.ndarray) else value for key, value in attrs.items()}


def _read_only(attrs: Mapping[str, Any]) -> Mapping[str, Any]:
    own = thawed(attrs)
    for value in own.values():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
    return MappingProxyType(own)


def _frozen(attrs: Mapping[str, Any]) -> tuple[Any, ...]:
    """Hashable form of attributes, equal only where types and bits are."""
    return tuple((key, value if type(value) is str else _bits(value)) for key, value in attrs.items())


def _bits(value: Any) -> tuple[Any, ...]:
    if isinstance(value, np.ndarray | np.generic):
        return type(value), value.dtype.str, value.shape, value.tobytes()
    return type(value), repr(value)


def packed(answers: Sequence[Mapping[str, Any]]) -> Packed:
    """Take the datasets out of answers, and join datasets of the same form into blocks."""
    places: dict[Form, list[int]] = {}
    for place, answer in enumerate(answers):
        if isinstance(answer.get("dataset"), Plain):
            places.setdefault(Form.of(answer["dataset"]), []).append(place)
    within = {place for each in places.values() for place in each}
    rest = [
        {key: value for key, value in answer.items() if key != "dataset" or place not in within}
        for place, answer in enumerate(answers)
    ]
    return rest, [_block(form, each, answers) for form, each in places.items()]


def _block(form: Form, places: list[int], answers: Sequence[Mapping[str, Any]]) -> Block:
    columns = zip(*(answers[place]["dataset"].values for place in places), strict=True)
    layout = np.frombuffer(form.layout.written, np.uint8)
    return places, layout, [_stacked(column) for column in columns]


def _stacked(column: Sequence[np.ndarray]) -> np.ndarray:
    stacked = np.empty((len(column), *column[0].shape), column[0].dtype)
    for n, array in enumerate(column):  # for a few small arrays `np.stack` takes several times as long
        stacked[n] = array
    return stacked


def unpacked(answers: Sequence[dict[str, Any]], blocks: Sequence[Block]) -> Sequence[dict[str, Any]]:
    """Put the datasets back into answers, as views of the blocks; `ValueError` where these do not fit."""
    for places, written, columns in blocks:
        layout = read(written.tobytes())
        _check(layout, columns, len(places))
        for n, place in enumerate(places):
            answers[place]["dataset"] = Plain(layout, [column[n, ...] for column in columns])
    return answers


def _check(layout: Layout, columns: Sequence[np.ndarray], cells: int) -> None:
    """Refuse columns that do not hold the fields of `cells` cells, or disagree on the size of a dimension."""
    sizes: dict[str, int] = {}
    for field, column in zip(layout.fields, columns, strict=True):
        lengths = dict(zip(field.dims, column.shape[1:], strict=True))
        if len(column) != cells or any(sizes.setdefault(dim, n) != n for dim, n in lengths.items()):
            raise ValueError(f"no values of {field.name}")
