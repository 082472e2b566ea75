"""Readings of a paper's open points: each changes the mechanism as printed, or the way it is followed.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002); several of its equations and parameters can
be read in more than one way. A reading changes one thing and leaves all else as printed.

Coarse fixed steps give what a simple program would: contact is looked at where the steps happen to fall. A
numerical-chaos hypothesis to try on published sections; as an answer about the mechanism use `poincare`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.period import period
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import SLACK
from jointplay.analysis.starts import crank_place
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parts.beam import Link
from jointplay.solver.mechanism.parts.joints import Friction
from jointplay.solver.mechanism.records import Mechanism, MotorLine, TestSystem
from jointplay_lab.paper.character import MOTIONS, character
from jointplay_lab.paper.fixed_steps import March, accepted_step, step_bound

PANELS = {"a": (2.9e-5, 15.0), "b": (2.9e-5, 3.0), "c": (2.9e-4, 3.0)}  # clearance in m, gear ratio
CREEP = 0.01  # m/s, of the regularised friction: about a tenth of the usual sliding speed
COARSE = 0.95  # of the longest stable step of RK4
CHUNK = 16384  # steps followed at once
UPDATES, CLOSE = 8, 1e-12  # of a section point's place in its step
RELEASED = 1  # the last contact mode without a force
QUANTITIES = ("angle", "angular_velocity", "journal_x", "journal_y", "penetration", "normal_velocity")


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


def coarse_section(
    mechanism: Mechanism | TestSystem, step: float | None, turns: int, transient: int = 0
) -> dict[str, np.ndarray]:
    """Cut a motion that is followed by fixed steps at the crank angle of its start, once a turn.

    Each point is reached by a shorter step of the method from the last step before it.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves; a test system must be forced.
    step : float or None
        Step, s, at most the longest stable one; None: half of that.
    turns, transient : int
        Section points kept, and section points dropped before.

    Returns
    -------
    dict of str to ndarray
        By point, then as said: ``time`` (s), ``state`` (states), ``mode`` (contacts), ``separations``
        (contacts; how often the steps saw contact lost in the turn that ends there), and for a linkage those
        of `QUANTITIES` that it has (links or joints). Fewer points than asked for if the motion grows beyond
        measure or the crank stops turning.

    Raises
    ------
    InputError
        If the step is too long.
    """
    model = assemble(mechanism)
    h, march, crank = accepted_step(model, step), March.of(model), Crank.of(model)
    n_x, wanted = len(model.state), transient + turns
    start, lost = np.concatenate([[0.0], model.state]), np.zeros(len(model.joints), dtype=np.int64)
    points, losses = [], [lost]
    while len(points) < wanted and start[0] < SLACK * model.period * wanted:
        rows = march(start, h, CHUNK)
        touching = rows[:, 1 + n_x :] > RELEASED
        total = lost + np.cumsum(touching[:-1] & ~touching[1:], axis=0)
        for i in crank.passes(rows):
            points.append(_point(march, crank, rows[i], h))
            losses.append(total[i])
        if not np.all(np.isfinite(rows[-1])):
            break
        start, lost = rows[-1, : 1 + n_x], total[-1]
    kept = slice(transient, wanted)
    rows = np.array(points).reshape(len(points), 1 + n_x + len(model.joints))[kept]
    separations = np.diff(np.array(losses), axis=0)[kept]
    return _columns(model, rows) | {"separations": separations}


@dataclass(frozen=True)
class Crank:
    """The crank's angle in a record's row (or the phase of a forcing): a column of it, or rate times time."""

    column: int | None
    rate: float
    start: float
    forward: int

    @classmethod
    def of(cls, model: Model) -> Crank:
        """Read it from a model."""
        place, forward = crank_place(model), -1 if model.crank_speed < 0 else 1
        column = None if place is None else 1 + place  # after the time
        return cls(column, forward * math.tau / model.period, model.crank_angle, forward)

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """Turns made since the start."""
        if self.column is None:
            return rows[..., 0] * abs(self.rate) / math.tau
        return (rows[..., self.column] - self.start) * self.forward / math.tau

    def passes(self, rows: np.ndarray) -> np.ndarray:
        """Numbers of the rows after which a turn is completed."""
        whole = np.floor(self(rows))
        return np.flatnonzero(whole[1:] > np.maximum.accumulate(whole)[:-1])


def _point(march: March, crank: Crank, row: np.ndarray, h: float) -> np.ndarray:
    """The record where the turn is completed, within a step from `row`."""
    start = row[: 1 + len(march.model.state)]
    before = crank(row)
    target, place, rate = np.floor(before) + 1.0, 0.0, None
    found, value = row, before
    for _ in range(UPDATES):
        if rate is None:
            rate = crank(march(start, h, 1)[-1]) - before
        change = (target - value) / rate
        place += change
        found = march(start, place * h, 1)[-1]
        value = crank(found)
        if abs(change) < CLOSE:
            break
    return found


def _columns(model: Model, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of the points by name."""
    n_x = len(model.state)
    columns = {"time": rows[:, 0], "state": rows[:, 1 : 1 + n_x], "mode": rows[:, 1 + n_x :].astype(np.int8)}
    if model.links:
        names = QUANTITIES if model.joints else QUANTITIES[:2]
        values = Quantities(model, rows, rows[0]).variables(names, "turn")
        columns |= {name: each[1] for name, each in values.items()}
    return columns
