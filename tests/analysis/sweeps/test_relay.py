"""A switch with two thresholds is a state: what goes on from a state knows which way it stands."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.display.errors import InputError

RELAY = {
    "states": {"y": "-2", "z": "0"},
    "parameters": {"p": 0.0},
    "rates": {"y": "p - y + 0.01*cos(t)", "z": "s - z"},
    "forcing": "2*pi",
}
SWITCH = {"switches": [{"name": "s", "on": "y - 1", "off": "-1 - y"}]}
LEVELS = [float(each) for each in np.linspace(-1.9, 1.9, 20)]  # none at a threshold
DECAY = np.exp(-2 * np.pi)  # of both states, in a period


def relay(**changed):
    return jp.System(name="relay", **RELAY | SWITCH | changed)


@pytest.mark.parametrize(("direction", "change"), [("up", 1.0), ("down", -1.0)])
@pytest.mark.parametrize("ensemble", [False, True])
def test_it_has_hysteresis_over_a_parameter(direction, change, ensemble):
    asked = {"over": {"p": LEVELS}, "turns": 4, "transient": 20, "n_jobs": 1, "ensemble": ensemble}
    found = jp.bifurcation(relay(), direction=direction, **asked)["state_value"]
    last = found.sel(state="z").isel(point=-1).values.ravel()
    np.testing.assert_allclose(last, np.array(LEVELS) > change, atol=1e-8)


def test_it_begins_as_its_thresholds_say_or_as_it_is_given():
    def start(y, **more):
        return relay(states={"y": y, "z": 0.0} | more).initial

    assert relay().order == ((), ("y", "z", "s"))
    assert [start(y)[2] for y in (-2.0, 0.0, 2.0)] == [0, 1, 1]
    assert start(0.0, s=0)[2] == 0
    assert relay().replace(initial=(0.5, 0.0, 0.0)).initial == (0.5, 0.0, 0.0)
    found = jp.simulate(
        relay(), initial=(2.0, 0.0, 0.0), turns=1, at=[0.0]
    )  # beyond a threshold it stands so
    assert found["state_value"].sel(state="s").values[0] == 1
    with pytest.raises(InputError, match="a state's"):
        relay(rates=RELAY["rates"] | {"s": "0"}, states={"y": 0, "z": 0, "s": 0})


def test_what_starts_where_a_motion_ends_goes_on():
    own = relay(rates=RELAY["rates"] | {"y": "1.2 - y - 2.5*s + 0.01*cos(t)"})
    whole = jp.simulate(own, turns=6, rtol=1e-11)["end_state"].values
    half = jp.simulate(own, turns=3, rtol=1e-11)["end_state"].values
    again = jp.simulate(own, turns=3, rtol=1e-11, initial=[*half])["end_state"].values
    np.testing.assert_allclose(again, whole, rtol=1e-9, atol=1e-12)


def test_orbits_exponents_and_derivatives_know_it():
    """From y = -2, at p = 0, it never turns on."""
    orbit = jp.periodic_orbit(relay(), transient=20)
    assert float(orbit["orbit_state"].sel(state="z")) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(
        np.sort(np.linalg.norm(orbit["floquet_multiplier"].values, axis=-1))[::-1],
        [DECAY, DECAY, 0.0],
        rtol=1e-6,
    )
    growth = jp.lyapunov(relay(), exponents="all", turns=20)["lyapunov_exponent"].values
    np.testing.assert_allclose(growth, [-1.0, -1.0], rtol=1e-6)
    slopes = jp.gradient(relay(), of=["end:state:y", "end:state:z"], by=["p"], orbit=True)
    np.testing.assert_allclose(slopes["derivative"].values.ravel(), [1.0, 0.0], atol=1e-7)


def test_planes_of_starts_have_both_its_ways():
    plane = {"y": [-2.0, -1.5, 0.0, 0.5, 2.0], "z": [-1.0, 1.0]}
    found = jp.basins(relay(), plane=plane, turns=4, n_jobs=1)
    assert found.sizes["number"] == 2
    assert float(found["fraction_none"]) == 0
    np.testing.assert_allclose(np.sort(found["fraction"].values), [0.2, 0.8])  # above y = 1, and all others


def test_one_that_hangs_on_another_begins_with_it():
    two = [*SWITCH["switches"], {"name": "b", "on": "s - 0.5 + 0*y", "off": "0.5 - s"}]
    started = [relay(states={"y": y, "z": 0.0}, switches=two).initial[2:] for y in (-2.0, 0.0)]
    assert started == [(0.0, 0.0), (1.0, 1.0)]
