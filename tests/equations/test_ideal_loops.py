"""Ideal loops and slides: accelerations, reactions, moments and torque against full coordinates."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.codegen import outputs
from jointplay.mechanism import catalog
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import Mechanism, MotorLine
from tests.support.full_coordinates import Full, Loose
from tests.support.plain import plain

NAMES = ("slider_crank", "watt", "stephenson", "quick_return")


def seen(mechanism, angle, speed=None):
    """Every quantity at a crank angle."""
    initial = {"crank_angle": angle} | ({} if speed is None else {"crank_speed": speed})
    model = assemble(mechanism, initial)
    functions = plain(model.structure)
    given = dict(zip(functions.STATE, [0.0, *model.state], strict=True))
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    found = outputs.evaluate(functions, functions.OUTPUTS, given)
    return {k: float(v) for k, v in found.items()}


def check(mechanism, angle, speed):
    same(Full(mechanism, angle, speed), seen(mechanism, angle, speed))


def same(full, found):
    """Both have the same speeds, accelerations, reactions and torque."""
    mechanism, (a, loads, torque) = full.mechanism, full.solve()
    place = full.closure.place
    scale = np.abs(a).max()
    for link in mechanism.links:
        at = place[link.name] + 2
        assert found[f"angular_velocity:{link.name}"] == pytest.approx(
            full.v[at], abs=1e-11 * np.abs(full.v).max()
        )
        assert found[f"angular_acceleration:{link.name}"] == pytest.approx(a[at], abs=1e-8 * scale)
    size = max(np.abs(load).max() for load in loads)
    for joint, load in zip(full.closure.mechanism.joints, loads, strict=True):
        x, y, moment = full.on_bearing(joint, load)
        assert found[f"reaction_x:{joint.name}"] == pytest.approx(x, abs=1e-8 * size)
        assert found[f"reaction_y:{joint.name}"] == pytest.approx(y, abs=1e-8 * size)
        if joint.prismatic:
            assert found[f"reaction_moment:{joint.name}"] == pytest.approx(moment, abs=1e-8 * size)
            s, ds = full.closure.slide(full.x, joint)
            assert found[f"slide_position:{joint.name}"] == pytest.approx(s, abs=1e-13)
            assert found[f"slide_velocity:{joint.name}"] == pytest.approx(ds @ full.v, abs=1e-11)
    if torque is not None:
        assert found["drive_torque"] == pytest.approx(torque, abs=1e-8 * size)


@pytest.mark.parametrize("name", NAMES)
def test_examples(name):
    mechanism = getattr(catalog, name)(clearance={}, gravity=9.8)
    for angle in (0.3, 1.9, 3.3, 5.1):
        check(mechanism, angle, mechanism.drive.speed)


def joint(name, journal, bearing, kind="revolute"):
    """A joint from two sides: link or point, distance along the link, direction."""

    def pin(side, at=0.0, direction=0.0):
        place = {"link": side, "at": at} if isinstance(side, str) else {"link": "ground", "point": side}
        return place | {"direction": direction}

    return {"name": name, "kind": kind, "journal": pin(*journal), "bearing": pin(*bearing)}


def linkage(joints, guess, drive=None):
    """Bars of one metre, mass centres off the middle."""
    names = dict.fromkeys(side["link"] for j in joints for side in (j["journal"], j["bearing"]))
    links = [
        {"name": k, "length": 1.0, "mass": 0.5 + 0.3 * i, "centre": 0.3 - 0.1 * i, "inertia": 0.4}
        for i, k in enumerate(name for name in names if name != "ground")
    ]
    drive = drive or {"kind": "speed", "link": "crank", "speed": 3.0}
    return Mechanism(links=links, joints=joints, drive=drive, gravity=9.8, guess=guess)


def turned(joints, swapped):
    """The same joints with journal and bearing exchanged where named."""
    return [
        j | {"journal": j["bearing"], "bearing": j["journal"]} if j["name"] in swapped else j for j in joints
    ]


CRANK = joint("O", ("crank",), ((0.0, 0.0),))
SCENES = {
    "inverted slider-crank, guide beside its pivot": (
        [
            CRANK,
            joint("A", ("crank", 0.3), ("block", 0.1)),
            joint("S", ("block", 0.2, 0.4), ("arm", 0.15, -0.3), "prismatic"),
            joint("C", ("arm", 0.05), ((0.8, 0.1),)),
        ],
        {"arm": 2.9},
    ),
    "slider-crank, guide inclined, pins beside the line": (
        [
            CRANK,
            joint("A", ("crank", 0.3), ("rod", 0.1)),
            joint("B", ("rod", 0.9), ("slider", 0.2)),
            joint("G", ("slider", 0.05, 1.1), ((0.2, 0.3), 0.0, 0.5), "prismatic"),
        ],
        {"rod": 0.5},
    ),
    "scotch yoke": (
        [
            CRANK,
            joint("A", ("crank", 0.3), ("block", 0.1)),
            joint("S", ("block", 0.0, 0.2), ("yoke", 0.3, 1.4), "prismatic"),
            joint("G", ("yoke", 0.0, 0.3), ((0.0, 0.1), 0.0, 0.1), "prismatic"),
        ],
        {},
    ),
    "rod between two sliders, one on the crank": (
        [
            CRANK,
            joint("S", ("block", 0.1, 0.3), ("crank", 0.2, 1.2), "prismatic"),
            joint("B", ("block", 0.3), ("slider", 0.2)),
            joint("G", ("slider", 0.05, 0.7), ((0.5, -0.2), 0.0, 0.2), "prismatic"),
        ],
        {},
    ),
    "slides on slides": (
        [
            CRANK,
            joint("A", ("crank", 0.2), ("rod", 0.0)),
            joint("B", ("rod", 0.8), ("slider", 0.0)),
            joint("G", ("slider", 0.0), ((0.0, 0.1),), "prismatic"),
            joint("S", ("sleeve", 0.1, 0.1), ("rod", 0.4, 0.2), "prismatic"),
            joint("C", ("sleeve", 0.3), ("lever", 0.9)),
            joint("D", ("lever", 0.0), ((0.4, -0.5),)),
            joint("T", ("ring", 0.2, 0.5), ("sleeve", 0.1, 0.9), "prismatic"),
            joint("E", ("ring", 0.5), ("bar", 0.9)),
            joint("F", ("bar", 0.0), ("slider", 0.2)),
        ],
        {"rod": 0.0, "lever": 1.5, "bar": 1.5},
    ),
}


@pytest.mark.parametrize("swapped", ["", "ACGDE", "SBTF", "OASBCGTDEF"])
@pytest.mark.parametrize("name", SCENES)
def test_every_dyad(name, swapped):
    joints, guess = SCENES[name]
    mechanism = linkage(turned(joints, swapped), guess)
    for angle in (-0.4, 0.5, 1.1):
        check(mechanism, angle, 3.0)


PLAY = [
    ("slider_crank", "O"),
    ("slider_crank", "A"),
    ("slider_crank", "B"),
    ("watt", "B"),
    ("stephenson", "B"),
    ("stephenson", "D"),
    ("quick_return", "C"),
]


@pytest.mark.parametrize("drive", ["speed", "motor"])
@pytest.mark.parametrize(("name", "loose"), PLAY)
def test_clearance_beside_ideal_loops(name, loose, drive):
    """At states out of the ideal mechanism's, in contact and slipping."""
    motor = MotorLine(
        link="crank", gear_ratio=3, efficiency=1, synchronous_speed=314, rated_speed=290, rated_torque=2
    )
    changes = {"friction": 0.3, "gravity": 9.8} | ({"drive": motor} if drive == "motor" else {})
    mechanism = getattr(catalog, name)(clearance={loose: 1e-4}, **changes)
    model = assemble(mechanism, {"crank_angle": 0.9})
    functions, random = plain(model.structure), np.random.default_rng(3)
    n = len(model.turning)
    state = model.state + np.r_[1e-3 * random.standard_normal(n), 0.5 * random.standard_normal(n)]
    given = dict(zip(functions.STATE, [0.0, *state], strict=True))
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    given |= {f"touch_{loose}": 1.0, f"slip_{loose}": 1.0, f"stick_{loose}": 0.0}
    found = {k: float(v) for k, v in outputs.evaluate(functions, functions.OUTPUTS, given).items()}
    contacts = {loose: [found[f"{word}_force:{loose}"] for word in ("normal", "tangential")]}
    assert all(contacts[loose])
    held = free(model, mechanism, functions.STATE[1:], state)
    same(Loose(mechanism, held, contacts), found)


def free(model, mechanism, names, state):
    """Values and speeds of the free coordinates."""
    n, found = len(model.turning), {}
    roots = [chain[0] for chain in model.structure.floats]
    for i, name in enumerate(names[:n]):
        word, _, rest = name.partition("_")
        if word == "theta":
            key = rest
        else:
            key = (None, rest) if word == "slide" else (roots[int(rest)], "xy".index(word))
        found[key] = state[i], state[n + i]
    if mechanism.drive.kind == "speed":
        found |= {"crank": (model.crank_angle, mechanism.drive.speed)}
    return found
