"""Claims: a paper's conclusions, their grades, and the numbers behind these."""

from __future__ import annotations

import re
from textwrap import wrap
from typing import TYPE_CHECKING

from jointplay.display import codes
from jointplay.figures.drawing import artists, select, table
from jointplay.figures.registry import picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from xarray import Dataset

COLUMNS = {"Conclusion of the paper": 48.0, "Grade": 20.0, "Numbers": 110.0}  # mm of width
LETTERS = {"Conclusion of the paper": 37, "Grade": 14, "Numbers": 90}  # that fit them
LINE, AROUND, HEAD = 2.95, 3.0, 6.0  # mm: a line of text, above and below it in a row, the heading
MINUS = re.compile(r"(?<!\w)-(?=\d)")
SHADE = {"undecidable": 0.0, "not": 0.0, "partly": 0.35, "reproduced": 0.85}


@picture()
def claims(dataset: Dataset) -> Figure:
    """Draw a table: a row a conclusion, with its grade (the darker, the better it stands) and the evidence.

    Parameters
    ----------
    dataset : Dataset
        What `jointplay.claims` returned.
    """
    select.require(dataset, "claims", ("claim", "grade", "evidence"))
    rows = [row(dataset.isel(claim=number)) for number in range(dataset.sizes["claim"])]
    heights = [AROUND + LINE * max(len(words.splitlines()) for words in one) for one in rows]
    figure, ax = table.page(sum(COLUMNS.values()) + 2.0, HEAD + sum(heights) + 1.0)
    left = 1.0
    for name, width in COLUMNS.items():
        table.write(ax, left + 1.0, HEAD - 2.5, name, fontsize=7.5)
        left += width
    top = HEAD
    for words, height in zip(rows, heights, strict=True):
        draw_row(ax, words, top, height)
        top += height
    return artists.finish(figure, dataset)


def row(one: Dataset) -> tuple[str, ...]:
    """Return the words of a row, in lines that fit."""
    grade = codes.words(one["grade"]).item()
    numbers = MINUS.sub("\N{MINUS SIGN}", str(one["evidence"].item()))
    words = (str(one.get("claim_text", one["claim"]).item()), grade, numbers)
    return tuple("\n".join(wrap(text, LETTERS[name])) for text, name in zip(words, COLUMNS, strict=True))


def draw_row(ax: Axes, words: tuple[str, ...], top: float, height: float) -> None:
    """Draw one row of cells, from `top` mm on."""
    left = 1.0
    for name, text in zip(COLUMNS, words, strict=True):
        box = (left, top, COLUMNS[name], height)
        if name == "Grade":
            table.cell(ax, box, text, SHADE.get(text, 0.0))
        else:
            table.cell(ax, box)
            table.write(ax, left + 1.0, top + height / 2, text)
        left += COLUMNS[name]
