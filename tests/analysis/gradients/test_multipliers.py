"""Derivatives of multipliers, return times and states on a section: closed forms, and orbits side by side."""

from __future__ import annotations

import cmath

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.gradients.gradient_dataset import VERDICTS
from tests.support.closed_pieces import derivatives

NAMES = ("multiplier", "multiplier_imaginary", "multiplier_modulus", "exponent")
OF = [f"{name}:{number}" for name in NAMES for number in (1, 2)]


def ball(acceleration, restitution):
    """The larger multiplier of one bounce a period: Holmes (1982), in half trace and determinant a^2."""
    a, s = restitution, np.pi * (1 - restitution) / (1 + restitution)
    half = (1 + a * a - (1 + a) ** 2 * cmath.sqrt(acceleration**2 - s * s)) / 2
    return half, a * a


def pair(gap, restitution):
    """Of one impact a wall a period: both are squares of the half period's map's (TRUTH: det and trace)."""
    k = (1 + restitution) / (1 - restitution)
    t0 = cmath.atan(2 / (np.pi * k)) - cmath.acos(gap / cmath.sqrt((np.pi * k) ** 2 + 4))
    trace = 2 * restitution + (1 - restitution**2) * np.pi / 2 * cmath.tan(t0)
    return (trace**2 - 2 * restitution**2) / 2, restitution**4


@pytest.mark.parametrize(("acceleration", "stable"), [(1.3, "stable"), (1.8, "unstable")])
def test_an_orbit_to_which_no_motion_settles_is_named(acceleration, stable):
    """One bounce a period is stable up to the doubling at an acceleration of 1.53."""
    found = jp.gradient(
        catalog.bouncing_ball(acceleration, 0.5), of=["multiplier:1"], orbit=True, transient=200
    )
    assert VERDICTS[int(found["derivative_status"])] == "ok"
    assert (abs(float(found["value"][0])) < 1) == (stable == "stable")
    assert jp.words(found)["stable"].item() == stable
    assert ("the motion does not settle to it" in str(jp.summary(found))) == (stable == "unstable")
    assert "stable" not in jp.gradient(catalog.bouncing_ball(acceleration, 0.5), of=["end:state:y"])


@pytest.mark.parametrize(
    ("system", "closed", "numbers", "start"),
    [
        (catalog.bouncing_ball(1.3, 0.5), ball, (1.3, 0.5), None),
        (catalog.bouncing_ball(1.48, 0.5), ball, (1.48, 0.5), None),
        (catalog.impact_pair(3.6, 0.8), pair, (3.6, 0.8), [-1.8, 0.5]),
    ],
    ids=["ball_pair", "ball_real", "impact_pair"],
)
def test_closed_forms(system, closed, numbers, start):
    """Multipliers half +- sqrt(half^2 - det): a pair's real part and modulus, or each of two real ones."""
    found = jp.gradient(system, of=OF, orbit=True, initial=start, transient=200)
    assert VERDICTS[int(found["derivative_status"])] == "ok"
    half, det = closed(*numbers)
    real = half.real**2 > det

    def larger(*values):
        half, det = closed(*values)
        root = cmath.sqrt(half**2 - det) if real else 0.0
        side = np.sign(half.real) if real else 0.0
        return np.array([half + side * root if real else half, half if real else cmath.sqrt(det)])

    values = np.real(larger(*numbers))
    slopes = derivatives(larger, *numbers).T
    got = found.sel(quantity=["multiplier:1", "multiplier_modulus:1"])
    if real:
        size = np.sign(values[0])
        assert got["value"].values == pytest.approx([values[0], size * values[0]], rel=1e-9)
        expected = np.array([slopes[0], size * slopes[0]])
    else:
        assert got["value"].values == pytest.approx(values, rel=1e-9)
        expected = slopes
    assert got["derivative"].values == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert found["error"].values.max() < 1e-8
    rate = expected[1] / got["value"].values[1] / (2 * np.pi)
    assert found["derivative"].sel(quantity="exponent:1").values == pytest.approx(rate, rel=1e-9, abs=1e-9)


LIMIT_CYCLE = {  # r' = r (mu - r^2), angle' = w + b r^2
    "states": {"x": 0.7, "y": -0.1},
    "parameters": {"mu": 0.3, "w": 2.0, "b": 0.5},
    "rates": {
        "x": "x*(mu - x**2 - y**2) - y*(w + b*(x**2 + y**2))",
        "y": "y*(mu - x**2 - y**2) + x*(w + b*(x**2 + y**2))",
    },
}
PLANE = jp.Plane(quantity="y", value=0.0)


@pytest.mark.nightly
def test_a_limit_cycle_on_a_plane():
    """Radius sqrt(mu), period 2 pi/(w + b mu), multiplier exp(-2 mu T), where y = 0 rises."""
    of = ["end:state:x", "time", "multiplier:1", "exponent:1"]
    found = jp.gradient(jp.System(**LIMIT_CYCLE), of=of, orbit=True, section=PLANE, rtol=1e-12)

    def closed(mu, w, b):
        period = 2 * np.pi / (w + b * mu)
        return np.array([mu**0.5, period, np.exp(-2 * mu * period), -2 * mu])

    assert found["value"].values == pytest.approx(closed(0.3, 2.0, 0.5), rel=1e-9)
    expected = derivatives(closed, 0.3, 2.0, 0.5).T
    assert found["derivative"].values == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_returns_from_a_start_beside_the_plane():
    """The third passage of y = 0: r by Bernoulli's equation, the angle by its integral."""
    found = jp.gradient(
        jp.System(**LIMIT_CYCLE), of=["time", "end:state:x"], turns=3, section=PLANE, rtol=1e-12
    )

    def closed(mu, w, b):
        start, angle = 0.5, cmath.atan(-0.1 / 0.7)  # of r^2, which is 1 / (1/mu + c exp(-2 mu t))
        c = 1 / start - 1 / mu

        def turned(t):
            grown = np.exp(2 * mu * t)
            return angle + w * t + b / 2 * np.log((c * mu + grown) / (c * mu + 1)), 1 / (1 / mu + c / grown)

        t = 6.0 + 0j
        for _ in range(60):
            at, square = turned(t)
            t -= (at - 4 * np.pi) / (w + b * square)
        return np.array([t, np.sqrt(turned(t)[1])])

    expected = closed(0.3, 2.0, 0.5)
    assert found["value"].values == pytest.approx(np.real(expected), rel=1e-9)
    slopes = derivatives(closed, 0.3, 2.0, 0.5).T
    assert found["derivative"].values == pytest.approx(slopes, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("rtol", [1e-8, 1e-10, 1e-12])
def test_equal_multipliers_have_no_derivative(rtol):
    """Both of the linear oscillator without damping in a well of damping 1 are exp(-T)."""
    critical = jp.System(
        states={"x": 1.0, "v": 0.0},
        parameters={"k": 1.0, "c": 2.0},
        rates={"x": "v", "v": "cos(t) - k*x - c*v"},
        forcing="2*pi",
    )
    with pytest.warns(jp.ModelWarning, match="multipliers are equal"):
        found = jp.gradient(critical, of=["multiplier:1"], orbit=True, rtol=rtol)
    assert VERDICTS[int(found["derivative_status"])] == "equal_multipliers"


@pytest.mark.parametrize(
    ("wrong", "key", "text"),
    [
        ({"of": ["multiplier:1"]}, "of[0]", "end:state:x"),
        ({"of": ["multiplier:2"], "orbit": True, "section": PLANE}, "of[0]", "multiplier:1"),
        ({"orbit": True}, "section", "a plane of a state is needed"),
        ({"section": jp.Plane(quantity="z", value=0.0)}, "section.quantity", "y"),
    ],
)
def test_wrong_requests_are_refused(wrong, key, text):
    with pytest.raises(jp.InputError) as caught:
        jp.gradient(jp.System(**LIMIT_CYCLE), **wrong)
    assert [problem.key for problem in caught.value.problems] == [key]
    assert text in str(caught.value)


@pytest.mark.nightly
def test_multipliers_of_the_four_bar():
    """Its period-1 motion, against orbits found beside it, farther off where the parameter hardly acts."""
    mechanism, of = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0), ["multiplier:1", "exponent:1"]
    shares = {
        "clearance": 1e-4,
        "links.coupler.mass": 1e-4,
        "joints.B.contact.damping": 1e-3,
    }  # it hardly acts
    found = jp.gradient(mechanism, of=of, by=[*shares], orbit=True)

    def beside(key, value):
        near = mechanism.replace(**{key: float(value)})
        return jp.gradient(near, of=of, by=["clearance"], orbit=True, rtol=1e-11)["value"].values

    for j, (key, share) in enumerate(shares.items()):
        value = float(found["parameter_value"][j])
        h = share * value
        one, less, two, least = (beside(key, value + i * h) for i in (1, -1, 2, -2))
        expected = (8 * (one - less) - (two - least)) / (12 * h)
        assert found["derivative"].values[:, j] == pytest.approx(expected, rel=1e-6)
        assert (found["error"].values[:, j] < 1e-6 * np.abs(expected)).all()
