"""Oscillators of the catalog with some numbers, states and modes."""

from __future__ import annotations

import itertools

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble

ARGUMENTS = {name: make.trial for name, make in catalog.NAMES.items()}
ARGUMENTS["rossler"] = {"a": 0.2, "b": 0.3, "c": 5.7}  # all different, or a wrong order would not show
STATES = {2: [(0.3, -0.7), (2.1, 1.4)], 3: [(1.2, -0.4, 7.0), (-3.0, 5.0, 0.2)]}
STATES[8] = [(0.3, -0.7, 1, 0, 0, 0, 0, 0), (2.1, 1.4, 0, 0, 1, 0, 0, 0)]  # two, and one of six modes


def oscillator(name, **changes):
    """The model of a test system."""
    return assemble(catalog.NAMES[name](**ARGUMENTS.get(name, {}) | changes))


def modes_of(model):
    """Every combination of modes of an oscillator's contacts."""
    return list(itertools.product(("free", "contact"), repeat=len(model.joints)))
