"""Answer of a result, in a few lines of text: on the terminal, in Python, in notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Annotated, Any

import numpy as np
import xarray as xr

from jointplay.analysis.declared import Outputs
from jointplay.display import codes
from jointplay.display.errors import of_a_result, refuse
from jointplay.display.number_text import measure, measured, plain
from jointplay.kinds import KINDS, load
from jointplay.solver.mechanism.base import accepts
from jointplay.solver.mechanism.signature import checked
from jointplay.study.results.outcome import explain

NO_KINDS = {"growth": ".analysis.exponents.growth:OUTPUTS"}  # analyses that no study asks for


@dataclass(frozen=True)
class Summary:
    """The answer of a result: text by `str`, a box in a notebook.

    Parameters
    ----------
    title : str
        The study's name and kind.
    lines : tuple of str
        The answer; the first line says the most.
    """

    title: str
    lines: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def __repr__(self) -> str:
        return f"{self.title}\n{self}" if self.title else str(self)

    def _repr_html_(self) -> str:
        lines = "<br>".join(escape(line) for line in self.lines)
        return f"<div><b>{escape(self.title)}</b><br>{lines}</div>"


@checked()
def summary(dataset: Annotated[xr.Dataset, accepts("a result")]) -> Summary:
    """Summarise a result in one to five lines.

    Parameters
    ----------
    dataset : xarray.Dataset
        What an analysis gave, or `jointplay.open`; of a single run or of a sweep.

    Returns
    -------
    Summary
        Prints as text; shows as a box in a notebook.

    Raises
    ------
    InputError
        When the dataset is no result of a known kind.

    Examples
    --------
    >>> import jointplay as jp
    >>> orbit = jp.periodic_orbit(jp.catalog.impact_pair(3.6, 0.8), initial=(0.0, 0.5), transient=50)
    >>> print(jp.summary(orbit))  # doctest: +SKIP
    period 1, stable, largest multiplier 0.8 in modulus
    """
    with of_a_result(dataset):
        return _summary(dataset)


def _summary(dataset: xr.Dataset) -> Summary:
    kind = str(dataset.attrs.get("kind"))
    if kind not in (*KINDS, *NO_KINDS):
        raise refuse(kind, f"a result of one of the kinds {', '.join(KINDS)} is accepted", "kind")
    name = str(dataset.attrs.get("study", ""))
    failure = explain(dataset) if "cell_status" not in dataset else None
    early = [f"stopped early: {failure}"] if failure else []
    return Summary(f"{name}: {kind}" if name else kind, (*early, *answer(dataset)))


def answer(dataset: xr.Dataset) -> list[str]:
    """Lines of the answer of a result of a known kind, whether it came to its end or not."""
    kind = str(dataset.attrs["kind"])
    outputs = load(NO_KINDS[kind]) if kind in NO_KINDS else KINDS[kind].outputs
    if "swept" in dataset.attrs:
        return over_cells(dataset, outputs).splitlines()
    if outputs.answer:
        return outputs.answer(dataset).splitlines()
    name = outputs.in_sweep(dataset)
    return [f"{outputs.shown[name] or name}: {plain(float(dataset[name].max()))}"] if name else []


def over_cells(dataset: xr.Dataset, outputs: Outputs) -> str:
    """Return failures, the words of the cells, and the ends of the number that the sweep shows."""
    dims = str(dataset.attrs["swept"]).split()
    lines, good = codes.failures(dataset, dims), (dataset["cell_status"] == 0).transpose(*dims).values
    if not good.any():
        return "\n".join(lines)
    if outputs.verdict:
        words = outputs.words(dataset).transpose(*dims).values.astype(object)
        words[~good] = codes.FAILED
        lines.append(codes.tally(words.astype(str), [dataset[dim] for dim in dims]))
    if name := outputs.in_sweep(dataset):
        lines += _ends(dataset, outputs, name, dims)
    return "\n".join(lines or [f"{good.size} values, all ok"])


def _ends(dataset: xr.Dataset, outputs: Outputs, name: str, dims: list[str]) -> list[str]:
    """A line on the smallest and the largest value of a number over the cells."""
    if not dataset[name].size:
        return []
    values = _of_cells(dataset[name], outputs.variables[name].at, dims)
    if not np.isfinite(values).any():
        return []
    units, title = str(dataset[name].attrs.get("units", "1")), outputs.shown[name] or name
    finite = np.where(np.isfinite(values), values, np.nan)
    ends = []
    for at in (np.nanargmin(finite), np.nanargmax(finite)):
        place = np.unravel_index(at, values.shape)
        named = (f"{d} {measured(dataset[d][i], dataset[d])}" for d, i in zip(dims, place, strict=True))
        ends.append(f"{measure(values[place], units, 3)} ({', '.join(named)})")
    return [f"{title}: from {ends[0]} to {ends[1]}"]


def _of_cells(array: xr.DataArray, at: Mapping[str, Any], dims: list[str]) -> np.ndarray:
    """The number of each cell: at the entries named, else the largest; moduli of complex ones."""
    array = array.astype(float)
    if "part" in array.dims:
        array = np.sqrt((array**2).sum("part", skipna=False))
    for dim, entry in at.items():
        if dim in array.dims and entry != "largest":
            array = array.sel({dim: entry})
    rest = [dim for dim in array.dims if dim not in dims]
    return array.max(rest).transpose(*dims).values if rest else array.transpose(*dims).values
