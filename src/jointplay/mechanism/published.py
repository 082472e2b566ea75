"""Published mechanisms with all their parameters. What a publication leaves open is said with each."""

from __future__ import annotations

from typing import Any

from jointplay.mechanism.beam import Beam, Link
from jointplay.mechanism.drive import ConstantSpeed
from jointplay.mechanism.preset_parts import fixed, joined, on
from jointplay.mechanism.records import Mechanism
from jointplay.mechanism.signature import checked

_SLIDER = 0.02  # m: a size that nothing depends on


@checked()
def ivp_crank(**changes: Any) -> Mechanism:
    """Give the slider-crank with an elastic rod of the IVP test set (problem `crank`; Simeon 1996, 1998).

    The crank turns at 150 rad/s without gravity; the rod bends in two sine modes and stretches in two
    quadratic shapes, and the slider sits on its end node. No damping. The published axial mass matrix is
    15 times ∫ρA ψ_a ψ_b, and there π is 3.1415927: both are a matter of the study of kind ``benchmark``, not
    of this mechanism. Left open, and without effect: the slider's size and inertia, the crank's inertia
    at its constant speed. Contact data for clearance at its joints are those of `slider_crank`.

    Parameters
    ----------
    **changes
        As in `Mechanism.replace`.

    Returns
    -------
    Mechanism
    """
    steel = {"modulus": 2e11, "density": 7870.0, "section": "square", "area": 6.4e-5}
    beam = Beam(shapes="sine", modes=2, axial=True, **steel)
    links = (
        Link(name="crank", length=0.15, mass=0.36, inertia=0.002727),
        Link(name="rod", length=0.3, mass=0.151104, inertia=0.0045339259, elastic=True, beam=beam),
        Link(name="slider", length=_SLIDER, mass=0.075552, centre=0.0, inertia=0.075552 * _SLIDER**2 / 12),
    )
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", 0.15), on("rod")),
        "B": (on("rod", 0.3), on("slider")),
        "G": (on("slider"), fixed(0.0, 0.0)),
    }
    joints = joined(pins, "G", radius=0.01, stiffness=1e7, damping=200.0, friction=0.05)
    return Mechanism(
        name="ivp_crank",
        links=links,
        joints=joints,
        drive=ConstantSpeed(link="crank", speed=150.0),
        gravity=0.0,
        guess={"crank": 0.0, "rod": 0.0},
    ).replace(**changes)
