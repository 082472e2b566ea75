"""What cannot be read, written or meant: refused at once, before any work, and never by a traceback."""

import json
import os
import sys
import warnings
from collections import UserString

import netCDF4
import numpy as np
import pytest

import jointplay as jp
from jointplay import cli
from jointplay.display import errors
from jointplay.display.errors import InputError
from jointplay.display.terminal import Progress
from jointplay.jobs import parallel, pool
from jointplay.jobs.journal import Journal
from jointplay.solver.mechanism import records
from jointplay.study import plan
from jointplay.study.results import store
from tests.support.program import jointplay
from tests.support.study_samples import TEXT, WRITTEN_OUT

MANY = 40_000
KEYS = "".join(f"wrong_{i} = 1\n" for i in range(MANY))


def refused(words, capsys, code=2):
    """What a command says that ends with this code."""
    assert cli.main([str(word) for word in words]) == code
    said = capsys.readouterr().err
    assert "Traceback" not in said
    return said


@pytest.fixture
def stored(study, calls, tmp_path):
    """A result on the disk."""
    assert cli.main(["run", str(study), "--out", str(tmp_path / "out"), "--no-figure"]) == 0
    calls.clear()
    return tmp_path / "out" / "small.nc"


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "text",
    [KEYS + TEXT, TEXT.replace("gear_ratio = 3.0\n", KEYS), TEXT + KEYS],
    ids=["top", "mechanism", "figure"],
)
def test_of_very_many_wrong_keys_a_hundred_are_shown(text, tmp_path, capsys):
    (tmp_path / "a.toml").write_text(text)
    first, *lines, last = refused(["check", tmp_path / "a.toml"], capsys).splitlines()
    assert (first, last) == (f"wrong input, {MANY} problems:", f"  and {MANY - 100} more")
    assert len(lines) == errors.SHOWN
    assert all("wrong_" in line for line in lines)


@pytest.mark.parametrize("rows", ["links", "joints"])
def test_a_list_without_end_is_refused_before_its_items_are_looked_at(rows, tmp_path, capsys, monkeypatch):
    looked = []
    monkeypatch.setattr(records, "_valid", lambda form, given: looked.append(given))
    items = "{a = 1}, " * 20_000
    (tmp_path / "a.toml").write_text(f'kind = "response"\nmechanism = {{{rows} = [{items}]}}\n')
    said = refused(["check", tmp_path / "a.toml"], capsys)
    assert f"mechanism.{rows}: got '20000 of them'; a list of at most 1000 is accepted" in said
    assert not looked


def test_wrong_keys_in_a_linkage_written_out_are_counted_with_what_does_not_fit(tmp_path, capsys):
    keys = "".join(f"wrong_{i} = 1\n" for i in range(300))
    (tmp_path / "a.toml").write_text(WRITTEN_OUT.replace("[mechanism]\n", "[mechanism]\n" + keys))
    assert "wrong input, 300 problems:" in refused(["check", tmp_path / "a.toml"], capsys)


def test_to_say_what_is_accepted_names_are_compared_only_when_it_is_read(monkeypatch):
    monkeypatch.setattr(errors, "did_you_mean", lambda *_: pytest.fail("compared"))
    problem = errors.unknown("a", 1, "gpa", ["gap"])
    assert isinstance(problem.expected, UserString)


@pytest.mark.parametrize("text", [f"{'a.' * 1000}a = 1\n{TEXT}", f"{TEXT}[{'a.' * 5000}a]\n"])
def test_a_key_of_a_thousand_dots_is_refused(text, tmp_path, capsys):
    (tmp_path / "a.toml").write_text(text)
    for words in ([], ["--set", "name=b"]):
        said = refused(["check", tmp_path / "a.toml", *words], capsys)
        assert "at most 16 levels" in said or "a key of more than 1000 parts" in said


@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "value", ["a." * 20_000 + "a=1", f"a={{ {'a.' * 20_000}a = 1 }}", "a=" + "[" * 100_000]
)
def test_a_change_without_end_is_refused(value, study, capsys):
    refused(["check", study, "--set", value, "b=1"], capsys)


def test_combinations_without_number_are_refused(tmp_path, capsys):
    axes = "".join(f"gap_{i} = [1.0, 2.0]\n" for i in range(20_000))
    (tmp_path / "a.toml").write_text(f"{TEXT}[vary]\n{axes}")
    assert "vary: got 'combinations of 20000 parameters'; at most" in refused(
        ["check", tmp_path / "a.toml"], capsys
    )


def test_cases_of_ever_other_parameters_name_a_few(tmp_path, capsys):
    cases = ", ".join(f"{{ gap_{i} = 1.0 }}" for i in range(3000))
    (tmp_path / "a.toml").write_text(f"{TEXT}[vary]\ncases = [{cases}]\n")
    said = refused(["check", tmp_path / "a.toml"], capsys)
    assert "vary.gap_7: got 'gap_7'; there is no such parameter" in said
    assert said.endswith("and 2900 more\n")
    names = [f"p{i}" for i in range(12)]
    system = {"rates": f'{{ x = "-x*({"+".join(names)})" }}', "states": "{ x = 1.0 }"}
    system["parameters"] = f"{{ {', '.join(f'{name} = 1.0' for name in names)} }}"
    lines = "".join(f"{key} = {value}\n" for key, value in system.items())
    cases = ", ".join(f"{{ {name} = 2.0 }}" for name in names)
    text = f'kind = "response"\n[mechanism]\n{lines}[analysis]\nduration = 1\n[vary]\ncases = [{cases}]\n'
    (tmp_path / "a.toml").write_text(text)
    assert "p7, ..., as in the other cases" in refused(["check", tmp_path / "a.toml"], capsys)


@pytest.mark.timeout(120)
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes of POSIX")
def test_a_pipe_without_a_writer_is_not_waited_for(tmp_path, capsys):
    for name in ("pipe.toml", "pipe.nc"):
        os.mkfifo(tmp_path / name)
        assert "no regular file" in refused(["check", tmp_path / name], capsys)
    assert cli.main(["list", str(tmp_path)]) == 0
    assert "pipe.toml  ?" in capsys.readouterr().out


def test_a_study_file_beyond_all_size_is_not_read(tmp_path, capsys):
    with open(tmp_path / "a.toml", "wb") as file:
        file.truncate(10**12)
    assert "1,000,000,000,000 bytes are more than" in refused(["check", tmp_path / "a.toml"], capsys)


@pytest.mark.parametrize("ending", ["nc", "pdf", "png"])
def test_a_folder_in_the_place_of_a_file_is_seen_before_any_work(ending, study, calls, tmp_path, capsys):
    (tmp_path / "out" / f"small.{ending}").mkdir(parents=True)
    said = refused(["run", study, "--out", tmp_path / "out"], capsys)
    assert f"a folder in which small.{ending} can be written (a folder has this name)" in said
    assert calls == []


def test_a_file_in_the_place_of_the_journal_is_seen_before_any_work(tmp_path):
    (tmp_path / "a.journal").write_text("")
    with pytest.raises(InputError, match=r"a\.journal can be written \(something else has this name\)"):
        store.check_writable(tmp_path, folders=["a.journal"])


@pytest.mark.parametrize("verb", ["figure", "export"])
@pytest.mark.parametrize("name", ["folder.png", "x" * 252 + ".png", "/", "..", "a\0b.png"])
def test_an_impossible_target_is_seen_before_it_is_drawn(
    verb, name, stored, calls, tmp_path, monkeypatch, capsys
):
    name = name.replace(".png", ".mat") if verb == "export" else name
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "folder.mat").mkdir()
    assert "--out: got " in refused([verb, stored, "--out", name], capsys)
    assert calls == []


@pytest.mark.parametrize("out", ["", "a\0b", "n" * 300, "o\udcff", "loop", "loop/out"])
def test_an_impossible_folder_is_seen_before_any_work(out, study, calls, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    assert "--out: got " in refused(["run", study, "--out", out], capsys)
    assert calls == []


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a disk that is always full, of Linux")
def test_a_full_disk_is_seen_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "temporary_name", lambda _: tmp_path / "full")
    (tmp_path / "full").symlink_to("/dev/full")
    with pytest.raises(InputError, match="No space left"):
        store.check_writable(tmp_path)


def test_a_folder_is_where_it_is_named(study, calls, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for out in ("~root", "http::x"):
        assert cli.main(["run", str(study), "--out", out, "--no-figure"]) == 0
        assert jp.open(f"{out}/small.nc").attrs["kind"] == "response"
        assert [path.name for path in (tmp_path / out).iterdir()] == ["small.nc"]


@pytest.mark.parametrize("name", ["𝒳" * 60, "ü" * 101, "../x", "a/b", "a\\u0000b", ""])
def test_a_name_that_no_file_can_have_is_refused(name, study, capsys):
    said = refused(["check", study, "--set", f'name="{name}"'], capsys)
    assert "name: got " in said
    assert "a name of at most" in said


@pytest.mark.parametrize(
    "words", ["--part 3/2", "--part 1/" + "9" * 5000, "--part 1/" + "9" * 30, "--jobs 1" + "0" * 30]
)
def test_shares_and_workers_that_there_cannot_be(words, study, calls, tmp_path, capsys):
    refused(["run", study, "--out", tmp_path, *words.split()], capsys)
    assert calls == []


def test_no_more_workers_start_than_there_are_tasks(monkeypatch, tmp_path):
    asked = []

    def in_tasks(jobs, workers, *_):
        asked.append(workers)

    monkeypatch.setattr(pool, "in_tasks", in_tasks)
    pool.Pool(64).run(["a", "b", "c"], Journal(tmp_path), print)
    assert asked == [3]
    assert plan._longest([2, 1], 10**6) == 2


PROVENANCE = [
    None,
    "{",
    3,
    np.arange(3),
    "null",
    "[" * 20_000,
    '{"study": [1]}',
    '{"study": {"figure": [1]}}',
]
PROVENANCE += [
    '{"study": {"figure": {"turns": 1' + "0" * 400 + "}}}",
    '{"study": {"kind": 3, "figure": null}}',
]
PROVENANCE += ['{"study": ' + '{"a":' * 900 + "1" + "}" * 901]


@pytest.mark.parametrize("given", PROVENANCE, ids=range(len(PROVENANCE)))
def test_damaged_provenance_is_no_traceback(given, stored, tmp_path, capsys):
    with netCDF4.Dataset(stored, "a") as file:
        file.delncattr("provenance") if given is None else file.setncattr("provenance", given)
    refused(["check", stored], capsys)
    assert cli.main(["figure", str(stored), "--out", str(tmp_path / "a.png")]) in (0, 2)
    assert cli.main(["export", str(stored), "--out", str(tmp_path / "a.mat")]) == 0


@pytest.mark.parametrize("over", [[], ["--over", "t", "t"]])
def test_results_of_other_programs_are_read_or_refused(over, tmp_path, capsys):
    with netCDF4.Dataset(tmp_path / "none.nc", "w"):
        pass
    with netCDF4.Dataset(tmp_path / "odd.nc", "w") as file:
        file.createDimension("t", 3)
        odd = file.createVariable("n" * 100, "f8", ("t",))
        odd[:] = 1.0
    with netCDF4.Dataset(tmp_path / "coordinates.nc", "w") as file:
        file.createDimension("t", 3)
        file.createVariable("a", "f8", ("t",)).coordinates = 3
    for name in ("none", "odd", "coordinates"):
        for ending in ("csv", "mat"):
            words = ["export", tmp_path / f"{name}.nc", "--out", tmp_path / f"a.{ending}", *over]
            assert cli.main(list(map(str, words))) in (0, 2)
        assert cli.main(["figure", str(tmp_path / f"{name}.nc"), "--out", str(tmp_path / "a.png")]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_a_cell_of_a_damaged_sweep_is_refused(stored):
    dataset = jp.open(stored)
    for swept, values in (("nowhere", {"nowhere": 1}), ("time", {"time": None}), ("time", {"time": "x"})):
        with pytest.raises(InputError, match=r"cell|a number is accepted"):
            jp.cell(dataset.assign_attrs(swept=swept), **values)


def test_what_dead_workers_leave_is_not_told(monkeypatch):
    monkeypatch.setenv("PYTHONWARNINGS", "error")
    with warnings.catch_warnings():
        parallel.hush()
        parallel.hush()
        warnings.warn("A worker stopped while some jobs were given to the executor.", stacklevel=1)
    assert os.environ["PYTHONWARNINGS"] == "error,ignore:resource_tracker:UserWarning"


def test_progress_without_a_terminal_to_tell_is_silent(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    with Progress("a") as progress:
        progress.last = -1e9
        progress(0.5)


def test_any_terminal_can_be_written_to(tmp_path):
    (tmp_path / "a.toml").write_text(TEXT.replace("A test", "Kurbel µ ± — Ω"), encoding="utf-8")
    plain = os.environ | {"PYTHONIOENCODING": "ascii", "COLUMNS": "1", "TERM": "dumb"}
    done = jointplay("check", tmp_path / "a.toml", env=plain)
    assert done.returncode == 0, done.stderr
    assert r"Kurbel \xb5 \xb1 \u2014 \u03a9" in done.stdout


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a disk that is always full, of Linux")
def test_output_that_cannot_be_written_is_told_at_the_end(monkeypatch, capfd):
    with open("/dev/full", "w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert cli.main(["schema"]) == 1
        monkeypatch.undo()
    assert "not done: [Errno 28]" in capfd.readouterr().err


def test_the_schema_is_json_on_every_terminal(capsys):
    assert cli.main(["schema"]) == 0
    text = capsys.readouterr().out
    assert text.isascii()
    assert json.loads(text)["$schema"]
