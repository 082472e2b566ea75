"""The backward pass on maps: Hénon's vectors against his map's own manifolds, cut off nowhere."""

import math

import mpmath as mp
import numpy as np
import pytest

from jointplay.analysis.exponents import batch_means
from jointplay.analysis.exponents.covariant import (
    angles_between,
    backward,
    factors,
    splittings,
    start,
    widened,
)

STEPS, ENDS = 3000, 60


def orbit(steps, first=(0.1, 0.1)):
    """Points of (1 - 1.4 x² + y, 0.3 x)."""
    points = [first]
    for _ in range(steps):
        x, y = points[-1]
        points.append((1 - 1.4 * x * x + y, 0.3 * x))
    return points


def jacobian(point):
    return np.array([[-2.8 * point[0], 1.0], [0.3, 0.0]])


@pytest.fixture(scope="module")
def henon():
    """Points, vectors at each, growth of the vectors and of the frame at each step."""
    points, Q, frames, steps = orbit(STEPS), np.eye(2), [], []
    for point in points[:-1]:
        frames.append(Q)
        Q, R = factors(jacobian(point) @ Q)
        steps.append(R)
    back = list(backward(reversed(steps), start(2, 0)))[::-1]
    vectors = [Q @ C for Q, (C, _) in zip(frames, back, strict=True)]
    return points, vectors, np.array([g for _, g in back]), np.log([np.diag(R) for R in steps])


def manifolds(points, at, length=60):
    """Unstable and stable direction at a point of the orbit, by 60 digits.

    What was anything long ago points along the unstable one; the stable one is what has shrunk most when the
    point has gone on for long: the pre-image of anything then.
    """
    with mp.workdps(60):
        J = lambda k: mp.matrix([[mp.mpf("-2.8") * mp.mpf(points[k][0]), 1], [mp.mpf("0.3"), 0]])  # noqa: E731
        ways = []
        for steps, move in (
            (range(at - length, at), lambda k, v: J(k) * v),
            (range(at + length - 1, at - 1, -1), lambda k, v: mp.inverse(J(k)) * v),
        ):
            way = mp.matrix([1, mp.mpf("0.3")])
            for k in steps:
                way = move(k, way)
                way /= mp.norm(way)
            ways.append([float(each) for each in way])
    return np.array(ways).T


def test_henon_s_vectors_are_tangent_to_his_manifolds(henon):
    points, vectors, *_ = henon
    for at in range(ENDS, STEPS - ENDS, 160):
        assert angles_between(vectors[at], manifolds(points, at)).max() < 1e-9


def test_a_map_takes_each_vector_to_the_next(henon):
    points, vectors, grown, _ = henon
    for at in range(ENDS, STEPS - ENDS):
        moved = jacobian(points[at]) @ vectors[at]
        lengths = np.linalg.norm(moved, axis=0)
        assert np.log(lengths) == pytest.approx(grown[at], abs=1e-9)
        assert angles_between(moved / lengths, vectors[at + 1]).max() < 1e-9


def test_both_growths_differ_by_the_angle_of_the_ends(henon):
    """The leading vector is the frame's; what both span together changes its volume as the frame does."""
    _, vectors, grown, frame = henon
    assert grown[:, 0] == pytest.approx(frame[:, 0], abs=1e-12)
    volume = np.log([abs(np.linalg.det(V)) for V in vectors])
    gained = (grown - frame)[ENDS : STEPS - ENDS].sum()
    assert gained == pytest.approx(volume[ENDS] - volume[STEPS - ENDS], abs=1e-9)
    assert frame.sum(axis=1) == pytest.approx(np.full(STEPS, math.log(0.3)), abs=1e-12)


def measured(growth):
    """Mean growth a step, and its standard error."""
    rows = np.vstack([np.zeros(3), np.cumsum(np.insert(growth, 0, 1.0, axis=1), axis=0)])
    return [of(rows, slice(1, 3)) for of in (batch_means.growth, batch_means.standard_error)]


def test_exponents_are_those_by_qr_of_another_orbit_and_the_known_ones(henon):
    """Within three standard errors; 0.41922 and their sum, ln 0.3."""
    *_, grown, _ = henon
    Q, logs = np.eye(2), []
    for point in orbit(2 * STEPS, (0.2, -0.1))[STEPS:-1]:
        Q, R = factors(jacobian(point) @ Q)
        logs.append(np.log(np.diag(R)))
    value, error = measured(grown[ENDS : STEPS - ENDS])
    other, doubt = measured(np.array(logs))
    assert np.all(error < 0.02)
    assert np.all(np.abs(value - other) < 3 * np.hypot(error, doubt))
    assert np.all(np.abs(value - [0.41922, math.log(0.3) - 0.41922]) < 3 * error)


def test_splittings_are_principal_angles():
    """Three lines of known angles: between a line and a plane, and between a plane and a line."""
    C = np.array([[1.0, math.cos(0.3), 0.0], [0.0, math.sin(0.3), math.sin(0.2)], [0.0, 0.0, math.cos(0.2)]])
    line = np.linalg.svd(C[:, 1:], full_matrices=False)[0].T @ C[:, :1]  # cosine of the angle with a plane
    assert splittings(C) == pytest.approx([math.acos(np.linalg.norm(line)), math.pi / 2 - 0.2], abs=1e-12)


def test_small_angles_keep_their_digits():
    C = np.array([[1.0, math.cos(1e-9)], [0.0, math.sin(1e-9)]])
    assert splittings(C) == pytest.approx([1e-9], rel=1e-6)
    assert angles_between(C[:, :1], -C[:, 1:]) == pytest.approx([1e-9], rel=1e-6)


def test_a_series_whose_later_factors_have_fewer_directions():
    random = np.random.default_rng(3)
    whole = [factors(random.normal(size=(3, 3)))[1] for _ in range(20)]
    cut = [R if i < 10 else R[:2, :2] for i, R in enumerate(whole)]
    full = list(backward(reversed(whole), start(3, 1)))[-1][0]
    less = list(backward(reversed(cut), start(3, 1)[:2, :2]))[-1][0]
    assert less.shape == (3, 3)
    assert less[:2, :2] == pytest.approx(full[:2, :2], abs=1e-12)
    assert np.allclose(widened(np.eye(2), 3), np.eye(3))
