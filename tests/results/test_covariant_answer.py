"""What the answer of covariant vectors says: where chaos lives, how near subspaces come, what is in doubt."""

import numpy as np
import pytest

import jointplay as jp
from tests.figures.analyses.test_covariant_figure import vectors


def said(*changes, **more):
    return list(jp.summary(vectors(*changes, **more)).lines)


def test_chaos_lives_where_the_growing_direction_is():
    first, second = said()
    assert first == (
        "chaos lives in the play of B 90 %, the bending of links 8 %, the crank's motion 2 % "
        "(the direction that grows by +1.600 ± 0.020 per turn)"
    )
    assert second == "angle of the growing direction with the others: at least 1°, median 4.5°"


def test_nothing_grows_and_two_directions_grow():
    errors = ("vector", np.full(3, 1.0))
    (line,) = said(covariant_standard_error_per_turn=errors)
    assert line.startswith("no chaos: no direction grows significantly; the leading one, +1.6 ± 1.0 per turn")
    *_, angles = said(covariant_exponent_per_turn=("vector", [1.6, 0.2, -1.0]))
    assert angles.startswith("angle of the 2 growing directions with the others: at least 10°")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"settling_residual": ("vector", [0.0, 0.1, 0.002])}, "vectors 2, 3 have not settled"),
        ({"block_spread": 21.0}, "the last vectors are inaccurate"),
        ({"lost": 1}, "1 direction lost at events"),
    ],
)
def test_doubts_are_told(changes, words):
    assert words in said(**changes)[-1]
    assert len(said(**changes)) == 3
