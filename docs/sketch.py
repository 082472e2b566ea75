"""The labelled sketch of a four-bar with clearance at B, from the paper's own mechanism: images/four_bar.png.

python docs/sketch.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle

import jointplay as jp
from jointplay.solver.mechanism.loops.ideal import ideal_state

IMAGE = Path(__file__).with_name("images") / "four_bar.png"
MECHANISM = jp.catalog.chunmei2002()
CRANK_ANGLE = 1.0
LINK, GROUND, NOTE = "#00344f", "0.45", "#a04000"


def along(start: np.ndarray, angle: float, distance: float) -> np.ndarray:
    """The point at a distance from a start, in the direction of an angle."""
    return start + distance * np.array([np.cos(angle), np.sin(angle)])


def places() -> tuple[dict[str, np.ndarray], dict[str, float]]:
    """Where the joints are, m, and the angles of the links, rad."""
    angles, *_ = ideal_state(MECHANISM, CRANK_ANGLE)
    found = {name: np.array(MECHANISM.joint(name).bearing.point) for name in "OC"}
    found["A"] = along(found["O"], angles["crank"], MECHANISM.link("crank").length)
    found["B"] = along(found["C"], angles["rocker"], MECHANISM.link("rocker").length)
    return found, angles


def linkage(ax: Axes) -> None:
    """Draw links with their names, origins and positive angles."""
    at, angles = places()
    for link, (one, two), side in (
        ("crank", "OA", (-0.026, 0.006)),
        ("coupler", "AB", (-0.035, 0.008)),
        ("rocker", "CB", (0.007, 0.002)),
    ):
        ends = np.array([at[one], at[two]])
        ax.plot(*ends.T, color=LINK, linewidth=3, solid_capstyle="round")
        ax.text(*(ends.mean(0) + side), link, color=LINK)
        ax.plot([at[one][0], at[one][0] + 0.03], [at[one][1]] * 2, color=GROUND, linewidth=0.6)
        ax.add_patch(Arc(at[one], 0.036, 0.036, theta2=np.degrees(angles[link]) % 360, color=NOTE))
        ax.annotate(
            rf"$\theta_{{\mathrm{{{link}}}}}$",
            along(at[one], (angles[link] % (2 * np.pi)) / 2, 0.021),
            color=NOTE,
            fontsize=8,
        )
    ax.plot([at["O"][0], at["C"][0]], [0, 0], color=GROUND, linewidth=0.6, linestyle="--")
    for name, place in at.items():
        ax.plot(*place, "o", color="white", markeredgecolor=LINK, markersize=8)
        ax.annotate(
            name, place, (8, -12) if name in "OC" else (-12, 8), textcoords="offset points", weight="bold"
        )
    for name in "OC":
        ax.plot(*(at[name] - (0, 0.007)), marker="^", color=GROUND, markersize=9)
    ax.annotate("gravity", (0.1, 0.01), (0.1, 0.038), arrowprops={"arrowstyle": "->"}, ha="center")
    ax.set_aspect("equal")
    ax.set_axis_off()


def bearing(ax: Axes) -> None:
    """Draw the joint with clearance, greatly enlarged."""
    r, e, R, angle = 1.0, 0.45, 1.0, -0.7
    journal = along(np.zeros(2), angle, e)
    ax.add_patch(Circle((0, 0), R + e, fill=False, color=LINK, linewidth=2))
    ax.add_patch(Circle(journal, R, color="0.85", ec=LINK))
    ax.add_patch(Circle((0, 0), e, fill=False, color=NOTE, linestyle="--"))
    ax.annotate("", journal, (0, 0), arrowprops={"arrowstyle": "->", "color": NOTE})
    ax.text(*(journal / 2 + (0.0, 0.12)), r"$\mathbf{r}$", color=NOTE)
    ax.annotate(
        "",
        along(np.zeros(2), angle, R + e),
        along(np.zeros(2), angle, R + e + 0.7),
        arrowprops={"arrowstyle": "<-", "color": NOTE},
    )
    ax.text(*along(np.zeros(2), angle, R + e + 0.78), r"$F_n$", color=NOTE, ha="left", va="top")
    ax.text(-1.15, -1.55, "bearing\n(rocker)", ha="right", color=LINK)
    ax.text(journal[0], journal[1] - 0.72 * r, "journal\n(coupler)", ha="center", color=LINK, fontsize=8)
    pointer = {"arrowstyle": "-", "color": NOTE, "linewidth": 0.6}
    ax.annotate(
        "clearance circle,\nradius $e$",
        (0.25, 0.38),
        (1.25, 1.3),
        color=NOTE,
        fontsize=8,
        arrowprops=pointer,
    )
    ax.set(xlim=(-2.6, 2.8), ylim=(-2.2, 1.8), aspect="equal")
    ax.set_title("Joint B, enlarged: in contact", fontsize=9)
    ax.set_axis_off()


def main() -> None:
    """Write the picture."""
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    linkage(left)
    bearing(right)
    figure.savefig(IMAGE, dpi=150)


if __name__ == "__main__":
    main()
