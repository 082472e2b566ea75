"""A block dragged through zero speed, creeping, on a belt: every law of friction against closed forms.

Mass m held by a spring k on a belt of speed V: it breaks away at f_s m g. With two coefficients, A = (f_s -
f) N/k and w = sqrt(k/m), slip takes (pi + 2 arctan(V/(w A)))/w and 2 A of way; sticking lasts 2 A/V.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from jointplay.analysis import tangents
from jointplay.analysis.quantities import EVENTS
from jointplay.solver.mechanism.parts.friction import Friction
from jointplay.solver.motion.trajectory import Request, follow
from tests.support.belt import LAWS, REGULARISED, STICKING, belt, ratio
from tests.support.tangent_map import tangent_map

M, K, V, N = 2.0, 50.0, 0.1, 20.0
KINKED = ("ramp", "ambrosio", "threlfall")
QUICK = ("coulomb", "threlfall", "andersson", "stribeck")


def each(names):
    """Laws by name; of some the tests are long."""
    return [name if name in QUICK else pytest.param(name, marks=pytest.mark.nightly) for name in names]


def motion(model, duration, rtol=1e-11, at=None):
    """States at times (the end alone, if none are given), events as (kind, time, position)."""
    times = np.array([duration]) if at is None else at
    found = follow(model, Request(duration, rtol, at=times, events=True, log_from=0.0))
    assert found.status == 0
    events = [(EVENTS[int(row[1])], row[2], row[3]) for row in found.events]
    return found.samples[:, 1:3], events, found.counts


def creep(friction, share):
    """Speed at which a law balances a share of its coefficient, in closed form where there is one."""
    v_0, load = friction.velocity, share * friction.coefficient
    if friction.law == "tanh":
        return v_0 * math.atanh(share)
    if friction.law == "ramp":
        return v_0 * share
    if friction.law == "ambrosio":
        return v_0 + (friction.full_velocity - v_0) * share
    if friction.law == "threlfall":
        return -v_0 / 3 * math.log1p(-share)
    return brentq(lambda v: ratio(friction, v) - load, 0.0, v_0, xtol=1e-16)


@pytest.mark.parametrize("name", each(REGULARISED))
@pytest.mark.parametrize("share", [0.5, -0.9])
def test_under_a_small_load_regularised_laws_creep(name, share):
    friction = LAWS[name]
    ((_, speed),), _, _ = motion(belt(friction, (0.0, 0.0), k=0.0, V=0.0, load=share * 0.3 * N), 40.0)
    assert speed == pytest.approx(math.copysign(creep(friction, abs(share)), share), rel=1e-10)


@pytest.mark.parametrize("name", each(STICKING))
def test_under_a_small_load_nothing_moves_that_sticks(name):
    limit = {"coulomb": 0.3, "stribeck": 0.5}[name] * N
    for share, moves in ((0.999, False), (-0.999, False), (1.001, True), (-1.001, True)):
        model = belt(LAWS[name], (0.0, 0.0), k=0.0, V=0.0, load=share * limit)
        ((x, v),), _, _ = motion(model, 2.0)
        assert (abs(v) > 1e-3) == moves
        assert (x == 0.0 == v) == (not moves)


@pytest.mark.parametrize("name", each(LAWS))
def test_steady_slip_takes_what_the_formula_says(name):
    """A load beyond the limit, less the formula's friction, accelerates."""
    for v in (0.7, -0.7):
        model = belt(LAWS[name], (0.0, v), k=0.0, V=0.0, load=math.copysign(20.0, v))
        ((_, after),), _, _ = motion(model, 0.1)
        mean = (after - v) / 0.1
        low, high = sorted(
            M * mean - (math.copysign(20.0, v) - N * _signed(LAWS[name], u)) for u in (v, after)
        )
        assert low <= 1e-9
        assert high >= -1e-9
        assert abs(after) > abs(v)


def _signed(friction, v):
    return ratio(friction, v) * (math.copysign(1.0, v) if friction.law in STICKING else 1.0)


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
@pytest.mark.parametrize(("narrow", "load"), [(0.01, -50.0), (0.03, -5.0)])
def test_the_top_of_friction_at_rest_is_not_stepped_over(narrow, load, rtol):
    """Speed turns under a load that is larger; the instant by quadrature."""
    friction = Friction(law="stribeck", coefficient=0.1, static_coefficient=0.2, stribeck_velocity=narrow)
    ends = (0.0, 5 * narrow, 1.0)
    _, events, _ = motion(belt(friction, (0.0, ends[-1]), k=0.0, V=0.0, load=load), 1.0, rtol)
    ((kind, turned, _),) = events
    exact = sum(quad(lambda v: M / (ratio(friction, v) * N - load), *part)[0] for part in pairwise(ends))
    assert kind == "slip_reversal"
    assert turned == pytest.approx(exact, rel=2 * rtol)


@pytest.mark.parametrize("name", each(LAWS))
def test_dragged_through_zero_speed_energy_falls(name):
    """A free oscillation: friction takes energy all the time, and stops what can stop."""
    times = np.linspace(0.0, 4.0, 400)
    states, events, _ = motion(belt(LAWS[name], (0.6, 0.0), V=0.0), 4.0, 1e-10, times)
    energy = M * states[:, 1] ** 2 / 2 + K * states[:, 0] ** 2 / 2
    assert (np.diff(energy) <= 1e-9).all()
    assert energy[-1] < 0.2 * energy[0]
    assert (states[:, 1] < -0.1).any()
    assert (states[:, 1] > 0.1).any()
    if name in STICKING:
        assert events[-1][0] == "stick_onset"
        assert np.ptp(states[-20:, 0]) < 1e-15
    else:
        assert events == []


@pytest.mark.parametrize("name", each(REGULARISED))
def test_the_motion_is_that_of_another_solver(name):
    """Kinks too: they cost steps, not accuracy."""
    friction, start = LAWS[name], (0.25, 0.0)

    def rate(_, y):
        return y[1], (-K * y[0] - N * float(ratio(friction, y[1]))) / M

    # of steps far shorter than what the kinks lie apart
    other = solve_ivp(rate, (0.0, 0.6), start, method="DOP853", rtol=1e-12, atol=1e-14, max_step=1e-3).y[
        :, -1
    ]
    for rtol in (1e-7, 1e-10):
        (end,), _, _ = motion(belt(friction, start, V=0.0), 0.6, rtol)
        assert np.abs(end - other).max() < 10 * rtol * 0.1


def cycle(friction):
    """Break-away, and duration of slip, slip distance and duration of sticking, on the belt."""
    _, events, _ = motion(belt(friction, (0.0, V)), 15.0)
    onsets = [(t, x) for kind, t, x in events if kind == "slip_onset"]
    stops = [(t, x) for kind, t, x in events if kind == "stick_onset"]
    (slip, far), (stop, near) = onsets[1], stops[1]
    return onsets[0][1] * K, stop - slip, far - near, onsets[2][0] - stop


def two_coefficients(f_s, f):
    """The same of Coulomb's law with two coefficients."""
    A, w = (f_s - f) * N / K, math.sqrt(K / M)
    return f_s * N, (math.pi + 2 * math.atan2(V, w * A)) / w, 2 * A, 2 * A / V


def test_coulomb_on_a_belt_breaks_away_at_its_limit_and_slips_whole_periods():
    """With one coefficient slip only touches zero speed: rounding decides whether it sticks there."""
    force, slip, _, stick = cycle(LAWS["coulomb"])
    periods = slip / two_coefficients(0.3, 0.3)[1]
    assert force == pytest.approx(0.3 * N, rel=1e-12)
    assert round(periods) >= 1
    assert periods == pytest.approx(round(periods), rel=1e-7)
    assert stick < 1e-6


PAGE = Path(__file__).parents[2] / "docs" / "friction-laws.md"


@pytest.mark.parametrize(("exponent", "order"), [(1.0, 1.0), (2.0, 2 / 3)])
def test_stribeck_on_a_belt_tends_to_two_coefficients(exponent, order):
    """Leaving rest takes time, less with smaller v_s: an error of order v_s, or v_s^(2/3) at exponent 2."""
    exact, errors = two_coefficients(0.5, 0.3), []
    for share in (1e-3, 1e-4):
        numbers = {"static_coefficient": 0.5, "stribeck_velocity": share * V, "exponent": exponent}
        found = cycle(Friction(law="stribeck", coefficient=0.3, **numbers))
        assert found[0] == pytest.approx(exact[0], rel=1e-12)
        assert found[2] == pytest.approx(V * found[3], rel=1e-9)
        errors.append([value / known - 1 for value, known in zip(found, exact, strict=True)][1:])
        told = " | ".join(f"{100 * error:.2g} %" for error in errors[-1][:2])
        assert f"| {exponent:g} | {share:g} V | {told} |" in PAGE.read_text(encoding="utf-8")
    assert max(errors[1]) < {1.0: 1e-4, 2.0: 1e-3}[exponent]
    for coarse, fine in zip(*errors, strict=True):
        assert math.log10(coarse / fine) == pytest.approx(order, abs=0.12)


@pytest.mark.parametrize("name", each(LAWS))
@pytest.mark.parametrize("speed", [0.0, V])
def test_tangents_through_zero_speed(name, speed):
    """Against central differences, through slip reversal, onset of sticking and break-away.

    Where slopes have kinks tangents are less exact: no event makes a step end there.
    """
    limit = LAWS[name].parameters["fs" if name == "stribeck" else "f"] * N / K
    start = (limit - 0.08, 0.05) if speed else (0.25, 0.03)
    duration = 1.2 if speed else 1.0
    model = belt(LAWS[name], start, V=speed)
    exact, scale, kinds = tangent_map(model, duration, 1e-13), tangents.scales(model), set()

    def quotient(size):
        columns = []
        for shift in size * np.diag(scale):
            ends = [motion(replace(model, state=start + i * shift), duration, 1e-13) for i in (1, -1, 2, -2)]
            for (_, one, _), (_, other, _) in pairwise(ends):
                assert [event[0] for event in one] == [event[0] for event in other]
            kinds.update(event[0] for event in ends[0][1])
            (a, b, c, d) = (state[0] for state, _, _ in ends)
            columns.append((8 * (a - b) - (c - d)) / (12 * shift.max()))
        return np.array(columns).T

    error = min(np.abs(quotient(size) - exact).max() for size in (1e-5, 1e-4)) / np.abs(exact).max()
    assert error < (1e-6 if name in KINKED else 1e-9)
    if name in STICKING:
        assert kinds >= ({"stick_onset", "slip_onset"} if speed else {"slip_reversal", "stick_onset"})
