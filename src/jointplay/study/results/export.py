"""A result for other programs: MATLAB's .mat, or a table of comma-separated values."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from io import BytesIO, StringIO
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import xarray as xr

from jointplay.display import codes
from jointplay.display.codes import coded
from jointplay.display.errors import NOTHING, InputError, of_a_result, refuse, unknown, warn
from jointplay.jobs.files import replaced
from jointplay.solver.mechanism.base import accepts
from jointplay.solver.mechanism.signature import checked
from jointplay.study.results.store import check_writable


@checked()
def export(
    dataset: Annotated[xr.Dataset, accepts("a result")],
    path: Annotated[Path | str, accepts("the name of a file")],
    over: Annotated[str | list[str] | tuple[str, ...] | None, accepts("names of dimensions")] = None,
) -> Path:
    """Write a result in another form, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    path : path-like
        The final name. ``.mat``: every variable under its name; structs ``units``, ``long_name``, ``comment``
        and ``dims`` by variable; ``words``, the texts of what is stored as codes; and ``attributes``.
        ``.csv``: one row of names with their units, as ``time [s]``, then one for each point of some
        dimensions: keys first, codes as words.
    over : sequence of str, optional
        Of a table, the dimensions of its rows; those of the largest variable if left out. Links, joints and
        states make columns, as ``angle:crank``; what has other dimensions is left out, and a `ModelWarning`
        names it.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        When there is no such form or dimension.

    Examples
    --------
    >>> import jointplay as jp
    >>> jp.export(jp.open("results/quickstart.nc"), "quickstart.csv", over=["time"])  # doctest: +SKIP
    """
    path = Path(path)
    if path.suffix not in FORMS:
        accepted = f"a name that ends in one of {', '.join(FORMS)} is accepted"
        raise refuse(str(path), accepted, "--out")
    over = [over] if isinstance(over, str) else over
    known = [str(dim) for dim in dataset.dims]
    if wrong := [unknown("--over", dim, dim, known, "dimension") for dim in over or () if dim not in known]:
        raise InputError(wrong)
    check_writable(path.parent, files=[path.name])
    with of_a_result(dataset):
        content = FORMS[path.suffix](dataset, over)
    with replaced(path) as temporary:
        temporary.write_bytes(content)
    return path


def _mat(dataset: xr.Dataset, _: Sequence[str] | None) -> bytes:
    from scipy.io import savemat

    variables = {str(name): variable for name, variable in dataset.variables.items()}
    structs = {
        key: {name: str(variable.attrs.get(key, "")) for name, variable in variables.items()}
        for key in ("units", "long_name", "comment")
    }
    told = words(dataset)
    structs["words"] = {name: _cells(told[name].values) for name in variables if coded(dataset[name])}
    structs["dims"] = {name: " ".join(map(str, variable.dims)) for name, variable in variables.items()}
    structs["attributes"] = {str(key): str(value) for key, value in dataset.attrs.items()}
    values = {name: _cells(variable.values) for name, variable in variables.items()}
    stream = BytesIO()
    try:
        savemat(stream, values | structs, do_compression=True, long_field_names=True, oned_as="column")
    except (TypeError, ValueError) as error:  # its names have 63 letters at most
        raise refuse(NOTHING, f"what a .mat file can hold is accepted: {error}", "result") from None
    return stream.getvalue()


def _cells(values: np.ndarray) -> np.ndarray:
    """Texts as MATLAB has them: cells, not rows of a character matrix."""
    return values.astype(object) if values.dtype.kind == "U" and values.ndim else values


def _csv(dataset: xr.Dataset, over: Sequence[str] | None) -> bytes:
    names = [dim for dim in dataset.dims if dim in dataset.coords and dataset[dim].dtype.kind in "UO"]
    largest = max(dataset.variables.values(), key=lambda variable: variable.size, default=xr.Variable((), 0))
    rows = list(dict.fromkeys(over or (dim for dim in largest.dims if dim not in names)))
    counted = {dim: (dim, np.arange(dataset.sizes[dim])) for dim in rows if dim not in dataset.variables}
    told = words(dataset).assign_coords(counted)
    keys = [*rows, *(name for name in told.coords if name not in rows)]
    every = [str(name) for name in dict.fromkeys((*keys, *told.variables))]
    columns = {name: [*_columns(told, name, rows, names)] for name in every}
    if left := [name for name, own in columns.items() if not own and name not in names]:
        also = sorted({str(dim) for name in left for dim in told[name].dims} - {*rows, *names})
        warn(
            f"not in the table: {', '.join(left)}" + (f"; theirs are over {', '.join(also)}" if also else "")
        )
    table = [column for own in columns.values() for column in own]
    stream = StringIO(newline="")
    writer = csv.writer(stream)
    writer.writerow([label if units in ("", "1") else f"{label} [{units}]" for label, units, _ in table])
    writer.writerows(zip(*(values.tolist() for _, _, values in table), strict=True))
    return stream.getvalue().encode()


def _columns(
    dataset: xr.Dataset, name: str, rows: Sequence[str], names: Sequence[str]
) -> Iterator[tuple[str, str, np.ndarray]]:
    """Columns of a variable: one, or one for each name that it is over."""
    variable = dataset[name].variable
    own = [dim for dim in variable.dims if dim in names and dim not in rows]
    if not set(variable.dims) & set(rows) or set(variable.dims) - {*rows, *own}:
        return
    units = str(variable.attrs.get("units", ""))
    for places in product(*(range(dataset.sizes[dim]) for dim in own)):
        at = dict(zip(own, places, strict=True))
        label = ":".join([name, *(str(dataset[dim].values[i]) for dim, i in at.items())])
        full = variable.isel(at).set_dims({dim: dataset.sizes[dim] for dim in rows})
        yield label, units, full.transpose(*rows).values.ravel()


FORMS: dict[str, Callable[[xr.Dataset, Sequence[str] | None], bytes]] = {".mat": _mat, ".csv": _csv}


@checked()
def words(dataset: Annotated[xr.Dataset, accepts("a result")]) -> xr.Dataset:
    """Give a copy of a result with words in place of all codes.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result. Files keep codes, with their words in ``flag_meanings``.

    Returns
    -------
    xarray.Dataset
        With ``status``, ``verdict``, ``stable``, ``branch_end``, ``event_kind``, ``event_joint`` (the joint's
        name) and all others that have flags as texts.

    Raises
    ------
    InputError
        When something else is given.

    Examples
    --------
    >>> import jointplay as jp
    >>> motion = jp.simulate(jp.catalog.impact_pair(3.6, 0.8), turns=1)  # doctest: +SKIP
    >>> jp.words(motion).status.item()  # doctest: +SKIP
    'ok'
    """
    with of_a_result(dataset):
        return _words(dataset)


def _words(dataset: xr.Dataset) -> xr.Dataset:
    return dataset.assign(
        {name: codes.words(dataset[name]) for name in dataset.variables if codes.coded(dataset[name])}
    )
