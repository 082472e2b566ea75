"""Adaptive maps of functions that are known everywhere: what is computed, and what stands for the rest."""

import itertools
import math

import numpy as np
import pytest

from jointplay.analysis.sweeps.bifurcation import Features, alike
from jointplay.analysis.sweeps.subdivision import Box, coarse, refined, representatives


def run(shape, levels, function, told=lambda looks: len(set(looks)) < 2, shuffle=False):
    """The computed points, the map as it stands, the boxes, and the rounds it took."""
    rounds = []

    def looked(needed, _):
        rounds.append(needed)
        points = reversed(needed) if shuffle else needed
        return {point: function(*point) for point in points}

    boxes, computed = refined(shape, levels, told, looked)
    place, level = representatives(shape, boxes, computed)
    values = np.array([function(*np.unravel_index(at, shape)) for at in place.flat]).reshape(shape)
    return computed, values, level, boxes, rounds


def disc(i, j):
    return int((i - 30) ** 2 + (j - 20) ** 2 < 15**2)


def exact(shape, function):
    return np.array([[function(i, j) for j in range(shape[1])] for i in range(shape[0])])


def test_a_disc_is_found_whole_by_few_points():
    shape = (65, 49)
    computed, values, level, boxes, rounds = run(shape, 4, disc)
    np.testing.assert_array_equal(values, exact(shape, disc))
    assert len(computed) < 0.25 * math.prod(shape)
    assert sum(map(len, rounds)) == len(computed) == len({*itertools.chain(*rounds)})
    assert level.max() == 4
    assert level[0, 48] == 0
    assert len(rounds) <= 6
    for box in boxes:  # none is left whole that has unlike points on it
        known = {
            computed[p] for p in itertools.product(*map(range, box.low, np.add(box.high, 1))) if p in computed
        }
        assert len(known) < 2 or not box.parts


def test_each_round_tells_half_of_what_was_left():
    said = []

    def looked(needed, tell):
        tell(0.0)
        tell(1.0)
        return {point: disc(*point) for point in needed}

    refined((65, 49), 4, lambda looks: len(set(looks)) < 2, looked, said.append)
    ends = [1 - 0.5**n for n in range(len(said) // 2 + 1)]
    assert said == [end for pair in itertools.pairwise(ends) for end in pair]
    assert len(said) > 6


def test_nothing_depends_on_the_order_of_answers():
    first, again = (run((40, 33), 3, disc, shuffle=shuffle) for shuffle in (False, True))
    assert first[4] == again[4]
    np.testing.assert_array_equal(first[1], again[1])
    np.testing.assert_array_equal(first[2], again[2])


def test_what_is_the_same_everywhere_costs_corners_alone():
    computed, _, level, *_ = run((33, 33), 4, lambda i, j: 7)
    assert sorted(computed) == [(i, j) for i in (0, 16, 32) for j in (0, 16, 32)]
    assert (level == 0).all()


def test_what_differs_everywhere_is_computed_whole():
    shape = (11, 6)
    computed, values, *_ = run(shape, 2, lambda i, j: 100 * i + j)
    assert len(computed) == math.prod(shape)
    np.testing.assert_array_equal(values, exact(shape, lambda i, j: 100 * i + j))


def test_a_point_on_a_border_halves_the_box_beside_it():
    """One box's corners are alike, but a point on its border, which its neighbour asked for, is not."""
    odd = {(4, 8), (6, 12)}
    computed, values, level, *_ = run((9, 17), 3, lambda i, j: int((i, j) in odd))
    assert (4, 8) not in computed  # nothing touches it: that is not seen
    odd |= {(8, 16)}
    computed, values, level, *_ = run((9, 17), 3, lambda i, j: int((i, j) in odd))
    assert values[4, 8] == 1
    assert level[4, 4] > 0


@pytest.mark.parametrize("levels", [0, 1, 3, 6])
@pytest.mark.parametrize("shape", [(1,), (2,), (30,), (1, 17), (5, 1)])
def test_one_parameter_and_narrow_grids(shape, levels):
    step = lambda *at: int(at[-1] > 0.6 * shape[-1] or at[0] > 0.7 * shape[0])  # noqa: E731
    computed, values, *_ = run(shape, levels, step)
    whole = np.array([step(*at) for at in np.ndindex(shape)]).reshape(shape)
    np.testing.assert_array_equal(values, whole)
    assert len(computed) <= math.prod(shape)
    assert all(values[at] == look for at, look in computed.items())


def test_boxes_cover_the_grid_and_parts_their_box():
    seen = np.zeros((10, 7))
    for box in coarse((10, 7), 2):
        seen[tuple(slice(a, b + 1) for a, b in zip(box.low, box.high, strict=True))] += 1
    assert seen.min() == 1
    box = Box((0, 4), (5, 5), 1)
    assert [(part.low, part.high) for part in box.parts] == [((0, 4), (2, 5)), ((2, 4), (5, 5))]
    assert Box((0, 4), (1, 5), 1).parts == []
    assert box.nearest((2, 4)) == (0, 4)
    assert box.nearest((3, 5)) == (5, 5)


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (Features(0, 1, -1.2, 0.01), True),
        (Features(0, 1, -1.6, 0.01), False),
        (Features(0, 1, -1.6, 0.5), True),
        (Features(0, 1, -1.6, math.nan), False),
        (Features(0, 1, math.nan, math.nan), False),
        (Features(0, 1, -math.inf, math.nan), False),
        (Features(0, 2, -1.0, 0.01), False),
        (Features(4, 1, -1.0, 0.01), False),
    ],
)
def test_motions_are_alike_by_period_status_and_exponent(other, same):
    one = Features(0, 1, -1.0, 0.01)
    assert alike(0.5)([(one,), (other,)]) == same
    assert alike(0.5)([(one, one), (one, other)]) == same
    assert alike(0.5)([(one,)])
    unknown = Features(0, 1, math.nan, math.nan)
    assert alike(0.5)([(unknown,), (Features(0, 1, math.nan, math.nan),)])
