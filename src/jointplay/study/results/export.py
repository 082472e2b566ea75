"""A result for other programs: MATLAB's .mat, or a table of comma-separated values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Annotated

import numpy as np
import xarray as xr

from jointplay.display import codes
from jointplay.display.codes import coded
from jointplay.display.errors import NOTHING, of_a_result, raise_any, refuse, strangers, warn
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
    raise_any(strangers((("--over", dim) for dim in over or ()), known, "dimension"))
    check_writable(path.parent, files=[path.name])
    with of_a_result(dataset):
        content = FORMS[path.suffix](dataset, over)
    with replaced(path) as temporary:
        temporary.write_bytes(content)
    return path


def _mat(dataset: xr.Dataset, _: Sequence[str] | None) -> bytes:
    from scipy.io import savemat

    decoded, variables = words(dataset), dataset.variables
    content = {name: _cells(variable.values) for name, variable in variables.items()}
    for key in ("units", "long_name", "comment"):
        content[key] = {name: str(variable.attrs.get(key, "")) for name, variable in variables.items()}
    content["words"] = {name: _cells(decoded[name].values) for name in variables if coded(dataset[name])}
    content["dims"] = {name: " ".join(map(str, variable.dims)) for name, variable in variables.items()}
    content["attributes"] = {key: str(value) for key, value in dataset.attrs.items()}
    stream = BytesIO()
    try:
        savemat(stream, content, do_compression=True, long_field_names=True, oned_as="column")
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
    if not rows:
        expected = "a result with dimensions is accepted for a table; a .mat file holds any"
        raise refuse(NOTHING, expected, "result")
    table = words(dataset)
    table = table.assign_coords({dim: table[dim] for dim in rows})  # of a dimension without values, 0, 1, …
    every = [name for name in dict.fromkeys((*table.coords, *table.variables)) if name not in rows]
    columns = {name: _columns(table, name, rows, names) for name in every}
    if left := [name for name in every if not columns[name] and name not in names]:
        groups: dict[str, list[str]] = {}
        for name in left:
            dims = " and ".join(str(dim) for dim in table[name].dims if dim not in names)
            groups.setdefault(f"over {dims}" if dims else f"not over {' and '.join(rows)}", []).append(name)
        lists = (f"{', '.join(each)} ({dims})" for dims, each in groups.items())
        warn(f"not in the table: {'; '.join(lists)}")
    found = {label: column for own in columns.values() for label, column in own.items()}
    frame = xr.Dataset(found, {dim: table[dim].variable for dim in rows}).to_dataframe(rows).reset_index()
    units = [str({**table.variables, **found}[label].attrs.get("units", "")) for label in frame]
    header = [
        f"{label} [{unit}]" if unit not in ("", "1") else label
        for label, unit in zip(frame, units, strict=True)
    ]
    return frame.to_csv(index=False, header=header, na_rep="nan", lineterminator="\r\n").encode()


def _columns(
    dataset: xr.Dataset, name: str, rows: Sequence[str], names: Sequence[str]
) -> dict[str, xr.Variable]:
    """Columns of a variable by their labels: one, or one for each name that it is over."""
    variable = dataset[name].variable
    own = [dim for dim in variable.dims if dim in names and dim not in rows]
    if not set(variable.dims) & set(rows) or set(variable.dims) - {*rows, *own}:
        return {}
    every = [
        dict(zip(own, places, strict=True)) for places in product(*(range(dataset.sizes[dim]) for dim in own))
    ]
    return {
        ":".join([name, *(str(dataset[dim].values[i]) for dim, i in at.items())]): variable.isel(at)
        for at in every
    }


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
        return dataset.assign(
            {name: codes.words(dataset[name]) for name in dataset.variables if coded(dataset[name])}
        )
