"""The paper's scheme against the whole: each case's errors as stored, lines that end where they are lost."""

import numpy as np
import pytest

from jointplay import figures
from jointplay.display.errors import InputError
from tests.figures.support.synthetic import response
from tests.figures.support.synthetic_tables import schemes


def panels(figure):
    """The panels of passes, the panel of run times, the panel of words."""
    *passes, work, words = figure.axes
    return passes, work, words


def test_each_number_of_windows_has_a_panel_with_a_line_a_case():
    data = schemes()
    passes, _, _ = panels(figures.draw(data))
    assert [ax.get_title(loc="left") for ax in passes] == ["(a) 1 window per turn", "(b) 48 windows per turn"]
    for number, ax in enumerate(passes):
        assert ax.get_yscale() == "log"
        for line, stored in zip(ax.lines, data.pass_deflection_error.values[:, number], strict=True):
            finite = np.isfinite(stored)
            np.testing.assert_array_equal(line.get_ydata()[finite], stored[finite])
            assert np.isnan(line.get_ydata()[~finite]).all()
            np.testing.assert_array_equal(line.get_xdata(), data["pass"].values)


def test_cases_that_are_lost_are_counted_and_do_not_stretch_the_scale():
    first, second = panels(figures.draw(schemes()))[0]
    assert [text.get_text().replace("\n", " ") for text in first.texts] == [
        "1 of 3 cases grow beyond measure"
    ]
    assert not second.texts
    assert first.get_ylim()[1] == pytest.approx(1e3)


def test_run_times_of_both_methods_are_those_stored():
    data = schemes()
    _, work, _ = panels(figures.draw(data))
    assert (work.get_xscale(), work.get_yscale()) == ("log", "log")
    stored = [*data.scheme_run_time.values, *data.monolithic_run_time.values]
    for line, seconds in zip(work.lines, stored, strict=True):
        np.testing.assert_allclose(line.get_xdata(), 1e3 * seconds)
    assert {line.get_linestyle() for line in work.lines} == {"None"}
    hollow = [line.get_markerfacecolor() == "white" for line in work.lines]
    assert hollow == [True] * 3 + [False] * 3


def test_cases_differ_without_colour_and_are_named():
    _, work, words = panels(figures.draw(schemes()))
    looks = {line.get_marker() for line in work.lines[:3]}
    assert len(looks) == 3
    names = [text.get_text() for text in words.get_legend().get_texts()]
    assert names[:3] == [str(case) for case in schemes().case.values]
    assert len(names) == 5


@pytest.mark.long
@pytest.mark.parametrize(
    ("measure", "label"), [("angle", "Error of the angles (rad)"), ("change", "Change from the pass before")]
)
def test_another_measure(measure, label):
    passes, _, _ = panels(figures.draw(schemes(), measure=measure))
    assert passes[0].get_ylabel().startswith(label)


def test_what_does_not_fit_is_refused():
    with pytest.raises(InputError, match="did you mean 'angle'"):
        figures.draw(schemes(), measure="angel")
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(response(section=False), kind="scheme_comparison")
