"""Basins of motions that are known to coexist, labels that depend on nothing but the motions, boundaries."""

import math
from functools import partial

import numpy as np
import pytest
from scipy.stats import binomtest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.cells import driven, in_memory
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import Journals
from jointplay.analysis.states.basin_uncertainty import (
    PAIRS,
    Pairs,
    count_pairs,
    grid_pairs,
    uncertainty_exponent,
    wilson,
)
from jointplay.analysis.states.basins import random_pairs
from jointplay.analysis.states.ends import Observation, end_states, match, set_distance, shortest_period
from jointplay.analysis.states.start_plane import Starts
from jointplay.display.errors import InputError
from tests.analysis.exact_maps import Symmetric, strobed

CANTOR = math.log(2) / math.log(3)
RATTLE = catalog.impact_pair(3.6, 0.8)


def span(start, stop, num):
    return {"start": start, "stop": stop, "num": num}


def test_two_wells_share_the_plane_as_their_symmetry_says():
    """Unforced: (x, v) and (-x, -v) mirror each other."""
    plane = {"y": span(-1.5, 1.5, 20), "v": span(-1.2, 1.2, 20)}
    found = jp.basins(catalog.duffing(amplitude=0.0), plane=plane, turns=16, transient=20, n_jobs=1)
    assert found.period.values.tolist() == [1, 1]
    labels = found.attractor.values
    assert (labels == 3 - labels[::-1, ::-1]).all()
    assert found.fraction.values.tolist() == [0.5, 0.5]
    assert found.fraction_standard_error.values == pytest.approx(0.5 / math.sqrt(400), rel=1e-12)
    assert found.section_plane.values[:, 0] == pytest.approx(np.array([[-1.0, 0.0], [1.0, 0.0]]), abs=1e-4)
    assert labels[0, -1] != labels[-1, 0]
    assert (found.fraction_low < 0.5).all()
    assert (found.fraction_high > 0.5).all()
    assert abs(float(found.uncertainty_exponent) - 1) < 3 * float(found.uncertainty_exponent_standard_error)


def test_a_saddle_that_a_start_hits_is_no_attractor():
    """x'' = x - x^3 - 0.2 x': two wells; a node of an odd grid is the saddle between them."""
    wells = jp.System(
        states={"x": 1.0, "v": 0.0},
        parameters={"c": 0.2},
        rates={"x": "v", "v": "x - x**3 - c*v"},
    )
    plane = {"x": span(-1.0, 1.0, 5), "v": span(-1.0, 1.0, 5)}
    found = jp.basins(wells, plane=plane, turns=16, transient=60, uncertainty=False, n_jobs=1)
    assert found.section_plane.values[:, 0] == pytest.approx(np.array([[-1.0, 0.0], [1.0, 0.0]]), abs=1e-4)
    assert found.attractor.sel(x=0.0, v=0.0) == 0
    flags = found.node_status.attrs["flag_meanings"].split()
    assert flags[int(found.node_status.sel(x=0.0, v=0.0))] == "saddle"
    assert float(found.fraction_none) == 1 / 25
    assert "an unstable periodic orbit" in str(jp.summary(found))


CENTRE = {"states": {"x": 0.5, "v": 0.0}, "parameters": {"f": 0.3, "c": 0.0}, "forcing": "2*pi"}
CENTRE |= {"rates": {"x": "v", "v": "-4*x - c*v + f*cos(t)"}}


def test_orbits_that_nothing_damps_are_told():
    """x'' = -4 x + 0.3 cos t: every start has a motion of its own, which repeats and attracts no other."""
    plane = {"x": span(-1.0, 1.0, 3), "v": span(-1.0, 1.0, 2)}
    keywords = {"plane": plane, "turns": 16, "transient": 20, "uncertainty": False, "n_jobs": 1}
    with pytest.warns(jp.ModelWarning, match="6 of 6 motions are neutral"):
        found = jp.basins(jp.System(**CENTRE), **keywords)
    assert "6 of 6 motions are neutral" in found.attrs["warning"]
    damped = jp.basins(jp.System(**CENTRE).replace(c=0.5), **keywords)
    assert "warning" not in damped.attrs


def test_tipping_tells_of_orbits_that_nothing_damps():
    keywords = {"starts": 3, "largest": 0.1, "steps": 1, "phases": 1, "directions": 2, "edge": False}
    keywords |= {"turns": 16, "transient": 20, "n_jobs": 1}
    with pytest.warns(jp.ModelWarning, match="3 of 3 motions are neutral"):
        found = jp.tipping(jp.System(**CENTRE), region={"x": [-1, 1], "v": [-1, 1]}, **keywords)
    assert "neutral" in found.attrs["warning"]


def test_an_adaptive_plane_follows_starts_where_basins_meet():
    """Where starts were followed the plane is the whole one's; elsewhere nearly so. No key comes twice."""
    wells, keys = catalog.duffing(amplitude=0.0), []
    keywords = {"plane": {"y": span(-1.2, 1.2, 25), "v": span(-0.6, 0.6, 25)}, "turns": 16, "transient": 20}
    keywords |= {"pairs": 5, "rtol": 1e-6}
    whole = jp.basins(wells, n_jobs=1, **keywords)

    def noted(work):
        keys.extend(key for job in work.jobs for key in job.keys)
        assert work.possible
        return in_memory(1, work)

    found = driven(partial(jp.basins, wells, refine=3, **keywords), noted)
    done = found.computed.values == 1
    assert len(keys) == len({*keys}) > 2
    assert 16 < done.sum() < 0.7 * done.size
    assert (found.attractor.values[done] == whole.attractor.values[done]).all()
    assert np.mean(found.attractor.values == whole.attractor.values) > 0.98
    assert found.refinement_level.values.max() == 3
    random = found.pair_kind.values == PAIRS.index("random")
    assert (found.uncertain_fraction.values[random] == whole.uncertain_fraction.values[random]).all()


def test_both_motions_of_the_impact_pair_are_found_from_their_starts():
    (y1, v1), (y3, v3) = strobed(3.6, 0.8, (2.0, -1.8, 0.5), 1), strobed(3.6, 0.8, (1.0, -1.8, 1.3), 1)
    found = jp.basins(RATTLE, plane={"y": [y1, y3], "v": [v1, v3]}, uncertainty=False, n_jobs=1)
    number = dict(zip(found.period.values.tolist(), found.number.values.tolist(), strict=True))
    assert number == {1: 1, 3: 2}
    assert found.attractor.sel(y=y1, v=v1) == 1
    assert found.attractor.sel(y=y3, v=v3) == 2
    assert found.section_plane.values[0, 0] == pytest.approx(Symmetric(3.6, 0.8).at_zero, abs=1e-6)
    assert np.isfinite(found.section_plane.values[:, :, 0]).sum(axis=1).tolist() == [1, 3]
    assert "uncertainty_exponent" not in found


def test_a_chaotic_motion_is_one_attractor():
    plane = {"y": span(-1.0, 1.0, 5), "v": span(-1.0, 1.0, 5)}
    found = jp.basins(catalog.duffing(amplitude=0.3), plane=plane, turns=64, patience=0, n_jobs=1)
    assert found.period.values.tolist() == [0]
    assert found["count"].values.tolist() == [25]
    assert math.isnan(float(found.uncertainty_exponent))


@pytest.mark.nightly
def test_the_linkage_has_four_motions_at_a_quarter_of_a_millimetre():
    plane = {"eccentricity_ratio_x": span(-0.6, 0.6, 5), "eccentricity_ratio_y": span(-0.6, 0.6, 5)}
    mechanism = catalog.chunmei2002(2.5e-4, gear_ratio=3.0)
    found = jp.basins(mechanism, plane=plane, turns=40, patience=6, tolerance=5e-3)  # five take 30 and more
    assert found.period.values.tolist() == [1, 1, 2, 6]
    assert int(found["count"].sum()) == 25


@pytest.mark.parametrize(
    "speed", [None, pytest.param(80.0, marks=pytest.mark.nightly)], ids=["motor", "speed"]
)
def test_starts_side_by_side_are_those_alone_with_the_journal_as_asked(speed):
    mechanism = catalog.chunmei2002(2.5e-4, **({"speed": speed} if speed else {}))
    place = Starts(mechanism, None, ("eccentricity_ratio_x", "journal_velocity_y"))
    nodes = np.array([[0.3, 0.1], [-0.9, -0.2], [1.2, 0.0], [1e5, 0.0]])  # out of the bearing, out of reach
    starts, journals = place.all(nodes), Journals(place.model)
    assert [start is None for start in starts] == [False, False, True, True]
    states, own = np.array([start.state for start in starts[:2]]), place.model.state[None]
    assert place.projected(states) == pytest.approx(nodes[:2], abs=1e-9)
    held = [(journals.positions(each)[:, 1], journals.velocities(each)[:, 0]) for each in (states, own)]
    assert held[0][0] == pytest.approx(np.repeat(held[1][0], 2), abs=1e-13)
    assert held[0][1] == pytest.approx(np.repeat(held[1][1], 2), abs=1e-9)
    n_q, h = states.shape[1] // 2, 1e-7  # velocities are what positions do along the speeds
    ways = [np.hstack([each * states[:, n_q:], 0 * states[:, n_q:]]) for each in (h, -h)]
    late, early = (
        journals.positions(states + w, i * h * (speed or 0)) for w, i in zip(ways, (1, -1), strict=True)
    )
    assert journals.velocities(states) == pytest.approx((late - early) / (2 * h), abs=1e-6)
    assert np.array_equal(states, [place(node).state for node in nodes[:2]])


def test_starts_with_a_crank_and_a_journal_have_both():
    place = Starts(catalog.chunmei2002(2.5e-4), None, ("crank_angle", "eccentricity_ratio_x"))
    nodes = np.array([[0.5, 0.2], [1.0, -0.4]])
    states = np.array([start.state for start in place.all(nodes)])
    assert place.projected(states) == pytest.approx(nodes, abs=1e-9)


def test_a_slow_approach_is_no_chaos():
    start = Starts(RATTLE, None, ("y", "v"))
    node = start((-0.3, 0.7))
    hasty, patient = (end_states(start.model, [node], Observation(0, 8, n, 1e-3, 1e-8))[0] for n in (0, 6))
    assert (hasty[:2], patient[:2]) == ((0, 0), (0, 1))
    assert len(hasty[2]) == 8


def test_a_period_is_not_longer_than_the_tolerance_tells():
    spiral = np.array([[1.0], [1.0004], [0.9998], [1.0001]])
    assert shortest_period(spiral, 4, 1e-3) == 1
    assert shortest_period(np.array([[0.0], [1.0], [0.0002], [1.0]]), 4, 1e-3) == 2
    assert shortest_period(np.array([[0.0], [1.0], [2.0], [1.0]]), 4, 1e-3) == 4
    assert shortest_period(np.array([[0.0], [1.0], [0.0]]), 3, 1e-3) == 3
    assert shortest_period(spiral, 0, 1e-3) == 0


def ends_to_match():
    """Three motions of period 2, 1 and 1, and two chaotic ones; ends of each, shuffled together."""
    random = np.random.default_rng(5)
    exact = [(2, [[0.0, 0.0], [1.0, 0.0]]), (1, [[0.5, 0.0]]), (1, [[-0.5, 0.0]])]
    found = [(p, np.roll(points, i, axis=0) + 1e-5 * i) for p, points in exact for i in range(6)]
    clouds = [random.normal((x, 0.0), (0.3, 1.0), size=(60, 2)) for x in (-2.0, 2.0) for _ in range(6)]
    return found + [(0, cloud) for cloud in clouds] + [(0, np.zeros((0, 2)))]


def test_ends_are_matched_whatever_their_order():
    ends = ends_to_match()
    labels = np.repeat([3, 2, 1, 4, 5, 0], [6, 6, 6, 6, 6, 1])
    for seed in range(3):
        order = np.random.default_rng(seed).permutation(len(ends))
        periods, points = zip(*(ends[i] for i in order), strict=True)
        found = match(np.array(periods), list(points), 1e-3)
        assert found.labels.tolist() == labels[order].tolist()
        assert found.periods.tolist() == [1, 1, 2, 0, 0]
        assert [found.labels[i] for i in found.shown_by] == [1, 2, 3, 4, 5]


def test_periodic_ends_belong_to_the_first_that_is_within_the_tolerance():
    chain = [np.array([[x]]) for x in (0.0, 0.8, 1.6)]
    found = match(np.ones(3, dtype=int), chain, 1.0)
    assert found.labels.tolist() == [1, 1, 2]
    assert found.shown_by.tolist() == [0, 2]


def test_the_distance_of_sets_is_that_of_the_loneliest_point():
    one, other = np.array([[[0.0, 0], [1, 0], [0, 0]]]), np.array([[0.0, 0], [1, 0.2], [3, 0]])
    assert set_distance(one, other).tolist() == [2.0]
    assert set_distance(np.array([other]), one[0]).tolist() == [2.0]


def test_starts_that_cannot_be_have_no_attractor_and_those_that_come_to_rest_have():
    walls = jp.basins(
        catalog.impact_pair(1.0, 0.8), plane={"y": [0.0, 0.7], "v": [0.1, 1.0]}, turns=4, n_jobs=1
    )
    assert walls.node_status.values[1].tolist() == [STATUS.index("bad_parameters")] * 2
    assert walls.attractor.values[1].tolist() == [0, 0]
    assert (float(walls.fraction.sum()), float(walls.fraction_none)) == (1.0, 0.0)  # of those that start
    rested = jp.basins(
        catalog.impact_pair(0.2, 0.6), plane={"y": [-0.095, 0.0], "v": [0.3, 1.0]}, turns=8, n_jobs=1
    )
    assert not rested.node_status.values.any()
    assert rested.attractor.values.all()


def test_all_failed_is_a_status():
    found = jp.basins(RATTLE, plane={"y": [0.0, 0.7], "v": [0.1, 1.0]}, turns=4, max_steps=3, n_jobs=1)
    assert STATUS[int(found.status)] == "step_limit"
    assert found.sizes["number"] == 0
    assert float(found.fraction_none) == 1


@pytest.mark.nightly
def test_workers_do_not_change_the_answer():
    plane = {"y": span(-1.7, 1.7, 10), "v": span(-2.0, 2.0, 10)}
    keywords = {"plane": plane, "turns": 16, "transient": 30, "pairs": 10}
    one, two = (jp.basins(RATTLE, n_jobs=n, **keywords).drop_vars("wall_time") for n in (1, 2))
    assert one.identical(two)


def test_a_refined_grid_keeps_the_numbers():
    coarse, fine = (
        jp.basins(
            RATTLE, plane={"y": span(-1.5, 1.5, n), "v": span(-2.1, 2.1, n)}, turns=16, patience=20, n_jobs=1
        )
        for n in (4, 7)
    )
    assert coarse.period.values.tolist() == fine.period.values.tolist() == [1, 3]
    assert (fine.attractor.values[::2, ::2] == coarse.attractor.values).all()


@pytest.mark.parametrize("count", [0, 1, 7, 50, 100])
def test_wilsons_interval(count):
    known = binomtest(count, 100).proportion_ci(0.95, method="wilson")
    assert wilson(np.array(count), 100) == pytest.approx((known.low, known.high), abs=1e-12)


def test_no_starts_have_no_fraction():
    assert np.isnan(wilson(np.array([0]), 0)).all()


def agrees(rows, known, within):
    found, error = uncertainty_exponent(rows)
    assert abs(found - known) < 3 * error
    assert error < within


@pytest.mark.parametrize("slope", [0.0, 0.37, 3.0])
def test_a_straight_boundary_has_exponent_one(slope):
    x, y = np.meshgrid(np.linspace(-1, 1, 160), np.linspace(-1, 1, 120), indexing="ij")
    agrees(grid_pairs(1 + (x + slope * y > 0.1 * (1 + slope)).astype(int)), 1.0, 0.1)


def cantor_label(x, depth=20):
    """1 or 2, by the generation of the middle third that x is in: its boundary is Cantor's set."""
    found, place = np.full(np.shape(x), 2), np.array(x, dtype=float)
    for generation in range(depth):
        third = np.clip(np.floor(3 * place), 0, 2)
        inside = (third == 1) & (found == 2)
        found[inside] = 3 + generation % 2
        place = 3 * place - third
    return np.where(found > 2, found - 2, 1 + depth % 2)


def test_a_boundary_of_cantors_set_has_its_exponent():
    """From the grid along x; along y nothing changes, and those pairs do not spoil it."""
    x = np.linspace(-0.3, 1.3, 3000)
    labels = np.repeat(np.where((x > 0) & (x < 1), cantor_label(x), 1)[:, None], 9, axis=1)
    found, error = uncertainty_exponent(grid_pairs(labels))
    assert found == pytest.approx(1 - CANTOR, abs=max(3 * error, 0.02))
    assert error < 0.05
    assert grid_pairs(labels)[-1].differing == 0


@pytest.mark.long
def test_random_pairs_of_cantors_set_have_its_exponent():
    """A plane of Cantor's set times a line, at distances that halve, in all directions."""
    axes = {"x": np.linspace(0.0, 1.0, 60), "y": np.linspace(0.0, 1.0, 60)}
    points, distances = random_pairs(axes, 25_000)
    apart = np.linalg.norm(points[:, 1:] - points[:, :1], axis=-1)
    assert apart == pytest.approx(np.broadcast_to(distances, apart.shape))
    labels = cantor_label(np.clip(points[..., 0], 0, 1))
    rows = [count_pairs(2, e, labels[:, 0], labels[:, 1 + i]) for i, e in enumerate(distances)]
    found, error = uncertainty_exponent(rows)
    assert found == pytest.approx(1 - CANTOR, abs=max(3 * error, 0.02))
    assert error < 0.05


def test_random_pairs_begin_at_half_a_mean_step_of_the_grid():
    points, distances = random_pairs({"x": np.linspace(-1.0, 1.0, 5), "y": np.linspace(0.0, 9.0, 3)}, 4)
    assert distances == pytest.approx([3 / 16, 3 / 32, 3 / 64, 3 / 128, 3 / 256])
    apart = (points[:, 1:] - points[:, :1]) / [2.0, 9.0]
    assert np.linalg.norm(apart, axis=-1) == pytest.approx(np.broadcast_to(distances, (4, 5)))


def test_distances_of_pairs_are_in_lengths_of_the_axes():
    rows = grid_pairs(np.ones((33, 17), dtype=int))
    assert [(row.kind, row.distance) for row in rows] == [
        *((0, k / 32) for k in (1, 2, 4)),
        *((1, k / 16) for k in (1, 2)),
    ]


def test_pairs_without_a_label_do_not_count():
    row = count_pairs(0, 0.1, np.array([1, 1, 0, 2]), np.array([1, 2, 1, 0]))
    assert (row.count, row.differing, row.fraction) == (2, 1, 0.5)
    assert math.isnan(uncertainty_exponent([row])[0])


def test_kinds_of_pairs_share_a_slope_and_nothing_else():
    rows = [
        Pairs(kind, e, 10**6, round(10**6 * size * e**0.5))
        for kind, size in enumerate((0.1, 0.8))
        for e in (0.01, 0.04, 0.1)
    ]
    assert uncertainty_exponent(rows)[0] == pytest.approx(0.5, abs=1e-3)
    assert len(PAIRS) == 3


def test_an_uneven_axis_gives_no_pairs():
    plane = {"y": np.geomspace(0.1, 1.5, 16), "v": span(-1, 1, 16)}
    found = jp.basins(catalog.duffing(amplitude=0.0), plane=plane, turns=8, transient=10, n_jobs=1)
    assert set(found.pair_kind.values.tolist()) == {1}


def test_every_problem_is_told_at_once():
    with pytest.raises(InputError) as caught:
        jp.basins(
            RATTLE,
            plane={"y": [0, 1], "w": [0, 1]},
            turns=2,
            transient=-1,
            tolerance=0,
            pairs=-1,
            patience=0.5,
            uncertainty=1,
            joint="B",
            rtol=1.0,
        )
    keys = [problem.key for problem in caught.value.problems]
    assert sorted(keys) == sorted(
        [*("plane.w", "turns", "transient", "tolerance", "pairs", "patience", "uncertainty", "joint", "rtol")]
    )


def test_every_variable_says_what_it_is():
    found = jp.basins(RATTLE, plane={"y": [0.0, 0.5], "v": [0.5, 0.8]}, turns=8, n_jobs=1)
    assert all(
        {"units", "long_name"} <= variable.attrs.keys()
        for variable in found.variables.values()
        if variable.dtype.kind not in "US"
    )
    meanings = found.attractor.attrs["flag_meanings"].split()
    assert len(meanings) == found.sizes["number"] + 1


def test_two_chaotic_motions_that_mirror_each_other_are_two():
    plane = {"y": span(-0.55, 0.55, 5), "v": span(-1.5, 1.5, 5)}
    found = jp.basins(catalog.impact_pair(1.2, 0.6), plane=plane, transient=50, patience=1, n_jobs=1)
    assert found.period.values.tolist() == [0, 0]
    means = found.section_plane.mean("point").values
    assert abs(means[0, 0] - means[1, 0]) > 0.4
