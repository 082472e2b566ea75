"""The joints of a mechanism, for a page that draws its links: what their origins follow from."""

from __future__ import annotations

from typing import Any

from jointplay.mechanism.joints import Joint, Pin
from jointplay.mechanism.records import Mechanism


def joints(mechanism: Mechanism) -> list[dict[str, Any]]:
    """Give the joints as `mechanism.positions` takes them, without their numbers that vary."""
    return [_joint(joint) for joint in mechanism.joints]


def _joint(joint: Joint) -> dict[str, Any]:
    label = (*joint.contacts, joint.name)[0]
    sides = {"journal": _pin(joint.journal), "bearing": _pin(joint.bearing)}
    return {"name": joint.name, "prismatic": joint.prismatic, "ideal": joint.ideal, "label": label} | sides


def _pin(pin: Pin) -> dict[str, Any]:
    return {
        "link": pin.link,
        "at": pin.at,
        "point": list(pin.point or (0.0, 0.0)),
        "direction": pin.direction,
    }
