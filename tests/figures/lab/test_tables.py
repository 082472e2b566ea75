"""Tables of the studies of the paper: every number that is there is written, and none that is not."""

import numpy as np
import pytest

from jointplay import figures
from jointplay.display.errors import InputError
from tests.figures.support.synthetic import response
from tests.figures.support.synthetic_tables import READINGS, claims, readings


def words(figure) -> list[str]:
    return [text.get_text().replace("\n", " ") for ax in figure.axes for text in ax.texts]


def shades(figure) -> dict[tuple[float, float], float]:
    """How light each cell of a table is, by its corner."""
    boxes = [patch for patch in figure.axes[0].patches if hasattr(patch, "get_xy")]
    return {tuple(np.round(patch.get_xy(), 3)): patch.get_facecolor()[0] for patch in boxes}


def test_readings_are_rows_and_panels_are_named_with_their_settings():
    said = words(figures.draw(readings()))
    assert {name.replace("_", " ") for name in READINGS} <= set(said)
    assert "(a) $e$ = 0.029 mm, $i$ = 15" in said
    assert "(c) $e$ = 0.29 mm, $i$ = 3" in said
    assert said.count("+0.420 ± 0.031") == 3
    assert said.count("\N{MINUS SIGN}0.810 ± 0.031") == 8
    assert said.count("none") == 3
    assert said.count("7.12") == 3
    assert said.count("\N{EN DASH}") == 3  # the cell that was not computed


def test_chaotic_cells_are_darker_than_periodic_and_lost_ones():
    data = readings()
    light = shades(figures.draw(data))
    by_column = {}
    for (x, _), lightness in sorted(light.items()):
        by_column.setdefault(x, []).append(lightness)
    columns = list(by_column.values())
    assert len(columns) == 12  # four a panel
    assert set(columns[2]) == {1.0}
    assert max(columns[10][:3]) < 0.5
    assert 1.0 in columns[10]


def test_section_points_lie_where_their_reading_is():
    data = readings()
    ax = figures.draw(data).axes[0]
    circles = [patch for patch in ax.patches if hasattr(patch, "get_radius")]
    assert len(circles) == 3 * len(READINGS)
    assert len(ax.lines) == 3 * len(READINGS)
    middles = {tuple(np.round(patch.get_center(), 3)) for patch in ax.patches if hasattr(patch, "get_xy")}
    assert {tuple(np.round(circle.get_center(), 3)) for circle in circles} <= middles
    first, line = circles[0], ax.lines[0]
    place = data.section_x.values[0, 0, 0] * first.get_radius() + first.get_center()[0]
    assert line.get_xdata()[0] == pytest.approx(place)
    higher = data.section_y.values[0, 0, 0] * first.get_radius()
    assert line.get_ydata()[0] == pytest.approx(first.get_center()[1] - higher)


def test_a_lost_cell_is_told():
    assert "crashed" in figures.draw(readings()).get_suptitle()


def test_points_need_not_be_stored():
    assert figures.draw(readings().drop_vars(["section_x", "section_y"])).axes[0].lines[:] == []


def test_every_conclusion_has_its_grade_and_all_of_its_ratios():
    data = claims()
    figure = figures.draw(data)
    titles = [place.get_suptitle().replace("\n", " ") for place in figure.subfigs]
    for text, grade, words in zip(
        data.claim_text.values, ("undecidable", "not", "partly"), titles, strict=False
    ):
        assert str(text)[1:] in words
        assert words.endswith(f": {grade}")
    peaks, impacts = (place.axes[0] for place in figure.subfigs[:2])
    drawn = {
        line.get_label(): line.get_xydata().tolist()
        for line in peaks.lines[1:]
        if line.get_marker() != "None"
    }
    assert drawn == {
        "as concluded": [[0.5, 0.0]],
        "undecided": [[1.2, 0.0]],
        "not as concluded": [[1.5, 1.0]],
    }
    assert peaks.lines[0].get_xdata() == [1.0, 1.0]
    assert (peaks.get_xscale(), impacts.get_xscale()) == ("linear", "log")
    (grades,) = peaks.child_axes
    said = [tick.get_text() for tick in grades.get_yticklabels()]
    assert said == ["reproduced: 1 of 1, 1 undecided", "not: 0 of 1"]


def test_a_conclusion_without_ratios_is_told_in_words():
    said = "".join(text.get_text() for text in figures.draw(claims()).subfigs[3].axes[0].texts)
    assert said.replace("\n", " ").startswith("a: periodic 1; a: periodic 1;")


@pytest.mark.parametrize("kind", ["readings", "claims"])
def test_another_result_is_refused(kind):
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(response(section=False), kind=kind)
