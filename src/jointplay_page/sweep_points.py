"""Cells of a sweep, for the one selected on a page: numbers, points or curves, command to run it again."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from xarray import DataArray, Dataset

from jointplay.display import codes
from jointplay.display.number_text import PLAIN, raised
from jointplay.figures.drawing import artists, cell_quantity, select, sweep_axes
from jointplay_page import packed, texts

KEY = re.compile(r"[\w.\[\]-]+")  # of a parameter: others cannot stand in a command
WORDS = {"period": {"0": "none found", "-1": "not known"}}  # of numbers that are none
FEW = 8  # entries along a dimension that are numbers of their own, not points of a curve
FIRST = ("cell_status", "trouble")  # must not be left out
LAST = ("n_", "wall_time", "end_state", "turn_period")  # beginnings of names of what matters least
POINTS = ("point", "turn")
LONG = (*POINTS, "time")
UNDRAWN = ("mode", "window", "state_value")
OWN = "cell_"  # before the name of a coordinate that differs from cell to cell
FORCES = ("normal_force", "reaction", "angular_acceleration", "state_value")
PLACES = (("journal_x", "journal_y"), ("eccentricity", "normal_velocity"))


def parameters(dataset: Dataset) -> list[str]:
    """Return the varied parameters of a sweep; none of another result."""
    if "cell_status" in dataset and dataset.attrs.get("kind") == "bifurcation":
        return sweep_axes.parameters(dataset, "bifurcation")
    return cell_quantity.varied(dataset)


def cells(dataset: Dataset, study: dict[str, Any], room: int) -> dict[str, Any] | None:
    """Return the data of a sweep's cells for a page, ready for `packed.text`; None where there is no sweep.

    Parameters
    ----------
    dataset : Dataset
        A result.
    study : dict
        The study that it answers, resolved; empty where it holds none.
    room : int
        Bytes that their numbers may take.
    """
    names = parameters(dataset)
    if not names:
        return None
    dims = [dim for dim in sweep_axes.SWEEPS if dim in dataset["cell_status"].dims]
    keys = list(product(*(map(str, dataset[dim].values) for dim in dims)))
    charts, thinned = curves(dataset, [*names, *dims], room // 8)
    room -= 4 * sum(map(values_of, charts))
    states = ends(dataset, [*names, *dims], room // 2)
    numbers, left = rows(dataset, [*names, *dims], room - (packed.size(states) if states else 0))
    return {
        "parameters": [axis(dataset, name, list(study.get("vary") or {})) for name in names],
        "ways": [" ".join(f"start {w}" if w.isdigit() else w for w in key) for key in keys],
        "rows": numbers,
        "charts": charts,
        "ends": states,
        "note": "; ".join(filter(None, (thinned, left))),
        "file": shlex.quote(texts.file_name({"study": study})),
    }


def ends(dataset: Dataset, grid: list[str], room: int) -> dict[str, Any] | None:
    """Return the state in which each cell's motion ended; None where there is none, or too little room."""
    array = dataset.get("end_state")
    if array is None or {*array.dims} != {*grid, "state"} or 8 * array.size > room:
        return None
    values = packed.array(array.transpose(*grid, "state").values, "<f8")
    return values | {"names": dataset["state"].values.tolist()}


def axis(dataset: Dataset, name: str, keys: list[str]) -> dict[str, Any]:
    """Return the values of a parameter, stored and as its axis shows them, and its key in a study."""
    values, unit = artists.displayed(dataset[name])
    key = next((key for key in keys if key.rpartition(".")[2] == name and KEY.fullmatch(key)), "")
    symbol = "" if unit.symbol == PLAIN["1"] else raised(unit.symbol)
    words = {"name": name, "title": select.title(dataset[name]), "unit": symbol, "key": key}
    stored, log = dataset[name].values.tolist(), sweep_axes.is_log(dataset[name].values)
    return words | {"values": values.tolist(), "stored": stored, "log": log}


def rows(dataset: Dataset, grid: list[str], room: int) -> tuple[list[dict[str, Any]], str]:
    """Return the numbers of each cell that there is room for, a row each, and a note on omitted ones."""
    known = [str(name) for name, each in dataset.data_vars.items() if set(grid) <= set(each.dims)]
    known.sort(key=lambda name: (name.startswith(LAST), name not in FIRST))
    every = [row for name in known for row in entries(dataset[name], grid)]
    sizes = np.cumsum([packed.size(row) for row in every])
    found = every[: int(np.searchsorted(sizes, room, side="right"))]
    left = [row["label"] for row in every[len(found) :]]
    return found, f"in the result only: {', '.join(left)}" if left else ""


def values_of(chart: dict[str, Any]) -> int:
    """Return the number of values of a chart."""
    return 2 * int(np.prod(chart["x"]["shape"]))


def entries(array: DataArray, grid: list[str]) -> Iterator[dict[str, Any]]:
    """Yield the rows of a variable: one for each of its few entries besides the grid."""
    own = [str(dim) for dim in array.dims if dim not in grid]
    if any(is_long(array, dim) for dim in own):
        return
    values, unit = (array.values, None) if array.dtype.kind not in "fiu" else artists.displayed(array)
    flat = array.copy(data=values).transpose(*grid, ...)
    for place in product(*(range(array.sizes[dim]) for dim in own)):
        one = flat.isel(dict(zip(own, place, strict=True)))
        which = [str(one[dim].values) for dim in own if dim in one.coords and array.sizes[dim] > 1]
        flags = {str(code): word.replace("_", " ") for code, word in codes.flags(array).items()}
        flags = flags or WORDS.get(str(array.name), {})
        label = ", ".join([select.title(array), *which])
        yield {
            "label": label,
            "unit": raised(unit.symbol) if unit else "",
            "flags": flags,
            **packed.array(one.values),
        }


def is_long(data: Dataset | DataArray, dim: str) -> bool:
    """Return whether entries along a dimension are points of a curve, or too many to be numbers."""
    return dim in LONG or data.sizes[dim] > FEW


def curves(dataset: Dataset, grid: list[str], stored: int) -> tuple[list[dict[str, Any]], str]:
    """Return the charts of each cell's points and curves, so many values, and a note on thinning."""
    over = [each for each in dataset.data_vars.values() if set(grid) <= set(each.dims)]
    inner = {str(dim) for each in over for dim in each.dims if is_long(each, str(dim))} - set(grid)
    if not inner:
        return [], ""
    dim = min(inner, key=lambda each: (each not in LONG, each))
    part = dataset[[each.name for each in over if dim in each.dims]]
    pairs = [[along(part, [*grid, dim], name) for name in pair] for pair in pairs_of(part, dim)]
    count = 2 * len(pairs) * int(np.prod([part.sizes[name] for name in grid]))
    size = part.sizes[dim]
    most = max(1, min(size, stored // max(count, 1)))
    last = dim in POINTS
    keep = np.arange(size)[-most:] if last else np.unique(np.linspace(0, size - 1, most).astype(int))
    charts = [chart(*pair, keep) | {"joined": not last} for pair in pairs]
    what = "section points" if last else "samples"
    left = f"{len(keep):,} of {size:,} {what} of each point of the sweep are drawn here"
    return charts, left if len(keep) < size else ""


def pairs_of(dataset: Dataset, dim: str) -> list[tuple[str, str]]:
    """Return names of variables drawn over each other; an empty first one stands for the dimension."""
    names = [name for name in select.names(dataset, dim) if name not in UNDRAWN]
    states = select.labels(dataset, "state")
    planes = [pair for pair in (*PLACES, tuple(states[:2])) if len(pair) == 2 and set(pair) <= set(names)]
    force = next((name for name in (*FORCES, *states, *names) if name in names), None)
    history = [("", force)] if force and dataset.sizes[dim] > 1 and (dim not in POINTS or not planes) else []
    return history + planes[:1]


def along(dataset: Dataset, where: list[str], name: str) -> DataArray:
    """Return a variable over the grid and one dimension more, of the first link, joint or other entry."""
    dim, own = where[-1], f"{OWN}{where[-1]}"
    if name:
        array = select.variable(dataset, name, "variables", dim)
    elif own in dataset.coords:  # of each cell another one
        array = dataset[own]
    else:
        array = dataset[dim] if dim in dataset.coords else DataArray(np.arange(dataset.sizes[dim]), dims=dim)
        array = array.rename(dim)
    for other in [other for other in array.dims if other not in where]:
        first, several = array.isel({other: 0}), array.sizes[other] > 1
        words = {"long_name": f"{select.title(array)}, {first[other].values}"} if several else {}
        array = first.assign_attrs(words)
    whole = {each: dataset.sizes[each] for each in where if each not in array.dims}
    return array.drop_vars(list(whole), errors="ignore").expand_dims(whole).transpose(*where)


def chart(x: DataArray, y: DataArray, keep: np.ndarray) -> dict[str, Any]:
    """Return one chart of a cell: labels and values, the last dimension along the curve."""
    (xs, x_unit), (ys, y_unit) = artists.displayed(x), artists.displayed(y)
    labels = {"x_label": artists.axis_label(x, x_unit), "y_label": artists.axis_label(y, y_unit)}
    values = {"x": packed.array(xs[..., keep].astype(float)), "y": packed.array(ys[..., keep].astype(float))}
    return labels | values
