"""Motions with links that bend: against closed forms under slow loads, and against each other."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.parts.beam import line_density, stiffness
from tests.support.linkages import bending

WORDS = ["angle", "angular_velocity", "angular_acceleration", "deflection"]
HERMITE = {"damping_ratio": 0.01}
SINE = {"shapes": "sine", "damping_ratio": 0.01}


def ideal(speed=None, **beam):
    """The table's mechanism without play, its coupler bending."""
    changes = {"gear_ratio": 3.0} if speed is None else {"speed": speed}
    return bending(jp.catalog.chunmei2002(clearance=0, **changes), {"coupler": jp.Beam(**HERMITE | beam)})


def mid(found):
    """Deflection of the coupler, m."""
    return found.deflection.sel(link="coupler").values


def sag(found, mechanism):
    """Quasi-static mid deflection, m: 5 q l^4 / 384 EI under an even load, half of it where q grows from 0.

    The load is weight and inertia of the coupler's frame; A moves on a circle.
    """
    link, crank, w = mechanism.link("coupler"), mechanism.link("crank"), mechanism.drive.speed
    turned = found.angle.sel(link="crank").values - found.angle.sel(link="coupler").values
    across = 9.8 * np.cos(found.angle.sel(link="coupler").values) - crank.length * w**2 * np.sin(turned)
    growing = link.length * found.angular_acceleration.sel(link="coupler").values
    return -5 / 384 * line_density(link) * link.length**4 / stiffness(link) * (across + growing / 2)


def partial(modes):
    """The share of an even load's mid deflection that sine modes make up."""
    terms = (4 / math.pi**5 * (-1) ** ((n - 1) // 2) / n**5 for n in range(1, modes + 1, 2))
    return sum(terms) * 384 / 5


@pytest.mark.parametrize(
    ("speed", "beam", "share"),
    [
        (2.0, {"damping_ratio": 1e-3}, 1.0),
        (2.0, {**SINE, "elements": None, "modes": 4, "damping_ratio": 1e-3}, partial(4)),
        (1e-3, {"damping_ratio": 1.0}, 1.0),
    ],
    ids=["elements", "sines", "critically damped"],
)
def test_a_slow_mechanism_bends_as_a_beam_at_rest(speed, beam, share):
    """Beyond it lie (speed/omega)^2 and the lag 2 xi speed/omega, omega = 4900 rad/s, of a few 1e-7."""
    mechanism = ideal(speed, **beam)
    found = jp.simulate(mechanism, turns=1, transient=2, rtol=1e-11, record=WORDS, samples_per_turn=90)
    expected = share * sag(found, mechanism)
    assert np.abs(mid(found) - expected).max() < 1e-6 * np.abs(expected).max()


def test_weight_and_inertia_both_bend_at_this_speed():
    """Or the test above would not see one of them."""
    mechanism = ideal(2.0)
    found = jp.simulate(mechanism, turns=1, record=WORDS, samples_per_turn=90)
    weight = sag(found.assign(angular_acceleration=0 * found.angular_acceleration), mechanism)
    assert 1e-3 < np.abs(sag(found, mechanism) / weight - 1).max() < 0.1


@pytest.mark.parametrize("speed", [None, 83.8])
def test_sine_modes_and_elements_bend_alike(speed):
    """At full speed; four sine modes lack the fifth and on, 3e-4 of it, once the start's are quiet."""
    ends = [
        mid(jp.simulate(ideal(speed, **beam), turns=1, transient=3, rtol=1e-10, record=WORDS))
        for beam in ({}, SINE | {"elements": None})
    ]
    assert np.abs(ends[0] - ends[1]).max() < 1e-3 * np.abs(ends[0]).max()


@pytest.mark.nightly
def test_what_few_modes_and_elements_lack():
    """Elements that have no node in the middle lack the cubic's share there, 1/5 of one element's sag."""
    quick = {"turns": 1, "transient": 3, "rtol": 1e-11, "record": WORDS}
    fine = mid(jp.simulate(ideal(83.8, elements=4), **quick))
    lacking = {"elements": {1: 1 / 5, 3: 1 / 5 / 3**4}, "modes": {n: abs(1 - partial(n)) for n in (1, 3, 5)}}
    for key, shares in lacking.items():
        for count, share in shares.items():
            beam = {"elements": count} if key == "elements" else SINE | {"elements": None, "modes": count}
            off = np.abs(mid(jp.simulate(ideal(83.8, **beam), **quick)) - fine).max()
            assert off == pytest.approx(share * np.abs(fine).max(), rel=0.1), (key, count)


def stiffer(clearance, modulus):
    """How far a mechanism runs in a turn from the one whose coupler is rigid, rad."""
    rigid = jp.catalog.chunmei2002(clearance=clearance, gear_ratio=3.0)
    stiff = bending(rigid, {"coupler": jp.Beam(modulus=modulus, damping_ratio=0.05)})
    one, other = (jp.simulate(m, turns=1, rtol=1e-10, record=WORDS[:2]) for m in (rigid, stiff))
    assert other.status == 0
    return float(np.abs(one.angle - other.angle).max())


@pytest.mark.nightly
def test_a_stiff_link_moves_as_a_rigid_one():
    """The difference falls as 1/E, with play; in a closed loop it is nothing but the start's."""
    far, near = (stiffer(2.9e-5, modulus) for modulus in (2.1e15, 2.1e17))
    assert near < 1e-9
    assert far / near == pytest.approx(100, rel=0.2)
    assert stiffer(0, 2.1e15) < 1e-10


def orders(words, **changes):
    """The paper's mechanism with both inertia terms, a turn in the steady state."""
    changes = {"elastic": ("coupler",), "gear_ratio": 3.0} | changes
    return [
        jp.simulate(
            jp.catalog.chunmei2002(order=order, **changes), turns=1, transient=5, rtol=1e-10, record=words
        )
        for order in ("consistent", "paper")
    ]


def apart(both, word, **part):
    """Largest difference in a turn, relative to the largest value."""
    one, other = (found[word].sel(**part).values for found in both)
    return np.abs(one - other).max() / np.abs(one).max()


def test_the_paper_s_inertia_terms_in_a_closed_loop():
    """Deflection differs by 8e-6, the force at A by 3.4e-5: not by nothing, and by no more."""
    both = orders(["deflection", "reaction"], clearance=0)
    assert 1e-6 < apart(both, "deflection", link="coupler") < 3e-5
    assert 1e-6 < apart(both, "reaction", pin="A") < 1e-4


@pytest.mark.nightly
def test_the_paper_s_inertia_terms_with_play():
    """Deflection differs by 2e-4, contact force by 2.5e-4, the force at A by 1e-3; same contacts."""
    both = orders(["deflection", "reaction", "normal_force"])
    assert list(both[0].event_kind) == list(both[1].event_kind)
    assert 1e-5 < apart(both, "deflection", link="coupler") < 2e-3
    assert 1e-5 < apart(both, "normal_force", joint="B") < 2e-3
    assert 1e-5 < apart(both, "reaction", pin="A") < 5e-3
