"""The reference's mechanisms as the package's records, and states at which both are compared."""

from __future__ import annotations

import numpy as np

from jointplay.mechanism import catalog
from jointplay.mechanism.parts import Contact, Friction
from jointplay.mechanism.records import ConstantSpeed, Mechanism

from .reference.bodies import Bodies, Parameters

ARRANGEMENTS = ("B", "C", "A", "O", "BC", "AC", "OABC")
SMALL = 2.9e-5
MODES = ("free", "released", "slip+", "slip-", "stick", "contact")


def mechanism(p: Parameters, clearance: dict[str, float]) -> Mechanism:
    """The package's record of a mechanism of the reference."""
    plain = catalog.chunmei2002(clearance=clearance, gear_ratio=p.i, gravity=p.gravity)
    contact = Contact(stiffness=p.K, damping=p.C_n, tension=p.tension)
    friction = Friction(coefficient=p.f, viscous=p.C_t) if p.f or p.C_t else None
    fields = {name: getattr(plain, name) for name in type(plain).model_fields}
    fields["joints"] = tuple(
        joint.model_copy(update={"contact": contact, "friction": friction}) for joint in plain.joints
    )
    drives = {"motor": plain.drive, "speed": ConstantSpeed(link="crank", speed=p.w0), "none": None}
    return Mechanism(**fields | {"drive": drives[p.drive]})


def start(p: Parameters) -> dict[str, float]:
    """The reference's start, for a mechanism that no drive gives a speed."""
    return {"crank_angle": 0.0, "crank_speed": p.w0}


def scattered(system: Bodies, seed: int) -> np.ndarray:
    """A state in which every joint is displaced by more than its clearance, and moves; any crank angle."""
    random = np.random.default_rng(seed)
    size = np.repeat([1e-3, 5.0], system.n)
    y = system.start() + size * random.standard_normal(2 * system.n)
    if system.p.drive == "speed":
        y[system.n] = system.p.w0
    return y


def own_state(system: Bodies, y: np.ndarray) -> np.ndarray:
    """The package's positions and speeds at the reference's state y; a prescribed crank is none of them."""
    if system.p.drive != "speed":
        return np.array(y)
    return np.delete(y, [0, system.n])
