"""One analysis with cells inside: killed, resumed, spread over workers, it is the same bit for bit."""

import inspect
import signal
from functools import partial

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog, cli
from jointplay.analysis import cells
from jointplay.analysis.states import basins, sensitivity
from jointplay.jobs import worker
from jointplay.jobs.job import CRASHED
from jointplay.jobs.journal import Journal
from jointplay.jobs.pool import Pool
from jointplay.kinds import KINDS
from jointplay.study import execute
from jointplay.study.plan import plan, status
from jointplay.study.results.store import open_result
from jointplay.study.run import count_by_keys, has_cells, run, study_hash, with_journal_keys
from tests.support.sweep_samples import PLANE, die, killed_after, loaded, same

FIELD = PLANE.replace('kind = "basins"\nname = "plane"', 'kind = "sensitivity"\nname = "field"')
FIELD = FIELD[: FIELD.index("transient")] + "turns = 3\n"
STUDIES = {"plane": PLANE, "field": FIELD}


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Six cells in place of one, each a part of its own."""
    monkeypatch.setattr(basins, "BLOCK", 5)
    monkeypatch.setattr(sensitivity, "BLOCK", 5)
    monkeypatch.setattr(worker, "BATCH", 0.0)


@pytest.fixture
def begun(monkeypatch):
    """Keys of the cells that begin in this process."""
    keys, begin = [], worker.Notes.begin

    def noted(notes, key):
        keys.append(key)
        begin(notes, key)

    monkeypatch.setattr(worker.Notes, "begin", noted)
    return keys


def kept(text, out, jobs=1, backend="loky", **options):
    out.mkdir(exist_ok=True)
    return execute.complete(loaded(text), out, Pool(jobs, backend), **options).dataset


@pytest.mark.parametrize(
    ("name", "jobs", "backend"),
    [
        ("plane", 1, "loky"),
        pytest.param("plane", 2, "loky", marks=pytest.mark.long),
        ("plane", 2, "threading"),
        ("field", 1, "loky"),
    ],
)
def test_kept_cells_give_what_the_analysis_gives(name, jobs, backend, tmp_path):
    found = kept(STUDIES[name], tmp_path, jobs, backend)
    assert same(found, run(loaded(STUDIES[name]), jobs=jobs))
    assert same(found, run(loaded(STUDIES[name]), jobs=1))
    assert same(open_result(tmp_path / f"{name}.nc"), found)
    assert len(Journal(tmp_path / f"{name}.journal").index()) == 6
    assert len(Journal(tmp_path / f"{name}.journal").parts()) == 1


@pytest.mark.parametrize("name", STUDIES)
@pytest.mark.parametrize("count", [1, 4, 6])
def test_a_killed_analysis_goes_on_where_it_was(name, count, tmp_path, begun):
    assert killed_after(count, lambda: kept(STUDIES[name], tmp_path)) == signal.SIGKILL
    done = Journal(tmp_path / f"{name}.journal").index()
    assert len(done) == count
    assert next(iter(status(loaded(STUDIES[name]), tmp_path))) == f"cells    {count} of 6 finished"
    found = kept(STUDIES[name], tmp_path)
    assert not set(begun) & done.keys()
    assert len(begun) == len(set(begun)) == 6 - count
    assert same(found, run(loaded(STUDIES[name])))


def test_a_damaged_part_costs_its_cells_only(tmp_path, monkeypatch, begun):
    monkeypatch.setattr(Journal, "compact", lambda _: None)
    first = kept(PLANE, tmp_path)
    part = Journal(tmp_path / "plane.journal").parts()[2]
    part.write_bytes(part.read_bytes()[:-7])
    begun.clear()
    said = []
    assert same(kept(PLANE, tmp_path, say=said.append), first)
    assert len(begun) == 1
    assert any(part.name in line for line in said)


def test_cells_that_are_there_already_are_told_and_no_others(tmp_path):
    said = []
    kept(PLANE, tmp_path, say=said.append)
    assert said == []
    kept(PLANE, tmp_path, say=said.append)
    assert said == ["journal  6 of 6 cells are there already"]


def test_a_block_that_crashed_runs_again(tmp_path, monkeypatch, begun):
    ends, calls = basins.ends, []

    def failing(**cell):
        calls.append(1)
        if len(calls) == 2:
            raise MemoryError("by chance")
        return ends(**cell)

    with monkeypatch.context() as patch:
        patch.setattr(basins, "ends", failing)
        hurt = kept(PLANE, tmp_path)
    assert (hurt["node_status"] == CRASHED).sum() == 5
    assert "crashed  1 (these run again)" in list(status(loaded(PLANE), tmp_path))
    begun.clear()
    assert same(kept(PLANE, tmp_path), run(loaded(PLANE)))
    assert len(begun) == 1


def test_other_settings_are_other_cells_and_fresh_drops_them(tmp_path, begun):
    kept(PLANE, tmp_path)
    other = PLANE.replace("tolerance = 1e-3", "tolerance = 1e-4")
    begun.clear()
    said = []
    kept(other, tmp_path, say=said.append)
    assert len(begun) == 6
    assert any("6 cells of other values" in line for line in said)
    begun.clear()
    kept(PLANE, tmp_path)
    assert not begun
    assert next(iter(status(loaded(PLANE), tmp_path))) == "cells    6 of 6 finished"
    kept(PLANE, tmp_path, fresh=True)
    assert len(begun) == 6
    assert len(Journal(tmp_path / "plane.journal").index()) == 6


@pytest.mark.parametrize(
    "more", ["analysis.turns=5", "integrator.rtol=1e-7", "mechanism.gap=1.5", "analysis.plane.y=[0.0, 0.1]"]
)
def test_keys_are_of_all_that_decides_an_answer(more):
    assert study_hash(loaded(PLANE).record) != study_hash(loaded(PLANE, more).record)
    assert study_hash(loaded(PLANE).record) == study_hash(loaded(PLANE, 'name="a"', 'title="b"').record)


def test_keys_say_how_many_there_are():
    record = loaded(PLANE).record
    works = [cells.first_work(partial(cells.handed_out, die, [{}] * count)) for count in (300, 20)]
    first, second = (
        [cell.key for cell in with_journal_keys(record, work, i)[0]] for i, work in enumerate(works)
    )
    assert len({*first, *second}) == 320
    assert {len(key) for key in (*first, *second)} == {32}
    assert count_by_keys(first[7:9]) == 300
    assert count_by_keys([*first[:2], second[-1]]) == 320
    assert count_by_keys([]) == 0


def test_plan_looks_at_one_cell_and_writes_nothing(tmp_path):
    lines = "\n".join(plan(loaded(PLANE), tmp_path, 2))
    assert "cells    6: 6 inside one analysis" in lines
    assert "time     about" in lines
    assert "result" not in lines
    assert not list(tmp_path.iterdir())
    assert next(iter(status(loaded(PLANE), tmp_path))) == "cells    0 finished"


def test_what_has_cells_no_cells_leaves_no_journal(tmp_path):
    text = FIELD[: FIELD.index("[analysis]")] + "[analysis]\nturns = 3\nneighbours = 2\n"
    assert not has_cells(loaded(text).record)
    assert has_cells(loaded(FIELD).record)
    kept(text, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["field.nc"]
    assert (
        next(iter(plan(loaded(text), tmp_path, 1)))
        == "cells    none: this is one analysis, which runs in one piece"
    )


def _hands_out(module):
    givers = (cells.handed_out, cells.answered, sensitivity.field)
    return any(value is giver for value in vars(module).values() for giver in givers)


def test_kinds_with_cells_inside_are_those_that_take_jobs():
    found = {kind for kind, row in KINDS.items() if _hands_out(inspect.getmodule(row.function))}
    assert found == {kind for kind, row in KINDS.items() if "n_jobs" in row.function.fields()}
    assert found >= {"basins", "bifurcation", "claims", "readings", "sensitivity"}
    assert not found & {"response", "section", "lyapunov", "periodic_orbit", "continuation"}


PAIR, LOOSE = catalog.impact_pair(3.0, 0.8), catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
GRID = {"y": np.linspace(-1, 1, 5).tolist(), "v": np.linspace(-1, 1, 5).tolist()}
REGION, FEW = {"y": (-1.6, 1.6), "v": (-3.0, 3.0)}, {"turns": 16, "transient": 20}
BRIEF = {"max_steps": 20, "transient": 1}
CALLS = {  # works that each hands out
    "bifurcation": (1, lambda **to: jp.bifurcation(PAIR, over={"gap": [3.0, 3.2]}, **FEW, **to)),
    "bifurcation, refined": (
        3,
        lambda **to: jp.bifurcation(
            PAIR, over={"gap": np.linspace(3, 3.9, 9).tolist()}, direction="reset", refine=2, **FEW, **to
        ),
    ),
    "basins": (1, lambda **to: jp.basins(PAIR, plane=GRID, **FEW, **to)),
    "basins, refined": (
        2,
        lambda **to: jp.basins(catalog.duffing(amplitude=0.0), plane=GRID, refine=1, **FEW, **to),
    ),
    "sensitivity": (1, lambda **to: jp.sensitivity(PAIR, plane=GRID, turns=1, **to)),
    "attractors": (
        4,
        lambda **to: jp.attractors(
            PAIR,
            over={"gap": [3.6, 3.65]},
            region=REGION,
            starts=8,
            bifurcations=True,
            exponents=False,
            **FEW,
            **to,
        ),
    ),
    "tipping": (3, lambda **to: jp.tipping(PAIR, region=REGION, starts=3, edge=False, **FEW, **to)),
    "tolerances": (
        2,
        lambda **to: jp.tolerances(
            PAIR,
            spreads={"restitution": {"uniform": [0.7, 0.8]}},
            limits={"largest:state:v": 3.0},
            edge={"largest:state:v": "restitution"},
            derivatives=False,
            samples=4,
            shares=2,
            **FEW,
            **to,
        ),
    ),
    "assess": (1, lambda **to: jp.assess(LOOSE, along=["clearance"], **BRIEF, **to)),
    "claims": (1, lambda **to: jp.claims(damping_ratios=(), **BRIEF, **to)),
    "readings": (1, lambda **to: jp.readings(panels=["b"], readings=["as_printed"], **BRIEF, **to)),
    "stress": (1, lambda **to: jp.stress(scenes=1, variants=("rigid",), max_steps=20, **to)),
}


@pytest.mark.long
@pytest.mark.parametrize("name", CALLS)
def test_all_cells_of_a_call_go_to_as_many_workers_as_it_asks_for(name, monkeypatch):
    asked, in_memory = [], cells.in_memory

    def noted(n_jobs, work):
        asked.append(n_jobs)
        return in_memory(1, work)

    monkeypatch.setattr(cells, "in_memory", noted)
    least, call = CALLS[name]
    call(n_jobs=3)
    assert len(asked) >= least
    assert {*asked} == {3}


def test_each_kind_with_cells_inside_is_called_so():
    assert {name.split(",")[0] for name in CALLS} == {
        kind for kind, row in KINDS.items() if "n_jobs" in row.function.fields()
    }


@pytest.mark.nightly
def test_varied_analyses_keep_theirs_to_themselves(tmp_path):
    text = PLANE + "\n[vary]\ngap = [3.0, 3.2]\n"
    found = kept(text, tmp_path, jobs=2)
    assert len(Journal(tmp_path / "plane.journal").index()) == 2
    alone = run(loaded(PLANE))
    assert np.array_equal(found["attractor"].sel(gap=3.0), alone["attractor"])


def test_parts_put_together_are_the_whole(tmp_path, capsys):
    path, words = tmp_path / "plane.toml", ["--out", str(tmp_path), "--no-figure"]
    path.write_text(PLANE)
    for share in ("1/2", "2/2"):
        assert cli.main(["merge", str(path), *words]) == 2
        assert "missing" in capsys.readouterr().err
        assert cli.main(["run", str(path), *words, "--jobs", "1", "--part", share]) == 0
        assert len(Journal(tmp_path / f"plane.part{share.replace('/', 'of')}.journal").index()) == 3
    assert cli.main(["merge", str(path), *words]) == 0
    assert same(open_result(tmp_path / "plane.nc"), run(loaded(PLANE)))


def test_parts_of_what_has_no_cells_are_refused_with_a_reason(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(FIELD[: FIELD.index("[analysis]")] + "[analysis]\nturns = 3\nneighbours = 2\n")
    for verb in (["run", str(path), "--part", "1/2"], ["merge", str(path)]):
        assert cli.main([*verb, "--out", str(tmp_path)]) == 2
        assert "[vary]" in capsys.readouterr().err


def test_ctrl_c_says_how_it_goes_on(tmp_path, monkeypatch, capsys):
    path = tmp_path / "a.toml"
    path.write_text(PLANE)
    words = ["run", str(path), "--out", str(tmp_path), "--jobs", "1"]

    def pressed(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(basins, "warm", pressed)
        assert cli.main(words) == 130
        assert "start over" in capsys.readouterr().err
    monkeypatch.setattr(worker.Notes, "begin", pressed)
    assert cli.main(words) == 130
    assert "go on" in capsys.readouterr().err


def test_who_runs_the_cells_of_an_analysis_does_not_run_the_cells_of_its_cells():
    seen = []

    def outer():
        first = cells.handed_out(inner, [{"n": 2}, {"n": 3}])
        return first + cells.handed_out(inner, [{"n": 1}], before=2)

    def runner(work):
        seen.append(len(work.jobs))
        return cells.in_memory(1, work)

    found = cells.driven(outer, runner)
    assert seen == [2, 1]
    assert [len(each["found"]) for each in found] == [2, 3, 1]
    assert cells.handed_out(leaf, [{"n": 1}], n_jobs=1) == [{"status": 0, "n": 1}]
    assert seen == [2, 1]


def test_an_error_ends_the_analysis_and_its_driving():
    def pressed(*_):
        raise KeyboardInterrupt

    ask = partial(cells.handed_out, leaf, [{"n": 1}])
    for call, driver in ((ask, pressed), (pressed, lambda _: pytest.fail("nobody drives any more"))):
        with pytest.raises(KeyboardInterrupt):
            cells.driven(call, driver)
        assert ask(n_jobs=1) == [{"status": 0, "n": 1}]


def test_the_first_work_of_an_analysis_is_told_and_none_of_it_run():
    ended = []

    def outer():
        try:
            return cells.handed_out(die, [{}] * 3)
        finally:
            ended.append(1)

    work = cells.first_work(outer)
    assert len(work.jobs) == 3
    assert ended == [1]
    assert cells.first_work(lambda: leaf(1)) is None


def inner(n):
    return {"status": 0, "found": cells.handed_out(leaf, [{"n": n}] * n, n_jobs=1)}


def leaf(n):
    return {"status": 0, "n": n}
