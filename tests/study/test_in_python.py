"""Study files run from Python: as the command does, with changes and progress."""

import traceback

import numpy as np
import pytest

import jointplay as jp
from jointplay.study.file import load
from jointplay.study.run import run

TEXT = """\
kind = "section"

[mechanism]
catalog = "duffing"

[analysis]
turns = 20
"""


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "duffing.toml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def test_it_is_what_the_command_computes(study):
    found, own = jp.run(study), run(load(study))
    assert found.drop_vars("wall_time").identical(own.drop_vars("wall_time"))
    assert found.attrs["study"] == "duffing"


def test_changes_by_table_and_by_path(study):
    by_table = jp.run(study, mechanism={"amplitude": 0.25}, analysis={"turns": np.int64(7)})
    by_path = jp.run(str(study), **{"mechanism.amplitude": np.float64(0.25), "analysis.turns": 7})
    assert by_table.sizes["turn"] == 7
    assert np.array_equal(by_table.state_value, by_path.state_value)
    assert not np.array_equal(by_table.state_value, jp.run(study).state_value[:7])


def test_progress(study, capsys):
    told = []
    jp.run(study, progress=told.append)
    assert told
    jp.run(study, progress=True)


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        (
            {"mechanism": {"amplitud": 1.0}},
            "mechanism.amplitud: got 1.0; there is no such key; did you mean 'amplitude'",
        ),
        ({"analysis": {"turns": object()}}, "analysis.turns: got <object"),
        ({"analysis": {"turns": float("nan")}}, "analysis.turns: got nan"),
        ({"progress": 3}, "progress: got 3"),
        ({"analyses": {"turns": 3}}, "analyses: got"),
    ],
)
def test_what_is_wrong_is_said(study, keywords, said):
    with pytest.raises(jp.InputError) as caught:
        jp.run(study, **keywords)
    assert said in str(caught.value)


def test_no_study_at_all():
    for wrong in (3, None, "there_is_none.toml"):
        with pytest.raises(jp.InputError):
            jp.run(wrong)


def test_a_name_that_is_not_there_and_a_result_where_none_is_accepted():
    """The nearest name is suggested, once; a result is no wall of text in a message."""
    for module, name, near in ((jp, "lyapunof", "lyapunov"), (jp.catalog, "slider_krank", "slider_crank")):
        assert not hasattr(module, name)
        with pytest.raises(AttributeError) as caught:
            getattr(module, name)
        shown = "".join(traceback.format_exception(caught.value))
        assert shown.count(f"did you mean '{near}'?") == 1
        assert "Did you mean" not in shown
    cut = jp.poincare(jp.catalog.duffing(), turns=2)
    with pytest.raises(jp.InputError, match="over: got <Dataset of kind 'section'>"):
        jp.figure(cut, over=cut)
