"""Neighbours that part at known rates, and fields of exponents against differences of the map."""

import math
from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import rules
from jointplay.analysis.exponents.growth import Turn
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.rules import on_section
from jointplay.analysis.states import start_plane
from jointplay.analysis.states.sensitivity import fit_growth, stretch
from jointplay.analysis.states.start_plane import Starts
from jointplay.analysis.tangents import scales
from jointplay.display.errors import InputError
from tests.analysis.exact_maps import TAU, Symmetric, strobed
from tests.support.wrong import problems_of

CHAOTIC = {
    "impact pair": (catalog.impact_pair(0.4, 0.8), 0.23792),
    "lorenz": (catalog.lorenz(), 0.9056),
}
JOURNAL = {"eccentricity_ratio_x": [-0.4, 0.0, 0.3], "eccentricity_ratio_y": [-0.2, 0.5]}


def linkage(**changes):
    return catalog.chunmei2002(**{"clearance": 2.9e-4, "gear_ratio": 3.0} | changes)


DRIVEN = catalog.chunmei2002(2.9e-4, speed=80.0)


@pytest.mark.parametrize(("mechanism", "speed"), [(linkage(), None), (DRIVEN, 80.0)])
def test_the_crank_is_seen_where_it_is_a_state_and_where_the_drive_holds_it(mechanism, speed):
    starts = Starts(mechanism, {"crank_angle": 0.7}, ("crank_angle", "crank_speed"))
    states = starts.model.state + np.arange(3.0)[:, None]
    seen = starts.projected(states)
    assert seen.shape == (3, 2)
    if speed is None:
        assert seen[:, 0].tolist() == states[:, starts.states.index("theta_crank")].tolist()
        assert seen[:, 1].tolist() == states[:, starts.states.index("w_crank")].tolist()
    else:
        assert seen == pytest.approx(np.tile([0.7, speed], (3, 1)))


@pytest.mark.parametrize("name", CHAOTIC)
def test_chaotic_neighbours_part_at_the_largest_exponent(name):
    system, exponent = CHAOTIC[name]
    found = jp.sensitivity(system, transient=60, turns=40, neighbours=3, references=30)
    rate, error = float(found.growth_rate), float(found.growth_rate_standard_error)
    assert abs(rate - exponent) < 3 * error
    assert error < 0.12 * exponent
    assert float(found.growth) == pytest.approx(rate * (system.period or 1.0))
    size = np.sqrt(np.mean(found.distance.values[..., -1] ** 2))
    assert float(found.saturation) == pytest.approx(size, rel=0.9)


def test_neighbours_of_a_stable_motion_come_closer_to_the_accuracy_of_the_runs():
    start = strobed(3.6, 0.8, (2.0, -1.8, 0.5), 1)
    system = catalog.impact_pair(3.6, 0.8)
    found = jp.sensitivity(system, initial=start, transient=60, turns=60, distance=1e-5)
    growth, error = float(found.growth), float(found.growth_standard_error)
    assert abs(growth - 2 * math.log(0.8)) < 3 * error < 0.2
    assert float(found.saturation) < 1e-10
    assert found.distance.values[:, :, 0] == pytest.approx(np.full((1, 20), 1e-5), rel=1e-6)
    first, last = found.fit_turns.values[0]
    assert 2 <= first < last < 40
    line = found.fitted_log_distance.values
    assert np.flatnonzero(np.isfinite(line)).tolist() == list(range(int(first), int(last) + 1))


def test_a_neighbour_is_a_motion_of_its_own():
    """Each distance is that of two runs of `poincare`."""
    system = catalog.duffing()
    found = jp.sensitivity(system, turns=5, neighbours=1, distance=1e-3, seed=7)
    away = np.random.default_rng(7).standard_normal((1, 2))[0]
    unit = scales(Starts(system, None, ("y", "v")).model)
    starts = (system.initial, system.initial + 1e-3 * away / np.linalg.norm(away) * unit)
    runs = [jp.poincare(system, turns=5, rtol=1e-12, initial=start).state_value.values for start in starts]
    apart = np.linalg.norm((runs[1] - runs[0]) / unit, axis=1)
    assert found.distance.values[0, 0, 1:] == pytest.approx(apart, rel=1e-6)


def test_at_equal_times_and_at_equal_phase_a_forced_system_is_the_same():
    one, other = (
        jp.sensitivity(catalog.duffing(), turns=6, neighbours=2, compare=c) for c in ("section", "time")
    )
    assert one.distance.values == pytest.approx(other.distance.values, rel=1e-2)


def test_at_equal_times_a_linkage_keeps_a_difference_along_its_motion():
    mechanism = linkage(clearance=2.9e-5)
    keywords = {"transient": 40, "turns": 14, "neighbours": 3, "distance": 1e-6, "rtol": 1e-11}
    angle, time = (jp.sensitivity(mechanism, compare=c, **keywords) for c in ("section", "time"))
    assert float(angle.growth) == pytest.approx(-1.48, abs=0.02)
    assert float(time.distance[0, :, -1].min()) > 1e-8 > float(angle.distance[0, :, -1].max()) * 100


def test_samples_within_a_turn_hold_those_at_its_ends():
    mechanism = linkage()
    coarse, fine = (
        jp.sensitivity(mechanism, turns=2, neighbours=2, distance=1e-6, samples_per_turn=n) for n in (1, 4)
    )
    assert fine.turn.values.tolist() == [i / 4 for i in range(9)]
    assert fine.distance.values[..., ::4] == pytest.approx(coarse.distance.values, rel=1e-3)


def walks(drift, spread, count, seed, turns, level):
    """Random walks with drift that stay where they reach a level."""
    steps = np.random.default_rng(seed).normal(drift, spread, size=(count, turns))
    return np.minimum(np.concatenate([np.zeros((count, 1)), np.cumsum(steps, axis=1)], axis=1), level)


@pytest.mark.parametrize("level", [12.0, 60.0])
def test_the_growth_of_random_walks_has_an_honest_error_and_no_bias(level):
    fits = [fit_growth(walks(1.0, 0.8, 20, seed, 120, level), 1) for seed in range(200)]
    off = np.array([(fit.growth - 1.0) / fit.error for fit in fits])
    assert np.mean(np.abs(off) < 3) > 0.97
    assert np.std(off) == pytest.approx(1.0, abs=0.25)
    assert np.mean([fit.growth for fit in fits]) == pytest.approx(1.0, abs=0.03)
    assert all(fit.level == level for fit in fits)


def test_a_straight_line_has_its_slope_and_stays_nowhere():
    fit = fit_growth(np.array([np.arange(30.0) * 0.5 - 20]), 2)
    assert (fit.growth, fit.error) == (pytest.approx(1.0), pytest.approx(0.0, abs=1e-12))
    assert math.isnan(fit.level)
    assert fit.ranges.tolist() == [[4, 28]]


def test_a_swing_that_comes_back_hardly_widens_the_error():
    swing = np.array([-0.3 * np.arange(40) + np.tile([0.0, 2.0, 1.0, 0.0], 10)])
    assert fit_growth(swing, 1).error < 0.15
    assert math.isnan(fit_growth(swing[:, :4], 1).growth)


def differences(model, turns, step=1e-8):
    """Logarithm of the largest stretch of the section's map, by central differences."""
    turn, unit = Turn(model, 1e-13), scales(model)
    free = [i for i in range(len(unit)) if i != turn.crank]
    rows = []
    for i in free:
        h = step * unit[i] * np.eye(len(unit))[i]
        rows.append(((turn(model.state + h, turns)[0] - turn(model.state - h, turns)[0]) / unit)[free])
    return math.log(np.linalg.norm(np.array(rows) / (2 * step), 2))


@pytest.mark.parametrize(
    "mechanism", [linkage(), pytest.param(DRIVEN, marks=pytest.mark.nightly)], ids=["motor", "speed"]
)
def test_exponents_of_the_linkage_are_those_of_differences(mechanism):
    plane = {"eccentricity_ratio_x": [-0.4, 0.3], "eccentricity_ratio_y": [-0.2, 0.5]}
    found = jp.sensitivity(mechanism, plane=plane, turns=1, rtol=1e-10, n_jobs=1)
    starts = Starts(mechanism, None, tuple(plane))
    for i, x in enumerate(plane["eccentricity_ratio_x"]):
        for j, y in enumerate(plane["eccentricity_ratio_y"]):
            exact = differences(starts((x, y)), 1)
            assert float(found.finite_time_exponent_per_turn[i, j]) == pytest.approx(exact, abs=2e-3)
    turn = starts.model.period
    assert found.finite_time_exponent.values * turn == pytest.approx(
        found.finite_time_exponent_per_turn.values, rel=1e-2
    )


def test_a_difference_along_the_motion_does_not_hide_its_stability():
    """At equal crank angle all differences die; at equal times one would stay."""
    model = Starts(linkage(clearance=2.9e-5), None, ("eccentricity_ratio_x", "eccentricity_ratio_y")).model
    settled = replace(model, state=Turn(model, 1e-12)(model.state, 30)[0])
    logs = [stretch(settled, turns, 1e-11)[0] for turns in (5, 10, 20)]
    assert logs[0] == pytest.approx(differences(settled, 5, 1e-6), abs=0.02)
    assert np.diff(logs) / [5, 10] == pytest.approx([-1.477, -1.477], abs=0.01)


def test_crank_angle_and_speed_make_a_plane():
    mechanism = linkage()
    plane = {"crank_angle": [0.3, 2.0], "crank_speed": [60.0, 80.0]}
    found = jp.sensitivity(mechanism, plane=plane, turns=1, rtol=1e-10, n_jobs=1)
    model = Starts(mechanism, None, tuple(plane))((2.0, 60.0))
    assert float(found.finite_time_exponent_per_turn[1, 0]) == pytest.approx(differences(model, 1), abs=2e-3)
    assert found.crank_angle.attrs["units"] == "rad"


def test_exponents_about_a_stable_motion():
    """Powers of the exact map over one period; in the long run, the logarithm of its multipliers."""
    motion = Symmetric(3.6, 0.8)
    y, v = motion.at_zero
    plane = {"y": [y, y + 1e-3], "v": [v, v + 1e-3]}
    found = jp.sensitivity(catalog.impact_pair(3.6, 0.8), plane=plane, turns=40, rtol=1e-11, n_jobs=1)
    steps = 1e-6 * np.eye(2)
    ends = [
        [np.array(strobed(3.6, 0.8, (0.0, *(motion.at_zero + s * d)), 1)) for s in (1, -1)] for d in steps
    ]
    M = np.stack([(ahead - behind) / 2e-6 for ahead, behind in ends], -1)
    exact = math.log(np.linalg.norm(np.linalg.matrix_power(M, 40), 2)) / 40
    values = found.finite_time_exponent_per_turn.values
    assert values[0, 0] == pytest.approx(exact, abs=1e-5)
    assert values == pytest.approx(np.full((2, 2), 2 * math.log(0.8)), abs=0.02)
    assert found.finite_time_exponent.values == pytest.approx(values / TAU, rel=1e-12)


def journal(state, lengths=(0.181, 0.1175, 0.03), ground=0.2):
    """The journal's place and velocity in its bearing, from the links' angles (crank, coupler, rocker)."""
    (crank, coupler, rocker), speeds = state[:3], state[3:]
    arms = np.array([lengths[2], lengths[0], -lengths[1]])
    e = np.exp(1j * np.array([crank, coupler, rocker]))
    place, velocity = arms @ e - ground, arms @ (1j * e * speeds)
    return place.real, place.imag, velocity.real, velocity.imag


def test_a_start_puts_the_journal_where_it_is_asked_to_be():
    starts = Starts(linkage(), None, ("eccentricity_ratio_x", "journal_velocity_y"))
    model = starts((0.6, -0.25))
    x, y, u, w = journal(model.state)
    assert (x / 2.9e-4, y / 2.9e-4) == pytest.approx((0.6, 0.0), abs=1e-8)
    assert (u, w) == pytest.approx((0.0, -0.25), abs=1e-10)
    assert model.state[[0, 3]].tolist() == starts.model.state[[0, 3]].tolist()
    assert starts.projected(model.state[None, :])[0] == pytest.approx([0.6, -0.25])


def test_a_prescribed_crank_moves_the_journal_too():
    model = Starts(DRIVEN, {"crank_angle": 0.7}, ("journal_velocity_x", "eccentricity_ratio_y"))((0.1, -0.3))
    coupler, rocker, w_coupler, w_rocker = model.state
    found = journal(np.array([0.7, coupler, rocker, 80.0, w_coupler, w_rocker]))
    assert found == pytest.approx((0.0, -0.3 * 2.9e-4, 0.1, 0.0), abs=1e-9)


def test_a_start_outside_the_bearing_or_beyond_a_wall_is_a_status():
    plane = {"eccentricity_ratio_x": [0.0, 0.8], "eccentricity_ratio_y": [0.0, 0.7]}
    found = jp.sensitivity(linkage(), plane=plane, turns=1, rtol=1e-6, n_jobs=1)
    assert [[STATUS[s] for s in row] for row in found.node_status.values] == [
        ["ok", "ok"],
        ["ok", "bad_parameters"],
    ]
    assert np.isnan(found.finite_time_exponent.values).tolist() == [[False, False], [False, True]]
    assert int(found.status) == 0
    walls = jp.sensitivity(
        catalog.impact_pair(1.0, 0.8), plane={"y": [0.0, 0.6], "v": [0.1, 1]}, turns=1, n_jobs=1
    )
    assert walls.node_status.values.tolist() == [[0, 0], [STATUS.index("bad_parameters")] * 2]


def test_a_crank_angle_at_which_the_linkage_cannot_close_is_a_status():
    """A crank as long as 0.14 m: at angle 0, coupler and rocker are too unequal to meet."""
    mechanism = linkage()
    links = [
        dict(link) | {"length": 0.14} if link.name == "crank" else dict(link) for link in mechanism.links
    ]
    joints = [dict(joint) for joint in mechanism.joints]
    joints[1]["journal"] = {"link": "crank", "at": 0.14}
    wide = type(mechanism)(**dict(mechanism) | {"links": links, "joints": joints})
    plane = {"crank_angle": [0.0, 1.0], "crank_speed": [5.0, 6.0]}
    found = jp.sensitivity(wide, plane=plane, turns=1, initial={"crank_angle": 1.0}, max_steps=5, n_jobs=1)
    assert [[STATUS[s] for s in row] for row in found.node_status.values] == [
        ["bad_parameters", "bad_parameters"],
        ["step_limit", "step_limit"],
    ]


@pytest.mark.nightly
def test_workers_do_not_change_the_answer():
    plane = {"y": {"start": -1.5, "stop": 1.5, "num": 12}, "v": {"start": -1.0, "stop": 1.0, "num": 12}}
    one, two = (jp.sensitivity(catalog.duffing(), plane=plane, turns=2, rtol=1e-8, n_jobs=n) for n in (1, 2))
    assert one.drop_vars("wall_time").identical(two.drop_vars("wall_time"))
    assert "distance" not in one


def test_trouble_is_a_status():
    found = jp.sensitivity(linkage(), turns=5, max_steps=20, neighbours=2)
    assert STATUS[int(found.status)] == "step_limit"
    assert math.isnan(float(found.growth))
    early = jp.sensitivity(linkage(), turns=5, transient=5, max_steps=20, neighbours=2)
    assert early.neighbour_status.values.tolist() == [[2, 2]]
    field = jp.sensitivity(linkage(), turns=1, plane=JOURNAL, max_steps=20, n_jobs=1)
    assert STATUS[int(field.status)] == "step_limit"


def test_neighbours_that_stay_where_they_are_are_no_failed_steps(monkeypatch):
    """x' = 1 + cos t keeps every difference: there is no growth to measure, and no step fails."""
    own = {"states": {"x": 0.0}, "parameters": {"d": 1.0}, "rates": {"x": "d + cos(t)"}, "forcing": "2*pi"}
    system, keywords = jp.System(name="drifting", **own), {"turns": 9, "neighbours": 2}
    found = jp.sensitivity(system, **keywords)
    assert STATUS[int(found.status)] == "not_converged"
    assert not found.neighbour_status.values.any()
    assert "no growth was found" in str(jp.summary(found))
    assert "step" not in str(jp.summary(found))
    follow = rules.follow
    short = {"status": STATUS.index("not_converged"), "sections": np.zeros((0, 9))}
    monkeypatch.setattr(rules, "follow", lambda *given: replace(follow(*given), **short))
    assert "a step could not be solved" in str(jp.summary(jp.sensitivity(system, **keywords)))


def test_a_stretch_does_not_overflow():
    system = catalog.impact_pair(0.4, 0.8)
    log, _, status = stretch(Starts(system, (0.1, 0.3), ("y", "v")).model, 600, 1e-8)
    assert status == 0
    assert log == pytest.approx(600 * TAU * 0.23792, rel=0.1)
    assert log > math.log(1e300)


def test_every_problem_is_told_at_once():
    plane = {"eccentricity_ratio_x": {"start": 1, "stop": 0, "num": 5}, "jornal_y": [0.0, 1.0]}
    with pytest.raises(InputError) as caught:
        jp.sensitivity(
            linkage(),
            plane=plane,
            turns=0,
            distance=2,
            seed=-1,
            compare="angle",
            joint="A",
            samples_per_turn=0,
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {
        *("turns", "distance", "seed", "compare", "joint", "samples_per_turn"),
        *("plane.eccentricity_ratio_x", "plane.jornal_y"),
    }


@pytest.mark.parametrize(
    ("system", "options", "key"),
    [
        (catalog.lorenz(), {"compare": "section"}, "compare"),
        (catalog.lorenz(), {"neighbours": 0}, "neighbours"),
        (catalog.lorenz(), {"references": 0}, "references"),
        (catalog.duffing(), {"plane": {"y": [0, 1]}}, "plane"),
        (catalog.duffing(), {"plane": {"y": [0, 1], "v": [1, 0]}}, "plane.v"),
        (catalog.duffing(), {"plane": {"y": [0, 1], "v": [0, 1]}, "transient": 3}, "transient"),
        (linkage(), {"plane": {"eccentricity_ratio_x": [0, 1], "w_crank": [0, 1]}}, "plane.w_crank"),
        (DRIVEN, {"plane": {"eccentricity_ratio_x": [0, 1], "crank_speed": [0, 1]}}, "plane.crank_speed"),
    ],
)
def test_wrong_keywords(system, options, key):
    assert list(problems_of(jp.sensitivity, system, **options)) == [key]


@pytest.mark.nightly
def test_of_two_joints_with_clearance_one_is_to_be_named():
    model = on_section(linkage(), None)
    bearing = model.structure.joints[0]
    two = replace(model.structure, joints=(bearing, replace(bearing, name="C")))
    loose = replace(model, structure=two, joints=("B", "C"))
    plane = {"eccentricity_ratio_x": [0, 1], "eccentricity_ratio_y": [0, 1]}
    (problem,) = start_plane.plane_fits(linkage(), plane, None, None, loose)
    assert problem.key == "joint"
    assert problem.expected.endswith("one of B, C")


def test_every_variable_says_what_it_is():
    plane = {"y": [0.0, 0.5], "v": [0.0, 0.5]}
    found = jp.sensitivity(catalog.duffing(), plane=plane, neighbours=2, turns=3)
    assert {"distance", "finite_time_exponent", "y"} <= set(found.variables)
    assert all({"units", "long_name"} <= variable.attrs.keys() for variable in found.variables.values())


def test_the_next_reference_is_where_the_motion_has_got_to():
    both = jp.sensitivity(catalog.duffing(), turns=6, neighbours=1, references=2)
    later = jp.sensitivity(catalog.duffing(), turns=6, neighbours=2, transient=6)
    assert both.distance.values[1, 0] == pytest.approx(later.distance.values[0, 1], rel=1e-2)


def test_of_every_reference_the_first_turn_is_a_whole_one():
    found = jp.sensitivity(linkage(clearance=2.9e-5), turns=1, neighbours=1, references=2).distance
    assert np.all(np.abs(found[..., 1] / found[..., 0] - 1) > 0.1)


def test_a_journal_s_place_is_in_metres_and_over_the_clearance_it_has_another_name():
    mechanism, e = linkage(clearance=2.9e-4), 2.9e-4
    ratio = np.array([[0.3, -0.4], [0.0, 0.9]])
    by_ratio = Starts(mechanism, None, ("eccentricity_ratio_x", "eccentricity_ratio_y"))
    by_place = Starts(mechanism, None, ("journal_x", "journal_y"))
    one, other = (
        np.array([m.state for m in starts.all(at)])
        for starts, at in ((by_ratio, ratio), (by_place, e * ratio))
    )
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(by_place.projected(one), e * ratio, atol=1e-12)
    for (x, y), model in zip(e * ratio, by_place.all(e * ratio), strict=True):
        names = ("theta_crank", "theta_coupler", "theta_rocker")
        angles = dict(zip(("crank", "coupler", "rocker"), model.state[:3], strict=True))
        assert set(names) <= set(by_place.states)
        speeds = dict(zip(angles, model.state[3:6], strict=True))
        start = {"angle": angles, "angular_velocity": speeds}
        motion = jp.simulate(mechanism, turns=1e-3, initial=start, record=["journal_x", "journal_y"])
        assert (float(motion.journal_x[0, 0]), float(motion.journal_y[0, 0])) == pytest.approx(
            (x, y), abs=1e-12
        )
    assert by_place.axes({"journal_x": ratio, "journal_y": ratio})["journal_x"][2]["units"] == "m"


@pytest.mark.parametrize(
    ("plane", "keys"),
    [
        ({"journal_x": [-1.0, 1.0], "crank_angle": [0.0, 1.0]}, ["plane.journal_x"]),
        (
            {"journal_x": {"start": -0.5, "stop": 0.5, "num": 5}, "crank_angle": [0.0, 1.0]},
            ["plane.journal_x"],
        ),
        ({"eccentricity_ratio_x": [-2e-4, 2e-4], "journal_y": [0.0, 1e-4]}, ["plane.eccentricity_ratio_x"]),
        ({"eccentricity_ratio_y": [0.0, 290.0], "journal_x": [0.0, 1e-4]}, ["plane.eccentricity_ratio_y"]),
        ({"journal_x": [0.0, 1e-4], "eccentricity_ratio_x": [0.0, 0.5]}, ["plane.journal_x"]),
        ({"journal_x": [-3e-4, 3e-4], "eccentricity_ratio_y": [-1.2, 1.2]}, []),
    ],
)
def test_a_plane_in_the_unit_of_the_other_word_is_refused(plane, keys):
    mechanism = linkage(clearance=2.9e-4)
    problems = start_plane.plane_fits(mechanism, plane, None, None, on_section(mechanism, None))
    assert [problem.key for problem in problems] == keys
    assert all("it is " in p.expected or "the same" in p.expected for p in problems)


def test_a_region_in_the_unit_of_the_other_word_is_refused():
    with pytest.raises(InputError, match="over the clearance it is eccentricity_ratio_x"):
        jp.tipping(linkage(clearance=2.9e-4), region={"journal_x": (-0.5, 0.5)})
