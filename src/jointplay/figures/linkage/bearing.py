"""A bearing enlarged: the clearance circle, where the journal's centre moves, in units of the clearance."""

from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Wedge

from jointplay.display.units import measure
from jointplay.figures.drawing import style
from jointplay.figures.linkage import symbols

RIM, OUTER = 1.45, 1.5  # clearances: outer radius of the bearing, half the width of the panel


def frame(ax: Axes, clearance: float) -> None:
    """Draw the bearing around the clearance circle, and the size of the clearance."""
    look = {"facecolor": "white", "edgecolor": symbols.DARK, "linewidth": 0.4, "hatch": "/////", "zorder": 0}
    ax.add_patch(Wedge((0, 0), RIM, 0, 360, width=RIM - 1.0, **look))
    ax.add_patch(Circle((0, 0), 1.0, facecolor=style.DISC, edgecolor=symbols.DARK, linewidth=0.9, zorder=0.5))
    ax.set(xlim=(-OUTER, OUTER), ylim=(-OUTER, OUTER), aspect="equal")
    ax.set_axis_off()
    ax.text(0.0, -OUTER - 0.1, f"$e$ = {measure(clearance, 'm')}", ha="center", va="top")


def journal(ax: Axes, x: float = 0.0, y: float = 0.0) -> symbols.Artists:
    """Mark the journal's centre."""
    return ax.plot(x, y, "o", color=symbols.LOOSE, markersize=4.5, markeredgewidth=0, zorder=6)


def enlargement(ax: Axes, clearance: float) -> None:
    """Write how many times larger than in the machine the panel shows the clearance, as it is laid out."""
    (left, _), (right, _) = ax.transData.transform([(-1.0, 0.0), (1.0, 0.0)])
    paper = (right - left) / 2 / ax.figure.dpi / style.MILLIMETRE * 1e-3
    times = paper / clearance
    ax.texts[0].set_text(f"$e$ = {measure(clearance, 'm')}, {float(f'{times:.1e}'):.7g} : 1")


def push(ax: Axes, start, tip) -> symbols.Artists:
    """Draw the force of the journal on the bearing, from the journal's centre."""
    look = {"color": symbols.ACTION, "linewidth": 1.2, "zorder": 8, "clip_on": False}
    return [ax.add_patch(FancyArrowPatch(start, tip, **look, **symbols.HEAD))]
