"""Trials of an optimisation that fail: none is kept as a design, none starts another."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.optimize
import xarray as xr

import jointplay as jp
from jointplay.analysis.gradients import optimise
from jointplay.analysis.gradients import optimise as trials_module
from jointplay.analysis.gradients.optimise import (
    INVALID,
    Aim,
    Trial,
    Trials,
    _designs_tried,
    best,
    descended,
    neighbour_values,
)

FREE = np.array([[-np.inf, np.inf]])


def trial(value, status=0, x=0.0, share=1.0):
    return Trial(np.array([x]), np.array([float(value)]), np.zeros((1, 1)), status, 0, share)


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2), (1, 2, 0), (0, 2, 1), (2, 0, 1)])
def test_the_best_of_some_is_the_best_that_has_a_motion(order):
    """A failed trial may hold any numbers; wherever it stands it is neither kept nor in the way."""
    aim, each = Aim(0, 1.0, FREE, np.zeros(1), np.ones((1, 3))), (trial(5.0), trial(-9.0, 4), trial(3.0))
    assert best([each[i] for i in order], aim, 0.0) is each[2]
    lost = [trial(1.0, 4), trial(0.0, 2)]
    assert best(lost, aim, 0.0) is lost[0]


def answered(value, slope, status=0, state=1.0):
    found = xr.Dataset({"value": ("quantity", [value]), "derivative": (("quantity", "parameter"), [[slope]])})
    return found.assign(
        status=status,
        derivative_status=0,
        orbit_state=("state", [state]),
        orbit_state_derivative=(("state", "parameter"), [[2.0]]),
    )


def test_a_failed_trial_starts_no_other(monkeypatch):
    """An orbit is sought from that of the last trial which has one, though others failed since."""
    asked, answers = [], [answered(1.0, 1.0), answered(1.0, 1.0, 3, 7.0), answered(1.0, np.nan, 0, 8.0)]
    answers += [answered(np.nan, 1.0, 0, 9.0), answered(2.0, 1.0)]

    def gradient(mechanism, **keywords):
        asked.append(keywords.get("initial"))
        return answers.pop(0)

    monkeypatch.setattr(trials_module, "gradient", gradient)
    system, told = jp.catalog.duffing(), []
    name = next(iter(system.parameters))
    low = system.parameters[name]
    runs = Trials(system, ("end:state:x",), {name: (low, low + 1.0)}, {}, 1.0, [], told.append)
    found = [runs.at(np.array([x])) for x in (0.0, 0.1, 0.2, 0.3, 0.4)]
    assert [each.status for each in found] == [0, 3, INVALID, INVALID, 0]
    assert asked[0] is None
    assert np.ravel(asked[1:]) == pytest.approx([1.2, 1.4, 1.6, 1.8])
    assert runs.at(np.array([0.1])) is found[1]
    assert told == [1, 2, 3, 4, 5]


def test_failed_trials_have_no_objective():
    made = [trial(5.0), trial(1.0, 4), trial(3.0, share=0.5)]
    runs = Trials(jp.catalog.duffing(), ("end:state:x",), {"a": (0.0, 1.0)}, {}, 1.0, made, lambda n: None)
    table = _designs_tried(runs, Aim(0, 1.0, FREE, np.zeros(1), np.ones((1, 3))))
    assert np.isnan(table["objective"]).tolist() == [False, True, True]
    assert np.isnan(table["tried_missed"]).tolist() == [False, True, True]


def test_designs_beside_an_optimum_differ_by_a_share_of_each_variable_or_lie_at_its_bound():
    """Of two variables from 2 to 6 and from 0 to 10, at 4 and at 10; the quantity is their sum."""
    low, width = np.array([2.0, 0.0]), np.array([4.0, 10.0])

    def tried(x):
        return Trial(x, np.array([np.sum(low + width * x)]), np.zeros((1, 2)), 0, 0, 1.0)

    runs = SimpleNamespace(low=low, width=width, by=("a", "b"), tried=tried)
    aim = Aim(0, 1.0, FREE, np.zeros(1), np.ones((1, 3)))
    table = neighbour_values(runs, aim, tried(np.array([0.5, 1.0])), 0.01, 1e-6)
    assert table["neighbour_objective"].ravel() == pytest.approx([13.96, 14.04, 13.9, np.nan], nan_ok=True)
    assert table["neighbour_gain"] == pytest.approx(0.1)


class Bowl:
    """Trials of (x - 0.9)^2; after the first some have no motion."""

    def __init__(self, failing):
        self.made, self.failing = [], failing

    def at(self, x):
        status = 4 if 0 < len(self.made) <= self.failing else 0
        found = Trial(x, (x - 0.9) ** 2, 2 * (x - 0.9)[None], status, 0, 1.0)
        self.made.append(found)
        return found


@pytest.mark.parametrize("failing", [0, 1, 6])
def test_a_box_that_failures_have_drawn_in_grows_again(failing):
    """After six it is 2.4e-4 of the range wide, and the best design lies further off than forty such."""
    aim = Aim(0, 1.0, FREE, np.zeros(1), np.ones((1, 3)))
    end, found = descended(Bowl(failing), aim, np.array([0.1]), 1e-10, 1000)
    assert end == "converged"
    assert found.x[0] == pytest.approx(0.9, abs=1e-4)


def test_where_the_first_step_fails_the_search_goes_on_from_the_first_design():
    """That was tried before, to know the sizes; below 0.2 nothing moves, and the slope leads to 0 at once."""
    known = {}

    def at(x):
        if x[0] not in known:
            known[x[0]] = Trial(x, x + 5.0, np.ones((1, 1)), 4 if x[0] < 0.2 else 0, 0, 1.0)
            runs.made.append(known[x[0]])
        return known[x[0]]

    runs = SimpleNamespace(made=[], at=at)
    at(np.array([0.4]))
    _, found = descended(runs, Aim(0, 1.0, FREE, np.zeros(1), np.ones((1, 3))), np.array([0.4]), 1e-10, 1000)
    assert found.x[0] == pytest.approx(0.2, abs=2e-3)


def test_what_scipy_says_of_points_that_it_clips_is_not_shown(monkeypatch, recwarn):
    def minimize(*given, **how):
        warnings.warn("Values in x were outside bounds", RuntimeWarning, stacklevel=1)
        return scipy.optimize.minimize(*given, **how)

    monkeypatch.setattr(optimise, "minimize", minimize)
    assert descended(Bowl(0), Aim(0, 1.0, FREE, np.zeros(1), np.ones((1, 3))), np.array([0.1]), 1e-10, 100)
    assert not recwarn.list


@pytest.mark.parametrize(("last", "kept"), [(1.0, 1.0), (0.2, 10**-0.75), (0.0, 0.0)])
def test_after_a_share_of_play_that_fails_a_smaller_step_is_tried(monkeypatch, last, kept):
    """`last` is the largest share at which constraints can be kept."""
    tried = []

    def at_share(share):
        return SimpleNamespace(share=share, at=lambda x: trial(0.0, share=share))

    def descended(part, *_):
        tried.append(part.share)
        return "converged", trial(0.0, 0 if part.share <= last else 4, share=part.share)

    monkeypatch.setattr(optimise, "_with_share", lambda trials, share: at_share(share))
    monkeypatch.setattr(optimise, "descended", descended)
    aim = SimpleNamespace(sized=lambda trial: aim, missed=lambda trial: 0.0)
    end, _, share = optimise.opened(at_share(1.0), aim, np.zeros(1), 1e-6, 100)
    assert end == ("converged" if last == 1 else "infeasible")
    assert share == pytest.approx(kept)
    for i, each in enumerate(tried):
        if each > last and i + 1 < len(tried):
            assert max(s for s in tried[:i] if s <= last) < tried[i + 1] < each
