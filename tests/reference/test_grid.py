"""Laws at bearings and guides with play, of a four-bar and a slider-crank: tangents through contact."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS
from jointplay.analysis.starts import End, Journals, placed, state_names
from jointplay.solver.mechanism.assemble import assemble
from tests.method.test_tangent import differences, scaled
from tests.support.laws_grid import GUIDED, PAIRS, SCENES, mechanism
from tests.support.tangent_map import agreed

QUICK = [("four_bar", ("kelvin_voigt", "coulomb"), False)]
LAWS = {scene: GUIDED if scene == "guide" else PAIRS for scene in SCENES}
BENT = {"four_bar": (2, 4, 7), "slider_crank": (0, 1, 6), "guide": (1, 10)}  # beside an elastic link
CELLS = [(scene, pair, False) for scene, pairs in LAWS.items() for pair in pairs]
CELLS += [(scene, LAWS[scene][i], True) for scene, places in BENT.items() for i in places]
STARTS, SHARE = 4, 0.04  # of a turn that tangents are followed for: some contacts
LONGER = {("slider_crank", "herbert_mcwhannell"): 0.06, ("slider_crank", "zhiying_qishao"): 0.3}
TOLERANCE = 1e-5
NEAR, FAR = (1e-6, 3e-6, 1e-5, 3e-5), (1e-5, 3e-5, 1e-4, 3e-4)  # sizes of differences; for stiff modes
BOUNDS = {
    **dict.fromkeys(
        ("ramp", "ambrosio", "threlfall"), 1e-4
    ),  # no step ends at a kink, estimates can miss one
    True: 3e-5,  # elastic: they see rounding
}
ENTERED = {"contact", "impact"}
LEFT = {"separation", "impact"}


def marked(cell):
    """A cell of the default tests, or a nightly one."""
    place, laws, elastic = cell
    name = "-".join([place, *laws, "elastic" if elastic else "rigid"])
    return pytest.param(*cell, id=name, marks=[] if cell in QUICK else pytest.mark.nightly)


def starts(model):
    """Scenes that start in flight, the journal about its bearing's centre; links that bend are straight."""
    random, n_q = np.random.default_rng(3), len(model.turning)
    unit = np.where(model.absolute[:n_q] > 1e-3, model.absolute[:n_q], 0.0) / model.reach
    memories = np.zeros(model.memories)
    size = np.concatenate([0.3 * model.clearances[0] * unit, 0.5 * unit, memories])
    for _ in range(STARTS):
        yield replace(model, state=model.state + size * random.uniform(-1, 1, len(size)))


def best(model, duration, exact, tolerance, sizes):
    """The best of the difference quotients, None where they do not agree; names of events."""
    found = [differences(model, duration, size, exact) for size in sizes]
    return agreed(found, off, 0.5 * tolerance), {EVENTS[kind] for _, kind in found[0][1]}


def off(one, other):
    """Largest difference of two maps' columns, over the columns' lengths."""
    size = np.linalg.norm(other, axis=0)
    kept = size > 1e-9 * size.max()
    return float(np.max(np.linalg.norm((one - other)[:, kept], axis=0) / size[kept]))


@pytest.mark.parametrize(("scene", "pair", "elastic"), [marked(cell) for cell in CELLS])
def test_tangents_are_those_of_neighbours(scene, pair, elastic):
    tolerance = max(BOUNDS.get(law, TOLERANCE) for law in (*pair, elastic, (scene, pair[0])))
    model, met, compared = assemble(mechanism(scene, *pair, elastic)), set(), 0
    for start in starts(model):
        duration = LONGER.get((scene, pair[0]), SHARE) * start.period
        exact = scaled(start, duration)
        quotient, events = best(start, duration, exact, tolerance, FAR if elastic else NEAR)
        if quotient is not None:
            assert off(exact, quotient) < tolerance
            compared, met = compared + 1, met | events
    assert compared >= 2
    assert met & ENTERED
    assert met & LEFT


@pytest.mark.nightly
@pytest.mark.parametrize("pair", PAIRS[:1], ids="-".join)
def test_a_sweep_has_an_exponent(pair):
    """Two clearances from one start, for so few turns that tolerances as far apart follow one motion."""
    cells = {"over": {"clearance": [1e-4, 1.1e-4]}, "turns": 1, "transient": 0, "direction": ("reset",)}
    run = partial(jp.bifurcation, mechanism("slider_crank", *pair, False), **cells, lyapunov_turns=1)
    loose, tight = (run(exponents=1, rtol=rtol) for rtol in (1e-8, 1e-10))
    assert (loose["status"] == 0).all()
    assert (tight["status"] == 0).all()
    found = [each["lyapunov_exponent_per_turn"].values for each in (loose, tight)]
    assert found[0].size == 2
    assert found[0] == pytest.approx(found[1], abs=1e-3)


@pytest.mark.long
def test_a_sweep_of_rigid_bearings_goes_up_and_down():
    """A clearance that shrinks leaves the end of the last motion beyond the face, to which it is brought."""
    faces = mechanism("slider_crank", "restitution", "none", False)
    cells = {"over": {"clearance": [1e-4, 1.1e-4]}, "turns": 1, "transient": 0, "lyapunov_turns": 1}
    both = jp.bifurcation(faces, **cells, direction=("up", "down"), exponents=1)
    assert int(both["status"]) == 0
    assert np.isfinite(both["lyapunov_exponent"]).all()
    narrow = faces.replace(clearance={"B": 1e-4})
    end = End(state_names(assemble(narrow)), np.array([0.0, 0.12 + 0.05 + 1.1e-4, 0.0, 0.0]), 0.0)
    model = placed(narrow, end)
    (ratios,) = Journals(model).eccentricity_ratios(model.state[None, :])
    assert ratios == pytest.approx(1.0)
    assert model.state[1] == pytest.approx(0.12 + 0.05 + 1e-4)
