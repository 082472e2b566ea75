"""From the answers of cells to one labelled dataset: cells along the varied dimensions.

A variable of the cells gets the varied dimensions in front. Along names (links, joints, states) cells are
aligned by name; along numbers they stand one after another, and what a shorter one lacks is NaN (-1 of whole
numbers, an empty text). A coordinate that differs from cell to cell, and a variable whose name a varied
parameter has taken, is called ``cell_`` and its name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.quantities import flags
from jointplay.analysis.words import STATUS
from jointplay.study.points import Points
from jointplay.study.status import MEANING

Entry = Mapping[str, Any]
LOST: Entry = {"variables": {}, "coords": {}, "attrs": {}}
OWN = "cell_"


def plain(dataset: xr.Dataset) -> dict[str, Any]:
    """A dataset as plain values: variables and coordinates as (dims, values, attributes)."""
    return {
        "variables": {str(name): _parts(variable) for name, variable in dataset.data_vars.items()},
        "coords": {str(name): _parts(variable) for name, variable in dataset.coords.items()},
        "attrs": dict(dataset.attrs),
    }


def _parts(variable: xr.DataArray) -> tuple[tuple[str, ...], np.ndarray, dict[str, Any]]:
    return tuple(map(str, variable.dims)), np.asarray(variable.values), dict(variable.attrs)


def dataset(kind: str, points: Points, answers: Sequence[Entry]) -> xr.Dataset:
    """Put the answers of all cells together.

    Parameters
    ----------
    kind : str
        Of the study.
    points : Points
        The cells, the last dimension fastest.
    answers : sequence of mapping
        As `jointplay.analysis.cells.guarded` gives them, with a ``dataset`` as `plain` makes it; a cell
        without one has only a ``status`` and ``trouble``.

    Returns
    -------
    xarray.Dataset
        With ``cell_status`` and ``trouble`` of each cell, and ``status``, the first that is not ok. The
        attribute ``swept`` names the varied dimensions.
    """
    return _Stack(points, [answer.get("dataset", LOST) for answer in answers]).whole(kind, answers)


class _Stack:
    """Cells on their way into one dataset."""

    def __init__(self, points: Points, cells: Sequence[Entry]) -> None:
        self.points, self.cells = points, cells
        self.taken = {*points.dims, *points.coordinates, "status", "trouble"}
        self.names = {dim: self._union(dim) for dim in self._labelled()}
        self.sizes = self._sizes()

    def whole(self, kind: str, answers: Sequence[Entry]) -> xr.Dataset:
        coords, own = self._shared()
        fields = {self._free(name): self._stacked("variables", name) for name in self._all("variables")}
        coords |= {self._free(name, True): self._stacked("coords", name) for name in own}
        fields.pop(OWN + "status", None)
        attributes = dict(self._common_attributes()) | {
            "Conventions": "CF-1.11",
            "kind": kind,
            "swept": " ".join(self.points.dims),
        }
        return xr.Dataset(
            fields | self._counts() | self._ends(answers), coords | self.points.coordinates, attributes
        )

    def _all(self, part: str) -> list[str]:
        return list(dict.fromkeys(name for cell in self.cells for name in cell[part]))

    def _having(self, part: str, name: str) -> Iterator[tuple[int, tuple]]:
        return ((i, cell[part][name]) for i, cell in enumerate(self.cells) if name in cell[part])

    def _free(self, name: str, own: bool = False) -> str:
        return OWN + name if own or name in self.taken else name

    def _labelled(self) -> list[str]:
        """Dimensions along which things have names."""
        return [
            name
            for name in self._all("coords")
            if all(
                dims == (name,) and values.dtype.kind in "UO"
                for _, (dims, values, _) in self._having("coords", name)
            )
        ]

    def _union(self, dim: str) -> list[str]:
        each = (values.tolist() for _, (_, values, _) in self._having("coords", dim))
        return list(dict.fromkeys(label for labels in each for label in labels))

    def _sizes(self) -> dict[str, int]:
        found: dict[str, int] = {}
        for part in ("variables", "coords"):
            for cell in self.cells:
                for dims, values, _ in cell[part].values():
                    for dim, n in zip(dims, values.shape, strict=True):
                        found[dim] = max(found.get(dim, 0), n)
        return found | {dim: len(names) for dim, names in self.names.items()}

    def _shared(self) -> tuple[dict[str, Any], list[str]]:
        """Coordinates that cells have in common, and names of those that they have each for itself."""
        shared, own = {}, []
        for name in self._all("coords"):
            each = [parts for _, parts in self._having("coords", name)]
            dims, longest, told = max(each, key=lambda parts: parts[1].size)
            if name in self.names:
                shared[self._free(name)] = (self._dims(dims), np.array(self.names[name], dtype=str), told)
            elif all(_begins(longest, values) for _, values, _ in each):
                shared[self._free(name)] = (self._dims(dims), longest, told)
            else:
                own.append(name)
        return shared, own

    def _dims(self, dims: Sequence[str]) -> tuple[str, ...]:
        return tuple(self._free(dim) for dim in dims)

    def _stacked(self, part: str, name: str) -> tuple[tuple[str, ...], np.ndarray, dict[str, Any]]:
        """A variable of every cell, in one array."""
        having = list(self._having(part, name))
        dims, _, told = having[0][1]
        sizes = [self.sizes[dim] for dim in dims]
        kind = np.result_type(*(values.dtype for _, (_, values, _) in having))
        kind = object if kind.kind in "UO" else kind
        full = np.full((len(self.cells), *sizes), _missing(np.dtype(kind)), dtype=kind)
        for i, (_, values, _) in having:
            own = self.cells[i]["coords"]
            places = [
                [self.names[dim].index(label) for label in own[dim][1].tolist()]
                if dim in self.names and dim in own
                else range(n)
                for dim, n in zip(dims, values.shape, strict=True)
            ]
            full[(i, *np.ix_(*places))] = values
        if full.dtype == object:
            full = full.astype(str)
        return (*self.points.dims, *self._dims(dims)), full.reshape(*self.points.shape, *sizes), told

    def _counts(self) -> dict[str, Any]:
        """How many entries each cell has along dimensions where cells differ."""
        found = {}
        for dim in self.sizes:
            each = [_size(cell, dim) for cell in self.cells]
            if dim not in self.names and len(set(each)) > 1:
                told = {"units": "1", "long_name": f"entries of the cell along {self._free(dim)}"}
                told["sample_dimension"] = self._free(dim)
                found[f"n_{dim}"] = (self.points.dims, np.reshape(each, self.points.shape), told)
        return found

    def _common_attributes(self) -> Iterator[tuple[str, Any]]:
        first = next((cell["attrs"] for cell in self.cells if cell["attrs"]), {})
        for key, value in first.items():
            if all(np.array_equal(cell["attrs"].get(key), value) for cell in self.cells if cell["attrs"]):
                yield key, value

    def _ends(self, answers: Sequence[Entry]) -> dict[str, Any]:
        """How each cell ended."""
        status = np.array([answer["status"] for answer in answers], dtype=np.int8)
        trouble = np.array([_trouble(answer) for answer in answers], dtype=str)
        bad, told = status[status != 0], flags(STATUS)
        dims, shape = self.points.dims, self.points.shape
        words = {"units": "1", "long_name": "what went wrong"}
        return {
            "status": ((), np.int8(bad[0] if len(bad) else 0), {"long_name": "how the sweep ended"} | told),
            "cell_status": (dims, status.reshape(shape), {"long_name": "how the cell ended"} | told),
            "trouble": (dims, trouble.reshape(shape), words),
        }


def _size(cell: Entry, dim: str) -> int:
    found = ((dims, values) for part in ("variables", "coords") for dims, values, _ in cell[part].values())
    return next((values.shape[dims.index(dim)] for dims, values in found if dim in dims), 0)


def _begins(longest: np.ndarray, values: np.ndarray) -> bool:
    """Whether values are where a longer array begins."""
    if values.ndim != 1 or longest.ndim != 1:
        return values.shape == longest.shape and np.array_equal(values, longest)
    return np.array_equal(longest[: len(values)], values)


def _missing(kind: np.dtype) -> Any:
    return {"f": np.nan, "c": np.nan, "i": -1, "u": 0, "b": False}.get(kind.kind, "")


def _trouble(answer: Entry) -> str:
    if answer["status"] == 0 or answer.get("trouble"):
        return answer.get("trouble", "")
    return MEANING[STATUS[answer["status"]]][0]
