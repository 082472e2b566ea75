"""Accelerations and contact quantities of the generated functions against free bodies with reactions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.support.linkages import ARRANGEMENTS, scattered

from .both import pair, point

MODES = ("free", "slip+", "slip-", "stick")


def mixed(count, seed):
    """Random modes of several joints, free and sticking ones among them."""
    random = np.random.default_rng(seed)
    return tuple(random.permutation([*MODES, *random.choice(MODES, count)])[:count])


def combinations(joints):
    """Every mode of all joints at once, and some mixtures."""
    same = [(mode,) * len(joints) for mode in MODES]
    return same + [mixed(len(joints), seed) for seed in range(6)] if len(joints) > 1 else same


def agree(system, model, y, modes, tolerance=1e-11):
    """Compare accelerations, and what every contact is like."""
    named = dict(zip(system.clearance, modes, strict=True))
    ours = point(system, model, y, modes)
    drop = system.p.drive == "speed"
    theirs = system.rate(y, named)[system.n + drop :]
    rate = ours.rate()
    assert np.abs(rate - theirs[:, None]).max() < tolerance * np.abs(theirs).max()
    _, held, slips = system.solve(y, named)
    for j, (name, mode) in enumerate(named.items()):
        u, v_n, v_t, F_n, F_t, creep = ours.contacts()[j]
        c = system.contact(name, y)
        assert (u, v_n, v_t) == pytest.approx((c.u, c.v_n, c.v_t), rel=1e-10, abs=1e-14)
        assert F_n == pytest.approx(c.force, rel=1e-9) or mode == "free"
        if mode == "stick":
            assert F_t == pytest.approx(held[name], rel=1e-9)
            assert abs(creep) < 1e-12 * np.abs(theirs).max()
        elif mode != "free":
            friction = (system.p.f if mode == "slip+" else -system.p.f) * c.force + system.p.C_t * c.v_t
            assert F_t == pytest.approx(friction, rel=1e-10)
            assert creep == pytest.approx(slips[name], rel=1e-9)


SCENES = [*itertools.product(ARRANGEMENTS, ("motor", "speed")), ("BC", "none")]


@pytest.mark.parametrize(("joints", "drive"), SCENES)
def test_accelerations_and_contacts(joints, drive):
    system, model = pair(joints, drive)
    for seed, modes in enumerate(combinations(joints)):
        agree(system, model, scattered(system, seed), modes)


@pytest.mark.parametrize("joints", ["B", "BC"])
def test_with_drag_and_without_gravity(joints):
    system, model = pair(joints, C_t=2.5, gravity=0.0)
    for seed, modes in enumerate(combinations(joints)):
        agree(system, model, scattered(system, seed), modes)


@pytest.mark.parametrize("joints", ["B", "C"])
def test_drag_alone(joints):
    system, model = pair(joints, C_t=2.5, f=0.0)
    for seed, mode in itertools.product(range(3), ("free", "slip+")):
        ours = {"slip+": "contact"}.get(mode, mode)
        y = scattered(system, seed)
        theirs = system.rate(y, dict.fromkeys(joints, mode))[system.n :]
        rate = point(system, model, y, [ours]).rate()[:, 0]
        assert np.abs(rate - theirs).max() < 1e-11 * np.abs(theirs).max()


def test_guards_are_what_their_names_say():
    system, model = pair("BC", tension=False)
    y = scattered(system, 5)
    ours = point(system, model, y, ("stick", "slip-"))
    ours.rate()
    guards = ours.watched()[:8, 0].reshape(2, 4)
    held = system.solve(y, {"B": "stick", "C": "slip-"})[1]["B"]
    for row, name in zip(guards, "BC", strict=True):
        c = system.contact(name, y)
        assert row[:3] == pytest.approx((c.rho**2 - system.clearance[name] ** 2, c.force, c.v_t), rel=1e-9)
    limit = system.p.f * system.contact("B", y).force
    assert guards[0, 3] == pytest.approx(limit**2 - held**2, rel=1e-8)


def test_a_centred_journal_is_finite_and_free():
    system, model = pair("BC")
    y = system.start()
    ours = point(system, model, y, ("free", "free"))
    theirs = system.rate(y, {"B": "free", "C": "free"})[system.n :]
    assert np.abs(ours.rate()[:, 0] - theirs).max() < 1e-11 * np.abs(theirs).max()
    assert np.all(np.isfinite(ours.watched()))
