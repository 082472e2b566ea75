"""Equations and algebra for eight trajectories at once, as plain Python: those of one trajectory, by lane."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay import catalog
from jointplay.solver.codegen.lanes import algebra, equations, exclusion
from jointplay.solver.equations.write import system
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.lanes import layout as rows
from jointplay.solver.method.lanes.radau import EIGEN, GAMMA
from tests.support.laws_grid import mechanism
from tests.support.plain import Point, masks, plain, run

TWO = {"B": 4e-5, "C": 3e-5}
TORQUE = {"kind": "torque", "link": "crank", "constant": 1.0, "nominal_speed": 200.0}
SCENES = {
    "one joint": (
        lambda: catalog.chunmei2002(clearance=4e-5, friction=0.3),
        ["free", "slip+", "slip-", "stick"],
    ),
    "a memory": (lambda: mechanism("four_bar", "flores", "ramp", False), ["free", "contact"]),
    "a slider": (
        lambda: catalog.slider_crank(clearance=1e-4, gravity=9.81).replace(drive=TORQUE),
        ["free", "slip+", "stick"],
    ),
    "a memory that sticks": (
        lambda: mechanism("four_bar", "flores", "coulomb", False),
        ["free", "slip+", "stick"],
    ),
    "two joints": (
        lambda: catalog.chunmei2002(clearance=TWO, friction=0.3),
        ["free free", "slip+ free", "slip- slip+", "stick slip-", "free stick", "stick stick"],
    ),
    "a loop": (lambda: catalog.watt(clearance={"F": 1e-4}), ["free", "slip+", "slip-", "stick"]),
    "a beam": (lambda: mechanism("four_bar", "kelvin_voigt", "coulomb", True), ["free", "slip-", "stick"]),
    "a guide": (
        lambda: catalog.slider_crank(clearance={"G": 1e-4}, gravity=9.81),
        [
            *("free free free free", "slip+ slip- free free", "stick stick free free"),
            *("stick free free slip+", "free free stick stick", "stick free free stick"),
        ],
    ),
}


def blocks(w, first, count):
    """A view of rows, by number and lane."""
    return w.reshape(-1, 8)[first : first + count]


QUICK = ("one joint", "a memory", "a memory that sticks", "two joints", "a loop")


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[] if each in QUICK else pytest.mark.nightly) for each in SCENES]
)
def test_rates_guards_and_slopes_are_those_of_one_trajectory(name):
    make, words = SCENES[name]
    model, random = assemble(make()), np.random.default_rng(4)
    assert not exclusion(model.structure)
    functions = run(equations.text(system(model.structure)))
    n, count, p = len(model.turning), len(model.joints), model.numbers
    turned, loops = len(functions.PHASES), len(model.structure.loops)
    w = np.zeros(8 * functions.ROWS)
    points = []
    for lane, word in enumerate(np.resize(words, 8)):
        state = model.state + random.uniform(-1e-4, 1e-4, len(model.state))
        points.append(Point(plain(model.structure), p, state, str(word).split()))
        blocks(w, rows.POSITION + turned, n)[:, lane] = state[:n]
        blocks(w, rows.SPEED, turned + n)[:, lane] = [*[model.crank_speed] * turned, *state[n : 2 * n]]
        blocks(w, rows.MEMORY, model.memories)[:, lane] = state[2 * n :]
        angles, turning = np.split(points[-1].s[1 + len(state) :], 2), np.flatnonzero(model.turning)
        turning = [*range(turned), *(turned + turning)]
        for row, values in zip((rows.SINE, rows.COSINE), angles, strict=True):
            blocks(w, row, turned + n)[turning, lane] = values
        blocks(w, rows.MASK, 3 * count)[:, lane] = masks(str(word).split())
        blocks(w, rows.NUMBERS, len(p))[:, lane] = p
    blocks(w, rows.NEW, 1)[:] = 1.0
    functions.prepare(w)
    functions.base(w)
    functions.jacobian(w)
    found = blocks(w, rows.JACOBIAN, 2 * rows.N * rows.N).reshape(rows.N, 2, rows.N, 8)
    found = found[turned : turned + n, :, turned : turned + n]
    for lane, own in enumerate(points):
        rate, (folds, guards) = own.rate()[:n, 0], np.split(own.watched()[: loops + 4 * count, 0], [loops])
        rounding = 1e-9 * max(10.0, np.abs(rate).max())
        assert np.allclose(blocks(w, rows.ACCELERATION + turned, n)[:, lane], rate, rtol=1e-8, atol=rounding)
        assert np.allclose(blocks(w, rows.GUARD + rows.FOLD, loops)[:, lane], folds, rtol=1e-12)
        sticks = own.m[2::3] > 0
        seen = np.repeat(own.m[::3] > 0, 4) & np.tile([True, True, True, False], count) | np.repeat(sticks, 4)
        ours = blocks(w, rows.GUARD, 4 * count)[:, lane]
        asked = seen & (guards != 0)  # what one trajectory watches in this variant
        assert np.allclose(ours[asked], guards[asked], rtol=1e-6, atol=1e-12)
        assert np.allclose(ours[::4], guards[::4], rtol=1e-9)
        slopes = own.jacobian()[:n, : 2 * n].reshape(n, 2, n)
        assert np.allclose(found[..., lane], slopes, rtol=1e-7, atol=1e-7 * np.abs(slopes).max())


@pytest.mark.parametrize("n", [1, 2, 3, 5, 7])
def test_inverses_are_those_of_the_matrices(n):
    functions, random = run(algebra.text((True,) * n, 1)), np.random.default_rng(n)
    w, h = np.zeros(8 * rows.NUMBERS), 0.3
    J = blocks(w, rows.JACOBIAN, 2 * rows.N * rows.N).reshape(rows.N, 2, rows.N, 8)
    J[:n, :, :n] = random.normal(size=(n, 2, n, 8))
    blocks(w, rows.H, 1)[:] = h
    functions.factor(w)
    real = blocks(w, rows.INVERSE, rows.N**2).reshape(rows.N, rows.N, 8)[:n, :n]
    pairs = blocks(w, rows.PAIRS, 4 * rows.N**2).reshape(2, rows.N, rows.N, 2, 8)[:, :n, :n]
    inverses = [
        (GAMMA, real),
        *((complex(*EIGEN[1 + k]), each[..., 0, :] + 1j * each[..., 1, :]) for k, each in enumerate(pairs)),
    ]
    for value, found in inverses:
        for lane in range(8):
            q, v = J[:n, 0, :n, lane], J[:n, 1, :n, lane]
            matrix = value * np.eye(n) - h * v - h * h / value * q
            assert np.allclose(found[..., lane] @ matrix, np.eye(n), atol=1e-9)
