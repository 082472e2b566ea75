"""Ideal loops and slides: accelerations, reactions, moments and torque against free bodies."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.records import Mechanism, MotorLine
from tests.support.motion import seen
from tests.support.multibody_records import at_state, marker, started
from tests.support.plain import Point, plain

NAMES = ("slider_crank", "watt", "stephenson", "quick_return")


def watched(mechanism, angle, speed=None):
    """Every quantity at a crank angle."""
    initial = {"crank_angle": angle} | ({} if speed is None else {"crank_speed": speed})
    model = assemble(mechanism, initial)
    return seen(model, model.state)


def check(mechanism, angle):
    system, y = started(mechanism, angle)
    same(mechanism, system.solve(0.0, y, []), watched(mechanism, angle))


def same(mechanism, solved, found):
    """Both have the same speeds, accelerations, reactions and torque."""
    now, held = solved.now, solved.reactions
    fastest, scale = (np.abs(values).max() for values in (now.v, solved.acceleration))
    for name, i in now.at.items():
        assert found[f"angular_velocity:{name}"] == pytest.approx(now.v[i + 2], abs=1e-11 * fastest)
        acceleration = solved.acceleration[i + 2]
        assert found[f"angular_acceleration:{name}"] == pytest.approx(acceleration, abs=1e-8 * scale)
    size = max(np.abs(force).max() for force in held.values())
    for joint in (joint for joint in mechanism.joints if joint.ideal):
        force = [found[f"reaction_{axis}:{joint.name}"] for axis in "xy"]
        assert force == pytest.approx(held[joint.name][:2], abs=1e-8 * size)
        if joint.prismatic:
            moment = held[joint.name][2]
            assert found[f"reaction_moment:{joint.name}"] == pytest.approx(moment, abs=1e-8 * size)
            along = now.along(marker(joint.journal), marker(joint.bearing))
            assert found[f"slide_position:{joint.name}"] == pytest.approx(along.slide, abs=1e-13)
            assert found[f"slide_velocity:{joint.name}"] == pytest.approx(along.slide_rate, abs=1e-11)
    if "drive" in held:
        assert found["drive_torque"] == pytest.approx(-held["drive"][2], abs=1e-8 * size)


TURN = np.linspace(-3.0, 3.2, 13)
SLOW = pytest.mark.nightly


def within(found, expected):
    """Equal to 1e-12 of the largest."""
    assert np.abs(np.subtract(found, expected)).max() < 1e-12 * np.abs(expected).max()


def test_slider_crank_in_closed_form():
    """Offset slider-crank over a turn: positions, speeds and accelerations of rod and slider."""
    r, l, h, w = 0.05, 0.12, 0.013, 200.0
    mechanism = catalog.slider_crank(crank=r, rod=l, offset=h, clearance=0, speed=w)
    found = [watched(mechanism, angle) for angle in TURN]
    sine = (h - r * np.sin(TURN)) / l
    cosine = np.sqrt(1 - sine**2)
    turning = -r * w * np.cos(TURN) / (l * cosine)
    bend = (r * w**2 * np.sin(TURN) + l * sine * turning**2) / (l * cosine)
    sliding = {
        "slide_position:G": r * np.cos(TURN) + l * cosine,
        "slide_velocity:G": -r * w * np.sin(TURN) - l * sine * turning,
        "angle:rod": np.arcsin(sine),
        "angular_velocity:rod": turning,
        "angular_acceleration:rod": bend,
    }
    for word, expected in sliding.items():
        within([each[word] for each in found], expected)


@pytest.mark.nightly
def test_quick_return_in_closed_form():
    """Arm of the crank shaper over a turn."""
    r, p, w = 0.05, 0.12, 20.0
    found = [watched(catalog.quick_return(crank=r, pivot=p), angle) for angle in TURN]
    x, y = r * np.cos(TURN), p + r * np.sin(TURN)
    d2, vx, vy = x**2 + y**2, -r * w * np.sin(TURN), r * w * np.cos(TURN)
    turning = (x * vy - y * vx) / d2
    bend = (-x * w**2 * (y - p) + y * w**2 * x - 2 * turning * (x * vx + y * vy)) / d2
    within([each["angle:arm"] for each in found], np.arctan2(y, x))
    within([abs(each["slide_position:S"]) for each in found], np.sqrt(d2))
    within([each["angular_velocity:arm"] for each in found], turning)
    within([each["angular_acceleration:arm"] for each in found], bend)


def circles(P, Q, one, two, side):
    """Where circles about P and Q meet, on the left of the way from P to Q or on the right."""
    d = abs(Q - P)
    along = (d**2 + one**2 - two**2) / (2 * d)
    return P + (Q - P) / d * (along + 1j * side * np.sqrt(one**2 - along**2))


@pytest.mark.parametrize("name", ["watt", "stephenson"])
def test_six_bars_in_closed_form(name):
    """Angles over a turn by meeting circles; speeds and accelerations by complex vector loops."""
    mechanism, w = getattr(catalog, name)(), 50.0
    at = {joint.name: joint.journal.at or joint.bearing.at for joint in mechanism.joints}
    long = {link.name: link.length for link in mechanism.links}
    coupler, rocker = at["B"], mechanism.joint("B").bearing.at
    C, F = (complex(*mechanism.joint(k).bearing.point) for k in "CF")
    found = [watched(mechanism, angle) for angle in TURN]
    A = long["crank"] * np.exp(1j * TURN)
    B = circles(A, C, coupler, rocker, 1)
    u = {"coupler": (B - A) / coupler, "rocker": (B - C) / rocker}
    near, base = ("rocker", C) if name == "watt" else ("coupler", A)
    D = base + long[near] * u[near]
    E = circles(D, F, long["rod"], long["output"], 1)
    u |= {"rod": (E - D) / long["rod"], "output": (E - F) / long["output"]}
    speed, bend = {"crank": w + 0 * TURN}, {"crank": 0 * TURN}
    u["crank"] = np.exp(1j * TURN)

    def close(known, one, two):
        """Solve sum a_k u_k = const, differentiated once and twice, for the last two."""
        (p, a), (q, b) = one, two
        K = sum(c * 1j * u[k] * speed[k] for k, c in known)
        for rates in (speed, bend):
            if rates is bend:
                K = sum(c * u[k] * (1j * bend[k] - speed[k] ** 2) for k, c in known)
                K = K - a * u[p] * speed[p] ** 2 - b * u[q] * speed[q] ** 2
            det = a * b * (np.conj(u[p]) * u[q]).imag
            x, y = 1j * a * u[p], 1j * b * u[q]
            rates[p] = -(np.conj(K) * y).imag / det
            rates[q] = -(np.conj(x) * K).imag / det

    close([("crank", long["crank"])], ("coupler", coupler), ("rocker", -rocker))
    start = (
        [("rocker", long["rocker"])]
        if name == "watt"
        else [("crank", long["crank"]), ("coupler", long["coupler"])]
    )
    close(start, ("rod", long["rod"]), ("output", -long["output"]))
    for k in long:
        within([np.exp(1j * each[f"angle:{k}"]) for each in found], u[k])
        within([each[f"angular_velocity:{k}"] for each in found], speed[k])
        if k != "crank":
            within([each[f"angular_acceleration:{k}"] for each in found], bend[k])


@pytest.mark.nightly
@pytest.mark.parametrize("name", NAMES)
def test_examples(name):
    mechanism = getattr(catalog, name)(clearance={}, gravity=9.8)
    for angle in (0.3, 1.9, 3.3, 5.1):
        check(mechanism, angle)


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


@pytest.mark.nightly
@pytest.mark.parametrize(
    "swapped", ["ACGDE", *(pytest.param(one, marks=SLOW) for one in ("", "SBTF", "OASBCGTDEF"))]
)
@pytest.mark.parametrize("name", SCENES)
def test_every_dyad(name, swapped):
    joints, guess = SCENES[name]
    mechanism = linkage(turned(joints, swapped), guess)
    for angle in (-0.4, 0.5, 1.1):
        check(mechanism, angle)


PLAY = [
    ("slider_crank", "O"),
    ("slider_crank", "A"),
    ("slider_crank", "B"),
    ("watt", "B"),
    ("stephenson", "B"),
    ("stephenson", "D"),
    ("quick_return", "C"),
]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "loose", "drive"),
    [(*play, drive) for play in PLAY for drive in ("speed", "motor")],
)
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
    system, y = at_state(mechanism, model, state)
    solved = system.solve(0.0, y, ["slip+"])
    forces = np.array(solved.touches[0][2:])
    assert all(forces)
    ours = [found[f"{word}_force:{loose}"] for word in ("normal", "tangential")]
    assert ours == pytest.approx(forces, abs=1e-10 * np.abs(forces).max())
    same(mechanism, solved, found)


@pytest.mark.parametrize(
    ("name", "loose"), [("slider_crank", "B"), pytest.param("stephenson", "D", marks=SLOW)]
)
def test_the_sliding_speed_s_rate(name, loose):
    """What decides on sticking, against the difference of the sliding speed along the flow."""
    model = assemble(getattr(catalog, name)(clearance={loose: 1e-4}), {"crank_angle": 0.9})
    functions, random, n = plain(model.structure), np.random.default_rng(1), len(model.turning)
    state = model.state + np.r_[1e-3 * random.standard_normal(n), 0.3 * random.standard_normal(n)]

    def at(h):
        place = state + h * np.r_[state[n:], rate]
        return Point(functions, model.numbers, place, ["slip+"], t=h).contacts()[0]

    rate = Point(functions, model.numbers, state, ["slip+"]).rate()[:, 0]
    assert at(0.0)[5] == pytest.approx((at(1e-7)[2] - at(-1e-7)[2]) / 2e-7, rel=1e-5)
