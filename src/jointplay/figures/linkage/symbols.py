"""Signs of a kinematic sketch: supports, pins, sliders, springs, arrows; lengths are in mm on the paper.

Each sign is drawn in a frame of its own, fixed to a point of the axes: it keeps its size on the paper
whatever the scale of the mechanism is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jointplay.figures.drawing import Axes, Transform, style

DARK, BODY, BENT, LOOSE, ACTION = "#333333", "#d5dbe1", "#9fc5e8", style.BLUE, style.WARNING
HEAD = {"arrowstyle": "-|>", "mutation_scale": 7, "shrinkA": 0, "shrinkB": 0}
Artists = list


def at(ax: Axes, point: Sequence[float], angle: float = 0.0) -> Transform:
    """Return the frame, in mm, of a sign at a point of the axes, turned by an angle in rad."""
    from matplotlib.transforms import Affine2D, ScaledTranslation

    scale = Affine2D().rotate(angle).scale(style.MILLIMETRE) + ax.figure.dpi_scale_trans
    return scale + ScaledTranslation(*point, ax.transData)


def _line(ax: Axes, x, y, frame: Transform, **look) -> Artists:
    return ax.plot(x, y, transform=frame, **{"color": DARK, "linewidth": 0.8, "zorder": 3} | look)


def _area(ax: Axes, corners, frame: Transform, **look) -> Artists:
    from matplotlib.patches import Polygon

    whole = {"facecolor": BODY, "edgecolor": DARK, "linewidth": 0.8, "zorder": 4} | look
    return [ax.add_patch(Polygon(corners, transform=frame, **whole))]


def hatched(ax: Axes, frame: Transform, half: float, height: float) -> Artists:
    """Draw fixed ground: a line with strokes below it."""
    marks = np.arange(-half, half + 0.01, 1.1)
    x = np.stack([marks, marks - 0.8, np.full(marks.size, np.nan)], -1).ravel()
    y = np.stack([np.full(marks.size, height), np.full(marks.size, height - 1.0), marks * np.nan], -1).ravel()
    line = _line(ax, [-half, half], [height, height], frame)
    return line + _line(ax, x, y, frame, linewidth=0.5)


def support(ax: Axes, point) -> Artists:
    """Draw the pedestal of a pin on the ground."""
    frame = at(ax, point)
    sides = _area(ax, [(-1.7, -3.2), (0, 0), (1.7, -3.2)], frame, facecolor="white", zorder=2)
    return sides + hatched(ax, frame, 2.6, -3.2)


def pin(ax: Axes, point, loose: bool) -> Artists:
    """Draw a revolute joint: a ring; with clearance a wider one around a journal."""
    ring = {"marker": "o", "markersize": 6.4 if loose else 4.4, "markeredgewidth": 0.9, "zorder": 6}
    rings = ax.plot(*point, color=LOOSE if loose else DARK, markerfacecolor="white", linestyle="none", **ring)
    dot = {"marker": "o", "markersize": 3.2, "markeredgewidth": 0, "zorder": 7, "linestyle": "none"}
    return rings + (ax.plot(*point, color=LOOSE, **dot) if loose else [])


def guide(ax: Axes, ends: np.ndarray, angle: float, stroke: float) -> Artists:
    """Draw a slider's guide: a line below the block, with strokes so far apart where it is ground."""
    from matplotlib.transforms import ScaledTranslation

    down = np.array([np.sin(angle), -np.cos(angle)]) * (1.0 if np.cos(angle) > -1e-9 else -1.0)

    def below(distance: float) -> Transform:
        return ax.transData + ScaledTranslation(
            *(distance * style.MILLIMETRE * down), ax.figure.dpi_scale_trans
        )

    look = {"color": DARK, "zorder": 2.2}
    if not stroke:
        return ax.plot(*np.transpose(ends), linewidth=0.8, linestyle="-", **look)
    along = ends[1] - ends[0]
    share = np.arange(0.5 * stroke, np.hypot(*along), stroke) / np.hypot(*along)
    marks = ends[0] + share[:, None] * along
    sign = {
        "marker": (2, 2, np.rad2deg(np.arctan2(*down[::-1])) - 130),
        "markersize": 4.5,
        "linestyle": "none",
    }
    line = ax.plot(*np.transpose(ends), transform=below(1.6), linewidth=0.8, linestyle="-", **look)
    return line + ax.plot(*marks.T, transform=below(2.1), markeredgewidth=0.5, **sign, **look)


def slider(ax: Axes, point, angle: float) -> Artists:
    """Draw a block that slides along a line of this angle."""
    return _area(ax, [(-2.6, -1.5), (2.6, -1.5), (2.6, 1.5), (-2.6, 1.5)], at(ax, point, angle))


def bar(ax: Axes, ends, bent: bool) -> Artists:
    """Draw a link as a bar between two points; one that bends in another colour."""
    rounded, (x, y) = {"solid_capstyle": "round", "linestyle": "-"}, np.transpose(ends)
    edge = ax.plot(x, y, color=DARK, linewidth=5.2, zorder=3, **rounded)
    return edge + ax.plot(x, y, color=BENT if bent else BODY, linewidth=3.8, zorder=3.1, **rounded)


def weight(ax: Axes, point) -> Artists:
    """Draw a point mass."""
    return ax.plot(*point, "s", color=DARK, markersize=5.0, markeredgewidth=0, zorder=5)


def coil(ax: Axes, first, second) -> Artists:
    """Draw a spring between two points as a zigzag, straight at both ends."""
    first, second = np.asarray(first), np.asarray(second)
    share = np.concatenate([[0.0], np.linspace(0.125, 0.875, 11), [1.0]])
    side = np.concatenate([[0.0, 0.0], np.tile([1.0, -1.0], 5)[:9], [0.0, 0.0]])
    across = np.array([first[1] - second[1], second[0] - first[0]])
    places = first + share[:, None] * (second - first) + 0.06 * side[:, None] * across
    return ax.plot(*places.T, color=DARK, linewidth=0.8, linestyle="-", zorder=2.5)


def spiral(ax: Axes, point) -> Artists:
    """Draw a torsion spring."""
    turn = np.linspace(0.0, 5 * np.pi, 90)
    radius = 1.6 + 0.14 * turn
    return _line(ax, radius * np.cos(turn), radius * np.sin(turn), at(ax, point), zorder=2.6)


def pointer(ax: Axes, tail, tip, **look) -> Artists:
    """Draw an arrow from point to point."""
    from matplotlib.patches import FancyArrowPatch

    whole = {"color": ACTION, "linewidth": 1.1, "zorder": 8} | HEAD | look
    return [ax.add_patch(FancyArrowPatch(tail, tip, **whole))]


def arrow(ax: Axes, point, angle: float, length: float = 9.0) -> Artists:
    """Draw a straight arrow, `length` mm long, that ends at a point."""
    tail = (-length * np.cos(angle), -length * np.sin(angle))
    return pointer(ax, tail, (0, 0), transform=at(ax, point))


def turning(ax: Axes, point, positive: bool = True) -> Artists:
    """Draw an arrow around a point: a torque, or the drive of a link."""
    ends = np.deg2rad([20.0, 130.0] if positive else [130.0, 20.0])
    tail, tip = (tuple(4.6 * np.array([np.cos(e), np.sin(e)])) for e in ends)
    bend = f"arc3,rad={0.5 if positive else -0.5}"
    return pointer(ax, tail, tip, transform=at(ax, point), connectionstyle=bend)


def push(ax: Axes, start: np.ndarray, along: np.ndarray) -> Artists:
    """Draw a force on a bearing or a face, from where the contact is; both in units of the axes."""
    return pointer(ax, start, start + along, linewidth=1.2, clip_on=False)


def block(ax: Axes, corners: np.ndarray) -> Artists:
    """Draw a slider to scale."""
    return _area(ax, corners, ax.transData)


def face(ax: Axes, ends: np.ndarray, outward: np.ndarray, ground: bool) -> Artists:
    """Draw a face of a guide, hatched on its outer side, which a vector points to, where it is ground."""
    line = ax.plot(*np.transpose(ends), color=DARK, linewidth=0.8, linestyle="-", zorder=2.2)
    if not ground:
        return line
    strip = np.concatenate([ends, ends[::-1] + outward])
    look = {"facecolor": "white", "linewidth": 0.0, "hatch": "/////", "zorder": 1.2}
    return line + _area(ax, strip, ax.transData, **look)


def below(ax: Axes, text: str) -> None:
    """Write below a panel."""
    ax.annotate(text, (0.5, 0.0), (0, -2), "axes fraction", "offset points", ha="center", va="top")


def paper_length(ax: Axes, ends) -> float:
    """The distance of two points of the axes on the paper, m."""
    first, last = ax.transData.transform(ends)
    return float(np.hypot(*(last - first))) / ax.figure.dpi / style.MILLIMETRE * 1e-3


def ratio(times: float) -> str:
    """A scale in two digits."""
    return f"{float(f'{times:.1e}'):.7g}"


def word(ax: Axes, point, text: str, offset: tuple[float, float], **look) -> Artists:
    """Write a name next to a point, `offset` in mm."""
    whole = {"ha": "center", "va": "center", "fontsize": 8, "zorder": 9} | look
    return [ax.text(*offset, text, transform=at(ax, point), **whole)]
