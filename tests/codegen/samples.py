"""Oscillators of the catalog with some numbers, states and modes."""

from __future__ import annotations

import itertools

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble

ARGUMENTS = {  # all different, or a wrong order would not show
    "rossler": {"a": 0.2, "b": 0.3, "c": 5.7},
    "impact_pair": {"gap": 3.6, "restitution": 0.8},
    "soft_impact_pair": {"gap": 3.6, "stiffness": 50.0, "damping": 2.0},
    "bouncing_ball": {"acceleration": 1.2, "restitution": 0.5},
    "gear_backlash": {"mean_load": 0.1, "amplitude": 0.2, "frequency": 1.6, "damping": 0.05},
}
STATES = {2: [(0.3, -0.7), (2.1, 1.4)], 3: [(1.2, -0.4, 7.0), (-3.0, 5.0, 0.2)]}


def oscillator(name, **changes):
    """The model of a test system."""
    return assemble(catalog.NAMES[name](**ARGUMENTS.get(name, {}) | changes))


def modes_of(model):
    """Every combination of modes of an oscillator's contacts."""
    return list(itertools.product(("free", "contact"), repeat=len(model.joints)))
