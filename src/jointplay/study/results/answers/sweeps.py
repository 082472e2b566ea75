"""Answers of studies with `[vary]`: what changes over the cells, failed ones first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jointplay.display.number_text import plain
from jointplay.display.units import measure
from jointplay.kinds import Kind, Shown
from jointplay.study.results.answers import stretches

if TYPE_CHECKING:
    from xarray import DataArray, Dataset


def answer(dataset: Dataset, row: Kind) -> str:
    """Return failures, the words of the cells, and the ends of the number that the sweep shows."""
    dims = str(dataset.attrs["swept"]).split()
    lines, good = stretches.failures(dataset, dims), (dataset["cell_status"] == 0).transpose(*dims).values
    if not good.any():
        return "\n".join(lines)
    if row.words:
        words = row.words(dataset).transpose(*dims).values.astype(object)
        words[~good] = stretches.FAILED
        lines.append(stretches.told(words.astype(str), _axes(dataset, dims)))
    shown = next((each for each in row.in_sweeps if each.name in dataset), None)
    if shown:
        lines += _ends(dataset, shown, dims)
    return "\n".join(lines or [f"{good.size} values, all ok"])


def _axes(dataset: Dataset, dims: list[str]) -> list[DataArray]:
    return [dataset[dim] for dim in dims]


def _ends(dataset: Dataset, shown: Shown, dims: list[str]) -> list[str]:
    """A line on the smallest and the largest value of a number over the cells."""
    if not dataset[shown.name].size:
        return []
    values = _of_cells(dataset, shown, dims)
    if not np.isfinite(values).any():
        return []
    units, name = str(dataset[shown.name].attrs.get("units", "1")), shown.title or shown.name
    finite = np.where(np.isfinite(values), values, np.nan)
    ends = []
    for at in (np.nanargmin(finite), np.nanargmax(finite)):
        place = np.unravel_index(at, values.shape)
        named = (
            f"{dim} {measure(dataset[dim].values[i], str(dataset[dim].attrs.get('units', '1')))}"
            for dim, i in zip(dims, place, strict=True)
        )
        ends.append(f"{_number(values[place], units)} ({', '.join(named)})")
    return [f"{name}: from {ends[0]} to {ends[1]}"]


def _number(value: float, units: str) -> str:
    return plain(value, 3) if units == "1" else measure(value, units, 3)


def _of_cells(dataset: Dataset, shown: Shown, dims: list[str]) -> np.ndarray:
    """The number of each cell: at the entries named, else the largest; moduli of complex ones."""
    array = dataset[shown.name].astype(float)
    if "part" in array.dims:
        array = np.sqrt((array**2).sum("part", skipna=False))
    for dim, entry in shown.entries:
        if dim in array.dims and entry != "largest":
            array = array.sel({dim: entry})
    rest = [dim for dim in array.dims if dim not in dims]
    return array.max(rest).transpose(*dims).values if rest else array.transpose(*dims).values
