"""Contacts of a motion: counts, fractions, closest calls and words, on records written by hand."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import beta

import jointplay as jp
from jointplay import catalog
from jointplay.analysis import contacts
from jointplay.solver.mechanism.assemble import assemble

ENTRY, EXIT, SLIP, HIT = 0, 1, 3, 6
PAIR = assemble(catalog.impact_pair(3.0, 0.8), None, "phase")
SOFT = assemble(catalog.soft_impact_pair(3.0, 100.0, 1.0), None)
LINKAGE = assemble(catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0), None, "angle:crank")


def events(*rows):
    """Rows of events: contact, kind, time."""
    return np.array(rows, dtype=float).reshape(-1, 3)


def bent(drag, **more):
    """A driven oscillator with quadratic drag, written with a kink or without."""
    rates = {"x": "v", "v": f"F*cos(w*t)-.3*x-c*v*{drag}"}
    numbers = {"F": 1.2, "w": 0.7, "c": 0.5}
    states = {"x": 0.0, "v": 1.0}
    return jp.System(name="bent", states=states, parameters=numbers, rates=rates, forcing="2*pi/w", **more)


def test_kinks_and_switches_are_no_contacts():
    stop = {"impacts": [{"name": "stop", "gap": "1.2-x", "restitution": 0.7}]}
    settings = {"over": {"F": [1.2]}, "turns": 20, "transient": 40, "n_jobs": 1}
    for more in ({}, stop):
        kinked, smooth = (
            (jp.bifurcation(made, **settings), jp.simulate(made, turns=4, transient=10))
            for made in (bent("abs(v)", **more), bent("sqrt(v*v+1e-18)", **more))
        )
        for found, like in zip(kinked, smooth, strict=True):
            names = ("impacts", "separations", "contact_fraction", "smallest_impact_speed", "contacts_begun")
            assert [name in found for name in names] == [name in like for name in names]
            for name in (name for name in names if name in like):
                np.testing.assert_allclose(found[name].values, like[name].values, rtol=1e-6)
        assert ("contacts begun" in str(jp.summary(kinked[1]))) == bool(more)
        assert ("impacts" in kinked[0]) == bool(more)


@pytest.mark.parametrize("power", ["depth**1.5", "depth*sqrt(depth)", "depth**n", "max(depth,0)**1.5"])
def test_an_own_contact_of_hertz_lasts_as_long_as_it_must(power):
    """A mass m that meets F = k u^1.5 at v is thrown back as fast, after 4/5 B(2/5, 1/2) u_max / v."""
    system = jp.System(
        name="hertz",
        states={"x": -0.1, "v": 1.0},
        parameters={"k": 1e5, "n": 1.5},
        rates={"x": "v", "v": "0"},
        contacts=[{"name": "s", "depth": "x", "force": f"k*{power}"}],
        scales={"t": 1.0},
    )
    found = jp.simulate(system, duration=0.2, transient=0)
    lasts = 0.8 * beta(0.4, 0.5) * (5 / (4 * 1e5)) ** 0.4
    np.testing.assert_allclose(found["end_state"].values, (lasts - 0.1, -1.0), rtol=1e-7)


def test_counts_of_a_motion_that_begins_free():
    rows = events((0, ENTRY, 1.0), (0, SLIP, 1.5), (0, EXIT, 2.0), (0, ENTRY, 6.0), (0, EXIT, 7.5))
    found = contacts.counts(rows, 10.0, 4.0, False)
    assert found == {"impacts": 0.5, "separations": 0.5, "contact_fraction": 0.25}


def test_counts_of_a_motion_that_begins_and_ends_in_contact():
    rows = events((0, EXIT, 2.0), (0, ENTRY, 6.0), (0, EXIT, 12.0))
    assert contacts.counts(rows, 10.0, 2.0, True)["contact_fraction"] == pytest.approx(
        0.6
    )  # 12 s is after the end
    assert contacts.counts(rows, 10.0, 2.0, True)["separations"] == 0.5


@pytest.mark.parametrize("closed", [True, False])
def test_a_motion_without_events_is_as_it_ends(closed):
    assert contacts.counts(events(), 10.0, 2.0, closed)["contact_fraction"] == float(closed)


def test_each_joint_has_its_own_counts_and_an_impact_is_both():
    rows = events((0, ENTRY, 1.0), (1, ENTRY, 2.0), (0, EXIT, 3.0), (1, EXIT, 8.0), (1, HIT, 9.0))
    one, two = (contacts.counts(rows, 10.0, 1.0, False, joint) for joint in (0, 1))
    assert one == {"impacts": 1.0, "separations": 1.0, "contact_fraction": 0.2}
    assert two == {"impacts": 2.0, "separations": 2.0, "contact_fraction": 0.6}


def record(model, *rows, **more):
    """Records with events (contact, kind, time, state, modes) and the state's own start."""
    n = 1 + len(model.state) + len(model.joints)
    start = np.concatenate([[0.0], model.state, np.zeros(len(model.joints))])
    return SimpleNamespace(events=np.array(rows, dtype=float).reshape(-1, 2 + n), start=start, **more)


def test_rigid_walls_closing_speed_and_gap():
    found = record(PAIR, (0, HIT, 1.0, 1.5, 0.7), (1, HIT, 2.0, -1.5, -0.2), (0, HIT, 3.0, 1.5, 0.4))
    assert contacts.smallest_impact_speed(PAIR, found) == pytest.approx([0.4, 0.2])
    missed = record(PAIR, misses=np.array([(0, 0, 1.0, 1.4, 0.0), (0, 0, 2.0, 1.45, 0.0)]))
    assert contacts.smallest_missed_gap(PAIR, missed) == pytest.approx([0.05, np.nan], nan_ok=True)


def test_a_table_that_moves_closes_at_its_own_speed_too():
    ball = assemble(catalog.bouncing_ball(1.2, 0.5), None, "phase")
    found = record(ball, (0, HIT, 0.3, np.sin(0.3), -1.0))
    assert contacts.smallest_impact_speed(ball, found) == pytest.approx([1.0 + np.cos(0.3)], rel=1e-8)


def test_soft_walls_closing_speed_and_gap():
    found = record(
        SOFT,
        (0, ENTRY, 1.0, 1.5, 0.7, 0, 0),
        (1, ENTRY, 2.0, -1.5, -0.2, 0, 0),
        (0, EXIT, 3.0, 1.5, -0.1, 5, 0),
    )
    assert contacts.smallest_impact_speed(SOFT, found) == pytest.approx([0.7, 0.2])
    missed = record(SOFT, misses=np.array([(1, 0, 1.0, -1.2, 0.0, 0, 0)]))
    assert contacts.smallest_missed_gap(SOFT, missed) == pytest.approx([np.nan, 0.3], nan_ok=True)


def test_a_journal_in_the_middle_of_its_bearing_misses_by_the_clearance():
    missed = record(LINKAGE, misses=np.array([(0, 0, 1.0, *LINKAGE.state, 0)]))
    assert contacts.smallest_missed_gap(LINKAGE, missed) == pytest.approx([2.9e-4])


@pytest.mark.parametrize(
    "system", [catalog.impact_pair(3.0, 0.8), catalog.soft_impact_pair(3.0, 100.0, 1.0)], ids=lambda s: s.name
)
def test_a_motion_between_the_walls_misses_them_by_what_is_left(system):
    """y = -sin t never meets a wall."""
    gaps = np.array([2.02, 2.2, 4.0])
    found = jp.bifurcation(
        system, over={"gap": gaps}, direction="reset", initial=[0.0, -1.0], turns=5, transient=1, n_jobs=1
    )
    assert found.smallest_missed_gap.values[:, 0] == pytest.approx(gaps / 2 - 1, abs=1e-6)
    assert (found.impacts == 0).all()
    assert (found.mode_word == ".").all()
    assert np.isnan(found.smallest_impact_speed).all()
    assert found.smallest_missed_gap.attrs["units"] == "1"


def test_words_of_modes():
    modes = [0, 2, 3, 3, 0]  # before each event, then at the end
    state = LINKAGE.state
    rows = [(0, ENTRY, 1.0 + i, *state, mode) for i, mode in enumerate(modes[:-1])]
    found = record(LINKAGE, *rows)
    last = np.array([6.0, *state, modes[-1]])
    word = lambda *bounds: contacts.words(LINKAGE, found, last, np.array(bounds), 1)  # noqa: E731
    assert word(0.0, 6.0) == ["f+-f"]
    assert word(0.0, 1.5, 6.0) == ["+-f"]
    assert word(0.0, 2.5, 2.7) == ["-"]
    both = contacts.words(LINKAGE, found, last, np.array([0.0, 2.5, 6.0]), 2)
    assert both == ["-f f+-"]  # the turn that comes first in the alphabet leads
    assert contacts.words(LINKAGE, found, last, np.array([0.0, 2.5, 6.0]), 0) == ["-f"]
    assert contacts.words(LINKAGE, found, last, np.array([0.0, 2.5, 6.0]), 7) == ["-f"]


def test_words_of_walls_and_of_a_long_turn():
    hits = [(i % 2, HIT, 0.1 + i, 1.5, 0.7) for i in range(5)]
    found = record(PAIR, *hits)
    last = np.array([5.0, 0.0, 0.0])
    assert contacts.words(PAIR, found, last, np.array([0.0, 2.0, 4.0, 5.0]), 2) == ["u ul"]
    assert contacts.words(PAIR, found, last, np.array([0.0, 4.9, 5.0]), 1) == ["."]
    many = record(PAIR, *[(0, HIT, 0.01 * (i + 1), 1.5, 0.7) for i in range(40)])
    (word,) = contacts.words(PAIR, many, last, np.array([0.0, 5.0]), 1)
    assert word == "u" * 23 + "~"
