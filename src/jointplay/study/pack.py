"""Answers of cells as a part of the journal holds them: an array for each variable of all cells of one form.

So a part of many short cells is read and written as fast as a few arrays, and says names and attributes once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from jointplay.study.layout import Layout, Plain
from jointplay.study.survey import Form

Block = tuple[list[int], Layout, list[np.ndarray]]  # which answers, and their values one after another
Packed = tuple[list[dict[str, Any]], list[Block]]  # answers without their datasets, and these


def packed(answers: Sequence[Mapping[str, Any]]) -> Packed:
    """Put the datasets of answers together where they have the same form."""
    places: dict[Form, list[int]] = {}
    for place, answer in enumerate(answers):
        if isinstance(answer.get("dataset"), Plain):
            places.setdefault(Form.of(answer["dataset"]), []).append(place)
    within = {place for each in places.values() for place in each}
    rest = [
        {key: value for key, value in answer.items() if key != "dataset" or place not in within}
        for place, answer in enumerate(answers)
    ]
    return rest, [_block(form, each, answers) for form, each in places.items()]


def _block(form: Form, places: list[int], answers: Sequence[Mapping[str, Any]]) -> Block:
    columns = zip(*(answers[place]["dataset"].values for place in places), strict=True)
    return places, form.layout, [_together(column) for column in columns]


def _together(column: Sequence[np.ndarray]) -> np.ndarray:
    found = np.empty((len(column), *column[0].shape), column[0].dtype)
    for n, values in enumerate(column):  # for a few small arrays `np.stack` takes several times as long
        found[n] = values
    return found


def unpacked(answers: list[dict[str, Any]], blocks: Sequence[Block]) -> list[dict[str, Any]]:
    """Give each answer its dataset back; values are views of what the block holds."""
    for places, layout, columns in blocks:
        for n, place in enumerate(places):
            answers[place]["dataset"] = Plain(layout, [column[n, ...] for column in columns])
    return answers
