"""A stress study as plain text: verdicts and statuses, slowest and worst scenes, and their study files."""

from __future__ import annotations

import numpy as np
import xarray as xr

from jointplay.display import codes

ROW = "{:>8}  {:<12} {:<14} {:<19} {:<18} {:<7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8}"
HEAD = ("scene", "verdict", "status", "variant", "geometry", "start")
HEAD += ("K (N/m)", "C (N s/m)", "differ", "growth", "energy", "ms per turn", "excess")
CODES = ("verdict", "scene_status", "variant", "geometry", "start")
FIGURES = ("stiffness", "damping", "disagreement", "growth", "energy_residual", "cpu_time", "excess")


def stress_summary(dataset: xr.Dataset) -> str:
    """Return a stress study as text: counts of verdicts and statuses, slowest and worst scenes.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.stress`.
    """
    ok, times = dataset["scene_status"].values == 0, dataset["cpu_time"].values
    median = float(np.nanmedian(times)) if np.isfinite(times).any() else np.nan
    slow = int(np.count_nonzero(ok & (times > 100 * median)))
    lines = [f"{dataset.sizes['scene']} scenes: {_counts(dataset['verdict'])}"]
    lines.append(f"ended with {_counts(dataset['scene_status'])}")
    lines.append(
        f"processor time of a turn: median {1e3 * median:.3g} ms; {slow} that ended ok took over 100 times it"
    )
    for word in ("slowest", "worst"):
        rows = (_row(dataset.sel(scene=number)) for number in dataset[word].values)
        lines += ["", word, ROW.format(*HEAD), *rows]
    return "\n".join(line.rstrip() for line in lines) + "\n"


def stress_table(dataset: xr.Dataset) -> str:
    """Return `stress_summary`, and a study file of each scene listed.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.stress`.
    """
    listed = {
        int(number): str(text)
        for word in ("slowest", "worst")
        for number, text in zip(dataset[word].values, dataset[f"{word}_lines"].values, strict=True)
    }
    files = (f"# {'-' * 30} scene-{number}.toml\n{text}" for number, text in listed.items())
    return "\n".join([stress_summary(dataset), *files])


def _counts(array: xr.DataArray) -> str:
    numbers = ((int(np.count_nonzero(array.values == i)), word) for i, word in codes.flags(array).items())
    return ", ".join(f"{number} {word}" for number, word in numbers if number)


def _row(one: xr.Dataset) -> str:
    words = (codes.words(one[name]).item() for name in CODES)
    scale = {"cpu_time": 1e3}
    figures = (_figure(float(one[name]) * scale.get(name, 1.0)) for name in FIGURES)
    return ROW.format(int(one["scene"]), *words, *figures)


def _figure(value: float) -> str:
    return f"{value:.1e}" if np.isfinite(value) else "-"
