"""Running a study: what the analysis is asked, and what its answer carries away."""

import json

import xarray as xr

from jointplay.solver.mechanism import catalog
from jointplay.study.file import load
from jointplay.study.results import provenance
from jointplay.study.results.store import open_result, write_result
from jointplay.study.run import run


def test_the_analysis_gets_the_mechanism_and_the_keywords(study, calls):
    fractions = []
    loaded = load(study)
    run(loaded, fractions.append)
    (mechanism, keywords), = calls  # fmt: skip
    assert mechanism == catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    assert keywords == loaded.record.keywords()
    assert fractions == [0.5]


def test_an_initial_state_is_handed_over_as_plain_values(study, calls):
    run(load(study, ["analysis.initial.crank_angle=1"]))
    assert calls[0][1]["initial"] == {"crank_angle": 1.0}


def test_the_result_knows_where_it_comes_from_even_on_disk(study, calls, tmp_path):
    loaded = load(study, ["integrator.rtol=1e-7"])
    dataset = run(loaded)
    back = open_result(write_result(dataset, tmp_path / "r.nc"))
    assert (back.attrs["study"], back.attrs["title"]) == ("small", "A test")
    assert back.attrs["source"].startswith("jointplay ")
    origin = provenance.read(back)
    assert origin["study"] == json.loads(json.dumps(loaded.record.model_dump(mode="json")))
    assert origin["study"]["integrator"]["rtol"] == 1e-7
    assert origin["study_text"] == study.read_text()


def test_two_runs_are_identical(study, calls):
    xr.testing.assert_identical(run(load(study)), run(load(study)))


def test_a_dataset_without_provenance_has_none():
    assert provenance.read(xr.Dataset()) == {}
    assert provenance.read(xr.Dataset(attrs={"provenance": "no json"})) == {}
    assert provenance.read(xr.Dataset(attrs={"provenance": "[1]"})) == {}
