"""The command line: what it writes, what it says, and its exit codes."""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from jointplay import cli, figures
from jointplay.display.errors import InputError, Problem
from jointplay.study.results import store
from tests.support.study_samples import TEXT, result, stand_in

QUICKSTART = Path(__file__).parents[2] / "studies" / "quickstart.toml"


def python(*words, **options):
    return subprocess.run(
        [sys.executable, "-m", "jointplay", *map(str, words)], capture_output=True, text=True, **options
    )


def test_run_writes_result_and_figures_and_says_where(study, calls, tmp_path, capsys):
    out = tmp_path / "new" / "out"
    assert cli.main(["run", str(study), "--out", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["small.nc", "small.pdf", "small.png"]
    said = capsys.readouterr().out
    assert all(str(out / f"small.{end}") in said for end in ("nc", "pdf", "png"))
    assert calls[-1] == {"kind": "overview", "joint": "B"}


def test_a_second_run_gives_the_same_bytes(study, calls, tmp_path):
    for out in ("a", "b"):
        assert cli.main(["run", str(study), "--out", str(tmp_path / out)]) == 0
    for end in ("nc", "pdf", "png"):
        assert (tmp_path / "a" / f"small.{end}").read_bytes() == (
            tmp_path / "b" / f"small.{end}"
        ).read_bytes()


def test_changes_and_no_figure(study, calls, tmp_path):
    words = ["run", str(study), "--out", str(tmp_path / "out"), "--no-figure"]
    assert (
        cli.main([*words, "--set", "name=other", "analysis.turns=7", "--set", "mechanism.clearance=1e-4"])
        == 0
    )
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["other.nc"]
    mechanism, keywords = calls[0]
    assert keywords["turns"] == 7
    assert mechanism.joint("B").clearance == 1e-4


def test_a_numerical_failure_is_stored_named_and_exit_1(study, calls, tmp_path, monkeypatch, capsys):
    stand_in(monkeypatch, "response", lambda *_, **__: result(status=2))
    assert cli.main(["run", str(study), "--out", str(tmp_path)]) == 1
    assert int(store.open_result(tmp_path / "small.nc")["status"]) == 2
    said = capsys.readouterr().err
    assert "step_limit" in said
    assert "integrator.max_steps" in said


def test_a_failure_too_early_to_draw_is_still_a_failure(study, calls, tmp_path, monkeypatch, capsys):
    def refuse(*_):
        raise InputError([Problem("figure.turns", 3, "nothing was recorded")])

    monkeypatch.setattr(figures, "draw", refuse)
    assert cli.main(["run", str(study), "--out", str(tmp_path)]) == 2
    stand_in(monkeypatch, "response", lambda *_, **__: result(status=1))
    assert cli.main(["run", str(study), "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().err
    assert "diverged" in said
    assert "no figure" in said


def test_an_interrupt_is_130_and_leaves_nothing(study, calls, tmp_path, monkeypatch, capsys):
    def stop(*_, **__):
        raise KeyboardInterrupt

    stand_in(monkeypatch, "response", stop)
    assert cli.main(["run", str(study), "--out", str(tmp_path / "out")]) == 130
    assert list((tmp_path / "out").iterdir()) == []
    assert "interrupted" in capsys.readouterr().err


def test_a_disk_that_fails_while_storing_is_no_traceback(study, calls, tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(store, "write_result", full)
    assert cli.main(["run", str(study), "--out", str(tmp_path / "out")]) == 1
    assert "No space left" in capsys.readouterr().err


def wrong(words, tmp_path):
    """Words of a command that must be refused, with the paths it needs."""
    (tmp_path / "a.toml").write_text(TEXT)
    (tmp_path / "broken.toml").write_text("kind = \n")
    (tmp_path / "file").write_text("a file")
    (tmp_path / "no.nc").write_text("no netCDF")
    return [word.replace("@", str(tmp_path)) for word in words.split()]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run @/none.toml", "study file"),
        ("check @/none.toml", "study file"),
        ("check @/broken.toml", "line 1"),
        ("check @", "study file"),
        ("check @/no.nc", "netCDF"),
        ("check @/a.toml --set nonsense", "--set"),
        ("check @/a.toml --set analysis.turns=0 nmae=1", "2 problems"),
        ("run @/a.toml --out @/file/out", "--out"),
        ("figure @/none.nc", "result"),
        ("figure @/no.nc", "netCDF"),
        ("list @/none", "folder"),
    ],
)
def test_wrong_input_is_exit_2_with_its_place_and_before_any_work(words, said, calls, tmp_path, capsys):
    assert cli.main(wrong(words, tmp_path)) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
    assert calls == []


@pytest.mark.parametrize("words", ["", "rnu a.toml", "run", "run a.toml --jbos 3"])
def test_a_wrong_command_is_exit_2(words):
    with pytest.raises(SystemExit) as error:
        cli.main(words.split())
    assert error.value.code == 2


def test_a_stored_result_is_drawn_again(study, calls, tmp_path):
    cli.main(["run", str(study), "--out", str(tmp_path), "--no-figure"])
    path = tmp_path / "small.nc"
    assert cli.main(["figure", str(path)]) == 0
    assert calls[-1] == {"kind": "overview", "joint": "B"}
    assert (tmp_path / "small.pdf").exists()
    assert (
        cli.main(
            [
                "figure",
                str(path),
                "--kind",
                "time_history",
                "--set",
                "link=crank",
                "--out",
                str(tmp_path / "x.svg"),
            ]
        )
        == 0
    )
    assert calls[-1] == {"kind": "time_history", "link": "crank"}
    assert (tmp_path / "x.svg").exists()
    assert not (tmp_path / "x.pdf").exists()
    assert cli.main(["figure", str(path), "--out", str(tmp_path / "x.doc")]) == 2
    assert cli.main(["figure", str(path), "--out", str(path / "below" / "x.pdf")]) == 2


@pytest.mark.nightly
def test_check_and_list_and_schema(study, calls, tmp_path, capsys):
    assert cli.main(["check", str(study)]) == 0
    assert "chunmei2002" in capsys.readouterr().out
    (tmp_path / "broken.toml").write_text("=")
    cli.main(["run", str(study), "--out", str(tmp_path / "out"), "--no-figure"])
    capsys.readouterr()
    assert cli.main(["list", str(tmp_path), "--out", str(tmp_path / "out")]) == 0
    broken, small = capsys.readouterr().out.splitlines()
    assert re.search(r"broken\.toml +\? .*jointplay check", broken)
    assert re.search(r"small\.toml +response +done +A test", small)
    assert cli.main(["schema"]) == 0
    assert '"$schema"' in capsys.readouterr().out


def test_studies_are_listed_where_they_are(study, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    (tmp_path / "inside").mkdir()
    shutil.copy(study, tmp_path / "inside" / "other.toml")
    assert cli.main(["list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["small.toml"]
    (tmp_path / "studies").mkdir()
    assert cli.main(["list"]) == 2
    assert "jointplay new" in capsys.readouterr().err
    shutil.copy(study, tmp_path / "studies")
    assert cli.main(["list"]) == 0
    assert capsys.readouterr().out.startswith(str(Path("studies") / "small.toml"))


@pytest.mark.long
def test_the_program_refuses_wrong_input_without_a_traceback(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(TEXT + "jiont = 1")
    done = python("check", path)
    assert done.returncode == 2
    assert "figure.jiont" in done.stderr
    assert "Traceback" not in done.stderr


def test_help_is_quick(record_property):
    start = time.perf_counter()
    assert python("--help").returncode == 0
    record_property("help_seconds", time.perf_counter() - start)  # measured, not judged: machines differ


def test_two_turns_of_the_quickstart_run_from_end_to_end(tmp_path):
    changes = ["analysis.turns=2", "analysis.transient=0", "figure.turns=2"]
    done = python("run", QUICKSTART, "--out", tmp_path, "--set", *changes)
    assert done.returncode == 0, done.stderr
    dataset = store.open_result(tmp_path / "quickstart.nc")
    assert int(dataset["status"]) == 0
    assert dataset.sizes["time"] > 1000
    assert all("units" in dataset[name].attrs for name in dataset.data_vars)
    assert (tmp_path / "quickstart.png").stat().st_size > 10_000


def test_figure_of_a_study_file_is_its_mechanism(tmp_path, capsys):
    study, out = tmp_path / "own.toml", tmp_path / "own.png"
    study.write_text('[mechanism]\ncatalog = "slider_crank"\n')
    assert cli.main(["figure", str(study), "--out", str(out), "--set", "crank_angle=0.5"]) == 0
    assert out.read_bytes().startswith(b"\x89PNG")
    study.write_text('[mechanism]\ncatalog = "duffing"\n')
    assert cli.main(["figure", str(study), "--out", str(out)]) == 2
    assert "a linkage is accepted" in capsys.readouterr().err
