"""The generated Jacobian against complex steps of the generated rates, in every variant."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.own.systems import SYSTEMS
from tests.support.plain import Point, plain

from ..equations.both import pair, point
from ..reference.four_bar import scattered
from .samples import STATES, modes_of, oscillator

STEP = 1e-30
LINKAGES = {
    "B": [("free",), ("slip+",), ("slip-",), ("stick",)],
    "C": [("slip-",), ("stick",)],
    "A": [("slip+",), ("stick",)],
    "BC": [
        *[("free", "free"), ("slip+", "free"), ("slip-", "slip+"), ("stick", "free"), ("stick", "slip-")],
        *[("stick", "stick"), ("released", "stick")],
    ],
    "OABC": [("free",) * 4, ("slip+", "slip-", "free", "slip+"), ("stick", "slip+", "stick", "free")],
}


def by_complex_steps(at, width):
    """d rate / d state of `at(shift)`, a point whose state is shifted."""
    columns = []
    for k in range(width):
        shift = np.zeros(width, dtype=complex)
        shift[k] = 1j * STEP
        columns.append(at(shift).rate()[:, 0].imag / STEP)
    return np.array(columns).T


def agree(at, width, tolerance):
    """Compare by columns: those of positions hold the contact stiffness and are far larger."""
    exact, given = by_complex_steps(at, width), at(np.zeros(width)).jacobian().real
    scale = np.abs(exact).max(axis=0) + 1e-300
    assert np.all(np.abs(given - exact) <= tolerance * np.maximum(scale, 1e-12))


def shifted(base, modes):
    """Points about the base of a linkage, as complex numbers."""
    n_x = len(base.s) - 1 - 2 * base.sizes["angles"]
    state = base.s[1 : 1 + n_x]
    return (lambda shift: Point(base.f, base.p, state + shift, modes, complex)), n_x


@pytest.mark.nightly
@pytest.mark.parametrize("drive", ["motor", "speed"])
@pytest.mark.parametrize("joints", LINKAGES)
def test_linkages(joints, drive):
    system, model = pair(joints, drive=drive, C_t=2.5 if joints == "C" else 0.0)
    for seed, modes in enumerate(LINKAGES[joints]):
        base = point(system, model, scattered(system, seed), modes)
        agree(*shifted(base, modes), 1e-11)


BENDING = {  # joints with play, links that bend, drive, order: modes
    ("B", "coupler", "motor", "consistent"): LINKAGES["B"],
    ("B", "coupler rocker", "motor", "paper"): LINKAGES["B"],
    ("AC", "coupler", "motor", "consistent"): [("free", "slip+"), ("stick", "slip-"), ("stick", "stick")],
    ("", "coupler", "motor", "consistent"): [()],
    ("", "coupler rocker", "speed", "consistent"): [()],
    ("", "coupler rocker", "motor", "paper"): [()],
}


@pytest.mark.nightly
@pytest.mark.parametrize(
    "model", BENDING, ids=["_".join(model).replace(" ", "_").strip("_") for model in BENDING]
)
def test_links_that_bend(model):
    system, ours = pair(*model)
    for seed, modes in enumerate(BENDING[model]):
        base = point(system, ours, scattered(system, seed), modes)
        agree(*shifted(base, modes), 1e-10)


@pytest.mark.parametrize("links", ["", "coupler"])
def test_friction_by_tanh(links):
    system, ours = pair("B", links, smooth=3.0, C_t=1.5)
    for seed, modes in enumerate([("free",), ("contact",), ("contact",)]):
        base = point(system, ours, scattered(system, seed), modes)
        agree(*shifted(base, modes), 1e-10)


@pytest.mark.parametrize("name", SYSTEMS)
def test_oscillators(name):
    model = oscillator(name)
    functions = plain(model.structure)
    for state in STATES[len(model.state)]:
        for modes in modes_of(model):

            def at(shift, state=state, modes=modes):
                return Point(functions, model.numbers, np.array(state) + shift, modes, complex, t=0.7)

            agree(at, len(state), 1e-13)


def test_compiled_functions_are_the_text():
    """Numba's arithmetic of the same text: rates, Jacobian, contacts."""
    from jointplay.solver.codegen import cache

    model = assemble(catalog.chunmei2002(gear_ratio=3.0))
    state = model.state + np.random.default_rng(2).normal(size=6) * np.repeat([1e-3, 5.0], 3)
    for mode in ("free", "slip+", "slip-", "stick"):
        both = [
            Point(functions, model.numbers, state, [mode])
            for functions in (plain(model.structure), cache.structure_module(model.structure))
        ]
        for quantity in (Point.rate, Point.watched, Point.values, Point.contacts):
            mine, compiled = (quantity(p) for p in both)
            assert np.abs(mine - compiled).max() <= 1e-11 * np.abs(mine).max()
