"""The paper's conclusions with their grades, and its readings, as plain text."""

from __future__ import annotations

import math
from textwrap import wrap

import numpy as np
import xarray as xr

from jointplay.display import codes
from jointplay.display.codes import counted

COLUMNS = {"separations": ".2f", "impacts": ".2f", "contact_fraction": ".4f", "extent": ".0e"}
STANDS = {"not": "not reproduced", "partly": "partly reproduced"} | {
    word: word for word in ("reproduced", "undecidable")
}
WIDTHS = (44, 12, 110)  # characters of conclusion, grade, evidence


def claims_table(dataset: xr.Dataset) -> str:
    """Return the paper's conclusions, their grades and the numbers behind these, as text in three columns.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.claims`.
    """
    grades = codes.words(dataset["grade"]).values
    rows = [("conclusion of the paper", "grade", "numbers"), tuple("-" * (width - 2) for width in WIDTHS)]
    for number, claim in enumerate(dataset.claim.values):
        one = dataset.sel(claim=claim)
        rows.append((f"{number + 1} {one.claim_text.item()}", grades[number], str(one.evidence.item())))
    return "".join(_lines(row) for row in rows)


def claims_answer(dataset: xr.Dataset) -> str:
    """Return the number of the paper's conclusions with each grade.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.claims`.
    """
    grades = np.array([STANDS[grade] for grade in codes.words(dataset["grade"]).values])
    return f"conclusions of the paper: {counted(grades)}"


def readings_answer(dataset: xr.Dataset) -> str:
    """Return the motion of each panel, counted over the readings of the paper.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.readings`.
    """
    motions = zip(dataset.panel.values, codes.words(dataset["motion"]).values, strict=True)
    return "\n".join(f"panel {panel}, {row.size} readings: {counted(row)}" for panel, row in motions)


def _lines(row: tuple[str, ...]) -> str:
    """A row of cells, each broken to the width of its column."""
    cells = [wrap(text, width - 2) or [""] for text, width in zip(row, WIDTHS, strict=True)]
    height = max(map(len, cells))
    padded = [cell + [""] * (height - len(cell)) for cell in cells]
    lines = zip(*padded, strict=True)
    return "".join("".join(map(str.ljust, line, WIDTHS)).rstrip() + "\n" for line in lines)


def readings_table(dataset: xr.Dataset) -> str:
    """Return every panel of Figure 12 under every reading as text, one a line.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `jointplay.readings`.
    """
    head = ("panel", "reading", *COLUMNS, "period", "growth per turn", "motion")
    motions = codes.words(dataset["motion"]).values
    rows = [_reading(dataset.isel(panel=p, reading=r), motions[p, r]) for p, r in np.ndindex(motions.shape)]
    both = (dataset.reading, dataset.reading_text)
    texts = [f"{name.item():<32}{text.item()}" for name, text in zip(*both, strict=True)]
    return "\n".join([_row(head), *map(_row, rows), "", *texts]) + "\n"


def _row(words: tuple[str, ...]) -> str:
    return "{:<7}{:<30}{:>12}{:>9}{:>18}{:>9}{:>8}  {:<18}{}".format(*words)


def _reading(one: xr.Dataset, motion: str) -> tuple[str, ...]:
    period = {0: "none", -1: "-"}.get(int(one.period), str(int(one.period)))
    growth = f"{_number(one.growth, '+.3f')} ± {_number(one.growth_standard_error, '.3f')}"
    numbers = (_number(one[name], form) for name, form in COLUMNS.items())
    return one.panel.item(), one.reading.item(), *numbers, period, growth.replace("- ± -", "-"), motion


def _number(value: xr.DataArray, form: str) -> str:
    """A number as text, a dash where there is none."""
    return format(float(value), form) if math.isfinite(value) else "-"
