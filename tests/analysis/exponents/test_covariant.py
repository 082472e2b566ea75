"""Covariant vectors of motions: carried by tangent maps, of known exponents; what takes part in them."""

import math
from dataclasses import replace

import numpy as np
import pytest

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import tangents
from jointplay.analysis.exponents.covariant import TIGHT, Participation, Recorder, angles_between, frame
from jointplay.analysis.starts import state_names
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request
from tests.support.tangent_map import tangent_map

LOOSE = {"clearance": 2.9e-4, "gear_ratio": 3.0}


def carried(mechanism, found, count, points, rtol=1e-13):
    """Angles of vectors with images of those a turn before, and the ln of their growth over the turns."""
    model = assemble(mechanism)
    scale, times = tangents.scales(model), found["time"].values
    worst, grown = 0.0, []
    for at in range(points):
        V, after = (found["covariant_vector"].values[i].T[:, :count] for i in (at, at + 1))
        here = replace(model, state=found["section_state"].values[at])
        M = tangent_map(here, times[at + 1] - times[at], rtol)
        image = (M * scale / scale[:, None]) @ V
        lengths = np.linalg.norm(image, axis=0)
        worst = max(worst, angles_between(image / lengths, after).max())
        grown.append(np.log(lengths))
    return worst, np.array(grown)


@pytest.fixture(scope="module")
def pair():
    system = catalog.impact_pair(0.4, 0.8)
    run = {"turns": 41, "settling": 10, "transient": 20, "rtol": 1e-12, "initial": (0.05, 0.7)}
    return system, jp.covariant(system, **run)


def test_a_block_lasts_a_fiftieth_of_a_turn():
    model = assemble(catalog.duffing())
    first = frame(2, tangents.scales(model), model.memories)
    recorder = Recorder(tangents.Bundle(model, Request(model.period, 1e-8), first, TIGHT))
    ends = [block.time for block in recorder.blocks(model.period)]
    assert np.diff(ends)[:-1] == pytest.approx(model.period / 50)
    assert ends[-1] == pytest.approx(model.period)


def test_two_first_frames_are_compared_on_one_motion():
    """In chaos two motions of one start have parted after some sixteen turns, and their vectors with them."""
    found = jp.covariant(catalog.chunmei2002(**LOOSE), turns=2, transient=24, settling=20)
    assert float(found.lyapunov_exponent[0]) > 5
    assert found.settling_residual.values.max() < 1e-6


@pytest.mark.parametrize("transient", [40, 80, 150])
def test_frames_are_compared_on_one_side_of_an_event_at_the_end_of_the_transient(transient):
    """Hénon's map as a clock strikes: the event is due, by rounding before it or behind it."""
    jump = {"x": "1 - a*x**2 + y", "y": "b*x", "c": "0"}
    system = jp.System(
        name="striking",
        states={"x": 0.1, "y": 0.1, "c": 0.0},
        parameters={"a": 1.4, "b": 0.3},
        rates={"x": "0", "y": "0", "c": "1"},
        scales={"t": 1.0},
        jumps=[{"name": "strike", "guard": "1 - c", "jump": jump}],
    )
    found = jp.covariant(system, turns=3, transient=transient, settling=60, exponents=1)
    assert found.settling_residual.values.max() < 1e-4


@pytest.mark.nightly
def test_tangent_maps_carry_the_vectors_through_impacts(pair):
    """Over whole periods, each with impacts, by maps of another tolerance that know nothing of frames."""
    system, found = pair
    assert int(found.status) == 0
    assert int(found.n_events) > 2 * found.sizes["turn"]
    worst, grown = carried(system, found, 2, 40)
    assert worst < 1e-8
    assert found["settling_residual"].max() < 1e-9
    mean = grown.mean(axis=0) / system.period
    assert mean == pytest.approx(found["covariant_exponent"].values, abs=0.02)


@pytest.mark.long
def test_a_frame_that_has_not_come_in_is_told_of(pair):
    """Without a transient the first vectors are those of the frame's start."""
    system, settled = pair
    start = settled["section_state"].values[0].tolist()
    found = jp.covariant(system, turns=5, settling=10, transient=0, rtol=1e-12, initial=start)
    assert found["section_state"].values[0] == pytest.approx(settled["section_state"].values[1], abs=1e-9)
    V, W = found["covariant_vector"].values[0].T, settled["covariant_vector"].values[1].T
    residual = found["settling_residual"].values
    assert np.all(angles_between(V, W) <= residual + 1e-6)
    assert residual[0] > 1e-2
    assert "vectors 1 have not settled" in str(jp.summary(found))


@pytest.mark.nightly
def test_windows_leave_no_seam(pair):
    """A record kept as a whole gives the vectors that come window by window."""
    system, found = pair
    run = {"turns": 41, "transient": 20, "rtol": 1e-12, "initial": (0.05, 0.7)}
    whole = jp.covariant(system, settling=60, **run)
    assert whole["time"].values == pytest.approx(found["time"].values, abs=1e-12)
    for V, W in zip(found["covariant_vector"].values, whole["covariant_vector"].values, strict=True):
        assert angles_between(V.T, W.T).max() < 1e-8
    both = (each["covariant_exponent"].values for each in (found, whole))
    assert next(both) == pytest.approx(next(both), abs=1e-9)


@pytest.mark.long
def test_leading_vectors_are_those_of_the_spectrum(pair):
    system, found = pair
    run = {"turns": 5, "settling": 5, "transient": 20, "rtol": 1e-12, "initial": (0.05, 0.7)}
    one = jp.covariant(system, exponents=1, **run)
    assert one.sizes["vector"] == 1
    assert one.sizes["splitting"] == 0
    for V, W in zip(one["covariant_vector"].values, found["covariant_vector"].values, strict=False):
        assert angles_between(V.T, W.T[:, :1]).max() < 1e-6


def test_angles_are_those_of_the_vectors(pair):
    _, found = pair
    V = found["covariant_vector"].values
    between = angles_between(V[:, 0].T, V[:, 1].T)
    assert found["splitting_angle"].values[:, 0] == pytest.approx(between, abs=1e-9)
    assert float(found["smallest_angle"][0]) == pytest.approx(between.min(), abs=1e-9)
    assert found["share"].values == pytest.approx(V**2, abs=1e-12)
    assert list(found["part"].values) == ["y", "v"]


@pytest.mark.nightly
def test_lorenz_s_neutral_vector_is_his_motion():
    """The rate of the state; exponents as published, whose sum is the divergence."""
    found = jp.covariant(catalog.lorenz(), turns=60, settling=20)
    assert int(found["neutral_vector"]) == 2
    assert found["neutral_angle"].max() < 1e-6
    errors = found["covariant_standard_error"].values + 1e-3
    assert np.all(np.abs(found["covariant_exponent"].values - [0.9056, 0, -14.5723]) < 3 * errors)
    together = float(found["lyapunov_exponent"].sum())
    assert together == pytest.approx(-41 / 3, rel=1e-9)
    assert not any(name.endswith("per_turn") for name in found)


def test_a_run_that_fails_says_so():
    found = jp.covariant(catalog.impact_pair(0.4, 0.8), turns=50, max_steps=400, initial=(0.05, 0.7))
    assert int(found.status) == 2
    assert "covariant_exponent" not in found
    assert str(jp.summary(found)).endswith("the covariant vectors are not known")


@pytest.mark.parametrize("transient", [0, 20])
def test_where_every_direction_is_lost_nothing_is_told(transient):
    """A body that comes to rest on a rigid wall forgets where it came from."""
    run = {"turns": 10, "settling": 3, "transient": transient, "initial": (0.05, 0.7)}
    found = jp.covariant(catalog.impact_pair(0.4, 0.3), **run)
    assert (int(found.status), int(found["lost"])) == (0, 2)
    assert "covariant_exponent" not in found
    assert "2 directions lost at events" in str(jp.summary(found))


def test_of_an_ideal_linkage_all_is_the_crank_s():
    found = jp.covariant(catalog.chunmei2002(clearance=0.0), turns=2, settling=1, transient=3)
    assert int(found["status"]) == 0
    assert found["part"].values.tolist() == ["crank"]
    assert found["mean_share"].values == pytest.approx(np.ones((2, 1)))


def test_an_ideal_motion_has_no_play_in_it():
    """Turn the crank of the closed linkage a little: all of the change is the crank's, rates included."""
    model = assemble(catalog.chunmei2002(**LOOSE))
    participation, h = Participation(model), 1e-5
    assert participation.parts == ("crank", "play B")
    near = [assemble(catalog.chunmei2002(**LOOSE), {"crank_angle": 0.7 + s * h}).state for s in (1, -1)]
    here = assemble(catalog.chunmei2002(**LOOSE), {"crank_angle": 0.7}).state
    along = (near[0] - near[1]) / (2 * h) / tangents.scales(model)
    shares = participation(0.0, here, along[:, None])[:, 0]
    assert shares == pytest.approx([1.0, 0.0], abs=1e-8)


def test_a_journal_alone_is_play_and_both_add_up():
    """With the crank held, coupler and rocker move; energies by the links' own masses."""
    model = assemble(catalog.chunmei2002(**LOOSE))
    scale, rng = tangents.scales(model), np.random.default_rng(1)
    held = rng.normal(size=6) * [0, 1, 1, 0, 1, 1]
    shares = Participation(model)(0.0, model.state, np.stack([held, rng.normal(size=6)], 1))
    assert shares[:, 0] == pytest.approx([0.0, 1.0], abs=1e-12)
    assert shares.sum(axis=0) == pytest.approx([1.0, 1.0])
    assert 0 < shares[0, 1] < 1
    assert np.all(scale > 0)


@pytest.mark.long
def test_parts_of_an_elastic_linkage():
    elastic = Participation(assemble(catalog.chunmei2002(**LOOSE, elastic=["coupler"], elements=2)))
    assert elastic.parts == ("crank", "play B", "bending")
    model = elastic.model
    bent = np.zeros((len(model.state), 1))
    bent[[name.startswith("eta_") for name in state_names(model)]] = 1.0
    assert elastic(0.0, model.state, bent)[:, 0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("system", "turns", "known"),
    [
        (catalog.lorenz(), 1000, (0.9056, 0.0, -14.5723)),
        (catalog.impact_pair(0.4, 0.8), 1000, (0.23792, -0.58033)),
        (catalog.soft_impact_pair(0.4, 1e4, 14.0), 500, None),
        (catalog.chunmei2002(**LOOSE), 600, None),
    ],
)
def test_exponents_are_those_of_the_frame(system, turns, known):
    """Within three errors of each other, of `lyapunov`, and of what is known."""
    found = jp.covariant(system, turns=turns, transient=50)
    other = jp.lyapunov(system, exponents="all", turns=turns, transient=50)
    count = found.sizes["vector"]
    value, error = found["covariant_exponent"].values, found["covariant_standard_error"].values
    for name, source in (("frame", found), ("lyapunov", other)):
        apart = np.abs(value - source["lyapunov_exponent"].values[:count])
        combined = np.hypot(error, source["lyapunov_standard_error"].values[:count])
        assert np.all(apart < 3 * combined), name
    if known:
        assert np.all(np.abs(value - known) < 3 * error + 1e-4)


@pytest.mark.nightly
def test_case_c_is_carried_by_its_tangent_maps():
    """The leading three over whole turns with contacts; the others shrink by e^90, beyond a map's digits."""
    mechanism = catalog.chunmei2002(**LOOSE)
    found = jp.covariant(mechanism, turns=40, transient=50, rtol=1e-11)
    worst, _ = carried(mechanism, found, 3, 30, rtol=1e-12)
    assert worst < 1e-5
    assert found["neutral_angle"].max() < 1e-7
    assert math.isclose(float(found["mean_share"].sel(vector=1).sum()), 1.0, rel_tol=1e-12)
