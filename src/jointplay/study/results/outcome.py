"""A result as text: its status, and for some kinds a table in a file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from jointplay.analysis.labels import xr
from jointplay.display import codes
from jointplay.display.errors import NOTHING, refuse
from jointplay.display.number_text import listed
from jointplay.jobs.files import replaced
from jointplay.kinds import KINDS
from jointplay.solver.method.codes import Status

SHOWN = 8  # cells named


def name_of(dataset: xr.Dataset) -> str:
    """The status of a result by name, such as ``ok`` or ``step_limit``; `InputError` where it has not one."""
    status = dataset.get("status", xr.DataArray())
    try:
        return codes.flags(status)[status.item()]
    except (KeyError, ValueError, TypeError, AttributeError):
        several = f"{status.size} of them, over {', '.join(map(str, status.dims))}" if status.dims else None
        given = several or (status.item() if "status" in dataset else NOTHING)
        expected = "one status is accepted, as an analysis gives it; of several results take one, as by isel"
        raise refuse(given, expected, "status") from None


def explain(dataset: xr.Dataset) -> str | None:
    """Describe a failure and its remedy in a line, with the cells concerned; None when all is well."""
    name = name_of(dataset)
    if name == "ok":
        return None
    status, cells = Status[name.upper()], failed_cells(dataset)
    reason = dataset.attrs.get("trouble", f"{status.meaning}; {status.remedy}")  # no run failed: a search did
    for each in {"cell_status", "sample_status"} & {*dataset} if status == Status.BAD_PARAMETERS else ():
        reason = next(filter(None, dataset["trouble"].values[dataset[each].values == status]), reason)
    return f"{name}: {reason}" + (f" (in {listed(cells, SHOWN)})" if cells else "")


def failed_cells(dataset: xr.Dataset) -> list[str]:
    """Labels of the cells of a result whose own status is not ok, such as ``b no_tension``."""
    labels = []
    for name in (name for name in dataset.data_vars if str(name).endswith("_status") and dataset[name].dims):
        cells = dataset[name]
        for place in np.argwhere(cells.values != 0):
            label = (cells[dim].values[i] for dim, i in zip(cells.dims, place, strict=True))
            labels.append(" ".join(map(str, label)))
    return labels


def write_table(
    dataset: xr.Dataset, path: Path, table: Callable[[xr.Dataset], str] | None = None
) -> list[Path]:
    """Write the table of a result, its kind's own one if left out, if any; give back the files."""
    row = KINDS.get(str(dataset.attrs.get("kind")))
    table = table or (row.outputs.table if row else None)
    if table is None or "swept" in dataset.attrs:
        return []
    with replaced(path) as temporary:
        temporary.write_text(table(dataset), encoding="utf-8")
    return [path]
