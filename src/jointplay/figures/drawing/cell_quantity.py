"""Value of each cell of a sweep: the quantity, its entry and its error."""

from __future__ import annotations

from typing import Any

import numpy as np

from jointplay.display import codes
from jointplay.display.errors import NOTHING, InputError, Problem, raise_any, unknown
from jointplay.figures.drawing import DataArray, Dataset, select
from jointplay.kinds import KINDS

LARGEST = "largest"  # of all entries the one with the largest value
ENTRIES = {"exponent": 1, "multiplier": LARGEST}  # where none is asked for
COMPLEX = "part"  # the dimension of real and imaginary part; without a choice the modulus is meant
ERRORS = 2  # standard errors on either side
LISTED = 12  # entries named in an error


def varied(dataset: Dataset) -> list[str]:
    """Return the varied dimensions of a sweep's result; none of another dataset."""
    return [dim for dim in str(dataset.attrs.get("swept", "")).split() if dim in dataset.dims]


def known(dataset: Dataset) -> list[str]:
    """Return the numeric variables that cells have."""
    dims = set(varied(dataset))
    return [
        str(name)
        for name, array in dataset.data_vars.items()
        if dims <= set(array.dims) and array.dtype.kind in "fiu" and name != "cell_status"
    ]


def usual(dataset: Dataset) -> str | None:
    """Return the name of the quantity that a sweep shows by default; None where it has none."""
    row = KINDS.get(str(dataset.attrs.get("kind"))) if varied(dataset) else None
    return row.outputs.in_sweep(known(dataset)) if row else None


def cell_values(dataset: Dataset, quantity: str | None, at: dict[str, Any]) -> Dataset:
    """Return the value of each cell, at the entries that `at` names along the quantity's own dimensions.

    The dataset holds ``value`` with units and name, ``low`` and ``high`` where the result has errors or
    quartiles (the attribute ``reach`` says which), ``cell_status`` and ``status``.
    """
    first, names = usual(dataset), known(dataset)
    if quantity is None and first is None:
        raise InputError([Problem("figure.quantity", NOTHING, f"one of {', '.join(names)} is needed")])
    name = first if quantity is None and first else select.choice("quantity", quantity, names)
    outputs = KINDS[str(dataset.attrs["kind"])].outputs if name == first else None
    at_first, title_first = (outputs.variables[name].at, outputs.shown[name]) if outputs else ({}, "")
    array = numbers(dataset, name, modulus=COMPLEX not in at)
    own = [str(dim) for dim in array.dims if dim not in varied(dataset)]
    requested = {dim: entry for dim, entry in at.items() if dim not in varied(dataset)}
    entries = {dim: e for dim, e in {**ENTRIES, **at_first}.items() if dim in own} | requested
    refuse_wrong(array, own, entries)
    found = {"value": array} | spread(dataset, name, array, entries)
    for dim in own:
        index = entry_index(found["value"], dim, entries.get(dim, LARGEST))
        found = {key: each.isel({dim: index}) if dim in each.dims else each for key, each in found.items()}
    usually = title_first and not {*own} & at.keys()
    words = {"long_name": title_first if usually else title(array, own, entries)}
    found = {key: each.drop_vars(own, errors="ignore") for key, each in found.items()}
    found["value"] = found["value"].assign_attrs(array.attrs | words)
    reach = "quartiles" if "quartile" in own else f"± {ERRORS} standard errors"
    return dataset[["status", "cell_status"]].assign(found).assign_attrs(reach=reach, quantity=name)


def numbers(dataset: Dataset, name: str, modulus: bool = True) -> DataArray:
    """Return a variable as floats; -1 of whole numbers, which stands for a missing value, as NaN."""
    array = dataset[name]
    values = array.astype(float)
    if array.dtype.kind in "iu":
        means = -1 in codes.flags(array)
        values = values.where((values != -1) | (means & (dataset["cell_status"] == 0)))
    if COMPLEX in array.dims and modulus:
        values = np.sqrt((values**2).sum(COMPLEX, skipna=False))
    return values.transpose(..., *varied(dataset)).assign_attrs(array.attrs).rename(name)


def spread(dataset: Dataset, name: str, array: DataArray, entries: dict[str, Any]) -> dict[str, DataArray]:
    """Return lower and upper bounds of a quantity by its quartiles or errors; nothing without these."""
    if entries.get("quartile") == 0.5:
        return {end: array.sel(quartile=quarter) for end, quarter in (("low", 0.25), ("high", 0.75))}
    named = (f"{name}_error", f"{name}_standard_error", name.replace("exponent", "standard_error", 1))
    for error in (numbers(dataset, each) for each in named if each != name and each in dataset.data_vars):
        return {"low": array - ERRORS * error, "high": array + ERRORS * error}
    return {}


def refuse_wrong(array: DataArray, own: list[str], entries: dict[str, Any]) -> None:
    """Refuse entries and dimensions that do not exist, and a needed entry that is not named."""
    strange = [dim for dim in entries if dim not in own]
    wrong = [unknown(f"figure.at.{dim}", entries[dim], dim, own, "dimension") for dim in strange]
    for dim in own:
        given, values = entries.get(dim, NOTHING), array[dim].values.tolist()
        needed = given is NOTHING and len(values) > 1
        if needed or (given is not NOTHING and entry_index(array, dim, given) is None):
            named = ", ".join(map(str, values[:LISTED])) + (f" ... {values[-1]}" if values[LISTED:] else "")
            accepted = f"an entry along {dim} is accepted: {named}, or {LARGEST!r}"
            wrong.append(Problem(f"figure.at.{dim}", given, accepted))
    raise_any(wrong)


def entry_index(array: DataArray, dim: str, entry: Any) -> Any:
    """Return the index of an entry along a dimension, in each cell; None where there is no such entry."""
    values = array[dim].values
    if entry == LARGEST:
        return array.fillna(-np.inf).argmax(dim)
    if values.dtype.kind not in "iuf":
        return values.tolist().index(entry) if entry in values.tolist() else None
    if not select.is_number(entry):
        return None
    found = np.flatnonzero(np.isclose(values, float(entry), rtol=1e-6, atol=0.0))
    return int(found[0]) if found.size else None


def title(array: DataArray, own: list[str], entries: dict[str, Any]) -> str:
    """Return the name of a quantity at the named entries."""
    at = [f"{dim} {entries[dim]}" for dim in own if dim in entries and array.sizes[dim] > 1]
    return ", ".join([select.title(array), *at])
