"""No event is stepped over: between two recorded events every guard keeps the sign that the mode demands."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import jointplay as jp
from jointplay import catalog

CONTACT, SEPARATION, REOPENING, IMPACT, REST = 0, 1, 2, 6, 7
OK, CHATTER = 0, 3
FEW = settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))

tolerances = st.sampled_from([1e-4, 1e-5, 1e-8, 1e-12])
starts = st.tuples(st.floats(-0.09, 0.09), st.floats(-1.5, 1.5))


def response(system, rtol, **options):
    found = jp.simulate(system, rtol=rtol, **{"turns": 6, "samples_per_turn": 400} | options)
    assert int(found.status) in (OK, CHATTER)
    assert (np.diff(found.event_time.values) >= 0).all()
    assert (np.diff(found.time.values) > 0).all()
    return found


def pieces(found):
    """Samples between events, with the last event of each wall: (kinds by wall, y, v)."""
    time, (y, v) = found.time.values, found.state_value.values.T
    last, begin = {}, -math.inf
    rows = zip(found.event_time.values, found.event_joint.values, found.event_kind.values, strict=True)
    for end, wall, kind in [*rows, (math.inf, 0, -1)]:
        inside = (time > begin) & (time < end)
        yield dict(last), y[inside], v[inside]
        last[int(wall)], begin = int(kind), end


def check_walls(found, half, K, C, tension, slack):
    for last, y, v in pieces(found):
        for wall, side in enumerate((1, -1)):
            u, force = side * y - half, K * (side * y - half) + C * side * v
            kind = last.get(wall, REOPENING)
            touching, released = kind == CONTACT, kind == SEPARATION and not tension
            if touching and tension:
                assert (u > -slack).all()
            elif touching:
                assert (force > -slack * (K + C)).all()
            elif released:
                assert (force < slack * (K + C)).all()
                assert (u > -slack).all()
            else:
                assert (u < slack).all()


@pytest.mark.nightly
@FEW
@given(st.floats(0.2, 3.0), st.floats(0.5, 6.0), st.floats(0.01, 1.2), st.booleans(), starts, tolerances)
def test_soft_walls(gap, stiffness, ratio, tension, start, rtol):
    K = 10**stiffness
    C = 2 * ratio * math.sqrt(K)
    found = response(catalog.soft_impact_pair(gap, K, C, tension=tension), rtol, initial=start)
    check_walls(found, gap / 2, K, C, tension, 1e-12 + 1e-2 * rtol)


@pytest.mark.long
@FEW
@given(st.floats(0.0, 0.2), st.floats(0.05, 0.4), st.floats(0.4, 2.0), st.floats(0.01, 0.1), tolerances)
def test_gear_flanks(load, amplitude, frequency, damping, rtol):
    found = response(catalog.gear_backlash(load, amplitude, frequency, damping), rtol, turns=20)
    check_walls(found, 1.0, 1.0, 0.0, True, 1e-12 + 1e-2 * rtol)


@FEW
@given(st.floats(0.2, 4.0), st.floats(0.0, 1.0), starts, tolerances)
def test_walls_with_restitution(gap, restitution, start, rtol):
    """Every sample up to the end of the run lies between the walls."""
    found = response(catalog.impact_pair(gap, restitution), rtol, initial=start, turns=20)
    assert (np.abs(found.state_value.sel(state="y").values) < gap / 2 + 1e-12 + 1e-2 * rtol).all()
    assert np.isin(found.event_kind, (IMPACT, REST, SEPARATION)).all()


@FEW
@given(st.floats(0.5, 3.0), st.floats(0.0, 0.95), st.floats(0.01, 3.0), tolerances)
def test_the_ball_stays_above_the_table(acceleration, restitution, height, rtol):
    ball = catalog.bouncing_ball(acceleration, restitution)
    found = response(ball, rtol, initial=(height, 0.0), turns=20)
    above = found.state_value.sel(state="y").values - np.sin(found.time.values)
    assert (above > -1e-11 - rtol).all()  # at rest it follows the table to the tolerance of a position


SYSTEMS = {
    "soft": catalog.soft_impact_pair(0.4, 400.0, 4.0),
    "not_pulling": catalog.soft_impact_pair(0.4, 400.0, 4.0, tension=False),
    "pair": catalog.impact_pair(0.4, 0.8),
    "gear": catalog.gear_backlash(0.1, 0.2, 1.6, 0.05),
    "duffing": catalog.duffing(),
}
each = pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS)


@each
def test_twice_the_same(system):
    one, two = (jp.simulate(system, turns=10).drop_vars("wall_time") for _ in range(2))
    assert one.identical(two)


@each
def test_samples_do_not_change_the_motion(system):
    plain = jp.simulate(system, turns=5, at=[])
    assert plain.sizes["time"] == 0
    end = 5 * float(plain.turn_period_nominal)
    for at in ([0.0, end], [0.0, 0.0, 1e-9, end, end], np.linspace(0, end, 1000), plain.event_time.values):
        found = jp.simulate(system, turns=5, at=at)
        assert np.array_equal(found.time.values, at)
        assert np.isfinite(found.state_value.values).all()
        assert np.array_equal(found.event_time.values, plain.event_time.values)
        assert int(found.n_steps) == int(plain.n_steps)
    assert jp.simulate(system, turns=5, at=[0.0]).state_value.values[0] == pytest.approx(
        system.initial, abs=0
    )


@each
def test_end_of_a_run_is_sampled(system):
    """The last sample of one run is that of a longer one, to the tolerance."""
    end = 7.3
    short = jp.simulate(system, duration=end, at=[end], rtol=1e-11)
    long = jp.simulate(system, duration=2 * end, at=[end], rtol=1e-11)
    assert short.sizes["time"] == 1
    assert short.state_value.values == pytest.approx(long.state_value.values, abs=1e-7)


@each
@pytest.mark.parametrize("duration", [1e-12, 1e-6, 1e-3])
def test_shorter_than_a_step(system, duration):
    found = jp.simulate(system, duration=duration, at=[0.0, duration])
    y, v = system.initial
    assert int(found.status) == OK
    assert found.state_value.values[0].tolist() == [y, v]
    assert found.state_value.values[1] == pytest.approx([y + v * duration, v], abs=3 * duration)


@pytest.mark.parametrize("name", ["soft", "not_pulling", "gear"])
def test_samples_at_events_lie_on_the_wall(name):
    system = SYSTEMS[name]
    times = jp.simulate(system, turns=5, rtol=1e-11).event_time.values
    found = jp.simulate(system, turns=5, rtol=1e-11, at=times)
    y = found.state_value.sel(state="y").values
    half = 1.0 if name == "gear" else 0.2
    on_the_wall = found.event_kind.values != (SEPARATION if name == "not_pulling" else -1)
    assert np.abs(y[on_the_wall]) == pytest.approx(half, abs=1e-11)


def test_step_limit():
    found = jp.simulate(SYSTEMS["soft"], turns=50, max_steps=30)
    assert int(found.status) == 2
    assert int(found.n_steps + found.n_rejected + found.n_failed) == 30
