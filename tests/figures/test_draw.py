"""Choosing a figure, and what is said of options that do not fit."""

import subprocess
import sys
import warnings

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

from jointplay import figures
from jointplay.kinds import KINDS
from tests.figures.support.synthetic import oscillator, response, section
from tests.support.wrong import refused


def keys(options: dict, dataset=None) -> dict[str, str]:
    """The problems that drawing with `options` reports: what is accepted, by key."""
    return refused(figures.draw, response() if dataset is None else dataset, options)


def panels(figure: Figure) -> int:
    return len(figure.axes)


def test_kind_follows_the_dataset():
    assert panels(figures.draw(response())) == 4
    assert panels(figures.draw(section())) == 2
    assert panels(figures.draw(oscillator())) == 2
    assert panels(figures.draw(response().drop_dims(["joint", "event"]))) == 1


OF_A_MOTION = (*KINDS["response"].figures, *KINDS["section"].figures)


@pytest.mark.parametrize("kind", OF_A_MOTION)
def test_every_kind_draws_a_response_with_a_section(kind):
    figure = figures.draw(response(), {"kind": kind})
    assert isinstance(figure, Figure)
    lowest = figure.axes[-1:] if kind == "contact_angle" else figure.axes  # its panels share the time axis
    labels = [ax.get_xlabel() for ax in lowest] + [ax.get_ylabel() for ax in figure.axes]
    assert all(label.endswith(")") or "/" in label for label in labels)  # a unit, or a ratio


@pytest.mark.parametrize("kind", OF_A_MOTION)
def test_panels_have_room_beside_their_labels(kind):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figures.draw(response(), {"kind": kind}).draw_without_rendering()


@pytest.mark.parametrize("kind", OF_A_MOTION)
def test_every_kind_draws_a_run_without_samples(kind):
    none = response(status="crashed").isel(time=slice(0, 0), event=slice(0, 0), turn=slice(0, 0))
    figure = figures.draw(none, {"kind": kind})
    assert "crashed" in figure.get_suptitle()
    words = {text.get_text().replace("\n", " ") for ax in figure.axes for text in ax.texts}
    assert words & {"No samples in this run", "The run never crossed the section"}


@pytest.mark.parametrize(
    ("options", "key", "hint"),
    [
        ({"kind": "journal_orbits"}, "figure.kind", "did you mean 'journal_orbit'?"),
        ({"kind": "orbit"}, "figure.kind", "did you mean 'journal_orbit'?"),
        ({"kind": "time_history", "link": "CRANK"}, "figure.link", "did you mean 'crank'?"),
        ({"kind": "time_history", "variabels": ["x"]}, "figure.variabels", "did you mean 'variables'?"),
        ({"tunrs": 3}, "figure.tunrs", "did you mean 'turns'?"),
        (
            {"kind": "time_history", "variables": "normal_forse"},
            "figure.variables",
            "mean 'normal_force'?",
        ),
        ({"kind": "time_history", "link": "crnak"}, "figure.link", "did you mean 'crank'?"),
        ({"kind": "time_history", "turns": "all"}, "figure.turns", "a number of turns"),
        ({"kind": "time_history", "turns": -1}, "figure.turns", "greater than 0"),
        ({"kind": "time_history", "turns": [90, 91]}, "figure.turns", "0 to 0.45 s"),
        ({"kind": "time_history", "turns": 2, "time": [0, 1]}, "figure.time", "not both"),
        ({"kind": "time_history", "time": [1, 0]}, "figure.time", "increasing"),
        ({"kind": "time_history", "axis": "minutes"}, "figure.axis", "accepted: time, turns, angle"),
        ({"kind": "time_history", "events": ["contacts"]}, "figure.events", "did you mean 'contact'?"),
        ({"kind": "time_history", "column": "triple"}, "figure.column", "accepted: single, double"),
        ({"kind": "journal_orbit", "joint": "C"}, "figure.joint", "accepted: B"),
        ({"kind": "phase_portrait", "x": "excentricity"}, "figure.x", "did you mean 'eccentricity'?"),
        (
            {"kind": "poincare_section", "y": "contact_angel"},
            "figure.y",
            "mean 'contact_angle'?",
        ),
        ({"kind": "poincare_section", "zoom": "yes"}, "figure.zoom", "true or false"),
        ({"kind": "poincare_section", "turns": [50, 60]}, "figure.turns", "counted from 0"),
    ],
)
def test_wrong_options_are_named_with_what_is_accepted(options, key, hint):
    assert hint in keys(options)[key]


def test_all_unknown_options_are_reported_at_once():
    assert set(keys({"kind": "overview", "a": 1, "b": 2})) == {"figure.a", "figure.b"}
    assert [problem.key for problem in figures.problems({"kind": "journal_orbit", "x": 1})] == ["figure.x"]
    assert figures.problems({"kind": "journal_orbit", "turns": 3}) == []


@pytest.mark.parametrize("kind", KINDS["response"].figures)
def test_a_section_has_no_histories(kind):
    assert "figure.kind" in keys({"kind": kind}, section(5))


@pytest.mark.parametrize("kind", ["contact_angle", "journal_orbit", "overview", "poincare_section"])
def test_a_test_system_without_joints_is_refused_kindly(kind):
    assert keys({"kind": kind}, oscillator())


def test_neither_settings_nor_pyplot_are_touched():
    before = dict(mpl.rcParams)
    figures.draw(response())
    assert dict(mpl.rcParams) == before
    code = "import sys, jointplay.figures; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_settings_of_the_user_do_not_change_a_figure(tmp_path):
    def saved(name: str) -> bytes:
        figures.draw(oscillator()).savefig(tmp_path / name)
        return (tmp_path / name).read_bytes()

    plain = saved("plain.png")
    with mpl.rc_context(
        {"font.size": 20, "axes.facecolor": "black", "savefig.dpi": 30, "xtick.labelsize": 3}
    ):
        assert saved("dark.png") == plain


@pytest.mark.nightly
def test_saved_files_embed_fonts_and_are_reproducible(tmp_path):
    for suffix in ("pdf", "svg"):
        files = [tmp_path / f"{name}.{suffix}" for name in "ab"]
        for file in files:
            figures.draw(section(300)).savefig(file)
        assert files[0].read_bytes() == files[1].read_bytes()
    content = (tmp_path / "a.pdf").read_bytes()
    assert b"/CIDFontType2" in content
    assert b"/Type3" not in content


@pytest.mark.parametrize(("kind", "width"), [("overview", 180), ("time_history", 180), ("journal_orbit", 88)])
def test_widths_are_those_of_journal_columns(kind, width):
    figure = figures.draw(response(), {"kind": kind})
    assert figure.get_size_inches()[0] * 25.4 == pytest.approx(width)
