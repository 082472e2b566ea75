"""Studies that vary parameters: the `[vary]` table, and all that is told before anything is computed."""

import numpy as np
import pytest

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.study import run
from jointplay.study.file import Loaded, validate
from jointplay.study.toml_text import override, parse
from tests.support.wrong import refused

PAIR = """\
kind = "bifurcation"
name = "small"

[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.8

[vary]
gap = { start = 2.95, stop = 3.05, num = 3 }

[analysis]
turns = 8
transient = 20
direction = ["up", "reset"]
starts = [[0.0, 1.0], [0.1, 1.0]]
"""
LINKAGE = """\
kind = "bifurcation"
name = "linkage"

[mechanism]
catalog = "chunmei2002"
clearance = 0.0
gear_ratio = 3.0

[vary]
clearance = [1e-5, 2e-5]
"""


def record(text, *changes):
    return validate(override(parse(text), changes))


def problems(text, *changes):
    """Key and message of each problem."""
    return refused(record, text, *changes)


def test_a_study_is_the_function():
    found = run.run(Loaded(record(PAIR), PAIR), jobs=1)
    starts = [[0.0, 1.0], [0.1, 1.0]]
    over = {"gap": np.linspace(2.95, 3.05, 3)}
    pair = jp.catalog.impact_pair(3.0, 0.8)
    same = jp.bifurcation(
        pair, over=over, turns=8, transient=20, direction=("up", "reset"), starts=starts, n_jobs=1
    )
    assert found.equals(same)
    assert found.attrs["study"] == "small"
    assert found.attrs["kind"] == "bifurcation"


def test_what_is_left_out_is_as_in_the_function():
    keywords = record(LINKAGE).keywords()
    assert keywords["over"] == {"clearance": (1e-5, 2e-5)}
    assert keywords["rtol"] == 1e-7
    assert keywords["direction"] == ("up",)
    assert record(LINKAGE, 'analysis.direction="down"').keywords()["direction"] == ("down",)
    named = record(LINKAGE, "analysis.starts=[{crank_angle = 1.0}, {crank_angle = 2.0, crank_speed = 3.0}]")
    assert named.keywords()["starts"] == ({"crank_angle": 1.0}, {"crank_angle": 2.0, "crank_speed": 3.0})
    assert "clearance of joint B, 2 values from 10 µm to 20 µm" in named.summary()


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("{ start = 1e-5, stop = 1e-3, num = 3, scale = 'log' }", (1e-5, 1e-4, 1e-3)),
        ("{ start = 1e-5, stop = 3e-5, num = 3 }", (1e-5, 2e-5, 3e-5)),
        ("{ start = 3e-5, stop = 1e-5, num = 3 }", (3e-5, 2e-5, 1e-5)),
        ("[2e-5, 1e-5]", (2e-5, 1e-5)),
    ],
)
def test_axes_are_lists_or_ranges(given, expected):
    found = record(LINKAGE, f"vary.clearance={given}").keywords()["over"]["clearance"]
    assert found == pytest.approx(expected, rel=1e-12)


def test_a_key_path_may_be_written_as_nested_tables_or_in_quotes():
    quoted = LINKAGE.replace("clearance = [1e-5, 2e-5]", '"joints.B.contact.stiffness" = [1e6, 7e6]')
    nested = LINKAGE.replace("clearance = [1e-5, 2e-5]", "joints.B.contact.stiffness = [1e6, 7e6]")
    deep = LINKAGE.replace(
        "[vary]\nclearance = [1e-5, 2e-5]",
        "[vary.joints.B.contact.stiffness]\nstart = 1e6\nstop = 7e6\nnum = 2",
    )
    for text in (quoted, nested, deep):
        assert record(text).keywords()["over"] == {"joints.B.contact.stiffness": (1e6, 7e6)}


def test_every_mistake_in_an_axis_is_told_with_its_place():
    assert problems(PAIR, "vary.gap.num=1", "vary.gap.stop=2.95", 'vary.gap.scale="even"').keys() == {
        *("vary.gap.num", "vary.gap.stop", "vary.gap.scale")
    }
    assert problems(PAIR, "vary.gap.step=0.1").keys() == {"vary.gap.step"}
    assert problems(PAIR, "vary.gap={start = -1.0, stop = 2.0, num = 3, scale = 'log'}").keys() == {
        "vary.gap.scale"
    }
    with pytest.raises(InputError) as error:
        record(PAIR, "vary.gap={start = -1.0, stop = 2.0, num = 7}")
    (only,) = error.value.problems  # the first of three
    assert (only.key, only.given) == ("vary.gap", -1.0)
    assert problems(PAIR, "vary.gap=[1.0, -1.0, 'x']").keys() == {"vary.gap[2]"}
    assert problems(PAIR, "vary.gap=[1.0, -1.0, 1.0]").keys() == {"vary.gap[1]", "vary.gap[2]"}
    assert problems(PAIR, "vary.gap=[]").keys() == {"vary.gap"}
    assert problems(PAIR, "vary.gap=3.0").keys() == {"vary.gap"}
    assert problems(PAIR, "vary={}").keys() == {"vary"}
    assert problems(PAIR, "vary=1").keys() == {"vary"}
    assert "did you mean 'gap'?" in problems(PAIR, "vary.gapp=[1.0]")["vary.gapp"]
    assert problems(LINKAGE, "vary.joints.B.clearence=[1.0]").keys() == {"vary.joints.B.clearence"}
    for given in ("['20 um']", "{start = '10 um', stop = '20 um', num = 2}"):
        lost = problems(LINKAGE, f"vary.joints.B.clearence={given}", "vary.gravity=['9.8 m/s^2']")
        assert lost.keys() == {"vary.joints.B.clearence"}
        assert "did you mean 'clearance'?" in lost["vary.joints.B.clearence"]
    case = "vary={cases = [{clearance = '1 um'}, {clearence = '2 um'}]}"
    assert "did you mean 'clearance'?" in problems(LINKAGE, "kind=lyapunov", case)["vary.clearence"]
    three = ("vary.gear_ratio=[1.0]", "vary.gravity=[9.8]")
    assert problems(LINKAGE, *three).keys() == {"vary"}
    assert problems(PAIR.replace("[vary]\ngap = { start = 2.95, stop = 3.05, num = 3 }\n", "")).keys() == {
        "vary"
    }


def test_what_does_not_fit_the_varied_mechanism_is_told():
    of_the_varied_one = record(LINKAGE, 'analysis.record=["journal_x"]')
    assert of_the_varied_one.analysis.record == ("journal_x",)
    starts = "analysis.starts=[{crank_angle = 1.0}, [1.0, 2.0]]"
    figure = ('figure.kind="bifurcation"', 'figure.direction="down"', 'figure.joint="C"')
    found = problems(LINKAGE, 'analysis.record=["journal_x", "state_value"]', starts, *figure)
    assert found.keys() == {"analysis.record[1]", "analysis.starts[1]", "figure.direction", "figure.joint"}
    assert "journal_x" in problems(LINKAGE, 'figure.quantity="journal_z"')["figure.quantity"]
    assert problems(PAIR, 'figure.kind="parameter_map"').keys() == {"figure.kind"}
    assert problems(PAIR, "figure.limits=3", "figure.period=1").keys() == {"figure.limits", "figure.period"}
    assert problems(PAIR, "analysis.initial=[0.0, 1.0]").keys() == {"analysis.initial"}
    assert problems(PAIR, 'analysis.direction=["up", "up"]').keys() == {"analysis.direction[1]"}
    assert problems(PAIR, 'analysis.section.kind="plane"').keys() == {
        "analysis.section.quantity",
        "analysis.section.value",
    }


def test_a_state_of_the_test_system_can_be_drawn():
    assert record(PAIR, 'figure.quantity="v"').figure == {"quantity": "v"}
