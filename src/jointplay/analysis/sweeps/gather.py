"""From the answers of cells to one labelled dataset, cells along the varied dimensions, and back to one cell.

A variable of the cells gets the varied dimensions in front. Along names (links, joints, states) cells are
aligned by name; along numbers they stand one after another, and missing values of a shorter one are NaN (-1
of whole numbers, an empty text). A coordinate that differs from cell to cell, and a variable whose name a
varied parameter has taken, is called ``cell_`` and its name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Annotated, Any, Protocol

import numpy as np
import xarray as xr

from jointplay.analysis.cells import Read
from jointplay.analysis.evaluate import on_joints
from jointplay.analysis.labels import Out, along
from jointplay.analysis.quantities import STATUS
from jointplay.display.errors import NOTHING, InputError, Problem, raise_any
from jointplay.jobs.columns import PARTS, Field, Form, Plain, shared, thawed
from jointplay.jobs.journal import refuse_lost
from jointplay.solver.mechanism.base import accepts, is_number
from jointplay.solver.mechanism.signature import checked

Parts = tuple[tuple[str, ...], np.ndarray, dict[str, Any]]
OWN = "cell_"
ENDED = Out((), "how the sweep ended", flags=STATUS)
OF_CELL = {"cell_status": Out((), "how the cell ended", flags=STATUS), "trouble": Out((), "what went wrong")}


class Grid(Protocol):
    """Grid of cells: the varied dimensions, the numbers of cells along them, and their coordinates."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coordinates: dict[str, Any]


def plain(dataset: xr.Dataset) -> Plain:
    """Split a dataset into a layout, shared by all alike, and the values of its variables in that order."""
    coords, values, fields = set(dataset.coords), [], []
    for name, variable in dataset.variables.items():
        part = "coords" if name in coords else "variables"
        fields.append((part, str(name), tuple(map(str, variable.dims)), variable.attrs))
        values.append(np.asarray(variable.values))
    return Plain(shared(fields, dataset.attrs), values)


def dataset(kind: str, grid: Grid, keys: Sequence[str], read: Read) -> xr.Dataset:
    """Put the answers of all cells together.

    Parameters
    ----------
    kind : str
        Of the study.
    grid, keys
        The cells and their keys, the last dimension fastest.
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
    stack = _Stack(grid, survey)
    for key, answer in read():
        if "dataset" in answer:
            stack.put(key, answer["dataset"].values)
    return stack.whole(kind)


class _Stack:
    """Cells on their way into one dataset: an array for each variable, cells first."""

    def __init__(self, grid: Grid, survey: Survey) -> None:
        self.grid, self.survey = grid, survey
        self.taken = {*grid.dims, *grid.coordinates, "status", "trouble"}
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
        attributes = dict(self.survey.attributes()) | {"Conventions": "CF-1.11", "kind": kind}
        attributes["swept"] = " ".join(self.grid.dims)
        fields |= self._counts() | self._ends()
        return on_joints(xr.Dataset(fields, coords | self.grid.coordinates, attributes))

    def _free(self, name: str, own: bool = False) -> str:
        return OWN + name if own or name in self.taken else name

    def _dims(self, dims: Sequence[str]) -> tuple[str, ...]:
        return tuple(self._free(dim) for dim in dims)

    def _shared(self) -> tuple[dict[str, Parts], list[str]]:
        """Coordinates that cells have in common, and names of the ones that each has for itself."""
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
        shape = (*self.grid.shape, *full.shape[1:])
        return (*self.grid.dims, *self._dims(field.dims)), full.reshape(shape), thawed(field.attrs)

    def _counts(self) -> dict[str, Any]:
        """Number of entries of each cell along dimensions where cells differ."""
        counts = {}
        for dim in self.survey.sizes:
            each, name = self.survey.lengths(dim), self._free(dim)
            if dim not in self.survey.labels and len(set(each)) > 1:
                attributes = {"units": "1", "long_name": f"entries of the cell along {name}"}
                attributes["sample_dimension"] = name
                counts[f"n_{dim}"] = (self.grid.dims, np.reshape(each, self.grid.shape), attributes)
        return counts

    def _ends(self) -> dict[str, Any]:
        """Status of the sweep and of each cell."""
        status, trouble = self.survey.status, np.array(self.survey.trouble, dtype=str)
        cells, outs = {"cell_status": status, "trouble": trouble}, along(OF_CELL, *self.grid.dims)
        found = {name: outs[name].variable(each.reshape(self.grid.shape)) for name, each in cells.items()}
        return {"status": ENDED.variable(next(iter(status[status != 0]), 0))} | found


def _missing(kind: np.dtype) -> Any:
    return {"f": np.nan, "c": np.nan, "i": -1, "u": 0, "b": False}.get(kind.kind, "")


@checked()
def cell(dataset: Annotated[xr.Dataset, accepts("a result")], **values: Any) -> xr.Dataset:
    """Take one cell out of a sweep, as the analysis by itself would give it.

    Parameters
    ----------
    dataset : xarray.Dataset
        The result of a study with `[vary]`.
    **values : float
        Of each varied parameter, the nearest one there is; of a study with cases, ``case`` and its number.

    Returns
    -------
    xarray.Dataset
        With the names and lengths of that cell, its ``status``, and ``trouble``, what went wrong.

    Raises
    ------
    InputError
        When the values do not name one cell.
    """
    dims = str(dataset.attrs.get("swept", "")).split()
    if not dims or set(values) != set(dims):
        expected = f"one value of each of {', '.join(dims)} is needed" if dims else "a sweep is accepted"
        raise InputError([Problem("cell", values or NOTHING, expected)])
    numbers = values.items()
    raise_any(Problem(name, each, "a number is accepted") for name, each in numbers if not is_number(each))
    try:
        found = dataset.sel(values, method="nearest")
    except (KeyError, TypeError, ValueError, IndexError) as error:
        expected = f"a number for each of {', '.join(dims)}, of those in the result, is accepted"
        raise InputError([Problem("cell", values, expected)]) from error
    counts = {name: v.attrs["sample_dimension"] for name, v in found.items() if "sample_dimension" in v.attrs}
    found = found.isel({dim: slice(int(found[name])) for name, dim in counts.items()})
    along = (name for name, each in dataset.coords.items() if each.dims and set(each.dims) <= set(dims))
    varied = [name for name in along if not str(name).startswith(OWN)]
    found = found.drop_vars([*counts, *varied, "status"])
    found.attrs.pop("swept")
    return _own_names(found)


def _own_names(found: xr.Dataset) -> xr.Dataset:
    """Take `OWN` off every name again; a coordinate along its own dimension becomes its index."""
    taken = [str(name) for name in (*found.variables, *found.dims) if str(name).startswith(OWN)]
    back = {name: name.removeprefix(OWN) for name in taken}
    along = [name for name in taken if name in found and found[name].dims in ((name,), (back[name],))]
    indices = {back[name]: found[name].variable for name in along}
    rest = found.drop_vars(along)
    rest = rest.rename({name: back[name] for name in taken if name in (*rest.variables, *rest.dims)})
    return rest.assign_coords({name: (name, v.values, v.attrs) for name, v in indices.items()})


class Common:
    """The longest values that cells have for a coordinate, and whether all others are its beginnings."""

    def __init__(self) -> None:
        self.fits, self.number = True, -1
        self.field: Field
        self.values = np.empty(0)

    def see(self, number: int, field: Field, values: np.ndarray) -> None:
        """Take in the values of a cell; of equally long ones, the first cell's count."""
        first = self.number < 0
        longer = first or (values.size, -number) > (self.values.size, -self.number)
        if not first:
            pair = (values, self.values) if longer else (self.values, values)
            self.fits = self.fits and _begins(*pair)
        if longer:
            self.fits = self.fits and _begins(values, values)
            self.number, self.field, self.values = number, field, values


class Survey:
    """Forms and ends of all cells.

    Parameters
    ----------
    keys : sequence of str
        Of each cell; cells that come to the same share one.
    """

    def __init__(self, keys: Sequence[str]) -> None:
        self.places: dict[str, list[int]] = {}
        for number, key in enumerate(keys):
            self.places.setdefault(key, []).append(number)
        self.status = np.full(len(keys), -1, dtype=np.int8)
        self.trouble = [""] * len(keys)
        self.form: list[Form | None] = [None] * len(keys)
        self.common: dict[str, Common] = {}
        self._known: dict[Form, Form] = {}

    def see(self, key: str, answer: Mapping[str, Any]) -> None:
        """Take in the answer of a cell."""
        form, numbers = None, self.places[key]
        if "dataset" in answer:
            found = Form.of(answer["dataset"])
            form = self._known.setdefault(found, found)
            for i, field in form.fields("coords"):
                if field.name not in form.labels:
                    common = self.common.setdefault(field.name, Common())
                    common.see(numbers[0], field, answer["dataset"].values[i])
        for number in numbers:
            self.status[number], self.trouble[number] = answer["status"], answer.get("trouble", "")
            self.form[number] = form

    @cached_property
    def forms(self) -> list[Form]:
        """Every form once, in the order of the cells."""
        return list(dict.fromkeys(form for form in self.form if form is not None))

    def names(self, part: str) -> list[str]:
        """Names of all variables, or of all coordinates."""
        return list(dict.fromkeys(field.name for form in self.forms for _, field in form.fields(part)))

    def having(self, part: str, name: str) -> list[tuple[Form, int, Field]]:
        """Forms that hold a variable, each with the field's number and the field."""
        return [
            (form, i, field) for form in self.forms for i, field in form.fields(part) if field.name == name
        ]

    @cached_property
    def labels(self) -> dict[str, list[str]]:
        """Labels along each dimension that is labelled in every cell."""
        each = {name: [form.labels.get(name) for form, *_ in self.having("coords", name)]
                for name in self.names("coords")}  # fmt: skip
        return {
            name: list(dict.fromkeys(label for labels in found for label in labels or ()))
            for name, found in each.items()
            if None not in found
        }

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Length of the longest cell along each dimension; of a labelled one, the number of labels."""
        sizes: dict[str, int] = {}
        for part in PARTS:
            for form in self.forms:
                for _, field in form.fields(part):
                    sizes |= {dim: max(sizes.get(dim, 0), form.sizes[dim]) for dim in field.dims}
        return sizes | {dim: len(names) for dim, names in self.labels.items()}

    def lengths(self, dim: str) -> list[int]:
        """Number of entries of each cell along a dimension."""
        return [0 if form is None else form.sizes.get(dim, 0) for form in self.form]

    def attributes(self) -> Iterator[tuple[str, Any]]:
        """Attributes of the whole that all cells have in common."""
        tables = [form.layout.attrs for form in self.forms if form.layout.attrs]
        for key, value in tables[0].items() if tables else ():
            if all(np.array_equal(each.get(key), value) for each in tables):
                yield key, value


def _begins(longest: np.ndarray, values: np.ndarray) -> bool:
    """Whether values are where a longer array begins."""
    if values.ndim != 1 or longest.ndim != 1:
        return values.shape == longest.shape and np.array_equal(values, longest)
    return np.array_equal(longest[: len(values)], values)
