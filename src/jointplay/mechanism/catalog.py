"""Mechanisms and test systems by name.

Source of the linkage: Chunmei, Yang, Ling and Ling, "The non-linear dynamic behavior of an elastic linkage
mechanism with clearances", J. Sound Vib. (2002), Table 1. The test systems are dimensionless, on the time
scale on which their known answers are stated; each starts at time 0 from the state that its docstring
gives.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import Field

from jointplay.mechanism.base import GROUND, Flag, NonNegative, Number, Positive
from jointplay.mechanism.beam import Beam, Link
from jointplay.mechanism.joints import Contact, Friction, Joint, Pin
from jointplay.mechanism.records import Mechanism, MotorLine, TestSystem
from jointplay.mechanism.signature import checked

_RPM = 2 * math.pi / 60
_GEAR_RATIO = 15.0
_Restitution = Annotated[NonNegative, Field(le=1)]


@checked()
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
    return _table_1().replace(**given)


def _table_1() -> Mechanism:
    coupler, rocker, crank, ground = 0.181, 0.1175, 0.03, 0.2
    beam = Beam(shapes="sine", damping_ratio=0.01)
    links = (
        Link(name="crank", length=crank, mass=0.4489, inertia=1.5e-4, beam=beam),
        Link(name="coupler", length=coupler, mass=0.1743, inertia=2.7e-3, beam=beam),
        Link(name="rocker", length=rocker, mass=0.2916, inertia=1.34e-3, beam=beam),
    )
    joints = (
        _bearing("O", Pin(link="crank"), Pin(link=GROUND, point=(0.0, 0.0))),
        _bearing("A", Pin(link="crank", at=crank), Pin(link="coupler")),
        _bearing("B", Pin(link="coupler", at=coupler), Pin(link="rocker", at=rocker)),
        _bearing("C", Pin(link="rocker"), Pin(link=GROUND, point=(ground, 0.0))),
    )
    drive = MotorLine(
        link="crank",
        gear_ratio=_GEAR_RATIO,
        efficiency=0.8,
        synchronous_speed=3000 * _RPM,
        rated_speed=2825 * _RPM,
        rated_torque=2.2 * 9.8,
    )
    return Mechanism(name="chunmei2002", links=links, joints=joints, drive=drive, gravity=9.8)


def _bearing(name: str, journal: Pin, bearing: Pin) -> Joint:
    contact = Contact(stiffness=7.15e6, damping=228.0)
    return Joint(
        name=name,
        journal=journal,
        bearing=bearing,
        radius=0.015,
        contact=contact,
        friction=Friction(coefficient=0.01),
    )


def _system(
    name: str, initial: tuple[float, ...], period: float | None = None, **parameters: float
) -> TestSystem:
    return TestSystem(name=name, system=name, parameters=parameters, initial=initial, period=period)


@checked()
def lorenz(sigma: Number = 10.0, rho: Number = 28.0, beta: Number = 8 / 3) -> TestSystem:
    """Lorenz's system: x' = σ(y − x), y' = x(ρ − z) − y, z' = x y − β z; starts at (1, 1, 1)."""
    return _system("lorenz", (1.0, 1.0, 1.0), sigma=sigma, rho=rho, beta=beta)


@checked()
def rossler(a: Number = 0.2, b: Number = 0.2, c: Number = 5.7) -> TestSystem:
    """Rössler's system: x' = −y − z, y' = x + a y, z' = b + z(x − c); starts at (1, 1, 0)."""
    return _system("rossler", (1.0, 1.0, 0.0), a=a, b=b, c=c)


@checked()
def jerk(damping: NonNegative = 0.6) -> TestSystem:
    """Jerk of Linz and Sprott: x‴ = −a x″ − x′ + |x| − 1, its rate bent at x = 0; starts at (−0.5, 0, 0).

    Parameters
    ----------
    damping : float
        a.
    """
    return _system("jerk", (-0.5, 0.0, 0.0), damping=damping)


@checked()
def duffing(
    amplitude: NonNegative = 0.3, damping: NonNegative = 0.2, frequency: Positive = 1.0
) -> TestSystem:
    """Duffing's two-well oscillator: x'' + δ x' − x + x³ = f cos ω t; starts at rest in a well, (1, 0).

    Parameters
    ----------
    amplitude, damping, frequency : float
        f, δ and ω.
    """
    period = 2 * math.pi / frequency
    return _system("duffing", (1.0, 0.0), period, amplitude=amplitude, damping=damping, frequency=frequency)


@checked()
def impact_pair(gap: Positive, restitution: _Restitution) -> TestSystem:
    """Rattling mass in a shaken frame: y'' = sin t, |y| ≤ d/2, y' → −r y' at a wall; starts at (0, 0).

    Parameters
    ----------
    gap : float
        d between the walls, in units of forcing amplitude over frequency squared.
    restitution : float
        r, from 0 to 1.
    """
    return _system("impact_pair", (0.0, 0.0), 2 * math.pi, gap=gap, restitution=restitution)


@checked()
def soft_impact_pair(
    gap: Positive, stiffness: Positive, damping: NonNegative, tension: Flag = True
) -> TestSystem:
    """Unit mass in a shaken frame with soft walls: y'' = sin t − F; starts at rest midway, (0, 0).

    Beyond a wall, |y| > d/2, F = k (|y| − d/2) + c d|y|/dt, away from the wall.

    Parameters
    ----------
    gap : float
        d.
    stiffness, damping : float
        k and c.
    tension : bool
        False: contact ends where the force reaches 0, and a wall never pulls.
    """
    numbers = {"gap": gap, "stiffness": stiffness, "damping": damping, "tension": tension}
    return _system("soft_impact_pair", (0.0, 0.0), 2 * math.pi, **numbers)


@checked()
def bouncing_ball(acceleration: Positive, restitution: _Restitution) -> TestSystem:
    """Ball on a table that moves as sin t: y'' = −1/Γ in flight, lengths in table amplitudes, time in 1/ω.

    Starts a hundredth above the motion of one bounce a period, where cos t₀ = π(1 − a)/(Γ(1 + a)) at a
    bounce; where there is none, with t₀ = 0: (0.01 + sin t₀ + t₀(2π − t₀)/(2Γ), (t₀ − π)/Γ), height and
    velocity in the fixed frame.

    Parameters
    ----------
    acceleration : float
        Γ = A ω²/g of the table.
    restitution : float
        a, from 0 to 1.
    """
    bounce = math.acos(min(1.0, math.pi * (1 - restitution) / (acceleration * (1 + restitution))))
    height = math.sin(bounce) + bounce * (2 * math.pi - bounce) / (2 * acceleration)
    start = (0.01 + height, (bounce - math.pi) / acceleration)
    return _system("bouncing_ball", start, 2 * math.pi, acceleration=acceleration, restitution=restitution)


@checked()
def gear_backlash(
    mean_load: Number, amplitude: NonNegative, frequency: Positive, damping: NonNegative
) -> TestSystem:
    """Gear pair with backlash: x'' + 2ζ x' + f(x) = F_m + F_a W² cos W t; starts at (0.5, 0).

    f is x − 1 above 1, 0 within ±1, x + 1 below −1.

    Parameters
    ----------
    mean_load, amplitude, frequency, damping : float
        F_m, F_a, W and ζ.
    """
    numbers = {"mean_load": mean_load, "amplitude": amplitude, "frequency": frequency, "damping": damping}
    return _system("gear_backlash", (0.5, 0.0), 2 * math.pi / frequency, **numbers)


NAMES: dict[str, Callable[..., Mechanism | TestSystem]] = {
    "chunmei2002": chunmei2002,
    "lorenz": lorenz,
    "rossler": rossler,
    "jerk": jerk,
    "duffing": duffing,
    "impact_pair": impact_pair,
    "soft_impact_pair": soft_impact_pair,
    "bouncing_ball": bouncing_ball,
    "gear_backlash": gear_backlash,
}
