"""Options that every figure has, the formats it can be saved in, and how notebooks show it."""

import contextlib
import inspect
import io
import math

import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure
from PIL import Image

from jointplay import figures
from jointplay.cli import results
from jointplay.display.errors import InputError
from jointplay.study.results.store import write_figure
from tests.figures.support.synthetic import response, section
from tests.figures.test_pictures import PICTURES
from tests.support.wrong import problems_of


def test_width_and_font_are_those_asked_for():
    figure = figures.draw(section(), width=120, font="STIXGeneral")
    assert figure.get_size_inches()[0] == pytest.approx(120 / 25.4)
    assert {label.get_fontname() for label in figure.axes[0].get_xticklabels()} == {"STIXGeneral"}
    assert figures.draw(section()).axes[0].xaxis.label.get_fontname() == "DejaVu Sans"  # and of no other


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"width": 5}, "figure.width"),
        ({"width": "wide"}, "figure.width"),
        ({"font": "No Such Font"}, "figure.font"),
        ({"font": 8}, "figure.font"),
        ({"ax": 1}, "figure.ax"),
    ],
)
def test_wrong_general_options_are_told(options, key):
    assert list(problems_of(figures.draw, section(), options)) == [key]


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name, made in PICTURES.items() if not {"x", "y"} & {*made()[1]}])
def test_all_has_room_at_the_least_width(name):
    dataset, options = PICTURES[name]()
    kind = options.get("kind", name.split(" ")[0])
    width = max(figures.registry.ABOUT[kind].least, 88.0)
    figure = figures.draw(dataset, {"kind": kind} | options | {"width": width})
    unit = figure.dpi / 25.4
    for ax in figure.axes:
        ends = ax.get_tightbbox()
        assert ax.get_label() == "<colorbar>" or ax.get_window_extent().width >= 15 * unit
        assert -2.5 * unit <= ends.x0 <= ends.x1 <= (width + 2.5) * unit
    for ends in (legend.get_window_extent() for legend in figure.legends):
        assert -2.5 * unit <= ends.x0 <= ends.x1 <= (width + 2.5) * unit
    if width > 88.0:
        with pytest.raises(InputError, match=rf"figure\.width: got {width - 1}; a width in mm, {width:g} to"):
            figures.draw(dataset, {"kind": kind} | options | {"width": width - 1})


def test_each_file_of_a_command_is_drawn_once_as_it_was_laid_out(tmp_path, monkeypatch):
    picture, drawn, once = figures.draw(section()), [], Figure.draw
    places = [ax.get_position().bounds for ax in picture.axes]
    monkeypatch.setattr(figures, "draw", lambda *_: picture)
    monkeypatch.setattr(Figure, "draw", lambda self, way: (drawn.append(way), once(self, way)))
    results.draw(None, {}, [tmp_path / "a.pdf", tmp_path / "a.png"])
    assert len(drawn) == 2
    assert [ax.get_position().bounds for ax in picture.axes] == places


def test_a_figure_of_one_panel_is_drawn_in_given_axes():
    mine, axes = plt.subplots(1, 2)
    plt.close(mine)
    assert figures.draw(response(), {"kind": "journal_orbit", "ax": axes[1]}) is mine
    assert not axes[0].lines
    assert axes[1].lines
    assert "r_x" in axes[1].get_xlabel()
    assert axes[1].get_legend() is not None
    with pytest.raises(InputError, match="2 panels"):
        figures.draw(section(), {"ax": axes[0]})


def test_a_figure_of_several_panels_is_drawn_in_a_subfigure():
    mine = plt.figure(layout="constrained")
    plt.close(mine)
    above, below = mine.subfigures(2, 1)
    assert figures.draw(response(status="diverged"), {"ax": below}) is mine
    assert len(below.axes) == 4
    assert not above.axes
    assert "diverged" in below.get_suptitle()


@pytest.mark.nightly
def test_every_format_that_is_offered_works(tmp_path):
    figure = figures.draw(response(), {"kind": "phase_portrait"})
    forms = {*figure.canvas.get_supported_filetypes()} - {"pgf"}  # needs LaTeX
    assert {"jpg", "tiff", "webp", "pdf", "svg", "eps"} <= forms
    for form in sorted(forms):
        assert write_figure(figure, tmp_path / f"picture.{form}").stat().st_size > 1000, form
    assert Image.open(tmp_path / "picture.jpg").size[0] == pytest.approx(88 / 25.4 * 300, abs=1)


def test_notebooks_show_a_figure():
    shown = Image.open(io.BytesIO(figures.draw(response())._repr_png_()))
    assert shown.format == "PNG"
    assert shown.size[0] > 600


STRANGE = (1000, "zzz", [1], {}, True, -1, 1.5, (), ["zzz"], [None], math.nan, {"a": 1}, [[1, 2]], b"x")


@pytest.mark.parametrize(("option", "value"), [("variables", 1000), ("maps", True), ("over", "diagram.nc")])
def test_what_is_no_name_and_no_result_is_told(option, value):
    assert [problem.key for problem in figures.problems({option: value})] == [f"figure.{option}"]


@pytest.mark.nightly
@pytest.mark.parametrize("name", PICTURES)
def test_strange_values_of_every_option_are_drawn_or_told(name):
    dataset, options = PICTURES[name]()
    kind = options.get("kind") or figures.usual_kind(dataset, options)
    for option in list(inspect.signature(figures.KINDS[kind]).parameters)[1:]:
        for value in STRANGE:
            with contextlib.suppress(InputError):
                figures.draw(dataset, options | {option: value})
