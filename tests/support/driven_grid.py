"""Derivatives of linkages in all of their parameters at once: along one direction through all of them.

A direction's derivative is the weighted sum of the tangents; its difference quotient takes five runs, however
many parameters there are. As a program: `python -m tests.support.driven_grid NAME …` prints the errors.
"""

from __future__ import annotations

import sys
from functools import partial

import numpy as np

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.gradients.directions import along, stacked
from jointplay.analysis.gradients.wanted import usual_parameters, value_of
from jointplay.analysis.starts import placed
from jointplay.analysis.tangents import Bundle
from jointplay.analysis.trajectory import Request
from jointplay.analysis.vary import changed
from jointplay.mechanism.assemble import assemble
from jointplay.numerics.codes import Event
from tests.analysis.test_rigid_bearing import rigid
from tests.support.driven import distance, end, quotient
from tests.support.laws_grid import PAIRS, mechanism

SHARES = (1e-7, 1e-6, 1e-5, 1e-4)  # of each parameter
MORE = ("joints.B.radius", "links.coupler.inertia", "links.rod.mass", "links.rocker.inertia", "gravity")
PLAY = {"clearance": 2.9e-4, "gear_ratio": 3.0}
OWN = {  # mechanism, turns
    "sticking": (partial(catalog.chunmei2002, friction=0.3, **PLAY), 0.4),
    "no_tension": (partial(catalog.chunmei2002, tension=False, **PLAY), 0.4),
    "two_joints": (partial(catalog.chunmei2002, clearance={"B": 1e-4, "C": 2e-4}, gear_ratio=3.0), 0.3),
    "three_joints": (partial(catalog.chunmei2002, clearance=dict.fromkeys("ABC", 1e-4), gear_ratio=3.0), 0.2),
    "constant_speed": (partial(catalog.chunmei2002, clearance=2.9e-4, speed=80.0), 0.5),
    "elastic": (partial(catalog.chunmei2002, elastic=("coupler",), **PLAY), 0.15),
    "stretching_rod": (partial(catalog.slider_crank, clearance=1e-4), 0.3),
    "rigid_bearing": (partial(rigid, 0.8), 0.3),
    "ideal": (partial(catalog.chunmei2002, clearance=0), 0.5),
    "watt": (catalog.watt, 0.3),
}
LAWS = {
    f"{normal}_{friction}": (partial(mechanism, "four_bar", normal, friction, False), 0.3)
    for normal, friction in PAIRS
}
SCENES = OWN | LAWS


def error(name: str) -> tuple[float, int, set[str]]:
    """Error of a scene, its parameters, and the kinds of event that it has; NaN where events differ."""
    make, turns = SCENES[name]
    return along_all(make(), turns)


def along_all(system: jp.Mechanism, turns: float, seed: int = 1) -> tuple[float, int, set[str]]:
    """Error along a random direction through the parameters, of the best of several differences."""
    keys = [*usual_parameters(system), *(key for key in MORE if _has(system, key))]
    values = np.array([value_of(system, key) for key in keys])
    weights = values * np.random.default_rng(seed).uniform(0.5, 1.5, len(keys))
    model = assemble(system)
    duration = turns * model.period
    parts = [
        along(lambda v, key=key: placed(changed(system, {key: v}), None), value, key)
        for key, value in zip(keys, values, strict=True)
    ]
    none = np.zeros((0, len(model.state)))
    bundle = Bundle(model, Request(duration, 1e-12), none, directions=stacked(parts))
    assert bundle.advance() == 0
    exact, found, kinds = weights @ bundle.vectors, [], []

    def state(at):
        changes = dict(zip(keys, (values + at * weights).tolist(), strict=True))
        reached, events = end(assemble(changed(system, changes)), duration)
        kinds.append([tuple(each) for each in events])
        return reached

    for share in SHARES:
        kinds.clear()
        estimate = quotient(state, 0.0, share)
        if all(sorted(each) == sorted(kinds[0]) for each in kinds):
            found.append(distance(exact, estimate, model))
    words = {Event(int(kind)).name.lower() for _, kind in kinds[0]}
    return min(found, default=float("nan")), len(keys), words


def _has(system, key):
    try:
        return value_of(system, key) != 0
    except (AttributeError, KeyError, TypeError):
        return False


if __name__ == "__main__":
    for name in sys.argv[1:] or SCENES:
        try:
            print(name, *error(name), flush=True)
        except Exception as problem:
            print(name, "FAILED", repr(problem)[:300], flush=True)
