"""Character of a steady motion: contact and impacts a turn, period, growth of a small difference.

The one rule by which this project calls a motion periodic or chaotic:

periodic   a period is found and a small difference shrinks, by more than 3 standard errors of its growth;
chaotic    no period is found and a small difference grows, by more than 3 standard errors;
undecided  all else.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jointplay.analysis.contacts import ROW, TIME, closed, counts
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.exponents.growth import Turn, averaged, measure
from jointplay.analysis.labels import Out
from jointplay.analysis.period import period
from jointplay.analysis.rules import quantity
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism
from jointplay.solver.motion.trajectory import Records

MOTIONS = ("undecided", "periodic", "chaotic")
NUMBERS = {  # of a motion, by their names in the answers of `character`
    "separations": Out((), "losses of contact in a turn"),
    "impacts": Out((), "contacts begun in a turn"),
    "contact_fraction": Out((), "fraction of time in contact"),
    "extent": Out((), "largest extent of the section points over the clearance"),
    "growth": Out((), "mean logarithm of the growth of a difference in a turn"),
    "growth_standard_error": Out((), "standard error of the growth"),
    "period": Out((), "period in turns; 0: none found, -1: not computed", missing=np.int32(-1)),
    "motion": Out((), "what the motion is", flags=MOTIONS, missing="undecided"),
}
ERRORS = 3  # standard errors by which a growth must differ from 0
TOLERANCE = 1e-4  # of the clearance: spread of section points that count as one
RTOL = 1e-10


def character(
    mechanism: Mechanism,
    *,
    turns: int = 300,
    transient: int = 400,
    growth_turns: int = 200,
    tolerance: float = TOLERANCE,
    rtol: float = RTOL,
    max_steps: int | None = None,
    initial: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Follow one motion of a linkage with one clearance joint, and classify it.

    Parameters
    ----------
    mechanism : Mechanism
        With clearance at one joint.
    turns, transient, growth_turns : int
        Turns looked at; turns dropped before; turns over which the growth is then averaged (0: none).
    tolerance : float
        Spread of the section points of one place, as a fraction of the clearance.
    rtol : float
        Relative tolerance of a step; the growth is followed at its own.
    max_steps : int, optional
        Attempted steps after which the run stops.
    initial : mapping, optional
        As in `simulate`.

    Returns
    -------
    dict
        ``status``; ``points``, shape (turns, 2), the journal's centre over the clearance at the section;
        ``separations`` and ``impacts`` a turn; ``contact_fraction``; ``period``; ``growth``,
        ``growth_standard_error`` a turn; ``motion``, an index into `MOTIONS`.
    """
    model = assemble(mechanism, initial, quantity(CrankAngle(), mechanism))
    turn, state, status = Turn(model, rtol, max_steps), model.state, 0
    if transient:
        state, _, status = turn(state, transient)
    if status:
        return {"status": status}
    records = turn.records(state, turns, events=True)
    if records.status:
        return {"status": records.status}
    points = _points(model, records)
    logs, status = np.zeros(0), 0
    if growth_turns:
        logs, _, status = measure(Turn(model, max_steps=max_steps), turn.state_at(records), growth_turns)
    last = records.sections[-1]
    contacts = counts(records.events, last[TIME], len(points), bool(closed(model, records, last[ROW:])[0]))
    turns_a_period, (growth, error) = period(points, tolerance), averaged(logs)
    result = {"points": points, "period": turns_a_period, "growth": growth, "growth_standard_error": error}
    return contacts | result | {"motion": motion(turns_a_period, growth, error), "status": status}


def motion(period: int, growth: float, error: float) -> int:
    """Index into `MOTIONS`, by the rule at the head of this file; NaN leaves it undecided."""
    if period and growth < -ERRORS * error:
        return MOTIONS.index("periodic")
    if not period and growth > ERRORS * error:
        return MOTIONS.index("chaotic")
    return MOTIONS.index("undecided")


def _points(model: Model, records: Records) -> np.ndarray:
    """The journal's centre over the clearance at the section, shape (turns, 2)."""
    cut = Quantities(model, records.sections[:, 2:], records.start)
    found = cut.variables(("journal_x", "journal_y"), "turn")
    return np.stack([found[name][1][:, 0] for name in ("journal_x", "journal_y")], -1) / model.clearances[0]
