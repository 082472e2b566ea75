"""Rigid walls beside what changes with a speed: an impact puts kinks, switches and let-go forces beyond zero.

Against a closed form, and against integrations by SciPy between events that it locates.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jointplay as jp

TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
BALL = {"name": "f", "gap": "x", "restitution": "r"}
FORMS = {
    "sign": {"rates": {"x": "v", "v": "-300-20*sign(v)"}},
    "switch": {
        "rates": {"x": "v", "v": "-300-20*(2*up-1)"},
        "switches": [{"name": "up", "on": "v"}],
    },
}


def falling(form):
    """A ball between two constant accelerations, by the sense of its speed."""
    return jp.System(
        name="falling",
        states={"x": 0.1, "v": 0.0},
        parameters={"r": 0.9},
        impacts=[BALL],
        scales={"t": 1.0},
        **FORMS[form],
    )


def exact(end, x=0.1, v=0.0, up=320.0, down=280.0, r=0.9):
    """State of the falling ball, from one top or impact to the next."""
    while end > 0:
        a, lasts = (up, v / up) if v > 0 else (down, (v + np.sqrt(v * v + 2 * down * x)) / down)
        lasts = min(lasts, end)
        x, v, end = x + v * lasts - a * lasts**2 / 2, v - a * lasts, end - lasts
        if end > 0 and v < 0:
            x, v = 0.0, -r * v
        elif end > 0:
            v = 0.0
    return x, v


@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("form", ["sign", "switch"])
def test_a_speed_that_an_impact_turns_has_turned_what_hangs_on_its_sign(form, rtol):
    found = jp.simulate(falling(form), duration=0.1, transient=0, rtol=rtol)
    assert int(found["status"]) == 0
    np.testing.assert_allclose(found["end_state"].values, exact(0.1), rtol=1e-6)


def bounced(rates, start, end, wall, turned):
    """State at the end: rates of time and state, from impact to impact; by `turned` each goes on."""
    time, state = 0.0, np.array(start)
    while time < end:
        settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "events": wall, "max_step": 1e-3}
        run = solve_ivp(rates, (time, end), state, **settings)
        time, state = run.t[-1], run.y[:, -1]
        if run.status == 1:
            state = turned(state)
    return state


def ball_with_drag(**more):
    rates = {"x": "v", "v": "-g-c*v*abs(v)" + more.pop("drive", "")}
    numbers = {"g": 9.81, "c": 0.5, "r": 0.8} | more.pop("numbers", {})
    states = {"x": 1.0, "v": 0.0}
    return jp.System(name="ball", states=states, parameters=numbers, rates=rates, impacts=[BALL], **more)


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_a_ball_with_drag_bounces_as_by_another_integrator(rtol):
    def meets(_, s):
        return s[0]

    meets.terminal, meets.direction = True, -1

    def rates(_, s):
        return s[1], -9.81 - 0.5 * s[1] * abs(s[1])

    like = bounced(rates, (1.0, 0.0), 1.5, meets, lambda s: np.array([1e-16, -0.8 * s[1]]))
    found = jp.simulate(ball_with_drag(scales={"t": 0.5}), duration=1.5, transient=0, rtol=rtol)
    np.testing.assert_allclose(found["end_state"].values, like, rtol=2e-5 if rtol > 1e-7 else 1e-7)


def test_derivatives_and_exponents_of_a_driven_ball_with_drag():
    """By differences over two parts in 10⁵; a table drives what bounces on it."""
    system = ball_with_drag(drive="+3*sin(w*t)", numbers={"w": 9.0}, forcing="2*pi/w")
    found = jp.gradient(system, turns=1, transient=0, of=["end:state:x"], by=["c", "g"], rtol=1e-10)
    assert (found["derivative_status"].values == 0).all()
    for name, value in zip(("c", "g"), np.ravel(found["derivative"].values), strict=True):
        size = float(system.replace().parameters[name])
        ends = [
            jp.simulate(system.replace(**{name: size * (1 + step)}), turns=1, transient=0, rtol=1e-12)
            for step in (-1e-5, 1e-5)
        ]
        difference = np.subtract(*(each["end_state"].values[0] for each in ends[::-1])) / (2e-5 * size)
        assert value == pytest.approx(difference, rel=1e-6)
    assert int(jp.lyapunov(system, turns=20, transient=5)["status"]) == 0


@pytest.mark.parametrize("rtol", TOLERANCES)
def test_a_contact_that_an_impact_makes_pull_lets_go(rtol):
    """A block is pushed by a plate with a strong damper until the plate hits a stop and turns back."""
    system = jp.System(
        name="plate",
        states={"x": 0.02, "y": 0.0, "v": 1.0, "u": 1.0},
        parameters={"k": 2000.0, "c": 120.0, "r": 0.8, "w": 5.0},
        rates={"x": "v", "y": "u", "v": "-9.81", "u": "-50*y-.5*u+40*sin(w*t)"},
        forcing="2*pi/w",
        contacts=[{"name": "q", "depth": "y-x+0.03", "force": "k*depth+c*speed", "tension": False}],
        impacts=[{"name": "w", "gap": "0.05-y", "restitution": "r"}],
    )

    def meets(_, s):
        return 0.05 - s[1]

    meets.terminal, meets.direction = True, -1

    def rates(t, s):
        x, y, v, u = s
        depth = y - x + 0.03
        push = max(2000.0 * depth + 120.0 * (u - v), 0.0) if depth > 0 else 0.0
        return v, u, push - 9.81, -50 * y - 0.5 * u - push + 40 * np.sin(5 * t)

    turned = lambda s: np.array([s[0], 0.05 - 1e-16, s[2], -0.8 * s[3]])  # noqa: E731
    like = bounced(rates, (0.02, 0.0, 1.0, 1.0), 0.27, meets, turned)
    found = jp.simulate(system, duration=0.27, transient=0, rtol=rtol)
    np.testing.assert_allclose(found["state_value"].values[-1], like, rtol=3e-5)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("grows", "way"), [(0.1, 0.1 / 6), (0.0, 0.0), (-0.1, 0.0)])
def test_what_starts_at_the_limit_of_friction_sticks_until_the_load_grows(grows, way, sign):
    """x = b t³/6 where the load a + b t exceeds the friction a."""
    own = jp.System(
        name="block",
        states={"x": 0.0, "v": 0.0, "s": 0.0},
        parameters={"a": 0.8, "b": grows, "way": sign},
        rates={"x": "v", "v": "way*(a + b*s)", "s": "1"},
        friction=[{"name": "f", "speed": "v", "normal": "1", "coefficient": "0.8"}],
        as_meant=True,
    )
    found = jp.words(jp.simulate(own, duration=1.0, rtol=1e-10))
    assert found["status"] == "ok"
    np.testing.assert_allclose(found["end_state"].values[:2], [sign * way, sign * 3 * way], atol=1e-9)
