"""Bifurcation diagrams: where points start, what is told of each, what happens to one that fails."""

import math

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.starts import Journals, end_of, placed
from jointplay.analysis.sweeps import chains
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.records import ContactSection, CrankAngle
from tests.support.wrong import refused

PAIR = catalog.impact_pair(3.0, 0.8)
LINKAGE = catalog.chunmei2002(clearance=2.9e-5, gear_ratio=3.0)
SHORT = {"turns": 12, "transient": 40, "n_jobs": 1}
STEP_LIMIT, BAD = 2, 5


def keys(mechanism, **keywords):
    """Keys of what is refused."""
    return refused(jp.bifurcation, mechanism, **keywords)


def test_integrals_over_time_are_refused():
    """A diagram keeps points of attractors, of which the way there is no part."""
    refused = keys(LINKAGE, over={"clearance": [3e-5]}, record=["angle", "energy_residual"])
    assert list(refused) == ["record[1]"]
    assert "integral" in refused["record[1]"]


@pytest.fixture(scope="module")
def linkage():
    """A small sweep of the linkage, up and down."""
    clearances = [4e-5, 2e-5, 2.9e-5]
    return jp.bifurcation(LINKAGE, over={"clearance": clearances}, direction=("up", "down"), **SHORT)


def test_the_linkage_agrees_with_its_sections_and_its_time_history(linkage):
    alone = jp.bifurcation(LINKAGE, over={"clearance": [2.9e-5]}, direction="reset", **SHORT)
    alone = alone.isel(clearance=0, direction=0)
    points = jp.poincare(LINKAGE, turns=12, transient=40, rtol=1e-7)
    for name in ("journal_x", "normal_velocity", "angular_velocity"):
        size = np.abs(points[name].values).max()
        assert alone[name].values == pytest.approx(points[name].values, abs=1e-4 * size)
    history = jp.simulate(LINKAGE, turns=12, transient=40, samples_per_turn=4000, rtol=1e-10)
    kinds = history.event_kind.values
    assert alone.impacts.item() == pytest.approx(np.sum(kinds == 0) / 12)
    assert alone.separations.item() == pytest.approx(np.sum(kinds == 1) / 12)
    assert np.sum(kinds == 0) > 0
    contact = np.mean(history["mode"].values > 1)
    assert alone.contact_fraction.item() == pytest.approx(contact, abs=1e-3)
    smallest = history.event_normal_velocity.values[kinds == 0].min()
    assert alone.smallest_impact_speed.item() == pytest.approx(smallest, rel=1e-3)
    assert alone.period.item() == 1
    assert alone.turn_period.item() == pytest.approx(np.diff(points.time.values).mean(), rel=1e-9)
    word = alone.mode_word.item()
    assert word.count("f") == alone.separations.item()
    assert word[0] == word[-1]  # periodic


def test_axes_rise_and_are_named(linkage):
    assert linkage.clearance.values.tolist() == [2e-5, 2.9e-5, 4e-5]
    assert linkage.clearance.attrs["units"] == "m"
    assert linkage.clearance.attrs["long_name"] == "radial clearance"
    assert linkage.journal_x.dims == ("clearance", "direction", "point", "joint")
    assert linkage.angular_velocity.dims == ("clearance", "direction", "point", "link")
    assert linkage.sizes["point"] == 12  # no more than there are turns
    for name, variable in linkage.variables.items():
        assert "long_name" in variable.attrs, name
        assert "units" in variable.attrs or variable.dtype.kind == "U", name


@pytest.mark.parametrize("way", ["up", "down"])
def test_a_point_starts_where_its_neighbour_ends(linkage, way):
    first, second = (0, 1) if way == "up" else (2, 1)
    begin = linkage.end_state.sel(direction=way).values[first]
    over = {"clearance": [linkage.clearance.values[second]]}
    again = jp.bifurcation(LINKAGE, over=over, direction="reset", initial=begin, **SHORT)
    expected = linkage.sel(direction=way).isel(clearance=second)
    xr.testing.assert_equal(
        again.isel(clearance=0, direction=0).drop_vars("direction"), expected.drop_vars("direction")
    )


def test_the_end_lies_on_the_section_to_the_last_bit(linkage):
    assert (linkage.end_state.sel(state="theta_crank") == 0.0).all()
    section = CrankAngle(angle=4.0)
    angles, speeds, _ = ideal_state(LINKAGE, 4.0)
    begin = [*angles.values(), *speeds.values()]
    assert placed(LINKAGE, begin, section).crank_angle == 4.0
    found = jp.bifurcation(LINKAGE, over={"clearance": [2e-5, 2.9e-5]}, section=section, **SHORT)
    assert (found.end_state.sel(state="theta_crank") == 4.0).all()
    assert (np.abs(found.end_state.sel(state=["theta_coupler", "theta_rocker"])) < math.pi).all()
    assert found.impacts.values == pytest.approx(linkage.impacts.sel(direction=["up"])[:2].values, abs=0.1)


def test_the_tolerance_of_a_period_is_a_fraction_of_the_clearance():
    over = {"clearance": [2.9e-5, 2.9e-4]}
    found = jp.bifurcation(LINKAGE, over=over, direction="reset", **SHORT)
    assert found.period.values.ravel().tolist() == [1, 0]
    tight = jp.bifurcation(LINKAGE, over=over, direction="reset", tolerance=0.05, **SHORT)
    assert tight.period.values.ravel().tolist() == [1, 0]
    loose = jp.bifurcation(LINKAGE, over=over, direction="reset", tolerance=2.5, **SHORT)
    assert loose.period.values.ravel().tolist() == [1, 1]  # no journal is farther from another


def test_the_first_point_starts_from_the_given_start():
    both = jp.bifurcation(
        PAIR, over={"gap": [2.95, 3.05]}, direction=("up", "down", "reset"), initial=[0.1, 1.0], **SHORT
    )
    for way, place in (("up", 0), ("down", 1)):
        one, other = (both.sel(direction=w).isel(gap=place).end_state.values for w in (way, "reset"))
        assert one.tolist() == other.tolist()
    ends = both.end_state.transpose("direction", "gap", "state").values
    assert ends[0, 1].tolist() != ends[2, 1].tolist()


def test_the_last_section_points_are_kept_and_the_end_is_the_last_of_them():
    over = {"gap": [0.4, 3.0]}
    whole, kept = (jp.bifurcation(PAIR, over=over, keep=keep, **SHORT) for keep in (100, 3))
    assert (whole.sizes["point"], kept.sizes["point"]) == (12, 3)
    assert kept.state_value.values.tolist() == whole.state_value.values[:, :, -3:].tolist()
    assert kept.end_state.values.tolist() == kept.state_value.values[:, :, -1].tolist()
    assert kept.period.values.tolist() == whole.period.values.tolist()


@pytest.mark.nightly
def test_one_worker_or_two_and_blocks_of_any_size(monkeypatch):
    grid = {"restitution": [0.75, 0.8], "gap": np.linspace(0.4, 0.7, 10)}
    options = {
        "over": grid,
        "direction": ("up", "reset"),
        "starts": [[0.0, 1.0], [0.1, -0.5]],
        "exponents": 1,
    }
    options |= {"turns": 8, "transient": 4, "lyapunov_turns": 5}
    one, two = (jp.bifurcation(PAIR, **options, n_jobs=n) for n in (1, 2))
    assert one.identical(two)
    assert one.lyapunov_exponent.dims == ("restitution", "gap", "direction", "start", "exponent")
    monkeypatch.setattr(chains, "BLOCK", 3)
    assert one.identical(jp.bifurcation(PAIR, **options, n_jobs=1))


def test_a_point_that_fails_has_no_values_and_the_next_starts_from_the_last_good_end(monkeypatch):
    seen, settle = [], chains.settle

    def failing(mechanism, start, plan):
        seen.append(start)
        if mechanism.parameters["gap"] == 3.0:
            raise ZeroDivisionError("by chance")
        return settle(mechanism, start, plan)

    monkeypatch.setattr(chains, "settle", failing)
    found = jp.bifurcation(PAIR, over={"gap": [2.95, 3.0, 3.05]}, **SHORT).isel(direction=0)
    assert seen[2].state.tolist() == seen[1].state.tolist()
    assert seen[2].state.tolist() == found.end_state.values[0].tolist()
    assert found.cell_status.values.tolist() == [0, 6, 0]
    assert int(found.status) == 6
    assert found.trouble.values[1] == "ZeroDivisionError: by chance"
    lost = found.isel(gap=1)
    for name in ("state_value", "impacts", "smallest_impact_speed", "end_state"):
        assert np.isnan(lost[name]).all()
        assert np.isfinite(found[name].isel(gap=[0, 2])).all()
    assert lost.period == -1
    assert lost.mode_word == ""


def test_rest_is_no_trouble_a_limit_on_steps_is_told_and_the_sweep_lives():
    pair = catalog.impact_pair(3.0, 0.8)
    found = jp.bifurcation(pair, over={"restitution": [0.8, 0.0]}, initial=[0.0, 1.3], **SHORT)
    assert found.cell_status.values[:, 0].tolist() == [0, 0]
    assert found.period.values[:, 0].tolist() == [1, 1]
    assert (found.n_steps > 0).all()
    later = jp.bifurcation(
        pair, over={"gap": [3.0]}, max_steps=1000, **SHORT, exponents=1, lyapunov_turns=900
    )
    assert later.cell_status.item() == STEP_LIMIT
    assert later.trouble.item() == "step_limit while exponents were measured"
    assert np.isfinite(later.impacts.item())
    assert "lyapunov_exponent" not in later


def test_values_that_do_not_go_together_are_told_where_they_meet():
    """A mass is possible, an inertia is possible; both together are not."""
    over = {"links.rocker.mass": [0.2, 0.35], "links.rocker.inertia": [1.1e-3, 1.34e-3]}
    found = jp.bifurcation(LINKAGE, over=over, direction="reset", turns=2, transient=0, n_jobs=1)
    assert found.cell_status.values[..., 0].tolist() == [[0, 0], [BAD, 0]]
    assert "moment of inertia" in found.trouble.values[1, 0, 0]
    assert found.inertia.attrs == {
        "units": "kg m2",
        "long_name": "moment of inertia of the rocker about the link's origin",
        "key": "links.rocker.inertia",
    }


def test_a_wall_that_moves_in_takes_the_mass_along():
    found = jp.bifurcation(PAIR, over={"gap": [0.5, 4.0]}, direction="down", initial=[1.9, 0.0], **SHORT)
    assert found.cell_status.values.ravel().tolist() == [0, 0]
    assert np.abs(found.state_value.values[0, ..., 0]).max() <= 0.25 + 1e-9


LENGTHS = {
    "four-bar": (LINKAGE, "coupler", "B"),
    "crank": (catalog.slider_crank(clearance={"B": 1e-4}), "crank", "A"),
    "guide": pytest.param(catalog.slider_crank(clearance={"G": 1e-4}), "rod", "B", marks=pytest.mark.long),
    "two": (catalog.chunmei2002(clearance={"A": 2e-5, "B": 2.9e-5}), "coupler", "B"),
}


@pytest.mark.parametrize(("mechanism", "name", "joint"), LENGTHS.values(), ids=LENGTHS)
def test_journals_stay_where_they_were_between_links_of_another_length(mechanism, name, joint):
    """Links turn so that no journal is thrown out of its bearing, and none gets another speed in it."""
    length = mechanism.link(name).length
    longer = mechanism.varied({f"links.{name}.length + joints.{joint}.journal.at": 1.01 * length})
    old = placed(mechanism, jp.simulate(mechanism, turns=1.9, rtol=1e-9).end_state.values)
    end = end_of(old, old.state)
    new, rows = placed(longer, end), (old.state[None, :], old.state[None, :])
    assert not np.array_equal(new.state, old.state)
    assert np.abs(Journals(new).positions(rows[0]) - end.journals[0]).max() > 2 * max(old.clearances)
    kept = Journals(new).positions(new.state[None, :]), Journals(new).velocities(new.state[None, :])
    for there, before, size in zip(kept, end.journals, (1e-4 * min(old.clearances), 1e-7), strict=True):
        assert there[0] == pytest.approx(before, abs=size)
    narrower = mechanism.replace(
        clearance={each.name: 0.9 * each.clearance for each in mechanism.clearance_joints}
    )
    assert np.array_equal(placed(narrower, end).state, old.state)  # the same links at the same angles


def test_a_motion_carried_to_another_length_is_not_kicked():
    slow, key = (
        catalog.chunmei2002(clearance=2.9e-4, gear_ratio=15.0),
        "links.coupler.length + joints.B.journal.at",
    )
    old = placed(slow, jp.simulate(slow, turns=2, transient=60).end_state.values)
    longer = slow.varied({key: 1.005 * slow.link("coupler").length})
    forces = [
        jp.simulate(each, initial=start.state, turns=1, record=["normal_force"])[
            "largest_normal_force"
        ].item()
        for each, start in ((slow, old), (longer, placed(longer, end_of(old, old.state))))
    ]
    assert forces[1] == pytest.approx(forces[0], rel=0.05)


@pytest.mark.parametrize("angle", [0.0, 1.0, 2 * math.pi, 4.0])
def test_another_phase_of_the_section(angle):
    found = jp.bifurcation(PAIR, over={"gap": [2.95, 3.0]}, section=CrankAngle(angle=angle), **SHORT)
    expected = jp.poincare(PAIR.replace(gap=2.95), CrankAngle(angle=angle), turns=12, transient=40, rtol=1e-7)
    assert found.state_value.values[0, 0] == pytest.approx(expected.state_value.values[-12:], abs=1e-6)
    assert found.period.values.ravel().tolist() == [1, 1]
    whole = jp.bifurcation(PAIR, over={"gap": [2.95, 3.0]}, **SHORT)  # the phase goes on, point to point
    if angle in (1.0, 4.0):
        assert found.end_state.values == pytest.approx(whole.end_state.values, abs=1e-9)
    assert found.impacts.values == pytest.approx(whole.impacts.values)


def test_section_at_contacts_counts_points_and_not_turns():
    found = jp.bifurcation(
        PAIR, over={"gap": [2.95, 3.0]}, section=ContactSection(), turns=12, transient=300, n_jobs=1, keep=50
    )
    assert found.period.values.ravel().tolist() == [2, 2]
    assert found.impacts.values.ravel().tolist() == [2, 2]
    walls = np.abs(found.state_value.sel(state="y")).isel(point=slice(0, 12), direction=0)
    assert walls.values == pytest.approx(np.outer([2.95 / 2, 1.5], np.ones(12)))


def test_everything_wrong_is_told_at_once():
    found = keys(
        PAIR,
        over={"gap": [1.0, -1.0, math.nan, 1.0], "gapp": [1.0], "restitution": []},
        turns=0.5,
        keep=0,
        exponents=-1,
        tolerance=0,
        direction=("up", "upward", "up"),
    )
    assert set(found) == {
        *("over.gap[1]", "over.gap[2]", "over.gap[3]", "over.gapp", "over.restitution"),
        *("turns", "keep", "exponents", "tolerance", "direction[1]", "direction[2]"),
    }
    assert "did you mean 'gap'?" in found["over.gapp"]
    one = {"over": {"gap": [3.0]}}
    assert set(keys(PAIR, **one, starts=[[0.0], [0.0, 0.0], [0.0, 9.0, 1.0]], record=["angle"])) == {
        *("starts[0]", "starts[2]", "record[0]")
    }
    assert set(keys(PAIR, **one, starts=[], initial=[0.0, 0.0])) == {"starts", "initial"}
    assert set(keys(LINKAGE, over={"clearance": [1e-5]}, initial=[1.0, 2.0])) == {"initial"}
    assert set(keys(PAIR, over=[1.0])) == {"over"}
    assert set(
        keys(
            catalog.gear_backlash(0.1, 0.2, 0.8, 0.05),
            over={key: [0.1] for key in ("mean_load", "damping", "frequency")},
        )
    ) == {"over"}
    assert set(keys(catalog.lorenz(), over={"rho": [28.0]})) == {"section.kind"}
    assert set(keys("pair", **one)) == {"mechanism"}
