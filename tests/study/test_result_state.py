"""Whose result lies under a study's name: `status`, `plan` and `list` tell it, and `run` keeps it."""

import pytest

from jointplay import cli
from jointplay.study import plan
from jointplay.study.file import load
from jointplay.study.result_state import result_state
from jointplay.study.results import provenance, store
from tests.support.fixtures import calls, study
from tests.support.study_samples import result, stand_in
from tests.support.sweep_samples import CELLS

__all__ = ["calls", "study"]


@pytest.fixture
def run(study, calls, tmp_path, capsys):
    def run(verb, *words):
        extra = ["--no-figure"] if verb == "run" else []
        code = cli.main([verb, str(study), "--out", str(tmp_path / "out"), *extra, *words])
        return code, "".join(capsys.readouterr())

    return run


def listed(tmp_path, capsys):
    assert cli.main(["list", str(tmp_path), "--out", str(tmp_path / "out")]) == 0
    return capsys.readouterr().out.splitlines()[0]


def test_a_single_run_has_a_status_before_and_after(run, tmp_path):
    assert run("status") == (
        0,
        "cells    none: this is one analysis, which runs in one piece\n"
        "result   none yet; `jointplay run` computes it\n",
    )
    run("run")
    code, said = run("status")
    assert code == 0
    assert f"result   {tmp_path / 'out' / 'small.nc'}: done\n" in said


def test_a_result_of_other_settings_is_not_the_studys_and_stays(run, tmp_path, calls, capsys):
    changed = ("--set", "analysis.turns=7", "mechanism.clearance=1e-4")
    run("run", *changed)
    path = tmp_path / "out" / "small.nc"
    kept = path.read_bytes()
    for verb in ("status", "plan"):
        assert "other settings (mechanism.joints[2].clearance, analysis.turns)" in run(verb)[1]
    assert "  other settings  A test" in listed(tmp_path, capsys)
    seen = len(calls)
    code, said = run("run")
    assert code == 2
    assert "other settings (mechanism.joints[2].clearance, analysis.turns)" in said
    assert "--fresh" in said
    assert (len(calls), path.read_bytes()) == (seen, kept)
    assert run("run", *changed)[0] == 0, "the study that made it may write it again"
    assert run("run", "--set", "name=second")[0] == 0
    assert path.read_bytes() == kept
    assert run("run", "--fresh")[0] == 0
    assert "  done  A test" in listed(tmp_path, capsys)


def test_the_time_of_a_single_run_is_estimated_from_two_short_ones(study, tmp_path, monkeypatch, capsys):
    now = [0.0]

    def analysis(mechanism, turns, transient, progress=None, **_):
        now[0] += 3.0 + 0.5 * (turns + transient)
        return result()

    stand_in(monkeypatch, "response", analysis)
    monkeypatch.setattr(plan.time, "perf_counter", lambda: now[0])
    words = ["plan", str(study), "--out", str(tmp_path), "--set"]
    assert cli.main([*words, "analysis.turns=900", "analysis.transient=100"]) == 0
    assert "time     about 8.4 min, by 40 of 1000 turns\n" in capsys.readouterr().out
    assert cli.main([*words, "analysis.turns=5"]) == 0
    assert "not known" in capsys.readouterr().out


def test_a_title_or_figure_changes_no_number(run):
    run("run")
    assert run("run", "--set", "title=Other", "figure.joint=B", "figure.kind=journal_orbit")[0] == 0


def test_a_file_that_is_no_result_is_not_written_over(run, tmp_path):
    path = tmp_path / "out" / "small.nc"
    path.parent.mkdir()
    path.write_text("mine")
    code, said = run("run")
    assert (code, path.read_text()) == (2, "mine")
    assert "a study that this version cannot read" in said
    assert "other version" in run("status")[1]


def test_a_run_that_stopped_early_is_not_done(run, monkeypatch, tmp_path, capsys):
    stand_in(monkeypatch, "response", lambda *_, **__: result(status=2))
    assert run("run")[0] == 1
    assert "stopped early (step_limit)" in run("status")[1]
    assert "  stopped early  A test" in listed(tmp_path, capsys)


def test_what_an_interrupted_run_has_left_is_told(run, tmp_path):
    path = tmp_path / "out" / "small.partial.nc"
    path.parent.mkdir()
    store.write_result(result(), path)
    assert f"partial  {path}" in run("status")[1]


@pytest.mark.nightly
def test_values_that_are_added_to_a_sweep_go_into_its_result(study, tmp_path, capsys):
    study.write_text(CELLS)
    words = ["run", str(study), "--out", str(tmp_path / "out"), "--no-figure"]
    assert cli.main(words) == 0
    assert cli.main([*words, "--set", "vary.gap=[2.0, 2.5, 3.0]"]) == 0
    assert store.open_result(tmp_path / "out" / "cells.nc").sizes["gap"] == 3
    capsys.readouterr()
    assert cli.main(["status", str(study), "--out", str(tmp_path / "out")]) == 0
    assert "other settings (vary)" in capsys.readouterr().out


def stored(record, folder):
    """A result of a study that stands there as if it had been computed."""
    folder.mkdir(exist_ok=True)
    kept = provenance.attach(result(), record.model_dump(mode="json"), "")
    return store.write_result(kept, folder / f"{record.name}.nc")


def test_a_result_of_fewer_samples_says_how_many_it_has(tmp_path):
    """200 samples of 1000 were called done, where the study asks for more."""
    path = tmp_path / "parts.toml"
    path.write_text(
        'kind = "tolerances"\n[mechanism]\ncatalog = "slider_crank"\n[tolerances]\nspeed.normal = [200, 1]\n'
    )
    file = stored(load(path, ["analysis.samples=200"]).record, tmp_path / "out")
    assert result_state(load(path).record, file) == "has 200 of 1000 samples"
    assert result_state(load(path, ["analysis.samples=200"]).record, file) == "done"
    assert result_state(load(path, ["analysis.samples=100"]).record, file) == "done"


def test_a_file_without_a_kind_has_a_state_as_each_that_it_was_computed_as(tmp_path, capsys):
    path = tmp_path / "rocker.toml"
    path.write_text('title = "A rocker"\n[mechanism]\ncatalog = "slider_crank"\n')
    words = ["status", str(path), "--out", str(tmp_path / "out")]
    assert cli.main(words) == 2, "nothing says as what"
    file = stored(load(path, kind="assess").record, tmp_path / "out")
    capsys.readouterr()
    assert cli.main(words) == 0
    assert f"result   {file}: done" in capsys.readouterr().out
    assert listed(tmp_path, capsys).endswith("rocker.toml  assess  done  A rocker")
