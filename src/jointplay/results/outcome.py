"""What a status means, in a sentence, and what to try."""

import numpy as np
import xarray as xr

from jointplay.numerics.codes import Status

SHOWN = 8  # cells named


def name_of(dataset: xr.Dataset) -> str:
    """The status of a result by name, such as ``ok`` or ``step_limit``."""
    status = dataset["status"]
    names = dict(zip(status.attrs["flag_values"], status.attrs["flag_meanings"].split(), strict=True))
    return names[int(status)]


def explain(dataset: xr.Dataset) -> str | None:
    """Say in a line what went wrong and what to try, with the cells in which; None when all is well."""
    name = name_of(dataset)
    if name == "ok":
        return None
    status = Status[name.upper()]
    cells = failed_cells(dataset)
    shown = ", ".join(cells[:SHOWN]) + (f" and {len(cells) - SHOWN} more" if len(cells) > SHOWN else "")
    return f"{name}: {status.meaning}; {status.remedy}" + (f" (in {shown})" if cells else "")


def failed_cells(dataset: xr.Dataset) -> list[str]:
    """Labels of the cells of a result whose own status is not ok, such as ``b no_tension``."""
    found = []
    for name in (name for name in dataset.data_vars if str(name).endswith("_status")):
        cells = dataset[name]
        for place in np.argwhere(cells.values != 0):
            labels = (cells[dim].values[i] for dim, i in zip(cells.dims, place, strict=True))
            found.append(" ".join(map(str, labels)))
    return found
