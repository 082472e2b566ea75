"""On which side of a grazing a curve starts, and which curves are one, on points made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.analysis.curves import curve as curves
from jointplay.analysis.curves import tracing
from jointplay.analysis.curves.grazing import SHORT, Grazing


def orbit(count):
    return SimpleNamespace(image=SimpleNamespace(events=np.zeros((count, 3)), status=0))


@pytest.mark.parametrize(("first", "second", "taken"), [(4, 6, 0), (6, 4, 1)])
def test_a_grazing_starts_on_the_side_with_fewer_events(monkeypatch, first, second, taken):
    """Whichever side is met first, in results and on branches."""
    event, sides = (0, 1), [(orbit(first), 0.1), (orbit(second), 0.2)]
    monkeypatch.setattr(
        curves, "changed_event", lambda one, other: event if one.shape != other.shape else None
    )
    assert curves._fewer_events(iter(sides), event)[1] == sides[taken][1]
    assert curves._fewer_events(iter([sides[0], sides[0]]), event)[1] == sides[0][1]
    points = [SimpleNamespace(orbit=each) for each, _ in sides]
    monkeypatch.setattr(tracing, "same_orbit_events", lambda one, other: one is other)
    for special in points:
        found = tracing._before(SimpleNamespace(points=points), SimpleNamespace(point=special))
        assert found is points[taken]


@pytest.mark.parametrize(("before", "here", "known"), [(1, 1, True), (1, 2, False), (2, 1, False)])
def test_a_grazing_is_followed_on_its_own_side(monkeypatch, before, here, known):
    """Where the guard fires once more, or less, there is no margin; else it ends short of 0."""
    section, image = SimpleNamespace(model=None, turns=1), SimpleNamespace(status=0, events=here, time=1.0)
    trial = SimpleNamespace(section=section, state=None, image=image)
    near = np.array([0.3]), np.array([0.5]), np.array([2.0])
    guards = SimpleNamespace(
        count=lambda guard, events: events, nearest=lambda *_: near, minimum=lambda *_: (0.3, 0.5)
    )
    monkeypatch.setattr("jointplay.analysis.curves.grazing.Guards", lambda model: guards)
    like = SimpleNamespace(orbit=SimpleNamespace(image=SimpleNamespace(events=before)))
    value = Grazing(0, 2.0).value(trial, like)
    assert np.isfinite(value) == known
    assert not known or value == pytest.approx(0.15 - SHORT, abs=1e-15)


def curve(points, multipliers, kind="fold", event=(-1, -1)):
    each = [SimpleNamespace(q=np.array(q, dtype=float), multipliers=np.array(multipliers)) for q in points]
    return SimpleNamespace(kind=kind, event=event, branch=SimpleNamespace(points=each))


def test_a_curve_that_crosses_another_is_not_the_same():
    """They meet in the plane, not in their orbits: multipliers differ there."""
    along = [(0.0, 0.5), (0.25, 0.5), (0.5, 0.5), (1.0, 0.5)]
    one, start = curve(along, (1.0, 0.2)), [(0.4, 0.5), (0.4, 0.9)]
    assert tracing._passes(one, curve(start, (1.0, 0.2)))
    assert not tracing._passes(one, curve(start, (1.0, 0.9)))
    assert not tracing._passes(one, curve(start, (1.0, 0.2), event=(0, 1)))
    assert not tracing._passes(one, curve(start, (1.0, 0.2), kind="period_doubling"))
    assert not tracing._passes(one, curve([(0.4, 0.6), (0.4, 0.9)], (1.0, 0.2)))
    assert not tracing._passes(one, curve([(1.2, 0.5), (1.4, 0.5)], (1.0, 0.2)))
