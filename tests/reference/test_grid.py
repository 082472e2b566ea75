"""Laws at revolute joints with play, of a four-bar and a slider-crank: tangents through contact."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from jointplay.analysis.quantities import EVENTS
from jointplay.mechanism.assemble import assemble
from tests.numerics.test_tangent import differences, scaled
from tests.support.laws_grid import PAIRS, mechanism

QUICK = [("four_bar", ("kelvin_voigt", "coulomb"), False)]
HELD = {"four_bar": (0, 1, 2, 3, 6), "slider_crank": (0, 1, 2, 4, 5, 6, 10, 12, 13)}  # pairs of laws
CELLS = [(scene, PAIRS[i], False) for scene, places in HELD.items() for i in places]
STARTS, SHARE = 4, 0.04  # of a turn that tangents are followed for: some contacts
TOLERANCE = 1e-5  # slopes of a force that begins as a root cost tangents up to 1e-6 a contact,
LOGARITHMIC = {"johnson": 1e-3, "dubowsky_freudenstein": 1e-3}  # those that begin as a logarithm more
ENTERED = {"contact", "impact"}
LEFT = {"separation", "impact"}


def marked(cell):
    """A cell of the default tests, or a long one."""
    name = "-".join([cell[0], *cell[1], "elastic" if cell[2] else "rigid"])
    return pytest.param(*cell, id=name, marks=[] if cell in QUICK else pytest.mark.long)


def starts(model):
    """Scenes that start in flight, the journal about its bearing's centre; links that bend are straight."""
    random, n_q = np.random.default_rng(3), len(model.turning)
    unit = np.where(model.absolute[:n_q] > 1e-3, model.absolute[:n_q], 0.0) / model.reach
    memories = np.zeros(model.memories)
    size = np.concatenate([0.3 * model.clearances[0] * unit, 0.5 * unit, memories])
    for _ in range(STARTS):
        yield replace(model, state=model.state + size * random.uniform(-1, 1, len(size)))


def best(model, duration, exact, tolerance):
    """The best of the difference quotients, None where they do not agree; names of events."""
    found = [differences(model, duration, size, exact) for size in (1e-6, 3e-6, 1e-5, 3e-5)]
    pairs = [(off(a, b), b) for (a, _, one), (b, _, other) in pairwise(found) if one and other]
    spread, quotient = min(pairs, key=lambda pair: pair[0], default=(math.inf, None))
    return quotient if spread < 0.5 * tolerance else None, {EVENTS[kind] for _, kind in found[0][1]}


def off(one, other):
    """Largest difference of two maps' columns, over the columns' lengths."""
    size = np.linalg.norm(other, axis=0)
    kept = size > 1e-9 * size.max()
    return float(np.max(np.linalg.norm((one - other)[:, kept], axis=0) / size[kept]))


@pytest.mark.parametrize(("scene", "pair", "elastic"), map(marked, CELLS))
def test_tangents_are_those_of_neighbours(scene, pair, elastic):
    tolerance = LOGARITHMIC.get(pair[0], TOLERANCE)
    model, met, compared = assemble(mechanism(scene, *pair, elastic)), set(), 0
    for start in starts(model):
        exact = scaled(start, SHARE * start.period)
        quotient, events = best(start, SHARE * start.period, exact, tolerance)
        if quotient is not None:
            assert off(exact, quotient) < tolerance
            compared, met = compared + 1, met | events
    assert compared >= 2
    assert met & ENTERED
    assert met & LEFT
