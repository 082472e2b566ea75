"""The scenes whose motions are stored in truth.json and, of links that bend, in flexible_truth.json."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .four_bar import Beam, FourBar, Parameters


@dataclass(frozen=True)
class Scene:
    """A motion: parameters, clearance (joint -> e, m), beams (link -> Beam) and nominal turns to keep."""

    parameters: Parameters
    clearance: dict
    turns: tuple = (1.0,)
    beams: dict = field(default_factory=dict)
    order: str = "consistent"

    @cached_property
    def system(self):
        """The bodies."""
        p, beams = self.parameters, self.beams
        return FourBar(p, self.clearance, {k: beams[k].row(*p.links[k][:2], self.order) for k in beams})

    @property
    def times(self):
        """Times to keep, s."""
        return [turn * 2 * math.pi / self.parameters.w0 for turn in self.turns]


SMALL, LARGE = 2.9e-5, 2.9e-4


def scene(joints="B", i=3.0, e=SMALL, turns=1.0, **changes):
    """Scene with the same clearance e at every joint named by a letter of ``joints``."""
    return Scene(Parameters(i=i, e=e, **changes), dict.fromkeys(joints, e), (turns,))


def conservative(joints, e=SMALL, **changes):
    """No motor, friction or damping: the crank starts at a/b and is left alone.

    Undamped rattling is chaotic: a start moved by 1e-16 moves the state by up to 1e-4 within one turn, so
    states are stored after a tenth of one, where doubles still agree to 1e-11.
    """
    return scene(joints, e=e, turns=0.1, drive="none", f=0.0, C_n=0.0, **changes)


SCENES = {
    "A": scene(i=15.0),
    "B": scene(),
    "C": scene(e=LARGE),
    "B_sticking": scene(f=0.3),
    "B_without_tension": scene(tension=False),
    "B_viscous": scene(C_t=3.0),
    "C_constant_speed": scene(e=LARGE, drive="speed"),
    "C_without_tension": scene(e=LARGE, tension=False),
    "C_sticking": scene(e=LARGE, f=0.3),
    "conservative_at_A": conservative("A"),
    "conservative_at_B": conservative("B"),
    "conservative_at_C": conservative("C"),
    "conservative_at_BC": conservative("BC"),
    "damped_at_A": scene("A"),
    "damped_at_C": scene("C"),
    "damped_at_O": scene("O"),
    "damped_at_BC": scene("BC"),
    "damped_at_BC_sticking": scene("BC", f=0.3),
    "damped_at_BC_constant_speed": scene("BC", drive="speed"),
    "damped_at_OABC": scene("OABC"),
}


def bent(links="", joints="", turns=1.0, count=20, order="consistent", xi=0.01, elements=2, **changes):
    """Scene with bending ``links`` (words) at so many evenly spaced times, the last included."""
    beams = dict.fromkeys(links.split(), Beam(elements=elements, xi=xi))
    kept = tuple(float(t) for t in np.linspace(0, turns, count + 1)[1:])
    parameters = Parameters(**{"i": 3.0, "e": SMALL} | changes)
    return Scene(parameters, dict.fromkeys(joints, SMALL), kept, beams, order)


def slowly(speed, **options):
    """Scene whose crank turns at a constant speed, rad/s."""
    p = Parameters()
    return bent(i=p.i * p.w0 / speed, drive="speed", **options)


BENT = {
    "ideal_rigid": bent(),
    "ideal_rigid_constant_speed": bent(drive="speed"),
    "ideal_coupler": bent("coupler"),
    "ideal_coupler_undamped": bent("coupler", xi=0.0),
    "ideal_coupler_paper": bent("coupler", order="paper"),
    "ideal_coupler_three_elements": bent("coupler", elements=3, turns=0.25, count=10),
    "ideal_coupler_rocker_constant_speed": bent("coupler rocker", xi=0.02, drive="speed", turns=0.5),
    "ideal_all": bent("crank coupler rocker", turns=0.04, count=8),
    "ideal_coupler_slowly": slowly(2.0, links="coupler", xi=1.0, turns=0.25, count=10),
    "B_coupler": bent("coupler", "B", turns=0.3, count=6),
    "B_coupler_paper": bent("coupler", "B", turns=0.3, count=6, order="paper"),
    "B_coupler_sticking": bent("coupler", "B", turns=0.3, count=6, f=0.3),
    "B_coupler_without_tension": bent("coupler", "B", turns=0.3, count=6, tension=False),
    "B_coupler_rocker": bent("coupler rocker", "B", turns=0.3, count=6),
    "A_coupler": bent("coupler", "A", turns=0.3, count=6, f=0.1),
    "BC_coupler_rocker": bent("coupler rocker", "BC", turns=0.2, count=4, f=0.1),
    "conservative": bent("coupler", "B", turns=0.1, count=4, xi=0.0, drive="none", f=0.0, C_n=0.0),
}
