"""The four-bar with three clearances of the Siconos examples over a second, and its stored motion.

Source: Siconos (INRIA), example `FourBarLinkageWith3clearance`: its plug-in for the controller, and
`FourBarClearance.ref` for the motion at instants 0.05 s apart: steps of 0.1 ms by Moreau and Jean's scheme
with theta = 1/2, penetration taken out after each step to 1e-6 m, impulses to 1e-6. Normal forces are its
impulses over a step. The first impact is at 11.4 ms, and after 30 ms all journals stay in contact but for
short flights, so that the motion can be compared to its end. It forgets its start, and its steps' error
does not grow: 2e-5 to 3e-5 rad, up to 5e-3 rad/s and some per cent of the small forces. The test of this kind
has steps of its own, of first order, which come nearer to what is computed here the shorter they are.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.keywords import Progress
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import Mechanism
from jointplay.solver.motion.trajectory import Request, follow
from jointplay_lab.benchmarks.answer import Answer

CENTRES = {
    "coupler": (1.876454585097650, 1.691962091335582),
    "rocker": (3.3764686197082958, 1.191962183453451),
}
ANGLES = {"crank": 1.570823772407980, "coupler": 0.3532842020624460, "rocker": 1.264872058968431}
PUBLISHED = {  # s: angles and speeds of crank, coupler and rocker
    0.05: (
        *(1.667922944579698, 0.3597912275586086, 1.305372286653169),
        *(4.395066090603877, 0.4832218296513042, 2.062151119085608),
    ),
    0.5: (
        *(5.545612454983465, 0.9158032070489857, 1.499656942955073),
        *(5.285050554283548, -2.184217792069421, -4.031963234133453),
    ),
    1.0: (
        *(4.238448368268986, 0.9189903084598952, 1.995555124902495),
        *(-9.985224822212604, -2.242266672403026, 0.8282237032208665),
    ),
}
FORCES = {"A": 130.3966647745497, "B": 39.31877876487853, "C": 26.28905038007516}  # N, at the end
TORQUE = 6.433404424687604  # N m, at the end


def answer(mechanism: Mechanism, rtol: float, max_steps: int, progress: Progress = None) -> Answer:
    """Follow the motion from the stored start and give it with the stored states."""
    model, at = assemble(mechanism), np.array(list(PUBLISHED))
    turned = {name: np.array([math.cos(angle), math.sin(angle)]) for name, angle in ANGLES.items()}
    ends = [CENTRES[name] - mechanism.link(name).length / 2 * turned[name] for name in CENTRES]
    places = np.concatenate([[ANGLES[name] for name in model.links], *ends])  # bases in the order of links
    model = dataclasses.replace(model, state=np.append(places, np.zeros(len(places))))
    records = follow(model, Request(at[-1], rtol, at=at, max_steps=max_steps), progress)
    computed, reached = np.full((len(at), 10), math.nan), len(records.samples)
    if reached:
        words = ("angle", "angular_velocity", "normal_force")
        found = Quantities(model, records.samples, records.start).variables((*words, "drive_torque"), "time")
        columns = [found[word][1] for word in words] + [found["drive_torque"][1][:, None]]
        computed[:reached] = np.hstack(columns)
    words = {"angle": "rad", "speed": "rad s-1"}
    names = [(f"{link} {word}", unit) for word, unit in words.items() for link in ANGLES]
    stored = {
        f"{name} at {t:g} s": (unit, each)
        for t, row in PUBLISHED.items()
        for (name, unit), each in zip(names, row, strict=True)
    }
    last = {f"normal force {joint}": ("N", force) for joint, force in FORCES.items()}
    last |= {"drive torque": ("N m", TORQUE)}
    stored |= {f"{name} at {at[-1]:g} s": each for name, each in last.items()}
    return Answer(stored, [*computed[:, :6].ravel(), *computed[-1, 6:]], records)
