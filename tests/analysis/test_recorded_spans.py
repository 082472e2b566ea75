"""What a time history says of its whole span: the same however the motion is sampled, and right."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis import evaluate, recorded_spans
from jointplay.display.errors import InputError
from jointplay.solver.motion.trajectory import INTERRUPTED

simulation = import_module("jointplay.analysis.simulate")  # whose name in the package is the function's
TURNS, TRANSIENT = 4, 2
WHOLE = ("recorded_time", "contacts_begun", "contact_fraction", "largest_force", "largest_normal_force")
RECORD = ["angle", "normal_force", "tangential_force", "reaction", "mode"]


@pytest.fixture(scope="module")
def linkage():
    return jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)


@pytest.fixture(scope="module")
def dense(linkage):
    """The same motion at many even samples and, apart from them, at the integrator's own points."""
    how = {"turns": TURNS, "transient": TRANSIENT, "record": RECORD}
    return jp.simulate(linkage, samples_per_turn=20_000, **how), jp.simulate(linkage, steps=True, **how)


def sampled(linkage, **how):
    return jp.simulate(linkage, turns=TURNS, transient=TRANSIENT, record=RECORD, **how)


def ways(linkage):
    period = float(dict(jp.simulate(linkage, turns=0.01, record=["angle"]))["turn_period_nominal"])
    middle = (TRANSIENT + TURNS / 2) * period
    return {
        "few": {"at": [middle, middle + 1e-6]},
        "none in the span": {"at": [0.1 * period]},
        "steps": {"steps": True},
        "coarse": {"samples_per_turn": 3},
        "usual": {},
    }


def test_whatever_is_sampled_the_same_is_said(linkage, dense):
    said = jp.summary(dense[0]).lines
    for name, how in ways(linkage).items():
        found = sampled(linkage, **how)
        assert jp.summary(found).lines == said, name
        for word in (*WHOLE, "largest_reaction"):
            np.testing.assert_array_equal(found[word], dense[0][word], err_msg=f"{name}: {word}")


@pytest.fixture
def evaluated(monkeypatch):
    """Rows whose forces have been evaluated, call by call."""
    rows, plain = [], evaluate.outputs.evaluate

    def counted(module, keys, given):
        if any(key.startswith("normal_force") for key in keys):
            rows.append(len(given[module.STATE[0]]))
        return plain(module, keys, given)

    monkeypatch.setattr(evaluate.outputs, "evaluate", counted)
    return rows


def test_of_a_long_span_the_usual_samples_serve_both(linkage, evaluated):
    """Beside the history, forces are evaluated at those own points alone that lie closer than its samples."""
    found = jp.simulate(linkage, turns=20, record=["normal_force"])
    assert len(found.time) == 20 * 720 + 1
    assert len(found.time) < sum(evaluated) < len(found.time) + int(found.n_steps) + 2 * int(found.n_events)
    few = jp.simulate(linkage, turns=20, record=["normal_force"], at=[0.1])
    np.testing.assert_array_equal(few.largest_normal_force, found.largest_normal_force)


def test_of_a_long_span_that_is_interrupted_no_largest_sizes_are_sought(linkage, evaluated, monkeypatch):
    monkeypatch.setattr(simulation, "MOST", 1000)
    plain = simulation.follow
    monkeypatch.setattr(simulation, "follow", lambda *given: replace(plain(*given), status=INTERRUPTED))
    found = jp.simulate(linkage, turns=20, record=["normal_force"], at=[0.1])
    assert jp.words(found)["status"] == "interrupted"
    assert "largest_normal_force" not in found
    assert sum(evaluated) == 1


def test_where_a_law_does_not_pull_contact_lasts_as_long_as_its_force():
    """The journal is still deeper than the bearing for another 0.3 % of the time."""
    linkage = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0, tension=False)
    record = ["normal_force", "penetration"]
    found = jp.simulate(linkage, turns=1, transient=1, samples_per_turn=10_000, record=record)
    pushes, deep = (float((found[name] > 0).mean()) for name in record)
    assert found.contact_fraction.item() == pytest.approx(pushes, abs=3e-4)
    assert deep > pushes + 1e-3


def test_contacts_are_those_of_the_list_of_events(dense):
    motion = dense[0]
    kinds = jp.words(motion)["event_kind"].values
    assert int(motion.contacts_begun) == np.count_nonzero(kinds == "contact") > 10
    turns = float(motion.recorded_time / motion.turn_period_nominal)
    assert turns == pytest.approx(TURNS, rel=1e-12)
    assert f"per nominal turn: {int(motion.contacts_begun) / TURNS:.3g}" in jp.summary(motion).lines[1]


def test_the_share_of_contact_is_that_of_the_modes_between_the_integrator_s_points(dense):
    motion = jp.words(dense[1])
    time, mode = motion.time.values, motion["mode"].values[:, 0]
    inside = ~np.isin(mode, ("free", "released"))
    begin = TRANSIENT * float(motion.turn_period_nominal)
    assert time[0] > begin  # the mode was the same before the first point in the span
    share = (np.diff(time) @ inside[:-1] + (time[0] - begin) * inside[0]) / float(motion.recorded_time)
    assert float(motion.contact_fraction[0]) == pytest.approx(share, rel=1e-12)
    assert 0.5 < share < 1.0


def test_forces_are_resultants_and_the_normal_force_has_its_own_name(dense):
    motion = dense[0]
    normal, across = (abs(motion[name].values[:, 0]) for name in ("normal_force", "tangential_force"))
    assert float(motion.largest_normal_force[0]) == pytest.approx(normal.max(), rel=3e-4)
    assert float(motion.largest_force[0]) == pytest.approx(np.hypot(normal, across).max(), rel=3e-4)
    np.testing.assert_allclose(motion.largest_reaction, motion.reaction.max("time"), rtol=2e-3)


@pytest.mark.parametrize("windows", [[[2.0, 6.0]], [[0.25, 0.75], [2, 3.5]]])
def test_of_windows_the_windows_are_spoken_of(linkage, windows):
    found = jp.simulate(linkage, windows=windows, samples_per_turn=5, record=RECORD, turns=6)
    plain = jp.simulate(linkage, turns=6, steps=True, record=RECORD)
    period, words = float(plain.turn_period_nominal), jp.words(plain)
    length = sum(b - a for a, b in windows) * period
    assert float(found.recorded_time) == pytest.approx(length, rel=1e-12)
    at = plain.event_time.values / period
    within = np.any([(a <= at) & (at <= b) for a, b in windows], 0)
    assert int(found.contacts_begun) == np.count_nonzero(within & (words.event_kind.values == "contact"))
    time, mode = plain.time.values, words["mode"].values[:, 0]
    touching = np.isin(mode, ("free", "released"), invert=True)
    inside = sum(
        np.diff(np.clip(np.append(time, 6 * period), a * period, b * period)) @ touching for a, b in windows
    )
    assert float(found.contact_fraction[0]) == pytest.approx(inside / length, rel=1e-12)
    if len(windows) == 1:
        whole = sampled(linkage)
        np.testing.assert_allclose(found.largest_force, whole.largest_force, rtol=1e-12)


def test_a_run_that_stops_early_speaks_of_what_it_reached(linkage):
    found = jp.simulate(linkage, turns=20, transient=0.5, record=RECORD, max_steps=300)
    period = float(found.turn_period_nominal)
    assert int(found.status) == 2
    assert float(found.recorded_time) < 19 * period
    assert float(found.recorded_time) + 0.5 * period >= found.event_time.max()
    assert float(found.contact_fraction[0]) <= 1.0


def test_a_test_system_has_walls_and_states():
    found = jp.simulate(jp.catalog.impact_pair(3.6, 0.8), turns=5, at=[1.0])
    kinds = jp.words(found)["event_kind"].values
    assert int(found.contacts_begun) == np.count_nonzero(kinds == "impact") > 5
    fine = jp.simulate(jp.catalog.impact_pair(3.6, 0.8), turns=5, samples_per_turn=5000)
    tops = abs(fine["state_value"]).max("time")
    np.testing.assert_allclose(found.largest_state_value, tops, rtol=1e-4)


def test_a_linkage_of_ideal_joints_has_no_contacts():
    ideal = jp.catalog.chunmei2002(clearance=0.0)
    found = jp.simulate(ideal, turns=1, at=[0.01])
    assert "contacts_begun" not in found
    assert jp.summary(found).lines[0].startswith("largest forces: ideal joints O ")
    assert "contact" not in str(jp.summary(found))


def test_without_friction_recorded_only_the_normal_force_is_told(linkage):
    found = jp.simulate(linkage, turns=1, record=["normal_force"])
    assert jp.summary(found).lines[0].startswith("largest normal forces: contact B ")
    assert "largest_force" not in found


def test_spans_too_long_to_look_through_have_no_largest_sizes():
    found = jp.simulate(jp.catalog.duffing(), turns=2800, at=[1.0], max_steps=10)
    assert not [name for name in found if str(name).startswith("largest_")]


@pytest.mark.parametrize(
    ("length", "key"), [({"duration": 0.05}, "at[2]"), ({"turns": 1, "transient": 1}, "at[2]")]
)
def test_samples_after_the_end_are_refused(linkage, length, key):
    with pytest.raises(InputError) as caught:
        jp.simulate(linkage, at=[0.0, 0.01, 9.0, 10.0], **length)
    assert [problem.key for problem in caught.value.problems] == [key]
    assert "where the run ends" in caught.value.problems[0].expected


def test_a_sample_at_the_very_end_is_kept(linkage):
    found = jp.simulate(linkage, duration=0.05, at=[0.0, 0.05], record=["angle"])
    np.testing.assert_array_equal(found.time, [0.0, 0.05])


@pytest.mark.parametrize("how", [{}, {"samples_per_turn": 100}, {"samples_per_turn": 7200}, {"steps": True}])
def test_between_samples_each_force_s_extremes_are_those_of_a_dense_record(linkage, dense, how):
    found, fine = sampled(linkage, **how), dense[0]
    first = int(how.get("steps", False))  # before the first of its own points no sample is
    edges = np.searchsorted(fine.time, found.time[first:])
    for name in ("normal_force", "tangential_force", "reaction"):
        values, size = fine[name].values, float(fine[f"largest_{name}"].max()) if "tang" not in name else 20.0
        there = np.flatnonzero(np.diff(edges))  # intervals that hold some of the dense record
        high = np.maximum.reduceat(values, edges[:-1][there], axis=0)
        low = np.minimum.reduceat(values, edges[:-1][there], axis=0)
        highest, lowest = (
            found[f"{word}_{name}"].values[first + 1 :][there] for word in ("highest", "lowest")
        )
        samples = found[name].values[first:]
        assert np.all(np.maximum(highest, samples[:-1][there]) > high - 0.02 * size)
        assert np.all(np.minimum(lowest, samples[:-1][there]) < low + 0.02 * size)
        assert np.all(found[f"highest_{name}"] >= found[name])
        assert np.all(found[f"lowest_{name}"] <= found[name])
    top = float(found.highest_normal_force.max())
    assert top == pytest.approx(float(found.largest_normal_force[0]), rel=1e-3)
    assert how.get("samples_per_turn", 720) > 720 or top == found.largest_normal_force[0]
    assert (
        found.highest_normal_force.attrs["long_name"]
        == "highest normal contact force since the sample before"
    )


@pytest.mark.long
def test_the_top_of_a_short_contact_is_met_though_a_step_passes_over_it(linkage):
    """Stiff faces: a contact lasts two or three steps, too few for a parabola through its force."""
    stiff = linkage.varied({"joints.B.contact.stiffness": 1e10, "joints.B.contact.damping": 10.0})
    turns, period = 20, float(jp.simulate(linkage, turns=0.01)["turn_period_nominal"])
    found = jp.simulate(stiff, turns=turns, record=["normal_force"], samples_per_turn=30, rtol=1e-9)
    begins = found["event_time"].values[jp.words(found)["event_kind"].values == "contact"]
    ends = found["event_time"].values[jp.words(found)["event_kind"].values == "separation"]
    ends = ends[np.searchsorted(ends, begins).clip(max=len(ends) - 1)]
    short = ends - begins < 1e-3 * period
    assert short.sum() > 100
    at = np.concatenate([np.linspace(*span, 60) for span in zip(begins[short], ends[short], strict=True)])
    at = np.unique(np.concatenate([at, np.linspace(0, turns * period, 20_000)]))
    dense = jp.simulate(
        stiff, duration=turns * period, at=at[at <= turns * period], record=["normal_force"], rtol=1e-9
    )
    most = dense["normal_force"].values.max()
    assert float(found["largest_normal_force"].max()) == pytest.approx(most, rel=2e-3)
    assert float(found["largest_normal_force"].max()) >= most * (1 - 1e-6)


def test_both_sides_of_an_event_may_be_tops_though_they_differ_by_rounding():
    """The largest may lie behind either; between two rows of one piece only the higher one is a top."""
    times = np.array([0.0, 1.0, 1.0, 2.0, 3.0, 4.0])
    sizes = np.array([3.0, 5.0, 5.0 - 1e-14, 4.0, 4.5, 4.4])
    for turned in (sizes, sizes[[0, 2, 1, 3, 4, 5]]):
        assert sorted(recorded_spans._tops(turned, times)) == [1, 2, 4]
