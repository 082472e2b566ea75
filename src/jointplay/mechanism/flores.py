"""A published slider-crank whose slider has clearance in its guide.

Source: Flores, Leine and Glocker, Multibody Syst. Dyn. 23 (2010): lengths, masses, inertias, clearance,
restitution 0.4. Theirs has a friction of 0.01 at the corners too; rigid impacts have none here.
"""

from __future__ import annotations

from typing import Annotated, Any

from jointplay.mechanism.base import NonNegative, unit
from jointplay.mechanism.beam import Link
from jointplay.mechanism.joints import Contact, Joint
from jointplay.mechanism.preset_parts import Gravity, Play, fixed, on
from jointplay.mechanism.records import Mechanism
from jointplay.mechanism.signature import checked

_Restitution = Annotated[NonNegative, unit("restitution", "1")]


@checked()
def flores2010(
    clearance: Play = {"G": 1e-3},  # noqa: B006  read only
    restitution: _Restitution = 0.4,
    gravity: Gravity = 9.81,
    **changes: Any,
) -> Mechanism:
    """Give the slider-crank of Flores, Leine and Glocker (2010), with clearance in the slider's guide G.

    Crank O–A, rod A–B, slider at B; nobody drives. Theirs starts at crank angle 0 with 150 rad/s:
    ``initial={"crank_speed": 150.0}``, at which the rod turns with −75 rad/s and the slider not at all.

    Corners of the slider meet rigid faces with Newton's restitution, two at one instant by Newton's law for
    both at once: so the first impact, of both upper corners, at 0.00269250275202121 s. Compliant laws part
    from it there, however stiff. Friction, 0.01 in the source, is left out: rigid impacts have none here.

    Parameters
    ----------
    clearance : float or dict of str to float
        Of G on either side, m; 0 or unnamed: ideal.
    restitution : float
        Of the corners, 0 to 1.
    gravity : float
        Along −y, m/s².
    **changes
        As in `Mechanism.replace`.
    """
    rows = (
        ("crank", 0.153, 0.038, 0.0765, 7.4e-5),
        ("rod", 0.306, 0.038, 0.153, 5.9e-4),
        ("slider", 0.1, 0.076, 0.0, 2.7e-6),
    )
    links = tuple(Link(name=k, length=l, mass=m, centre=s, inertia_centre=I) for k, l, m, s, I in rows)
    law = Contact(law="restitution", parameters={"restitution": restitution})
    block = {"kind": "prismatic", "half_length": 0.05, "half_height": 0.025, "contact": law}
    joints = (
        Joint(name="O", journal=on("crank"), bearing=fixed(0.0, 0.0)),
        Joint(name="A", journal=on("crank", 0.153), bearing=on("rod")),
        Joint(name="B", journal=on("rod", 0.306), bearing=on("slider")),
        Joint(name="G", journal=on("slider"), bearing=fixed(0.0, 0.0), **block),
    )
    made = Mechanism(name="flores2010", links=links, joints=joints, gravity=gravity, guess={"rod": 0.0})
    return made.replace(clearance=clearance, **changes)
