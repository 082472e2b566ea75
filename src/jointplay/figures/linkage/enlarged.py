"""A joint with clearance enlarged on a panel: `bearing` or `guide`."""

from __future__ import annotations

from types import ModuleType

from jointplay.figures.drawing import Axes, Figure
from jointplay.figures.linkage import bearing, guide
from jointplay.solver.mechanism.parts.joints import Joint


def of(joint: Joint) -> ModuleType:
    """Module that draws a joint enlarged."""
    return guide if joint.prismatic else bearing


def frame(ax: Axes, joint: Joint, **title) -> None:
    """Draw the fixed part of a joint, under the joint's name."""
    of(joint).frame(ax, joint)
    place = "on" if joint.prismatic else "in"
    ax.set_title(f"{joint.name}: {joint.journal.link} {place} {joint.bearing.link}", **title)


def legend(figure: Figure, modes: set[str]) -> None:
    """Add a legend for the marks of corners."""
    if modes:
        figure.legend(handles=guide.legend(modes), loc="outside lower center", ncols=7)
