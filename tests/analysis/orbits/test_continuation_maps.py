"""The algebra of continuation on maps with known bifurcations, in place of sections of a motion."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from jointplay.analysis.orbits.branch import Branch
from jointplay.analysis.orbits.branch_points import Special
from jointplay.analysis.orbits.continuation import Explorer, joined
from jointplay.analysis.orbits.family import Family, Point
from jointplay.analysis.orbits.section_map import Image
from jointplay.analysis.orbits.shooting import newton


@dataclass(frozen=True)
class Plain:
    """A smooth map as a section map: no events, nothing that turns."""

    rule: Callable
    p: float
    turns: int = 1
    phase: float = 0.0
    plane: bool = True
    units: object = None
    scale = None

    @property
    def free(self):
        return np.arange(len(self.rule(self.p, None)))

    def unknowns(self, state):
        return state

    def state(self, unknowns):
        return np.asarray(unknowns)

    def differ(self, one, other):
        return one - other

    def image(self, state, derivative=True, turns=None, directions=()):
        count = self.turns if turns is None else turns
        end, P = self.iterated(self.p, state, count)
        along = [self.iterated(self.p + 1e-40j * way, state, count)[0].imag / 1e-40 for way in directions]
        return Image(0, end, 1.0, P, np.zeros((0, 4)), along=np.array(along).T)

    def iterated(self, p, state, count):
        P = np.eye(len(state))
        for _ in range(count):
            state, step = self.rule(p, state)
            P = step @ P
        return state, P


class Plains(Family):
    """Such maps over parameters, which need no mechanism to be differentiated in them."""

    def directions(self, q, like):
        return np.eye(self.count) if self.count > 1 else [1.0]


def logistic(r, x):
    """x' = r x (1 - x): transcritical at 1, doublings at 3 and 1 + sqrt 6."""
    return [0.0] if x is None else (r * x * (1 - x), np.diag(r * (1 - 2 * x)))


def delayed(r, x):
    """x' = r x (1 - y), y' = x (Maynard Smith 1968): Neimark-Sacker at r = 2, multipliers exp(+-i pi/3)."""
    if x is None:
        return [0.0, 0.0]
    return np.array([r * x[0] * (1 - x[1]), x[0]]), np.array([[r * (1 - x[1]), -r * x[0]], [1.0, 0.0]])


def square(p, x):
    """x' = x + p - x^2: fold at p = 0."""
    return [0.0] if x is None else (x + p - x**2, np.diag(1 - 2 * x))


def saddle(p, x):
    """Multipliers 2 and p beside each other: a product of 1 at p = 1/2 that is no Neimark-Sacker."""
    return [0.0, 0.0] if x is None else (np.array([2.0, p]) * x, np.diag([2.0, p]))


def branches(rule, start, p, low, high, most=200, many=3, step=0.03):
    family = Plains(lambda value: Plain(rule, value), low, high, 1e-9)
    orbit = newton(Plain(rule, p), np.array(start), 1e-9)
    assert orbit.status == 0
    found = Explorer(family, step, most, many).explore(orbit, family.fraction(p))
    told = [[(s.kind, family.parameter(s.q), s.multiplier) for s in branch.specials] for branch in found]
    return found, told, family


def test_logistic_map():
    found, told, family = branches(logistic, [0.6], 2.5, 0.5, 3.6)
    (transcritical, doubling) = told[0]
    assert transcritical[:2] == ("branch_point", pytest.approx(1.0, abs=1e-7))
    assert doubling[:2] == ("period_doubling", pytest.approx(3.0, abs=1e-10))
    for point in found[0].points:
        assert point.orbit.state[0] == pytest.approx(1 - 1 / family.parameter(point.q), abs=1e-7)
    trivial = next(branch for branch in found[1:] if branch.points[0].orbit.map.turns == 1)
    assert np.all([abs(point.orbit.state[0]) < 1e-7 for point in trivial.points])
    doubled = next(n for n, branch in enumerate(found) if branch.points[0].orbit.map.turns == 2)
    assert told[doubled][0][:2] == ("period_doubling", pytest.approx(1 + np.sqrt(6), abs=1e-10))
    for point in found[doubled].points[1:]:
        r, x = family.parameter(point.q), point.orbit.state[0]
        assert r**2 * x**2 - r * (r + 1) * x + r + 1 == pytest.approx(0, abs=1e-7)
    assert found[doubled].ends == ("origin", "range")


def bubble(p, x):
    """x' = -(1 + a) x + x^3, a = 0.25 - p^2: doublings at p = +-1/2, the doubled orbit on p^2 + x^2 = 1/4."""
    if x is None:
        return [0.0]
    a = 0.25 - p**2
    return x**3 - (1 + a) * x, np.diag(3 * x**2 - 1 - a)


def test_a_doubled_orbit_joins_the_single_one_again():
    found, told, family = branches(bubble, [0.0], -0.8, -0.9, 0.9)
    assert [each[:2] for each in told[0]] == [
        ("period_doubling", pytest.approx(side, abs=1e-10)) for side in (-0.5, 0.5)
    ]
    assert len(found) == 2  # the second doubling is the end of what leaves the first
    assert found[1].ends == ("origin", "joined")
    for point in found[1].points:
        p, x = family.parameter(point.q), point.orbit.state[0]
        assert p**2 + x**2 == pytest.approx(0.25, abs=1e-8)
    assert family.parameter(found[1].points[-1].q) > 0.45


def test_neimark_sacker():
    _, told, _ = branches(delayed, [0.35, 0.35], 1.6, 1.3, 2.4, many=1)
    ((kind, value, multiplier),) = told[0]
    assert (kind, value) == ("neimark_sacker", pytest.approx(2.0, abs=1e-10))
    assert multiplier == pytest.approx(np.exp(1j * np.pi / 3), abs=1e-8)


def test_fold():
    found, told, _ = branches(square, [0.5], 0.25, -0.2, 0.5, many=1)
    ((kind, value, multiplier),) = told[0]
    assert (kind, value) == ("fold", pytest.approx(0.0, abs=1e-14))
    assert multiplier == pytest.approx(1, abs=1e-7)
    assert found[0].ends == ("range", "range")
    assert found[0].points[0].orbit.state[0] * found[0].points[-1].orbit.state[0] < 0


def test_a_real_pair_is_no_torus():
    _, told, _ = branches(saddle, [0.0, 0.0], 0.3, 0.2, 0.8, many=1)
    assert told[0] == []


def test_halves_are_joined_at_the_point_that_both_have():
    """Also where a change lies at that very point, as of a branch that ends where it begins."""
    at, back, forth = (Point(None, q, 1.0, np.array([q, 1.0])) for q in (0.5, 0.4, 0.6))
    turned = replace(at, tangent=-at.tangent)
    changes = [Special("grazing", turned, 0.5, 0.0), Special("fold", back, 0.4, 0.0)]
    ahead = Branch([at, forth], [Special("fold", forth, 0.6, 0.0)], ("origin", "max_points"))
    found = joined(Branch([turned, back], changes, ("origin", "range")), ahead)
    assert [point.q for point in found.points] == [0.4, 0.5, 0.6]
    assert [found.points.index(each.point) for each in found.specials] == [0, 1, 2]
    assert all(point.tangent[1] * (point.q - 0.5) >= 0 for point in found.points)
    assert found.ends == ("range", "max_points")
