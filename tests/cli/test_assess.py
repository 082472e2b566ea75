"""`jointplay assess`: the page, the stored result, files of other kinds, wrong input."""

import pytest

import jointplay as jp
from jointplay.analysis.assessment import assess as assess_module
from jointplay.cli import main
from jointplay.study.file import load
from jointplay.study.plan import status

MECHANISM = '[mechanism]\ncatalog = "chunmei2002"\nclearance = "29 µm"\ngear_ratio = 3.0\n'
BRIEF = ["analysis.turns=2", "analysis.transient=10", "analysis.reach=1.01", "analysis.lyapunov_turns=5"]


def assessed(path, tmp_path, *more):
    return main(["assess", str(path), "--out", str(tmp_path), "--jobs", "1", *more])


@pytest.mark.nightly
def test_the_page_is_printed_and_kept_beside_the_result(tmp_path, capsys):
    path = tmp_path / "press.toml"
    path.write_text(MECHANISM, encoding="utf-8")
    assert assessed(path, tmp_path, "--set", *BRIEF) == 0
    said = capsys.readouterr().out
    assert f"jointplay assess {path}" in said
    assert "radial clearance of joint B, now 29 µm" in said
    assert "gear ratio, now 3" in said
    found = jp.open(tmp_path / "press_assess.nc")
    assert found.attrs["kind"] == "assess"
    assert float(found["limit_ratio"].sel(parameter="gear_ratio", side="above")) == 1.01
    table = (tmp_path / "press_assess.txt").read_text(encoding="utf-8")
    assert table in said
    assert (tmp_path / "press_assess.png").exists()
    assert assessed(path, tmp_path, "--set", *BRIEF, "analysis.turns=3") == 2  # would write over it
    assert "other settings (analysis.turns)" in capsys.readouterr().err
    same = jp.assess(found_mechanism(), turns=2, transient=10, reach=1.01, lyapunov_turns=5, n_jobs=1)
    assert same["peak_force"].values.tolist() == found["peak_force"].values.tolist()


@pytest.mark.nightly
def test_each_part_of_the_page_is_printed_when_its_round_is_over(tmp_path, monkeypatch, capsys):
    """In the order of the rounds; together they are the page, and a run that has all of it prints it too."""
    said, (path, out) = [], (tmp_path / "press.toml", tmp_path / "press_assess")
    path.write_text(MECHANISM, encoding="utf-8")
    answers = assess_module.Rounds.answers

    def noted(rounds, function, cells, needed=None):
        said.append((function.__name__, capsys.readouterr().out))
        return answers(rounds, function, cells, needed)

    with monkeypatch.context() as patch:
        patch.setattr(assess_module.Rounds, "answers", noted)
        assert assessed(path, tmp_path, "--no-figure", "--set", *BRIEF) == 0
    rest = capsys.readouterr().out
    assert [name for name, _ in said] == ["assessed", "hung", "curved", "sided"]
    heads = ["", "Verdict", "What it hangs on", "What to do"]
    assert all(head in text for head, (_, text) in zip(heads, said, strict=True))
    assert said[0][1] == ""
    assert rest.startswith("Where the motion changes")
    page = "".join(text for _, text in said) + rest.partition("result  ")[0]
    kept = out.with_suffix(".txt").read_text(encoding="utf-8")
    assert page == kept + "\n"
    assert assessed(path, tmp_path, "--no-figure", "--set", *BRIEF, "analysis.budget=20") == 0
    again = capsys.readouterr().out
    assert again.partition("journal  ")[0] == page
    assert again.count("cells are there already") == 4
    study = load(str(path), [*BRIEF, "analysis.budget=3"], kind="assess")
    assert next(iter(status(study, tmp_path))) == "cells    9 of 9 finished"


def found_mechanism():
    return jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0)


@pytest.mark.nightly
def test_of_a_file_of_another_kind_the_mechanism_alone_is_taken(tmp_path, capsys):
    path = tmp_path / "motion.toml"
    path.write_text(f'kind = "response"\nname = "mine"\n{MECHANISM}[analysis]\nturns = 5\n', encoding="utf-8")
    assert assessed(path, tmp_path, "--no-figure", "--set", *BRIEF) == 0
    assert (tmp_path / "motion_assess.nc").exists()
    assert not (tmp_path / "mine.nc").exists()


@pytest.mark.nightly
def test_a_study_of_the_kind_keeps_its_name_and_settings(tmp_path, capsys):
    path = tmp_path / "motion.toml"
    lines = "\n".join(each.removeprefix("analysis.") for each in BRIEF)
    along = 'along = ["gear_ratio"]'
    path.write_text(f'kind = "assess"\nname = "mine"\n{MECHANISM}[analysis]\n{lines}\n{along}\n', "utf-8")
    assert assessed(path, tmp_path, "--no-figure") == 0
    found = jp.open(tmp_path / "mine.nc")
    assert found["parameter"].values.tolist() == ["gear_ratio"]


def test_wrong_input_is_told_all_at_once(tmp_path, capsys):
    path = tmp_path / "press.toml"
    path.write_text(MECHANISM, encoding="utf-8")
    wrong = ["mechanism.clearance=0.0", "analysis.reach=0.5", "analysis.stepp=1"]
    assert assessed(path, tmp_path, "--set", *wrong) == 2
    said = capsys.readouterr().err
    assert all(key in said for key in ("mechanism.joints", "analysis.reach", "analysis.stepp"))
    path.write_text('title = "no mechanism"\n', encoding="utf-8")
    assert assessed(path, tmp_path) == 2
    assert "mechanism" in capsys.readouterr().err
