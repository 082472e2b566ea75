"""Assessments: each number against another way to it; edges against motions and orbits on their two sides."""

from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment import assess
from jointplay.analysis.assessment.branch_walk import Branch
from jointplay.analysis.assessment.edges import HOW, Search, edges
from jointplay.analysis.assessment.forces import forces
from jointplay.analysis.assessment.settled import CHANGES, Settled, followed, plan, present
from jointplay.display.errors import InputError
from jointplay.solver.motion.progress import OutOfTime
from tests.support import unshown
from tests.support.wrong import problems_of

LOOSE = jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0)
BRIEF = plan(60, 40, 60, 1e-7, None)


def one_side(mechanism, key, side, reach, step=0.0025, how=BRIEF):
    """What is found on one side, by change: edge, error, low, high and how."""
    found = edges(present(mechanism, None, how), key, side, Search(reach, step, 2e-3, 1e-6), how)
    assert found["status"] == 0
    rows = (found[name] for name in ("edge", "error", "low", "high", "how"))
    return {name: row for name, *row in zip(CHANGES, *rows, strict=True)}, found["limit"]


def described(period, **more):
    values = {"period": ((), period), "contact_fraction": (("joint",), [1.0, 1.0])} | more
    return Settled(None, None, values).traits


def exponent(value, error, follows):
    names = ("section_exponent_per_turn", "section_standard_error_per_turn", "section_batch_correlation")
    given = zip(names, (value, error, follows), strict=True)
    return {name: (("multiplier",), [each]) for name, each in given}


def test_a_motion_is_chaotic_only_without_period_and_by_three_errors():
    assert described(1) == {"contact_loss": False, "doubling": False, "chaos": False}
    assert described(2)["doubling"]
    assert described(1, contact_fraction=(("joint",), [1.0, 0.99]))["contact_loss"]
    assert described(0, **exponent(1.0, 0.32, 0.1))["chaos"]
    assert not described(0, **exponent(1.0, 0.34, 0.1))["chaos"]
    assert described(0, **exponent(1.0, 0.1, 0.4))["chaos"]
    assert not described(0, **exponent(1.0, 0.1, 0.9))["chaos"]
    assert not described(3, **exponent(1.0, 0.1, 0.1))["chaos"]


@pytest.mark.parametrize("way", [-1, 1])
@pytest.mark.parametrize("begin", [2.9e-5, -40.0])
def test_values_reach_from_the_present_one_in_even_steps_no_longer_than_asked(way, begin):
    values = Search(2.0, 0.01, 1e-3).values(begin, way)
    every = np.array([begin, *values])
    assert every[-1] == pytest.approx(begin * 2.0**way)
    ratios = (every[1:] / every[:-1]) ** way
    assert ratios == pytest.approx(ratios[0])
    assert 1.009 < ratios[0] <= 1.01


@pytest.mark.long
def test_the_edge_of_contact_is_where_the_separation_ends():
    """Against motions at a tighter tolerance a thousandth beside it."""
    found, limit = one_side(LOOSE.replace(clearance=2.35e-5), "joints.B.clearance", "below", 1.06)
    edge, error, low, high, how = found["contact_loss"]
    assert HOW[int(how)] == "grazing"
    assert error < 1e-6 * edge
    assert low <= edge <= high
    assert high - low < 0.01 * edge
    beside = {"joints.B.clearance": [0.999 * edge, 1.001 * edge]}
    sweep = jp.bifurcation(LOOSE, over=beside, turns=20, transient=100, rtol=1e-8, n_jobs=1)
    assert sweep["separations"].values.ravel().tolist() == [0.0, 1.0]
    assert np.isnan(found["chaos"][0])
    assert limit == pytest.approx(2.35e-5 / 1.06)


@pytest.mark.nightly
def test_the_edge_of_period_1_is_where_the_multiplier_is_minus_1():
    """Over the gear ratio, which changes the nominal speed; against orbits found beside it."""
    found, _ = one_side(LOOSE.replace(gear_ratio=3.5), "gear_ratio", "above", 1.05)
    edge, error, low, high, how = found["doubling"]
    assert HOW[int(how)] == "period_doubling"
    assert error < 1e-6 * edge
    assert low <= edge <= high
    for factor, stable in ((1 - 1e-4, 1), (1 + 1e-4, 0)):
        orbit = jp.periodic_orbit(LOOSE.replace(gear_ratio=factor * edge), rtol=1e-10)
        assert int(orbit["stable"]) == stable
        assert float(orbit["floquet_multiplier"][0, 0]) == pytest.approx(-1.0, abs=0.005)


@pytest.mark.nightly
def test_a_window_narrower_than_a_step_is_met():
    """Doubled from 26.659 down to 26.63 µm, a tenth of a percent: no edge, but a window."""
    slow = LOOSE.replace(gear_ratio=15.0, clearance=2.6737e-5)
    here, search = present(slow, None, BRIEF), Search(1.00499, 0.0025, 2e-3)
    found = edges(here, "joints.B.clearance", "below", search, BRIEF)
    assert np.isnan(found["edge"]).all()
    ((low, high, _),) = found["windows"]
    assert low == pytest.approx(2.663e-5, rel=1e-3)
    assert high == pytest.approx(2.66585e-5, rel=1e-5)
    orbit = jp.periodic_orbit(slow.replace(clearance=high), rtol=1e-10)
    assert float(orbit["floquet_multiplier"][0, 0]) == pytest.approx(-1.0, abs=1e-3)
    edge = edges(here, "joints.B.clearance", "below", replace(search, lasting=1e-5), BRIEF)
    assert edge["edge"][CHANGES.index("doubling")] == pytest.approx(high)


@pytest.mark.nightly
def test_a_window_ends_where_the_orbit_is_stable_again():
    """Doubled over 0.99 % of the clearance, about values looked at that lie 1.003 % apart."""
    here = present(unshown.TEN["quiet crank-rocker"](), None, BRIEF)
    ((low, high, _),) = edges(here, "joints.B.clearance", "below", Search(1.05, 0.0025, 1e-3), BRIEF)[
        "windows"
    ]
    assert high / low < 1.01
    for value in (low, high):
        orbit = jp.periodic_orbit(here.mechanism.replace(clearance=value), rtol=1e-10)
        assert float(orbit["floquet_multiplier"][0, 0]) == pytest.approx(-1.0, abs=0.005)


@pytest.mark.nightly
def test_what_follows_an_orbit_that_is_not_found_farther_on_says_whether_it_changes():
    """Of period 2 from 1.0162 to 1.0248 times the clearance, by stick and slip: 0.9 %, a window."""
    here, key = present(unshown.TEN["quiet crank-rocker"](), None, BRIEF), "joints.B.clearance"
    found = edges(here, key, "above", search := Search(1.04, 0.0025, 1e-3), BRIEF)
    assert np.isnan(found["edge"]).all()
    ((low, high, period),) = found["windows"]
    assert (low, high) == pytest.approx((1.016 * 4e-5, 1.025 * 4e-5), rel=2e-3)
    assert period == 2
    found = edges(here, key, "above", replace(search, lasting=5e-3), BRIEF)
    low, high = (found[name][CHANGES.index("doubling")] for name in ("low", "high"))
    assert high - low < 2e-3 * high
    sweep = jp.bifurcation(here.mechanism, over={key: [low, high]}, turns=20, transient=100, n_jobs=1)
    assert np.ravel(sweep["period"]).tolist() == [1, 2]


@pytest.mark.long
def test_motions_go_on_from_where_they_are_said_to_stand():
    """To what an orbit errs by that is not run through again."""
    found = jp.assess(LOOSE, along=["gear_ratio"], reach=1.01, budget=1e6, n_jobs=1).isel(parameter=0)
    for side, count in found["values_looked_at"].groupby("side"):
        assert count.item() >= 2
        for i in range(count.item()):
            place = found.sel(side=side).isel(looked=i)
            there = LOOSE.varied({"gear_ratio": float(place["looked_ratio"] * found["present_value"])})
            turns, state = int(place["looked_period"]), place["looked_state"]
            end = jp.simulate(there, initial=state, turns=turns, rtol=1e-10)["end_state"]
            change = (end.sel(state=state["state"]) - state).values
            change -= 2 * np.pi * np.round(change / (2 * np.pi))
            assert change == pytest.approx(np.zeros(6), abs=2e-4)


@pytest.mark.nightly
def test_smaller_rigid_bearings_are_looked_at():
    """What lies on the face of the larger one is outside; a direct run at the last value says the same."""
    here, key = present(unshown.TEN["rigid slider"](), None, BRIEF), "joints.B.clearance"
    found = edges(here, key, "below", Search(1.02, 0.005, 2e-3), BRIEF)
    assert found["status"] == 0, found["trouble"]
    assert found["looked"].min() == found["limit"] == pytest.approx(2e-4 / 1.02)
    run = jp.bifurcation(here.mechanism, over={key: [found["limit"]]}, turns=20, transient=100, n_jobs=1)
    assert found["periods"][-1] == int(run["period"].item())


@pytest.mark.nightly
def test_an_orbit_of_period_2_ends_where_it_closes_after_one_turn():
    """Back at period 1 the orbit found over two turns is that of one turn, twice."""
    here, key = present(unshown.TEN["crank-rocker with two plays"](), None, BRIEF), "joints.A.clearance"
    assert here.period == 2
    found = edges(here, key, "below", Search(1.03, 0.0025, 1e-3), BRIEF)
    low, high = (found[name][CHANGES.index("doubling")] for name in ("low", "high"))
    assert high - low < 2e-3 * high
    run = jp.bifurcation(
        here.mechanism, over={key: [low * 0.998, high * 1.002]}, turns=20, transient=300, n_jobs=1
    )
    assert np.ravel(run["period"]).tolist() == [1, 2]


@pytest.mark.long
def test_an_orbit_that_is_not_found_once_more_is_carried(monkeypatch):
    monkeypatch.setattr(Branch, "first", lambda *_: None)
    found = edges(
        present(LOOSE, None, BRIEF), "joints.B.clearance", "above", Search(1.01, 0.005, 2e-3), BRIEF
    )
    assert found["status"] == 0
    assert len(found["looked"]) == 2
    assert np.isnan(found["edge"]).all()


@pytest.mark.long
def test_a_motion_that_takes_long_to_settle_has_kept_its_period():
    """At 32.22 µm a disturbance halves in 250 turns."""
    slow = LOOSE.replace(gear_ratio=15.0, clearance=3.215e-5)
    found, limit = one_side(slow, "joints.B.clearance", "above", 1.004, 0.0025)
    assert limit == pytest.approx(1.004 * 3.215e-5)
    assert np.isnan(found["doubling"][0])


@pytest.mark.nightly
def test_a_chaotic_motion_stays_so_as_it_is_carried_on():
    """Beside 0.29 mm, where the motion is chaotic, there is no edge within a percent."""
    found, limit = one_side(LOOSE.replace(clearance=2.9e-4), "joints.B.clearance", "above", 1.01, 0.01)
    assert limit == pytest.approx(1.01 * 2.9e-4)
    assert np.isnan([found[name][0] for name in CHANGES]).all()


@pytest.mark.long
def test_forces_and_losses_are_those_of_other_runs():
    found = forces(present(LOOSE, None, BRIEF), 4, BRIEF)
    names = found["names"]
    taken = float(found["impact_loss"][0] + found["friction_loss"][0])
    error = float(np.hypot(found["impact_loss_error"][0], found["friction_loss_error"][0]))
    assert taken == pytest.approx(found["joint_work"], abs=3 * error)
    assert found["joint_work"] == pytest.approx(found["drive_work"], rel=1e-6)
    turn = jp.simulate(
        LOOSE, turns=1, transient=60, samples_per_turn=8192, record=("normal_force", "reaction")
    )
    own = {name: float(turn["reaction"].sel(pin=name).max()) for name in turn["pin"].values}
    own["B"] = float(turn["normal_force"].max())
    for name, peak, error in zip(names, found["peak"], found["peak_error"], strict=True):
        assert peak == pytest.approx(own[name], abs=3 * error + 2e-3 * peak)
    assert found["impact_speed"][0] == pytest.approx(8.633e-3, rel=0.05)
    assert found["sliding_work"][0] * LOOSE.joints[2].friction.coefficient == pytest.approx(
        found["friction_loss"][0], rel=1e-3
    )


@pytest.mark.nightly
def test_a_rigid_bearing_is_hit_and_its_largest_forces_are_narrow():
    """Against the list of events, and forces at 524 288 even times of a turn."""
    rigid = unshown.TEN["rigid slider"]()
    found = forces(present(rigid, None, BRIEF), 2, BRIEF)
    recorded = {"record": ("normal_force", "tangential_force", "reaction"), "samples_per_turn": 2**19}
    turn = jp.words(jp.simulate(rigid, turns=1, transient=100, **recorded))
    hits = np.abs(turn["event_normal_velocity"].values[turn["event_kind"].values == "impact"])
    assert found["impact_speed"][0] == pytest.approx(hits.max(), rel=1e-5)
    assert found["impact_loss"][0] > 0.1 * found["joint_work"]
    assert found["impact_loss"][0] + found["friction_loss"][0] == pytest.approx(found["joint_work"], rel=1e-4)
    every, fourth = (largest_of(turn.isel(time=slice(None, None, step))) for step in (1, 4))
    for name, peak, error in zip(found["names"], found["peak"], found["peak_error"], strict=True):
        assert peak == pytest.approx(every[name], rel=1e-4)
        # a force that jumps is largest beside the impact, which even times miss by a part of their distance
        assert -1e-7 * peak < peak - every[name] < error + every[name] - fourth[name] + 1e-7 * peak


@pytest.mark.nightly
def test_ideal_joints_that_a_torque_speeds_up_for_ever_have_no_forces_to_compare_with():
    """Without losses each turn adds the torque's work: 2 pi 0.05 J."""
    drive = {"kind": "torque", "link": "crank", "constant": 0.05, "nominal_speed": 40.0}
    how = {"along": ["clearance"], "budget": 1e-3, "n_jobs": 1, "transient": 2, "lyapunov_turns": 20}
    with pytest.warns(jp.ModelWarning, match="comes to no steady speed"):
        found = jp.assess(jp.catalog.chunmei2002(drive=drive), **how)
    assert np.isfinite(found.peak_force).all()
    assert np.isnan(found.ideal_peak_force).all()
    assert np.isnan(found.force_ratio).all()
    assert "comes to no steady speed" in found.attrs["warning"]


def test_what_stiff_contacts_store_and_give_back_is_no_loss():
    """Impacts without friction: each stores many times what it loses."""
    changes = {"joints.B.contact.stiffness": 1e10, "joints.B.contact.damping": 316.0}
    stiff = jp.catalog.slider_crank(clearance=1e-4, friction=0.0).varied(changes)
    found = forces(followed(stiff, None, plan(30, 8, 20, 1e-8, None)), 8, BRIEF)
    assert found["separations"][0] > 50
    assert found["impact_loss"][0] > 0
    assert found["impact_loss"][0] == pytest.approx(found["joint_work"], rel=1e-9)


def largest_of(turn):
    own = {name: float(turn["reaction"].sel(pin=name).max()) for name in turn["pin"].values}
    return own | {"B": float(np.nanmax(np.hypot(turn["normal_force"], turn["tangential_force"])))}


@pytest.mark.parametrize(
    ("changes", "keywords", "key"),
    [
        ({"clearance": 0.0}, {}, "mechanism.joints"),
        ({"drive": None}, {}, "mechanism.drive"),
        ({}, {"along": ["joints.Q.clearance"]}, "along[0]"),
        ({}, {"along": []}, "along"),
        ({}, {"along": ["gear_ratio", "gear_ratio"]}, "along"),
        ({}, {"along": ["speed"]}, "along[0]"),
        ({}, {"along": ["joints.C.clearance"]}, "along[0]"),
        ({"clearance": {"B": 1e-5, "C": 1e-5}}, {"along": ["clearance"]}, "along[0]"),
        ({}, {"reach": 1.0}, "reach"),
    ],
)
def test_what_cannot_be_assessed_is_refused(changes, keywords, key):
    assert list(problems_of(jp.assess, LOOSE.replace(**changes), **keywords)) == [key]


def test_play_in_a_guide_is_refused_by_the_guide():
    """Its four corners are contacts, which never all touch at once: contact would always count as lost."""
    with pytest.raises(InputError) as caught:
        jp.assess(jp.catalog.slider_crank(clearance={"B": 1e-4, "G": 1e-4}))
    assert [problem.key for problem in caught.value.problems] == ["mechanism.joints.G.clearance"]


def test_a_test_system_is_refused():
    with pytest.raises(InputError, match="kind = 'bifurcation' or 'continuation'"):
        jp.assess(jp.catalog.impact_pair(3.0, 0.8))


@pytest.mark.parametrize("key", ["speed", "joints.C.clearance"])
def test_what_is_varied_by_factors_has_to_have_a_value(key):
    with pytest.raises(InputError, match="a parameter whose value is a number other than 0 is accepted"):
        jp.assess(LOOSE, along=[key])


def test_a_motion_that_does_not_settle_in_its_share_is_told_by_a_few_turns(monkeypatch):
    told = assess.assessed(LOOSE, None, 20, BRIEF, patience=0.0)
    assert told["status"] == 0
    assert np.isnan(told["motion"]["values"].get("section_exponent_per_turn", ((), np.nan))[1])
    settled = assess.assessed(LOOSE, None, 20, BRIEF, patience=1e3)
    assert settled["motion"]["orbit"] is not None
    assert told["motion"]["orbit"] is None
    np.testing.assert_allclose(told["peak"], settled["peak"], rtol=0.02)
    monkeypatch.setattr(assess, "SETTLING", np.inf)
    found = jp.assess(LOOSE, along=["gear_ratio"], reach=1.01, budget=1e-9, n_jobs=1)
    assert float(found["peak_force"].sel(joint="B")) == pytest.approx(told["peak"][0], rel=0.02)
    assert "settle" in str(jp.summary(found)) or int(found["period"]) == 1


@pytest.mark.long
def test_edges_stand_where_the_time_ends_behind_them(monkeypatch):
    def late(*_):
        raise OutOfTime

    monkeypatch.setattr(assess, "either_side", late)
    motion = present(LOOSE.replace(clearance=2.35e-5), None, BRIEF)
    given = {"turns": 5, "how": BRIEF, "limit": 1e3, "known": {}, "side": "below"}
    search = Search(1.06, 0.0025, 2e-3, 1e-6)
    key = "joints.B.clearance"
    cut = assess.sided(motion.mechanism, motion.plain(), key, search=search, **given)
    assert cut["status"] == assess.NOT_RUN
    assert np.isfinite(cut["edge"][0])
    assert len(cut["looked"]) > 3
