"""Tolerances by the public call: known functions, edges, twins of oscillators, the same bits however run."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from xarray.testing import assert_identical

import jointplay as jp
from jointplay.analysis.tolerances import tolerances as kind
from jointplay.display.errors import InputError
from tests.analysis.tolerances import twins

CRANK = jp.catalog.slider_crank(clearance=1e-4)
WINDOW = np.array([110.361e-6, 111.123e-6])
FREQUENCY, DAMPING = 2.8, 0.05
AMPLITUDE = 1 / np.hypot(1 - FREQUENCY**2, 2 * DAMPING * FREQUENCY)


def own(name, states, parameters, rates, forcing, **more):
    return jp.System(name=name, states=states, parameters=parameters, rates=rates, forcing=forcing, **more)


def function_of(text, names):
    """A system whose state after a period is a function of its parameters."""
    return own("function", {"y": 0.0}, dict.fromkeys(names, 0.1), {"y": f"{text} + sin(2*pi*t)"}, "1")


def stopped():
    parameters = {
        "damping": DAMPING,
        "force": 1.0,
        "frequency": FREQUENCY,
        "distance": 0.2,
        "restitution": 0.8,
    }
    rates = {"x": "v", "v": "force*cos(frequency*t) - 2*damping*v - x"}
    stop = {"name": "stop", "gap": "distance - x", "restitution": "restitution"}
    return own("stopped", {"x": 0.0, "v": 0.0}, parameters, rates, "2*pi/frequency", impacts=[stop])


def near_grazing(**given):
    """Shares of the stopped oscillator that hit, from its steady motion without a stop."""
    spreads = {"distance": {"normal": [0.146, 0.004]}, "restitution": {"uniform": [0.6, 0.9]}}
    start = [(1 - FREQUENCY**2) * AMPLITUDE**2, 2 * DAMPING * FREQUENCY**2 * AMPLITUDE**2]
    settings = {"limits": {"impacts": 0.0}, "shares": 0, "transient": 60, "turns": 20, "initial": start}
    return jp.tolerances(stopped(), spreads=spreads, **settings | given)


def ishigami(rows, **given):
    system = function_of("sin(a) + 7*sin(b)**2 + 0.1*c**4*sin(a)", "abc")
    spreads = {key: {"uniform": [-np.pi, np.pi]} for key in "abc"}
    settings = {"events": [], "of": ["end:state:y"], "turns": 1, "transient": 0, "n_jobs": 1}
    return jp.tolerances(system, spreads=spreads, samples=rows, shares=rows, **settings | given)


@pytest.mark.nightly
def test_ishigami():
    found = ishigami(64).isel(output=0)
    for name, truth in (("first_order", [0.3139, 0.4424, 0.0]), ("total", [0.5576, 0.4424, 0.2437])):
        assert np.all((found[f"{name}_low"] <= truth) & (truth <= found[f"{name}_high"])), name
    a, b, c = found["value"].values.T
    assert found["quantity_value"].values[:, 0] == pytest.approx(
        np.sin(a) + 7 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a), abs=1e-5
    )
    assert float(found["mean_low"].squeeze()) <= 3.5 <= float(found["mean_high"].squeeze())


@pytest.mark.nightly
@pytest.mark.parametrize("sequence", ["sobol", "random"])
def test_ishigami_to_two_digits(sequence):
    found = ishigami(1024, sequence=sequence, n_jobs=2).isel(output=0)
    for name, truth in (("first_order", [0.3139, 0.4424, 0.0]), ("total", [0.5576, 0.4424, 0.2437])):
        assert np.all((found[f"{name}_low"] <= truth) & (truth <= found[f"{name}_high"])), name
        assert found[name].values == pytest.approx(truth, abs=0.05)


@pytest.fixture(scope="module")
def crank():
    """The slider-crank about its window of lost contact, by its edge too."""
    spreads = {"clearance": {"normal": ["109 um", "1 um"]}}
    asked = {"edge": {"contact_loss": "clearance"}, "edge_runs": 32, "of": ["largest:normal_force:B"]}
    return jp.tolerances(CRANK, spreads=spreads, samples=64, shares=0, n_jobs=1, **asked)


@pytest.mark.nightly
def test_outcomes_are_those_of_the_edges(crank):
    clearance = crank["value"].values[:, 0]
    inside = (clearance > WINDOW[0]) & (clearance < WINDOW[1])
    assert np.array_equal(crank["outcome"].sel(event="contact_loss") == 1, inside)
    assert (crank["outcome"].sel(event=["doubling", "chaos"]) == 0).all()
    assert crank["edge_place"].values == pytest.approx(WINDOW, abs=0.02e-6)
    truth = np.diff(stats.norm(109e-6, 1e-6).cdf(WINDOW))[0]
    assert float(crank["edge_share_low"]) <= truth <= float(crank["edge_share_high"])
    told = jp.summary(crank)
    assert "by the edge along radial clearance at 110.36" in str(told)


@pytest.mark.nightly
def test_derivatives_say_the_deviation_where_the_force_is_smooth():
    spreads = {"clearance": {"normal": ["100 um", "1 um"]}, "links.slider.mass": {"normal": [0.14, 1e-4]}}
    asked = {"of": ["largest:normal_force:B"], "events": [], "shares": 0}
    found = jp.tolerances(CRANK, spreads=spreads, samples=64, n_jobs=1, **asked).squeeze("quantity")
    assert int(found["linear_trusted"]) == 1
    assert float(found["linear_deviation"]) == pytest.approx(float(found["deviation"]), rel=0.05)
    assert float(found["linear_share"].sum()) == pytest.approx(1)


@pytest.mark.nightly
def test_derivatives_are_not_trusted_across_an_edge():
    """Beyond the window the force grows by knocks, and no slope says how much."""
    spreads = {"clearance": {"uniform": ["100 um", "150 um"]}}
    asked = {"of": ["largest:normal_force:B"], "events": ["contact_loss"], "shares": 0}
    found = jp.tolerances(CRANK, spreads=spreads, samples=48, n_jobs=1, **asked)
    assert 0.2 < float(found["share"].squeeze()) < 0.8
    assert int(found["linear_trusted"].squeeze()) == 0
    assert "not to be trusted" in str(jp.summary(found))


@pytest.mark.long
@pytest.mark.parametrize("changed", ["workers", "blocks", "fewer"])
def test_the_same_bits_however_samples_are_run(crank, changed, monkeypatch):
    spreads = {"clearance": {"normal": ["109 um", "1 um"]}}
    given = {
        "events": ["contact_loss"],
        "shares": 0,
        "samples": 64,
        "n_jobs": 2 if changed == "workers" else 1,
    }
    if changed == "blocks":
        monkeypatch.setattr(kind, "BLOCK", 7)
        monkeypatch.setattr(kind, "STILL_OPEN", 3)
    if changed == "fewer":
        given["samples"] = 40
    found = jp.tolerances(CRANK, spreads=spreads, **given, ensemble=True)
    names = ["value", "period", "sample_status"]
    assert_identical(
        found[names].drop_attrs(), crank[names].isel(sample=slice(given["samples"])).drop_attrs()
    )
    assert np.array_equal(found["outcome"][:, 0], crank["outcome"][: given["samples"], 0])


@pytest.mark.long
def test_a_sample_that_fails_is_counted_and_named():
    """What hits takes more steps than are allowed."""
    found = near_grazing(samples=16, n_jobs=1, max_steps=1000)
    failed = found["sample_status"].values != 0
    assert failed.any()
    assert (found["value"].values[failed, 0] < AMPLITUDE).all()
    one = found.sel(event="above:impacts")
    assert float(one["share_failed"]) == failed.mean() > 0
    hits = np.mean(one["outcome"].values == 1)
    assert float(one["share"]) == pytest.approx(hits / (1 - failed.mean()))
    assert float(one["share_low"]) < hits
    assert float(one["share_high"]) > hits + failed.mean()
    assert all(text.startswith("step_limit") for text in found["trouble"].values[failed])
    assert "% failed" in str(jp.summary(found))


def test_where_all_samples_fail_nothing_is_known_and_it_is_said():
    asked = {"limits": {"impacts": 0.0}, "edge": {"impacts": "distance"}}
    told = str(jp.summary(found := near_grazing(samples=4, n_jobs=1, max_steps=10, **asked)))
    assert "unknown how many exceed 0 (contacts begun per turn); 100 % failed" in told
    assert "contacts begun per turn: no sample has a value" in told
    assert "no edge is located along distance: some motions there are undecided or failed" in told
    assert "No sample ended with a value" in {each.get_text() for each in jp.figure(found).axes[0].texts}


@pytest.mark.nightly
def test_limits_together_are_a_yield():
    system = function_of("a", "ab")
    spreads = {"a": {"uniform": [0.0, 1.0]}, "b": {"uniform": [0.0, 1.0]}}
    asked = {
        "events": [],
        "limits": {"end:state:y": 0.75, "largest:state:y": 10.0},
        "turns": 1,
        "transient": 0,
    }
    found = jp.tolerances(system, spreads=spreads, samples=256, shares=0, n_jobs=1, **asked)
    shares = dict(zip(found["event"].values, found["share"].values, strict=True))
    assert shares["above:end:state:y"] == pytest.approx(0.25, abs=0.01)
    assert shares["above:largest:state:y"] == 0
    assert shares["within_limits"] == pytest.approx(0.75, abs=0.01)
    half = found["narrowed_share"].sel(event="above:end:state:y", factor="a")
    assert float(half) == pytest.approx(0.0, abs=1e-12)


@pytest.fixture(scope="module")
def bent():
    """A limit whose edge bends over a second number."""
    system = function_of("a - 0.3*b - 0.1*b**2", "ab")
    spreads = {"a": {"normal": [0.0, 1.0]}, "b": {"normal": [0.0, 1.0]}}
    asked = {"events": [], "limits": {"end:state:y": 1.0}, "turns": 1, "transient": 0}
    more = {"edge": {"end:state:y": "a"}, "edge_runs": 64, "samples": 128, "shares": 32}
    return jp.tolerances(system, spreads=spreads, n_jobs=1, **asked | more)


@pytest.mark.nightly
def test_the_share_of_a_limit_by_its_edge(bent):
    a, b = np.random.default_rng(0).normal(size=(2, 10**6))
    truth, one = np.mean(a - 0.3 * b - 0.1 * b**2 > 1), bent.sel(event="above:end:state:y")
    assert float(bent["edge_share_low"]) <= truth <= float(bent["edge_share_high"])
    assert float(one["share_low"]) <= truth <= float(one["share_high"])
    crude = float(one["share_high"] - one["share_low"])
    assert float(bent["edge_share_high"] - bent["edge_share_low"]) < crude / 4
    across, line = bent["edge_across"].sel(factor="b"), bent["edge_line"].isel(edge=0).sel(factor="b")
    assert line.values == pytest.approx((1 + 0.3 * across + 0.1 * across**2).values, abs=0.03)


@pytest.mark.long
def test_the_picture_has_the_limit_and_the_edge(bent):
    figure = jp.figure(bent)
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"limit", "edge", "above the limit", "within the limit"} <= {*names}


def test_bad_questions_are_told_all_at_once():
    with pytest.raises(InputError) as error:
        jp.tolerances(
            CRANK, spreads={"clearance": {"normal": [1, 2, 3]}, "x.y": {"uniform": [0, 1]}}, events=["a"]
        )
    keys = {problem.key for problem in error.value.problems}
    assert {"spreads.clearance.normal", "events[0]"} <= keys


@pytest.mark.nightly
def test_shares_of_an_oscillator_near_grazing_are_those_of_its_amplitude():
    """It hits where the stop is nearer than the amplitude, from its steady motion on."""
    found = near_grazing(samples=96, n_jobs=1)
    hits = found["outcome"].sel(event="above:impacts").values
    decided = hits < 2
    assert decided.mean() > 0.9
    assert np.array_equal(hits[decided] == 1, found["value"].values[decided, 0] < AMPLITUDE)


@pytest.mark.nightly
@pytest.mark.timeout(3600)
def test_shares_near_grazing_against_a_million_direct_runs():
    found, rng = near_grazing(samples=4096), np.random.default_rng(0)
    distance, restitution = rng.normal(0.146, 0.004, 10**6), rng.uniform(0.6, 0.9, 10**6)
    hits = twins.all_impacts(distance, restitution, DAMPING, 1.0, FREQUENCY, 60, 20)
    assert (hits >= 0).all()
    truth, one = np.mean(hits > 0), found.sel(event="above:impacts")
    assert truth == pytest.approx(stats.norm(0.146, 0.004).cdf(AMPLITUDE), abs=0.002)
    assert float(one["share_low"]) <= truth <= float(one["share_high"])
    assert float(one["share_undecided"]) < 0.05
    same = twins.all_impacts(*found["value"].values.T.copy(), DAMPING, 1.0, FREQUENCY, 60, 20) > 0
    decided = one["outcome"].values < 2
    assert np.array_equal(same[decided], one["outcome"].values[decided] == 1)


def hardening(**given):
    """Duffing's oscillator about the fold of its large motion; the start varies, too."""
    rates = {"x": "v", "v": "force*cos(frequency*t) - 0.1*v - x - 0.04*x**3"}
    system = own("hardening", {"x": 0.0, "v": 0.0}, {"force": 1.0, "frequency": 1.4}, rates, "2*pi/frequency")
    spreads = {
        "force": {"normal": [1.0, 0.03]},
        "frequency": {"normal": [1.4, 0.05]},
        "initial.x": {"uniform": [-6.0, 6.0]},
        "initial.v": {"uniform": [-6.0, 6.0]},
    }
    asked = {"limits": {"largest:state:x": 3.0}, "shares": 0, "transient": 100, "turns": 20}
    return jp.tolerances(system, spreads=spreads, **asked | given)


@pytest.mark.nightly
def test_shares_of_two_motions_that_coexist_on_one_side_of_a_fold():
    """Amplitudes leave a gap about 3: the large motion, where it is, and the small one."""
    found, rng, n = hardening(samples=1024), np.random.default_rng(0), 20_000
    force, frequency = rng.normal(1.0, 0.03, n), rng.normal(1.4, 0.05, n)
    x, v = rng.uniform(-6, 6, (2, n))
    sizes = twins.all_largest(x, v, force, frequency, 0.1, 0.04, 100, 20)
    assert np.sum(np.abs(sizes - 3.0) < 0.3) < n / 500
    truth, one = np.mean(sizes > 3.0), found.sel(event="above:largest:state:x")
    assert 0.1 < truth < 0.9
    error = 3 * np.sqrt(truth * (1 - truth) / n)
    assert float(one["share_low"]) - error <= truth <= float(one["share_high"]) + error
    force, frequency, x, v = found["value"].values.T.copy()
    same = twins.all_largest(x, v, force, frequency, 0.1, 0.04, 100, 20)
    decided = (one["outcome"].values < 2) & (np.abs(same - 3.0) > 0.3)
    assert np.mean((same > 3.0)[decided] == (one["outcome"].values == 1)[decided]) > 0.999
