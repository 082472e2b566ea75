"""Answers of the laboratory: comparisons of solvers and of schemes, and benchmarks."""

import numpy as np
import xarray as xr

from jointplay.display.number_text import plain

ROW = "{:<24} {:<8} {:>22} {:>22} {:>10} {:>10}"
HEAD = ("quantity", "units", "computed", "published", "difference", "relative")


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


def scheme_answer(dataset: xr.Dataset) -> str:
    """Return the number of cases in which the scheme's passes settle, and the errors of both methods.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.scheme_comparison`.
    """
    settles = dataset["converged"].any("windows_per_turn").values
    errors = (np.nanmin(dataset[name].values) for name in ("scheme_error", "monolithic_error"))
    scheme, ours = (plain(float(error), 2) for error in errors)
    return (
        f"the scheme's passes settle in {np.count_nonzero(settles)} of {settles.size} cases\n"
        f"smallest error of a deflection: {scheme} by the scheme, {ours} with all unknowns at once"
    )


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
