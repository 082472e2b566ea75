"""Attractors over a parameter: motions that are known to coexist, what lasts, identities, fractions."""

import math

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.coexisting import attractors
from jointplay.analysis.coexisting.attractors import EVENTS, _motion, identities
from jointplay.analysis.coexisting.lasting import (
    AMONG,
    ENOUGH,
    UNSETTLED,
    Cloud,
    FromAfar,
    Lasting,
    Motions,
    along,
)
from jointplay.analysis.coexisting.passes import PILOTS
from jointplay.analysis.coexisting.region import drawn
from jointplay.analysis.orbits.branch_points import KINDS
from jointplay.analysis.states.ends import Observation
from jointplay.analysis.states.start_plane import Starts
from jointplay.display.errors import InputError
from tests.analysis.exact_maps import Symmetric

PAIR, WELLS = catalog.impact_pair(3.6, 0.8), catalog.duffing(amplitude=0.0)
PLANE = {"y": (-1.6, 1.6), "v": (-3.0, 3.0)}
SHORT = {
    "turns": 32,
    "transient": 200,
    "lyapunov_turns": 40,
}  # chaos before the birth at 3.41 lives 100 turns


@pytest.fixture(scope="module")
def pair():
    return jp.attractors(PAIR, over={"gap": [3.4, 3.6, 3.65]}, region=PLANE, starts=40, n_jobs=1, **SHORT)


def changes(found):
    kinds = [EVENTS[code] for code in found["change_kind"].values]
    return [*zip(kinds, found["change_identity"].values, found["change_low"].values, strict=True)]


@pytest.mark.nightly
def test_the_impact_pairs_motions_are_found_without_being_told(pair):
    assert pair["period"].values.tolist() == [[1, -1], [1, 3], [1, 3]]
    all_of = pair["fraction"].sum("identity") + pair["fraction_unsettled"]
    assert all_of.values == pytest.approx(1.0)
    assert (pair["fraction_unsettled"].values <= 0.05).all()
    assert changes(pair) == [("birth", 2, 3.4)]
    exact = [Symmetric(gap, 0.8).at_zero[0] for gap in pair["gap"].values]
    first = pair["state_value"].sel(identity=1, state="y").values[:, 0]
    assert first == pytest.approx(exact, abs=1e-4)
    shown = np.isfinite(pair["state_value"].sel(state="y")).sum("point").values
    assert shown.tolist() == np.maximum(pair["period"].values, 0).tolist()
    growth = pair["section_exponent_per_turn"].sel(identity=1, multiplier=1).values
    assert growth == pytest.approx(2 * math.log(0.8), abs=0.03)  # converges as 1/turns


def test_where_every_start_fails_no_motion_is_found_and_the_figure_shows_fractions():
    few = {"starts": 3, "transient": 2, "max_steps": 3, "ensemble": False, "n_jobs": 1}
    found = jp.attractors(PAIR, over={"gap": [3.4, 3.6]}, region=PLANE, **few)
    assert found.sizes["identity"] == 0
    assert found["fraction_failed"].values.tolist() == [1.0, 1.0]
    (axes,) = jp.figure(found, kind="attractors", quantity="y").axes
    assert axes.get_ylabel() == "Fraction of\nthe starts"


def test_a_basin_no_start_is_in_is_found_from_its_neighbour():
    region, keywords = {"y": (-0.3, 0.3), "v": (0.0, 0.3)}, SHORT | {"starts": 3, "n_jobs": 1}
    keywords |= {"over": {"gap": [3.62, 3.65]}, "exponents": False, "seed": 4}
    alone, carried = (jp.attractors(PAIR, region=region, carry=each, **keywords) for each in (False, True))
    assert alone["period"].values.tolist() == [[1, 3], [1, -1]]
    assert carried["period"].values.tolist() == [[1, 3], [1, 3]]
    assert carried["carried"].values.tolist() == [[0, 0], [0, 1]]
    assert carried["fraction"].values[1].tolist() == [1.0, 0.0]
    assert float(carried["fraction_high"][1, 1]) > 0.5  # of three starts
    assert (changes(alone), changes(carried)) == ([("death", 2, 3.62)], [])


def test_a_start_that_does_not_fit_is_told_before_anything_is_followed(monkeypatch):
    monkeypatch.setattr(Motions, "sort", lambda *_: pytest.fail("it is followed"))
    with pytest.raises(InputError) as caught:
        jp.attractors(PAIR, over={"gap": [3.6]}, region=PLANE, starts=4, initial=[0.1], n_jobs=1, **SHORT)
    assert [problem.key for problem in caught.value.problems] == ["initial"]


def test_code_is_compiled_for_the_first_and_the_last_value_that_make_a_model(monkeypatch):
    ahead = []
    monkeypatch.setattr(attractors, "warm", lambda models, *_: ahead.extend(models))
    attractors._warm(PAIR, [{"gap": 3.4}, {"gap": -1.0}, {"gap": 3.6}], None, exponents=False, ensemble=False)
    attractors._warm(PAIR, [{"gap": -1.0}, {"gap": 3.7}], None, exponents=False, ensemble=False)
    assert [model.numbers[0] for model in ahead] == [3.4, 3.6, 3.7]


@pytest.mark.nightly
def test_workers_do_not_change_the_answer():
    keywords = SHORT | {"over": {"gap": [3.4, 3.6]}, "region": PLANE, "starts": PILOTS + 48}
    one, two = (jp.attractors(PAIR, n_jobs=n, **keywords).drop_vars("wall_time") for n in (1, 2))
    assert one.identical(two)


@pytest.mark.nightly
def test_a_value_more_changes_no_other(pair):
    one = jp.attractors(PAIR, over={"gap": [3.6]}, region=PLANE, starts=40, n_jobs=1, **SHORT)
    assert one["count"].values.tolist() == pair["count"].values[1:2].tolist()
    assert not np.array_equal(drawn(PLANE, 5, 0, 3.6), drawn(PLANE, 5, 1, 3.6))
    assert not np.array_equal(drawn(PLANE, 5, 0, 3.6), drawn(PLANE, 5, 0, 3.65))


def sorted_into(system, amplitude, count, observation, names=("y", "v")):
    start = Starts(system.replace(amplitude=amplitude), None, names)
    motions = Motions(start.model, observation)
    nodes = drawn({"y": (-1.5, 1.5), "v": (-1.2, 1.2)}, count, 3, amplitude)
    return motions, motions.sort([start(node) for node in nodes])


def test_a_chaotic_motion_lasts_and_a_chaotic_transient_does_not():
    """Two wells: chaos at f = 0.3; at 0.25 every motion settles in a well, after long chaos."""
    motions, labels = sorted_into(catalog.duffing(amplitude=0.3), 0.3, 8, Observation(20, 64, 1, 1e-3, 1e-6))
    assert [each.period for each in motions.known] == [0]
    assert (labels == 0).all()
    assert motions.known[0].watched == 8 * 2 * 64
    motions, labels = sorted_into(catalog.duffing(amplitude=0.3), 0.25, 40, Observation(8, 32, 2, 1e-3, 1e-6))
    assert {each.period for each in motions.known} == {1}  # starts to come are not taken for chaos
    assert 0 < np.mean(labels == UNSETTLED) < 0.5
    assert (labels[labels != UNSETTLED] >= 0).all()


def test_a_motion_is_recognised_by_points_that_run_along_it_in_its_order():
    cycle = np.array([[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0]])
    twice, far = np.tile(cycle, (2, 1)), np.linspace(9e-4, 1e-4, 6)[:, None]
    away, near = twice + far[::-1], twice + far
    runs = [twice + 1e-4, twice[::-1], away, away[::-1], near, twice + 5 * far]
    found = along(np.array(runs), Lasting(3, cycle, cycle), 1e-3, 1e-4)
    assert found.tolist() == [True, False, False, False, True, False]
    assert not along(np.array([cycle]), Lasting(3, cycle, cycle), 1e-3, 1e-4).any()
    assert not along(np.array(runs), Lasting(0, cycle, cycle), 1e-3, 1e-4).any()


def test_from_afar_is_recognised_what_was_right_often_enough_and_never_wrong():
    rest = [Lasting(1, None, np.array([[at]])) for at in (0.0, 1.0)]
    coming = [at + np.geomspace(start, start / 100, 16)[:, None] for at, start in ((0.0, 8e-3), (1.0, 8e-3))]
    both, pieces = np.array(coming), [np.split(run, 2) for run in coming]
    afar = FromAfar(rest, 1e-3)
    assert afar.bound(both[:, :8]).tolist() == [0, 1]
    assert afar.recognised(both).tolist() == [-1, -1]
    afar.learn(pieces * (ENOUGH - 1), [0, 1] * (ENOUGH - 1))
    assert afar.recognised(both).tolist() == [-1, -1]
    afar.learn([*pieces, pieces[1]], [0, 1, 0])  # the last was bound for 1, and ended in 0
    assert afar.recognised(both).tolist() == [0, -1]
    near = FromAfar([*rest, Lasting(1, None, np.array([[-1e-3]]))], 1e-3)
    assert near.bound(both).tolist() == [-1, 1]  # along two motions at once


def test_a_cloud_holds_what_lies_among_its_points_for_long_enough():
    random = np.random.default_rng(1)
    ring = random.uniform(0, math.tau, (20, 50))
    cloud = Cloud(np.stack([np.cos(ring), np.sin(ring)], -1))
    angle = random.uniform(0, math.tau, (200, AMONG))
    inside, outside = (r * np.stack([np.cos(angle), np.sin(angle)], -1) for r in (1.0, 0.9))
    assert cloud.holds(inside).mean() > 0.8
    assert not cloud.holds(outside).any()
    inside[:, -1] *= 0.9
    assert not cloud.holds(inside).any()
    assert not cloud.holds(inside[:, 1:]).any()  # too few


@pytest.mark.nightly
@pytest.mark.parametrize(("system", "names"), [(PAIR, PLANE), (catalog.duffing(amplitude=0.3), None)])
def test_what_is_recognised_from_afar_ends_where_it_ends(system, names):
    region = names or {"y": (-1.5, 1.5), "v": (-1.2, 1.2)}
    place = Starts(system, None, tuple(region))
    starts = [place(node) for node in drawn(region, 160, 3, 0.0)]
    far, near = (Motions(place.model, Observation(60, 32, 1, 1e-3, 1e-5)) for _ in range(2))
    ends = [motions.sort(starts, pilots) for motions, pilots in ((far, 64), (near, None))]
    assert ends[0].tolist() == ends[1].tolist()
    assert [each.period for each in far.known] == [each.period for each in near.known]
    assert far.turns[:64].tolist() == near.turns[:64].tolist()
    needed = [np.where(motions.turns < 0, 60, motions.turns)[64:].sum() for motions in (far, near)]
    assert needed[0] < 0.9 * needed[1]


def points(*rows, period=None):
    cloud = np.array(rows, dtype=float).reshape(len(rows), -1)
    return {"points": cloud, "period": len(rows) if period is None else period}


def test_identities_follow_the_nearest_and_what_is_carried_comes_first():
    near = [[points(0.0), points(1.0)], [points(0.9), points(0.1)]]
    assert identities(near, {}, 0.2)[0] == [[1, 2], [2, 1]]
    crossed = {(0, 0, 1): 0, (0, 1, 1): 1}
    assert identities(near, crossed, 2.0)[0] == [[1, 2], [1, 2]]
    doubled = [[points(0.0)], [points(-0.1, 0.1)], [points(-0.2, -0.15, 0.15, 0.2)]]
    numbers, events, apart = identities(doubled, {}, 0.2)
    assert numbers == [[1], [1], [1]]
    assert (events, apart[1:]) == ([], [[0.1], [pytest.approx(0.1)]])


def test_births_deaths_splits_and_mergers():
    motions = [[points(0.0)], [points(-0.1), points(0.15)], [points(-0.2), points(5.0)], [points(-0.2)]]
    lands = {(1, 1, 0): 0, (1, 0, 0): 0, (1, 1, 2): 1, (1, 0, 2): 0, (2, 1, 1): 0, (2, 1, 3): 0}
    numbers, events, _ = identities(motions, lands, 0.2)
    assert numbers == [[1], [1, 2], [1, 3], [1]]
    told = [(each.kind, each.identity, each.other, each.between) for each in events]
    assert told == [
        ("split", 2, 1, (0, 1)),
        ("death", 2, 3, (1, 2)),
        ("birth", 3, 1, (1, 2)),
        ("death", 3, 1, (2, 3)),
    ]
    two = [[points(0.0), points(0.2)], [points(0.1)]]
    assert [each.kind for each in identities(two, {(0, 1, 1): 0, (0, 0, 1): 0}, 0.2)[1]] == ["merger"]


@pytest.mark.nightly
def test_the_loss_of_symmetry_is_found_on_the_branch_at_its_closed_form():
    """d_SB = k (pi - 4/pi) / sqrt(1 + 4 k^2 / pi^2), k = (1 + r) / (1 - r): below it two are mirrored."""
    k = 1.8 / 0.2
    exact = k * (math.pi - 4 / math.pi) / math.sqrt(1 + 4 * k**2 / math.pi**2)
    keywords = SHORT | {"starts": 8, "exponents": False, "bifurcations": True, "n_jobs": 1}
    found = jp.attractors(PAIR, over={"gap": [2.88, 2.9, 2.92]}, region=PLANE, **keywords)
    places = found["special_parameter"].values
    assert np.abs(places - exact).min() < 1e-6
    (stays,) = found["identity"].values[found["period"].values[1] > 0]
    assert found["special_identity"].values[np.abs(places - exact).argmin()] == stays
    born = [each for each in changes(found) if each[0] in ("merger", "death")]
    assert [low for _, _, low in born] == [2.88]
    assert KINDS[int(found["change_bifurcation"].values[0])] == "branch_point"


def test_what_is_wrong_is_said_by_its_key():
    with pytest.raises(InputError) as caught:
        jp.attractors(PAIR, over={"gap": [3.6], "restitution": [0.8]}, region={"x": (0, 1), "y": (1, 0)})
    assert {each.key for each in caught.value.problems} == {"over", "region.x", "region.y"}


def test_values_that_cannot_be_are_a_status():
    found = jp.attractors(PAIR, over={"gap": [3.6]}, region={"y": (5.0, 6.0)}, starts=4, n_jobs=1, **SHORT)
    assert (found.sizes["identity"], int(found["started"][0]), float(found["fraction_missed"][0])) == (
        0,
        0,
        1.0,
    )
    few = jp.attractors(PAIR, over={"gap": [3.6]}, region=PLANE, starts=4, max_steps=3, n_jobs=1, **SHORT)
    assert float(few["fraction_failed"][0]) == 1.0


@pytest.mark.nightly
def test_fractions_are_those_of_basins():
    plane = {name: {"start": low, "stop": high, "num": 30} for name, (low, high) in PLANE.items()}
    grid = jp.basins(PAIR, plane=plane, uncertainty=False)
    found = jp.attractors(PAIR, over={"gap": [3.6]}, region=PLANE, starts=900, exponents=False)
    assert found["period"].values[0].tolist() == grid["period"].values.tolist() == [1, 3]
    overlap = np.minimum(found["fraction_high"][0], grid["fraction_high"].values)
    assert (overlap > np.maximum(found["fraction_low"][0], grid["fraction_low"].values)).all()


@pytest.mark.nightly
def test_intervals_hold_the_known_fraction_as_often_as_they_say():
    """Unforced wells mirror each other: one half of a region that is its own mirror image reaches each."""
    keywords = {"over": {"damping": [0.2]}, "region": {"y": (-1.5, 1.5), "v": (-1.2, 1.2)}, "starts": 101}
    keywords |= {"exponents": False, "transient": 40, "turns": 8, "rtol": 1e-5, "n_jobs": 1}
    held = 0
    for seed in range(200):
        found = jp.attractors(WELLS, seed=seed, **keywords)
        assert found["period"].values.tolist() == [[1, 1]]
        held += float(found["fraction_low"][0, 0]) <= 0.5 <= float(found["fraction_high"][0, 0])
    assert 0.93 <= held / 200 <= 0.97


@pytest.mark.nightly
def test_the_linkages_four_motions_at_a_quarter_of_a_millimetre():
    mechanism, disc = (
        catalog.chunmei2002(2.5e-4, gear_ratio=3.0),
        ("eccentricity_ratio_x", "eccentricity_ratio_y"),
    )
    found = jp.attractors(
        mechanism,
        over={"clearance": [2.5e-4]},
        region=dict.fromkeys(disc, (-0.7, 0.7)),
        starts=100,
        turns=24,
        patience=6,
        tolerance=5e-3,
        ensemble=True,
    )
    assert sorted(found["period"].values[0].tolist()) == [1, 1, 2, 6]
    assert (found["section_exponent_per_turn"].values < 0).all()


def test_a_motion_that_no_start_reaches_is_said_to_be_carried(recwarn):
    none = xr.DataArray([[np.nan], [np.nan]], dims=("gap", "identity"))
    axes = {"gap": ("gap", [1.0, 2.0], {"units": "1"}), "identity": [1]}
    result = xr.Dataset({"fraction": none, "period": (none.dims, [[1], [1]])}, axes)
    told = _motion(result, "gap", 0, np.array([True, True]))
    assert told == "motion 1: period 1, from gap 1 to gap 2, found from neighbouring values alone"
    assert not recwarn.list
