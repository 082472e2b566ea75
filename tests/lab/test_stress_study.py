"""Stress studies: what is accepted, what is told, and that listed scenes run again from their own lines."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from jointplay import cli, figures
from jointplay.display.errors import InputError
from jointplay.study import run
from jointplay.study.file import Loaded, load, validate
from jointplay.study.toml_text import override, parse
from jointplay_lab.stress.scenes import VARIANTS, draw
from jointplay_lab.stress.stress import answer, table
from tests.support.wrong import texts_of

STUDIES = Path(__file__).parents[2] / "studies" / "stress"
TEXT = """\
kind = "stress"
name = "few"

[mechanism]
catalog = "chunmei2002"

[analysis]
scenes = 4
first = 70
variants = ["rigid"]
listed = 2
"""


def problems(*changes):
    """Key and message of each problem."""
    return texts_of(validate, override(parse(TEXT), changes))


@pytest.fixture(scope="module")
def found():
    return run.run(Loaded(validate(parse(TEXT)), TEXT), jobs=1)


def test_a_listed_scene_runs_again_from_its_lines(found):
    for word in ("slowest", "worst"):
        number, text = int(found[word][0]), str(found[f"{word}_lines"][0].values)
        record = validate({"name": "again"} | tomllib.loads(text))
        assert record.mechanism == draw(validate(parse(TEXT)).mechanism, number, 0, ("rigid",)).mechanism
        again, one = run.run(Loaded(record, text)), found.sel(scene=number)
        for name in ("n_steps", "n_rejected", "n_failed", "n_evaluations", "n_events"):
            assert int(again[name]) == int(one[name])
        assert int(again.status) == int(one.scene_status)


def test_the_table_counts_and_lists(found):
    text = answer(found)
    assert text.startswith("4 scenes: ")
    assert "median" in text
    rows = [line.split() for line in text.splitlines()]
    for word in ("slowest", "worst"):
        assert [row[0] for row in rows[rows.index([word]) + 2 :][:2]] == [str(k) for k in found[word].values]
    whole = table(found)
    assert whole.startswith(text)
    for part in whole.split("# ---")[1:]:
        validate({"name": "x"} | tomllib.loads(part.split("\n", 1)[1]))


def test_a_run_tells_it_and_writes_it_down(tmp_path, capsys):
    path = tmp_path / "few.toml"
    path.write_text(TEXT)
    command = ["run", str(path), "--out", str(tmp_path), "--jobs", "1", "--no-figure"]
    assert cli.main([*command, "--set", "analysis.scenes=1"]) == 0
    assert "1 scenes: 1 " in capsys.readouterr().out
    assert (tmp_path / "few.txt").read_text().count('kind = "response"') == 1
    assert (tmp_path / "few.nc").exists()


def test_its_figure(found):
    figure = figures.draw(found)
    times, residuals = figure.axes
    shown = np.concatenate([line.get_ydata() for line in times.lines])
    assert sorted(shown) == pytest.approx(sorted(1e3 * found.cpu_time.values))
    assert sum(patch.get_height() for patch in residuals.patches) == pytest.approx(4)
    (legend,) = figure.legends
    assert sum(int(text.get_text().split("(")[1][:-1]) for text in legend.get_texts()) == 4


def test_a_figure_needs_such_a_result(found):
    with pytest.raises(InputError, match="stress"):
        figures.draw(found.drop_vars("verdict"))


def test_every_mistake_is_told_with_its_place():
    wrong = ["analysis.scenes=0", "analysis.seed=-1", 'analysis.variants=["rigid"]', "analysis.turns=1.5"]
    assert set(problems(*wrong)) == {"analysis.scenes", "analysis.seed", "analysis.turns"}
    assert set(problems('analysis.variants=["rigit"]')) == {"analysis.variants[0]"}
    assert set(problems("mechanism.speed=80.0")) == {"mechanism"}
    assert set(problems('figure.kind="overview"')) == {"figure.kind"}
    assert set(problems("vary.gear_ratio=[1.0, 2.0]")) == {"vary"}


@pytest.mark.parametrize(
    ("start", "word"),
    [
        ("{ crank_angle = 1.0, angle = { crank = 1.0 } }", "crank_angle"),
        ("{ angle = { crank = 1.0, coupler = 1.0, rocker = 1.0 } }", "one finite number for each"),
    ],
)
def test_a_start_is_written_out_or_by_the_crank(start, word):
    text = 'kind = "response"\n[mechanism]\ncatalog = "chunmei2002"\n[analysis]\nturns = 1\n'
    with pytest.raises(InputError, match=word):
        validate({"name": "x"} | tomllib.loads(f"{text}initial = {start}\n"))


def test_the_shipped_studies():
    whole, few, others = (
        load(STUDIES / f"stress_{name}.toml").record for name in ("linkage", "few", "others")
    )
    assert {*others.analysis.variants} == {*VARIANTS}
    assert whole.analysis.scenes == 5000
    assert few.analysis.scenes <= 40
    assert "5000 scenes of seed 0" in whole.summary()
