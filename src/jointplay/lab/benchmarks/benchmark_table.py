"""A benchmark as text: its table of digits, and the worst of them."""

import numpy as np
import xarray as xr

ROW = "{:<18} {:<8} {:>22} {:>22} {:>10} {:>10}"
HEAD = ("quantity", "units", "computed", "published", "difference", "relative")


def benchmark_table(dataset: xr.Dataset) -> str:
    """Return the quantities, computed and published, with their differences.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.benchmark`.
    """
    words = ("quantity", "quantity_units", "computed", "published", "difference", "relative_difference")
    rows = zip(*(dataset[word].values for word in words), strict=True)
    lines = (
        ROW.format(*row[:2], *(f"{x:.15e}" for x in row[2:4]), *(f"{x:.1e}" for x in row[4:])) for row in rows
    )
    return "\n".join([ROW.format(*HEAD), *lines]) + "\n"


def benchmark_answer(dataset: xr.Dataset) -> str:
    """Return the largest relative difference.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.benchmark`.
    """
    off = dataset["relative_difference"].values
    worst = dataset["quantity"].values[np.argmax(off)]
    return f"all {off.size} published quantities to {off.max():.1e} or better (worst: {worst})"
