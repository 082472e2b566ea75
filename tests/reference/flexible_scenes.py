"""The scenes of bending links whose motions are stored in flexible_truth.json."""

from __future__ import annotations

import numpy as np

from .beams import Beam
from .bodies import Parameters
from .flexible_twin import Scene

SMALL = 2.9e-5


def even(turns, count):
    """Evenly spaced turns, the last included."""
    return tuple(float(t) for t in np.linspace(0, turns, count + 1)[1:])


def scene(links="", joints="", turns=1.0, count=20, order="consistent", xi=0.01, elements=2, **changes):
    """Scene at i = 3 with bending ``links`` (words) and clearance `SMALL` at ``joints`` (letters)."""
    beams = dict.fromkeys(links.split(), Beam(elements=elements, xi=xi))
    parameters = Parameters(**{"i": 3.0, "e": SMALL} | changes)
    return Scene(parameters, dict.fromkeys(joints, SMALL), beams, order, even(turns, count))


def slowly(speed, **options):
    """Scene whose crank turns at a constant speed, rad/s."""
    p = Parameters()
    return scene(i=p.i * p.w0 / speed, drive="speed", **options)


SCENES = {
    "ideal_rigid": scene(),
    "ideal_rigid_constant_speed": scene(drive="speed"),
    "ideal_coupler": scene("coupler"),
    "ideal_coupler_undamped": scene("coupler", xi=0.0),
    "ideal_coupler_paper": scene("coupler", order="paper"),
    "ideal_coupler_three_elements": scene("coupler", elements=3, turns=0.25, count=10),
    "ideal_coupler_rocker_constant_speed": scene("coupler rocker", xi=0.02, drive="speed", turns=0.5),
    "ideal_all": scene("crank coupler rocker", turns=0.04, count=8),
    "ideal_coupler_slowly": slowly(2.0, links="coupler", xi=1.0, turns=0.25, count=10),
    "B_coupler": scene("coupler", "B", turns=0.3, count=6),
    "B_coupler_paper": scene("coupler", "B", turns=0.3, count=6, order="paper"),
    "B_coupler_sticking": scene("coupler", "B", turns=0.3, count=6, f=0.3),
    "B_coupler_without_tension": scene("coupler", "B", turns=0.3, count=6, tension=False),
    "B_coupler_rocker": scene("coupler rocker", "B", turns=0.3, count=6),
    "A_coupler": scene("coupler", "A", turns=0.3, count=6, f=0.1),
    "BC_coupler_rocker": scene("coupler rocker", "BC", turns=0.2, count=4, f=0.1),
    "conservative": scene("coupler", "B", turns=0.1, count=4, xi=0.0, drive="none", f=0.0, C_n=0.0),
}
