"""Answer of a comparison of solvers."""

import numpy as np
import xarray as xr

from jointplay.display.number_text import plain


def precision_answer(dataset: xr.Dataset) -> str:
    """Return the fastest solver at each error that two or more reach, and whether the truth is confirmed.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.work_precision`.
    """
    lines = []
    for level in dataset["error_level"].values:
        times = dataset["cpu_time_at_error"].sel(error_level=level)
        if np.count_nonzero(np.isfinite(times)) > 1:
            best = int(np.nanargmin(times.values))
            took = f"{plain(1e3 * float(times[best]), 3)} ms per turn"
            lines.append(f"at an error of {plain(float(level), 1)}: {times['solver'].values[best]}, {took}")
    by = dataset.attrs.get("truth_confirmed_by", "none")
    truth = (
        f"the truth is confirmed by {by}" if int(dataset["truth_confirmed"]) else "the truth is not confirmed"
    )
    return "\n".join([*lines[:2], truth])
