"""Derivatives of numbers in a parameter at the end of what it can be."""

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.starts import placed
from jointplay.display.errors import InputError
from jointplay.solver.mechanism.directions import SIDES, along


def elastic(restitution):
    return placed(catalog.impact_pair(3.0, restitution), None, jp.CrankAngle())


def test_only_where_that_is_accepted_one_side_is_enough():
    found = along(elastic, 1.0, precise=False)
    assert found.rates == pytest.approx([1.0], rel=1e-12)
    with pytest.raises(InputError):
        along(elastic, 1.0)


@pytest.mark.parametrize("sides", SIDES)
def test_every_side_has_the_sixth_order(sides):
    from jointplay.solver.mechanism.directions import slope

    errors = [
        abs(slope(lambda x: np.array([math.exp(x)]), 0.0, h, np.ones(1), (sides,))[0] - 1)
        for h in (0.1, 0.05)
    ]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(6, abs=0.5)
