"""Studies of periodic orbits and their branches: every problem with its key path; one runs."""

from pathlib import Path

import pytest

from jointplay.study.file import load, validate
from jointplay.study.run import run
from tests.support.sweep_samples import loaded
from tests.support.wrong import problems_of

IMPACTS = {"catalog": "impact_pair", "gap": 5.0, "restitution": 0.8}
LINKAGE = {"catalog": "chunmei2002", "gear_ratio": 3.0}
BRANCH = {"kind": "continuation", "name": "n", "mechanism": IMPACTS}
ORBIT = {"kind": "periodic_orbit", "name": "n", "mechanism": LINKAGE}
PLANE = {"kind": "plane", "quantity": "y", "value": 0.0}


@pytest.mark.parametrize(
    ("study", "keys"),
    [
        (BRANCH, ["analysis.range"]),
        (BRANCH | {"analysis": {"range": [2.0, 9.0], "parameter": "gsp"}}, ["analysis.range.gsp"]),
        (BRANCH | {"analysis": {"range": [6.0, 9.0], "parameter": "gap"}}, ["analysis.start"]),
        (
            BRANCH | {"analysis": {"range": [9.0, 2.0], "parameter": "gap", "step": 2.0, "section": PLANE}},
            ["analysis.range", "analysis.step", "analysis.section"],
        ),
        (
            BRANCH | {"analysis": {"range": [2.0, 9.0], "steps": 3}},
            ["analysis.steps", "analysis.range.clearance"],
        ),
        (ORBIT | {"analysis": {"period": 0}}, ["analysis.period"]),
        (ORBIT | {"analysis": {"initial": [1.0]}}, ["analysis.initial"]),
        (ORBIT | {"analysis": {"record": ["journal_z"]}}, ["analysis.record[0]"]),
        (ORBIT | {"figure": {"kind": "continuation"}}, ["figure.kind"]),
        (ORBIT | {"figure": {"kind": "journal_orbit"}}, ["analysis.record"]),
        (
            ORBIT | {"figure": {"kind": "journal_orbit"}, "analysis": {"record": ["angle"]}},
            ["analysis.record"],
        ),
    ],
)
def test_what_does_not_fit_is_told_by_its_key(study, keys):
    assert list(problems_of(validate, study)) == keys


def test_length_in_words():
    orbit = validate(ORBIT | {"analysis": {"period": 2, "transient": 30}})
    assert "periodic_orbit, period 2, after 30 dropped turns" in orbit.summary()
    branch = validate(BRANCH | {"analysis": {"range": [2.0, 9.0], "parameter": "gap"}})
    assert "continuation, gap from 2 to 9, period 1" in branch.summary()


def test_a_cell_in_which_no_orbit_is_found_says_so():
    found = run(
        loaded(
            'kind = "periodic_orbit"\nname = "n"\n[mechanism]\ncatalog = "impact_pair"\ngap = 5.0\n'
            "restitution = 0.8\n[vary]\ngap = [5.0]\n"
            "[analysis]\nmax_iterations = 1\ntolerance = 1e-15\ntransient = 1\n"
        )
    )
    (said,) = found["trouble"].values
    assert said.startswith("no periodic orbit of 1 turn was found")
    assert "trouble" not in found.attrs


def test_a_study_runs(tmp_path: Path):
    path = tmp_path / "orbit.toml"
    path.write_text(
        'kind = "periodic_orbit"\n[mechanism]\ncatalog = "impact_pair"\ngap = 5.0\nrestitution = 0.8\n'
        "[analysis]\ntransient = 300\ninitial = [-0.5, 1.2]\n"
    )
    found = run(load(path))
    assert found.attrs["study"] == "orbit"
    assert int(found.status) == 0
    assert int(found.stable) == 1
