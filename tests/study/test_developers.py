"""docs/developers.md done as it says: a kind of study and a figure, of which no file of the package knows."""

import math
import pickle
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog, cli, figures
from jointplay.kinds import KINDS, Kind
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism.own import systems
from jointplay.study.file import load, schema, validate
from tests.support.linkages import jointed
from tests.support.wrong import refused

PAGE = (Path(__file__).parents[2] / "docs" / "developers.md").read_text(encoding="utf-8")
LAW, ANALYSIS, ROW, FIGURE, ALONE = re.findall(r"^```python\n(.*?)^```", PAGE, re.S | re.M)
_, _, SYSTEM = re.findall(r"^```py\n(.*?)^```", PAGE, re.S | re.M)
(STUDY,) = re.findall(r"^```toml\n(.*?)^```", PAGE, re.S | re.M)
SWEEP = STUDY.partition("[figure]")[0] + '[vary]\namplitude = [0.2, 0.25, 0.3]\n\n[figure]\nkind = "sweep"\n'


@pytest.fixture(autouse=True)
def returns(tmp_path_factory, monkeypatch):
    """The analysis, the figure and the row, as if they lay in the package; gone after the test."""
    folder = tmp_path_factory.mktemp("modules")
    (folder / "returns_analysis.py").write_text(ANALYSIS)
    (folder / "returns_figure.py").write_text(FIGURE)
    monkeypatch.syspath_prepend(str(folder))
    before = [dict(table) for table in (figures.KINDS, figures.ABOUT)]
    row = eval(ROW.replace(".analysis.signals.returns:", "returns_analysis:"), {"Kind": Kind})
    monkeypatch.setitem(KINDS, row.name, row)
    import_module("returns_figure")
    yield import_module("returns_analysis").returns
    for name in ("returns_analysis", "returns_figure"):
        del sys.modules[name]
    for table, kept in zip((figures.KINDS, figures.ABOUT), before, strict=True):
        table.clear()
        table.update(kept)


@pytest.fixture
def law(monkeypatch):
    """The law of the page, gone after the test."""
    monkeypatch.setitem(LAWS, "quadratic", None)
    exec(compile(LAW, "developers.md", "exec"), {})
    return LAWS["quadratic"]


def test_a_law_of_contact_is_one_object(law):
    assert jp.Contact(law="quadratic", stiffness=1e12, damping=200).coefficients == {"K": 1e12, "C": 200}
    assert set(problems(jp.Contact, law="quadratic", stiffness=1e12)) == {"contact.damping"}
    u, h = 1e-5, 1e-9
    above, below = (law.force(math, u + d, 0.0, 1e12, 200.0)[1] for d in (h, -h))
    assert (above - below) / (2 * h) == pytest.approx(law.force(math, u, 0.0, 1e12, 200.0)[0], rel=1e-6)
    assert law.slopes(u, 1e12, 200.0)[0] >= 2e12 * u


@pytest.mark.parametrize("turns", [0.3, pytest.param(2, marks=pytest.mark.long)])
def test_a_law_that_was_added_moves_a_linkage(law, turns):
    plain = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    contact = jp.Contact(law="quadratic", stiffness=1e12, damping=200)
    words = ["normal_force", "penetration", "normal_velocity", "energy_residual", "drive_work"]
    found = jp.simulate(jointed(plain, contact=contact), turns=turns, rtol=1e-9, record=words)
    assert int(found.status) == 0
    assert found.sizes["event"] > 2 * turns
    touching = found.penetration.values > 1e-7
    force = 1e12 * found.penetration.values**2 + 200 * found.normal_velocity.values
    assert found.normal_force.values[touching] == pytest.approx(force[touching], rel=1e-6, abs=1e-6)
    assert float(np.abs(found.energy_residual).max()) < 1e-6 * float(np.abs(np.diff(found.drive_work)).sum())


def test_a_test_system_is_a_function(monkeypatch):
    names = dict(vars(systems))
    exec(compile(SYSTEM, "developers.md", "exec"), names)
    monkeypatch.setitem(catalog.NAMES, "van_der_pol", names["van_der_pol"])
    record = names["van_der_pol"](damping=2.0)
    assert record.parameters == {"damping": 2.0}
    assert record.initial == (2.0, 0.0)
    assert record.replace(damping=3.0) == names["van_der_pol"](damping=3.0)
    assert set(problems(record.replace, damping=-1.0)) == {"damping"}
    cycle = jp.simulate(record, duration=60.0, rtol=1e-9).state_value.sel(state="y")[-20_000:]
    assert float(abs(cycle).max()) == pytest.approx(2.0199, abs=1e-3)  # Urabe (1960), for this damping


@pytest.fixture
def study(tmp_path):
    """Path of the study file of the page."""
    path = tmp_path / "returns.toml"
    path.write_text(STUDY)
    return path


def problems(call, *values, **keywords):
    """Key and message of each problem, without the tables of a study."""
    found = refused(call, *values, **keywords)
    return {re.sub("^(analysis|integrator)[.]", "", key): expected for key, expected in found.items()}


def test_it_runs_is_drawn_and_drawn_again(study, returns, tmp_path, capsys):
    assert cli.main(["check", str(study)]) == 0
    assert "40 turns after 10 dropped turns" in capsys.readouterr().out
    assert cli.main(["run", str(study), "--out", str(tmp_path), "--set", "figure.scale=log"]) == 0
    found = jp.open(tmp_path / "returns.nc")
    same = returns(jp.catalog.duffing(amplitude=0.3), turns=40, transient=10)
    assert found["return_share"].item() == same["return_share"].item()
    assert (tmp_path / "returns.png").exists()
    (tmp_path / "returns.png").unlink()
    assert cli.main(["figure", str(tmp_path / "returns.nc")]) == 0
    assert (tmp_path / "returns.png").exists()


@pytest.mark.parametrize("jobs", ["1", pytest.param("2", marks=pytest.mark.long)])
def test_it_is_swept_and_resumed(study, tmp_path, jobs, capsys):
    study.write_text(SWEEP)
    command = ["run", str(study), "--out", str(tmp_path), "--jobs", jobs]
    assert cli.main([*command, "--set", "vary.amplitude=[0.2, 0.3]"]) == 0
    assert cli.main(command) == 0
    assert "2 of 3 cells are there already" in capsys.readouterr().out
    found = jp.open(tmp_path / "returns.nc")
    assert found.sizes["amplitude"] == 3
    assert (found["cell_status"] == 0).all()
    assert (tmp_path / "returns.png").exists()
    assert cli.main(["status", str(study), "--out", str(tmp_path)]) == 0
    assert "3 of 3 finished" in capsys.readouterr().out
    assert figures.drawing.cell_quantity.usual(found) == "return_share"


def test_its_mistakes_are_told_alike_and_all_at_once(returns):
    table = {"name": "x"} | tomllib.loads(STUDY)
    wrong = {"turns": 3, "every": 4, "near": 1.0, "initial": [0.1]}
    said = problems(validate, table | {"analysis": wrong, "integrator": {"rtol": 1.0}})
    assert set(said) == {"every", "near", "initial", "rtol"}
    assert said == problems(returns, jp.catalog.duffing(), **wrong, rtol=1.0)
    assert "no such key; did you mean 'turns'" in str(problems(validate, table | {"analysis": {"turms": 1}}))
    assert set(problems(validate, table | {"figure": {"kind": "returns", "scale": "x"}})) == {"figure.scale"}
    assert set(problems(validate, table | {"figure": {"kind": "overview"}})) == {"figure.kind"}


def test_its_record_travels(study):
    record = load(study).record
    assert pickle.loads(pickle.dumps(record)) == record  # no class by value, as it would be without its row


def test_its_schema_says_its_keywords(study):
    table = schema()["$defs"]["ReturnsAnalysis"]
    assert table["properties"]["turns"]["default"] == 100
    assert load(study).record.analysis.near == 0.1


def test_a_figure_may_suit_a_kind_that_does_not_name_it(tmp_path):
    response = {
        "name": "x",
        "kind": "response",
        "mechanism": {"catalog": "duffing"},
        "analysis": {"turns": 1},
    }
    asked = response | {"figure": {"kind": "returns"}}
    assert set(problems(validate, asked)) == {"figure.kind"}
    figures.registry.picture(of=("response",))(figures.KINDS["returns"])
    assert validate(asked).figure == {"kind": "returns"}


def test_an_analysis_on_the_solver_alone_finds_how_often_a_motion_repeats():
    close_returns = {}
    exec(compile(ALONE, "developers.md", "exec"), close_returns)
    for amplitude, repeats in ((0.2, 1), (0.29, 3)):
        mechanism = jp.catalog.duffing(amplitude=amplitude)
        apart = close_returns["close_returns"](mechanism, turns=60, transient=400)
        assert {*np.flatnonzero(apart < 1e-6) + 1} == {*range(repeats, 13, repeats)}
        section = jp.bifurcation(mechanism, over={"amplitude": [amplitude]}, turns=60, transient=400)
        assert int(section.period.squeeze()) == repeats
    assert len(ALONE.splitlines()) <= 30
    above = (
        "jointplay.analysis jointplay.study jointplay.figures jointplay.jobs jointplay.cli xarray matplotlib"
    )
    code = f"{ALONE}\nimport sys\nassert not {{*sys.modules}} & {{*{above.split()!r}}}"
    subprocess.run([sys.executable, "-c", code], check=True)
