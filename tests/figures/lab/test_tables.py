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


def test_every_conclusion_has_its_grade_and_all_of_its_evidence():
    data = claims()
    said = words(figures.draw(data))
    assert {"undecidable", "not", "partly", "reproduced"} <= set(said)
    assert {str(text) for text in data.evidence.values} <= {
        f"{text} " if ";" in text else text for text in said
    }
    assert {str(text) for text in data.claim_text.values} <= set(said)


def test_a_reproduced_conclusion_is_darkest_and_long_evidence_has_room():
    ax = figures.draw(claims()).axes[0]
    cells = [patch for patch in ax.patches if patch.get_x() == pytest.approx(49)]
    assert [cell.get_facecolor()[0] < 1 for cell in cells] == [False, False, True, True]
    assert cells[3].get_facecolor()[0] < cells[2].get_facecolor()[0]
    figure = ax.figure
    figure.draw_without_rendering()
    for text in ax.texts:
        box = text.get_window_extent().transformed(ax.transData.inverted())
        holders = [
            patch for patch in ax.patches if patch.get_window_extent().contains(*text.get_window_extent().p0)
        ]
        assert box.x1 <= 180
        for cell in holders:
            assert text.get_window_extent().height <= cell.get_window_extent().height
            assert text.get_window_extent().width <= cell.get_window_extent().width


@pytest.mark.parametrize("kind", ["readings", "claims"])
def test_another_result_is_refused(kind):
    with pytest.raises(InputError, match=r"figure\.kind"):
        figures.draw(response(section=False), kind=kind)
