"""What a result answers, in a few lines of text: on the terminal, in Python, in notebooks."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Annotated

import xarray as xr

from jointplay.display.errors import of_a_result, refuse
from jointplay.display.number_text import plain
from jointplay.kinds import KINDS
from jointplay.solver.mechanism.base import accepts
from jointplay.solver.mechanism.signature import checked
from jointplay.study.results.answers import sweeps
from jointplay.study.results.outcome import explain


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
    """Say in one to three lines what a result answers.

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
    if kind not in KINDS:
        raise refuse(kind, f"a result of one of the kinds {', '.join(KINDS)} is accepted", "kind")
    name = str(dataset.attrs.get("study", ""))
    failure = explain(dataset) if "cell_status" not in dataset else None
    early = [f"stopped early: {failure}"] if failure else []
    return Summary(f"{name}: {kind}" if name else kind, (*early, *answer(dataset)))


def answer(dataset: xr.Dataset) -> list[str]:
    """Lines of the answer of a result of a known kind, whether it came to its end or not."""
    row = KINDS[str(dataset.attrs["kind"])]
    if "swept" in dataset.attrs:
        return sweeps.answer(dataset, row).splitlines()
    if row.answer:
        return row.answer(dataset).splitlines()
    shown = next((each for each in row.in_sweeps if each.name in dataset), None)
    return [f"{shown.title or shown.name}: {plain(float(dataset[shown.name].max()))}"] if shown else []
