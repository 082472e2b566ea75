"""Optimisation: against closed forms of a forced oscillator, and what it says where there is no optimum."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.gradients.optimise import Aim, Trial, best
from jointplay.study.toml_text import written
from tests.support import optima

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def found():
    """Optima of the oscillator."""
    return optima.all_found()


@pytest.mark.long
def test_resonance(found):
    """The amplitude 1 / sqrt((k - w^2)^2 + (c w)^2) is largest at k = w^2."""
    one = found["resonance"]
    assert one["end"] == "converged"
    assert one["optimum"] == pytest.approx([optima.FREQUENCY**2], rel=1e-6)
    assert one["value"] == pytest.approx([1 / (optima.DAMPING * optima.FREQUENCY)], rel=1e-9)
    assert max(one["confirmed_to"]) < 1e-6
    assert one["neighbour_gain"] == 0
    assert max(one["neighbours"]) < one["value"][0]


def test_progress_is_told_design_by_design_and_ends_at_one(found):
    begin, *designs, end = dict.fromkeys(found["progress"])
    assert (begin, end) == (0.0, 1.0)
    assert designs == pytest.approx([n / 100 for n in range(1, len(designs) + 1)])
    assert len(designs) > 3


def test_a_constraint_holds_at_the_optimum(found):
    """The smallest change of c that keeps the amplitude at resonance below a ends at 1 / (a w)."""
    one = found["damped"]
    assert one["optimum"] == pytest.approx([1 / (optima.AMPLITUDE * optima.FREQUENCY)], rel=1e-6)
    assert one["missed"] < 1e-6


def test_what_cannot_be_kept_is_said(found):
    assert found["impossible"]["end"] == "infeasible"
    assert found["impossible"]["missed"] > 0.1


def approaching(power=1):
    """A state that after a unit of time is k^power (1 - 1/e)."""
    return {"states": {"x": 0.0}, "parameters": {"k": 1.0}, "rates": {"x": f"k**{power} - x"}}


def kept(limits, first, power=1, **how):
    """The optimum of the least change of k that keeps the state after a unit of time within limits."""
    system = jp.System(name="approaching", **approaching(power)).varied({"k": first})
    return jp.optimise(system, by={"k": (-20.0, 20.0)}, subject={"end:state:x": limits}, orbit=False, **how)


@pytest.mark.parametrize(
    ("first", "limits", "reached"),
    [
        (1.0, (5.0, 10.0), 5.0),
        (1.0, (5.0, 1e9), 5.0),
        (1.0, (5.0, math.inf), 5.0),
        (-3.0, (0.0, 1e9), 0.0),
        (9.0, (-math.inf, 3.0), 3.0),
        (9.0, (-1e9, 3.0), 3.0),
    ],
)
def test_a_limit_is_kept_however_far_the_other_one_lies(first, limits, reached):
    """Each is judged by its own size: a share of the larger one is no tolerance of the smaller one."""
    found = kept(limits, first)
    assert jp.words(found)["end"].item() == "converged"
    assert found["value"].values == pytest.approx([reached], rel=1e-7, abs=1e-7)
    assert found["optimum"].values == pytest.approx([reached / (1 - math.exp(-1))], rel=1e-6, abs=1e-6)
    assert float(found["missed"]) <= 1e-8
    assert "is required" not in str(jp.summary(found))


def test_a_limit_is_kept_from_a_start_that_is_far_larger_than_it():
    """A billion at first: a share of that is no tolerance of 5."""
    found = kept((-math.inf, 5.0), 10.0, power=9)
    assert found["before"].values[0] > 5e8
    assert found["value"].values == pytest.approx([5.0], rel=1e-7)
    assert float(found["missed"]) <= 1e-8


@pytest.mark.parametrize(
    ("limits", "required"), [((0.1, 0.5), "at most 0.5"), ((5.0, math.inf), "at least 5")]
)
def test_the_summary_names_a_limit_that_is_not_met(limits, required):
    """However the search ended: a result that holds 1 where another value was required."""
    found = kept(limits, 1.0)
    assert "is required" not in str(jp.summary(found))
    missed = found.assign(value=found["value"] * 0 + 1, missed=found["missed"] * 0 + 0.8)
    assert f"state at the end, x is 1, and {required} is required" in str(jp.summary(missed))


def test_limits_of_a_study_file_may_be_infinite(tmp_path):
    rows = ['kind = "optimise"', "[mechanism]", *(f"{k} = {written(v)}" for k, v in approaching().items())]
    rows += ["[analysis]", "orbit = false", "by = { k = [0.5, 20.0] }"]
    rows += ['subject = { "end:state:x" = [5.0, inf] }']
    (path := tmp_path / "one_sided.toml").write_text("\n".join(rows), encoding="utf-8")
    assert jp.run(path)["value"].values == pytest.approx([5.0], rel=1e-7)
    changed = jp.run(path, analysis={"subject": {"end:state:x": (-math.inf, 0.5)}})
    assert changed["value"].values == pytest.approx([0.5], rel=1e-7)


@pytest.mark.parametrize("limits", [(math.nan, 1.0), (1.0, math.nan), (math.inf, math.inf), (2.0, 1.0)])
def test_limits_of_which_no_value_lies_within_are_refused(limits):
    with pytest.raises(jp.InputError, match="a lowest value below the highest"):
        kept(limits, 1.0)


def test_a_design_without_motion_is_never_best():
    aim = Aim(0, 1.0, np.array([[-np.inf, np.inf]]), np.zeros(1), np.ones((1, 3)))
    good, lost = (
        Trial(np.zeros(1), np.array([v]), np.zeros((1, 1)), s, 0, 1) for v, s in ((5.0, 0), (1.0, 4))
    )
    assert best([lost, good], aim, 0.0) is good
    assert best([good, lost], aim, 0.0) is good


def test_wrong_requests_are_refused_at_once():
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-5)
    with pytest.raises(jp.InputError) as error:
        jp.optimise(
            mechanism, by={"gear_ratio": (20.0, 30.0), "clearence": (1e-5, 2e-5)}, least="larges:time"
        )
    text = str(error.value)
    assert "clearence" in text
    assert "larges:time" in text
    with pytest.raises(jp.InputError, match="hold the present value"):
        jp.optimise(mechanism, by={"gear_ratio": (20.0, 30.0)}, least="time")
    with pytest.raises(jp.InputError, match="begins without"):
        jp.optimise(mechanism, by={"clearance": (1e-5, 3e-5)}, least="time", ideal=True)


def test_a_multiplier_is_of_the_orbit_alone():
    """Impact pair: the product of both is r^4, and they are a complex pair; no motion has any."""
    pair, start = jp.catalog.impact_pair(3.6, 0.8), {"initial": (-0.35, 0.77), "transient": 60}
    found = jp.optimise(pair, by={"restitution": (0.7, 0.9)}, least="multiplier_modulus:1", **start)
    assert found["optimum"].values == pytest.approx([0.7], rel=1e-6)
    assert found["value"].values == pytest.approx([0.49], rel=1e-6)
    assert np.isnan(found["after"].values).all()
    assert "does not settle" not in str(jp.summary(found))


@pytest.mark.nightly
def test_forces_of_all_joints_are_those_of_the_motions_before_and_after():
    linkage, mass = jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=15.0), "links.coupler.mass"
    how = {"rtol": 1e-8, "orbit": False, "max_iterations": 3}
    found = jp.optimise(linkage, by={mass: (0.17, 0.18)}, least="largest:reaction:O", **how)
    assert found["joint"].values.tolist() == ["B", "O", "A", "C"]
    for side, value in (("before", float(found["first_value"][0])), ("after", float(found["optimum"][0]))):
        run = jp.simulate(linkage.varied({mass: value}), turns=1, samples_per_turn=50_000, rtol=1e-10)
        forces = [run.normal_force.max("time"), *run.reaction.max("time")]
        largest = [float(each.squeeze()) for each in forces]
        assert found[f"force_{side}"].values == pytest.approx(largest, rel=1e-3)
    assert found["force_after"].values[1] < found["force_before"].values[1]


@pytest.mark.nightly
def test_the_chaotic_four_bar_keeps_contact():
    """The shipped study: what is found keeps contact, from the usual start too, with a fifth of the force."""
    found = jp.run(ROOT / "studies" / "optima" / "optimise_contact.toml")
    assert float(found["play_kept"]) == 1
    assert found["before"].values[0] > 100
    assert found["value"].values[0] < 60
    assert found["after"].values == pytest.approx(found["value"].values, rel=1e-4)
    assert found["after"].values[1] > 2
    assert (found["force_after"] < found["force_before"]).all()
