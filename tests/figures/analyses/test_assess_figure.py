"""The figure of an assessment: grades behind its curves."""

import numpy as np
import pytest

from jointplay import figures
from jointplay.solver import Status
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


def test_parameters_that_were_not_looked_at_have_words_and_no_panel():
    found = assessment()
    whole = figures.draw(found, {"kind": "assess"})
    found["curve_status"].loc[{"parameter": KEYS[0]}] = Status.NOT_RUN
    part = figures.draw(found, {"kind": "assess"})
    *panels, line = part.axes
    assert len(panels) == len(whole.axes) - 2
    assert all(ax.lines or ax.patches for ax in panels)
    assert [text.get_text() for text in line.texts] == [
        "Forces and impact speeds over these were not looked at: radial clearance of joint B."
    ]
    assert part.get_figheight() < whole.get_figheight()
    found["curve_status"][:] = Status.NOT_RUN
    assert not figures.draw(found, {"kind": "assess"}).legends


def test_a_curve_that_was_cut_short_is_drawn_through_what_was_looked_at():
    found = assessment()
    found["curve_status"][:] = Status.NOT_RUN
    found["curve_status"][0, ::12] = Status.OK
    part = figures.draw(found, {"kind": "assess"})
    (ideal, loose, *_), ratios = part.axes[0].lines, found["curve_ratio"].values[0, ::12]
    for line in (ideal, loose):
        assert line.get_xdata() == pytest.approx(200 * ratios)
    texts = [text.get_text() for legend in part.legends for text in legend.get_texts()]
    assert "unknown" not in texts
    assert "5 values and their grades" in texts
