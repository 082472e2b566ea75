"""Motions that are known from another motion: mirror images, the ideal mechanism, more samples."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.parts.joints import Contact
from jointplay.solver.motion import guard_tolerances
from tests.support.linkages import jointed

WORDS = ["angle", "angular_velocity", "journal_x", "journal_y"]


def mirrored(speed):
    """The mechanism under a constant speed, and its image in the ground line."""
    upper = jp.catalog.chunmei2002(clearance=2.9e-4, speed=speed)
    return upper, upper.replace(speed=-speed, gravity=-upper.gravity, branch="lower")


@pytest.mark.long
def test_the_image_of_a_mechanism_moves_as_the_image_of_its_motion():
    found, image = (jp.simulate(m, duration=0.15, rtol=1e-11, record=WORDS) for m in mirrored(83.8))
    assert list(found.event_kind) == list(image.event_kind)
    assert image.event_time.values == pytest.approx(found.event_time.values, abs=1e-9)
    for word in ("angle", "angular_velocity", "journal_y"):
        scale = float(np.abs(found[word]).max())
        turns = (
            (found[word] + image[word]).values
            if word != "angle"
            else np.sin(found[word] + image[word]).values
        )
        assert np.abs(turns).max() < 1e-8 * scale
    assert np.abs(found.journal_x - image.journal_x).max() < 1e-9 * float(np.abs(found.journal_x).max()) * 10


def stiffer(clearance, stiffness):
    """The mechanism with a clearance, and contacts of a stiffness and damping in proportion."""
    plain = jp.catalog.chunmei2002(clearance=clearance, gear_ratio=3.0, friction=0)
    contact = Contact(stiffness=stiffness, damping=228.0 * math.sqrt(stiffness / 7.15e6))
    return jointed(plain, contact=contact)


def off(clearance, stiffness):
    """How far coupler and rocker run from the ideal mechanism at the same crank angle, rad."""
    mechanism = stiffer(clearance, stiffness)
    found = jp.simulate(mechanism, turns=1, rtol=1e-9, record=WORDS[:2], samples_per_turn=24)
    largest = 0.0
    for row in found.angle.values:
        angles, *_ = ideal_state(mechanism, crank_angle=float(row[0]))
        largest = max(largest, *(abs(row[k] - angles[name]) for k, name in ((1, "coupler"), (2, "rocker"))))
    return largest


def test_no_play_and_no_give_is_the_ideal_mechanism():
    """A quarter of the play and sixteen times the stiffness: less than a third as far off."""
    far = [off(2.9e-5 / 4**k, 7.15e6 * 16**k) for k in range(4)]
    assert all(later < earlier / 3 for earlier, later in itertools.pairwise(far))
    assert far[-1] < 2e-5


def test_sampling_does_not_change_the_motion():
    mechanism = jp.catalog.chunmei2002(gear_ratio=3.0)
    ends = []
    for samples in (1, 37, 5000):
        found = jp.simulate(mechanism, turns=2, rtol=1e-9, samples_per_turn=samples, record=WORDS[:2])
        ends.append(np.concatenate([found.angle.values[-1], found.angular_velocity.values[-1]]))
    assert np.array_equal(ends[0], ends[1])
    assert np.array_equal(ends[0], ends[2])


def test_samples_are_points_of_the_motion():
    """Between the integrator's points samples have an accuracy of their own: the collocation polynomial's."""
    mechanism = jp.catalog.chunmei2002(gear_ratio=3.0)
    coarse, fine = (
        jp.simulate(mechanism, turns=1, rtol=rtol, samples_per_turn=500, record=WORDS[:2])
        for rtol in (1e-9, 1e-13)
    )
    assert np.abs(coarse.angle - fine.angle).max() < 1e-7
    assert np.abs(coarse.angular_velocity - fine.angular_velocity).max() < 1e-6 * 83.8


def test_a_transient_is_dropped_and_nothing_else():
    mechanism = jp.catalog.chunmei2002(gear_ratio=3.0)
    whole = jp.simulate(mechanism, turns=3, rtol=1e-9, samples_per_turn=40, record=WORDS)
    late = jp.simulate(mechanism, turns=1, transient=2, rtol=1e-9, samples_per_turn=40, record=WORDS)
    assert late.time.values == pytest.approx(whole.time.values[80:], rel=1e-13)
    assert late.angle.values == pytest.approx(whole.angle.values[80:], rel=1e-12)
    after = whole.event_time >= 2 * 0.075
    assert np.array_equal(late.event_time, whole.event_time[after])


def test_a_linkage_near_rest_has_the_rounding_of_its_nominal_speed():
    """It will soon be as fast as that."""
    mechanism = jp.catalog.chunmei2002()
    nominal = abs(mechanism.drive.nominal_speed)
    slow, usual = (assemble(mechanism, {"crank_speed": speed}) for speed in (1e-3, nominal))
    fastest = np.abs(usual.state[len(usual.turning) :][usual.turning > 0]).max()
    ratio = guard_tolerances._rounding(slow) / guard_tolerances._rounding(usual)
    assert ratio == pytest.approx(nominal / fastest)
