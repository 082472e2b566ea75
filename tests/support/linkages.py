"""The reference's mechanisms as the package's records, and states at which both are compared."""

from __future__ import annotations

import numpy as np

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.parts.beam import Beam
from jointplay.solver.mechanism.parts.joints import Contact, Friction
from jointplay.solver.mechanism.records import ConstantSpeed, Mechanism
from tests.reference.four_bar import FourBar, Parameters

ARRANGEMENTS = ("B", "C", "A", "O", "BC", "AC", "OABC")
SMALL = 2.9e-5
MODES = ("free", "released", "slip+", "slip-", "stick", "contact")
SOFT = {  # so soft that stiffness, inertia of second order and gravity are of one size
    "crank": Beam(modulus=1e4, damping_ratio=0.03),
    "coupler": Beam(modulus=1e7, damping_ratio=0.01, elements=None, shapes="sine", modes=3),
    "rocker": Beam(modulus=2e7, damping_ratio=0.0),
}


def altered(record, **changes):
    """A record with other fields, checked."""
    return type(record)(**dict(record) | changes)


def jointed(plain: Mechanism, loose: bool = False, **data) -> Mechanism:
    """A mechanism with other data in all its joints, or in the loose ones alone."""
    joints = (joint if loose and joint.ideal else joint.model_copy(update=data) for joint in plain.joints)
    return altered(plain, joints=tuple(joints))


def mechanism(p: Parameters, clearance: dict[str, float], smooth: float | None = None) -> Mechanism:
    """The package's record of a mechanism of the reference; `smooth` is the velocity of friction by tanh."""
    plain = catalog.chunmei2002(clearance=clearance, gear_ratio=p.i, gravity=p.gravity)
    contact = Contact(stiffness=p.K, damping=p.C_n, tension=p.tension)
    law = "tanh" if smooth else "coulomb"
    sliding = Friction(law=law, coefficient=p.f, viscous=p.C_t, velocity=smooth)
    friction = sliding if p.f or p.C_t else None
    drives = {"motor": plain.drive, "speed": ConstantSpeed(link="crank", speed=p.w0), "none": None}
    return altered(jointed(plain, contact=contact, friction=friction), drive=drives[p.drive])


def bending(rigid: Mechanism, beams: dict[str, Beam], order: str = "consistent") -> Mechanism:
    """The mechanism with elastic links, their beams by name."""
    links = (
        altered(link, elastic=True, beam=beams[link.name]) if link.name in beams else link
        for link in rigid.links
    )
    return altered(rigid, links=tuple(links), order=order)


def start(p: Parameters) -> dict[str, float]:
    """The reference's start, for a mechanism that no drive gives a speed."""
    return {"crank_angle": 0.0, "crank_speed": p.w0}


def own_state(system: FourBar, y: np.ndarray) -> np.ndarray:
    """The package's positions and speeds at the reference's state y; a prescribed crank is none of them."""
    first = int(system.p.drive == "speed" and bool(system.clearance))
    halves = np.split(np.asarray(y), 2)
    return np.concatenate(
        [part for half in halves for part in (half[system.rigid :], half[first : system.rigid])]
    )
