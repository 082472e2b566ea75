"""Which cells a study asks for, and what `plan` and `status` say of them."""

import pytest

import jointplay as jp
from jointplay import cli
from jointplay.analysis import vary
from jointplay.display.errors import InputError
from jointplay.jobs.journal import Journal
from jointplay.jobs.pool import Pool
from jointplay.study.execute import complete
from jointplay.study.plan import plan, status
from jointplay.study.run import first_work, run
from jointplay.study.vary_table import ACCEPTED, points
from tests.support.sweep_samples import CELLS, CHAINS, loaded, ran
from tests.support.wrong import refused

HEAD, TAIL = CELLS.split("[vary]\n")[0], "\n[analysis]\nturns = 5\n"


def told(vary):
    """Key and message of each problem of a `[vary]` table."""
    return refused(loaded, f"{HEAD}[vary]\n{vary}\n{TAIL}")


def changes(vary):
    record = loaded(f"{HEAD}[vary]\n{vary}\n{TAIL}").record
    return points(record.mechanism, record.vary).changes


def test_a_list_without_values_is_told_what_is_accepted():
    assert told("gap = []") == {"vary.gap": f"{ACCEPTED} is accepted"}


def test_values_make_a_grid_unless_they_go_together():
    lists = "gap = [3.0, 2.0]\nrestitution = [0.8, 0.7]"
    assert [tuple(each.values()) for each in changes(lists)] == [(2, 0.7), (2, 0.8), (3, 0.7), (3, 0.8)]
    pairs = [{"gap": 3.0, "restitution": 0.8}, {"gap": 2.0, "restitution": 0.7}]
    assert changes(f"zip = true\n{lists}") == pairs
    assert len(changes(f"zip = false\n{lists}")) == 4
    written = "cases = [{gap = 3.0, restitution = 0.8}, {restitution = 0.7, gap = 2.0}]"
    assert changes(written) == pairs
    same = "zip = true\ngap = [2.0, 2.0]\nrestitution = { start = 0.7, stop = 0.8, num = 2 }"
    assert [each["gap"] for each in changes(same)] == [2.0, 2.0]


@pytest.mark.parametrize(
    ("vary", "keys"),
    [
        ("gapp = [1.0]", {"vary.gapp"}),
        ("gap = [1.0, -1.0, 1.0]", {"vary.gap[1]", "vary.gap[2]"}),
        ("zip = true\ngap = [1.0, 2.0]\nrestitution = [0.5]", {"vary.zip"}),
        ("zip = true", {"vary.zip"}),
        ("zip = true\ngap = [1.0, 2.0, 1.0]", {"vary.zip"}),
        ("zip = true\ngap = [1.0, -2.0]", {"vary.gap[1]"}),
        ("zip = 3\ngap = [1.0]", {"vary.zip"}),
        ("gap = true", {"vary.gap"}),
        ("gap = [{gap = 1.0}]", {"vary.gap"}),
        ("cases = [1.0]", {"vary.cases"}),
        ("gap = [1.0]\ncases = [{gap = 1.0}]", {"vary.cases"}),
        ("cases = [{gap = 1.0}, {restitution = 0.5}]", {"vary.cases[0]", "vary.cases[1]"}),
        ("cases = [{}]", {"vary.cases[0]"}),
        ("cases = [{gap = 1.0}, {gap = 1.0}]", {"vary.cases[1]"}),
        ("cases = [{gap = 1.0}, {gap = -1.0}]", {"vary.cases[1].gap"}),
        ("cases = [{gap = 1.0}, {gap = 'x'}]", {"vary.cases[1].gap"}),
        ("gap.start = 1\ngap.stop = 2\ngap.num = 2000\nrestitution.start = 0.1\nrestitution.stop = 0.9\n"
         "restitution.num = 2000", {"vary"}),
    ],
)  # fmt: skip
def test_every_mistake_is_told_with_its_place(vary, keys):
    assert told(vary).keys() == keys


def test_paths_may_be_nested_in_cases_too():
    head = 'kind = "response"\nname = "a"\n[mechanism]\ncatalog = "chunmei2002"\nclearance = 1e-4\n[vary]\n'
    cases = "cases = [{joints.B.contact.stiffness = 1e6}, {joints.B.contact.stiffness = 2e6}]"
    record = loaded(f"{head}{cases}\n[analysis]\nturns = 1\n").record
    found = points(record.mechanism, record.vary)
    assert [each["joints.B.contact.stiffness"] for each in found.changes] == [1e6, 2e6]
    assert (found.dims, found.shape) == (("case",), (2,))
    assert found.coordinates["stiffness"][0] == "case"


def test_looking_at_many_values_takes_so_many_looks(monkeypatch):
    compared, made = [], []

    class Value(float):
        """A number that counts how often it is compared."""

        __hash__ = float.__hash__

        def __eq__(self, other):
            compared.append(1)
            return float(self) == float(other)

    def counted(mechanism, changes):
        made.extend([1] * bool(changes))
        return varied(mechanism, changes)

    varied = jp.System.varied
    monkeypatch.setattr(jp.System, "varied", counted)
    record = loaded(CELLS, "vary={gap={start=2.9, stop=3.1, num=500}}").record
    assert len(made) == 500
    vary.axes(record.mechanism, {"gap": [Value(2 + i / 500) for i in range(500)]})
    assert len(made) == 1000
    assert len(compared) < 100
    assert len({key for job in first_work(record).jobs for key in job.keys}) == 500
    assert len(made) == 1001  # the one more tells whether its structure goes in lanes


@pytest.mark.parametrize("kind", ["claims", "readings", "scheme_comparison"])
def test_kinds_that_look_at_one_mechanism_do_not_vary_it(kind):
    with pytest.raises(InputError) as error:
        loaded(
            f'kind = "{kind}"\nname = "a"\n[mechanism]\ncatalog = "chunmei2002"\n[vary]\nclearance = [1e-4]\n'
        )
    assert "vary" in {problem.key for problem in error.value.problems}


def test_a_cell_is_known_by_what_it_computes_alone():
    def keys(*more):
        return [job.key for job in first_work(loaded(CELLS, *more).record).jobs]

    whole = keys()
    assert len(set(whole)) == 6
    assert keys('name="other"', 'title="Other"', "mechanism.gap=1.0") == whole
    assert set(whole) < set(keys("vary.gap=[2.9, 2.95, 3.0, 3.05, 3.1]"))
    for more in ("analysis.turns=6", "integrator.rtol=1e-9", "mechanism.catalog='soft_impact_pair'"):
        try:
            assert not set(whole) & set(keys(more))
        except InputError:
            continue


BALL = """\
name = "ball"
kind = "section"
[mechanism]
catalog = "bouncing_ball"
acceleration = 5.0
restitution = 0.8
[analysis]
turns = 2
[vary]
acceleration = [4.0, 6.0]
"""
FALL = """\
name = "fall"
kind = "response"
[mechanism]
states = { z = "h", v = 0 }
parameters = { h = 1.0, g = 9.8 }
rates = { z = "v", v = "-g" }
impacts = [{ name = "floor", gap = "z", restitution = "0.8" }]
[analysis]
turns = 2
[vary]
g = [1, 2.0]
"""


LINKAGE = """\
name = "linkage"
kind = "section"
[mechanism]
catalog = "chunmei2002"
clearance = 1e-4
[analysis]
turns = 2
[vary]
gear_ratio = [2.0, 3.0]
"""


@pytest.mark.parametrize(("study", "same", "others"), [
    (LINKAGE, ["mechanism.gear_ratio=7.0", "vary.gear_ratio=[2, 3]"],
     ["mechanism.friction=0.2", "mechanism.clearance=2e-4"]),
    (BALL, ["mechanism.acceleration=7.0"], ["mechanism.restitution=0.7", "mechanism.catalog='impact_pair'"]),
    (FALL, ["mechanism.parameters.g=3.0", "vary.g=[1.0, 2]"],
     ["mechanism.parameters.h=2.0", "mechanism.states.v=1", "mechanism.rates.v='-2*g'"]),
])  # fmt: skip
def test_a_cell_is_known_by_its_numbers_and_its_tables(study, same, others):
    def keys(*more):
        return {job.key for job in first_work(loaded(study, *more).record).jobs}

    whole = keys()
    assert len(whole) == 2
    for more in same:
        assert keys(more) == whole
    for more in others:
        try:
            assert not whole & keys(more)
        except InputError:
            assert "catalog" in more


def test_a_point_of_a_chain_is_known_by_all_before_it():
    def keys(*more):
        return [job.keys for job in first_work(loaded(CHAINS, *more).record).jobs]

    up, down, reset = keys()
    higher = keys("vary.gap=[2.95, 3.0, 3.05, 3.1, 3.2]")
    assert higher[0][:4] == up
    assert not set(higher[1]) & set(down)
    assert set(higher[2]) > set(reset)
    lower = keys("vary.gap=[2.9, 2.95, 3.0, 3.05, 3.1]")
    assert not set(lower[0]) & set(up)
    assert lower[1][:4] == down


def test_plan_says_how_many_how_long_how_much_and_writes_nothing(tmp_path):
    lines = "\n".join(plan(loaded(CELLS), tmp_path, 4))
    assert "cells    6: 3 gap x 2 restitution" in lines
    assert "to do    6; 0 are in the journal" in lines
    assert "time     about" in lines
    assert list(tmp_path.iterdir()) == []
    text = "\n".join(plan(loaded(CHAINS), tmp_path, 8))
    assert "chains   2 of up to 4 points" in text
    assert "parallel 3 of 8 workers" in text


def test_status_follows_a_study(tmp_path, capsys):
    study, path = loaded(CELLS), tmp_path / "cells.toml"
    path.write_text(CELLS)
    assert next(iter(status(study, tmp_path))) == "cells    0 of 6 finished"
    ran(study, tmp_path)
    lines = list(status(study, tmp_path))
    assert lines[:2] == ["cells    6 of 6 finished", f"result   {tmp_path / 'cells.nc'}: done"]
    assert lines[2:] == list(jp.summary(jp.open(tmp_path / "cells.nc")).lines) != []
    words = ["status", str(path), "--out", str(tmp_path), "--set", "vary.gap=[2.9, 3.3]"]
    assert cli.main(words) == 0
    said = capsys.readouterr().out
    assert "2 of 4 finished" in said
    assert "other settings (vary)" in said
    assert "to do    2; 2" in "\n".join(plan(loaded(CELLS, "vary.gap=[2.9, 3.3]"), tmp_path, 2))


def test_a_study_of_one_analysis_has_no_cells(tmp_path):
    study = loaded(f"{HEAD}{TAIL}")
    assert (
        next(iter(plan(study, tmp_path, 2))) == "cells    none: this is one analysis, which runs in one piece"
    )
    with pytest.raises(InputError, match="vary"):
        first_work(study.record)
    assert "gap" not in run(study).dims


def test_status_counts_what_parts_have_finished(tmp_path, monkeypatch):
    study = loaded(CELLS)
    for number in (1, 2):
        complete(study, tmp_path, Pool(1), share=(number, 3))
    read = []
    index = Journal.index
    monkeypatch.setattr(Journal, "index", lambda each: read.append(each.folder) or index(each))
    lines = list(status(study, tmp_path))
    assert len(read) == len({*read}) == 3  # two parts and the whole, each once
    assert lines[0] == "cells    4 of 6 finished"
    assert "parts    2, put together by `jointplay merge`" in lines
    complete(study, tmp_path, Pool(1), share=(3, 3))
    assert next(status(study, tmp_path)) == "cells    6 of 6 finished"
    lines = list(status(loaded(CELLS, "analysis.turns=31"), tmp_path))
    assert "parts    3 without a finished cell of this study as it is now" in lines
    assert not any("merge" in line for line in lines)
