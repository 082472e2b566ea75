"""Periodic orbits and their multipliers: closed forms, a published orbit, exponents along the motion."""

import math
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.orbits import shooting
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.analysis.starts import placed
from tests.analysis.exact_maps import TAU, Symmetric
from tests.analysis.orbits.test_continuation_maps import Plain, square
from tests.support.wrong import problems_of

ROUNDING = 1e-11
LINKAGE = catalog.chunmei2002(gear_ratio=3.0)


def multipliers(found):
    """Complex, as stored."""
    return found.floquet_multiplier.values @ [1, 1j]


@pytest.mark.parametrize(("damping", "word"), [(-0.01, "unstable"), (0.0, "neutral"), (0.01, "stable")])
def test_an_orbit_that_neighbours_neither_approach_nor_leave_is_neutral(damping, word):
    """An oscillator: multipliers exp(-d T/2 ± i w T), on the unit circle but for rounding where d = 0."""
    rates = {"x": "v", "v": "0.1*cos(2.5*t) - x - d*v"}
    start = {"states": {"x": 0.0, "v": 0.0}, "parameters": {"d": damping}, "forcing": "2*pi/2.5"}
    found = jp.periodic_orbit(jp.System(name="oscillator", rates=rates, **start), transient=0)
    assert np.abs(multipliers(found)) == pytest.approx(math.exp(-damping * TAU / 5), rel=1e-7)
    assert jp.words(found).stable.item() == word
    assert f"period 1, {word}, largest" in str(jp.summary(found))


@pytest.mark.parametrize("restitution", [0.6, 0.8])
@pytest.mark.parametrize("place", [0.08, 0.3, 0.6, "at the section", 0.9999])
def test_symmetric_impacts(restitution, place):
    """Real, complex and nearly critical multipliers; an impact at the very time of the section."""
    k = (1 + restitution) / (1 - restitution)
    gap = math.pi * k if place == "at the section" else place * math.hypot(math.pi * k, 2)
    motion = Symmetric(gap, restitution)
    state = np.array(motion.at_zero)
    found = jp.periodic_orbit(catalog.impact_pair(gap, restitution), initial=list(0.999 * state), transient=0)
    assert int(found.status) == 0
    assert float(found.residual) < ROUNDING
    trace, determinant = motion.half_map
    known = np.roots([1, -trace, determinant]).astype(complex) ** 2
    for of in (np.sum, np.prod):  # the multipliers themselves are double where t0 = 0
        assert of(multipliers(found)) == pytest.approx(of(known), rel=1e-10)
    assert bool(found.stable == 1) == bool(np.all(np.abs(known) < 1))
    exponents = np.sort(np.log(np.abs(known)) / TAU)[::-1]
    assert found.lyapunov_exponent.values == pytest.approx(exponents, abs=1e-7)
    if place != "at the section":
        assert found.orbit_state.values == pytest.approx(state, rel=1e-9)
    times = np.sort(np.mod([motion.t0, motion.t0 + math.pi], TAU))
    away = np.mod(found.event_time.values[:, None] - times + math.pi, TAU) - math.pi
    assert np.all(np.min(np.abs(away), axis=1) < 1e-9)
    assert found.event_approach_speed.values == pytest.approx(motion.speed, rel=1e-9)
    assert float(found.smallest_impact_speed) == pytest.approx(motion.speed, rel=1e-9)
    if place != 0.08:  # there the mass nearly turns back before it reaches a wall
        assert math.isnan(float(found.closest_approach))
    assert float(found.impacts) == 2


@pytest.mark.parametrize(("frequency", "period", "given"), [(0.8, 2, 2), (1.0, 4, 4), (0.8, 2, 6)])
def test_gear_backlash(frequency, period, given):
    """Damping gives the multipliers' product; exponents are those along the motion; shortest period."""
    system = catalog.gear_backlash(0.1, 0.2, frequency, 0.05)
    found = jp.periodic_orbit(system, period=given)
    time = period * TAU / frequency
    assert (int(found.status), float(found.period)) == (0, period)
    assert float(found.period_time) == pytest.approx(time, rel=1e-13)
    assert np.prod(multipliers(found)).real == pytest.approx(math.exp(-0.1 * time), rel=1e-9)
    measured = jp.lyapunov(system, exponents="all", turns=60 * period, transient=300)
    assert found.lyapunov_exponent.values == pytest.approx(measured.lyapunov_exponent.values, abs=2e-5)


@pytest.mark.parametrize("tension", [True, False])
def test_soft_impacts(tension):
    """Kelvin-Voigt walls, whose force jumps at contact: exponents are those along the motion."""
    system = catalog.soft_impact_pair(2.0, 50.0, 4.0, tension=tension)
    found = jp.periodic_orbit(system)
    assert (int(found.status), int(found.stable), float(found.impacts)) == (0, 1, 2)
    measured = jp.lyapunov(system, exponents="all", turns=200, transient=100)
    assert found.lyapunov_exponent.values == pytest.approx(measured.lyapunov_exponent.values, rel=1e-6)


@pytest.mark.long
def test_shortest_orbit_of_lorenz():
    """Period after Viswanath, Physica D 190 (2004) 115: 1.5586522107161747; it is unstable."""
    section = jp.Plane(quantity="z", value=27.0, direction="up")
    found = jp.periodic_orbit(catalog.lorenz(), section, period=2)
    assert float(found.period_time) == pytest.approx(1.5586522107161747, abs=1e-12)
    assert float(found.orbit_state.sel(state="z")) == 27.0
    volume = math.exp(-(10 + 1 + 8 / 3) * float(found.period_time))
    assert np.prod(multipliers(found)).real == pytest.approx(volume, rel=1e-4)
    assert float(found.lyapunov_exponent[0]) > 0.9
    assert int(found.stable) == 0


def test_no_time_passes_to_the_section_on_which_an_orbit_stands():
    section = section_map(placed(catalog.slider_crank(clearance={"B": 1e-4}), None), jp.CrankAngle(), 1, 1e-8)
    state, status = shooting.on_section(section)
    orbit = shooting.newton(section, state)
    assert (status, orbit.status) == (0, 0)
    same, time = shooting.at_phase(orbit, orbit.map.phase)
    assert (same.tolist(), time) == (orbit.state.tolist(), 0.0)
    before, time = shooting.at_phase(orbit, orbit.map.phase - 0.1)
    assert time == pytest.approx(orbit.image.time * (1 - 0.1 / TAU))
    assert abs(before - orbit.state).max() > 1e-3


def test_linkage():
    """Figure 12b's motion: the flow's exponents but for the zero one; at any section the same multipliers."""
    found = jp.periodic_orbit(LINKAGE, transient=40, record=["journal_x", "mode"])
    assert int(found.status) == 0
    assert float(found.residual) < ROUNDING
    assert int(found.stable) == 1
    measured = jp.lyapunov(LINKAGE, exponents=3, turns=60, transient=60)
    assert np.abs(float(measured.lyapunov_exponent[0])) < 0.05
    along = measured.lyapunov_exponent.values[1:]
    assert found.lyapunov_exponent.values[:2] == pytest.approx(along, rel=2e-3)
    there = jp.periodic_orbit(LINKAGE, jp.CrankAngle(angle=2.0), transient=40)
    assert multipliers(there)[:2] == pytest.approx(multipliers(found)[:2], rel=1e-6)
    assert float(there.period_time) == pytest.approx(float(found.period_time), rel=1e-12)
    assert found.journal_x[0].values == pytest.approx(found.journal_x[-1].values, rel=1e-9)
    assert float(found.time[-1]) == pytest.approx(float(found.period_time), rel=1e-14)
    kinds = [EVENTS[kind] for kind in found.event_kind.values]
    assert kinds.count("contact") == kinds.count("separation") == 1


def test_derivative_of_the_linkage_s_section_map():
    """Against central differences of the map itself, the period being free."""
    found = jp.periodic_orbit(LINKAGE, transient=40)
    section = section_map(placed(LINKAGE, None, jp.CrankAngle()), jp.CrankAngle(), 1, 1e-13)
    state = found.orbit_state.values
    exact = section.image(state).derivative
    unknowns, columns = section.unknowns(state), []
    for size in 2e-8 * np.eye(len(unknowns)):
        ends = [section.image(section.state(unknowns + sign * size), False).state for sign in (1, -1)]
        columns.append(section.differ(*ends) / 4e-8)
    assert exact == pytest.approx(np.array(columns).T, abs=2e-4 * np.abs(exact).max())


@pytest.mark.parametrize("turns", [1, 3])
def test_a_state_comes_to_the_section_alike_with_its_derivative_and_without(turns):
    """Of a crank that a motor drives, whose passage is sought: the run that seeks it has the state there."""
    section = section_map(placed(LINKAGE, None, jp.CrankAngle(angle=1.0)), jp.CrankAngle(angle=1.0), turns)
    whole, plain = (section.image(section.model.state, derivative) for derivative in (True, False))
    assert plain.status == whole.status == 0
    assert np.abs(section.differ(plain.state, whole.state)).max() < ROUNDING
    assert plain.time == pytest.approx(whole.time, rel=1e-14)
    assert len(whole.events) > 5 * turns - 5
    assert plain.events == pytest.approx(whole.events, rel=1e-9, abs=1e-12)


def test_whole_turns_of_any_link_do_not_count():
    section = section_map(placed(LINKAGE, None, jp.CrankAngle()), jp.CrankAngle(), 1)
    state = section.model.state
    turned = state + np.array([math.tau, -math.tau, 2 * math.tau, 0.0, 0.0, 0.1])
    away = section.differ(turned, state)
    assert away[:4] == pytest.approx(0, abs=1e-14)
    assert away[4] > 0


@pytest.mark.nightly
def test_an_unstable_orbit_beside_a_stable_one():
    """Beyond a period doubling: the motion settles to the doubled orbit, Newton's method finds both."""
    mechanism = catalog.chunmei2002(4.65e-5, gear_ratio=3.0)
    single, double = (jp.periodic_orbit(mechanism, period=period) for period in (1, 2))
    assert [int(single.status), int(double.status)] == [0, 0]
    assert [float(single.period), float(double.period)] == [1, 2]
    assert [int(single.stable), int(double.stable)] == [0, 1]
    assert multipliers(single)[0].real < -1.01
    again = jp.periodic_orbit(mechanism, initial=list(1.0001 * single.orbit_state.values), transient=0)
    assert again.orbit_state.values == pytest.approx(single.orbit_state.values, rel=1e-9, abs=1e-11)


def test_an_orbit_that_is_exact_is_not_improved_and_none_can_be_changed():
    exact = Plain(square, 0.25)  # x' = x + 1/4 - x^2
    found = shooting.newton(exact, np.array([0.5]))
    assert (found.iterations, found.state.tolist()) == (0, [0.5])
    with pytest.raises(FrozenInstanceError):
        found.status = 1


def test_where_nothing_is_found_another_section_of_the_turn_is_tried(monkeypatch):
    tried, newton = [], shooting.newton

    def failing(section, *given, **how):
        tried.append(section.phase)
        found = newton(section, *given, **how)
        return found if len(tried) > 1 else replace(found, status=STATUS.index("not_converged"))

    monkeypatch.setattr(shooting, "newton", failing)
    found = jp.periodic_orbit(catalog.soft_impact_pair(2.0, 50.0, 4.0))
    assert found.status == 0
    assert (tried[1] - tried[0]) % TAU == pytest.approx(shooting.ASIDE * TAU)


def test_trouble_is_a_status():
    found = jp.periodic_orbit(LINKAGE, max_steps=5, record=["journal_x"])
    assert int(found.status) == 2
    assert np.all(np.isnan(found.floquet_multiplier))
    assert found.sizes["time"] == found.sizes["event"] == 0
    stopped = jp.periodic_orbit(catalog.duffing(), transient=3, period=1, max_iterations=1, tolerance=1e-15)
    assert int(stopped.status) == 4
    assert math.isnan(float(stopped.period))


SOUGHT = [
    (jp.periodic_orbit, {"period": 2}),
    (jp.continuation, {"period": 2, "parameter": "d", "range": [0.9, 1.1]}),
    (jp.gradient, {"turns": 2, "orbit": True}),
]


@pytest.mark.parametrize(("seek", "keywords"), SOUGHT, ids=["orbit", "branch", "gradient"])
def test_a_search_that_finds_nothing_does_not_say_that_a_step_failed(seek, keywords, monkeypatch):
    """x' = 1 + cos t comes back to no x; then a run that does fail, which its status tells."""
    own = {"states": {"x": 0.0}, "parameters": {"d": 1.0}, "rates": {"x": "d + cos(t)"}, "forcing": "2*pi"}
    system = jp.System(name="drifting", **own)
    found = seek(system, transient=2, **keywords)
    assert STATUS[int(found.status)] == "not_converged"
    first, *rest = str(jp.summary(found)).splitlines()
    assert "no periodic orbit of 2 turns was found" in first
    assert "transient" in first
    assert "step" not in first
    assert "did not reach its end" not in " ".join(rest)
    monkeypatch.setattr("jointplay.analysis.tangents.advance", lambda *_: STATUS.index("not_converged"))
    failed = seek(system, transient=2, **keywords)
    assert STATUS[int(failed.status)] == "not_converged"
    assert "a step could not be solved" in str(jp.summary(failed))
    assert "trouble" not in failed.attrs


@pytest.mark.parametrize(
    ("system", "keywords", "keys"),
    [
        (catalog.duffing(), {"period": 0, "tolerance": 2.0}, ["period", "tolerance"]),
        (catalog.duffing(), {"section": jp.ContactSection()}, ["section"]),
        (catalog.duffing(), {"section": jp.Plane(quantity="y", value=0.0)}, ["section"]),
        (catalog.lorenz(), {}, ["section"]),
        (catalog.lorenz(), {"section": jp.Plane(quantity="w", value=0.0)}, ["section.quantity"]),
        (LINKAGE, {"record": ["drive_work"], "max_iterations": 1.5}, ["max_iterations", "record[0]"]),
        (LINKAGE, {"initial": [0.0]}, ["initial"]),
    ],
)
def test_wrong_keywords(system, keywords, keys):
    assert list(problems_of(jp.periodic_orbit, system, **keywords)) == keys


def test_every_variable_says_what_it_is():
    found = jp.periodic_orbit(LINKAGE, transient=30, record=["journal_x"])
    lacking = [name for name, v in found.variables.items() if not {"units", "long_name"} <= v.attrs.keys()]
    assert set(lacking) <= {"joint"}


def test_an_equilibrium_is_no_orbit():
    """Lorenz' system rests at x = y = sqrt(beta (rho - 1)), z = rho - 1, on the section."""
    rest = [math.sqrt(72.0), math.sqrt(72.0), 27.0]
    section = jp.Plane(quantity="z", value=27.0, direction="up")
    found = jp.periodic_orbit(catalog.lorenz(), section, initial=rest, transient=0)
    assert int(found.status) != 0
    assert np.isnan(found.orbit_state).all()


def test_a_failed_search_gives_times_from_the_section_asked_for():
    """Newton's method is tried again on a section 0.2 turn on: times and state do not count from there."""
    system, state = catalog.impact_pair(3.6, 0.8), Symmetric(3.6, 0.8).at_zero
    keywords = {"initial": [0.999 * value for value in state], "transient": 0}
    found = jp.periodic_orbit(system, **keywords)
    failed = jp.periodic_orbit(system, max_iterations=1, tolerance=1e-15, **keywords)
    assert (int(found.status), int(failed.status)) == (0, 4)
    assert failed.event_time.values == pytest.approx(found.event_time.values, abs=0.02)
    assert failed.orbit_state.values == pytest.approx(found.orbit_state.values, abs=0.02)


@pytest.mark.long
def test_multipliers_of_a_quiet_motion_do_not_hang_on_the_tolerance():
    """The journal stays pressed; neighbours roll to and fro in the bearing, many times within a step."""
    quiet, found = catalog.chunmei2002(clearance=1e-6, friction=0.0, gear_ratio=3.0), []
    for rtol in (1e-7, 1e-10):
        pair = jp.periodic_orbit(quiet, rtol=rtol, transient=30).floquet_multiplier.values[0]
        found.append(float(np.hypot(*pair)))
    assert found[0] == pytest.approx(found[1], rel=1e-3)
