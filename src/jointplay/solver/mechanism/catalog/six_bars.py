"""Six-bars of Watt and Stephenson, to start from: a four-bar that drives a dyad."""

from __future__ import annotations

from typing import Any

from jointplay.solver.mechanism.catalog.preset_parts import (
    Density,
    Gravity,
    Length,
    Speed,
    bars,
    example,
    fixed,
    on,
)
from jointplay.solver.mechanism.parts.joints import Pin
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.signature import preset


@preset()
def watt(
    crank: Length = 0.04,
    coupler: Length = 0.12,
    rocker: Length = 0.1,
    arm: Length = 0.15,
    rod: Length = 0.18,
    output: Length = 0.12,
    ground: Length = 0.13,
    pivot: Length = 0.28,
    density: Density = 1.0,
    speed: Speed = 50.0,
    gravity: Gravity = 9.8,
    **changes: Any,
) -> Mechanism:
    """Give a Watt six-bar: the rocker of the four-bar O A B C, longer than C–B, drives another, C D E F.

    Links crank O–A, coupler A–B, rocker C–B–D, rod D–E, output F–E; O, C and F on the ground along +x.

    Parameters
    ----------
    crank, coupler, rocker, rod, output : float
        Distances O–A, A–B, C–B, D–E, F–E, m.
    arm : float
        Distance C–D on the rocker, m; at least C–B.
    ground, pivot : float
        Distances O–C and O–F, m.
    density : float
        Mass of a metre of the uniform links, kg/m.
    speed : float
        Constant speed of the crank, rad/s.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    lengths = {"crank": crank, "coupler": coupler, "rocker": arm, "rod": rod, "output": output}
    pins = _four_bar(crank, coupler, rocker, ground) | _dyad("rocker", arm, rod, output, pivot)
    guess = {"coupler": 0.95, "rocker": 1.8, "rod": -0.15, "output": 1.6}
    links = bars(lengths, density)
    return example("watt", links, pins, "", speed, gravity, guess).replace(**changes)


@preset()
def stephenson(
    crank: Length = 0.04,
    coupler: Length = 0.12,
    arm: Length = 0.17,
    rocker: Length = 0.1,
    rod: Length = 0.14,
    output: Length = 0.12,
    ground: Length = 0.13,
    pivot: Length = 0.2,
    density: Density = 1.0,
    speed: Speed = 50.0,
    gravity: Gravity = 9.8,
    **changes: Any,
) -> Mechanism:
    """Give a Stephenson six-bar: the coupler of the four-bar O A B C, longer than A–B, drives D–E and F–E.

    Links crank O–A, coupler A–B–D, rocker C–B, rod D–E, output F–E; O, C and F on the ground along +x.

    Parameters
    ----------
    crank, coupler, rocker, rod, output : float
        Distances O–A, A–B, C–B, D–E, F–E, m.
    arm : float
        Distance A–D on the coupler, m; at least A–B.
    ground, pivot : float
        Distances O–C and O–F, m.
    density : float
        Mass of a metre of the uniform links, kg/m.
    speed : float
        Constant speed of the crank, rad/s.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    lengths = {"crank": crank, "coupler": arm, "rocker": rocker, "rod": rod, "output": output}
    pins = _four_bar(crank, coupler, rocker, ground) | _dyad("coupler", arm, rod, output, pivot)
    guess = {"coupler": 0.9, "rocker": 1.9, "rod": -0.5, "output": 0.8}
    links = bars(lengths, density)
    return example("stephenson", links, pins, "", speed, gravity, guess).replace(**changes)


def _four_bar(crank: float, coupler: float, rocker: float, ground: float) -> dict[str, tuple[Pin, Pin]]:
    return {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", crank), on("coupler")),
        "B": (on("coupler", coupler), on("rocker", rocker)),
        "C": (on("rocker"), fixed(ground, 0.0)),
    }


def _dyad(link: str, at: float, rod: float, output: float, pivot: float) -> dict[str, tuple[Pin, Pin]]:
    return {
        "D": (on(link, at), on("rod")),
        "E": (on("rod", rod), on("output", output)),
        "F": (on("output"), fixed(pivot, 0.0)),
    }
