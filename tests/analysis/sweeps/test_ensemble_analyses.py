"""Basins, sweeps and studies with `ensemble`: same results as one by one, and refused where it cannot be."""

from __future__ import annotations

import tomllib
from types import SimpleNamespace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states.basins import basins
from jointplay.analysis.sweeps import chains
from jointplay.cli import main
from jointplay.display.errors import InputError
from jointplay.jobs.worker import Task, work
from jointplay.solver.codegen import cache
from jointplay.solver.codegen.lanes.equations import laid_out
from jointplay.solver.equations.write import system
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble, linkage
from jointplay.solver.method.codes import Status
from jointplay.solver.method.lanes import layout, memory
from jointplay.solver.motion import ensemble_runs
from jointplay.solver.motion.eligibility import IN_LANES, LEFT
from jointplay.study.file import validate
from jointplay.study.run import first_work

PLANE = {"eccentricity_ratio_x": np.linspace(-0.5, 0.5, 3), "eccentricity_ratio_y": np.linspace(-0.5, 0.5, 3)}


def test_basins_in_lanes_are_those_one_by_one():
    keywords = {"plane": PLANE, "turns": 8, "transient": 10, "patience": 1, "rtol": 1e-7, "n_jobs": 1}
    each = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0, friction=0.1)
    alone = basins(each, uncertainty=False, **keywords)
    found = basins(each, uncertainty=False, ensemble=True, **keywords)
    assert (found.followed == 1).all()
    assert not alone.followed.any(), "nine starts do not fill the lanes of two workers"
    assert found.attractor.values.tolist() == alone.attractor.values.tolist()
    assert found.period.values.tolist() == alone.period.values.tolist()
    assert np.allclose(found.section_state, alone.section_state, atol=1e-4, rtol=1e-6)


SWEEP = {"turns": 8, "transient": 6, "keep": 4, "direction": "reset", "rtol": 1e-7}


def test_a_sweep_in_lanes_is_that_one_by_one():
    each, over = catalog.chunmei2002(gear_ratio=3.0), {"clearance": np.geomspace(2e-5, 4e-5, 5)}
    how = SWEEP | {"n_jobs": 1, "exponents": 2, "lyapunov_turns": 20}
    alone = jp.bifurcation(each, over=over, **how)
    told = []
    found = jp.bifurcation(each, over=over, ensemble=True, progress=told.append, **how)
    assert told[-1] == 1.0
    assert (found.exponents_followed == IN_LANES).all()
    for name in ("lyapunov_exponent_per_turn", "section_exponent_per_turn"):
        assert np.allclose(found[name], alone[name], atol=0.1), (
            "means from a step's end on, and from a time on"
        )
    for name in ("cell_status", "period", "impacts", "separations", "mode_word"):
        assert found[name].values.tolist() == alone[name].values.tolist()
    for name in ("contact_fraction", "smallest_impact_speed", "smallest_missed_gap", "journal_x"):
        assert np.allclose(found[name], alone[name], rtol=1e-3, atol=1e-8, equal_nan=True)
    assert np.isfinite(found.smallest_impact_speed).any()


@pytest.mark.nightly
@pytest.mark.parametrize("exponents", [0, 1])
def test_what_lanes_cannot_finish_goes_on_by_itself(monkeypatch, exponents):
    def failing(name):
        loop = method(name)
        if name not in ("lanes.flow", "lanes.tangent_flow"):
            return loop

        def run(*given):
            code = loop.flow(*given)
            for jobs in given:
                if isinstance(jobs, memory.Jobs):
                    jobs.status[1] = Status.NOT_CONVERGED
            return code

        return SimpleNamespace(flow=run)

    method = cache.method
    each, over = catalog.chunmei2002(gear_ratio=3.0), {"clearance": np.geomspace(2e-5, 4e-5, 3)}
    how = SWEEP | {"n_jobs": 1} | ({"exponents": 1, "lyapunov_turns": 5} if exponents else {})
    alone, beside = (jp.bifurcation(each, over=over, **how, **more) for more in ({}, {"ensemble": True}))
    monkeypatch.setattr(cache, "method", failing)
    found = jp.bifurcation(each, over=over, ensemble=True, **how)
    assert not found.cell_status.any()
    assert found.followed.values.ravel().tolist() == [IN_LANES, LEFT, IN_LANES]
    for n, same in enumerate((beside, alone, beside)):
        assert np.array_equal(found.journal_x[n], same.journal_x[n])


@pytest.mark.long
@pytest.mark.parametrize(
    ("gear", "clearance"), [(9.835, 2.1867241478865552e-05), (18.1, 2.659147948472494e-05)]
)
def test_places_of_a_map_where_the_iteration_is_hard(gear, clearance):
    each, over = catalog.chunmei2002(gear_ratio=gear), {"clearance": [clearance]}
    how = SWEEP | {"turns": 70, "transient": 150, "exponents": 1, "lyapunov_turns": 60, "rtol": 1e-5}
    assert not jp.bifurcation(each, over=over, n_jobs=1, ensemble=True, **how).cell_status.any()


@pytest.mark.long
def test_periods_are_found_at_a_loose_tolerance():
    """What counts as one section point grows with rtol: period 1 is found at any."""
    each, over = catalog.chunmei2002(gear_ratio=18.0), {"clearance": np.geomspace(1e-4, 4e-4, 4)}
    how, tight = SWEEP | {"turns": 16, "transient": 300, "n_jobs": 1}, {"rtol": 1e-7}
    wanted = jp.bifurcation(each, over=over, **how | tight)
    assert float(wanted.period_tolerance) == 1e-4
    found = jp.bifurcation(each, over=over, **how | {"rtol": 1e-5, "ensemble": True})
    assert float(found.period_tolerance) == pytest.approx(1e-2)
    assert found.period.values.tolist() == wanted.period.values.tolist()
    assert found.period.values.max() == 1


@pytest.mark.long
def test_a_point_of_a_sweep_does_not_depend_on_the_others(monkeypatch):
    each = catalog.chunmei2002(gear_ratio=3.0)
    keywords = SWEEP | {"ensemble": True, "exponents": 2, "lyapunov_turns": 5}
    over = {"friction": [0.0, 0.1], "clearance": np.geomspace(2e-5, 3e-4, 5)}  # of two structures
    whole = jp.bifurcation(each, over=over, n_jobs=1, **keywords)
    monkeypatch.setattr(chains, "TOGETHER", 2)
    assert jp.bifurcation(each, over=over, n_jobs=2, **keywords).identical(whole)


def test_a_point_that_fails_leaves_the_others_alone():
    each = catalog.chunmei2002(gear_ratio=3.0)
    over = {"links.rocker.mass": [0.2, 0.35], "links.rocker.inertia": [1.1e-3, 1.34e-3]}
    found = jp.bifurcation(each, over=over, n_jobs=1, ensemble=True, **SWEEP)
    assert [STATUS[code] for code in found.cell_status.values.ravel()] == ["ok", "ok", "bad_parameters", "ok"]
    assert "moment of inertia" in found.trouble.values[1, 0, 0]
    few = jp.bifurcation(each, over={"clearance": [2e-5, 3e-5]}, ensemble=True, max_steps=200, **SWEEP)
    assert [STATUS[code] for code in few.cell_status.values.ravel()] == ["step_limit"] * 2


@pytest.mark.parametrize(
    ("mechanism", "plane", "rtol"),
    [
        (
            catalog.chunmei2002(clearance=0.0),
            {"crank_angle": [0.0, 1.0], "crank_speed": [1.0, 2.0]},
            1e-6,
        ),
        (catalog.chunmei2002(), {"crank_angle": [0.0, 1.0], "crank_speed": [1.0, 2.0]}, 1e-10),
    ],
)
def test_lanes_are_refused_where_they_cannot_be(mechanism, plane, rtol):
    with pytest.raises(InputError, match="ensemble"):
        basins(mechanism, plane=plane, rtol=rtol, ensemble=True)


@pytest.mark.parametrize(
    ("changes", "fit"),
    [
        *(({"clearance": {joint: 3e-5}}, True) for joint in "OABC"),
        ({"drive": None}, True),
        ({"clearance": {"B": 3e-5, "C": 3e-5}}, True),
        ({"clearance": dict.fromkeys("ABC", 3e-5)}, True),
        ({"clearance": dict.fromkeys("OABC", 3e-5)}, False),
        ({"gravity_direction": 0.3}, True),
        ({"clearance": 0}, False),
        ({"speed": 10.0}, True),
        ({"elastic": ["coupler"]}, True),
        ({"elastic": ["coupler", "rocker"]}, False),
    ],
)
def test_the_structure_says_whether_lanes_are_refused(changes, fit):
    mechanism = catalog.chunmei2002(**changes)
    assert (ensemble_runs.ensemble_fits(mechanism, True, 1e-6) == []) == fit
    assert not ensemble_runs.ensemble_fits(mechanism, False, 1e-12)
    if fit:
        (found, phases), model = laid_out(system(linkage(mechanism))), assemble(mechanism)
        turning = [1] * phases + [*model.turning]
        angles = [angle.position for angle in found.angles]
        assert all(angle.rate == 0 and angle.offset == 0 for angle in found.angles)
        assert angles == [q for q, turns in zip(found.positions, turning, strict=True) if turns]
        assert len(found.positions) == len(found.speeds) - model.memories <= layout.N
        assert len(found.contacts) == len(model.joints) <= layout.CONTACTS
        assert found.angles[0].name == model.crank
        assert not found.resets
        assert not found.powers


def test_studies_take_lanes_where_they_are_used():
    table = {
        "name": "a",
        "mechanism": {"catalog": "chunmei2002"},
        "integrator": {"ensemble": True, "rtol": 1e-6},
    }
    plane = {"plane": {"crank_angle": [0.0, 1.0], "crank_speed": [1.0, 2.0]}}
    assert validate(table | {"kind": "basins", "analysis": plane}).keywords()["ensemble"] is True
    with pytest.raises(InputError, match=r"integrator\.ensemble"):
        validate(table | {"kind": "response", "analysis": {"turns": 1}})
    over = {"kind": "bifurcation", "vary": {"clearance": [2e-5, 3e-5]}, "analysis": {"direction": "reset"}}
    assert validate(table | over).keywords()["ensemble"] is True
    assert validate(table | over | {"integrator": {"rtol": 1e-6}}).keywords().get("ensemble") is None
    with pytest.raises(InputError, match=r"integrator\.ensemble"):
        validate(table | over | {"mechanism": {"catalog": "chunmei2002", "elastic": ["coupler", "rocker"]}})
    sharp = table | {"kind": "basins", "analysis": plane, "integrator": {"ensemble": True, "rtol": 1e-10}}
    with pytest.raises(InputError, match=r"integrator\.ensemble"):
        validate(sharp)


STUDY = """
kind = "bifurcation"
name = "lanes"
[mechanism]
catalog = "chunmei2002"
gear_ratio = 3.0
[integrator]
rtol = 1e-7
ensemble = true
[vary]
clearance = [2e-5, 2.9e-5, 4e-5]
[analysis]
direction = "reset"
turns = 8
transient = 6
keep = 4
"""


def test_a_study_in_lanes_is_planned_and_run(tmp_path, capsys):
    (tmp_path / "a.toml").write_text(STUDY)
    place = [str(tmp_path / "a.toml"), "--out", str(tmp_path)]
    assert main(["plan", *place]) == 0
    assert "one cell" in capsys.readouterr().out
    assert main(["run", *place, "--jobs", "1", "--no-figure"]) == 0
    over = {"clearance": [2e-5, 2.9e-5, 4e-5]}
    alone = jp.bifurcation(catalog.chunmei2002(gear_ratio=3.0), over=over, ensemble=True, n_jobs=1, **SWEEP)
    with jp.open(tmp_path / "lanes.nc") as found:
        for name in ("journal_x", "end_state", "smallest_missed_gap", "n_steps"):
            np.testing.assert_array_equal(found[name].values, alone[name].values)


def test_what_was_computed_at_once_is_kept_at_once():
    """A task whose time is up ends between two cells; those of an ensemble are finished together."""
    record = validate(tomllib.loads(STUDY))
    jobs = first_work(record).jobs
    assert len(work(Task(jobs, None, limit=0.0)).answers) == 3
    apart = first_work(record.model_copy(update={"integrator": type(record.integrator)(rtol=1e-7)})).jobs
    assert len(work(Task(apart, None, limit=0.0)).answers) == 1
