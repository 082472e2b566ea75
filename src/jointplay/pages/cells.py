"""Cells of a sweep, as a page shows the selected one: numbers, points or curves, how to run it again."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from xarray import DataArray, Dataset

from jointplay.display.units import PLAIN
from jointplay.figures.drawing import artists, cell_quantity, select, sweep_axes
from jointplay.pages import packed, texts, thin

KEY = re.compile(r"[\w.\[\]-]+")  # of a parameter: others cannot stand in a command
WORDS = {"period": {"0": "none found", "-1": "not known"}}  # of numbers that are none
FEW = 8  # entries along a dimension that are numbers of their own, not points of a curve
ROWS = 60  # numbers of a cell
STORED = 400_000  # values of all cells' points and curves, 2 MB of a page
LONG = ("point", "turn", "time")
FORCES = ("normal_force", "reaction", "angular_acceleration", "state_value")
PLACES = (("journal_x", "journal_y"), ("eccentricity", "normal_velocity"))


def parameters(dataset: Dataset) -> list[str]:
    """Return the varied parameters of a sweep; none of another result."""
    if "cell_status" in dataset and dataset.attrs.get("kind") == "bifurcation":
        return sweep_axes.parameters(dataset, "bifurcation")
    return cell_quantity.varied(dataset)


def cells(dataset: Dataset, study: dict[str, Any]) -> dict[str, Any] | None:
    """Return what a page needs of a sweep's cells, ready for `packed.text`; None where there is no sweep.

    Parameters
    ----------
    dataset : Dataset
        A result.
    study : dict
        The study that it answers, resolved; empty where it holds none.
    """
    names = parameters(dataset)
    if not names:
        return None
    beside = [dim for dim in sweep_axes.BESIDE if dim in dataset["cell_status"].dims]
    ways = list(product(*(map(str, dataset[dim].values) for dim in beside)))
    charts, note = curves(dataset, [*names, *beside])
    return {
        "parameters": [axis(dataset, name, list(study.get("vary") or {})) for name in names],
        "ways": [" ".join(f"start {w}" if w.isdigit() else w for w in way) for way in ways],
        "rows": list(rows(dataset, [*names, *beside])),
        "charts": charts,
        "note": note,
        "file": shlex.quote(texts.file_name({"study": study})),
    }


def axis(dataset: Dataset, name: str, keys: list[str]) -> dict[str, Any]:
    """Return the values of a parameter, stored and as its axis shows them, and its key in a study."""
    values, unit = artists.displayed(dataset[name])
    key = next((key for key in keys if key.rpartition(".")[2] == name and KEY.fullmatch(key)), "")
    symbol = "" if unit.symbol == PLAIN["1"] else unit.symbol
    words = {"name": name, "title": select.title(dataset[name]), "unit": symbol, "key": key}
    stored, log = dataset[name].values.tolist(), sweep_axes.is_log(dataset[name].values)
    return words | {"values": values.tolist(), "stored": stored, "log": log}


def rows(dataset: Dataset, grid: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the numbers of each cell, a row each: its label, unit, and values along the grid."""
    known = [name for name, each in dataset.data_vars.items() if set(grid) <= set(each.dims)]
    found = (row for name in known for row in entries(dataset[name], grid))
    yield from (row for row, _ in zip(found, range(ROWS), strict=False))


def entries(array: DataArray, grid: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the rows of a variable: one for each of its few entries beside the grid."""
    own = [str(dim) for dim in array.dims if dim not in grid]
    if any(is_long(array, dim) for dim in own):
        return
    values, unit = (array.values, None) if array.dtype.kind not in "fiu" else artists.displayed(array)
    flat = array.copy(data=values).transpose(*grid, ...)
    for place in product(*(range(array.sizes[dim]) for dim in own)):
        one = flat.isel(dict(zip(own, place, strict=True)))
        which = [str(one[dim].values) for dim in own if dim in one.coords and array.sizes[dim] > 1]
        flags = {str(code): word.replace("_", " ") for code, word in select.flags(array).items()}
        flags = flags or WORDS.get(str(array.name), {})
        label = ", ".join([select.title(array), *which])
        yield {
            "label": label,
            "unit": unit.symbol if unit else "",
            "flags": flags,
            **packed.array(one.values),
        }


def is_long(data: Dataset | DataArray, dim: str) -> bool:
    """Return whether entries along a dimension are points of a curve, or too many to be numbers."""
    return dim in LONG or data.sizes[dim] > FEW


def curves(dataset: Dataset, grid: list[str]) -> tuple[list[dict[str, Any]], str]:
    """Return the charts of each cell's points and curves, and a note of what is thinned."""
    inner = {
        str(dim) for each in dataset.data_vars.values() if set(grid) <= set(each.dims) for dim in each.dims
    }
    long = sorted(inner - set(grid), key=lambda dim: (dim not in LONG, dim))
    dim = next((dim for dim in long if is_long(dataset, dim)), None)
    if dim is None:
        return [], ""
    pairs = [chosen(dataset, grid, dim, pair) for pair in pairs_of(dataset, dim)]
    count = sum(2 for _ in pairs) * int(np.prod([dataset.sizes[name] for name in grid]))
    size = dataset.sizes[dim]
    most = max(1, min(size, STORED // max(count, 1)))
    keep = (
        np.arange(size)[-most:] if dim == "point" else np.unique(np.linspace(0, size - 1, most).astype(int))
    )
    charts = [chart(*pair, dim, keep) for pair in pairs]
    return charts, thin.told(
        len(keep), size, f"{'section points' if dim == 'point' else 'samples'} of each cell"
    )


def pairs_of(dataset: Dataset, dim: str) -> list[tuple[str, str]]:
    """Return names of variables drawn over each other; an empty first one stands for the dimension."""
    names = [name for name in select.names(dataset, dim) if name not in ("mode", "window", "state_value")]
    states = select.labels(dataset, "state")
    planes = [pair for pair in (*PLACES, tuple(states[:2])) if len(pair) == 2 and set(pair) <= set(names)]
    force = next((name for name in (*FORCES, *states, *names) if name in names), None)
    along = [("", force)] if force and (dim == "time" or not planes) else []
    return along + planes[:1]


def chosen(dataset: Dataset, grid: list[str], dim: str, pair: tuple[str, str]) -> list[DataArray]:
    """Return both variables over the grid and one dimension, of the first link or joint."""
    where = [*grid, dim]
    numbers = DataArray(np.arange(dataset.sizes[dim]), dims=dim, name=dim)
    coordinate = dataset[dim] if dim in dataset.coords else numbers
    found = []
    for name in pair:
        array = select.variable(dataset, name, "variables", dim) if name else coordinate
        found.append(select.labelled_slice(array, dataset, where) if name else array)
    shape = found[1].transpose(*where)
    return [each.broadcast_like(shape).transpose(*where) for each in found]


def chart(x: DataArray, y: DataArray, dim: str, keep: np.ndarray) -> dict[str, Any]:
    """Return one chart of a cell: labels and values, the last dimension along the curve."""
    (xs, x_unit), (ys, y_unit) = artists.displayed(x), artists.displayed(y)
    labels = {"x_label": artists.axis_label(x, x_unit), "y_label": artists.axis_label(y, y_unit)}
    values = {"x": packed.array(xs[..., keep].astype(float)), "y": packed.array(ys[..., keep].astype(float))}
    return labels | values | {"joined": dim == "time"}
