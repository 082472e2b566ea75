"""Textbook systems as shipped studies, each against a closed form that is derived here."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import jointplay as jp
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.codes import Status
from jointplay.study.file import load
from tests.support.tangent_map import tangent_map

STUDIES = Path(__file__).parents[2] / "studies" / "own"
TAU = 2 * math.pi
pytestmark = pytest.mark.long


def system(name, **changes):
    return load(STUDIES / f"{name}.toml").record.mechanism.replace(**changes)


def states(mechanism, at, **how):
    """States at times; a row each."""
    at = list(at)
    found = jp.simulate(mechanism, duration=at[-1] + 1e-9, at=at, rtol=1e-11, **how)
    assert int(found.status) == 0
    return found.state_value.values


def events(mechanism, duration, kind, **how):
    found = jp.simulate(mechanism, duration=duration, rtol=1e-11, **how)
    words = found.event_kind.attrs["flag_meanings"].split()
    return found.event_time.values[found.event_kind.values == words.index(kind)]


def test_relief_valve_loses_its_steady_state_where_its_eigenvalues_say():
    """x² (x + delta) = flow²; s³ + (kappa + c) s² + (1 + kappa c) s + c + d, with c, d of the pressure."""
    valve = system("relief_valve")
    kappa, delta, beta = (valve.parameters[name] for name in ("kappa", "delta", "beta"))

    def steady(flow):
        x = brentq(lambda x: x * math.sqrt(x + delta) - flow, 0, 10)
        p = x + delta
        slope = [[0, 1, 0], [-1, -kappa, 1], [-beta * math.sqrt(p), 0, -beta * x / (2 * math.sqrt(p))]]
        return (x, 0.0, p), np.linalg.eigvals(slope)

    hopf = brentq(lambda flow: steady(flow)[1].real.max(), 5, 10)
    for flow in (hopf - 0.3, hopf + 0.3):
        state, values = steady(flow)
        there = valve.replace(flow=flow)
        assert states(there, [1.0], initial=state)[0] == pytest.approx(state, abs=1e-12)
        found = np.linalg.eigvals(tangent_map(assemble(there, state), 2.0, 1e-11))
        assert sorted(abs(found)) == pytest.approx(sorted(abs(np.exp(2 * values))), abs=1e-8)
    spread = []
    for flow in (hopf + 0.3, hopf - 0.3):
        start = np.add(steady(flow)[0], (0.05, 0, 0))
        spread.append(
            np.ptp(states(valve.replace(flow=flow), [199.0, 200.0, 201.0], initial=start), axis=0).max()
        )
    assert spread[0] < 1e-2 < spread[1]
    assert 8 < hopf < 9


def test_stick_slip_period():
    """Slip lasts 2/w (pi - atan(D w/V)) and sticking 2 D/V, D = (static - sliding) N/k."""
    block = system("stick_slip")
    p = block.parameters
    w, D = math.sqrt(p["stiffness"] / p["mass"]), (p["static"] - p["sliding"]) * p["load"] / p["stiffness"]
    slip, stick = 2 / w * (math.pi - math.atan(D * w / p["belt"])), 2 * D / p["belt"]
    found = events(block, 20.0, "slip_onset")
    again = events(block, 20.0, "stick_onset")
    assert len(found) > 3
    assert np.diff(found) == pytest.approx(slip + stick, abs=1e-9)
    assert found[0] == pytest.approx(p["static"] * p["load"] / p["stiffness"] / p["belt"], abs=1e-9)
    assert again[-len(found) :][0] > 0
    assert (again[again > found[0]][0] - found[0]) == pytest.approx(slip, abs=1e-9)


def test_impact_oscillator_grazes_where_its_amplitude_is_the_distance():
    oscillator = system("impact_oscillator")
    w, damping = oscillator.parameters["frequency"], oscillator.parameters["damping"]
    amplitude = 1 / math.hypot(1 - w**2, 2 * damping * w)
    phase = math.atan2(2 * damping * w, 1 - w**2)
    steady = amplitude * math.cos(phase), amplitude * w * math.sin(phase)
    for distance, hits in ((1.000001 * amplitude, False), (0.999 * amplitude, True)):
        found = events(oscillator.replace(distance=distance), 20.0, "impact", initial=steady)
        assert bool(len(found)) == hits
    at = np.linspace(1, 20, 9)
    found = states(oscillator.replace(distance=2 * amplitude), at, initial=steady)
    assert found[:, 0] == pytest.approx(amplitude * np.cos(w * at - phase), abs=1e-9)


def test_ball_bounces_once_a_period_where_it_should():
    """cos t0 = pi (1 - a)/(Gamma (1 + a)), and the period doubles at Gamma_PD (Guckenheimer and Holmes)."""
    a, at_one = 0.5, math.pi * (1 - 0.5) / (1 + 0.5)
    doubling = math.hypot(at_one, 2 * (1 + a**2) / (1 + a) ** 2)
    for gamma, period in ((doubling - 0.03, 1), (doubling + 0.03, 2)):
        start = jp.catalog.bouncing_ball(gamma, a).initial
        ball = system("bouncing_ball", acceleration=gamma, initial=start)
        hits = events(ball, 400 * TAU, "impact")[-8:] % TAU
        assert np.ptp(hits[::period]) < 1e-6 < (np.ptp(hits) + (period == 1))
        if period == 1:
            assert math.cos(hits[-1]) == pytest.approx(at_one / gamma, abs=1e-7)


def test_rocking_block_as_housner_has_it():
    """A quarter of the swing from a: acosh(1/(1 - a))/p; then 1 - (1 - b)² = r² (1 - (1 - a)²)."""
    block = system("rocking_block")
    p, r, a, time = block.parameters["frequency"], block.parameters["restitution"], 0.9, 0.0
    found = events(block, 9.0, "impact")
    assert len(found) > 5
    for n in range(5):
        quarter = math.acosh(1 / (1 - a)) / p
        time += quarter
        assert found[n] == pytest.approx(time, abs=1e-8)
        a = 1 - math.sqrt(1 - r**2 * (1 - (1 - a) ** 2))
        time += math.acosh(1 / (1 - a)) / p


@pytest.mark.nightly
def test_buck_converter_against_its_exact_pieces():
    """Between events it is linear: exponentials of matrices, and roots of the control voltage on the ramp."""
    buck = system("buck_converter")
    p = buck.parameters
    A = np.array([[-1 / p["load"] / p["capacity"], 1 / p["capacity"]], [-1 / p["coil"], 0.0]])
    drive = np.array([0.0, p["source"] / p["coil"]])

    def flown(x, on, dt):
        rest = -np.linalg.solve(A, drive * on)
        return rest + expm(A * dt) @ (x - rest)

    def guard(x, clock):
        return p["low"] + (p["high"] - p["low"]) * clock - p["gain"] * (x[0] - p["reference"])

    x, T, cycles = np.array([12.0, 0.55]), p["cycle"], 40
    for _ in range(cycles):
        at, on = 0.0, guard(x, 0.0) > 0
        while at < T:
            grid = np.linspace(at, T, 200)[1:]
            beyond = [t for t in grid if (guard(flown(x, on, t - at), t / T) > 0) != on and t > at + 1e-9]
            if not beyond:
                break
            first = grid[max(np.searchsorted(grid, beyond[0]) - 1, 0)] if beyond[0] > grid[0] else at + 1e-12
            until = brentq(
                lambda t, x=x, on=on, at=at: guard(flown(x, on, t - at), t / T), first, beyond[0], xtol=1e-18
            )
            x, at, on = flown(x, on, until - at), until, not on
        x = flown(x, on, T - at)
    found = jp.simulate(buck, duration=(cycles + 0.01) * T, at=[cycles * T - 1e-12], rtol=1e-11)
    assert int(found.status) == 0
    assert found.state_value.values[-1][:2] == pytest.approx(x, abs=1e-6)


def test_clocks_of_the_buck_converter_lose_nothing_in_its_tangents():
    model = assemble(system("buck_converter"))
    until, h = 3.3 * 4e-4, 1e-5
    found = tangent_map(model, until, 1e-12)
    columns = []
    for d in h * np.diag([1.0, 1.0, 0.1]):
        ends = [
            states(system("buck_converter"), [until], initial=tuple(model.state + s * d))[0] for s in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / (2 * np.abs(d).max()))
    assert found == pytest.approx(np.transpose(columns), rel=1e-4, abs=1e-5)


def test_chua_rests_and_grows_as_its_eigenvalues_say():
    """Beside 0 it rests at x = +-(outer - inner)/(1 + outer), y = 0, z = -x."""
    chua = system("chua")
    p, beta = chua.parameters, chua.parameters["beta"]
    x = (p["outer"] - p["inner"]) / (1 + p["outer"])
    for state, slope in (
        ((x, 0.0, -x), p["outer"]),
        ((-x, 0.0, x), p["outer"]),
        ((0.0, 0.0, 0.0), p["inner"]),
    ):
        A = np.array([[-9.0 * (1 + slope), 9.0, 0.0], [1.0, -1.0, 1.0], [0.0, -beta, 0.0]])
        assert x == pytest.approx(1.5)
        assert states(chua, [1.0], initial=state)[0] == pytest.approx(state, abs=1e-10)
        found = tangent_map(assemble(chua, state), 0.7, 1e-11)
        assert found == pytest.approx(expm(0.7 * A), abs=1e-7)


def test_rimless_wheel_comes_to_its_speed():
    """rate² after a step: c² 4 sin(slope) sin(half)/(1 - c²), c = cos 2 half; c² of what is off is left."""
    wheel = system("rimless_wheel")
    slope, half = wheel.parameters["slope"], wheel.parameters["half"]
    c = math.cos(2 * half)
    gain = 4 * math.sin(slope) * math.sin(half)
    found = jp.poincare(wheel, jp.ContactSection(joint="step"), turns=12, rtol=1e-11)
    assert found.sizes["turn"] == 11
    squares = [0.6**2]
    for _ in range(11):
        squares.append(c**2 * (squares[-1] + gain))
    assert found.state_value.sel(state="rate").values ** 2 == pytest.approx(squares[1:], abs=1e-9)
    steady = math.sqrt(gain * c**2 / (1 - c**2))
    upright = math.sqrt(steady**2 + 2 * math.cos(slope - half) - 2)  # rate²/2 + cos(tilt) is kept
    model = assemble(wheel, (0.0, upright))  # five steps from here end far from an impact
    times = events(wheel, 60.0, "impact", initial=(slope - half, steady))
    step = times[0]
    assert np.diff(times) == pytest.approx(step, abs=1e-8)
    values = np.linalg.eigvals(tangent_map(model, 5 * step, 1e-12))
    assert sorted(abs(values)) == pytest.approx([c**10, 1.0], abs=1e-6)


def test_gear_pair_in_contact_all_the_time_is_linear():
    gear = system("gear_backlash", mean_load=5.0)
    W, zeta, a = (gear.parameters[name] for name in ("frequency", "damping", "amplitude"))
    size, phase = a * W**2 / math.hypot(1 - W**2, 2 * zeta * W), math.atan2(2 * zeta * W, 1 - W**2)
    start = 6 + size * math.cos(phase), size * W * math.sin(phase)
    at = np.linspace(1, 15, 8)
    assert states(gear, at, initial=start)[:, 0] == pytest.approx(6 + size * np.cos(W * at - phase), abs=1e-9)
    chaotic = jp.lyapunov(system("gear_backlash"), turns=200, transient=50, exponents="all")
    assert float(chaotic.lyapunov_exponent.sum()) == pytest.approx(-2 * zeta, abs=1e-6)


def test_friction_turns_with_a_jump_of_the_speed():
    """A block on a rough floor whose speed a clock turns round at t = 0.5: 1 - f t, then f t - 1 up to 0."""
    block = jp.System(
        states={"x": 0, "v": 1, "clock": 0},
        parameters={"f": 0.4},
        rates={"x": "v", "v": 0, "clock": 1},
        friction=[{"name": "floor", "speed": "v", "normal": 1, "coefficient": "f"}],
        jumps=[{"name": "turn", "guard": "0.5 - clock", "jump": {"v": "-v", "clock": "clock - 100"}}],
    )
    found = states(block, [0.4, 0.6, 2.0, 2.4, 2.6, 4.0])[:, 1]
    assert found == pytest.approx([0.84, -0.76, -0.2, -0.04, 0, 0], abs=1e-10)
    assert events(block, 4.0, "stick_onset") == pytest.approx([2.5], abs=1e-9)


def test_a_switch_with_two_thresholds_remembers():
    """x' = 1 from 1 up to 3, -2 back: 2 + 1 a cycle."""
    heater = {"name": "heater", "on": "1 - x", "off": "x - 3"}
    room = jp.System(states={"x": 2}, rates={"x": "3*heater - 2"}, switches=[heater])
    found = jp.simulate(room, duration=19.5, rtol=1e-11)
    assert found.event_time.values == pytest.approx(
        np.sort([*np.arange(1, 20, 3), *np.arange(2, 20, 3)]), abs=1e-10
    )


def test_two_masses_slide_as_modes_until_one_turns_and_rest_where_friction_holds():
    chain = system("friction_chain")
    k, F = 100.0, 2.0
    K, start = k * np.array([[2.0, -1.0], [-1.0, 1.0]]), np.array([0.2, 0.3])
    squares, modes = np.linalg.eigh(K)
    middle = np.linalg.solve(K, [F, F])  # both slide down: friction pushes up
    amplitudes = modes.T @ (start - middle)

    def motion(t):
        w = np.sqrt(squares)
        return middle + modes @ (amplitudes * np.cos(w * t)), -modes @ (amplitudes * w * np.sin(w * t))

    slips = events(chain, 5.0, "slip_reversal")
    stops = np.concatenate([slips, events(chain, 5.0, "stick_onset")])
    first = min(stops[stops > 1e-9])
    assert min(abs(motion(first)[1])) < 1e-8
    for t in (0.3 * first, 0.7 * first):
        found = states(chain, [t])[0]
        assert found == pytest.approx(np.concatenate(motion(t)), abs=1e-9)
        assert (found[2:] < 0).all()
    x1, x2, v1, v2 = states(chain, [5.0])[0]
    assert [v1, v2] == pytest.approx([0, 0], abs=1e-8)
    assert max(abs(K @ [x1, x2])) <= F + 1e-9


def test_buck_with_idle_times_against_its_exact_pieces():
    """Each piece is linear: exponentials of matrices, and the root of the current."""
    buck = system("buck_discontinuous")
    p, cycles = buck.parameters, 5
    T, on = p["cycle"], p["duty"] * p["cycle"]
    leak = -1 / p["load"] / p["capacity"]
    A = np.array([[leak, 1 / p["capacity"]], [-1 / p["coil"], 0.0]])
    rest = -np.linalg.solve(A, [0.0, p["source"] / p["coil"]])  # where conduction leads to
    x, ends, jumps = np.array([7.0, 0.0]), [], []
    for n in range(cycles):
        x = rest + expm(A * on) @ (x - rest)
        until = brentq(lambda t, x=x: (expm(A * t) @ x)[1], 1e-8, T - on, xtol=1e-20)
        x = expm(A * until) @ x
        ends.append(n * T + on + until)
        # neighbours whose current ends later freewheel for longer, and idle for less
        saltation = np.eye(2) + np.outer([leak * x[0], 0.0] - A @ x, [0.0, 1.0]) / (A @ x)[1]
        decay = math.exp(leak * (T - on - until))
        jumps.append(np.diag([decay, 1.0]) @ saltation @ expm(A * (on + until)))
        x = np.array([x[0] * decay, 0.0])
    found = jp.simulate(buck, duration=cycles * T * (1 - 1e-12), at=[cycles * T * (1 - 1e-12)], rtol=1e-11)
    assert found.state_value.values[0] == pytest.approx([*x, 1.0, 0.0, 0.0, 1.0], abs=1e-9)
    times = np.sort([*ends, *(np.arange(cycles) * T + on), *(np.arange(1, cycles) * T)])
    assert found.event_time.values == pytest.approx(times, abs=1e-16)
    mapped = tangent_map(assemble(buck), T * (1 - 1e-12), 1e-12)
    assert mapped[:2, :2] == pytest.approx(jumps[0], abs=1e-8)


def test_a_relay_slides_to_rest_whatever_the_load():
    """v' = load - force up to line x + v = 0; along it x decays at the rate line, whatever the load."""
    relay = system("sliding_control")
    line, force, load = (relay.parameters[name] for name in ("line", "force", "load"))
    a = force - load  # line (1 - a t²/2) = a t
    meets = (-1 + math.sqrt(1 + 2 * line**2 / a)) / line
    x = 1 - a * meets**2 / 2
    found = jp.simulate(relay, duration=4.0, at=[0.5 * meets, 2.0, 4.0], rtol=1e-11)
    expected = [[1 - a * meets**2 / 8, -a * meets / 2]]
    expected += [[x * math.exp(-line * (t - meets)) * factor for factor in (1, -line)] for t in (2.0, 4.0)]
    assert found.state_value.values == pytest.approx(np.array(expected), abs=1e-10)
    assert found.event_time.values == pytest.approx([meets], abs=1e-11)
    h = 1e-200j  # by the load: a' = -1

    def end(a, line=line):
        meets = (-1 + (1 + 2 * line**2 / a) ** 0.5) / line
        return (1 - a * meets**2 / 2) * np.exp(-line * (4 - meets))

    slopes = [-end(a + h).imag / 1e-200, end(a, line + h).imag / 1e-200]
    known = jp.gradient(relay, of=["end:state:x"], by=["load", "line"], turns=4)
    assert known["derivative"].values[0] == pytest.approx(slopes, abs=1e-9)


def test_sliding_ends_where_one_side_no_longer_pushes_back():
    """x' = z + 1 - 2 s, z' = 1: from x = 0.3 to 0 at 1.5 - sqrt(1.65), along it until z = 1, then off it."""
    relay = jp.System(
        states={"x": 0.3, "z": -0.5},
        rates={"x": "z + 1 - 2*s", "z": "1"},
        switches=[{"name": "s", "on": "x", "slides": True}],
        outputs={"share": "s"},
    )
    found = jp.simulate(relay, duration=2.5, at=[1.0, 2.5], rtol=1e-11)
    assert found.event_time.values == pytest.approx([1.5 - math.sqrt(1.65), 1.5], abs=1e-11)
    assert found.state_value.values == pytest.approx(np.array([[0.0, 0.5, 0.75], [0.5, 2.0, 1.0]]), abs=1e-10)
    known = jp.gradient(relay, of=["end:state:x"], by=["initial.x", "initial.z"], turns=2)
    assert known["derivative"].values == pytest.approx(np.array([[0.0, 0.5]]), abs=1e-9)
    lost = jp.lyapunov(relay.replace(), turns=2, transient=0, exponents="all")
    assert lost.lyapunov_exponent.values[-1] == -math.inf


RELAYS = jp.System(
    states={"x": 0.5, "y": -0.6, "z": 0.0},
    parameters={"a": 0.3, "b": -0.2, "k": 0.0, "l": 0.0},
    rates={
        "x": "a - (2*s - 1) + k*(2*r - 1)",
        "y": "b - 1.5*(2*r - 1) + l*(2*s - 1)",
        "z": "x + y + s - 2*r",
    },
    switches=[{"name": "s", "on": "x", "slides": True}, {"name": "r", "on": "y", "slides": True}],
)


def relays(a, b, x, y, k, l, end):
    """When each begins to slide, and z at the end: rates are even in between. All may be complex."""
    e, s, r, z, time, times = np.array([x, y]), 1.0, -1.0, 0.0, 0.0, {}
    while len(times) < 2:
        rate = np.array([0.0 if 0 in times else a - s + k * r, 0.0 if 1 in times else b - 1.5 * r + l * s])
        left = {i: -e[i] / rate[i] for i in (0, 1) if i not in times}
        first = min(left, key=lambda i: left[i].real)
        span = left[first]
        z = z + span * (e.sum() + (1 + s) / 2 - (1 + r)) + span**2 * rate.sum() / 2
        e, time = e + span * rate, time + span
        times[first] = time
        if len(times) == 1:  # one keeps itself at 0 beside what the other does
            s, r = (a + k * r, r) if first == 0 else (s, (b + l * s) / 1.5)
    s, r = np.linalg.solve([[1, -k], [-l, 1.5]], [a, b])
    return [times[i] for i in sorted(times, key=lambda i: times[i].real)], z + (end - time) * (
        (1 + s) / 2 - (1 + r)
    )


@pytest.mark.parametrize(("k", "l"), [(0.0, 0.0), (0.4, -0.5)], ids=["alone", "coupled"])
def test_two_switches_slide_at_one_time(k, l):
    """Each keeps its own guard: (1, -k; -l, 1.5) (2s - 1, 2r - 1) = (a, b)."""
    system, given = RELAYS.replace(k=k, l=l), (0.3, -0.2, 0.5, -0.6)
    times, z = relays(*given, k, l, 2.0)
    found = jp.simulate(system, duration=2.0, at=[2.0], rtol=1e-11)
    assert found.event_time.values == pytest.approx(times, abs=1e-11)
    assert found.state_value.values == pytest.approx(np.array([[0, 0, z]]), abs=1e-10)
    h = 1e-200
    moved = [[v + 1j * h * (i == j) for i, v in enumerate(given)] for j in range(4)]
    slopes = [relays(*each, k, l, 2.0)[1].imag / h for each in moved]
    known = jp.gradient(system, of=["end:state:z"], by=["a", "b", "initial.x", "initial.y"], turns=2)
    assert known["derivative"].values[0] == pytest.approx(slopes, abs=1e-9)


@pytest.mark.parametrize("start", [[0.7, -1.3, 0.0], [0.0, 0.0, 0.0]], ids=["together", "from there"])
def test_two_switches_begin_to_slide_together(start):
    """At 1 both, x = 0.7 - 0.7 t and y = 1.3 t - 1.3; or at the start."""
    found = jp.simulate(RELAYS, duration=3.0, at=[3.0], rtol=1e-11, initial=start)
    both, before = (1.0, -0.3 + 1.0) if start[0] else (0.0, 0.0)
    z = before + (3 - both) * ((1 + 0.3) / 2 - (1 - 0.2 / 1.5))
    assert found.event_time.values == pytest.approx([both] * 2 if both else [], abs=1e-11)
    assert found.state_value.values == pytest.approx(np.array([[0, 0, z]]), abs=1e-10)


def test_sliding_ends_the_run_where_both_sides_come_to_lead_away():
    """x' = (1 - s) v - s u, u' = v' = -1: at 1 if u = v; else one side does first, and x = (t - 1)²/2."""
    fold = jp.System(
        states={"x": 0.0, "u": 1.0, "v": 1.0},
        rates={"x": "(1 - s)*v - s*u", "u": "-1", "v": "-1"},
        switches=[{"name": "s", "on": "x", "slides": True}],
    )
    found = jp.simulate(fold, duration=2.0, at=[0.5, 1.5], rtol=1e-11)
    assert Status(int(found.status)) == Status.CHATTER
    assert found.event_time.values == pytest.approx(np.ones(len(found.event_time)), abs=1e-9)
    assert found.time.values.tolist() == [0.5]
    beside = jp.simulate(fold, duration=2.0, at=[2.0], rtol=1e-11, initial=[0.0, 1.0, 1.0001])
    assert beside.state_value.values[0] == pytest.approx([0.5, -1.0, -0.9999], abs=1e-10)
