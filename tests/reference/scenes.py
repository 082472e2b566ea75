"""The scenes whose end states are stored in truth.json."""

from __future__ import annotations

from dataclasses import dataclass

from .bodies import Parameters


@dataclass(frozen=True)
class Scene:
    """Parameters, clearance joints (name -> e, m) and length in nominal revolutions of one stored motion."""

    parameters: Parameters
    clearance: dict
    turns: float = 1.0


SMALL, LARGE = 2.9e-5, 2.9e-4


def scene(joints="B", i=3.0, e=SMALL, turns=1.0, **changes):
    """Scene with the same clearance e at every joint named by a letter of ``joints``."""
    return Scene(Parameters(i=i, e=e, **changes), dict.fromkeys(joints, e), turns)


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
