"""Mechanism: the linkage as it starts, with names of its parts, and its joints with clearance enlarged."""

from __future__ import annotations

from textwrap import wrap
from typing import Any

from jointplay.display.errors import NOTHING, Problem
from jointplay.display.number_text import shown
from jointplay.figures.drawing import Axes, Figure, select, style
from jointplay.figures.drawing.style import owner
from jointplay.figures.linkage import enlarged
from jointplay.figures.linkage.sketch import Sketch, gravity
from jointplay.figures.registry import picture
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.start import Pose, start_pose

ROWS, MOST = 3, 6  # bearings below each other, and in all
SIZE, LINE, LETTER = 84.0, 4.0, 1.6  # mm: heights of a panel and of a line, width of a letter
LEADER = {"color": style.GREY, "linewidth": 0.5, "linestyle": (0, (1.5, 1.5)), "zorder": 1.5}


def fits(options: Any, _: Any):
    """Yield the problem of every study: a mechanism is no result."""
    expected = "a figure of a result; the mechanism is drawn by `jointplay figure STUDY.toml`"
    yield Problem("figure.kind", options.get("kind", NOTHING), expected)


@picture(least=100, fits=fits)
def mechanism(linkage: Mechanism, *, names: bool = True, crank_angle: float | None = None) -> Figure:
    """Draw a mechanism with its joints, drive, springs and loads; joints with clearance are enlarged.

    Journals are drawn in the middle of their bearings, sliders in the middle of their guides. A guide with
    clearance has its faces and the slider's block, to scale; enlarged, its line points to the right.

    Parameters
    ----------
    linkage : Mechanism
        What to draw.
    names : bool
        Whether to write the names of links, joints, springs and loads.
    crank_angle : float, optional
        Of the driven link, rad; by default as it starts.
    """
    from matplotlib.patches import ConnectionPatch

    if not isinstance(linkage, Mechanism):
        raise select.refuse("kind", "mechanism", "a figure of a result; of a mechanism: jp.figure(mechanism)")
    select.switch("names", names)
    if crank_angle is not None and not select.is_number(crank_angle):
        raise select.refuse("crank_angle", crank_angle, "an angle in rad")
    pose = start_pose(linkage, None if crank_angle is None else {"crank_angle": crank_angle})
    loose = linkage.clearance_joints[:MOST]
    rows, columns = max(min(len(loose), ROWS), 1), -(-len(loose) // ROWS)
    width = 112.0 + 34.0 * columns
    notes = [part for line in remarks(linkage) for part in wrap(line, int(width / LETTER))]
    figure = style.sheet(width, SIZE + LINE * len(notes))
    grid = figure.add_gridspec(rows, 1 + columns, width_ratios=[3.0] + [1.0] * columns)
    ax = figure.add_subplot(grid[:, 0])
    drawn = whole(ax, linkage, pose)
    panels = [figure.add_subplot(grid[n % ROWS, 1 + n // ROWS]) for n in range(len(loose))]
    for panel, joint in zip(panels, loose, strict=True):
        enlarged.frame(panel, joint)
        enlarged.of(joint).still(panel)
        ends = {"xyA": drawn.at(pose, joint.journal), "coordsA": ax.transData, "axesA": ax}
        ends |= {"xyB": enlarged.of(joint).EDGE, "coordsB": panel.transData, "axesB": panel}
        figure.add_artist(ConnectionPatch(**ends, **LEADER))
    if notes:
        figure.supxlabel("\n".join(notes), fontsize=8, ha="left", x=0.02)
    owner(figure).draw_without_rendering()  # what follows has to know the places of the panels
    for panel, joint in zip(panels, loose, strict=True):
        enlarged.of(joint).enlargement(panel, joint)
    if names:
        drawn.name(ax, pose)
    return figure


def whole(ax: Axes, linkage: Mechanism, pose: Pose) -> Sketch:
    """Draw the linkage with axes of length; return the sketch."""
    unit = shown(Sketch(linkage).corners([pose]), "m")
    drawn = Sketch(linkage, unit.factor)
    drawn.frame(ax, [pose])
    drawn.draw(ax, pose)
    gravity(ax, linkage, drawn.corners([pose]))
    ax.set(xlabel=f"$x$ ({unit.symbol})", ylabel=f"$y$ ({unit.symbol})")
    return drawn


def remarks(linkage: Mechanism) -> list[str]:
    """Return a line each on the drive and loads of the mechanism, and on joints that are not shown."""
    lines = [f"Drive: {linkage.drive.description}"] if linkage.drive else []
    lines += [f"{part.name}: {part.description}" for part in (*linkage.springs, *linkage.loads)]
    rest = len(linkage.clearance_joints) - MOST
    return lines + [f"{rest} more joints with clearance are not enlarged"] * (rest > 0)
