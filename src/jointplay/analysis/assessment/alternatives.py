"""The sensitivity of an assessment: the same motion with other contact data, each within its uncertainty.

Stiffness and damping of a contact are known to a factor, a coefficient of restitution to some tenths,
friction to a factor of two or not at all. All joints with clearance are changed alike. No friction is a
thousandth of it: the motion is the same, and the equations are those of before. Where all these joints are
given by pin and bush, the least and the largest value that follow from them are taken instead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from jointplay.analysis.assessment.forces import columns, forces
from jointplay.analysis.assessment.settled import LONGER, SLOW, SOUGHT, Settled, Unsettled, reached
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.progress import stands

NUMBERS = {  # what is changed together
    "stiffness": ("stiffness", "journal_modulus", "bearing_modulus"),
    "damping": ("damping", "dissipation"),
    "restitution": ("restitution",),
    "friction": ("coefficient", "static_coefficient"),
}
PLACES = ("contact", "friction")  # of a joint, where they stand
ENDS = {"÷10": "low", "×10": "high", "÷3": "low", "×3": "high"} | {"−0.2": "low", "+0.2": "high"}
ENDS |= {"none": "low", "×2": "high"}
ESTIMATES = {"damping": "dissipation"}  # names in contact data
NONE = 1e-3  # of a coefficient of friction: none
CHANGES: tuple[tuple[str, str, Callable[[float], float]], ...] = (
    ("stiffness", "÷10", lambda x: x / 10),
    ("stiffness", "×10", lambda x: 10 * x),
    ("damping", "÷3", lambda x: x / 3),
    ("damping", "×3", lambda x: 3 * x),
    ("restitution", "−0.2", lambda x: x - 0.2),
    ("restitution", "+0.2", lambda x: x + 0.2),
    ("friction", "none", lambda x: NONE * x),
    ("friction", "×2", lambda x: 2 * x),
)
PER_TURN = 1024  # samples of a turn
LEAST = 0.01  # coefficient of restitution


class Variant(NamedTuple):
    """Other contact data: what is changed, how, and the mechanism."""

    quantity: str
    change: str
    mechanism: Mechanism


def variants(mechanism: Mechanism) -> Iterator[Variant]:
    """Yield a mechanism with other contact data, one after another."""
    places = tuple(f"joints.{joint.name}.{of}." for joint in mechanism.clearance_joints for of in PLACES)
    numbers = [each for each in Parameter.of(mechanism) if each.key.startswith(places)]
    estimated = all(joint.data is not None for joint in mechanism.clearance_joints)
    for quantity, change, changed in CHANGES:
        own = [each for each in numbers if each.key.rsplit(".", 1)[-1] in NUMBERS[quantity] and each.value]
        values = {each.key: changed(each.value) for each in own}
        if estimated:
            change, name = ENDS[change], ESTIMATES.get(quantity, quantity)
            values = {each.key: _scaled(mechanism, name, change, each) for each in own}
        if quantity == "restitution":
            values = {key: min(max(value, LEAST), 1.0) for key, value in values.items()}
        if values and any(values[each.key] != each.value for each in own):
            yield Variant(quantity, change, mechanism.varied(values))


def _scaled(mechanism: Mechanism, quantity: str, end: str, number: Parameter) -> float:
    """A number of a joint at one end of the range that its pin and bush give."""
    estimate = getattr(mechanism.joint(number.key.split(".")[1]).data, quantity)
    return number.value * getattr(estimate, end) / estimate.value


def hangs_on(motion: Settled, turns: int, how: Plan) -> dict[str, Any]:
    """Forces of the same motion with other contact data, in the order of `variants`.

    Returns
    -------
    dict
        ``names`` of the joints; over variants ``quantity``, ``change``, ``period`` (0: none seen), ``lost``
        (1: contact is lost) and ``statuses``; over variants and joints ``peak`` (N), and over those with
        clearance ``separations`` in a turn and ``impact_speed`` (m/s); NaN where a motion that settles slowly
        has not settled.
    """
    rows: list[dict[str, Any]] = []
    others, slow = [*variants(motion.mechanism)], motion.radius > SLOW
    for quantity, change, mechanism in others:
        stands(len(rows) / len(others), f"contact data: {quantity} {change}")
        row = {"quantity": quantity, "change": change, "statuses": 0}
        try:
            other = reached(mechanism, motion.end, how, LONGER if slow else SOUGHT[:1])
            row["period"] = other.period
            if other.period or not slow:  # else it still swings
                row |= forces(other, turns, how, PER_TURN, brief=True)
                row["lost"] = other.traits["contact_loss"]
        except Unsettled as error:
            row["statuses"] = error.status
        rows.append(row)
    keys = ("quantity", "change", "statuses", "period", "lost", "peak", "separations", "impact_speed")
    return columns(rows, keys)
