"""One cell out of a sweep's result, under the names that it has by itself."""

from __future__ import annotations

import xarray as xr

from jointplay.errors import NOTHING, InputError, Problem
from jointplay.study.gather import OWN


def cell(dataset: xr.Dataset, **values: float) -> xr.Dataset:
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
    found = dataset.sel(values, method="nearest")
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
