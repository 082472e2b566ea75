"""Kinks in rates of own equations, and powers and roots of what they keep above 0: against quadrature.

The sign of what is 0 over a stretch is refused, since no event tells it.
"""

import itertools

import numpy as np
import pytest
from scipy.integrate import quad

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.records import System

SWUNG = {"states": {"x": "sin(0.4)", "v": "1.7*cos(0.4)", "z": "0"}, "scales": {"t": 1.0}}
HELD = {  # with the value, of x = sin(1.7 t + 0.4) and its speed v
    "k*max(-x, 0)**1.5": lambda x, _: 3 * np.maximum(-x, 0) ** 1.5,
    "max(x-0.3, 0)**2.5": lambda x, _: np.maximum(x - 0.3, 0) ** 2.5,
    "abs(x)**n": lambda x, _: abs(x) ** 1.5,
    "x*sqrt(abs(x))": lambda x, _: x * abs(x) ** 0.5,
    "sign(x)*sqrt(abs(x))": lambda x, _: np.sign(x) * abs(x) ** 0.5,
    "sqrt(max(x, 0))": lambda x, _: np.maximum(x, 0) ** 0.5,
    "max(sqrt(x**2), 0.5)": lambda x, _: np.maximum(abs(x), 0.5),
    "abs(sqrt(x**2)-x)": lambda x, _: abs(abs(x) - x),
    "sign(sqrt(v**2)-0.3)": lambda _, v: np.sign(abs(v) - 0.3),
    "min(sqrt(x**2), sqrt(v**2))": lambda x, v: np.minimum(abs(x), abs(v)),
    "max(sign(x), 0)": lambda x, _: np.sign(x).clip(0),
    "sign(a)+sign(-2)": lambda x, _: -1.0 + 0 * x,
}


def kinks():
    """Times at which one of these has a kink: of angles at which x, or v, has a value, or both are alike."""
    phases = [
        np.arcsin([0, 0.3, 0.5, -0.5]),
        np.arccos([0.3 / 1.7, -0.3 / 1.7]),
        np.arctan([1.7, -1.7]),
        [np.pi / 2],
    ]
    angles = np.concatenate(
        [*phases, *(np.pi - np.array(each) for each in phases), *(-np.array(each) for each in phases)]
    )
    times = (angles[:, None] + 2 * np.pi * np.arange(-1, 4) - 0.4) / 1.7
    return np.unique(times[(times > 0) & (times < 9)].round(12))


@pytest.mark.parametrize("text", HELD)
def test_powers_and_roots_of_what_a_kink_keeps_above_zero_are_those_of_numpy(text):
    rates = {"x": "v", "v": "-1.7**2*x", "z": text}
    found = jp.simulate(
        System(name="s", parameters={"k": 3, "n": 1.5, "a": 0}, rates=rates, **SWUNG), duration=9.0
    )

    def value(t):
        return HELD[text](np.sin(1.7 * t + 0.4), 1.7 * np.cos(1.7 * t + 0.4))

    expected = sum(quad(value, *part, limit=200)[0] for part in itertools.pairwise([0.0, *kinks(), 9.0]))
    assert jp.words(found)["status"] == "ok"
    assert found["state_value"].values[-1, -1] == pytest.approx(expected, rel=1e-6)


FLAT = ["sign(max(x, 0))", "sign(abs(x)+x)", "sign(max(x, -v)+v)", "sign(s*x)", "2*sign(min(abs(v)-1, 0))"]


@pytest.mark.parametrize("text", FLAT)
def test_what_is_0_over_a_stretch_has_no_sign(text):
    with pytest.raises(InputError, match="0 over a stretch"):
        System(name="s", rates={"x": "v", "v": "-x", "z": text}, switches=[{"name": "s", "on": "v"}], **SWUNG)


@pytest.mark.parametrize("guard", ["max(x, 0)", "abs(x)-x"])
def test_nor_can_it_tell_an_event(guard):
    parts = {
        "switches": [{"name": "s", "on": guard}],
        "impacts": [{"name": "w", "gap": guard, "restitution": "1"}],
        "jumps": [{"name": "j", "guard": guard, "jump": {"z": "1"}}],
        "contacts": [{"name": "c", "depth": guard, "force": "depth"}],
    }
    for name, part in parts.items():
        with pytest.raises(InputError, match="0 over a stretch"):
            System(name="s", rates={"x": "v", "v": "-x", "z": "v"}, **SWUNG, **{name: part})
