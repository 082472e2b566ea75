"""Contact angle: the direction of the journal over time, on three branches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.display import codes
from jointplay.figures.drawing import Axes, Dataset, Figure, artists, select, style, timebase
from jointplay.figures.registry import picture

PANEL, GAP, MARGINS = 28.0, 7.0, 23.0  # mm of height
FLIGHT = 2.0  # pt: flights are a short part of a turn
ROWS = {"wrapped": 360.0, "unwrapped": None, "arctan $(r_y/r_x)$": 180.0}  # ranges, deg, if any


@picture(least=120, needs=("contact_angle",), clearance=True)
def contact_angle(
    dataset: Dataset,
    *,
    joint: str | None = None,
    turns: float | Sequence[float] | None = None,
    time: Sequence[float] | None = None,
    axis: str | Sequence[str] | None = None,
    column: str = "double",
) -> Figure:
    """Draw the direction of a journal wrapped, unwrapped, and on the arctangent's principal branch.

    On the principal branch, opposite directions are one: its jumps are none of the motion's, and are not
    drawn. Of a run recorded in windows, each has a column and is unwrapped from its own start.

    Parameters
    ----------
    dataset : Dataset
        A response with `contact_angle`; with `mode`, contact is told from free flight.
    joint : str, optional
        The joint; by default the first with clearance.
    turns, time, axis, column
        As in `time_history`.
    """
    width = style.COLUMNS[select.choice("column", column, style.COLUMNS)]
    joint = select.label(dataset, "joint", joint)
    panes = timebase.panes(timebase.window(dataset, turns, time))
    figure = style.sheet(width, len(ROWS) * (PANEL + GAP) + MARGINS)
    axes = figure.subplots(len(ROWS), len(panes), sharex="col", squeeze=False)
    timebase.apart(figure, panes)
    for column_axes, pane in zip(axes.T, panes, strict=True):
        bases = pane.bases(dataset, axis)
        angle_column(column_axes, pane.samples, joint, bases[0])
        timebase.dress(column_axes[-1], column_axes[0], bases, "right" if pane.title else "center")
    for row in axes:
        timebase.level(row)
        timebase.name_once(row)
    timebase.head(axes, panes, two_axes=len(bases) > 1)
    artists.shared_legend(figure, axes[0], 2)
    return artists.finish(figure, dataset)


def angle_column(axes: np.ndarray, part: Dataset, joint: str, base: timebase.Base) -> None:
    """Draw one stretch of time, a panel a row."""
    array = select.curve(part, "contact_angle", "kind", joint=joint)
    x, degrees = base.forward(array["time"].values), artists.displayed(array)[0]
    contact = select.in_contact(part, joint)
    which = f" at {codes.contact(joint)}" if part.sizes["joint"] > 1 else ""
    for ax, (words, span) in zip(axes, ROWS.items(), strict=True):
        branch = timebase.within(degrees, span) if span else timebase.unwrapped(degrees)
        angle_panel(ax, x, branch, contact, span)
        ax.set_ylabel(f"Contact angle{which},\n{words} (deg)")
        artists.in_degrees(ax.yaxis)
        if x.size > 1:
            ax.set_xlim(timebase.limits(base, x))


def angle_panel(ax: Axes, x: np.ndarray, degrees: np.ndarray, contact, span: float | None) -> None:
    """Draw an angle that is confined to a range of `span` deg, if to any."""
    if span is not None:
        masks = [] if contact is None else [contact]
        x, degrees, *masks = timebase.broken(degrees, span, x, degrees, *masks)
        contact = masks[0] if masks else None
        ax.set_ylim(-0.53 * span, 0.53 * span)
    artists.path(ax, x, degrees, contact, flight=FLIGHT)
