"""Sections of the test systems: planes, phases and impacts, each point where it belongs and none twice."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jointplay as jp
from jointplay import catalog
from tests.support.wrong import problems_of

from .exact_maps import TAU, Symmetric
from .test_known_smooth import rossler


@pytest.mark.parametrize(
    ("quantity", "value", "direction"), [("x", 0.0, "up"), ("x", 0.0, "down"), ("y", 1.5, "up")]
)
def test_plane_section(quantity, value, direction):
    plane = jp.Plane(quantity=quantity, value=value, direction=direction)
    found = jp.poincare(catalog.rossler(), plane, duration=40.0, rtol=1e-12)

    def passes(t, s):
        return s["xyz".index(quantity)] - value

    passes.direction = {"up": 1, "down": -1}[direction]
    truth = solve_ivp(rossler, (0, 40), (1.0, 1.0, 0.0), "DOP853", rtol=1e-13, atol=1e-14, events=passes)
    assert found.time.values == pytest.approx(truth.t_events[0], abs=1e-9)
    assert found.state_value.values == pytest.approx(truth.y_events[0], abs=1e-9)


def test_section_by_phase():
    found = jp.poincare(catalog.duffing(frequency=1.3), jp.CrankAngle(angle=1.0), turns=10, transient=3)
    assert found.time.values == pytest.approx((1.0 + math.tau * np.arange(3, 13)) / 1.3, abs=1e-10)
    history = jp.simulate(catalog.duffing(frequency=1.3), duration=70.0, at=found.time.values)
    assert found.state_value.values == pytest.approx(history.state_value.values, abs=1e-7)


def test_section_inside_a_response():
    found = jp.simulate(
        catalog.duffing(), turns=5, section=jp.Plane(quantity="y", value=1.0, direction="down")
    )
    assert found.sizes["turn"] > 2
    assert found.section_state_value.sel(state="y").values == pytest.approx(1.0, abs=1e-12)
    assert (found.section_state_value.sel(state="v").values < 0).all()


@pytest.mark.parametrize(
    ("section", "key"),
    [
        (jp.Plane(quantity="w", value=0.0), "section.quantity"),
        (jp.CrankAngle(), "section.kind"),
        (jp.ContactSection(), "section.joint"),
    ],
)
def test_section_that_does_not_exist(section, key):
    assert list(problems_of(jp.poincare, catalog.lorenz(), section, duration=5.0)) == [key]


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-11])
def test_plane_on_a_wall(rtol):
    """A plane where contact begins: passed once for each contact, at its time."""
    plane = jp.Plane(quantity="y", value=0.2)
    found = jp.simulate(
        catalog.soft_impact_pair(0.4, 400.0, 4.0), turns=20, initial=(0.05, 0.7), rtol=rtol, section=plane
    )
    begins = (found.event_kind == 0) & (found.event_joint == 0)
    assert found.section_time.values == pytest.approx(found.event_time.values[begins], abs=1e-12)


@pytest.mark.parametrize("direction", ["up", "down"])
@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-11])
def test_plane_passed_smoothly_and_by_jumps(direction, rtol):
    """The speed of the rattling mass turns between impacts and at them; both pass the plane, once each."""
    plane = jp.Plane(quantity="v", value=0.0, direction=direction)
    found = jp.simulate(
        catalog.impact_pair(1.4, 0.8),
        turns=10,
        initial=(0.05, 0.7),
        rtol=rtol,
        section=plane,
        samples_per_turn=2000,
    )
    signs = np.diff(np.sign(found.state_value.sel(state="v").values))
    assert found.sizes["turn"] == (signs > 0 if direction == "up" else signs < 0).sum()
    assert (np.diff(found.section_time.values) > 1e-3).all()


@pytest.mark.parametrize("offset", [0.0, 1e-15, 1e-12, -1e-12, 1e-9])
def test_phase_of_an_impact(offset):
    """Impact and section at one time: neither is lost."""
    exact = Symmetric(3.6, 0.8)
    section = jp.CrankAngle(angle=exact.t0 + offset)
    found = jp.simulate(catalog.impact_pair(3.6, 0.8), turns=10, initial=exact.at_zero, section=section)
    assert found.sizes["event"] == 20
    assert found.section_time.values == pytest.approx(exact.t0 + offset + TAU * np.arange(1, 11), abs=1e-11)


def test_forcing_that_runs_backwards():
    parameters = catalog.duffing().parameters | {"frequency": -1.0}
    back = jp.TestSystem(**dict(catalog.duffing()) | {"parameters": parameters})
    one, two = (jp.poincare(system, turns=5, rtol=1e-12) for system in (catalog.duffing(), back))
    assert two.time.values == pytest.approx(TAU * np.arange(1, 6), abs=1e-10)
    assert two.state_value.values == pytest.approx(one.state_value.values, abs=1e-9)


def test_separation_of_a_flank():
    gear = catalog.gear_backlash(0.1, 0.2, 1.6, 0.05)
    found = jp.poincare(gear, jp.SeparationSection(joint="drive"), turns=50)
    state = found.state_value
    assert found.sizes["turn"] > 20
    assert state.sel(state="y").values == pytest.approx(1.0, abs=1e-12)
    assert (state.sel(state="v") < 0).all()
    with pytest.raises(jp.InputError, match="did you mean 'drive'"):
        jp.poincare(gear, jp.SeparationSection(joint="drivee"), turns=5)
