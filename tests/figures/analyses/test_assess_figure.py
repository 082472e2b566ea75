"""The figure of an assessment: grades behind its curves."""

import numpy as np
import pytest

from jointplay import figures
from tests.figures.support.synthetic_assessment import KEYS, assessment


@pytest.mark.parametrize(("change", "end"), [(1.15, 1.15), (1.3, None)])
def test_a_grade_ends_where_it_changes_and_else_in_the_middle_of_two_values(change, end):
    """Of two values of the curve, 1.10 and 1.21 times 0.2 mm, the second has another grade."""
    found = assessment()
    found["grade_change_ratio"].loc[{"parameter": KEYS[0], "side": "above", "place": "after"}] = change
    ratios = found["curve_ratio"].sel(parameter=KEYS[0]).values
    first = int(np.flatnonzero(ratios > 1.2)[0])
    ax = figures.draw(found, {"kind": "assess"}).axes[0]
    spans = [patch.get_extents().transformed(ax.transData.inverted()).x1 for patch in ax.patches]
    expected = end or np.sqrt(ratios[first] * ratios[first - 1])
    assert min(abs(x - 200 * expected) for x in spans) < 1e-6 * 200
