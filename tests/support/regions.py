"""Cells of a map between curves: to which region each belongs, and whether it has the region's label."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr
from scipy import ndimage

from jointplay.figures.drawing.artists import through

AWAY = 2  # cells from a curve
MARGIN = 40  # cells around the map, through which curves that leave it are followed


@dataclass(frozen=True)
class Regions:
    """Cells of a map that lie away from all curves.

    Parameters
    ----------
    number : ndarray of int
        Of the region of each cell; 0 near a curve.
    right : ndarray of bool
        Whether a cell is in a region and has the label that most of its cells have.
    labels : list of tuple
        Of the regions, in order: period, contacts a turn.
    """

    number: np.ndarray
    right: np.ndarray
    labels: list[tuple[int, float]]

    @property
    def share(self) -> float:
        """Share of the cells away from curves that have their region's label."""
        return float(self.right.sum() / (self.number > 0).sum())


def regions(curves: xr.Dataset, diagram: xr.Dataset) -> Regions:
    """Compare a map of periods and contacts with curves over the same two parameters."""
    names = curves.attrs["parameters"].split()
    cells = diagram.isel(direction=0).transpose(*names, ...)
    shape = tuple(diagram.sizes[name] for name in names)
    axes = [diagram[name].values for name in names]
    number, count = ndimage.label(~_near(curves, names, axes, shape))
    periods, contacts = (cells[name].values.reshape(*shape, -1)[..., 0] for name in ("period", "impacts"))
    right, labels = np.zeros(shape, dtype=bool), []
    for region in range(1, count + 1):
        own = number == region
        told = Counter(zip(periods[own].tolist(), contacts[own].round(6).tolist(), strict=True))
        labels.append(told.most_common(1)[0][0])
        right |= own & (periods == labels[-1][0]) & np.isclose(contacts, labels[-1][1])
    return Regions(number, right, labels)


def _near(curves: xr.Dataset, names: list[str], axes: list[np.ndarray], shape: tuple[int, int]) -> np.ndarray:
    """Whether cells lie within some cells of a curve, as it is drawn."""
    found = np.zeros(np.add(shape, 2 * MARGIN), dtype=bool)
    first, unit = (np.array([part(values) for values in axes]) for part in (np.min, np.ptp))
    unit = unit / (np.array(shape) - 1)
    for number, count in enumerate(curves["n_points"].values):
        places, slopes = (
            np.stack([curves[f"{name}{of}"].values[number, :count] for name in names], -1)
            for of in ("", "_tangent")
        )
        for one, other in pairwise(through((places - first) / unit, slopes / unit)):
            steps = np.linspace(one, other, 3 + int(4 * np.abs(other - one).max()))
            inside = np.all((steps > -MARGIN) & (steps < np.add(shape, MARGIN - 1)), axis=1)
            found[tuple(np.rint(steps[inside]).astype(int).T + MARGIN)] = True
    near = ndimage.binary_dilation(found, np.ones((2 * AWAY + 1, 2 * AWAY + 1)))
    return near[MARGIN:-MARGIN, MARGIN:-MARGIN]
