"""A system's outputs stand beside its states in what is recorded, and in nothing else of any analysis."""

import numpy as np
import pytest

import jointplay as jp

KEYS = {
    "name": "oscillator",
    "states": {"x": 0.0, "v": 0.1},
    "parameters": {"k": 0.35},
    "rates": {"x": "v", "v": "1.5*sin(2*t) - x - 0.3*v - k - 0.2*x**3"},
    "forcing": "pi",
}
ANALYSES = {
    "bifurcation": lambda system: jp.bifurcation(system, over={"k": [0.1, 0.2]}, turns=6, transient=3),
    "periodic_orbit": lambda system: jp.periodic_orbit(system, record=["state_value"]),
    "continuation": lambda system: jp.continuation(system, parameter="k", range=(0.3, 0.4), max_points=6),
}


@pytest.mark.parametrize("name", ANALYSES)
def test_numbers_are_those_of_the_system_without_outputs(name):
    alone, beside = (
        ANALYSES[name](jp.System(**KEYS, **more)) for more in ({}, {"outputs": {"energy": "x**2 + v**2"}})
    )
    x, v, energy = np.moveaxis(beside["state_value"].values, -1, 0)
    assert energy == pytest.approx(x**2 + v**2, nan_ok=True)
    recorded = ("wall_time", "state_value", "state_value_tangent")
    known = alone.drop_vars(recorded, errors="ignore")
    for each in known.data_vars:
        if known[each].dtype.kind == "f":
            assert beside[each].values == pytest.approx(known[each].values, rel=1e-9, nan_ok=True), each
    jp.figure(beside)


def test_an_orbit_is_a_start_though_there_are_outputs():
    system = jp.System(**KEYS, outputs={"energy": "x**2 + v**2"})
    orbit = jp.periodic_orbit(system)
    end = jp.simulate(system, initial=orbit, turns=1, rtol=1e-11)["end_state"].values
    assert end == pytest.approx(orbit["orbit_state"].values, abs=1e-8)
