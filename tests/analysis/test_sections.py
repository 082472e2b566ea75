"""Section points: on their section, on the motion, and the same from both analyses."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp

SIX = ["angle", "angular_velocity", "penetration", "normal_force", "tangential_velocity", "mode"]
STATE = ["angle", "angular_velocity"]
LOOSE = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)


def state_of(found, dim):
    """Angles and speeds over points."""
    return np.concatenate([found[f"{word}"].transpose(dim, "link").values for word in STATE], axis=1)


@pytest.fixture(scope="module")
def turns():
    return jp.poincare(LOOSE, jp.CrankAngle(angle=1.3), transient=2, turns=6, rtol=1e-10, record=SIX)


def test_crank_angle_points_lie_on_their_section(turns):
    angle = turns.angle.sel(link="crank").values
    assert len(angle) == 6
    assert (
        np.abs(angle - 1.3 - 2 * math.pi * np.round((angle - 1.3) / (2 * math.pi))).max()
        < 1e-12 * angle.max()
    )
    assert np.diff(angle) == pytest.approx(np.full(5, 2 * math.pi), abs=1e-11)
    assert angle[0] == pytest.approx(1.3 + 2 * 2 * math.pi, abs=1e-11)  # two turns of transient dropped


def test_they_are_points_of_the_motion(turns):
    """A run that is sampled there goes through them; sampling leaves its steps alone, sections do too."""
    found = jp.simulate(LOOSE, duration=1.0, at=turns.time.values, rtol=1e-10, record=SIX)
    w0 = LOOSE.drive.no_load_speed
    assert np.abs(state_of(found, "time") - state_of(turns, "turn")).max() < 1e-8 * w0
    assert np.array_equal(found.mode.values, turns.mode.values)


@pytest.mark.parametrize(
    "section",
    [
        jp.CrankAngle(angle=1.3),
        jp.ContactSection(joint="B"),
        jp.SeparationSection(),
        jp.Plane(quantity="angular_velocity", link="rocker", value=0.0, direction="down"),
    ],
)
def test_both_analyses_give_the_same_points(section):
    cut = jp.poincare(LOOSE, section, duration=4 * 0.075, rtol=1e-10, record=STATE)
    history = jp.simulate(LOOSE, section=section, duration=4 * 0.075, rtol=1e-10, record=STATE)
    assert len(cut.turn) >= 4
    assert cut.time.values == pytest.approx(history.section_time.values, rel=1e-12)
    for word in STATE:
        assert cut[word].values == pytest.approx(history[f"section_{word}"].values, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("section", "kind"), [(jp.ContactSection(), 0), (jp.SeparationSection(joint="B"), 1)]
)
def test_event_sections_are_the_events(section, kind):
    found = jp.simulate(LOOSE, section=section, turns=4, rtol=1e-10, record=SIX)
    events = found.event_time.values[found.event_kind.values == kind]
    assert len(events) > 5
    assert found.section_time.values == pytest.approx(events, rel=1e-15)
    assert np.abs(found.section_penetration).max() < 1e-14


def test_events_of_the_transient_are_dropped():
    pair, section = jp.catalog.impact_pair(3.0, 0.7), jp.ContactSection()
    whole = jp.poincare(pair, section, turns=9).time.values
    found = jp.poincare(pair, section, transient=4, turns=5).time.values
    assert found.tolist() == whole[whole >= 4 * math.tau].tolist()
    assert 0 < len(found) < len(whole)


@pytest.mark.parametrize(
    "section",
    [
        jp.ContactSection(),
        jp.CrankAngle(angle=1.0),
        jp.Plane(quantity="angular_velocity", link="rocker", value=0.0),
    ],
    ids=lambda section: section.kind,
)
def test_integrals_are_those_of_a_run_from_its_start(section):
    """Section points know the work since the start of the run, as samples at the same times do."""
    flows = ["energy_residual", "drive_work", "joint_work"]
    cut = jp.poincare(LOOSE, section, duration=0.3, rtol=1e-10, record=flows)
    history = jp.simulate(LOOSE, duration=0.3, at=cut.time.values, rtol=1e-10, record=flows)
    for word in flows[1:]:
        assert cut[word].values == pytest.approx(history[word].values, rel=1e-9)
    assert np.abs(cut.energy_residual).max() < 1e-9 * np.abs(cut.drive_work).max()


LONG = pytest.mark.nightly
PLANES = [
    ("angular_velocity", {"link": "rocker"}, 0.0, "down"),
    ("angular_velocity", {"link": "rocker"}, 0.0, "up"),
    ("penetration", {"joint": "B"}, -1e-5, "up"),  # passed twice in one long step of free flight
    pytest.param("penetration", {"joint": "B"}, -1e-5, "down", marks=LONG),
    pytest.param("journal_x", {}, 1e-5, "down", marks=LONG),
    pytest.param("normal_force", {}, 20.0, "up", marks=LONG),
    pytest.param("kinetic_energy", {}, 1.0, "up", marks=LONG),
]


def sole(found, quantity):
    """The rocker's, the lone joint's, or the mechanism's value of a quantity over time or turns."""
    data = found[quantity].sel(link="rocker") if "link" in found[quantity].dims else found[quantity]
    return data.values.reshape(len(data), -1)[:, 0]


def at_contact(cut, dense):
    """Points of a section that lie on an event, where a quantity may jump over the plane."""
    return np.abs(cut.time.values[:, None] - dense.event_time.values).min(axis=1) < 1e-12


@pytest.mark.parametrize(("quantity", "label", "value", "direction"), PLANES)
def test_planes(quantity, label, value, direction):
    """Points lie on their plane, all of them are found, and the quantity goes the right way there."""
    section = jp.Plane(quantity=quantity, value=value, direction=direction, **label)
    cut = jp.poincare(LOOSE, section, turns=3, rtol=1e-10, record=[quantity])
    dense = jp.simulate(LOOSE, turns=3, rtol=1e-10, record=[quantity], samples_per_turn=20_000)
    values = sole(dense, quantity)
    on_plane = np.abs(sole(cut, quantity) - value) < 1e-11 * np.abs(values).max()
    assert np.all(on_plane | ((quantity == "normal_force") & at_contact(cut, dense)))
    side = np.sign(values - value) * (1 if direction == "up" else -1)
    crossed = dense.time.values[1:][(side[:-1] <= 0) & (side[1:] > 0)]
    assert len(crossed) == len(cut.turn) >= 2
    assert np.abs(crossed - cut.time.values).max() <= 1.01 * 0.075 / 20_000


def test_a_forced_oscillator_is_cut_at_its_phase():
    found = jp.poincare(jp.catalog.duffing(), turns=5, rtol=1e-11)
    assert found.time.values == pytest.approx(2 * math.pi * np.arange(1, 6), rel=1e-13)
    motion = jp.simulate(jp.catalog.duffing(), duration=40.0, at=found.time.values, rtol=1e-11)
    assert found.state_value.values == pytest.approx(motion.state_value.values, abs=1e-8)


def test_a_free_system_is_cut_at_a_plane():
    found = jp.poincare(
        jp.catalog.lorenz(), jp.Plane(quantity="z", value=27.0, direction="down"), duration=10.0, rtol=1e-11
    )
    assert len(found.turn) > 5
    assert np.abs(found.state_value.sel(state="z") - 27.0).max() < 1e-12 * 27
    x, y, z = found.state_value.values.T
    assert np.all(x * y - 8 / 3 * z < 0)


def test_impacts_are_a_section_of_a_rigid_wall():
    pair = jp.catalog.impact_pair(gap=3.6, restitution=0.8)
    found = jp.poincare(pair, jp.ContactSection(), turns=6, initial=(-1.8, 0.5), rtol=1e-10)
    assert len(found.turn) >= 6
    assert np.abs(np.abs(found.state_value.sel(state="y")) - 1.8).max() < 1e-13
