"""Windows in study files: the length may be left out, and what contradicts them is refused by its key."""

import pytest

from jointplay.study.file import load
from tests.support.wrong import refused

WINDOWED = """\
kind = "response"

[mechanism]
catalog = "chunmei2002"

[analysis]
windows = [[0, 1], [20, 25]]

[figure]
kind = "time_history"
pin = "A"
variables = "reaction_x"
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "windowed.toml"
    path.write_text(WINDOWED)
    return path


def problems(path, *changes):
    return refused(load, path, changes)


def test_windows_are_passed_on_without_a_length(file):
    record = load(file).record
    assert record.keywords()["windows"] == ((0.0, 1.0), (20.0, 25.0))
    assert "turns" not in record.keywords()
    assert "turns 0 to 1 and 20 to 25" in record.summary()


def test_a_length_may_go_on_but_not_end_before_the_last_window(file):
    assert load(file, ["analysis.turns=30"]).record.analysis.turns == 30
    assert "at least 25" in problems(file, "analysis.turns=24")["analysis.turns"]


@pytest.mark.parametrize(
    "change",
    ["transient=2", "duration=1.0", "at=[0.1]", "steps=true", 'section={ kind = "crank_angle" }'],
)
def test_what_contradicts_windows_is_refused(file, change):
    key = f"analysis.{change.partition('=')[0]}"
    assert problems(file, f"analysis.{change}").keys() == {key}
    assert "windows" in problems(file, f"analysis.{change}")[key]


def test_all_contradictions_are_said_at_once(file):
    keys = problems(file, "analysis.transient=2", "analysis.steps=true", "analysis.turns=3").keys()
    assert keys == {"analysis.transient", "analysis.steps", "analysis.turns"}


@pytest.mark.parametrize(
    ("windows", "key"),
    [
        ("[]", ""),
        ("3", ""),
        ("[[1, 0]]", ""),
        ("[[0, 1], [1, 2]]", ""),
        ("[[-1, 2]]", ""),
        ("[[0, 1, 2]]", "[0]"),
        ("[[0, 1], ['a', 2]]", "[1][0]"),
    ],
)
def test_windows_that_make_no_sense_are_refused(file, windows, key):
    assert problems(file, f"analysis.windows={windows}").keys() == {f"analysis.windows{key}"}


def test_a_section_has_no_windows(file):
    keys = problems(file, "kind=section", "analysis.turns=3", "figure={}").keys()
    assert keys == {"analysis.windows"}


def test_a_pin_in_a_figure_is_an_ideal_joint(file):
    assert "no such ideal joint" in problems(file, "figure.pin=B")["figure.pin"]
    assert "accepted: O, A, C" in problems(file, "figure.pin=B")["figure.pin"]


def test_a_contact_angle_needs_clearance(file):
    changes = ("mechanism.clearance=0", 'figure={ kind = "contact_angle" }')
    assert problems(file, *changes).keys() == {"figure.kind"}
