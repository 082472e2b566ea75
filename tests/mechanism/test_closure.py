"""The closed form against the closure itself, put back in as vectors."""

import math
from typing import get_args

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.base import Branch
from jointplay.solver.mechanism.loops.dyads import FourBar
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.records import ConstantSpeed, Joint, Link, Mechanism, Pin
from tests.support.wrong import problems_of

PAPER = catalog.chunmei2002()
angle = st.floats(-10, 10)
branch = st.sampled_from(get_args(Branch))
length = st.floats(0.05, 1.0)


def linkage(crank, coupler, rocker, pivot, origin=(0.0, 0.0), pins=None):
    """Build a four-bar in an odd order: journals and bearings mixed, its pins anywhere on the links."""
    spans, (one, two, three) = (crank, coupler, rocker), ("in", "rod", "out")
    near, far = zip(*(pins or [(0.0, span) for span in spans]), strict=True)
    sizes = zip((one, two, three), near, far, strict=True)
    links = [Link(name=name, length=max(a, b), mass=1, centre=0, inertia=1) for name, a, b in sizes]
    rods = (
        Joint(name="r", journal=Pin(link=three, at=far[2]), bearing=Pin(link=two, at=far[1])),
        Joint(name="p", journal=Pin(link="ground", point=origin), bearing=Pin(link=one, at=near[0])),
        Joint(name="s", journal=Pin(link=three, at=near[2]), bearing=Pin(link="ground", point=pivot)),
        Joint(name="q", journal=Pin(link=two, at=near[1]), bearing=Pin(link=one, at=far[0])),
    )
    return Mechanism(links=links[::-1], joints=rods, drive=ConstantSpeed(link=one, speed=2.0))


def place(mechanism, angles):
    """Give the place of the joint between coupler and rocker as reached from either side, as x + iy."""
    loop = FourBar.of(mechanism.joints, mechanism.crank)
    e = {name: complex(math.cos(t), math.sin(t)) for name, t in angles.items()}
    crank, coupler, rocker = loop.spans
    end = loop.origin + crank * e[loop.links[0]]
    return end + coupler * e[loop.links[1]], loop.pivot + rocker * e[loop.links[2]]


def crank_end(span, angle):
    return span * complex(math.cos(angle), math.sin(angle))


def gap(mechanism, angles):
    ahead, behind = place(mechanism, angles)
    return abs(ahead - behind)


@given(angle, branch)
def test_positions_close_the_loop_of_the_paper(crank_angle, branch):
    angles, *_ = ideal_state(PAPER, crank_angle, branch=branch)
    assert angles["crank"] == crank_angle
    assert gap(PAPER, angles) < 2e-15


@given(angle, branch)
def test_upper_is_above_the_ground_line(crank_angle, branch):
    angles, *_ = ideal_state(PAPER, crank_angle, branch=branch)
    assert (place(PAPER, angles)[0].imag > 0) == (branch == "upper")


@given(angle, branch, st.floats(-50, 50))
def test_speeds_are_the_derivative_of_the_angles(crank_angle, branch, speed):
    _, speeds, _ = ideal_state(PAPER, crank_angle, speed, branch)
    h = 1e-5
    after, before = (ideal_state(PAPER, crank_angle + d, branch=branch)[0] for d in (h, -h))
    for name in ("crank", "coupler", "rocker"):
        slope = math.remainder(after[name] - before[name], 2 * math.pi) / (2 * h)
        assert speeds[name] == pytest.approx(slope * speed, rel=1e-7, abs=1e-7 * (1 + abs(speed)))


@given(angle, branch, st.tuples(length, length, length), angle, length, st.floats(-1, 1), st.data())
def test_any_four_bar_with_any_names_and_pins(crank_angle, branch, spans, base, ground, x, data):
    pivot = (x + ground * math.cos(base), ground * math.sin(base))
    sides = (*spans, ground)
    assume(2 * max(sides) < 0.99 * sum(sides))
    shift = st.tuples(st.floats(0, 0.5), st.booleans())
    pins = [(s, s + span)[:: -1 if flip else 1] for span in spans for s, flip in [data.draw(shift)]]
    mechanism = linkage(*spans, pivot, (x, 0.0), pins)
    try:
        angles, speeds, _ = ideal_state(mechanism, crank_angle, 1.0, branch)
    except InputError:
        event("cannot close, or dead centre")
        flip = -1 if pins[0][0] > pins[0][1] else 1
        reach = abs(complex(*pivot) - x - flip * crank_end(spans[0], crank_angle))
        assert not abs(spans[1] - spans[2]) + 1e-9 < reach < spans[1] + spans[2] - 1e-9
        return
    assert gap(mechanism, angles) < 1e-9 * max(sides)  # near a dead centre half the digits go
    loop = FourBar.of(mechanism.joints, mechanism.crank)
    d, t, w = loop.spans, [angles[n] for n in loop.links], [speeds[n] for n in loop.links]
    velocity = [d[k] * w[k] * complex(-math.sin(t[k]), math.cos(t[k])) for k in range(3)]
    assert abs(velocity[0] + velocity[1] - velocity[2]) < 1e-9 * max(map(abs, velocity))


def test_both_branches_at_a_known_configuration():
    # A 3-4-5 triangle: the crank along the ground line leaves its end 5 from the pivot.
    mechanism = linkage(1.0, 4.0, 3.0, (6.0, 0.0))
    angles, speeds, _ = ideal_state(mechanism, 0.0)
    known = {"in": 0.0, "rod": math.atan2(3, 4), "out": math.pi - math.atan2(4, 3)}
    assert angles == pytest.approx(known, abs=1e-15)
    lower, *_ = ideal_state(mechanism, 0.0, branch="lower")
    assert lower == pytest.approx({name: -value for name, value in known.items()}, abs=1e-15)
    # The crank's end moves at 2 across; rod and rocker, at right angles, each take one component of it.
    assert speeds == pytest.approx({"in": 2.0, "rod": -2 * 0.8 / 4, "out": -2 * 0.6 / 3})


@given(angle, branch)
def test_mirror_image_left_to_right_keeps_the_branch(crank_angle, branch):
    here, there = linkage(0.03, 0.181, 0.1175, (0.2, 0.0)), linkage(0.03, 0.181, 0.1175, (-0.2, 0.0))
    angles, speeds, _ = ideal_state(here, crank_angle, 1.0, branch)
    mirrored, reversed_speeds, _ = ideal_state(there, math.pi - crank_angle, -1.0, branch)
    for name in angles:
        turn = math.remainder(mirrored[name] - (math.pi - angles[name]), 2 * math.pi)
        assert turn == pytest.approx(0, abs=1e-12)
        assert reversed_speeds[name] == pytest.approx(-speeds[name], abs=1e-12)


def test_defaults_come_from_the_mechanism():
    assert ideal_state(PAPER)[1]["crank"] == PAPER.drive.no_load_speed
    assert ideal_state(PAPER.replace(speed=-3.0))[1]["crank"] == -3.0
    assert set(ideal_state(PAPER.replace(drive=None))[1].values()) == {0.0}
    assert ideal_state(PAPER.replace(branch="lower"))[:2] == ideal_state(PAPER, branch="lower")[:2]
    assert list(ideal_state(linkage(1, 4, 3, (6, 0)))[0]) == ["out", "rod", "in"]


def test_clearance_does_not_matter():
    assert ideal_state(PAPER, 0.7)[:2] == ideal_state(PAPER.replace(clearance=0), 0.7)[:2]


def test_cannot_close_at_this_angle_says_where_it_can():
    rocking = linkage(0.5, 0.3, 0.3, (0.4, 0.0))
    problem = problems_of(ideal_state, rocking, 2.0)["crank_angle"]
    limit = math.acos((0.25 + 0.16 - 0.36) / 0.4)
    assert problem.given == 2.0
    assert f"between 0 and {limit:.6g} rad" in problem.expected
    ideal_state(rocking, limit - 1e-3)
    problems_of(ideal_state, rocking, limit + 1e-3)


@pytest.mark.parametrize("crank_angle", [math.acos(0.05 / 0.4), -math.acos(0.05 / 0.4)])
def test_dead_centre(crank_angle):
    problem = problems_of(ideal_state, linkage(0.5, 0.3, 0.3, (0.4, 0.0)), crank_angle)["crank_angle"]
    assert "dead centre" in problem.expected


def test_a_crank_end_on_the_rocker_pivot_is_a_dead_centre():
    assert (
        "dead centre"
        in problems_of(ideal_state, linkage(0.4, 0.3, 0.3, (0.4, 0.0)), 0.0)["crank_angle"].expected
    )


def test_every_wrong_argument_at_once():
    found = problems_of(ideal_state, PAPER, float("nan"), "fast", "uper")
    assert set(found) == {"crank_angle", "crank_speed", "branch"}
    assert "did you mean 'upper'?" in found["branch"].expected


def test_a_branch_is_that_of_a_four_bar_whose_crank_is_driven():
    arm = Link(name="arm", length=1, mass=1, inertia=1)
    hinge = Joint(name="O", journal=Pin(link="arm"), bearing=Pin(link="ground", point=(0, 0)))
    pendulum = Mechanism(links=(arm,), joints=(hinge,))
    assert ideal_state(pendulum, 0.3).angles == {"arm": 0.3}
    for other in (pendulum, PAPER.replace(drive=ConstantSpeed(link="coupler", speed=1))):
        found = problems_of(ideal_state, other, 0.3, 0.0, "upper")
        assert "of a four-bar only" in found["initial.branch"].expected
