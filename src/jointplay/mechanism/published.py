"""Published mechanisms with all their parameters. What a publication leaves open is said with each."""

from __future__ import annotations

from typing import Any

from jointplay.mechanism.beam import Beam, Link
from jointplay.mechanism.drive import ConstantSpeed
from jointplay.mechanism.preset_parts import Play, fixed, joined, on
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


@checked()
def siconos_four_bar(clearance: Play = {"A": 5e-3, "B": 5e-3, "C": 5e-3}, **changes: Any) -> Mechanism:  # noqa: B006
    """Give the four-bar with three clearances of the Siconos examples (``FourBarClearance``).

    Links of 1, 4 and 2.5 m, 3 m between the pivots, 1 kg each, uniform; journals of radius 0.055 m. Published
    with rigid plastic impacts (restitution 0), friction 0.1, and a controller that leads the crank. Left
    open by what could be read of it: the clearances, about 5 mm by its stored trajectory. Not those of the
    publication, since impacts here know no friction: a stiff contact that does not pull, and no drive.

    Parameters
    ----------
    clearance : float or dict of str to float
        Radial clearance, m: a number is joint B's; 0 or unnamed: ideal.
    **changes
        As in `Mechanism.replace`.

    Returns
    -------
    Mechanism
    """
    lengths = {"crank": 1.0, "coupler": 4.0, "rocker": 2.5}
    links = tuple(Link(name=name, length=l, mass=1.0, inertia=l**2 / 3) for name, l in lengths.items())
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", 1.0), on("coupler")),
        "B": (on("coupler", 4.0), on("rocker", 2.5)),
        "C": (on("rocker"), fixed(3.0, 0.0)),
    }
    joints = joined(pins, "", radius=0.055, stiffness=1e7, damping=1e3, friction=0.1)
    made = Mechanism(name="siconos_four_bar", links=links, joints=joints, gravity=9.81)
    return made.replace(clearance=clearance, tension=False, **changes)
