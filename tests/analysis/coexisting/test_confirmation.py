"""What makes a knock confirmed, an edge state one, and two motions without a period the same."""

import math
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.analysis.coexisting import tipping as edge_module
from jointplay.analysis.coexisting.attractors import distance
from jointplay.analysis.coexisting.knocks import ABOVE, AT, BELOW, smallest
from jointplay.analysis.coexisting.lasting import FAILED, UNSETTLED, Lasting, along
from jointplay.analysis.coexisting.tipping import Boundary, edge_state
from tests.analysis.coexisting.test_tipping import told


def test_the_smallest_knock_is_improved_round_by_round():
    """On a grid of three phases and four directions the best is 7 % larger than the smallest, 0.5."""

    def over(place, size):
        edge = 1.0 - 0.3 * math.cos(place.direction - 1.0) - 0.2 * math.cos(place.phase - 2.9)
        return int(size > edge + 0.1 * place.point)

    ways, phases = np.arange(4) * math.pi / 2, np.arange(3) * math.tau / 3
    grid = 1.0 - 0.3 * np.cos(ways - 1.0).max() - 0.2 * np.cos(phases - 2.9).max()
    assert grid > 1.05 * 0.5
    found = smallest(told(over), 3, 4, np.arange(1, 17) / 10)
    assert 0.5 <= found.high < 0.5 + 0.2 * (grid - 0.5)


@pytest.mark.parametrize(
    ("at_below", "at_above", "confirmed"),
    [(0, 1, True), (0, UNSETTLED, False), (FAILED, 1, False), (0, 0, False), (0, FAILED, False)],
)
def test_a_knock_is_confirmed_where_less_returns_and_more_reaches_another_motion(
    at_below, at_above, confirmed
):
    """A hundredth below and above; farther out it is as if nothing else were there."""

    def over(place, size):
        if 0.985 < size < 0.9985:
            return at_below
        return at_above if size > 1.006 else int(size > 1.0)

    found = smallest(told(over, False), 1, 2, np.array([1.003]))
    assert found.high == pytest.approx(1.0, abs=2e-3)
    assert (found.ends[BELOW], found.ends[AT], found.ends[ABOVE]) == (at_below, 1, at_above)
    assert (found.confirmed == found.high) == confirmed
    assert math.isnan(found.share) == confirmed


class Approached:
    """A boundary whose states come back at once."""

    def __init__(self):
        self.inside, self.section = np.zeros(2), SimpleNamespace(differ=lambda one, other: one - other)

    def close(self):
        pass

    def turn(self):
        return True

    def plane(self, state):
        return None


def test_an_edge_state_is_sought_where_the_boundary_has_come_to(monkeypatch):
    """Twice the same state is an orbit's, wherever the boundary was before."""
    monkeypatch.setattr(edge_module, "_solved", lambda section, state, period: SimpleNamespace(state=state))
    seen = [np.array([x, 0.0]) for x in (3.0, 2.0, 1.0, 1.0)]
    assert edge_module._refined(Approached(), seen).state is seen[-1]
    assert edge_module._refined(Approached(), seen[:-1]) is None


@pytest.mark.parametrize(
    ("unstable", "taken"), [((0.9, 0.1), False), ((1.7, 0.1), True), ((-1.7, 0.1), True), ((1.7, 1.2), False)]
)
def test_an_edge_state_leaves_the_boundary_in_one_direction_alone(monkeypatch, unstable, taken):
    orbit = SimpleNamespace(status=0, state=np.zeros(2), image=SimpleNamespace(derivative=None))
    monkeypatch.setattr(edge_module, "replace", lambda section, **_: section)
    monkeypatch.setattr(edge_module, "solved", lambda *_: orbit)
    monkeypatch.setattr(edge_module, "shortest", lambda orbit, _: orbit)
    monkeypatch.setattr(edge_module, "multipliers", lambda _: np.array(unstable))
    assert (edge_state(Approached(), 3) is orbit) == taken


@dataclass(frozen=True)
class Angle:
    """A motion that starts at an angle."""

    state: np.ndarray
    fold: np.ndarray = field(default_factory=lambda: np.array([True]))


def test_a_pair_that_a_turn_parts_is_halved_in_again_about_the_boundary():
    """A turn takes angles ten thousand times as far off, and on by a whole turn."""
    edge = 2.0

    def image(state, _):
        return SimpleNamespace(status=0, state=edge + 1e4 * (state - edge) + math.tau)

    def sort(models):
        return np.array([int(each.state[0] > edge) for each in models])

    section = SimpleNamespace(image=image, differ=lambda one, other: one - other, place=None)
    motions = SimpleNamespace(base=Angle(np.zeros(1)), sort=sort)
    pair = Boundary(motions, 0, section, np.array([edge - 1e-8]), np.array([edge + 1e-8]))
    for _ in range(3):
        assert pair.turn()
        assert pair.width <= 1e-9
        assert pair.inside[0] <= edge < pair.outside[0]
        pair.inside, pair.outside = pair.inside - 1e-8, pair.outside + 1e-8


def test_nothing_runs_along_a_motion_without_a_period():
    points = np.zeros((1, 48, 2))
    for period, found in ((1, True), (0, False)):
        motion = Lasting(period, np.zeros((1, 2)), np.zeros((1, 2)))
        assert along(points, motion, 1e-3, 1e-4).tolist() == [found]


@pytest.mark.parametrize(("away", "near"), [(9, True), (11, False)])
def test_nine_in_ten_points_of_a_motion_without_a_period_have_to_be_near(away, near):
    cloud = 10.0 * np.arange(100.0)[:, None]
    other = cloud.copy()
    other[:away] += 1e4
    one, two = ({"period": 0, "points": points} for points in (cloud, other))
    there, back = distance(one, two)
    assert (there < 0.5) == near
    assert (back < 0.5) == near
    periodic = distance(one | {"period": 100}, two | {"period": 100})
    assert min(periodic) > 0.5  # of one with a period every point
