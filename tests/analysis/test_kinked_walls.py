"""Rigid walls, jumps and modes whose gap or guard has a kink, or bends where nothing else does.

Against closed forms, the same walls one by one, and integrations by SciPy between events that it locates.
"""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jointplay as jp

TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
CARRIED = {"rates": {"x": "v", "v": "0"}}
FREE = {"rates": {"x": "v", "v": "0"}, "scales": {"t": 1.0}}
PAIR = [
    {"name": "right", "gap": "0.55-x", "restitution": "r"},
    {"name": "left", "gap": "0.55+x", "restitution": "r"},
]
BOTH = [{"name": "both", "gap": "0.55-abs(x)", "restitution": "r"}]
SWUNG = {"rates": {"x": "v", "v": "-x-0.1*v+0.8*cos(w*t)"}, "forcing": "2*pi/w"}


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("half", [0.1, 0.01, 1e-3])
@pytest.mark.parametrize("gap", ["abs(x-0.3)-{0}", "max(x-0.3-{0}, 0.3-{0}-x)", "sqrt((x-0.3)**2)-{0}"])
def test_nothing_passes_through_a_thin_wall(gap, half, rtol):
    walls = [{"name": "w", "gap": gap.format(half), "restitution": "0.5"}]
    thrown = jp.System(name="thrown", states={"x": -1.0, "v": 2.0}, impacts=walls, **FREE)
    found = jp.simulate(thrown, duration=1.9, rtol=rtol)
    met = (1.3 - half) / 2
    np.testing.assert_allclose(found["event_time"].values, [met], rtol=1e-12)
    np.testing.assert_allclose(found["end_state"].values, [0.3 - half - (1.9 - met), -1.0], rtol=1e-12)


def test_a_block_is_met_at_the_side_that_is_nearest():
    walls = [{"name": "block", "gap": "max(0.1-x, 0.1-y, x-0.3)", "restitution": "0.5"}]
    states, rates = {"x": -1.0, "y": -0.8, "u": 1.0, "v": 1.0}, {"x": "u", "y": "v", "u": "0", "v": "0"}
    thrown = jp.System(name="thrown", states=states, rates=rates, impacts=walls, scales={"t": 1.0})
    found = jp.simulate(thrown, duration=1.9)
    np.testing.assert_allclose(found["event_time"].values, [1.1], rtol=1e-12)
    np.testing.assert_allclose(found["end_state"].values, [-0.3, 1.1, -0.5, 1.0], rtol=1e-12)


@pytest.mark.parametrize("gap", ["max(x, -1-x)", "abs(x+0.5)-0.5", "max(x, -5)", "min(x, 5)"])
def test_a_ball_comes_to_rest_on_it(gap):
    walls = [{"name": "floor", "gap": gap, "restitution": "0.5"}]
    falls = {"rates": {"x": "v", "v": "-9.81"}, "scales": {"t": 1.0}}
    dropped = jp.System(name="dropped", states={"x": 1.0, "v": 0.0}, impacts=walls, **falls)
    found = jp.words(jp.simulate(dropped, duration=3.0))
    assert str(found["event_kind"].values[-1]) == "rest"
    assert found["event_time"].values[-1] == pytest.approx(3 * np.sqrt(2 / 9.81), rel=1e-8)
    np.testing.assert_allclose(found["end_state"].values, 0.0, atol=1e-12)


def test_on_a_shaken_table_it_rests_and_leaves_as_on_a_plain_one():
    """A fold of the gap far away changes no event, state or derivative."""
    gaps = ("x-0.05*sin(w*t)", "max(x-0.05*sin(w*t), -0.05*sin(w*t)-2-x)")
    rates = {"rates": {"x": "v", "v": "-9.81"}, "forcing": "2*pi/w"}
    plain, kinked = (
        jp.System(
            name="shaken",
            states={"x": 0.1, "v": 0.0},
            parameters={"w": 16.0, "r": 0.3},
            impacts=[{"name": "table", "gap": gap, "restitution": "r"}],
            **rates,
        )
        for gap in gaps
    )
    runs = [jp.words(jp.simulate(each, turns=8, rtol=1e-10)) for each in (plain, kinked)]
    kinds = [each["event_kind"].values.tolist() for each in runs]
    assert kinds[0] == kinds[1]
    assert {"rest", "separation", "impact"} <= {*kinds[0]}
    for name in ("event_time", "end_state"):
        np.testing.assert_allclose(*(each[name].values for each in runs), rtol=1e-9, atol=1e-11)
    growth = [
        jp.lyapunov(each, turns=40, transient=10)["lyapunov_exponent"].values for each in (plain, kinked)
    ]
    np.testing.assert_allclose(*growth, rtol=1e-6)


def between(walls, r=0.8, **how):
    states = {"x": 0.5, "v": 0.3}
    return jp.System(
        name="between", states=states, parameters={"r": r} | how.pop("numbers", {}), impacts=walls, **how
    )


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_two_walls_in_one_gap_are_two_walls(rtol):
    one, two = (
        jp.simulate(between(walls, 1.0, **FREE), duration=55.0, rtol=rtol)["end_state"].values
        for walls in (BOTH, PAIR)
    )
    np.testing.assert_allclose(one, two, atol=1e-12)


def test_so_they_are_in_events_derivatives_and_exponents():
    one, two = (between(walls, numbers={"w": 1.3}, **SWUNG) for walls in (BOTH, PAIR))
    runs = [jp.simulate(each, turns=6, rtol=1e-11) for each in (one, two)]
    np.testing.assert_allclose(*(each["end_state"].values for each in runs), rtol=1e-8)
    met = [each["event_time"].values[jp.words(each)["event_kind"].values == "impact"] for each in runs]
    np.testing.assert_allclose(*met, rtol=1e-8)
    assert len(met[0]) > 6
    asked = {"turns": 3, "of": ["end:state:x"], "by": ["r", "w"], "rtol": 1e-10}
    found = [jp.gradient(each, **asked) for each in (one, two)]
    assert all((each["derivative_status"].values == 0).all() for each in found)
    np.testing.assert_allclose(*(each["derivative"].values for each in found), rtol=1e-6)
    growth = [jp.lyapunov(each, turns=60, transient=20)["lyapunov_exponent"].values for each in (one, two)]
    np.testing.assert_allclose(*growth, rtol=1e-5, atol=1e-7)


def followed(rates, start, end, guards, jump):
    """State at the end: what happens at each event of the guards is given by the jump."""
    time, state, at = 0.0, np.array(start), 0
    for each in guards:
        each.terminal, each.direction = True, -1
    while time < end:
        settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "max_step": 1e-2, "args": (at,)}
        run = solve_ivp(rates, (time, end), state, events=guards[at], **settings)
        time, state = run.t[-1], run.y[:, -1]
        if run.status == 1:
            state, at = jump(state, at)
    return state


def test_a_mode_begins_and_ends_at_a_guard_with_a_kink():
    modes = {"on": [{"to": "off", "guard": "0.55-abs(x)"}], "off": [{"to": "on", "guard": "abs(x)-0.2"}]}
    states, rates = {"x": 0.5, "v": 0.3}, {"x": "v", "v": "-x-0.1*on*v"}
    switched = jp.System(name="switched", states=states, rates=rates, modes=modes, scales={"t": 1.0})
    found = jp.simulate(switched, duration=9.0, rtol=1e-11)
    guards = [lambda _, s, _on: 0.55 - abs(s[0]), lambda _, s, _on: abs(s[0]) - 0.2]
    like = followed(
        lambda _, s, at: (s[1], -s[0] - 0.1 * (at == 0) * s[1]),
        (0.5, 0.3),
        9.0,
        guards,
        lambda s, at: (s, 1 - at),
    )
    assert found.sizes["event"] > 4
    np.testing.assert_allclose(found["end_state"].values[:2], like, rtol=1e-8)


def test_a_jump_happens_at_a_guard_with_a_kink():
    jumps = [{"name": "j", "guard": "0.55-abs(x)", "jump": {"x": "0.9*x", "v": "-1.6*v"}}]
    states, rates = {"x": 0.5, "v": 0.3}, {"x": "v", "v": "-x"}
    thrown = jp.System(name="thrown", states=states, rates=rates, jumps=jumps, scales={"t": 1.0})
    found = jp.simulate(thrown, duration=9.0, rtol=1e-11)
    like = followed(
        lambda _, s, _at: (s[1], -s[0]),
        (0.5, 0.3),
        9.0,
        [lambda _, s, _at: 0.55 - abs(s[0])],
        lambda s, at: (np.array([0.9 * s[0], -1.6 * s[1]]), at),
    )
    assert np.sum(jp.words(found)["event_kind"].values == "impact") > 2
    np.testing.assert_allclose(found["end_state"].values, like, rtol=1e-8)


BENDS = {  # by the place x of the nearer side, at which it is 0, and a time in which it is passed
    "sqrt((x-c)**2+(w/2)**2)-w": (math.sqrt(0.75), 1.0),
    "log(((x-c)/w)**2+0.5)": (math.sqrt(0.5), 1.0),
    "1-2*exp(-((x-c)/w)**2)": (math.sqrt(math.log(2)), 0.1),
    "1-2/(1+((x-c)/w)**2)": (1.0, 0.1),
    "tanh(((x-c)/w)**2-1)": (1.0, 0.1),
}


@pytest.mark.parametrize("w", [0.1, 0.01, 3e-3])
@pytest.mark.parametrize("gap", BENDS)
def test_nothing_passes_where_a_gap_bends_in_a_part_of_a_step(gap, w):
    half, within = BENDS[gap]
    numbers = {"c": 0.3, "w": w, "x0": -1.0, "v0": 2.0}
    parts = {
        "wall": {"impacts": [{"name": "w", "gap": gap, "restitution": "0.5"}]},
        "jump": {"jumps": [{"name": "j", "guard": gap, "jump": {"x": "-10"}}]},
        "mode": {"modes": {"on": [{"to": "off", "guard": gap}], "off": [{"to": "on", "guard": "x+100"}]}},
        "contact": {"contacts": [{"name": "c", "depth": f"-({gap})", "force": "0.1*depth"}]},
    }
    for name, part in parts.items():
        own = jp.System(
            name=name,
            states={"x": "x0", "v": "v0"},
            parameters=numbers,
            scales={"t": within},
            **CARRIED,
            **part,
        )
        for x, v in itertools.product((-1.0, -1.37, -0.81), (0.7, 2.0, 3.3)):
            found = jp.simulate(own.replace(x0=x, v0=v), duration=2.2 / v)
            met = (0.3 - half * w - x) / v
            assert found["event_time"].values[0] == pytest.approx(met, rel=1e-9), (name, x, v)


def test_what_bends_is_followed_by_itself():
    walls = [{"name": "w", "gap": next(iter(BENDS)), "restitution": "0.5"}]
    own = jp.System(
        name="one", states={"x": -1, "v": 2}, parameters={"c": 0.3, "w": 0.1}, impacts=walls, **CARRIED
    )
    with pytest.raises(jp.InputError, match="no polynomial of the state"):
        jp.poincare(own, section="x = 0", ensemble=True)
