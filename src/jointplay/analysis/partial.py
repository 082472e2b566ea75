"""Partial results of an interrupted run, within a second: of very many samples every n-th one."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

from jointplay.solver.motion.progress import Aborted, Stopped
from jointplay.solver.motion.trajectory import INTERRUPTED, Records

if TYPE_CHECKING:
    import xarray as xr

MOST = 100_000  # samples of an interrupted motion whose quantities are evaluated: a tenth of a second


def evaluated(
    records: Records, rows: int, dim: str, make: Callable[[Records, int], xr.Dataset]
) -> xr.Dataset:
    """The dataset that is made of a run's records and every so many-th of its rows along `dim`.

    Every row counts, unless the run was interrupted, or is so now; then at most `MOST` do.
    """
    if records.status != INTERRUPTED:
        with suppress(Stopped, Aborted):
            return make(records, 1)
        records = replace(records, status=INTERRUPTED)
    step = math.ceil(max(rows, 1) / MOST)
    return noted(make(records, step), step, dim)


def thinned(dataset: xr.Dataset, most: int) -> xr.Dataset:
    """Every n-th entry of a dataset along the dimension that has most of it: at most so many bytes."""
    if dataset.nbytes <= most:
        return dataset
    held = {dim: sum(v.nbytes for v in dataset.variables.values() if dim in v.dims) for dim in dataset.sizes}
    dim = max(held, key=lambda each: held[each])
    step = math.ceil(held[dim] / max(most - (dataset.nbytes - held[dim]), 1 + most // 2))
    return noted(dataset.isel({dim: slice(None, None, step)}), step, str(dim))


def noted(dataset: xr.Dataset, step: int, dim: str) -> xr.Dataset:
    """The dataset, which says where it has only every so many-th entry along a dimension."""
    if step == 1:
        return dataset
    before = f"{dataset.attrs['partial']}, and of these " if "partial" in dataset.attrs else ""
    return dataset.assign_attrs(partial=f"{before}1 in {step} of what was computed along {dim}")
