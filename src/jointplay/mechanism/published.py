"""Published mechanisms with all their parameters. What a publication leaves open is said with each."""

from __future__ import annotations

from typing import Annotated, Any

from jointplay.mechanism.base import NonNegative, unit
from jointplay.mechanism.beam import Beam, Link
from jointplay.mechanism.drive import ConstantSpeed
from jointplay.mechanism.friction import Friction
from jointplay.mechanism.joints import Contact, Joint
from jointplay.mechanism.preset_parts import Gravity, Play, fixed, joined, on
from jointplay.mechanism.records import Mechanism
from jointplay.mechanism.signature import checked

_SLIDER = 0.02  # m: a size that nothing depends on
_Restitution = Annotated[NonNegative, unit("restitution", "1")]
_Coefficient = Annotated[NonNegative, unit("friction coefficient", "1")]


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

    Links of 1, 4 and 2.5 m, 3 m between the pivots, 1 kg each, uniform; journals of radius 0.055 m, bearings
    of 0.06 m. Published with rigid plastic impacts (restitution 0), friction 0.1, and a controller that makes
    the crank's angle follow 6 sin(3πt/4) rad by a torque computed from its angle and speed. Not those of the
    publication: a stiff contact that does not pull, and no drive, since none here is such a controller.

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


@checked()
def flores2010(
    clearance: Play = {"G": 1e-3},  # noqa: B006  read only
    restitution: _Restitution = 0.4,
    friction: _Coefficient = 0.01,
    gravity: Gravity = 9.81,
    **changes: Any,
) -> Mechanism:
    """Give the slider-crank of Flores, Leine and Glocker (2010), with clearance in the slider's guide G.

    Crank O–A, rod A–B, slider at B; nobody drives. Theirs starts at crank angle 0 with 150 rad/s:
    ``initial={"crank_speed": 150.0}``, at which the rod turns with −75 rad/s and the slider not at all.

    Corners of the slider meet rigid faces with Newton's restitution and Coulomb's friction, two at one
    instant by these laws for both at once: so the first impact, of both upper corners, at 0.00269250275202121
    s. Compliant laws part from it there, however stiff.

    Parameters
    ----------
    clearance : float or dict of str to float
        Of G on either side, m; 0 or unnamed: ideal.
    restitution : float
        Of the corners, 0 to 1.
    friction : float
        Coulomb's coefficient at the corners.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    rows = (
        ("crank", 0.153, 0.038, 0.0765, 7.4e-5),
        ("rod", 0.306, 0.038, 0.153, 5.9e-4),
        ("slider", 0.1, 0.076, 0.0, 2.7e-6),
    )
    links = tuple(Link(name=k, length=l, mass=m, centre=s, inertia_centre=I) for k, l, m, s, I in rows)
    law = Contact(law="restitution", parameters={"restitution": restitution})
    block = {"kind": "prismatic", "half_length": 0.05, "half_height": 0.025, "contact": law}
    block["friction"] = Friction(coefficient=friction)
    joints = (
        Joint(name="O", journal=on("crank"), bearing=fixed(0.0, 0.0)),
        Joint(name="A", journal=on("crank", 0.153), bearing=on("rod")),
        Joint(name="B", journal=on("rod", 0.306), bearing=on("slider")),
        Joint(name="G", journal=on("slider"), bearing=fixed(0.0, 0.0), **block),
    )
    made = Mechanism(name="flores2010", links=links, joints=joints, gravity=gravity, guess={"rod": 0.0})
    return made.replace(clearance=clearance, **changes)
