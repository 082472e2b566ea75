"""Largest forces over a parameter: of motions that have settled, soon or later, as direct runs have them."""

from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment import curves
from jointplay.analysis.assessment.settled import plan, present
from jointplay.analysis.quantities import STATUS

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


def test_what_cannot_be_or_start_so_or_is_not_followed_is_a_status(here):
    slower = {"crank_speed": 1.0}  # than the one that is imposed
    bad = curves.Scene(here, KEY, slower, 20, HOW).rows(np.array([1.0]))
    assert bad == [{"status": BAD}]
    ended = curves.Scene(here, KEY, None, 20, replace(HOW, max_steps=5)).rows(np.array([1.0]))
    assert ended == [{"status": STATUS.index("step_limit")}]
    found = curves.Scene(here, KEY, None, 20, HOW).rows(np.array([1.0, -1.0]))
    assert (found[0]["status"], found[1]) == (0, {"status": BAD})
