"""The verb that computes and draws the paper's studies, and the tables that it writes."""

import re
import signal
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from jointplay import cli
from jointplay.analysis.states import basins
from jointplay.display.errors import InputError
from jointplay.jobs import worker
from jointplay.jobs.journal import Journal
from jointplay.study.file import load
from jointplay.study.results import store
from jointplay.study.results.outcome import explain, failed_cells
from jointplay_lab import reproduce as module
from jointplay_lab.paper import claims, readings
from jointplay_lab.reproduce import choose, find_folder, reproduce
from tests.support.study_samples import TEXT, result, stand_in
from tests.support.sweep_samples import PLANE, die, forked, same

PAPER = Path(__file__).parents[2] / "studies" / "paper"
FLAGS = "ok diverged step_limit chatter not_converged bad_parameters crashed not_run interrupted"
KIND = 'kind = "claims"\n[mechanism]\ncatalog = "chunmei2002"\n'


def graded():
    """A result of kind claims."""
    grades = {
        "flag_values": np.arange(4, dtype=np.int8),
        "flag_meanings": "undecidable not partly reproduced",
    }
    ok = {"flag_values": np.arange(len(FLAGS.split()), dtype=np.int8), "flag_meanings": FLAGS}
    data = {
        "grade": ("claim", np.array([2, 3], np.int8), grades),
        "evidence": ("claim", ["ratio 1.29 to 4.6 (16 of 18 above 1); " * 6, "period 1"]),
        "status": ((), np.int8(0), ok),
    }
    texts = ("claim", ["clearance raises the peaks of acceleration and joint force", "partly chaotic"])
    return xr.Dataset(data, {"claim": ["peaks", "chaos"], "claim_text": texts}, {"kind": "claims"})


@pytest.fixture
def folder(tmp_path, calls, monkeypatch):
    """A folder of three studies whose analyses compute nothing: two responses and the claims."""
    place = tmp_path / "studies" / "paper"
    place.mkdir(parents=True)
    for name, text in (("fig03", TEXT), ("fig04", TEXT), ("claims", KIND)):
        (place / f"{name}.toml").write_text(text)
    stand_in(monkeypatch, "claims", lambda *_, **__: graded())
    monkeypatch.setattr(module.figures, "draw", figure)
    monkeypatch.setattr(module, "_compile", lambda paths: None)
    monkeypatch.chdir(tmp_path)
    return place


def figure(*_):
    from matplotlib.figure import Figure

    return Figure()


def test_all_studies_are_computed_drawn_and_the_table_printed(folder, tmp_path, capsys):
    assert cli.main(["reproduce", "--jobs", "1"]) == 0
    out = tmp_path / "results" / "reproduced"
    names = [f"{stem}.{end}" for stem in ("claims", "fig03", "fig04") for end in ("nc", "pdf", "png")]
    assert sorted(path.name for path in out.iterdir()) == sorted([*names, "claims.txt"])
    said = capsys.readouterr().out
    assert re.findall(r"\d of 3  (\w+) +done", said) == ["claims", "fig03", "fig04"]
    assert (out / "claims.txt").read_text() in said
    assert "3 of 3 studies done; results in results/reproduced" in said
    assert store.open_result(out / "fig03.nc").attrs["study"] == "fig03"


def test_only_those_named(folder, tmp_path, capsys):
    assert cli.main(["reproduce", "fig04", "fig04", "--jobs", "1", "--out", "here"]) == 0
    assert "1 of 1 studies done; results in here" in capsys.readouterr().out
    assert sorted(path.name for path in (tmp_path / "here").iterdir()) == [
        "fig04.nc",
        "fig04.pdf",
        "fig04.png",
    ]


def test_an_unknown_name_is_refused_before_anything_runs(folder, tmp_path, capsys):
    assert cli.main(["reproduce", "fig3", "fig04", "other"]) == 2
    said = capsys.readouterr().err
    assert "2 problems" in said
    assert "did you mean 'fig03'?" in said
    assert "accepted: claims, fig03, fig04" in said
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("words", [["--jobs", "0"], ["--out", "fig.txt/x"]])
def test_wrong_options(folder, tmp_path, words, capsys):
    (tmp_path / "fig.txt").touch()
    assert cli.main(["reproduce", *words]) == 2
    assert words[0] in capsys.readouterr().err


def test_a_study_that_fails_is_named_and_the_rest_goes_on(folder, tmp_path, monkeypatch, capsys):
    (folder / "fig01.toml").write_text(TEXT.replace("turns = 2", "turnz = 2"))
    (folder / "fig02.toml").write_text("kind =")
    (folder / "fig05.toml").write_text(KIND.replace("claims", "section") + "[analysis]\nturns = 2\n")

    def crash(*_, **__):
        raise ZeroDivisionError("at the end of the road")

    stand_in(monkeypatch, "section", crash)
    stand_in(monkeypatch, "response", lambda *_, **__: result(status=2))
    assert cli.main(["reproduce", "--jobs", "1"]) == 1
    said = capsys.readouterr()
    assert "1 of 6 studies done" in said.out
    failures = dict(re.findall(r"^failed: (\w+): (.*)$", said.err, re.M))
    assert set(failures) == {"fig01", "fig02", "fig03", "fig04", "fig05"}
    assert "turnz" in failures["fig01"]
    assert "ZeroDivisionError: at the end of the road" in failures["fig05"]
    assert failures["fig03"].startswith("step_limit")
    assert (tmp_path / "results" / "reproduced" / "fig03.nc").is_file()  # what was computed is kept
    assert (tmp_path / "results" / "reproduced" / "claims.txt").is_file()


def test_without_studies_it_says_where_to_run_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(module, "__file__", str(tmp_path / "a" / "b" / "c" / "d.py"))
    monkeypatch.chdir(tmp_path)
    assert cli.main(["reproduce"]) == 2
    said = capsys.readouterr().err
    assert "studies/paper" in said
    assert "checkout of the project" in said


def test_the_studies_of_the_checkout_are_found_from_anywhere(tmp_path):
    assert find_folder(tmp_path).samefile(PAPER)
    (tmp_path / "studies" / "paper").mkdir(parents=True)
    (tmp_path / "studies" / "paper" / "x.toml").touch()
    assert find_folder(tmp_path) == tmp_path / "studies" / "paper"


def test_what_takes_longest_begins_first():
    names = [path.stem for path in choose(PAPER)]
    assert [name for name in names if name in ("claims", "readings")] == ["readings", "claims"]
    assert names.index("claims") < names.index("fig03a")
    assert set(names) == {path.stem for path in PAPER.glob("*.toml")}


@pytest.mark.nightly
def test_in_worker_processes(tmp_path):
    """Real ones, and the same data as in this process."""
    place = tmp_path / "studies"
    place.mkdir()
    short = TEXT.replace("transient = 1", "transient = 0").replace("turns = 2", "turns = 1")
    for name in ("one", "two"):
        (place / f"{name}.toml").write_text(short)
    lines = []
    found = [
        reproduce(jobs=jobs, out=tmp_path / str(jobs), folder=place, say=lines.append) for jobs in (1, 2)
    ]
    assert [outcome.failure for outcomes in found for outcome in outcomes] == [""] * 4
    assert len(lines) == 4
    for name in ("one", "two"):
        a, b = (store.open_result(tmp_path / str(jobs) / f"{name}.nc") for jobs in (1, 2))
        xr.testing.assert_identical(a.drop_vars("wall_time"), b.drop_vars("wall_time"))


@pytest.mark.nightly
def test_a_killed_run_goes_on_where_it_was(tmp_path, monkeypatch):
    """Cells that an earlier run finished do not run again, unless they are to be dropped."""
    place, out, begun, begin = tmp_path / "studies", tmp_path / "out", [], worker.Notes.begin
    place.mkdir()
    (place / "plane.toml").write_text(PLANE)
    monkeypatch.setattr(basins, "BLOCK", 5)
    monkeypatch.setattr(worker, "BATCH", 0.0)

    def noted(notes, key):
        begun.append(key)
        if len(begun) == 3:
            die()
        begin(notes, key)

    monkeypatch.setattr(worker.Notes, "begin", noted)
    assert forked(lambda: reproduce(jobs=1, out=out, folder=place)) == signal.SIGKILL
    done = Journal(out / "plane.journal").index()
    assert len(done) == 2
    begun += [None] * 3
    (outcome,) = reproduce(jobs=1, out=out, folder=place)
    assert outcome.failure == ""
    assert len(begun) == 3 + 4
    assert not done.keys() & set(begun)
    reproduce(jobs=1, out=tmp_path / "anew", folder=place)
    assert same(*(store.open_result(where / "plane.nc") for where in (out, tmp_path / "anew")))
    begun.clear()
    begun += [None] * 3
    reproduce(jobs=1, out=out, folder=place, fresh=True)
    assert len(begun) == 3 + 6


def test_the_studies_of_the_whole_paper_validate():
    readings, claims = (load(PAPER / f"{name}.toml").record for name in ("readings", "claims"))
    assert readings.keywords()["readings"][0] == "as_printed"
    assert readings.keywords()["rtol"] == 1e-10
    assert claims.keywords()["damping_ratios"] == (0.0, 0.005, 0.01, 0.02, 0.05)
    assert "300 turns after 400 dropped turns" in readings.summary()


@pytest.mark.parametrize(
    ("kind", "changes", "words"),
    [
        ("readings", ["analysis.panels=['d']"], r"analysis\.panels\[0\]: got 'd'; there is no such panel"),
        ("readings", ["analysis.readings=['frictionles']"], "did you mean 'frictionless'"),
        ("readings", ["analysis.turns=0"], r"analysis\.turns"),
        ("readings", ["figure.kind='overview'"], r"figure\.kind: got 'overview'"),
        ("readings", ["mechanism={catalog='lorenz'}"], "mechanism: .*motor-driven"),
        ("claims", ["analysis.damping_ratios=[2.0]"], r"analysis\.damping_ratios"),
        ("claims", ["analysis.record=['angle']"], r"analysis\.record"),
    ],
)
def test_wrong_studies_of_the_whole_paper(kind, changes, words):
    with pytest.raises(InputError, match=words):
        load(PAPER / f"{kind}.toml", changes)


def test_the_table_of_conclusions():
    lines = claims.table(graded()).splitlines()
    assert lines[0].split() == ["conclusion", "of", "the", "paper", "grade", "numbers"]
    assert lines[2].startswith("1 clearance raises the peaks of")
    assert "partly" in lines[2]
    assert lines[-1].startswith("2 partly chaotic")
    assert lines[-1].endswith("period 1")
    assert lines[-1].split()[-3:-2] == ["reproduced"]
    assert max(map(len, lines)) <= 166
    column = lines[0].index("numbers")
    assert all(line[column - 2 : column].strip() == "" for line in lines)


def test_the_table_of_readings():
    flags = {"flag_values": np.arange(3, dtype=np.int8), "flag_meanings": "undecided periodic chaotic"}
    dims, numbers = ("panel", "reading"), np.array([[1.0, np.nan]])
    names = ("separations", "impacts", "contact_fraction", "extent", "growth", "growth_standard_error")
    data = dict.fromkeys(names, (dims, numbers))
    data |= {"period": (dims, [[0, -1]]), "motion": (dims, np.array([[2, 0]], np.int8), flags)}
    texts = ("reading", ["as it stands", "otherwise"])
    table = readings.table(xr.Dataset(data, {"panel": ["a"], "reading": ["x", "y"], "reading_text": texts}))
    _, first, second, *_ = table.splitlines()
    assert first.split() == [
        "a",
        "x",
        "1.00",
        "1.00",
        "1.0000",
        "1e+00",
        "none",
        "+1.000",
        "±",
        "1.000",
        "chaotic",
    ]
    assert second.split() == ["a", "y", "-", "-", "-", "-", "-", "-", "undecided"]
    assert "otherwise" in table


def test_failed_cells_are_named():
    ok = {"flag_values": np.arange(len(FLAGS.split()), dtype=np.int8), "flag_meanings": FLAGS}
    cells = np.zeros((2, 6), np.int8)
    data = {"status": ((), np.int8(2), ok), "cell_status": (("panel", "reading"), cells, ok)}
    found = xr.Dataset(data, {"panel": ["a", "b"], "reading": list("uvwxyz")})
    found["cell_status"][1, 2] = 2
    assert failed_cells(found) == ["b w"]
    assert explain(found).endswith("(in b w)")
    found["cell_status"][:] = 2
    assert explain(found).endswith("b v and 4 more)")
    assert explain(xr.Dataset({"status": ((), np.int8(0), ok)})) is None
