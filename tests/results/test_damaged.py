"""Results that are damaged, mislabelled or of another version: shown, or one sentence; never a traceback."""

import random

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import jointplay as jp
from jointplay import cli, figures
from jointplay.analysis.states.basins import basins
from jointplay.display.errors import InputError, intact, sealed
from jointplay.figures.drawing import artists
from jointplay.study.results import store
from jointplay.study.results import summary as summary_module
from tests.figures.support.synthetic import response
from tests.figures.test_pictures import leaning
from tests.results import damage

PLANE = {"y": (0.0, 0.5, 3), "v": (0.0, 0.5, 3)}
STUDY = """
kind = "response"
mechanism = { catalog = "impact_pair", gap = 3.6, restitution = 0.8 }
analysis = { turns = 1 }
"""
MANY = pytest.param(2000, marks=[pytest.mark.nightly, pytest.mark.timeout(7200)])


@pytest.mark.nightly
@pytest.mark.parametrize("files", [20, MANY])
def test_no_damaged_file_ends_in_a_traceback(files):
    counts, wrong = damage.run(files, seed=files)
    assert wrong == []
    assert counts.total() == files
    ended = {word: sum(n for how, n in counts.items() if how.endswith(word)) for word in ("shown", "refused")}
    assert min(ended.values()) > files / 5, counts


@pytest.mark.parametrize("one", damage.DAMAGES, ids=lambda each: each.__name__)
def test_each_damage_changes_something(one):
    sound = response()
    found = [one(random.Random(seed), sound.copy(deep=True)) for seed in range(9)]
    assert not all(each.identical(sound) for each in found)


def test_dollar_signs_in_a_name_are_drawn_as_they_stand(tmp_path):
    name = "$\\frac $ B"
    odd = leaning()
    odd["parameter_name"] = ("parameter", ["clearance", name, "$x$"])
    store.write_result(odd, tmp_path / "a.nc")
    assert cli.main(["figure", str(tmp_path / "a.nc"), "--out", str(tmp_path / "a.pdf")]) == 0
    texts = [each for each in figures.draw(odd).findobj(Text) if name in each.get_text()]
    assert texts
    assert not any(each.get_parse_math() for each in texts)


def test_each_line_of_a_label_is_mathematics_or_not_by_itself(caplog):
    """As they are drawn; what is asked of both at once has no sign for the line's end, which is then told."""
    figure = Figure()
    two, one = figure.text(0, 0, "$x^2$\ncosts $5"), figure.text(0, 0, "$x^2$\n$\\frac$")
    artists.literal(figure)
    assert (two.get_parse_math(), one.get_parse_math()) == (True, False)
    assert not [record for record in caplog.records if "glyph" in record.getMessage()]


def test_basins_without_the_boundarys_dimension_have_an_answer():
    system = jp.catalog.soft_impact_pair(gap=1.0, stiffness=50.0, damping=1.0)
    found = basins(system, plane=PLANE, transient=20, turns=8, uncertainty=False, n_jobs=1)
    assert "attractor" in str(jp.summary(found))


def test_the_error_that_came_is_the_cause():
    with pytest.raises(InputError, match="damaged, changed, or of another version") as caught:
        jp.summary(leaning().drop_vars("derivative"))
    assert isinstance(caught.value.__cause__, KeyError)


@pytest.mark.parametrize("name", ["bifurcation", "curve", "fig03b", "overview", "time_history of turns"])
def test_the_seal_of_a_result_outlasts_its_file_and_no_change(name, tmp_path):
    dataset = sealed(damage.whole()[name]()[0])
    store.write_result(dataset, tmp_path / "a.nc")
    back = store.open_result(tmp_path / "a.nc")
    assert intact(dataset)
    assert intact(back)
    for one in damage.DAMAGES:
        changed = one(random.Random(1), back.copy(deep=True))
        assert changed.identical(back) or not intact(changed)


def test_a_fault_of_our_own_is_not_called_the_files(tmp_path, monkeypatch):
    """The same error where the file is as it was written, and where it was changed since."""
    study = tmp_path / "a.toml"
    study.write_text(STUDY)
    found = jp.run(study)
    store.write_result(found, tmp_path / "a.nc")
    store.write_result(found.assign_attrs(title="Another"), tmp_path / "b.nc")
    monkeypatch.setattr(summary_module, "answer", lambda dataset: dataset.no_such)
    with pytest.raises(AttributeError, match="no_such"):
        jp.summary(jp.open(tmp_path / "a.nc"))
    with pytest.raises(InputError, match="no_such"):
        jp.summary(jp.open(tmp_path / "b.nc"))


@pytest.mark.long
def test_what_a_users_progress_raises_stays_as_it_is(tmp_path):
    def progress(_):
        raise LookupError("mine")

    motion, _ = damage._motion()
    with pytest.raises(LookupError, match="mine"):
        jp.animate(motion, tmp_path / "a.gif", seconds=0.5, rate=10, progress=progress)
