"""Curves of maps with known bifurcations in two parameters, and their meetings."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from jointplay.analysis.curves.tracing import CONDITIONS, Curves, _passes, starts_of
from jointplay.analysis.curves.tracing import _unstuck as unstuck
from jointplay.analysis.orbits.arclength import first
from jointplay.analysis.orbits.continuation import Explorer
from jointplay.analysis.orbits.shooting import newton
from jointplay.solver.method.codes import Event
from tests.analysis.orbits.test_continuation_maps import Plain, Plains


def mixed(p, x):
    """x' = r x (1 - b y - (1 - b) x), y' = x: determinant b (r - 1), trace 1 - (1 - b)(r - 1)."""
    if x is None:
        return [0.0, 0.0]
    r, b = p
    share = 1 - b * x[1] - (1 - b) * x[0]
    return np.array([r * x[0] * share, x[0]]), np.array(
        [[r * (share - (1 - b) * x[0]), -r * b * x[0]], [1.0, 0.0]]
    )


def cusped(p, x):
    """x' = x + p + q x - x^3: folds at p = -+2 (q/3)^(3/2), which meet in a cusp at 0."""
    if x is None:
        return [0.0]
    return x + p[0] + p[1] * x - x**3, np.diag(1 + p[1] - 3 * x**2)


def both(p, x):
    """x' = x + p - x^2, y' = -(1 + q + x) y: a fold at p = 0; a doubling at p = q^2."""
    if x is None:
        return [0.0, 0.0]
    state = np.array([x[0] + p[0] - x[0] ** 2, -(1 + p[1] + x[0]) * x[1]])
    return state, np.array([[1 - 2 * x[0], 0.0], [-x[1], -(1 + p[1] + x[0])]])


def stuck(p, x):
    """x' = x + p + (q - 2/3 sqrt x) x, which sticks; from x = 0 down x' = x/2 + p, which does not."""
    if x is None:
        return [0.0]
    if x[0] <= 0:
        return x / 2 + p[0], np.diag([0.5])
    root = math.sqrt(x[0])
    return x * (1 + p[1] - 2 / 3 * root) + p[0], np.diag([1 + p[1] - root])


PLANE = np.array([[-0.4, -0.5], [0.3, 1.0]])


def sticking(contact, onset, share):
    """Rows of a piece of sticking that takes a share of an orbit."""
    places = (onset, Event.STICK_ONSET), ((onset + share) % 1.0, Event.SLIP_ONSET)
    return [[contact, kind, place, place] for place, kind in sorted(places)] if share else []


class Stuck(Plain):
    """The map `stuck` with its sticking: it takes a tenth of the root of x, across the section."""

    def image(self, state, *given, **named):
        events = np.reshape(self.events(state), (-1, 4)).astype(float)
        return replace(super().image(state, *given, **named), events=events)

    def events(self, state):
        return sticking(0, 0.9995, 0.1 * math.sqrt(max(state[0], 0.0)))


class Twice(Stuck):
    """The same with a short piece of sticking in another contact, below q = 0.5 alone."""

    def events(self, state):
        return super().events(state) + sticking(1, 0.5, 1e-5 * (self.p[1] < 0.5))


def curves(rule, start, p, low, high, of, step=0.04, most=200, plain=Plain):
    """Curves from the branch over the first parameter, as (kind, parameters, meetings, ends)."""
    low, high, p = map(np.array, (low, high, p))
    family = Plains(lambda value: plain(rule, value), low, high, 1e-9)
    line = Plains(lambda value: plain(lambda q, x: rule([q, p[1]], x), value), low[0], high[0], 1e-9)
    orbit = newton(plain(rule, p), np.array(start), 1e-9)
    assert orbit.status == 0
    branch = Explorer(line, step, 200, 1).explore(orbit, line.fraction(p[0]))[0]
    second = family.fraction(p)[1]
    starts = starts_of([branch], of, lambda first: np.array([first, second]))
    found = []
    for each in Curves(family, step, most, lambda point: None).traced(starts):
        places = np.array([family.parameter(point.q) for point in each.branch.points])
        met = {special.kind: family.parameter(special.q) for special in each.branch.specials}
        found.append((each.kind, places, met, each.branch.ends))
    return found


def test_neimark_sacker_between_its_resonances():
    ((kind, places, met, ends),) = curves(
        mixed, [0.6, 0.6], [2.5, 0.6], [1.5, 0.15], [7.0, 0.9], ("neimark_sacker",)
    )
    r, b = places.T
    assert kind == "neimark_sacker"
    assert r == pytest.approx(1 + 1 / b, rel=1e-9)
    assert met["resonance_1_4"] == pytest.approx([3, 1 / 2], rel=1e-9)
    assert met["resonance_1_3"] == pytest.approx([4, 1 / 3], rel=1e-9)
    assert met["resonance_1_2"] == pytest.approx([5, 1 / 4], rel=1e-7)
    assert set(ends) == {"range", "resonance"}
    assert b.min() == pytest.approx(1 / 4, rel=1e-7)
    assert b.max() == 0.9


@pytest.mark.parametrize(("apart", "same"), [(5.0, True), (15.0, False)])
def test_a_start_lies_on_a_curve_where_the_multipliers_are_nearly_the_same(apart, same):
    """Their product is 1000 there: a hundredth of it is 10."""

    def curve(ends, product):
        points = [SimpleNamespace(q=np.array(q), multipliers=np.array([1.0, product])) for q in ends]
        return SimpleNamespace(kind="fold", event=(-1, -1), branch=SimpleNamespace(points=points))

    one, other = curve([(0.0, 0.0), (1.0, 1.0)], 1000.0), curve([(0.5, 0.5)], 1000.0 + apart)
    assert _passes(one, other) is same


def test_a_doubling_passes_the_resonance():
    ((_, places, met, ends),) = curves(
        mixed, [0.6, 0.6], [2.5, 0.1], [1.5, 0.05], [7.0, 0.9], ("period_doubling",)
    )
    r, b = places.T
    assert r == pytest.approx(1 + 2 / (1 - 2 * b), rel=1e-9)
    assert met == {"resonance_1_2": pytest.approx([5, 1 / 4], rel=1e-7)}
    assert ends == ("range", "range")


def test_two_folds_meet_in_a_cusp():
    found = curves(cusped, [1.3], [0.0, 1.5], [-2.0, -1.0], [2.0, 2.0], ("fold",))
    ((_, places, met, ends),) = found  # the second fold of the branch lies on the same curve
    p, q = places.T
    assert np.abs(p) == pytest.approx(2 * np.maximum(q / 3, 0) ** 1.5, abs=1e-9)
    assert p.min() < -0.5
    assert p.max() > 0.5
    assert met == {"cusp": pytest.approx([0, 0], abs=1e-8)}
    assert ends == ("range", "range")


def test_a_doubling_touches_a_fold():
    found = curves(both, [0.5, 0.0], [0.25, -0.3], [-0.5, -0.9], [0.9, 0.9], ("fold", "period_doubling"))
    assert {kind for kind, *_ in found} == {"fold", "period_doubling"}
    for kind, places, met, _ in found:
        p, q = places.T
        assert p == pytest.approx(q**2 if kind == "period_doubling" else 0 * q, abs=1e-9)
        assert met == {"fold_doubling": pytest.approx([0, 0], abs=1e-6)}


@pytest.mark.parametrize("most", [200, 44])
def test_a_fold_ends_where_sticking_has_shrunk_to_nothing(most):
    """It is at x = q^2, p = -q^3/3; at q = 0 P' jumps to 1/2. Points that one half leaves serve the other."""
    ((_, places, met, ends),) = curves(stuck, [2.25], [0.225, 0.9], *PLANE, ("fold",), most=most, plain=Stuck)
    assert places[:, 0] == pytest.approx(-(places[:, 1] ** 3) / 3, abs=1e-9)
    assert met == {"grazing": pytest.approx([0.0, 0.0], abs=1e-6)}
    assert sorted(ends) == ["grazing", "range"]
    assert np.sum(places[:, 1] < 0.9) > 22
    assert len(places) <= 44


def test_only_sticking_that_shrinks_to_nothing_soon_ends_a_fold():
    def ahead(q, plain=Stuck):
        family = Plains(lambda value: plain(stuck, value), *PLANE, 1e-9, CONDITIONS["fold"])
        p = np.array([-(q**3) / 3, q])
        orbit = newton(plain(stuck, p), np.array([q**2]), 1e-9)
        met = unstuck(family, first(family, orbit, family.fraction(p), (0.0, -1.0)))
        return None if met is None else (family.parameter(met.q), met.event)

    place, event = ahead(0.01)
    assert place == pytest.approx([0.0, 0.0], abs=1e-5)
    assert event == (0, Event.STICK_ONSET)
    assert ahead(0.1) is None
    assert ahead(0.49999, Twice) is None  # what appears beside the point shrinks nowhere


@pytest.mark.parametrize(
    ("kind", "critical"), [("fold", 1.0), ("period_doubling", -1.0), ("symmetry_breaking", -1.0)]
)
def test_a_condition_vanishes_where_a_multiplier_is_critical_and_there_alone(kind, critical):
    """A symmetric orbit loses its symmetry where half a turn and the reflection have the multiplier -1."""
    like = np.array([[critical, 0.4], [0.0, 0.3]])
    point = SimpleNamespace(orbit=SimpleNamespace(image=SimpleNamespace(derivative=like)))
    for multiplier in (critical, -critical, 2 * critical, 0.5):
        P = np.array([[multiplier, 0.4], [0.0, 0.3]])
        value = CONDITIONS[kind].value(SimpleNamespace(image=SimpleNamespace(derivative=P)), point)
        assert (abs(value) < 1e-12) == (multiplier == critical)


def beside(pair):
    """A fold at p = 0 beside two multipliers; both pass the product 1 at q = 0."""

    def rule(p, x):
        if x is None:
            return [0.0, 0.0, 0.0]
        B = pair(1 + p[1])
        P = np.zeros((3, 3), dtype=B.dtype)
        P[0, 0], P[1:, 1:] = 1 - 2 * x[0], B
        return np.array([x[0] + p[0] - x[0] ** 2, *(B @ x[1:])]), P

    return rule


@pytest.mark.parametrize(
    ("pair", "meeting"),
    [
        (lambda r: r * np.array([[math.cos(1.0), -math.sin(1.0)], [math.sin(1.0), math.cos(1.0)]]), True),
        (lambda r: r * np.diag([2.0, 0.5]), False),
    ],
)
def test_a_fold_meets_a_torus_where_a_pair_turns_and_nothing_at_a_neutral_saddle(pair, meeting):
    ((_, places, met, ends),) = curves(
        beside(pair), [0.3, 0.0, 0.0], [0.09, 0.05], [-0.05, -0.2], [0.2, 0.2], ("fold",)
    )
    assert places[:, 0] == pytest.approx(0.0, abs=1e-9)
    assert met == ({"fold_torus": pytest.approx([0.0, 0.0], abs=1e-7)} if meeting else {})
    assert ends == ("range", "range")
