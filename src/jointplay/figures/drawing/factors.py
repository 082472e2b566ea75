"""Powers of ten of an axis stand in its label, beside the unit, and never over a title or a tick."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from jointplay.display.number_text import RAISED
from jointplay.display.units import PLAIN

if TYPE_CHECKING:
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure, FigureBase

POWER = re.compile(r"^1e([−\d]+)$")  # as matplotlib writes it
UNIT = re.compile(r"\(([^()]*)\)$")  # that a label ends with


def settle(figure: FigureBase) -> None:
    """Lay a figure out, with the powers of ten that matplotlib writes beside axes in the axes' labels.

    Panels that share an axis share its power; each that has a label gets it.
    """
    _lay_out(figure.get_figure(root=True))  # powers are chosen as ticks are made
    moved = False
    axes = [ax for each in figure.axes for ax in (each, *each.child_axes)]
    for axis in (axis for ax in axes for axis in (ax.xaxis, ax.yaxis)):
        if power := POWER.search(axis.get_offset_text().get_text()):
            digits = power[1].replace("\N{MINUS SIGN}", "-")
            move(axis, f"10{digits.translate(RAISED)}")
            moved = True
    if moved:  # labels take room
        _lay_out(figure.get_figure(root=True))


def _lay_out(figure: Figure) -> None:
    """Lay a figure out, without drawing it where its engine can."""
    engine = figure.get_layout_engine()
    if engine is None:
        figure.draw_without_rendering()
    else:
        engine.execute(figure)


def unit(label: str) -> str:
    """Return the unit that a label ends with; empty where there is none."""
    found = UNIT.search(label.replace("\n", " "))
    return found[1] if found else ""


def move(axis: Axis, factor: str) -> None:
    """Write a factor before the unit of an axis' label, and not at the end of the axis."""
    label = axis.get_label()
    text = label.get_text()
    if unit := UNIT.search(text):
        words = factor if unit[1] in PLAIN.values() else f"{factor} {unit[1]}"
        label.set_text(f"{text[: unit.start()]}({words})")
    elif text:
        label.set_text(f"{text} ({factor})")
    axis.get_offset_text().set_visible(False)
