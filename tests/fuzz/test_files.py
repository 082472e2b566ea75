"""Mutated study files: accepted or refused with reasons. Ten thousand: `python -m tests.fuzz files`."""

import random
import tomllib
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jointplay import cli
from jointplay.display.errors import Problem
from jointplay.kinds import KINDS
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.study import vary_table
from jointplay.study.file import validate
from tests.fuzz import files, values
from tests.support.study_samples import BENT, BENT_WRITTEN_OUT, GUIDED, STRETCHED, TEXT, WRITTEN_OUT
from tests.support.sweep_samples import CELLS, CHAINS

GRID = "gap = { start = 2.9, stop = 3.1, num = 3 }\nrestitution = [0.7, 0.8]\n"
ZIPPED = CELLS.replace(GRID, "gap = [2.9, 3.0, 3.1]\nrestitution = [0.7, 0.8, 0.7]\nzip = true\n")
CASES = CELLS.replace(GRID, "cases = [{ gap = 2.9, restitution = 0.7 }, { gap = 3.0, restitution = 0.8 }]\n")
SHIPPED = {tomllib.loads(text)["kind"]: text for text in values.TEXTS}
TEXTS = [
    TEXT,
    WRITTEN_OUT,
    BENT,
    BENT_WRITTEN_OUT,
    GUIDED,
    STRETCHED,
    CELLS,
    CHAINS,
    ZIPPED,
    CASES,
    *SHIPPED.values(),
]
SEEDS = st.integers(0, 2**32)


def said(path, *words):
    """`check` a file: accepted in silence or refused with key paths; any exception fails the test."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as errors:
        code = cli.main(["check", str(path), *words])
    lines = [line for line in errors.getvalue().splitlines() if not line.startswith("warning ")]
    assert code in (0, 2)
    assert bool(lines) == (code == 2)
    assert all(files.LINE.fullmatch(line) for line in lines[1:])
    return "\n".join(lines)


def written(folder, text):
    path = folder / "study.toml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    return path


@pytest.mark.long
def test_a_study_of_many_cells_is_planned_and_not_run(tmp_path):
    (text,) = (each for each in values.TEXTS if "Map of the foot of the wedge of chaos" in each)
    path = str(written(tmp_path, text))
    assert files.ran(path, tomllib.loads(text), str(tmp_path / "out")) == (None, True)
    assert not (tmp_path / "out").exists()


def test_the_samples_hold_every_kind_of_study():
    assert set(SHIPPED) == set(KINDS)
    assert ZIPPED != CELLS != CASES
    assert all(validate({"name": "sample"} | tomllib.loads(text)).vary for text in (ZIPPED, CASES))
    assert all(validate({"name": "sample"} | tomllib.loads(text)) for text in (GUIDED, STRETCHED))


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(text=st.sampled_from(TEXTS), data=st.data())
def test_a_text_with_characters_changed(text, data, tmp_path_factory):
    start = data.draw(st.integers(0, len(text)))
    stop = data.draw(st.integers(start, min(len(text), start + 20)))
    changed = text[:start] + data.draw(st.text(max_size=8)) + text[stop:]
    said(written(tmp_path_factory.getbasetemp(), changed))


@pytest.mark.nightly
@settings(max_examples=150, deadline=None)
@given(seed=SEEDS)
def test_a_study_with_its_tables_changed(seed, tmp_path_factory):
    dice = random.Random(seed)
    table = files.changed_table(tomllib.loads(dice.choice(TEXTS)), dice)
    said(written(tmp_path_factory.getbasetemp(), files.dumped(table)))


@pytest.mark.nightly
@settings(max_examples=60, deadline=None)
@given(seed=SEEDS)
def test_any_key_set_to_anything_on_the_command_line(seed, tmp_path_factory):
    dice = random.Random(seed)
    text = dice.choice(TEXTS)
    change = files.change(tomllib.loads(text), dice)
    said(written(tmp_path_factory.getbasetemp(), text), "--set", change)


@pytest.mark.long
@given(seed=SEEDS)
@settings(max_examples=30, deadline=None)
def test_what_is_written_is_what_was_changed(seed):
    dice = random.Random(seed)
    table = files.changed_table(dice.choice(values.TABLES), dice)
    assert tomllib.loads(files.dumped(table)) == table or "nan" in repr(table)  # no NaN equals another


@pytest.mark.parametrize(
    ("text", "change", "key"),
    [
        (
            TEXT,
            "figure={ kind = 'time_history', events = 1.5 }",
            "figure.events: got 1.5; true, false, or a list",
        ),
        (SHIPPED["spectrum"], f"figure.between=[0, {10**30}]", ""),
        (SHIPPED["spectrum"], f"figure.between=[{10**30}, 1]", "figure.between: got [1000000000000000"),
        (
            TEXT,
            "analysis.turns=1000000000",
            "analysis.turns: got 1000000000.0; together with samples_per_turn at",
        ),
        (GUIDED, "mechanism.joints[3].name={ a = 1 }", "mechanism.joints[3].name: got {'a': 1}"),
        (CHAINS, "vary.cases=[2.9, 3.0]", "vary.cases: got [2.9, 3.0]; the name of a parameter is accepted"),
        (CHAINS, "vary.zip=[2.9, 3.0]", "vary.zip: got [2.9, 3.0]; the name of a parameter is accepted"),
        (CELLS, "vary.gap=3", "vary.gap: got 3; a list of numbers, or a table of start, stop, num and scale"),
        (SHIPPED["basins"], "analysis.pairs=1000000000", "analysis.pairs: got 1000000000; a whole number"),
    ],
)
def test_what_was_once_a_traceback_is_refused_by_its_key(text, change, key, tmp_path):
    assert key in said(written(tmp_path, text), "--set", change)


def test_a_plane_that_no_memory_holds_is_refused(tmp_path):
    changes = [
        f"analysis.plane.{name}.num=100000" for name in tomllib.loads(SHIPPED["basins"])["analysis"]["plane"]
    ]
    assert "analysis.plane: got '10,000,000,000 nodes'" in said(
        written(tmp_path, SHIPPED["basins"]), "--set", *changes
    )


def test_too_little_memory_is_said_and_not_thrown(tmp_path, monkeypatch, capsys):
    def exhausted(*_, **__):
        raise MemoryError("8 TiB")

    monkeypatch.setattr("jointplay.study.file.load", exhausted)
    assert cli.main(["check", str(tmp_path)]) == cli.FAILED
    assert "not enough memory: 8 TiB" in capsys.readouterr().err


def test_a_key_that_cannot_be_printed_plainly_is_quoted():
    assert str(Problem("vary.a\nb", 1, "nothing")) == "'vary.a\\nb': got 1; nothing"
    assert str(Problem(" mechanism", 1, "nothing")) == "' mechanism': got 1; nothing"


@pytest.mark.parametrize("form", ["gap", "zip"])
def test_of_a_long_range_some_values_are_tried_out_and_both_ends(form, tmp_path, monkeypatch):
    tried, checked = [], vary_table.axes

    def counted(mechanism, given, root):
        tried.append(sum(map(len, given.values())))
        return checked(mechanism, given, root)

    monkeypatch.setattr(vary_table, "axes", counted)
    text = CELLS.replace(
        GRID, "gap = { start = 1.0, stop = -1.0, num = 20000 }\n" + "zip = true\n" * (form == "zip")
    )
    assert "vary.gap" in said(written(tmp_path, text))
    assert sum(tried) == vary_table.TRIED


def test_beside_other_mistakes_no_more_of_a_long_range_is_tried(tmp_path, monkeypatch):
    made, at = [], Parameter.at
    monkeypatch.setattr(Parameter, "at", lambda self, value: made.append(value) or at(self, value))
    ranged = CELLS.replace('"lyapunov"', '"bifurcation"').replace(
        GRID, "gap = { start = 2.9, stop = 3.1, num = 20000 }\n"
    )
    assert "analysis.turns" in said(written(tmp_path, ranged), "--set", "analysis.turns=-1")
    assert 0 < len(made) < 3 * vary_table.TRIED


def test_a_wall_beyond_the_reach_of_rounding_is_no_traceback(tmp_path):
    """A unit of the position does not show in its gap."""
    text = CELLS.replace(GRID, "gap = [2.95, 3.1e30]\n")
    assert text != CELLS
    assert said(written(tmp_path, text)) == ""
