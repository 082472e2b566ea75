"""What makes one turn of a linkage unlike the next, so that no map from turn to turn describes it."""

from __future__ import annotations

from collections.abc import Iterator

from jointplay.errors import Problem
from jointplay.mechanism.records import Mechanism

_HERE = "accepted here, where each turn starts anew from the state at the end of the one before"


def unlike_turns(mechanism: Mechanism) -> Iterator[Problem]:
    """Yield a problem for each part that tells one turn from the next."""
    for i, spring in enumerate(mechanism.springs):
        if spring.twists and mechanism.crank in spring.links:
            text = f"a torsion spring between links other than the turning {mechanism.crank} is {_HERE}"
            yield Problem(f"mechanism.springs[{i}]", spring.name, text)
