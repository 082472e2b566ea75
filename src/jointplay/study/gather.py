"""From the answers of cells to one labelled dataset: cells along the varied dimensions.

A variable of the cells gets the varied dimensions in front. Along names (links, joints, states) cells are
aligned by name; along numbers they stand one after another, and what a shorter one lacks is NaN (-1 of whole
numbers, an empty text). A coordinate that differs from cell to cell, and a variable whose name a varied
parameter has taken, is called ``cell_`` and its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis.quantities import flags
from jointplay.analysis.words import STATUS
from jointplay.study.journal import refuse_lost
from jointplay.study.layout import Field, Plain, shared, thawed
from jointplay.study.points import Points
from jointplay.study.survey import Form, Survey

Entry = Mapping[str, Any]
Read = Callable[[], Iterable[tuple[str, Entry]]]
Parts = tuple[tuple[str, ...], np.ndarray, dict[str, Any]]
OWN = "cell_"


def plain(dataset: xr.Dataset) -> Plain:
    """A dataset as a layout, which it shares with others, and the values of its variables in that order."""
    coords, values, fields = set(dataset.coords), [], []
    for name, variable in dataset.variables.items():
        part = "coords" if name in coords else "variables"
        fields.append((part, str(name), tuple(map(str, variable.dims)), variable.attrs))
        values.append(np.asarray(variable.values))
    return Plain(shared(fields, dataset.attrs), values)


def dataset(kind: str, points: Points, keys: Sequence[str], read: Read) -> xr.Dataset:
    """Put the answers of all cells together.

    Parameters
    ----------
    kind : str
        Of the study.
    points : Points
        The cells, the last dimension fastest.
    keys : sequence of str
        Of each cell, in that order.
    read : callable
        Goes through the answers, as (key, answer) in any order; called twice, so that they need not be in
        memory all at once. Answers are as `jointplay.analysis.cells.guarded` gives them, with a ``dataset``
        as `plain` makes it; a cell without one has only a ``status`` and ``trouble``.

    Returns
    -------
    xarray.Dataset
        With ``cell_status`` and ``trouble`` of each cell, and ``status``, the first that is not ok. The
        attribute ``swept`` names the varied dimensions.

    Raises
    ------
    OSError
        When answers are missing.
    """
    survey = Survey(keys)
    for key, answer in read():
        survey.see(key, answer)
    refuse_lost(int((survey.status < 0).sum()))
    stack = _Stack(points, survey)
    for key, answer in read():
        if "dataset" in answer:
            stack.put(key, answer["dataset"].values)
    return stack.whole(kind)


class _Stack:
    """Cells on their way into one dataset: an array for each variable, cells first."""

    def __init__(self, points: Points, survey: Survey) -> None:
        self.points, self.survey = points, survey
        self.taken = {*points.dims, *points.coordinates, "status", "trouble"}
        self.coords, own = self._shared()
        stacked = [("variables", name) for name in survey.names("variables") if name != "status"]
        self.full = {each: self._empty(*each) for each in (*stacked, *(("coords", name) for name in own))}
        self.targets = {form: self._targets(form) for form in survey.forms}

    def put(self, key: str, values: Sequence[np.ndarray]) -> None:
        """Fill in a cell."""
        for number in self.survey.places[key]:
            for full, i, places in self.targets[self.survey.form[number]]:
                full[(number, *places)] = values[i]

    def whole(self, kind: str) -> xr.Dataset:
        """The dataset."""
        fields, coords = {}, dict(self.coords)
        for (part, name), full in self.full.items():
            place = fields if part == "variables" else coords
            place[self._free(name, part == "coords")] = self._stacked(part, name, full)
        attributes = dict(self.survey.attributes()) | {
            "Conventions": "CF-1.11",
            "kind": kind,
            "swept": " ".join(self.points.dims),
        }
        return xr.Dataset(
            fields | self._counts() | self._ends(), coords | self.points.coordinates, attributes
        )

    def _free(self, name: str, own: bool = False) -> str:
        return OWN + name if own or name in self.taken else name

    def _dims(self, dims: Sequence[str]) -> tuple[str, ...]:
        return tuple(self._free(dim) for dim in dims)

    def _shared(self) -> tuple[dict[str, Parts], list[str]]:
        """Coordinates that cells have in common, and names of those that they have each for itself."""
        shared, own, survey = {}, [], self.survey
        for name in survey.names("coords"):
            if name in survey.labels:
                having = survey.having("coords", name)
                field = max(having, key=lambda each: each[0].sizes[name])[2]
                values = np.array(survey.labels[name], dtype=str)
            elif all(name not in form.labels for form in survey.forms) and survey.common[name].fits:
                field, values = survey.common[name].field, survey.common[name].values
            else:
                own.append(name)
                continue
            shared[self._free(name)] = (self._dims(field.dims), values, thawed(field.attrs))
        return shared, own

    def _empty(self, part: str, name: str) -> np.ndarray:
        having = self.survey.having(part, name)
        kind = np.result_type(*(form.kinds[i] for form, i, _ in having))
        kind = np.dtype(object) if kind.kind in "UO" else kind
        sizes = [self.survey.sizes[dim] for dim in having[0][2].dims]
        return np.full((len(self.survey.form), *sizes), _missing(kind), dtype=kind)

    def _targets(self, form: Form) -> list[tuple[np.ndarray, int, tuple[Any, ...]]]:
        """Array, number of the field and places along its dimensions, of all that cells of a form fill in."""
        return [
            (self.full[field.part, field.name], i, self._places(form, field))
            for i, field in enumerate(form.layout.fields)
            if (field.part, field.name) in self.full
        ]

    def _places(self, form: Form, field: Field) -> tuple[Any, ...]:
        labels = self.survey.labels
        along = [
            [labels[dim].index(label) for label in form.labels[dim]]
            if dim in labels and dim in form.labels
            else list(range(form.sizes[dim]))
            for dim in field.dims
        ]
        if all(places == list(range(len(places))) for places in along):
            return tuple(slice(len(places)) for places in along)
        return np.ix_(*along)

    def _stacked(self, part: str, name: str, full: np.ndarray) -> Parts:
        """A variable of every cell."""
        field = self.survey.having(part, name)[0][2]
        full = full.astype(str) if full.dtype == object else full
        shape = (*self.points.shape, *full.shape[1:])
        return (*self.points.dims, *self._dims(field.dims)), full.reshape(shape), thawed(field.attrs)

    def _counts(self) -> dict[str, Any]:
        """How many entries each cell has along dimensions where cells differ."""
        found = {}
        for dim in self.survey.sizes:
            each = self.survey.lengths(dim)
            if dim not in self.survey.labels and len(set(each)) > 1:
                told = {"units": "1", "long_name": f"entries of the cell along {self._free(dim)}"}
                told["sample_dimension"] = self._free(dim)
                found[f"n_{dim}"] = (self.points.dims, np.reshape(each, self.points.shape), told)
        return found

    def _ends(self) -> dict[str, Any]:
        """How each cell ended."""
        status, trouble = self.survey.status, np.array(self.survey.trouble, dtype=str)
        bad, told = status[status != 0], flags(STATUS)
        dims, shape = self.points.dims, self.points.shape
        words = {"units": "1", "long_name": "what went wrong"}
        return {
            "status": ((), np.int8(bad[0] if len(bad) else 0), {"long_name": "how the sweep ended"} | told),
            "cell_status": (dims, status.reshape(shape), {"long_name": "how the cell ended"} | told),
            "trouble": (dims, trouble.reshape(shape), words),
        }


def _missing(kind: np.dtype) -> Any:
    return {"f": np.nan, "c": np.nan, "i": -1, "u": 0, "b": False}.get(kind.kind, "")
