"""Accelerations and contact quantities of the generated functions against free bodies with reactions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from tests.support.linkages import ARRANGEMENTS

from ..reference.four_bar import by_name, scattered
from .both import accelerations, pair, point

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
    ours, theirs = point(system, model, y, modes), accelerations(system, y, named)
    rate, solved = ours.rate(), system.at_modes(y, named)
    assert np.abs(rate - theirs[:, None]).max() < tolerance * np.abs(theirs).max()
    slips = by_name(solved)[1]
    for (name, touch, normal, tangential), row in zip(solved.touches, ours.contacts(), strict=True):
        u, v_n, v_t, F_n, F_t, creep = row
        assert (u, v_n, v_t) == pytest.approx((touch.u, touch.v_n, touch.v_t), rel=1e-10, abs=1e-14)
        if named[name] == "free":
            continue
        assert F_n == pytest.approx(normal, rel=1e-9)
        assert F_t == pytest.approx(tangential, rel=1e-9)
        if named[name] == "stick":
            assert abs(creep) < 1e-12 * np.abs(theirs).max()
        else:
            assert creep == pytest.approx(slips[name], rel=1e-9)


SCENES = [*itertools.product(ARRANGEMENTS, ("motor", "speed")), ("BC", "none")]


@pytest.mark.nightly
@pytest.mark.parametrize(("joints", "drive"), SCENES)
def test_accelerations_and_contacts(joints, drive):
    system, model = pair(joints, drive=drive)
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
    for seed, mode in itertools.product(range(3), ("free", "closed")):
        y = scattered(system, seed)
        theirs = accelerations(system, y, dict.fromkeys(joints, mode))
        rate = point(system, model, y, [{"closed": "contact"}.get(mode, mode)]).rate()[:, 0]
        assert np.abs(rate - theirs).max() < 1e-11 * np.abs(theirs).max()


@pytest.mark.nightly
def test_guards_are_what_their_names_say():
    system, model = pair("BC", tension=False)
    y = scattered(system, 5)
    ours = point(system, model, y, ("stick", "slip-"))
    ours.rate()
    guards = ours.watched()[:8, 0].reshape(2, 4)
    solved = system.at_modes(y, {"B": "stick", "C": "slip-"})
    for row, (name, touch, F_n, _) in zip(guards, solved.touches, strict=True):
        beyond = touch.u * (touch.u + 2 * system.clearance[name])
        assert row[:3] == pytest.approx((beyond, F_n, touch.v_t), rel=1e-9)
    _, _, F_n, held = solved.touches[0]
    assert guards[0, 3] == pytest.approx((system.p.f * F_n) ** 2 - held**2, rel=1e-8)


def test_a_centred_journal_is_finite_and_free():
    system, model = pair("BC")
    y = system.start()
    ours = point(system, model, y, ("free", "free"))
    theirs = accelerations(system, y, {"B": "free", "C": "free"})
    assert np.abs(ours.rate()[:, 0] - theirs).max() < 1e-11 * np.abs(theirs).max()
    assert np.all(np.isfinite(ours.watched()))
