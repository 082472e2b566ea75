"""Plans of real structures: nothing of Newton's matrix lies outside them, and little of them is empty."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen import cache
from jointplay.solver.codegen.elimination import LARGEST_DENSE
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from tests.support.plain import Point, plain

from ..equations.both import pair, point
from ..method.linear import factored, newtons_matrix
from ..reference.four_bar import scattered
from .test_jacobian import by_complex_steps, shifted

MODES = {
    ("B", "coupler"): [("free",), ("slip+",), ("stick",)],
    ("B", "coupler rocker"): [("free",), ("slip-",), ("stick",)],
    ("AC", "coupler"): [("free", "free"), ("stick", "slip+"), ("stick", "stick"), ("free", "stick")],
    ("", "coupler rocker"): [()],
}


@pytest.mark.long
@pytest.mark.parametrize(
    "model", MODES, ids=["_".join(model).replace(" ", "_").strip("_") for model in MODES]
)
def test_factors_make_newtons_matrix(model):
    """The product of the factors against M and complex steps of the rates, at random states."""
    system, ours = pair(*model)
    for seed, modes in enumerate(MODES[model]):
        base = point(system, ours, scattered(system, seed), modes)
        M, _ = base.matrices()
        at, width = shifted(base, modes)
        B = M @ by_complex_steps(at, width)
        for h in (1e-6, 1e-4):
            base.f.factor(base.variant, base.w, base.values(), h)
            for k in range(4):
                E = newtons_matrix(M, B, h, k)
                scale = np.minimum(np.abs(E).max(axis=0), np.abs(E).max(axis=1)[:, None])
                error = np.abs(factored(base.f.plans[base.variant], base.w, k) - E)
                assert np.all(error <= 1e-9 * scale)


@pytest.mark.nightly
def test_modes_are_eliminated_without_fill():
    """Of 12 modes and three angles: each mode meets itself and the angles, and no mode meets another."""
    model = assemble(catalog.chunmei2002(elastic=("crank", "coupler", "rocker")))
    free, slip, _ = plain(model.structure).plans
    for plan in (free, slip):
        filled_in = {*plan.filled()} - {*plan.mass, *plan.pull, *plan.rate}
        assert all(i >= 12 and j >= 12 for i, j in filled_in)
        assert not any(i < 12 and j < 12 and i != j for i, j in free.filled())
    assert len(free.filled()) == 49
    assert len(slip.filled()) == 65


@pytest.mark.nightly
@pytest.mark.parametrize("elastic", [(), ("coupler",)])
def test_only_many_unknowns_are_planned(elastic):
    sizes = plain(assemble(catalog.chunmei2002(elastic=elastic)).structure).SIZES
    assert sizes["planned"] == (sizes["speeds"] > LARGEST_DENSE)
    assert sizes["speeds"] == 3 + 4 * len(elastic)


@pytest.mark.long
def test_compiled_functions_are_the_text():
    """Numba's arithmetic of the same text, the algebra on lanes included."""
    model = assemble(catalog.chunmei2002(gear_ratio=3.0, elastic=("coupler",)))
    random, n = np.random.default_rng(2), 7
    state = model.state + random.normal(size=2 * n) * np.repeat([1e-6, 1e-2, 1e-3, 5.0], [4, 3, 4, 3])
    for mode in ("free", "slip+", "stick"):
        found = []
        for functions in (plain(model.structure), cache.structure_module(model.structure)):
            here = Point(functions, model.numbers, state, [mode])
            quantities = [here.rate(), here.watched(), here.values(), here.contacts(), *stepped(here)]
            found.append(quantities)
        for mine, compiled in zip(*found, strict=True):
            assert np.abs(mine - compiled).max() <= 1e-9 * np.abs(mine).max()


def stepped(here, h=1e-4):
    """What the algebra makes: increments after two updates, their sizes, an error estimate, a prediction."""
    f, n_x, variant, J = here.f, 14, here.variant, here.values()
    weight, sizes = np.linspace(1.0, 2.0, n_x), []
    f.factor(variant, here.w, J, h)
    f.rest(here.w)
    f.move(here.w, here.s, h)
    for _ in range(2):
        f.rate(variant, here.w, here.s, here.p, here.m)
        sizes.append(f.newton(variant, here.w, here.s, J, weight, h))
    increments = here.lanes[: 1 + n_x].copy()
    error = np.concatenate([here.s[8:15], here.lanes[1 + n_x : 1 + n_x + 7, 7]])
    sizes.append(f.estimate(variant, here.w, J, weight, error, h))
    f.extrapolate(here.w, increments[1:].ravel().copy(), 1.0, 0.8)
    return increments, np.array(sizes), error, here.lanes[8 : 1 + n_x].copy()
