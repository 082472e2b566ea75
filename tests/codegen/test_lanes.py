"""Eight lanes are eight points: rates and guards, at increments as far as the polynomials reach."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen.lanes import exclusion
from jointplay.solver.codegen.source import MAX_TURN
from jointplay.solver.mechanism.own.systems import SYSTEMS
from jointplay.solver.method.control import TURN
from tests.support.plain import Point, plain

from ..equations.both import pair, point
from ..reference.four_bar import scattered
from .samples import STATES, modes_of, oscillator


def agree(base, modes, increments):
    """Compare lane i with a point of its own."""
    rate, rest = base.rate(increments), base.watched()
    n_x = len(increments) - 1
    for i in range(8):
        t, *shift = increments[:, i]
        own = Point(base.f, base.p, base.s[1 : 1 + n_x] + shift, modes, t=base.s[0] + t)
        for lanes, single in ((rate, own.rate()), (rest, own.watched())):
            scale = np.abs(single[:, 0]) + 1e-3 * np.nanmax(np.abs(single), initial=0.0)
            close = np.abs(lanes[:, i] - single[:, 0]) <= 1e-11 * scale
            assert np.all(close | np.isnan(lanes[:, i]) & np.isnan(single[:, 0]))  # a root of what is below 0


@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize(
    ("joints", "modes"),
    [("B", ("free",)), ("B", ("slip-",)), ("B", ("stick",)), ("BC", ("stick", "slip+")), ("A", ("slip+",))],
)
def test_linkages(joints, modes, drive):
    system, model = pair(joints, drive=drive)
    base = point(system, model, scattered(system, 3), modes)
    n_q, n = base.sizes["positions"], base.sizes["speeds"]
    sizes = np.concatenate([[0.7 / system.p.w0], np.full(n_q, 0.7), np.full(n, 20.0)])
    signs = np.random.default_rng(1).uniform(-1, 1, (1 + n_q + n, 8))
    signs[:, 0], signs[:, 1] = 1.0, -1.0  # the farthest corners
    agree(base, modes, sizes[:, None] * signs)


@pytest.mark.parametrize(("joints", "modes"), [("B", ("free",)), ("B", ("stick",)), ("", ())])
def test_links_that_bend(joints, modes):
    """As far as a step of a closed loop may go, in which the coupler's and rocker's angles follow."""
    system, model = pair(joints, "coupler", C_t=1.5)
    base = point(system, model, scattered(system, 3), modes)
    n, bent = base.sizes["speeds"], system.half - system.rigid
    sizes = np.repeat([0.7 / system.p.w0, 1e-3, 0.7, 5.0, 20.0], [1, bent, n - bent, bent, n - bent])
    agree(base, modes, sizes[:, None] * np.random.default_rng(1).uniform(-1, 1, (1 + 2 * n, 8)))


@pytest.mark.parametrize("name", [name for name in SYSTEMS if not exclusion(oscillator(name).structure)])
def test_oscillators(name):
    model = oscillator(name)
    for state in STATES[len(model.state)]:
        for modes in modes_of(model):
            base = Point(plain(model.structure), model.numbers, state, modes, t=0.4)
            increments = np.random.default_rng(2).uniform(-0.4, 0.4, (1 + len(state), 8))
            agree(base, modes, increments)


def test_the_step_stays_where_the_polynomials_hold():
    assert TURN <= MAX_TURN
    functions = plain(oscillator("duffing").structure)
    base = Point(functions, oscillator("duffing").numbers, (0.0, 0.0), ())
    increments = np.zeros((3, 8))
    increments[0] = np.linspace(-TURN, TURN, 8)
    force = base.rate(increments)[0]
    assert np.abs(force - 0.3 * np.cos(increments[0])).max() < 1e-16
