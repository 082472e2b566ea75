"""Every law at every kind of joint, beside rigid and elastic links: mechanisms with contact entered and left.

A cell pairs a normal law with a law of friction, so that each occurs with every kind of joint and link. Laws
that differ in numbers alone share compiled code where they rub alike.
"""

from __future__ import annotations

import jointplay as jp
from jointplay import catalog
from jointplay.solver.equations.laws import LAWS
from tests.support.belt import TRIED, contact
from tests.support.linkages import altered, jointed

NORMAL = {name: contact(name) for name in LAWS}
FRICTION = {"none": None} | TRIED
PAIRS = [
    *[("kelvin_voigt", "coulomb"), ("hertz", "stribeck"), ("hunt_crossley", "tanh"), ("restitution", "none")],
    *[("johnson", "brown_mcphee"), ("dubowsky_freudenstein", "andersson"), ("liu", "lugre")],
    *[("flores", "ramp"), ("hu_guo", "ambrosio"), ("gonthier", "threlfall")],
]
PAIRS += [(law, "none") for law in LAWS if law not in dict(PAIRS)]
ROUND = ("johnson", "dubowsky_freudenstein", "liu")  # of a journal in its bearing: no corner has them
GUIDED = [pair for pair in PAIRS if (pair[0] not in ROUND and pair[1] != "none") or pair[0] == "restitution"]
GUIDED += [("lee_wang", "andersson"), ("zhiying_qishao", "brown_mcphee"), ("lankarani_nikravesh", "lugre")]
GUIDED += [(law, "none") for law in ("herbert_mcwhannell", "hunt_crossley_restitution")]
BEAM = jp.Beam(shapes="sine", modes=1, damping_ratio=0.01)
SCENES = {  # the elastic link, and the mechanism
    "four_bar": ("coupler", lambda: catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)),
    "slider_crank": ("rod", lambda: catalog.slider_crank(clearance=1e-4, gravity=9.81)),
    "guide": ("rod", lambda: catalog.slider_crank(clearance={"G": 1e-4}, gravity=9.81)),
}


def mechanism(scene: str, normal: str, friction: str, elastic: bool) -> jp.Mechanism:
    """A scene under two laws, one of its links rigid or elastic."""
    bent, make = SCENES[scene]
    plain = make()
    links = [
        link.model_copy(update={"elastic": True, "beam": BEAM}) if elastic and link.name == bent else link
        for link in plain.links
    ]
    laws = {"contact": NORMAL[normal], "friction": FRICTION[friction]}
    return jointed(altered(plain, links=tuple(links)), loose=True, **laws)
