"""Benchmarks: published digits, reached and told."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jointplay as jp
from jointplay.kinds import KINDS, load
from jointplay.lab.benchmarks import flores2010, ivp_crank
from jointplay.mechanism.assemble import assemble

SPARE = {  # relative: twice what was found, where the published start's nine digits allow no more
    "slider position": 1.3e-9,
    "q1 rate": 3e-10,
    "q2 rate": 4e-9,
    "q3 rate": 2.5e-8,
    "q4 rate": 2e-8,
}


@pytest.mark.long
def test_the_elastic_slider_crank_of_the_ivp_test_set():
    found = jp.benchmark(jp.catalog.ivp_crank())
    assert int(found.status) == 0
    for name, off in zip(found.quantity.values, found.relative_difference.values, strict=True):
        assert off < SPARE.get(name, 2e-10), name
    x3 = found.sel(quantity="slider position")
    exact = 0.15 + 0.3 + 1.69327969e-5
    assert float(x3.difference) == pytest.approx(exact - 0.450016933, abs=1e-12)  # its start's, kept
    table = load(KINDS["benchmark"].table)(found)
    assert len(table.splitlines()) == 17
    assert "-3.31173498825626" in table
    assert str(jp.summary(found)).startswith("all 16 published quantities")


@pytest.mark.long
def test_a_run_that_stops_says_so():
    found = jp.benchmark(jp.catalog.ivp_crank(), max_steps=3)
    assert jp.words(found).status == "step_limit"
    assert np.isnan(found.computed).all()


def test_the_mechanism_is_the_published_one_but_for_pi_and_fifteen():
    """Numbers of the benchmark's equations against the catalog's own: ratios of powers of 15 and of π."""
    model = assemble(jp.catalog.ivp_crank())
    names = ivp_crank.parameter_names(model.structure)
    own, printed = (dict(zip(names, row, strict=True)) for row in (model.numbers, ivp_crank._numbers(model)))
    changed = {name for name in names if printed[name] != pytest.approx(own[name], rel=1e-6, abs=1e-12)}
    assert {name.split("_")[0] for name in changed} == {"along", "lever", "axial", "stretch", "G"}
    for name in changed:
        factor = 1 / 15 if name.startswith("axial") else 15**-0.5
        assert abs(printed[name] / own[name]) == pytest.approx(factor, rel=5e-7)


def pushed(q, v):
    """Mass matrix and forces of the slider-crank of Flores, Leine and Glocker between its faces."""
    crank, rod, m = 0.153, 0.306, (0.038, 0.038, 0.076)
    coupled = (m[1] / 2 + m[2]) * crank * rod
    turning = 7.4e-5 + (m[0] / 4 + m[1] + m[2]) * crank**2, 5.9e-4 + (m[1] / 4 + m[2]) * rod**2
    off = coupled * np.cos(q[0] - q[1])
    whirl = coupled * np.sin(q[0] - q[1]) * np.array([v[1] ** 2, -(v[0] ** 2)])
    weight = 9.81 * np.array([(m[0] / 2 + m[1] + m[2]) * crank, (m[1] / 2 + m[2]) * rod]) * np.cos(q)
    return np.array([[turning[0], off], [off, turning[1]]]), -whirl - weight


@pytest.mark.long
def test_the_slider_crank_of_flores_before_its_first_impact():
    """Against SciPy's DOP853 on equations written out."""
    found = jp.benchmark(jp.catalog.flores2010())
    assert int(found.status) == 0

    def rates(t, y):
        return [*y[2:], *np.linalg.solve(*pushed(y[:2], y[2:]))]

    start, options = [0, 0, 150, -75], {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
    end = solve_ivp(rates, (0, flores2010.END), start, **options).y[:, -1]
    exact = [*end, 1e-3 - 0.153 * np.sin(end[0]) - 0.306 * np.sin(end[1])]
    assert found.computed.values == pytest.approx(exact, rel=1e-9)
    off = found.relative_difference.values
    assert 1e-3 < off[:2].max() < 2e-3
    assert off[4] == pytest.approx(0.162, abs=0.001)  # of the steps, as the next test says


def test_the_stored_motion_of_flores_slider_crank_has_these_equations():
    """Its own steps on equations written out: theta = 1/2, mass at the guessed end, one Newton iteration."""
    q, v, h, d = np.zeros(2), np.array([150.0, -75.0]), 1e-4, 1e-20
    for _ in range(26):
        mass, ahead = pushed(q + h * v, v)
        slopes = [pushed(q + h * v + h / 2 * 1j * d * e, v + 1j * d * e)[1].imag / d for e in np.eye(2)]
        after = v + np.linalg.solve(mass - h / 2 * np.stack(slopes, -1), h / 2 * (pushed(q, v)[1] + ahead))
        q, v = q + h / 2 * (v + after), after
    gap = 1e-3 - 0.153 * np.sin(q[0]) - 0.306 * np.sin(q[1])
    stored = [value for _, value in flores2010.PUBLISHED.values()]
    assert [*q, *v] == pytest.approx(stored[:4], rel=1e-14)
    assert gap == pytest.approx(stored[4], rel=1e-11)


def test_another_mechanism_is_refused():
    for other in (jp.catalog.slider_crank(), jp.catalog.ivp_crank(damping_ratio=0.005)):
        with pytest.raises(jp.InputError, match="unchanged, is accepted"):
            jp.benchmark(other)
