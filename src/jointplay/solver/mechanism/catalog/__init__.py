"""Mechanisms and test systems by name.

Source of the linkage: Chunmei, Yang, Ling and Ling, "The non-linear dynamic behavior of an elastic linkage
mechanism with clearances", J. Sound Vib. (2002), Table 1. Other linkages are those of the files beside
this one, test systems those of `mechanism.own.systems`.
"""

# ruff: noqa: F401, I001  all entries are offered here, which `as` tells type checkers

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from jointplay.display.errors import no_attribute
from jointplay.solver.extensions import Table
from jointplay.solver.mechanism.catalog.presets import four_bar_pins, joined
from jointplay.solver.mechanism.catalog.presets import (
    quick_return as quick_return,
    slider_crank as slider_crank,
)
from jointplay.solver.mechanism.catalog.published import (
    flores2010 as flores2010,
    ivp_crank as ivp_crank,
    siconos_four_bar as siconos_four_bar,
)
from jointplay.solver.mechanism.catalog.presets import stephenson as stephenson, watt as watt
from jointplay.solver.mechanism.own.own import CATALOG
from jointplay.solver.mechanism.own.systems import (
    SYSTEMS,
    TestSystem,
    bouncing_ball as bouncing_ball,
    cam_follower as cam_follower,
    duffing as duffing,
    gear_backlash as gear_backlash,
    impact_pair as impact_pair,
    jerk as jerk,
    lorenz as lorenz,
    relief_valve as relief_valve,
    rossler as rossler,
    soft_impact_pair as soft_impact_pair,
)
from jointplay.solver.mechanism.parts.beam import Beam, Link
from jointplay.solver.mechanism.records import Mechanism, MotorLine
from jointplay.solver.mechanism.signature import preset

_RPM = 2 * math.pi / 60
_GEAR_RATIO = 15.0


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
    return _table_1().replace(**given)


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


_LINKAGES = (
    *(chunmei2002, slider_crank, watt, stephenson, quick_return),
    *(ivp_crank, flores2010, siconos_four_bar),
)
CATALOG.own = {each.__name__: each for each in _LINKAGES} | CATALOG.own
NAMES: Table[Callable[..., Mechanism | TestSystem]] = CATALOG


def __getattr__(name: str) -> Any:
    if name[:1] != "_" and name in NAMES:
        return NAMES[name]
    raise no_attribute("the catalog", name, NAMES)


def __dir__() -> list[str]:
    return sorted(NAMES)
