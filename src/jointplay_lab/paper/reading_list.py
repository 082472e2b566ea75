"""The readings of what a paper leaves open: each changes the mechanism as printed, or how it is followed.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002); several of its equations and parameters can
be read in more than one way. A reading changes one thing and leaves all else as printed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointplay.analysis.period import period
from jointplay.analysis.quantities import STATUS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.joints import Friction
from jointplay.solver.mechanism.records import Mechanism, MotorLine
from jointplay_lab.paper.character import MOTIONS, character
from jointplay_lab.paper.coarse import coarse_section
from jointplay_lab.paper.fixed_steps import step_bound

PANELS = {"a": (2.9e-5, 15.0), "b": (2.9e-5, 3.0), "c": (2.9e-4, 3.0)}  # clearance in m, gear ratio
CREEP = 0.01  # m/s, of the regularised friction: about a tenth of the usual sliding speed
COARSE = 0.95  # of the longest stable step of RK4


@dataclass(frozen=True)
class Reading:
    """One way to read the paper.

    Parameters
    ----------
    text : str
        One line for people.
    change : callable
        From the mechanism as printed to the mechanism so read.
    settings : dict
        Keywords of `measure` that differ from what is asked for.
    measure : callable
        Classifies a motion: `character`, or a function like it.
    """

    text: str
    change: Callable[[Mechanism], Mechanism] = lambda mechanism: mechanism
    settings: dict[str, Any] = field(default_factory=dict)
    measure: Callable[..., dict[str, Any]] = character


def _replaced(**changes: Any) -> Callable[[Mechanism], Mechanism]:
    return lambda mechanism: mechanism.replace(**changes)


def _parts(mechanism: Mechanism, **fields: Any) -> Mechanism:
    """Return a validated copy with other links, joints or drive."""
    return type(mechanism)(**dict(mechanism) | fields)


def _coupler(change: Callable[[Link], dict[str, float]]) -> Callable[[Mechanism], Mechanism]:
    """Another mass model of the coupler: the fields of its record that change."""

    def changed(mechanism: Mechanism) -> Mechanism:
        links = (link.total for link in mechanism.links)
        changes = ((link, change(link) if link.name == "coupler" else {}) for link in links)
        return _parts(mechanism, links=tuple(link.model_copy(update=update) for link, update in changes))

    return changed


def _point_mass(link: Link) -> dict[str, float]:
    """A uniform bar and a point at its far end, of the link's mass and inertia."""
    point = 1.5 * (link.inertia / link.length**2 - link.mass / 3)
    return {"centre": (link.mass + point) / 2 * link.length / link.mass}


def _uniform(link: Link) -> dict[str, float]:
    return {"inertia": link.mass * link.length**2 / 3}


def _diametral(mechanism: Mechanism) -> Mechanism:
    return mechanism.replace(clearance={j.name: j.clearance / 2 for j in mechanism.clearance_joints})


def _regularised(mechanism: Mechanism) -> Mechanism:
    coefficients = [joint.friction.coefficient for joint in mechanism.joints]
    laws = (Friction(law="tanh", coefficient=f, velocity=CREEP) for f in coefficients)
    pairs = zip(mechanism.joints, laws, strict=True)
    return _parts(mechanism, joints=tuple(joint.model_copy(update={"friction": law}) for joint, law in pairs))


def _newton_metres(mechanism: Mechanism) -> Mechanism:
    drive: MotorLine = mechanism.drive
    return _parts(mechanism, drive=drive.model_copy(update={"rated_torque": drive.rated_torque / 9.8}))


def coarse(mechanism: Mechanism, *, turns: int, transient: int, tolerance: float, **_: Any) -> dict[str, Any]:
    """Follow a motion by RK4 with a step near the longest stable one and no location of events.

    As `character`, as far as such a run can tell: no growth, so nothing is called periodic or chaotic.
    """
    step = COARSE * step_bound(assemble(mechanism)).step
    found = coarse_section(mechanism, step, turns, transient)
    points = np.stack([found[name][:, 0] for name in ("journal_x", "journal_y")], -1)
    points = points / mechanism.clearance_joints[0].clearance
    if len(points) < turns:  # it grew beyond measure, or the crank stopped turning
        return {"status": STATUS.index("diverged")}
    return {
        "status": 0,
        "points": points,
        "separations": float(found["separations"][:, 0].mean()),
        "period": period(points, tolerance),
        "motion": MOTIONS.index("undecided"),
    }


READINGS: dict[str, Reading] = {
    "as_printed": Reading("as printed: Coulomb friction 0.01 with true sticking, contact that may pull"),
    "efficiency_in_slope": Reading(
        "the gear's efficiency in the slope of the motor line too", _replaced(efficiency_in_slope=True)
    ),
    "rated_torque_in_newton_metres": Reading("M_b is 2.2 N m and not 2.2 kg m", _newton_metres),
    "no_tension": Reading("contact ends where its force reaches 0", _replaced(tension=False)),
    "frictionless": Reading("no friction", _replaced(friction=0.0)),
    "friction_tanh": Reading("friction f tanh(v_t/v_0) F_n, v_0 = 0.01 m/s", _regularised),
    "point_mass_at_B": Reading("coupler a uniform bar with a point mass at B (M1)", _coupler(_point_mass)),
    "end_bosses": Reading("coupler a bar with equal bosses at its ends (M2): rigid, it is the printed one"),
    "uniform_coupler": Reading("coupler uniform, J_A = m l²/3 in place of Table 1 (M3)", _coupler(_uniform)),
    "diametral_clearance": Reading("e is the diametral clearance: half of it radially", _diametral),
    "lower_branch": Reading("rocker below the ground line", _replaced(branch="lower")),
    "start_up": Reading("turns from the first on, none dropped", settings={"transient": 0}),
    "short_transient": Reading("20 turns dropped", settings={"transient": 20}),
    "long_transient": Reading("2000 turns dropped", settings={"transient": 2000}),
    "coarse_rk4": Reading(
        "RK4, 0.95 of its longest stable step, events not located; 40 turns after 40",
        settings={"turns": 40, "transient": 40},
        measure=coarse,
    ),
}
