"""Overview of a response: force histories; orbit, portrait and section of each journal, on one sheet."""

from __future__ import annotations

from collections.abc import Sequence

from jointplay.display import codes
from jointplay.display.number_text import listed
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style, timebase
from jointplay.figures.motion.journal_orbit import ORBIT, orbit_panel
from jointplay.figures.motion.phase_portrait import counted, journal_points, portrait_panel
from jointplay.figures.motion.time_history import between, history_panel, legends
from jointplay.figures.registry import picture

MOST = 4  # joints on a sheet
FORCES, JOINT = 57.0, 66.0  # mm of height: the forces, the pictures of a joint


@picture(least=120, needs=("normal_force", *ORBIT, "eccentricity", "normal_velocity"), clearance=True)
def overview(dataset: Dataset, *, joint: str | None = None, turns: float | Sequence[float] = 3) -> Figure:
    """Draw the forces of the joints with clearance; of each its orbit, portrait, and section if one was kept.

    Parameters
    ----------
    dataset : Dataset
        A response of a mechanism with clearance.
    joint : str, optional
        One joint alone; by default the first four.
    turns : float or pair
        Window of the histories and paths: the last so many turns, or [first, last]. Sections are whole.
    """
    if not select.labels(dataset, "joint") or "time" not in dataset.dims:
        expected = "a response of a mechanism with clearance; else one of the other kinds"
        raise select.refuse("kind", "overview", expected)
    every = loose(dataset) if joint is None else [select.label(dataset, "joint", joint)]
    joints, more = every[:MOST], listed([*map(codes.contact, every[MOST:])], 1)
    part = timebase.last(timebase.window(dataset, turns))
    figure = style.sheet(180.0, FORCES + JOINT * len(joints))
    columns = 3 if "turn" in dataset.dims else 2
    grid = figure.add_gridspec(1 + len(joints), columns, height_ratios=(1.0, *[1.15] * len(joints)))
    axes = [figure.add_subplot(grid[0, :])]
    force(axes[0], dataset, part, joints)
    artists.heading(axes[0], more and f"without {more}", beside_top_axis=True)
    for row, name in enumerate(joints, start=1):
        axes += [figure.add_subplot(grid[row, column]) for column in range(columns)]
        pictures(axes[-columns:], dataset, part, name)
    artists.letter(axes)
    artists.shared_legend(figure, axes[-columns:][:2], 4)
    return artists.finish(figure, dataset)


def loose(dataset: Dataset) -> list[str]:
    """Return the joints with clearance."""
    names = select.labels(dataset, "joint")
    if "clearance" not in dataset:
        return names
    return [name for name in names if float(dataset["clearance"].sel(joint=name)) > 0] or names


def force(ax: Axes, dataset: Dataset, part: Dataset, joints: list[str]) -> None:
    """Draw the normal forces of the window."""
    bases = timebase.bases(dataset, part["time"].values, None)
    array = select.variable(part, "normal_force").sel(joint=joints)
    history_panel(ax, array, bases[0], len(joints) > 1, extremes=between(part, array))
    legends([ax])
    timebase.dress(ax, ax, bases)


def pictures(axes: list[Axes], dataset: Dataset, part: Dataset, joint: str) -> None:
    """Draw the motion of one joint: orbit, portrait, section."""
    orbit_panel(axes[0], part, joint)
    portrait_panel(axes[1], part, None, None, None, joint)
    axes[1].set_box_aspect(1)
    for ax in axes[1:]:
        ax.locator_params(nbins=4)  # narrow panels
    for ax in axes[2:]:
        journal_points(ax, dataset, joint, False, counted(dataset))
