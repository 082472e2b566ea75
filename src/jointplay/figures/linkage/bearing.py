"""A bearing enlarged: the clearance circle, where the journal's centre moves, in units of the clearance."""

from __future__ import annotations

import numpy as np

from jointplay.display.number_text import measure
from jointplay.figures.drawing import Axes, artists, style
from jointplay.figures.linkage import symbols
from jointplay.solver.mechanism.parts.joints import Joint

RIM, OUTER = 1.45, 1.5  # clearances: outer radius of the bearing, half the width of the panel
PUSH = 0.45  # of the largest force, as an arrow
EDGE = (-RIM, 0.0)  # where what it enlarges is pointed at


def frame(ax: Axes, joint: Joint) -> None:
    """Draw the bearing around the clearance circle, and the size of the clearance."""
    from matplotlib.patches import Circle, Wedge

    look = {"facecolor": "white", "edgecolor": symbols.DARK, "linewidth": 0.4, "hatch": "/////", "zorder": 0}
    ax.add_patch(Wedge((0, 0), RIM, 0, 360, width=RIM - 1.0, **look))
    ax.add_patch(Circle((0, 0), 1.0, facecolor=style.DISC, edgecolor=symbols.DARK, linewidth=0.9, zorder=0.5))
    ax.set(xlim=(-OUTER, OUTER), ylim=(-OUTER, OUTER), aspect="equal")
    ax.set_axis_off()
    symbols.below(ax, f"$e$ = {measure(joint.clearance, 'm')}")


def still(ax: Axes, x: float = 0.0, y: float = 0.0) -> symbols.Artists:
    """Mark the journal's centre."""
    return ax.plot(x, y, "o", color=symbols.LOOSE, markersize=4.5, markeredgewidth=0, zorder=6)


def enlargement(ax: Axes, joint: Joint) -> None:
    """Write the panel's enlargement of the clearance, as it is laid out."""
    times = symbols.paper_length(ax, [(-1.0, 0.0), (1.0, 0.0)]) / 2 / joint.clearance
    ax.texts[0].set_text(f"$e$ = {measure(joint.clearance, 'm')}, {symbols.ratio(times)} : 1")


def moment(ax: Axes, loose, i: int, first: int) -> symbols.Artists:
    """Draw the journal's centre at a sample and its path from another on."""
    x, y = loose.journal[first : i + 1, 0].T
    if loose.contact is None:
        return ax.plot(x, y, **artists.PLAIN_PATH, zorder=4) + still(ax, *loose.journal[i, 0])
    found, touching = [], loose.contact[first : i + 1, 0]
    for where, look in ((~touching, style.IN_FLIGHT), (touching, style.IN_CONTACT)):
        shown = where | artists.neighbours(where) if look is style.IN_FLIGHT else where
        found += ax.plot(x, np.where(shown, y, np.nan), **{**look, "label": "_"}, zorder=4)
    return found + still(ax, *loose.journal[i, 0])


def spots(loose, i: int) -> np.ndarray:
    """Places from which contacts push, shape (1, 2)."""
    return loose.journal[i]
