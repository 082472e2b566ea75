"""Work and precision: the peers solve the same equations, errors fall, and what disagrees is told apart."""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method.modes import FREE, SLIP_NEGATIVE, SLIP_POSITIVE, STICK
from jointplay.solver.motion import trajectory as following
from jointplay.solver.motion.trajectory import Request, follow, functions
from jointplay_lab.precision import contenders, generated_code
from jointplay_lab.precision import work_precision as plans
from jointplay_lab.precision.contenders import Heyoka, Ours, Outcome, slips
from jointplay_lab.precision.generated_code import Equations, units
from jointplay_lab.precision.work_precision import AGREEMENT, Row, Truth, time_at

LINKAGE = jp.catalog.chunmei2002(gear_ratio=3.0)
PAIR = jp.catalog.impact_pair(gap=2.0, restitution=0.6)
STORED = Path(__file__).parents[1] / "reference" / "truth.json"
TRUTHS = {
    "A": {},
    "B": {"gear_ratio": 3.0},
    "C": {"gear_ratio": 3.0, "clearance": 2.9e-4},
    "B_sticking": {"gear_ratio": 3.0, "friction": 0.3},
}
PEERS = ("CVODE", "LSODA", "DOP853")
TOUCHING = {"turns": 0.1, "tolerances": (1e-5, 1e-7, 1e-9), "rounds": 0}


def words(variable) -> list[str]:
    return [variable.flag_meanings.split()[code] for code in variable.values]


def touching(mode=SLIP_NEGATIVE) -> tuple[Equations, float, np.ndarray]:
    """Equations of the linkage in a contact mode, at a state with the joint closed."""
    model = assemble(LINKAGE)
    rows = follow(model, Request(model.period, at=np.linspace(0.0, model.period, 400))).samples
    closed = rows[rows[:, -1] == SLIP_NEGATIVE][0]
    equations = Equations(model, 1e-9)
    equations._enter(np.array([mode]))
    return equations, float(closed[0]), closed[1:-1].copy()


@pytest.fixture(scope="module")
def compared():
    return jp.work_precision(LINKAGE, peers=PEERS, **TOUCHING)


@pytest.mark.nightly
@pytest.mark.parametrize("mode", [FREE, SLIP_NEGATIVE, STICK])
def test_the_jacobian_is_the_derivative_of_the_rates(mode):
    equations, t, y = touching(mode)
    n, J = len(y), np.empty((len(y), len(y)))
    equations.jacobian(t, y, J)
    size, out = 1e-9 * units(equations.model), np.empty((2, n))
    for k in range(n):
        for side, sign in enumerate((1, -1)):
            equations.rate(t, y + sign * size[k] * np.eye(n)[k], out[side])
        found = (out[0] - out[1]) / (2 * size[k])
        assert J[:, k] == pytest.approx(found, rel=1e-5, abs=1e-6 * np.abs(J).max())


@pytest.mark.nightly
def test_differences_by_lanes_are_the_jacobian():
    equations, t, y = touching()
    away = 1e-7 * equations.model.absolute
    exact, found = np.empty((2, 6, 6))
    equations.jacobian(t, y, exact)
    made = generated_code.callbacks(functions(equations.model.structure), planned=True)
    made.derivatives(equations.place, equations.b, t, y, away, found)
    assert found == pytest.approx(exact, rel=1e-5, abs=1e-6 * np.abs(exact).max())


@pytest.mark.peer
@pytest.mark.parametrize("source", ["generated", "tuned"])
@pytest.mark.parametrize("mode", [FREE, SLIP_NEGATIVE, STICK])
def test_heyoka_s_expressions_are_the_compiled_equations(mode, source):
    heyoka = pytest.importorskip("heyoka")
    from tests.benchmarks.tuned_heyoka import TunedHeyoka

    equations, t, y = touching(mode)
    if mode == SLIP_NEGATIVE:  # both slip directions share an integrator
        equations._enter(np.array([SLIP_POSITIVE]))
    peer = {"generated": Heyoka, "tuned": TunedHeyoka}[source]
    states, rates, guards = peer(equations, 1e-9, 1.0, units(equations.model), 0).expressions()
    equations._enter(np.array([mode]))
    slipping = {"pars": np.array(slips(equations.key))} if any(slips(equations.key)) else {}
    found = heyoka.cfunc([*rates, *guards], states)(y, **slipping)
    rate, guard = np.empty(6), np.empty(equations.guards)
    equations.rate(t, y, rate)
    equations.roots(t, y, guard)
    assert found[:6] == pytest.approx(rate, rel=1e-10)
    assert found[6:] == pytest.approx(guard, rel=1e-10)


@pytest.mark.peer
@pytest.mark.nightly  # its structure, with two clearances, is compiled for it alone
@pytest.mark.parametrize("modes", [(STICK, SLIP_POSITIVE), (SLIP_POSITIVE, STICK)])
def test_heyoka_s_expressions_tell_which_of_two_joints_sticks(modes):
    heyoka = pytest.importorskip("heyoka")
    model = assemble(LINKAGE.replace(clearance={"B": 2.9e-5, "C": 2.9e-5}))
    t, *y = follow(model, Request(0.3 * model.period, at=[0.3 * model.period])).samples[0, :11]
    equations, y = Equations(model, 1e-9), np.array(y)
    equations._enter(np.array(modes))
    states, rates, guards = Heyoka(equations, 1e-9, 1.0, units(model), 0).expressions()
    slipping = np.trim_zeros(np.array(slips(equations.key)), "b")
    found = heyoka.cfunc([*rates, *guards], states)(y, pars=slipping)
    rate, guard = np.empty(10), np.empty(equations.guards)
    equations.rate(t, y, rate)
    equations.roots(t, y, guard)
    assert found == pytest.approx([*rate, *guard], rel=1e-9)


@pytest.mark.peer
@pytest.mark.parametrize(("system", "turns"), [(PAIR, 2), (LINKAGE, 0.1)], ids=["walls", "contact"])
def test_heyoka_follows_the_same_motion(system, turns):
    pytest.importorskip("heyoka")
    found = jp.work_precision(system, turns=turns, peers=["heyoka"], tolerances=[1e-6, 1e-9], rounds=0)
    series = found.sel(solver="heyoka")
    assert words(series.agreement) == ["same", "same"]
    assert np.all(series.error < [1e-7, 1e-10])
    assert np.all(series.steps > 0)


@pytest.mark.long
def test_errors_fall_with_the_tolerance(compared):
    assert compared.status == 0
    assert list(compared.solver.values) == ["jointplay", *PEERS]
    assert compared.truth_events >= 3
    assert np.all(compared.events == compared.truth_events)
    for solver in compared.solver.values:
        errors = compared.error.sel(solver=solver).values
        assert np.all(errors[1:] < 0.3 * errors[:-1])
        assert words(compared.agreement.sel(solver=solver)) == 3 * ["same"]
    assert np.all(np.diff(compared.evaluations, axis=1) > 0)
    assert np.all(compared.cpu_time > 0)
    assert np.all(compared.timed_runs == 0)


@pytest.mark.nightly
def test_the_truth_is_confirmed_by_the_peer_that_comes_closest(compared):
    errors = compared.error.sel(solver=list(PEERS)).values[:, -1]
    assert compared.truth_confirmed == 1
    assert compared.truth_difference == errors.min()
    assert compared.attrs["truth_confirmed_by"] == PEERS[errors.argmin()]
    assert compared.truth_own_difference < 1e-11


@pytest.mark.long
def test_jumps_of_the_state_are_followed_too():
    found = jp.work_precision(PAIR, turns=2, tolerances=(1e-5, 1e-8), peers=("DOP853",), rounds=3)
    assert found.truth_events >= 3
    assert np.all(found.events == found.truth_events)
    assert found.truth_confirmed == 1
    assert found.truth_difference < 1e-6
    assert np.all(found.timed_runs == 3)
    assert np.all(found.cpu_time_spread >= 0)
    model = assemble(PAIR)
    ours = Ours(model, 1e-8, 2 * model.period).run()
    assert 2 * found.evaluations.sel(solver="jointplay", rtol=1e-8) == ours.evaluations


def test_our_seconds_are_those_of_the_integration():
    ours = Ours(assemble(PAIR), 1e-8, 2000 * assemble(PAIR).period)
    ours.run()  # whatever is made or loaded once
    began = time.process_time()
    seconds = ours.run().seconds
    whole = time.process_time() - began
    assert 0.0 < seconds <= whole
    assert Ours(ours.model, 1e-8, 200 * ours.model.period).run().seconds < seconds


def test_other_equations_are_told_by_the_state(monkeypatch):
    right = Equations.rate

    def wrong(self, t, y, out):
        right(self, t, y, out)
        out[3:] *= 1 + 1e-3

    monkeypatch.setattr(Equations, "rate", wrong)
    found = jp.work_precision(LINKAGE, turns=0.02, tolerances=(1e-6, 1e-11), peers=("DOP853",), rounds=0)
    assert words(found.agreement.sel(solver="jointplay")) == ["same", "same"]
    assert words(found.agreement.sel(solver="DOP853"))[1] == "other_state"
    assert found.truth_confirmed == 0
    assert found.attrs["truth_confirmed_by"] == "none"


@pytest.mark.long
def test_other_events_are_told(monkeypatch):
    right = Equations.after_event

    def wrong(self, t, y, k):
        y, (joint, kind) = right(self, t, y, k)
        return y, (joint, kind + 1)

    monkeypatch.setattr(Equations, "after_event", wrong)
    found = jp.work_precision(PAIR, turns=1, tolerances=1e-6, peers="DOP853", rounds=2)
    assert words(found.agreement[:, 0]) == ["same", "other_events"]
    assert np.isfinite(found.error).all()
    assert found.truth_confirmed == 0
    assert np.isnan(found.truth_difference)
    assert np.isnan(found.cpu_time_at_error.sel(solver="DOP853")).all()


def test_a_peer_that_fails_in_its_own_way_is_told(monkeypatch):
    monkeypatch.setattr(contenders.Peer, "_follow", lambda *_: 1 / 0)
    found = jp.work_precision(PAIR, turns=1, tolerances=1e-6, peers="DOP853", rounds=0)
    assert words(found.run_status[:, 0]) == ["ok", "crashed"]


def test_endless_events_end(monkeypatch):
    monkeypatch.setattr(contenders, "ENDLESS", (0, 1))
    found = jp.work_precision(PAIR, turns=2, tolerances=1e-5, peers="DOP853", rounds=1)
    assert words(found.run_status[:, 0]) == ["ok", "chatter"]
    assert words(found.agreement[:, 0]) == ["same", "no_end"]


def test_without_peers_nothing_confirms():
    found = jp.work_precision(PAIR, turns=1, tolerances=(1e-6,), peers=(), rounds=1)
    assert found.truth_confirmed == 0
    assert found.status == 0
    assert found.error.shape == (1, 1)


def test_what_is_not_installed_is_named(monkeypatch):
    monkeypatch.setattr(plans, "find_spec", lambda name: None if name == "heyoka" else True)
    found = jp.work_precision(PAIR, turns=1, tolerances=1e-6, peers=("heyoka", "DOP853"), rounds=0)
    assert found.attrs["not_installed"] == "heyoka"
    assert list(found.solver.values) == ["jointplay", "DOP853"]


def test_progress_is_the_share_of_runs_then_of_rounds():
    told = []
    jp.work_precision(PAIR, turns=1, tolerances=(1e-5, 1e-7), peers=(), rounds=2, progress=told.append)
    assert sorted({*told} - {0.0}) == pytest.approx([0.3, 0.6, 0.8, 1.0])


def test_what_does_not_fit_the_budget_is_not_run():
    found = jp.work_precision(LINKAGE, peers=("Radau",), budget=1e-3, **TOUCHING)
    status = words(found.run_status.sel(solver="Radau"))
    assert status[0] == "step_limit"
    assert status[2] == "not_run"
    assert np.isnan(found.error.sel(solver="Radau")).all()


def test_a_truth_that_does_not_reach_the_end_is_the_status():
    found = jp.work_precision(LINKAGE, peers=("LSODA",), max_steps=5, **TOUCHING)
    assert STATUS[int(found.status)] == "step_limit"
    assert {word for row in found.run_status for word in words(row)} == {"not_run"}
    assert {word for row in found.agreement for word in words(row)} == {"no_end"}


@pytest.mark.parametrize(("name", "changes"), TRUTHS.items())
def test_the_truth_is_the_stored_one(name, changes):
    """Of truth.json: Taylor series in 80 bits, events located."""
    stored = json.loads(STORED.read_text())[name]
    model = assemble(jp.catalog.chunmei2002(**changes))
    truth = Truth.of(model, 1e-13, model.period)
    expected = Outcome(state=np.array([*stored["angles"].values(), *stored["speeds"].values()]))
    assert truth.error(expected) < 3e-12
    assert [EVENTS[kind] for _, kind in truth.outcome.events] == [event[2] for event in stored["events"]]


def test_agreement_is_a_matter_of_events_first():
    truth = Truth(Outcome(state=np.zeros(2), events=[(0, 0)]), 0.0, np.array([1.0, 10.0]))
    near, far = np.array([0.0, 1e-3]), np.array([0.2, 0.0])
    assert truth.error(Outcome(state=near)) == pytest.approx(1e-4)
    assert truth.agreement(Outcome(state=near, events=[(0, 0)]), 1e-8) == "same"
    assert truth.agreement(Outcome(state=far, events=[(0, 0)]), 1e-8) == "other_state"
    assert truth.agreement(Outcome(state=near, events=[(1, 0)]), 1e-8) == "other_events"
    assert truth.agreement(Outcome("step_limit"), 1e-8) == AGREEMENT[3]


def test_the_time_at_an_error_lies_between_runs_log_over_log():
    runs = [(1e-2, 1.0), (1e-4, 4.0), (1e-3, 9.0), (1e-8, 16.0)]  # the third is beaten
    rows = [Row("x", 1e-5, None, error=e, agreement="same", times=[t]) for e, t in runs]
    assert time_at(rows, 1e-3) == pytest.approx(2.0)
    assert time_at(rows, 1e-6) == pytest.approx(8.0)
    assert time_at(rows, 1.0) == 1.0
    assert math.isnan(time_at(rows, 1e-9))


def test_our_runs_are_those_of_the_package():
    model = assemble(LINKAGE)
    end = 0.1 * model.period
    found, records = Ours(model, 1e-8, end).run(), follow(model, Request(end, 1e-8, at=np.array([end])))
    # two compiled loops, whose sums a processor may join in other ways
    assert found.state == pytest.approx(records.samples[0, 1:7], rel=1e-13, abs=0)
    assert found.evaluations == records.counts["n_evaluations"]
    assert len(found.events) == records.counts["n_events"]


def test_a_full_log_is_emptied_and_the_run_goes_on(monkeypatch):
    model = assemble(LINKAGE)
    whole = Ours(model, 1e-8, model.period).run()
    monkeypatch.setattr(following, "LOG_ROWS", 26)
    parts = Ours(model, 1e-8, model.period).run()
    assert parts.events == whole.events
    assert parts.state.tolist() == whole.state.tolist()


def test_everything_wrong_is_told_at_once():
    with pytest.raises(jp.InputError) as caught:
        jp.work_precision(
            LINKAGE,
            turns=-1,
            tolerances=(1e-8, 1e-5),
            peers=("LSODA", "LSODE", "LSODA"),
            rounds=-1,
            budget=0,
            rtol=1.0,
            max_steps=0,
        )
    keys = [problem.key for problem in caught.value.problems]
    names = "turns tolerances rounds budget rtol max_steps peers[1] peers[2]"
    assert keys == names.split()
    assert "did you mean 'LSODA'" in str(caught.value)
