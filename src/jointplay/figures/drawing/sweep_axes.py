"""Elements of figures of sweeps: varied parameters, directions and starts, parameter axes, colour maps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from jointplay.display.errors import Problem, unknown
from jointplay.display.number_text import Shown
from jointplay.figures.drawing import Axes, DataArray, Dataset, artists, select, style

SWEEPS = ("direction", "start")  # dimensions of a grid that are no parameters
ORDER = ("down", "reset", "up")  # drawn one over the other
LOOKS = {
    "up": {"color": style.BLUE, "label": "upward"},
    "down": {"color": style.AMBER, "label": "downward"},
    "reset": {"color": style.BLACK, "label": "each from the start"},
}
SHORT = 20  # times the low end, below which an axis has more numbers
STARTS = (style.BLACK, style.AMBER, style.BLUE, style.GREY)


def parameters(dataset: Dataset, kind: str) -> list[str]:
    """Return the varied parameters of a sweep; a dataset that is none is an error."""
    if dataset.attrs.get("kind") != "bifurcation" or "cell_status" not in dataset:
        raise select.refuse("kind", kind, "a result of a study of kind bifurcation")
    return varied(dataset)


def varied(dataset: Dataset) -> list[str]:
    """Return the parameters that vary in a dataset of cells; none in another."""
    dims = dataset["cell_status"].dims if "cell_status" in dataset else ()
    return [str(dim) for dim in dims if dim not in SWEEPS]


def one_parameter(dataset: Dataset, at: float | None) -> tuple[Dataset, str]:
    """Return the sweep along its last parameter, at the value of the other nearest to `at`, and its name."""
    *others, name = parameters(dataset, "bifurcation")
    if at is not None and not (others and select.is_number(at)):
        expected = f"a value of {others[0]}" if others else "nothing: there is one parameter only"
        raise select.refuse("at", at, expected)
    for other in others:
        values = dataset[other].values
        dataset = dataset.isel({other: 0 if at is None else int(np.abs(values - at).argmin())})
    return dataset, name


def chosen(dataset: Dataset, direction: str | None, start: int | None) -> Dataset:
    """Return the sweep with the given direction and start alone; None: all of them."""
    if direction is not None:
        select.choice("direction", direction, select.labels(dataset, "direction"))
        dataset = dataset.sel(direction=[direction])
    if start is not None:
        count = dataset.sizes.get("start", 1)
        if not isinstance(start, int) or isinstance(start, bool) or not 0 <= start < count:
            raise select.refuse("start", start, f"the number of a start, 0 to {count - 1}")
        dataset = dataset.isel(start=[start]) if "start" in dataset.dims else dataset
    return dataset


def motions(dataset: Dataset) -> list[tuple[Dataset, dict]]:
    """Return each direction and start of a sweep with its line style, in the order of drawing."""
    directions, found = select.labels(dataset, "direction"), []
    starts = dataset.sizes.get("start", 1)
    several = len(directions) * starts > 1
    for direction in sorted(directions, key=ORDER.index):
        for s in reversed(range(starts)):
            one = dataset.sel(direction=direction)
            one = one.isel(start=s) if "start" in one.dims else one
            look = dict(LOOKS[direction]) if len(directions) > 1 else {"color": style.BLACK, "label": ""}
            if len(directions) == 1 and starts > 1:
                number = int(dataset["start"].values[s])
                look = {"color": STARTS[number % len(STARTS)], "label": f"start {number}"}
            look["size"] = 1.6 if several and not found else 1.0  # seen around those drawn over it
            found.append((one, look | ({"label": "_"} if len(directions) > 1 and s else {})))
    return found


def fits(options: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[Problem]:
    """Yield the problems of a figure's direction and quantity, by the study's own."""
    for key, known in (("direction", settings["direction"]), ("quantity", settings["recorded"])):
        if key in options and known and options[key] not in known:
            yield unknown(f"figure.{key}", options[key], options[key], known, key)


def is_log(values: np.ndarray) -> bool:
    """Return whether values are spaced evenly in their logarithms and not in themselves."""
    if values.size < 3 or values[0] <= 0:
        return False
    ratios, steps = np.diff(np.log(values)), np.diff(values)
    return bool(np.allclose(ratios, ratios[0], rtol=1e-3) and not np.allclose(steps, steps[0], rtol=1e-2))


def parameter_axis(ax: Axes, axis: DataArray, which: str = "x") -> Shown:
    """Set scale, limits, numbers and label of an axis for a parameter; return its unit."""
    values, unit = artists.displayed(axis)
    log = is_log(values)
    ax.set(**{f"{which}label": artists.axis_label(axis, unit)})
    if log:
        logarithmic(ax, values[0], values[-1], which)
    if values.size > 1:
        borders, step = values[[0, -1]], np.array([-0.01, 0.01])
        away = (values[-1] / values[0]) ** step if log else step * np.ptp(values)
        ax.set(**{f"{which}lim": borders * away if log else borders + away})
    return unit


def logarithmic(ax: Axes, low: float, high: float, which: str = "x") -> None:
    """Give an axis a scale of logarithms; where it is short, with numbers at 1, 2 and 5, or at more."""
    from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter

    ax.set(**{f"{which}scale": "log"})
    if high < 1e3 * low:
        numbers = getattr(ax, f"{which}axis")
        more = (1.5, 3.0, 7.0) if high < SHORT * low else ()
        numbers.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0, *more)))
        numbers.set_major_formatter(StrMethodFormatter("{x:g}"))
        numbers.set_minor_locator(NullLocator())


def edges(values: np.ndarray) -> np.ndarray:
    """Return the borders of cells around values: midway, in logarithms where these are evenly spaced."""
    if values.size == 1:
        return values[0] + np.array([-0.5, 0.5]) * (abs(values[0]) or 1.0)
    place = np.log(values) if is_log(values) else values
    inner = (place[1:] + place[:-1]) / 2
    found = np.concatenate([[2 * place[0] - inner[0]], inner, [2 * place[-1] - inner[-1]]])
    return np.exp(found) if is_log(values) else found


def colour_map(ax: Axes, dataset: Dataset, names: Sequence[str], values: np.ndarray, look: dict[str, Any]):
    """Draw values over two parameters as colours, the last along x; return mesh and cell centres."""
    units = [parameter_axis(ax, dataset[name], which) for name, which in zip(names, "yx", strict=True)]
    middles = [dataset[name].values * unit.factor for name, unit in zip(names, units, strict=True)]
    y, x = map(edges, middles)
    mesh = ax.pcolormesh(x, y, np.ma.masked_invalid(values), rasterized=True, **look)
    ax.set(xlim=x[[0, -1]], ylim=y[[0, -1]])
    return mesh, middles


def exponents(dataset: Dataset) -> tuple[DataArray, DataArray] | None:
    """Return exponents per turn and their errors over ``number``: the section map's, else the flow's."""
    for word, dim in (("section", "multiplier"), ("lyapunov", "exponent")):
        names = [f"{word}_{each}_per_turn" for each in ("exponent", "standard_error")]
        if names[0] in dataset:
            means, errors = (dataset[name].rename({dim: "number"}) for name in names)
            return means, errors
    return None
