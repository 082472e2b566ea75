"""Sheets of the paper's figures that are to be compared: drawn from stored results, with the same axes."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from jointplay import figures
from jointplay.results.store import open_result, write_figure
from jointplay.study.file import load

SHEETS = {
    "fig03": ("fig03a", "fig03b"),
    "fig05": ("fig05a", "fig05b"),
    "fig06": ("fig06a", "fig06b"),
    "fig08_09": ("fig08", "fig09a", "fig09b"),
    "fig12": ("fig12a", "fig12b", "fig12c"),
}


def write_sheets(folder: Path, out: Path, anew: Collection[str]) -> list[Path]:
    """Draw the sheets that show a result among those computed `anew`, where the others are stored as well.

    Parameters
    ----------
    folder, out : Path
        Where the studies are, and their results.
    anew : collection of str
        Names of studies.

    Returns
    -------
    list of Path
        The files written.
    """
    files = []
    for name, parts in SHEETS.items():
        there = all((out / f"{part}.nc").exists() and (folder / f"{part}.toml").exists() for part in parts)
        if there and not set(parts).isdisjoint(anew):
            drawn = figures.sheet_of(
                [(open_result(out / f"{p}.nc"), load(folder / f"{p}.toml").record.figure) for p in parts]
            )
            files += [write_figure(drawn, out / f"{name}.{ending}") for ending in ("pdf", "png")]
    return files
