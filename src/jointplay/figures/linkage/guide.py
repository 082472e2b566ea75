"""A guide enlarged: its two faces and the slider's block between them, the gap in units of the clearance.

The block's half length is LONG; its height is cut short, so that across the guide only the gap is to scale. A
corner stands at +-(TALL + w), w its way towards its face over the clearance: faces are at w = 1. The guide's
line points to the right.
"""

from __future__ import annotations

import numpy as np

from jointplay.display.number_text import measure
from jointplay.figures.drawing import Axes, Line2D, artists, style
from jointplay.figures.linkage import symbols
from jointplay.solver.equations.structure import CORNERS
from jointplay.solver.mechanism.parts.joints import Joint

LONG, TALL, WALL = 2.6, 1.4, 0.75  # clearances: half of the block as it is drawn, thickness of a face
ACROSS, BESIDE = TALL + 1.0 + WALL + 0.05, 3.2  # half the height and width of the panel
PUSH = 0.75  # of the largest force, as an arrow
EDGE = (-BESIDE, 0.0)  # where what it enlarges is pointed at
OUTLINE = [0, 1, 3, 2]  # corners, in the order of `CORNERS`, around the block
SIDES = np.array(list(CORNERS.values()))  # of the corners: along and across
UNKNOWN = "unknown"
# mode: sign, filled, words
MARKS = {
    "free": ("o", False, "free"),
    "released": ("D", False, "released"),
    "contact": ("o", True, "contact"),
    "slip_positive": (">", True, "slips forward"),
    "slip_negative": ("<", True, "slips back"),
    "stick": ("s", True, "sticks"),
    "rest": ("s", True, "rests"),
    UNKNOWN: ("o", False, "corner (modes not recorded)"),
}


def frame(ax: Axes, joint: Joint) -> None:
    """Draw the faces, and the size of the clearance."""
    from matplotlib.patches import Rectangle

    look = {"facecolor": "white", "edgecolor": symbols.DARK, "linewidth": 0.0, "hatch": "/////", "zorder": 0}
    for low, face in ((TALL + 1.0, TALL + 1.0), (-TALL - 1.0 - WALL, -TALL - 1.0)):
        ax.add_patch(Rectangle((-BESIDE, low), 2 * BESIDE, WALL, **look))
        ax.plot([-BESIDE, BESIDE], [face, face], color=symbols.DARK, linewidth=0.9, linestyle="-", zorder=0.5)
    ax.set(xlim=(-BESIDE, BESIDE), ylim=(-ACROSS, ACROSS), aspect="equal")
    ax.set_axis_off()
    symbols.below(ax, scales(joint, 1.0, 1.0))


def still(ax: Axes) -> symbols.Artists:
    """Draw the block in the middle of its guide."""
    return block(ax, np.zeros(len(CORNERS)))


def places(shifts: np.ndarray) -> np.ndarray:
    """Corners on the panel, shape (4, 2), from progress towards their faces, in clearances, shape (4,)."""
    return SIDES * np.stack([np.full(shifts.shape, LONG), TALL + shifts], -1)


def block(ax: Axes, shifts: np.ndarray) -> symbols.Artists:
    """Draw the block with its height cut."""
    from matplotlib.patches import Polygon

    corners = places(shifts)
    box = {"facecolor": symbols.BODY, "edgecolor": symbols.DARK, "linewidth": 0.8, "zorder": 4}
    found = [ax.add_patch(Polygon(corners[OUTLINE], **box))]
    x = np.linspace(-LONG - 0.25, LONG + 0.25, 21)
    front, rear = (corners[[k, k + 2], 1].mean() for k in (0, 1))
    y = (front + rear) / 2 + (front - rear) / (2 * LONG) * x + 0.09 * (-1.0) ** np.arange(x.size)
    cut = np.concatenate([np.stack([x, y + 0.12], -1), np.stack([x, y - 0.12], -1)[::-1]])
    found.append(ax.add_patch(Polygon(cut, facecolor="white", edgecolor="none", zorder=4.1)))
    for edge in (0.12, -0.12):
        found += ax.plot(x, y + edge, color=symbols.DARK, linewidth=0.5, linestyle="-", zorder=4.2)
    return found


def enlargement(ax: Axes, joint: Joint) -> None:
    """Write the scales across and along the guide, as the panel is laid out."""
    across = symbols.paper_length(ax, [(0.0, -1.0), (0.0, 1.0)]) / 2 / joint.clearance
    along = symbols.paper_length(ax, [(-LONG, 0.0), (LONG, 0.0)]) / 2 / joint.half_length
    ax.texts[0].set_text(scales(joint, across, along))


def scales(joint: Joint, across: float, along: float) -> str:
    """The clearance, and the panel's enlargements of it and of the block's length."""
    words = f"gap {symbols.ratio(across)} : 1, length {symbols.ratio(along)} : 1"
    return f"$e$ = {measure(joint.clearance, 'm')} on either side\n{words}"


def moment(ax: Axes, loose, i: int, first: int) -> symbols.Artists:
    """Draw the block at a sample, its corners marked by their modes."""
    found = block(ax, loose.shifts[i])
    for (x, y), mode in zip(places(loose.shifts[i]), loose.modes[i], strict=True):
        found += ax.plot(x, y, **mark(mode))
    return found


def mark(mode: str) -> dict:
    """Style of a corner in a mode: dark and filled in contact, light and hollow in flight."""
    sign, filled, _ = MARKS[mode]
    edge = style.IN_CONTACT["color"] if filled else style.GREY if mode == UNKNOWN else style.AMBER
    look = {"markerfacecolor": edge if filled else "white", "markeredgecolor": edge, "linestyle": "none"}
    return look | {"marker": sign, "markersize": 5.0, "markeredgewidth": 0.9, "zorder": 9}


def legend(modes: set[str]) -> list[Line2D]:
    """Signs of the modes that occur, with their words."""
    return [artists.sample(**mark(mode), label=MARKS[mode][2]) for mode in MARKS if mode in modes]


def spots(loose, i: int) -> np.ndarray:
    """Places of contacts, shape (4, 2)."""
    return places(loose.shifts[i])
