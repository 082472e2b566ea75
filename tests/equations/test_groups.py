"""Loops that close by more than two links at a time: motion, forces and slopes against other programs."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops.kinematic_chains import Forest
from tests.support.multibody_records import from_mechanism
from tests.support.multibody_run import assemble as placed
from tests.support.plain import Point, plain

from ..codegen.test_jacobian import agree
from .test_ideal_loops import CRANK, check, joint, linkage, watched

PLATE = [  # a plate on three bars, one of them on the crank
    CRANK,
    joint("A", ("crank", 0.1), ("rod",)),
    joint("B", ("rod", 0.9), ("plate",)),
    joint("D", ("right", 0.7), ("plate", 0.8)),
    joint("Q", ("right",), ((1.4, 1.3),)),
]
BAR = [joint("C", ("left", 0.7), ("plate", 0.4)), joint("P", ("left",), ((0.9, 0.4),))]
GUIDE = [
    joint("C", ("left",), ("plate", 0.4)),
    joint("G", ("left", 0.0, 0.2), ((0.4, 0.9), 0.0, 0.8), "prismatic"),
]
SLEEVE = [  # a bar that slides in a link of the group
    joint("C", ("left", 0.2, 0.1), ("plate", 0.4, 1.9), "prismatic"),
    joint("P", ("left",), ((0.9, 0.4),)),
]
GUESS = {"rod": 1.57, "plate": 0.0, "left": 2.36, "right": -2.55}


def double_butterfly():
    """Three plates, three bars: each loop has five links, and none closes before all do."""
    at, joints, guess = {}, [CRANK], {}
    at["A"], at["C"], at["B"] = 0.1 + 0j, 1.1 + 0.1j, 0.6 + 1.3j  # ends of the crank and pivots on the ground
    for plate, start, angle, ends in (
        ("one", "A", 1.0, {"X": 0.5, "Y": 0.9}),
        ("two", "X", 0.4, {"Z": 0.4, "W": 0.8}),
        ("three", "C", 1.3, {"V": 0.4, "U": 0.8}),
    ):
        at |= {end: at[start] + arm * cmath.rect(1, angle) for end, arm in ends.items()}
        guess[plate] = angle
    for bar, start, end in (("b", "B", "Z"), ("d", "Y", "V"), ("f", "W", "U")):
        guess[bar] = cmath.phase(at[end] - at[start])
    long = {
        bar: abs(at[end] - at[start])
        for bar, start, end in (("b", "B", "Z"), ("d", "Y", "V"), ("f", "W", "U"))
    }
    joints += [
        joint("A", ("crank", 0.1), ("one",)),
        joint("X", ("one", 0.5), ("two",)),
        joint("B", ("b",), ((0.6, 1.3),)),
        joint("Z", ("b", long["b"]), ("two", 0.4)),
        joint("C", ("three",), ((1.1, 0.1),)),
        joint("Y", ("d",), ("one", 0.9)),
        joint("V", ("d", long["d"]), ("three", 0.4)),
        joint("W", ("f",), ("two", 0.8)),
        joint("U", ("f", long["f"]), ("three", 0.8)),
    ]
    return linkage(joints, guess)


def beside_a_group(drive):
    """The plate on three bars drives a slider by a rod, whose pin has clearance."""
    contact = {"law": "kelvin_voigt", "stiffness": 1e7, "damping": 500.0}
    loose = {"clearance": 1e-4, "radius": 0.02, "contact": contact, "friction": {"coefficient": 0.1}}
    more = [
        joint("E", ("right", 0.35), ("link",)),
        joint("F", ("link", 0.8), ("slider",)) | loose,
        joint("G", ("slider",), ((0.0, 1.6),), "prismatic"),
    ]
    return linkage([*PLATE, *BAR, *more], GUESS | {"link": 2.8}, drive)


SCENES = {
    "bars": lambda: linkage(PLATE + BAR, GUESS),
    "a slider": lambda: linkage(PLATE + GUIDE, {k: GUESS[k] for k in ("rod", "plate", "right")}),
    "a sleeve": lambda: linkage(PLATE + SLEEVE, {k: GUESS[k] for k in ("rod", "plate", "right")}),
    "double butterfly": double_butterfly,
}


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_a_group_against_full_coordinates(name):
    """Speeds, accelerations, reactions, moments, torque."""
    mechanism = SCENES[name]()
    ((_, unknowns),) = Forest.of(mechanism).cuts
    assert len(unknowns) == len(mechanism.links) - 1
    for angle in (-0.4, 0.1, 0.5):
        check(mechanism, angle)


def shifted(model, size, seed=2):
    """Its state with memories a little off."""
    random, n = np.random.default_rng(seed), len(model.state) - model.memories
    return model.state + np.r_[np.zeros(n), size * random.standard_normal(model.memories)]


def newton(angle):
    """Angles of the plate on three bars, by Newton's method on complex numbers."""
    A, P, Q = 0.1 * cmath.exp(1j * angle), 0.9 + 0.4j, 1.4 + 1.3j
    x = np.array([GUESS[k] for k in ("rod", "plate", "left", "right")])
    for _ in range(20):
        rod, plate, left, right = np.exp(1j * x)
        open_ = A + 0.9 * rod + 0.4 * plate - P - 0.7 * left, A + 0.9 * rod + 0.8 * plate - Q - 0.7 * right
        slope = 1j * np.array(
            [[0.9 * rod, 0.4 * plate, -0.7 * left, 0], [0.9 * rod, 0.8 * plate, 0, -0.7 * right]]
        )
        rows = np.concatenate([slope.real, slope.imag])
        x = x - np.linalg.solve(rows, np.r_[np.real(open_), np.imag(open_)])
    return x


@pytest.mark.nightly
def test_angles_over_a_turn_whatever_the_memories_are_near():
    """A memory that is off by some 1e-4 changes nothing but by rounding."""
    mechanism = SCENES["bars"]()
    for angle in np.linspace(-3.0, 3.0, 13):
        model = assemble(mechanism, {"crank_angle": angle})
        assert model.memories == 8
        for off in (0.0, 1e-4):
            found = quantities(model, shifted(model, off))
            x = [found[f"angle:{k}"] for k in ("rod", "plate", "left", "right")]
            assert x == pytest.approx(newton(angle), abs=1e-12)


def quantities(model, state):
    """Every output at a state."""
    functions = plain(model.structure)
    given = dict(zip(functions.STATE, [0.0, *state], strict=True))
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    return {k: float(v) for k, v in outputs.evaluate(functions, functions.OUTPUTS, given).items()}


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["bars", "a sleeve"])
def test_slopes_against_complex_steps(name):
    """Rates of the crank do not depend on memories, which decay to what they led to."""
    mechanism = SCENES[name]()
    mechanism = mechanism.replace(drive=None)
    model = assemble(mechanism, {"crank_angle": 0.4, "crank_speed": 2.0})
    functions, n = plain(model.structure), len(model.state)
    base = Point(functions, model.numbers, model.state, [], complex)

    def at(shift):
        return Point(functions, model.numbers, model.state + shift, [], complex)

    agree(at, n, 1e-10)
    J = base.jacobian().real
    assert np.all(J[0, 2:] == 0)
    assert np.allclose(J[1:, 2:], -settling(model) * np.eye(n - 2), atol=1e-12)


def settling(model):
    """Rate at which memories decay."""
    return dict(zip(plain(model.structure).PARAMETERS, model.numbers, strict=True))["settling"]


@pytest.mark.parametrize("speed", [pytest.param(0.5, marks=pytest.mark.long), 40.0])
def test_after_a_turn_nothing_is_left_of_what_memories_began_with(speed):
    """As slow or fast as it turns, since time has no other unit."""
    model = assemble(SCENES["bars"]().replace(drive=None), {"crank_angle": 0.4, "crank_speed": speed})
    assert math.exp(-settling(model) * math.tau / speed) < 1e-13


def test_reactions_to_a_billionth():
    """Against multipliers in full coordinates, without a difference in them."""
    mechanism = SCENES["bars"]()
    system = from_mechanism(mechanism, 0.7)
    y = placed(system, {"crank": 0.7} | GUESS)
    one, found = system.solve(0.0, y, []), watched(mechanism, 0.7)
    size = max(np.abs(force[:2]).max() for name, force in one.reactions.items() if name != "drive")
    for each in mechanism.joints:
        for word, mine in zip("xy", one.reactions[each.name], strict=False):
            assert found[f"reaction_{word}:{each.name}"] == pytest.approx(mine, abs=1e-9 * size)
    assert found["drive_torque"] == pytest.approx(-one.reactions["drive"][2], abs=1e-9 * size)


def test_what_does_not_close_is_no_number():
    """A memory far from any configuration."""
    model = assemble(SCENES["bars"](), {"crank_angle": 0.7})
    state = model.state.copy()
    state[2:] = [-1.0, 0.3, 0.2, 1.0, 0.9, 0.4, -0.3, 1.0]
    with np.errstate(invalid="ignore"):
        assert not np.isfinite(quantities(model, state)["angle:plate"])
