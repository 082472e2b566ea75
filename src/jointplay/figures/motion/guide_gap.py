"""The gap of a guide with clearance: a slider's corner on its way to its face, over the slide.

Across the guide the way is in units of the clearance. The face is at 1; at -1 is the corner of a slider that
lies along the other face.
"""

import numpy as np
from matplotlib.axes import Axes
from xarray import DataArray, Dataset

from jointplay.equations.structure import CORNERS
from jointplay.figures.drawing import artists, style

NAMES = tuple(f"_{corner}" for corner in CORNERS)


def is_corner(joint: str) -> bool:
    """Return whether a contact is a corner of a slider."""
    return joint.endswith(NAMES)


def along(dataset: Dataset, joint: str, dim: str) -> DataArray:
    """Return how far along its guide the slider is; the time, or the crossing, where that is not recorded."""
    if "slide_position" in dataset and dim in dataset["slide_position"].dims:
        return dataset["slide_position"].sel(joint=joint)
    return dataset["time"] if dim == "time" else DataArray(np.arange(dataset.sizes[dim]), name=dim, dims=dim)


def gap_frame(ax: Axes, joint: str, x: DataArray, reach: float) -> None:
    """Draw the two faces around the farthest point, at `reach`, and name the axes."""
    half = 1.08 * max(1.0, reach)
    wall = {"facecolor": "white", "edgecolor": style.GREY, "linewidth": 0.0, "hatch": "/////", "zorder": 0}
    ax.axhspan(-1.0, 1.0, facecolor=style.DISC, linewidth=0.0, zorder=0, label="gap of the guide")
    ax.axhspan(1.0, 2 * half, **wall)
    for face in (1.0, -1.0):
        ax.axhline(face, color=style.GREY, linewidth=0.6, linestyle="-", zorder=0.5)
    unit = artists.displayed(x)[1]
    ax.set(ylim=(-half, half), box_aspect=1)
    ax.set_xlabel(artists.axis_label(x, unit))
    ax.set_ylabel(f"Way of corner {joint}\nto its face, over $e$ (\N{EN DASH})")
