"""Quantities that can be asked of each sample: names, words, units."""

from __future__ import annotations

from jointplay.analysis.gradients import selection
from jointplay.solver.mechanism.records import Joint, Mechanism, TestSystem

OF_JOINT = {
    "force": ("largest joint force", "N"),
    "impact_speed": ("largest normal speed with which contact begins", "m s-1"),
    "pressure": ("largest force over the bearing's projected area", "Pa"),
    "sliding_work": ("normal force times sliding distance per turn", "J"),
    "impact_loss": ("energy lost by normal contact per turn", "J"),
    "friction_loss": ("energy lost by friction per turn", "J"),
}
COUNTED = {"separations": "contacts lost per turn", "impacts": "contacts begun per turn"}
PLAIN = {"period": ("period in turns, 0 for none", "1"), "turn_period": ("mean period of a turn", "s")}


def known_quantities(mechanism: Mechanism | TestSystem) -> list[str]:
    """Names of all quantities that can be asked for: those of `gradient`, and of contacts."""
    inside = [
        name for name in selection.known_quantities(mechanism) if name.partition(":")[0] in selection.POINTS
    ]
    if isinstance(mechanism, TestSystem):
        return [*PLAIN, *COUNTED, *inside]
    joints, free = mechanism.contacts, [joint.name for joint in mechanism.joints if joint.ideal]
    own = [f"{word}:{name}" for word in (*COUNTED, *OF_JOINT) for name in joints]
    return [*PLAIN, *own, *(f"force:{name}" for name in free), *inside]


def joint_of(mechanism: Mechanism, name: str) -> Joint:
    """The joint whose contact a quantity is of."""
    return next(each for each in mechanism.joints if name.partition(":")[2] in each.contacts)


def words_of(name: str) -> tuple[str, str]:
    """What a quantity is, and its units."""
    head, _, label = name.partition(":")
    if head in selection.POINTS:
        found = selection.quantity(name)
        return found.noun, found.units
    text, units = (PLAIN | OF_JOINT | {key: (each, "1") for key, each in COUNTED.items()})[head]
    return f"{text}, {label}" if label else text, units
