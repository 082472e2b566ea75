"""The paper's conclusions: the numbers behind them, and the rules by which they are graded."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.display import codes
from jointplay.display.errors import InputError
from jointplay_lab.paper import claims as module
from jointplay_lab.paper.claims import (
    CLAIMS,
    GRADES,
    Ratio,
    claims,
    grade,
    graded,
    irregularity,
    mean,
    peaks,
    starts,
    vibration,
)
from jointplay_lab.paper.reading_list import PANELS

PRINTED = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0)


@pytest.fixture
def brief(monkeypatch):
    """One panel and few turns."""
    monkeypatch.setattr(module, "PANELS", {"b": PANELS["b"]})
    monkeypatch.setattr(module, "STEADY", {"b": 3})
    monkeypatch.setattr(module, "DROPPED", 8)


def run(**options):
    lengths = {"turns": 16, "transient": 20, "growth_turns": 40, "n_jobs": 1}
    return claims(**lengths | {"damping_ratios": ()} | options)


@pytest.mark.nightly
def test_the_conclusions_on_one_panel(brief):
    found = run()
    assert STATUS[int(found.status)] == "ok"
    assert found.damping_ratio.values[1:].tolist() == [0.0, 0.01]
    for name, variable in found.variables.items():
        assert variable.attrs["long_name"], name
        assert "units" in variable.attrs or variable.dtype.kind in "iU", name
    grades = [GRADES[code] for code in found.grade.values]
    assert grades == ["reproduced", "partly", "partly", "partly"]
    force = found.peak_force.sel(panel="b", links="rigid")
    assert force.sel(joints="ideal").values == pytest.approx([33.126, 33.126], abs=1e-2)
    assert force.sel(joints="clearance").values == pytest.approx([104.78, 42.83], abs=0.1)
    assert np.isnan(found.peak_deflection.sel(links="rigid")).all()
    assert found.peak_deflection.sel(joints="clearance").values[0, 1:, 0] == pytest.approx(1.39e-5, rel=0.02)
    assert found.motion.values.tolist() == [[1] * 4]
    assert found.distance.values.max() < 1e-6


@pytest.mark.nightly
def test_a_failed_run_leaves_its_conclusion_undecidable(brief):
    found = run(max_steps=2000)
    assert STATUS[int(found.status)] == "step_limit"
    assert [GRADES[code] for code in found.grade.values] == ["undecidable"] * 4


@pytest.mark.nightly
def test_all_panels():
    found = claims()
    assert [GRADES[code] for code in found.grade.values] == ["partly"] * 4
    assert found.motion.values.tolist() == [[1] * 4, [1] * 4, [2] * 4]
    assert (found.distance.sel(panel=["a", "b"]) < 1e-6).all()
    assert (found.distance.sel(panel="c")[1:] > 1e-2).all()


@pytest.mark.parametrize(
    ("mechanism", "word"), [(catalog.duffing(), "motor"), (PRINTED.replace(speed=9), "motor")]
)
def test_wrong_input(mechanism, word):
    with pytest.raises(InputError, match=word):
        claims(mechanism)


def test_starts_differ_and_begin_at_the_same_crank_angle():
    found = starts(PRINTED)
    assert list(found) == list(module.START_NAMES)
    first = [jp.simulate(PRINTED, turns=1, initial=one).isel(time=0) for one in found.values()]
    assert [float(one.angle.sel(link="crank")) for one in first] == [0.0] * 4
    speeds = [float(one.angular_velocity.sel(link="crank")) for one in first]
    assert np.array(speeds) / speeds[0] == pytest.approx([1, 0.8, 1.2, 1], rel=1e-9)
    assert [float(one.eccentricity_ratio[0]) for one in first] == pytest.approx([0, 0, 0, 0.9], abs=1e-3)


def test_ends_are_compared_as_sets_of_points():
    """A motion of period 2 ends on the same points one turn later; a farther point counts for itself."""
    first = {"points": np.tile([[0.0, 0.0], [3.0, 4.0]], (30, 1))}
    later = {"points": first["points"][::-1]}
    other = {"points": np.append(first["points"], [[3.0, 4.5]], axis=0)}
    assert module._distance(first, later) == 0.0
    assert module._distance(first, other) == 0.5
    assert math.isnan(module._distance(first, {"status": 2}))


def test_ends_are_compared_by_their_last_points():
    """What only one of them passed before its end counts in neither."""
    early, last = (np.full((50, 2), each) for each in (3.0, 0.0))
    passed, stays = ({"points": np.concatenate(parts)} for parts in ([early, early, last], [early, early]))
    assert module._distance(passed, {"points": last}) == 0.0
    assert module._distance({"points": last}, passed) == 0.0
    assert module._distance(passed, stays) == pytest.approx(3.0 * math.sqrt(2))


def test_peaks_hold_both_sides_of_every_event():
    """At gear ratio 15 the motor calms the crank in a microsecond: samples miss what an impact does."""
    mechanism = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=15.0)
    own = jp.simulate(mechanism, turns=1, steps=True)
    after = np.abs(own.angular_acceleration.sel(link="crank").values[own.time.values > 0.01 * 0.375]).max()
    found = peaks(mechanism, turns=1)
    assert found["peak_crank_acceleration"][0][0] >= after
    sampled = jp.simulate(mechanism, turns=1, samples_per_turn=3000)
    assert found["peak_force"][0][0] >= float(np.hypot(sampled.normal_force, sampled.tangential_force).max())
    contacts = own.event_time[own.event_kind == EVENTS.index("contact")] / own.turn_period_nominal
    counted = float(np.sum(contacts >= 0.005)) / 0.995
    assert counted > 1
    assert found["impacts"][0] == (pytest.approx(counted), 0.0)


def test_mean_and_standard_error():
    assert mean(np.array([3.0])) == (3.0, 0.0)
    assert mean(np.array([1.0, 3.0])) == pytest.approx((2.0, 1.0))


def test_irregularity():
    angle = np.linspace(0, 6 * math.tau, 6001)
    assert irregularity(angle, np.sin(angle))[0] == pytest.approx(0, abs=1e-3)
    assert irregularity(angle**1.0, np.sin(angle / 2))[0] == pytest.approx(2, abs=0.01)  # the other way round
    noise = np.random.default_rng(0).standard_normal(6001)
    assert irregularity(angle, noise)[0] == pytest.approx(math.sqrt(2), abs=0.1)
    assert irregularity(-angle, np.sin(angle))[0] == pytest.approx(0, abs=1e-3)
    assert np.isnan(irregularity(angle[:1500], noise[:1500])).all()


def test_irregularity_at_equal_crank_angle():
    """A crank whose speed changes in the turn, and its turn from one to the next, is still regular."""
    time = np.linspace(0, 1, 60_001)
    angle = 6 * math.tau * (time + 0.1 * time**2)
    assert irregularity(angle, np.sin(angle) ** 3)[0] < 1e-3


def test_vibration():
    time = np.arange(20_000)
    slow, fast = np.sin(math.tau * time / 20_000), np.sin(math.tau * time / 100)
    assert vibration(slow, 100) < 1e-3
    assert vibration(fast, 100) == pytest.approx(1, abs=0.01)
    assert vibration(slow + 0.5 * fast, 100) == pytest.approx(0.5 / math.sqrt(1.25), abs=0.01)


@pytest.mark.parametrize(
    ("checks", "word"),
    [
        ([1, 1], "reproduced"),
        ([1, 0], "partly"),
        ([0, 0], "not"),
        ([], "undecidable"),
        ([math.nan], "undecidable"),
        ([math.nan, 1], "reproduced"),
        ([math.nan, 0], "not"),
    ],
)
def test_grade(checks, word):
    assert grade(checks) == word


@pytest.mark.parametrize(
    ("value", "error", "above", "below"),
    [
        (1.5, 0.0, 1, 0),
        (0.5, 0.0, 0, 1),
        (1.005, 0.0, 0, 0),
        (0.995, 0.0, 0, 0),
        (1.2, 0.1, math.nan, math.nan),
        (1.5, 0.1, 1, 0),
        (0.5, 0.1, 0, 1),
        (math.nan, math.nan, math.nan, math.nan),
    ],
)
def test_ratio(value, error, above, below):
    ratio = Ratio(np.array([value]), np.array([error]))
    np.testing.assert_equal([ratio.above()[0], ratio.below()[0]], [above, below])


def numbers(**values):
    """Numbers of two panels, all alike but for what is given, as the analysis returns them."""
    dims = {"panel": ["a", "b"], "joints": ["ideal", "clearance"], "window": ["start_up", "steady"]}
    links = ["rigid", "elastic 0", "elastic 0.01"]
    one = xr.DataArray(
        np.ones((2, 2, 3, 2)), {**dims, "links": links}, ("panel", "joints", "links", "window")
    )
    names = {**module.PEAKS}
    found = {name: one.copy() for name in names} | {f"{name}_error": 0 * one for name in names}
    data = xr.Dataset(found).assign_coords(damping_ratio=("links", [math.nan, 0.0, 0.01]))
    shape, dims = (2, 2), ("panel", "start")
    for name, value in (("separations", 1.0), ("growth", -1.0), ("growth_standard_error", 0.1)):
        data[name] = (dims, np.full(shape, value))
    data["period"], data["motion"] = (dims, np.ones(shape, int)), (dims, np.ones(shape, int))
    data["distance"], data["motion_status"] = (dims, np.zeros(shape)), (dims, np.zeros(shape, int))
    data["peak_status"] = (("panel",), np.zeros(2, int))
    return data


@pytest.mark.parametrize("claim", ["peaks", "impacts", "deflection"])
def test_equal_numbers_show_nothing(claim):
    assert graded(claim, numbers())[0] == "not"


def test_clearance_that_raises_every_peak():
    data = numbers()
    names = ("peak_force", "peak_coupler_acceleration", "peak_crank_acceleration")
    for name in names:
        data[name].loc[{"joints": "clearance"}] = 3.0
    assert graded("peaks", data)[0] == "reproduced"
    assert "(12 of 12 above 1)" in graded("peaks", data)[1]
    data["peak_force"].loc[{"joints": "clearance", "panel": "a", "window": "steady"}] = 1.0
    assert graded("peaks", data)[0] == "partly"
    assert "(11 of 12 above 1)" in graded("peaks", data)[1]


def elastic(data, joints, value, **place):
    data["peak_force"].loc[{"joints": joints, "links": ["elastic 0", "elastic 0.01"], **place}] = value


def test_elasticity_counts_only_where_there_are_impacts():
    data = numbers()
    elastic(data, "ideal", 1.3)
    elastic(data, "clearance", 0.8)
    assert graded("impacts", data)[0] == "reproduced"
    elastic(data, "clearance", 1.0, window="steady")
    assert graded("impacts", data)[0] == "partly"
    data["impacts"].loc[{"joints": "clearance", "window": "steady"}] = 0.0
    assert graded("impacts", data)[0] == "reproduced"
    elastic(data, "ideal", 1.0)
    assert graded("impacts", data)[0] == "partly"
    elastic(data, "clearance", 1.2)
    assert graded("impacts", data)[0] == "not"


def test_damping_that_lowers_every_deflection():
    data = numbers()
    for name in ("peak_deflection", "rms_deflection", "vibration", "irregularity"):
        data[name].loc[{"links": "elastic 0.01"}] = 0.5
    assert graded("deflection", data)[0] == "reproduced"
    data["irregularity"].loc[{"window": "start_up"}] = math.nan  # a window of one turn has none
    assert graded("deflection", data)[0] == "reproduced"
    for name in ("peak_deflection", "rms_deflection", "vibration"):
        data[name].loc[{"links": "elastic 0.01", "window": "start_up"}] = 1.0
        assert graded("deflection", data)[0] == "partly"
        data[name].loc[{"links": "elastic 0.01", "window": "start_up"}] = 0.5
    data["irregularity"] = data["irregularity"] * 1e-5  # regular before and after
    assert graded("deflection", data)[0] == "partly"


def test_each_comparison_is_kept_with_its_ratios_and_a_grade_of_its_own():
    """The stored result: what it keeps of comparisons is what its own numbers give."""
    data = jp.open(Path(__file__).parents[2] / "results" / "paper" / "claims.nc")
    rows = {str(name): n for n, name in enumerate(data["compared"].values)}
    force = data["peak_force"].sel(links="rigid", window="start_up")
    kept = data["ratio"].values[rows["force at B, start-up"], :3]
    assert kept == pytest.approx(
        (force.sel(joints="clearance") / force.sel(joints="ideal")).values, rel=1e-12
    )
    grades = dict(zip(rows, codes.words(data["compared_grade"]).values, strict=True))
    wanted = {
        "force at B, start-up": "reproduced",
        "force at B, steady": "partly",
        "ideal joints, steady": "not",
    }
    assert wanted.items() <= grades.items()
    for claim in ("peaks", "impacts", "deflection"):
        holds = data["ratio_holds"].values[data["compared_for"].values == claim]
        assert grade(holds[np.isfinite(holds)]) == codes.words(data["grade"].sel(claim=claim)).item()


def of_panel(data, panel, **values):
    for name, value in values.items():
        data[name].loc[{"panel": panel}] = value


def test_a_chaotic_and_a_periodic_panel():
    data = numbers().assign_coords(start=["x", "y"])
    of_panel(data, "a", separations=0.0)
    of_panel(data, "b", motion=2, period=0, growth=1.0, distance=0.3)
    assert graded("chaos", data)[0] == "reproduced"
    found = "b chaotic: losses of contact per turn 1, period none, growth per turn 1"
    assert found in graded("chaos", data)[1]
    of_panel(data, "a", separations=2.0)  # periodic although it loses contact
    assert graded("chaos", data)[0] == "partly"
    of_panel(data, "a", separations=0.0, distance=0.5)  # periodic, but not the same from every start
    assert graded("chaos", data)[0] == "partly"
    of_panel(data, "b", motion=0)
    assert graded("chaos", data)[0] == "not"


def test_a_failed_run_is_undecidable():
    data = numbers()
    data["peak_status"][0] = 2
    assert [graded(claim, data)[0] for claim in CLAIMS][:3] == ["undecidable"] * 3
    data["motion_status"][0, 0] = 2
    assert graded("chaos", data)[0] == "undecidable"
