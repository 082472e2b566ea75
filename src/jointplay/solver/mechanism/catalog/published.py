"""Published mechanisms with all their parameters; choices that a publication leaves open are stated.

Source of the crank-rocker: Chunmei, Yang, Ling and Ling, "The non-linear dynamic behavior of an elastic
linkage mechanism with clearances", J. Sound Vib. (2002), Table 1.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated, Any

from jointplay.solver.mechanism.base import NonNegative, unit
from jointplay.solver.mechanism.catalog.presets import Gravity, Play, fixed, four_bar_pins, joined, on
from jointplay.solver.mechanism.parts.beam import Beam, Link
from jointplay.solver.mechanism.parts.courses import Harmonic
from jointplay.solver.mechanism.parts.drive import ConstantSpeed, MotorLine, Servo
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.mechanism.parts.joints import Contact, Joint
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.mechanism.signature import preset

_RPM = 2 * math.pi / 60
_GEAR_RATIO = 15.0
_SLIDER = 0.02  # m: a size that nothing depends on
_Restitution = Annotated[NonNegative, unit("restitution", "1")]
_Coefficient = Annotated[NonNegative, unit("friction coefficient", "1")]


@preset("chunmei2002")
def chunmei2002(clearance: Any = 2.9e-5, gear_ratio: float = _GEAR_RATIO, **changes: Any) -> Mechanism:
    """Give the motor-driven crank-rocker of Chunmei et al. (2002), with clearance at joint B.

    The gear ratio is not in the paper's Table 1; its Figure 12 uses 15 and 3. The mass centres are not
    given either: halfway along each link, which the rocker's inertia confirms. The rated torque of 2.2 kg·m
    is 2.2 × 9.8 N m. Every joint carries B's radius, contact and friction data, so that any of them can be
    given clearance. Every link is rigid and carries a beam, so that any can be made elastic: the table's
    modulus 2.1 × 10¹¹ Pa and damping ratio 0.01; density and section are not in the paper, and here are
    those of a round steel bar of the link's mass. It bends in four sine modes. The paper's two elements
    (``elements=2``) cost as much, but drift out of phase: see ``studies/elastic``.

    Parameters
    ----------
    clearance : float or dict of str to float
        Radial clearance, m: a number is joint B's; 0 or unnamed: ideal.
    gear_ratio : float
        Motor speed over crank speed.
    **changes
        As in `Mechanism.replace`.

    Returns
    -------
    Mechanism
    """
    given = {"clearance": clearance, **changes}
    # By identity: the default gives way to another drive, but a ratio that was given contradicts it.
    if gear_ratio is not _GEAR_RATIO or not {"speed", "drive"} & changes.keys():
        given["gear_ratio"] = gear_ratio
    return _table_1().changed(given)


def _table_1() -> Mechanism:
    coupler, rocker, crank, ground = 0.181, 0.1175, 0.03, 0.2
    beam = Beam(shapes="sine", damping_ratio=0.01)
    links = (
        Link(name="crank", length=crank, mass=0.4489, inertia=1.5e-4, beam=beam),
        Link(name="coupler", length=coupler, mass=0.1743, inertia=2.7e-3, beam=beam),
        Link(name="rocker", length=rocker, mass=0.2916, inertia=1.34e-3, beam=beam),
    )
    pins = four_bar_pins(crank, coupler, rocker, ground)
    joints = joined(pins, (), radius=0.015, stiffness=7.15e6, damping=228.0, friction=0.01)
    drive = MotorLine(
        link="crank",
        gear_ratio=_GEAR_RATIO,
        efficiency=0.8,
        synchronous_speed=3000 * _RPM,
        rated_speed=2825 * _RPM,
        rated_torque=2.2 * 9.8,
    )
    return Mechanism(name="chunmei2002", links=links, joints=joints, drive=drive, gravity=9.8)


@preset("simeon1996")
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


# The controller of the four-bar below: what the ideal linkage needs, in closed form. `half` is the tangent of
# half the rocker's angle; c and s are cosines and sines of coupler and rocker, `across` and `along` those of
# the angle between them, `k` and `dk` their speeds and accelerations over the crank's.
_MODEL = {
    "x": "0.25 - 6*cos(angle)",
    "root": "sqrt((5*sin(angle))**2 + (15 - 5*cos(angle))**2 - x**2)",
    "half": "(5*sin(angle) - root)/(x - 15 + 5*cos(angle))",
    "c_rocker": "(1 - half**2)/(1 + half**2)",
    "s_rocker": "2*half/(1 + half**2)",
    "c_coupler": "(3 - cos(angle) + 2.5*c_rocker)/4",
    "s_coupler": "(2.5*s_rocker - sin(angle))/4",
    "across": "s_coupler*c_rocker - c_coupler*s_rocker",
    "along": "c_coupler*c_rocker + s_coupler*s_rocker",
    "ahead": "c_coupler*cos(angle) + s_coupler*sin(angle)",
    "aside": "s_coupler*cos(angle) - c_coupler*sin(angle)",
    "k_coupler": "(s_rocker*cos(angle) - c_rocker*sin(angle))/(4*across)",
    "k_rocker": "aside/(2.5*across)",
    "dk": "along*(k_coupler - k_rocker)",
    "dk_coupler": "((k_rocker - 1)*(c_rocker*cos(angle) + s_rocker*sin(angle)) - 4*k_coupler*dk)/(4*across)",
    "dk_rocker": "((k_coupler - 1)*ahead - 2.5*k_rocker*dk)/(2.5*across)",
    "inertia": "4/3 + 16/3*k_coupler**2 + 25/12*k_rocker**2 + 4*ahead*k_coupler",
    "coupled": "ahead*dk_coupler + k_coupler*aside*(1 - k_coupler)",
    "slope": "16/3*k_coupler*dk_coupler + 25/24*k_rocker*dk_rocker + 2*coupled",
    "weight": "9.81*(1.5*cos(angle) + 2*k_coupler*c_coupler + 1.25*k_rocker*c_rocker)",
    "wanted": "wanted_acceleration - 10*(angular_velocity - wanted_velocity)",
    "reached": "angular_velocity - 10*(angle - wanted_angle)",
}


@cache
def _controller() -> Servo:
    return Servo(
        link="crank",
        stiffness=2000.0,
        damping=200.0,
        harmonics=(Harmonic(order=1, sine=6.0),),
        frequency=0.75 * math.pi,
        where=_MODEL,
        feedforward="inertia*wanted + slope*angular_velocity*reached + weight",
        nominal_speed=4.5 * math.pi,
    )


@preset("acary_brogliato2008", "slotine_li1991")
def siconos_four_bar(
    clearance: Play = {"A": 5e-3, "B": 5e-3, "C": 5e-3},  # noqa: B006  read only
    restitution: _Restitution | None = 0.0,
    friction: _Coefficient = 0.1,
    **changes: Any,
) -> Mechanism:
    """Give the four-bar with three clearances of the Siconos examples (``FourBarClearance``).

    Links of 1, 4 and 2.5 m, 3 m between the pivots, 1 kg each, uniform; journals of radius 0.055 m, bearings
    of 0.06 m, rigid. A controller (Slotine and Li 1991) makes the crank's angle follow 6 sin(3πt/4) rad: 200
    N m s/rad times what angle and speed lack, λ = 10 1/s, and the torque of the ideal linkage at the crank's
    angle, which stays that of these numbers whatever is changed. As published, its term of the speed's square
    has the rocker's inertia about its centre, and θ' − λ (θ − φ) in the place of φ' − λ (θ − φ). Theirs
    starts at rest, the crank upright: ``initial={"crank_angle": pi / 2, "crank_speed": 0.0}``, to 3e-5 rad.

    Parameters
    ----------
    clearance : float or dict of str to float
        Radial clearance, m: a number is joint B's; 0 or unnamed: ideal.
    restitution : float or None
        Of the journals, 0 to 1; None: a stiff contact that does not pull instead.
    friction : float
        Coulomb's coefficient in the bearings.
    **changes
        As in `Mechanism.replace`.

    Returns
    -------
    Mechanism
    """
    lengths = {"crank": 1.0, "coupler": 4.0, "rocker": 2.5}
    links = tuple(Link(name=name, length=l, mass=1.0, inertia=l**2 / 3) for name, l in lengths.items())
    contact = Contact(stiffness=1e7, damping=1e3, tension=False)
    if restitution is not None:
        contact = Contact(law="restitution", parameters={"restitution": restitution})
    law = {"contact": contact, "friction": Friction(coefficient=friction), "radius": 0.055}
    pins = four_bar_pins(*lengths.values(), 3.0).items()
    joints = tuple(Joint(name=name, journal=one, bearing=two, **law) for name, (one, two) in pins)
    made = Mechanism(name="siconos_four_bar", links=links, joints=joints, drive=_controller(), gravity=9.81)
    return made.changed({"clearance": clearance} | changes)


@preset("flores2010")
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
    return made.changed({"clearance": clearance} | changes)
