"""Largest forces over a parameter: of motions that have settled, soon or later, as direct runs have them."""

from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment import alternatives, curves
from jointplay.analysis.assessment.assess import first_change, sided
from jointplay.analysis.assessment.edges import Search
from jointplay.analysis.assessment.page import BY
from jointplay.analysis.assessment.settled import SLOW, followed, plan, present
from jointplay.analysis.quantities import STATUS
from jointplay.jobs.values import read, written
from jointplay.solver.mechanism.catalog.presets import four_bar_pins, joined
from jointplay.solver.motion.progress import OutOfTime
from tests.support.unshown import TEN

pytestmark = pytest.mark.long  # the first one compiles for six seconds
HOW = plan(40, 32, 60, 1e-7, None)
BAD = STATUS.index("bad_parameters")
KEY = "joints.B.clearance"
LINKAGE = jp.catalog.slider_crank(clearance={"B": 1e-4})


@pytest.fixture(scope="module")
def here():
    return present(LINKAGE, None, HOW)


def test_what_soon_repeats_closely_is_not_followed_further(here, monkeypatch):
    """A tenfold clearance repeats every second turn. Where no points are close enough all are followed."""
    asked, plain = [], curves.settle_together

    def counted(points, how):
        asked.append((how, [model.clearances[0] for _, model in points if model.clearances]))
        return plain(points, how)

    monkeypatch.setattr(curves, "settle_together", counted)
    scene = curves.Scene(here, KEY, None, 20, HOW)
    where = np.array([0.7, 1.0, 10.0])
    found = scene.rows(where)
    looked = [(how.transient, how.turns, how.tolerance, given) for how, given in asked if given]
    assert looked[0] == (8, 4, curves.CLOSELY, pytest.approx(1e-4 * where))
    assert looked[1] == (18, 8, None, pytest.approx([1e-3]))
    assert [row["period"] for row in found] == [1, 1, 2]
    monkeypatch.setattr(curves, "CLOSELY", 1e-30)
    asked.clear()
    later = scene.rows(where[:2])
    assert [len(given) for _, given in asked if given] == [2, 2]
    for one, other in zip(found, later, strict=False):
        np.testing.assert_allclose(one["peak"], other["peak"], rtol=1e-6)


@pytest.mark.parametrize("key", [KEY, "speed"])
def test_forces_along_a_curve_are_those_of_a_settled_motion_run_directly(here, key):
    where, start = np.array([0.8, 1.1, 1.2]), {"crank_angle": 0.7}
    found = curves.Scene(here, key, start, 20, HOW).rows(where)
    for ratio, row in zip(where, found, strict=True):
        place = LINKAGE.varied({key: ratio * (1e-4 if key == KEY else 200.0)})
        motion = jp.simulate(place, transient=60, turns=2, rtol=1e-10, samples_per_turn=5000)
        by_name = dict(zip(motion["pin"].values, motion["largest_reaction"].values, strict=True))
        largest = [float(motion["largest_force"][0]), *(by_name[name] for name in row["names"][1:])]
        assert row["period"] == 1
        np.testing.assert_allclose(row["peak"], largest, rtol=2e-5)
        ideal = jp.simulate(place.replace(clearance=0.0), turns=1, rtol=1e-10, samples_per_turn=5000)
        by_name = dict(zip(ideal["pin"].values, ideal["largest_reaction"].values, strict=True))
        np.testing.assert_allclose(row["ideal"], [by_name[name] for name in row["names"]], rtol=1e-6)


def test_a_curve_that_is_cut_short_has_values_far_apart_and_goes_on_with_those_between(monkeypatch):
    """Of a motion that has not settled: cut in each group of values, it ends as one that is not cut."""
    for name, value in {"VALUES": 9, "FIRST": (4, 2, 1)}.items():
        monkeypatch.setattr(curves, name, value)
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    now = followed(mechanism, None, replace(HOW, transient=2, turns=4))
    assert not now.period
    assert not now.traits["chaos"]
    how = replace(HOW, transient=4, turns=4, lyapunov_turns=4)
    whole, rows = curves.curve(now, KEY, None, 2, how), curves.Scene.rows
    assert whole["status"] == 0
    assert "known" not in whole
    known, looked, left = None, [], [0]

    def cut(scene, where):
        left[0] -= 1
        if left[0] < 0:
            raise OutOfTime
        return rows(scene, where)

    monkeypatch.setattr(curves.Scene, "rows", cut)
    with pytest.raises(OutOfTime):
        curves.curve(now, KEY, None, 2, how)
    for _ in range(3):
        left[0] = 1
        part = curves.curve(now, KEY, None, 2, how, known)
        looked.append(np.flatnonzero(part["statuses"] != curves.NOT_RUN).tolist())
        assert part["status"] == curves.NOT_RUN
        known = read(written(part["known"]))  # as of a journal
        assert np.isfinite(part["peak"][looked[-1]]).all()
    assert looked == [[0, 3, 4, 8], [0, 2, 3, 4, 6, 8], [*range(9)]]
    monkeypatch.setattr(curves.Scene, "rows", rows)
    again = curves.curve(now, KEY, None, 2, how, known)
    for name in ("statuses", "peak", "ideal", "impact_speed", "grade", "change"):
        np.testing.assert_array_equal(again[name], whole[name])


@pytest.fixture(scope="module")
def press():
    """A crank-rocker of steel bars: contact is lost from 27.68 to 29.75 µm, between two values of a curve."""
    sizes = {"crank": 0.04, "coupler": 0.16, "rocker": 0.11}
    bar = {"bar": {"width": 0.02, "thickness": 0.01}, "material": "steel"}
    links = [jp.Link(name=name, length=length, shape=bar) for name, length in sizes.items()]
    pins = four_bar_pins(0.04, 0.16, 0.11, 0.17)
    joints = joined(pins, "", radius=0.006, stiffness=1e7, damping=300.0, friction=0.1)
    drive = jp.ConstantSpeed(link="crank", speed=10 * np.pi)
    return jp.Mechanism(links=links, joints=joints, drive=drive).replace(clearance={"B": 3e-5})


@pytest.mark.nightly
def test_an_edge_between_two_values_of_a_curve_is_where_the_grade_changes(press):
    """With the numbers of direct runs on both sides of it."""
    here = present(press, None, HOW)
    scene = curves.Scene(here, KEY, None, 20, HOW)
    where = np.array([25e-6, 27.25e-6, 30e-6, 31e-6, 32e-6]) / 3e-5
    coarse = scene.change(scene.rows(where[:3]) + scene.rows(where[3:]), where, -1)
    assert 3e-5 * coarse[:, 0] == pytest.approx([25.2e-6, 25.2e-6], rel=5e-3)
    found = sided(press, here.plain(), KEY, "below", Search(1.02, 0.005, 1e-3), 20, HOW, 1e6, {})
    change = first_change(coarse, found["beside"])
    assert change[:, 0] == pytest.approx([29.7511e-6 / 3e-5] * 2, rel=1e-5)
    assert change[:, 1].tolist() == [0, 1]
    for factor, (*_, force, ratio, hit, _) in zip((1.005, 0.995), change, strict=True):
        run = jp.simulate(press.varied({KEY: factor * 29.7511e-6}), transient=100, turns=2, rtol=1e-9)
        assert force == pytest.approx(float(run["largest_force"][0]), rel=1e-3)
        speeds = np.abs(run["event_normal_velocity"].values[jp.words(run)["event_kind"].values == "contact"])
        assert (speeds.size > 0) == (hit > 0) == (factor < 1)
        assert hit == pytest.approx(speeds.max(initial=0.0), rel=1e-3)
        assert 1.2 < ratio < 1.4


class Graded(curves.Scene):
    """Grades over a parameter: 3 from 1.2 times the present value on, of motions that have not settled.

    They become 0, or 2 from `far` on.
    """

    def __init__(self, far):
        self.far = far

    def row(self, ratio, settled):
        mark = 0 if ratio < (self.far if settled else 1.2) else 2 if settled else 3
        peak, hit = np.array([ratio]), np.zeros(1)
        return {
            "grade": mark,
            "peak": peak,
            "ideal": peak,
            "impact_speed": hit,
            "settled": settled or not mark,
        }

    def _row_at(self, ratio):
        return self.row(ratio, False)

    def _longer(self, row):
        row |= self.row(row["peak"][0], True)


@pytest.mark.parametrize(("far", "end"), [(1.45, 1.45), (1.3, 1.3), (100.0, np.nan)])
def test_a_grade_of_what_has_not_settled_is_asked_of_what_it_becomes(far, end):
    scene, where = Graded(far), np.array([0.5, 0.7, 1.0, 1.25, 1.5])
    rows = [scene.row(ratio, False) for ratio in where]
    (inner, *_), (ratio, mark, *_, by) = scene.change(rows, where, 1)
    if np.isnan(end):
        assert np.isnan(ratio)
        assert [row["grade"] for row in rows] == [0] * 5
    else:
        assert (inner, ratio) == pytest.approx((end, end), rel=0.01)
        assert (mark, BY[int(by)]) == (2, "values")
        assert inner < end <= ratio
    assert rows[3]["settled"]


@pytest.mark.parametrize("slow", [True, False])
def test_what_may_still_swing_has_no_grade_and_no_number_with_other_contact_data(here, slow, monkeypatch):
    values = here.values | {"period": ((), 0), "section_exponent_per_turn": ((), np.nan)}
    swinging = replace(here, values=values, orbit=None)
    scene = curves.Scene(here, KEY, None, 20, HOW)
    scene.slow, scene._on_orbit = slow, lambda *_: None
    answer = {"status": 0, "mechanism": here.mechanism, "motion": swinging, "model": None}
    assert np.isnan(scene._row(1e-4, answer, {})["grade"]) == slow
    monkeypatch.setattr(alternatives, "reached", lambda *_: swinging)
    found = alternatives.hangs_on(replace(here, radius=0.99 if slow else 0.5), 2, HOW)
    assert set(found["period"]) == {0}
    assert np.isnan(found["peak"]).all() == slow


def test_what_cannot_be_or_start_so_or_is_not_followed_is_a_status(here):
    slower = {"crank_speed": 1.0}  # than the one that is imposed
    bad = curves.Scene(here, KEY, slower, 20, HOW).rows(np.array([1.0]))
    assert bad == [{"status": BAD}]
    ended = curves.Scene(here, KEY, None, 20, replace(HOW, max_steps=5)).rows(np.array([1.0]))
    assert ended == [{"status": STATUS.index("step_limit")}]
    found = curves.Scene(here, KEY, None, 20, HOW).rows(np.array([1.0, -1.0]))
    assert (found[0]["status"], found[1]) == (0, {"status": BAD})


def test_what_settles_slowly_with_other_contact_data_is_sought_longer():
    """A third and three times the damping; with ten times the stiffness it swings for thousands of turns."""
    here = present(TEN["crank-rocker without friction"](), None, HOW)
    assert here.radius > SLOW
    found = alternatives.hangs_on(here, 2, HOW)
    assert found["change"].tolist() == ["÷10", "×10", "÷3", "×3"]
    assert found["period"].tolist() == [1, 0, 1, 1]
    assert np.isfinite(found["peak"]).all(axis=1).tolist() == [True, False, True, True]
