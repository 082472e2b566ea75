"""Orbits beside a curve's end that lack one of its events: which is taken, and as what."""

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.analysis.curves import tracing
from jointplay.solver.method.codes import Event

EVENTS = np.array([[0, Event.STICK_ONSET, 0.1], [1, Event.CONTACT, 0.4], [1, Event.SEPARATION, 0.5]])
ACROSS = np.array([0.8, -0.6])  # a curve's tangent in the ranges is (0.6, 0.8)


def beside(monkeypatch, fewer):
    """Orbits across a curve; of each its way across tells which events it has, None where there is none."""

    def newton(q, state, tolerance):
        events = fewer((q - last.q) @ ACROSS)
        image = None if events is None else SimpleNamespace(events=events)
        return SimpleNamespace(status=int(events is None), image=image)

    monkeypatch.setattr(tracing, "newton", newton)
    family = SimpleNamespace(at=lambda q, like: q, tolerance=1e-9)
    orbit = SimpleNamespace(image=SimpleNamespace(events=EVENTS), state=np.zeros(2), map=None)
    last = SimpleNamespace(tangent=np.array([9.0, 3.0, 4.0]), q=np.array([0.5, 0.5]), orbit=orbit)
    return [(float((q - last.q) @ ACROSS), event) for _, q, event in tracing._across(family, last)]


@pytest.mark.parametrize(
    ("gone", "away"), [(0.0, 1e-5), (5e-6, 1e-5), (5e-5, 1e-4), (5e-4, 1e-3), (5e-3, 1e-2)]
)
@pytest.mark.parametrize("side", [-1, 1])
def test_the_nearest_orbit_without_a_contact_is_taken(monkeypatch, gone, away, side):
    """Beyond `gone` on one side the contact does not begin, and so does not end."""
    found = beside(monkeypatch, lambda place: EVENTS[:1] if side * place > gone else EVENTS)
    assert found == [(pytest.approx(side * away), (1, Event.CONTACT))]


def test_no_orbit_is_taken_that_fails_has_as_many_events_or_lacks_another_kind(monkeypatch):
    assert beside(monkeypatch, lambda place: None) == []
    assert beside(monkeypatch, lambda place: EVENTS[[0, 1, 2, 0]]) == []
    assert beside(monkeypatch, lambda place: EVENTS[1:]) == []
