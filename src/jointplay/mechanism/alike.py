"""What makes one turn of a linkage unlike the next, so that no map from turn to turn describes it."""

from __future__ import annotations

import math
from collections.abc import Iterator

from jointplay.errors import Problem
from jointplay.mechanism.kinematic_chains import Forest
from jointplay.mechanism.records import Mechanism

_HERE = "accepted here, where each turn starts anew from the state at the end of the one before"


def unlike_turns(mechanism: Mechanism) -> Iterator[Problem]:
    """Yield a problem for each part that tells one turn from the next."""
    drive = mechanism.drive
    if drive and drive.transient:
        text = "a drive that does the same in each turn is"
        yield Problem("mechanism.drive.kind", drive.kind, f"{text} {_HERE}")
    # without clearance in a loop the crank's angle is a state, and another section would begin at time 0 too
    held = not mechanism.clearance_joints and Forest.of(mechanism).cuts
    speed = drive.imposed_speed if drive and not held else None
    for i, load in enumerate(mechanism.loads):
        ratio = load.frequency / abs(speed) if load.timed and speed else 0.5
        if load.timed and not math.isclose(ratio, round(ratio), rel_tol=1e-9):
            text = "a load over the crank's angle, or over time where a joint has clearance and the frequency"
            multiple = "is a whole multiple of a constant speed of the crank, is"
            yield Problem(f"mechanism.loads[{i}].frequency", load.frequency, f"{text} {multiple} {_HERE}")
    for i, spring in enumerate(mechanism.springs):
        if spring.twists and mechanism.crank in spring.links:
            text = f"a torsion spring between links other than the turning {mechanism.crank} is {_HERE}"
            yield Problem(f"mechanism.springs[{i}]", spring.name, text)
