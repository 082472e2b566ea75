"""Survey of the answers of a sweep's cells: which variables, of which sizes, with which labels.

The shape of the whole follows from the few forms that cells have, however many there are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from jointplay.jobs.columns import PARTS, Field, Form


class Common:
    """The longest values that cells have for a coordinate, and whether all others are its beginnings."""

    def __init__(self) -> None:
        self.fits, self.number = True, -1
        self.field: Field
        self.values = np.empty(0)

    def see(self, number: int, field: Field, values: np.ndarray) -> None:
        """Take in the values of a cell; of equally long ones, the first cell's count."""
        first = self.number < 0
        longer = first or (values.size, -number) > (self.values.size, -self.number)
        if not first:
            pair = (values, self.values) if longer else (self.values, values)
            self.fits = self.fits and _begins(*pair)
        if longer:
            self.fits = self.fits and _begins(values, values)
            self.number, self.field, self.values = number, field, values


class Survey:
    """Forms and ends of all cells.

    Parameters
    ----------
    keys : sequence of str
        Of each cell; cells that come to the same share one.
    """

    def __init__(self, keys: Sequence[str]) -> None:
        self.places: dict[str, list[int]] = {}
        for number, key in enumerate(keys):
            self.places.setdefault(key, []).append(number)
        self.status = np.full(len(keys), -1, dtype=np.int8)
        self.trouble = [""] * len(keys)
        self.form: list[Form | None] = [None] * len(keys)
        self.common: dict[str, Common] = {}
        self._known: dict[Form, Form] = {}

    def see(self, key: str, answer: Mapping[str, Any]) -> None:
        """Take in the answer of a cell."""
        form, numbers = None, self.places[key]
        if "dataset" in answer:
            found = Form.of(answer["dataset"])
            form = self._known.setdefault(found, found)
            for i, field in form.fields("coords"):
                if field.name not in form.labels:
                    common = self.common.setdefault(field.name, Common())
                    common.see(numbers[0], field, answer["dataset"].values[i])
        for number in numbers:
            self.status[number], self.trouble[number] = answer["status"], answer.get("trouble", "")
            self.form[number] = form

    @cached_property
    def forms(self) -> list[Form]:
        """Every form once, in the order of the cells."""
        return list(dict.fromkeys(form for form in self.form if form is not None))

    def names(self, part: str) -> list[str]:
        """Names of all variables, or of all coordinates."""
        return list(dict.fromkeys(field.name for form in self.forms for _, field in form.fields(part)))

    def having(self, part: str, name: str) -> list[tuple[Form, int, Field]]:
        """Forms that hold a variable, each with the field's number and the field."""
        return [
            (form, i, field) for form in self.forms for i, field in form.fields(part) if field.name == name
        ]

    @cached_property
    def labels(self) -> dict[str, list[str]]:
        """Labels along each dimension that is labelled in every cell."""
        each = {name: [form.labels.get(name) for form, *_ in self.having("coords", name)]
                for name in self.names("coords")}  # fmt: skip
        return {
            name: list(dict.fromkeys(label for labels in found for label in labels or ()))
            for name, found in each.items()
            if None not in found
        }

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Length of the longest cell along each dimension; of a labelled one, the number of labels."""
        sizes: dict[str, int] = {}
        for part in PARTS:
            for form in self.forms:
                for _, field in form.fields(part):
                    sizes |= {dim: max(sizes.get(dim, 0), form.sizes[dim]) for dim in field.dims}
        return sizes | {dim: len(names) for dim, names in self.labels.items()}

    def lengths(self, dim: str) -> list[int]:
        """Number of entries of each cell along a dimension."""
        return [0 if form is None else form.sizes.get(dim, 0) for form in self.form]

    def attributes(self) -> Iterator[tuple[str, Any]]:
        """Attributes of the whole that all cells have in common."""
        tables = [form.layout.attrs for form in self.forms if form.layout.attrs]
        for key, value in tables[0].items() if tables else ():
            if all(np.array_equal(each.get(key), value) for each in tables):
                yield key, value


def _begins(longest: np.ndarray, values: np.ndarray) -> bool:
    """Whether values are where a longer array begins."""
    if values.ndim != 1 or longest.ndim != 1:
        return values.shape == longest.shape and np.array_equal(values, longest)
    return np.array_equal(longest[: len(values)], values)
