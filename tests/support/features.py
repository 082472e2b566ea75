"""Mechanisms put together from features: one level of each, with numbers drawn from a seed.

Levels are read from the tables of the program where it has one: drives, laws of contact and of friction,
kinds of study. `unfit` says which levels do not go together, and why; what it lets through is a valid
mechanism by construction. Tests of pairs and of transformations take their scenes from here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import jointplay as jp
from jointplay import catalog
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import FACTORS, LAWS
from jointplay.solver.mechanism.parts.drive import DRIVES
from tests.equations.test_groups import beside_a_group
from tests.support.linkages import altered, jointed

KINDS = tuple(each.model_fields["kind"].default for each in DRIVES)


@dataclass(frozen=True)
class Layout:
    """A linkage whose joints may have play: how it is made, and which of its parts features take.

    Parameters
    ----------
    make : callable
        Gives the mechanism without play.
    loose : tuple of str
        Joints with play.
    bends : str
        The link that bends, where one does.
    pulled : tuple of str and float
        Link and place at which forces act.
    """

    make: Any
    loose: tuple[str, ...]
    bends: str
    pulled: tuple[str, float]


def _group():
    plain = beside_a_group({"kind": "speed", "link": "crank", "speed": 30.0})
    return jointed(plain, clearance=0.0)


FOUR_BAR, SLIDER_CRANK = catalog.chunmei2002, catalog.slider_crank
LAYOUTS = {
    "four_bar": Layout(FOUR_BAR, (), "coupler", ("rocker", 0.1)),
    "slider_crank": Layout(SLIDER_CRANK, (), "rod", ("slider", 0.0)),
    "quick_return": Layout(catalog.quick_return, (), "rod", ("arm", 0.2)),
    "bearing": Layout(FOUR_BAR, ("B",), "coupler", ("rocker", 0.1)),
    "two_bearings": Layout(FOUR_BAR, ("B", "C"), "coupler", ("rocker", 0.1)),
    "crank_pin": Layout(SLIDER_CRANK, ("A",), "rod", ("slider", 0.0)),
    "slider_pin": Layout(SLIDER_CRANK, ("B",), "rod", ("slider", 0.0)),
    "guide": Layout(SLIDER_CRANK, ("G",), "rod", ("slider", 0.0)),
    "moving_guide": Layout(catalog.quick_return, ("S",), "rod", ("arm", 0.2)),
    "six_bar": Layout(catalog.watt, ("F",), "rod", ("output", 0.1)),
    "group": Layout(_group, ("F",), "left", ("slider", 0.0)),
}
GUIDES = ("guide", "moving_guide")
FOUR_BARS = ("four_bar", "bearing", "two_bearings")
STRETCHING = (
    "slider_crank",
    "quick_return",
    "four_bar",
    "bearing",
    "two_bearings",
    "slider_pin",
    "moving_guide",
)
OPEN = ("bearing", "crank_pin", "slider_pin")  # no loop is left closed, and angles alone place all links
LOADS = (
    "none",
    "tilted",
    "weights",
    "spring",
    "coil",
    "force_time",
    "force_angle",
    "torque_time",
    "torque_angle",
)
ROUND = tuple(name for name, law in LAWS.items() if "R" in law.joint)
TRANSIENT = tuple(each.model_fields["kind"].default for each in DRIVES if each.transient)
LEVELS = {
    "drive": ("none", *KINDS),
    "law": ("none", *LAWS, "kelvin_voigt_pushes"),
    "friction": ("none", *FRICTIONS),
    "joint": tuple(LAYOUTS),
    "load": LOADS,
    "elastic": ("rigid", "sine", "hermite", "stretching"),
    "analysis": ("response", "section", "gradient"),
    "way": ("single", "lanes"),
    "start": ("zero", "turned", "lower", "off_centre", "pressed"),
}
Choice = Mapping[str, str]


def unfit(c: Choice) -> str:
    """Why some of these levels do not go together; empty where they do."""
    return next((why for there, why in _rules(c) if there), "")


def _rules(c) -> Iterator[tuple[bool, str]]:
    joint, law, friction, drive = (c.get(name, "") for name in ("joint", "law", "friction", "drive"))
    load, start, analysis, way = (c.get(name, "") for name in ("load", "start", "analysis", "way"))
    ideal = joint in LAYOUTS and not LAYOUTS[joint].loose
    if joint and law:
        yield ideal != (law == "none"), "a law is of a joint with play, and each such joint has one"
        yield joint in GUIDES and law in ROUND, "a guide's faces are flat"
    if joint and friction:
        yield ideal and friction != "none", "an ideal joint does not rub"
    if law and friction:
        yield law == "none" and friction != "none", "an ideal joint does not rub"
        rigid = law in LAWS and LAWS[law].rigid
        yield rigid and friction not in ("none", "coulomb"), "in an instant only Coulomb's law has a meaning"
    if law and start:
        yield law == "none" and start in ("off_centre", "pressed"), "an ideal joint has no room"
        yield (
            law in LAWS and LAWS[law].rigid and start == "pressed",
            "rigid bodies are not pressed into another",
        )
    if joint and start:
        yield start == "lower" and joint not in FOUR_BARS, "a branch is one of a four-bar"
        yield (
            start in ("off_centre", "pressed") and joint not in OPEN,
            "in ideal loops links determine each other",
        )
    if joint and c.get("elastic") == "stretching":
        held = "what stretches hangs at its origin, and holds others by play or by a loop alone"
        yield joint not in STRETCHING, held
    if drive and analysis:
        yield drive in TRANSIENT and analysis == "gradient", "gradients count turns that are alike"
        yield (
            drive == "none" and analysis in ("section", "gradient"),
            "nothing turns the crank past a section",
        )
    if load and analysis:
        unlike = load in ("force_time", "torque_time")
        yield unlike and analysis == "gradient", "gradients count turns that are alike"
    if way == "lanes":
        yield analysis in ("response", "gradient"), "lanes make section points"
        yield drive not in ("", "motor", "torque", "speed"), "imposed_motion"
        yield law in LAWS and LAWS[law].rigid, "rigid_impacts"
        yield friction in FRICTIONS and FRICTIONS[friction].bristles is not None, "bristles"
        yield friction in FRICTIONS and not FRICTIONS[friction].rises, "falling_friction"
        yield ideal or law == "none", "no_clearance"
        yield joint == "group", "loop_groups"
        yield joint == "two_bearings" and c.get("elastic") == "stretching", "size"


@dataclass(frozen=True)
class Scene:
    """A mechanism, its start, and how long it is followed, s."""

    choice: Choice
    mechanism: jp.Mechanism
    initial: dict[str, Any]
    duration: float
    speed: float
    crank_angle: float
    numbers: dict[str, float] = field(default_factory=dict)


def contact(name: str, random: np.random.Generator) -> jp.Contact:
    """A law's record with drawn numbers."""
    share, at_least = random.uniform(0.55, 0.9), random.uniform(0.005, 0.02)
    if name.startswith("kelvin_voigt"):
        K, C = random.uniform(0.7, 1.5) * 1e7, random.uniform(100.0, 400.0)
        return jp.Contact(stiffness=K, damping=C, tension=name == "kelvin_voigt")
    law = LAWS[name]
    own = {key: each.trial for key, each in law.numbers.items() if each.usual is None}
    if "restitution" in law.numbers:
        own["restitution"] = share
    if "slowest" in law.numbers:
        own["slowest"] = at_least
    if "length" in law.numbers:
        own["length"] = random.uniform(0.01, 0.03)
    if "dissipation" in law.numbers:
        own["dissipation"] = random.uniform(0.1, 0.4)
    if name in (*FACTORS, "hertz", "hunt_crossley"):
        own["exponent"] = random.uniform(1.4, 1.6)
    numbers = {key: own.pop(key) for key in ("stiffness", "damping") if key in own}
    if "stiffness" in numbers:
        numbers["stiffness"] *= random.uniform(1.0, 3.0)
    return jp.Contact(law=name, parameters=own, **numbers)


def friction(name: str, random: np.random.Generator) -> jp.Friction | None:
    """A law of friction's record with drawn numbers."""
    if name == "none":
        return None
    law, f = FRICTIONS[name], random.uniform(0.05, 0.3)
    usual = {
        "velocity": random.uniform(0.02, 0.1),
        "full_velocity": random.uniform(0.15, 0.3),
        "static_coefficient": f * random.uniform(1.1, 1.6),
        "stribeck_velocity": random.uniform(0.1, 0.4),
        "exponent": 2.0,
        "bristle_stiffness": random.uniform(0.5, 2.0) * 1e4,
        "bristle_damping": random.uniform(0.5, 3.0),
    }
    own = {key: usual.get(key, x) for key, x in law.trial.items() if key in law.numbers}
    return jp.Friction(law=name, coefficient=f, viscous=random.uniform(0.0, 2.0), **own)


def _drive(name: str, link: str, random, speed: float):
    if name == "none":
        return None
    wave = [{"order": 1, "cosine": 0.03, "sine": -0.02}, {"order": 2, "sine": 0.02}]
    of = {"kind": name, "link": link}
    rows = {
        "motor": {
            "gear_ratio": 1.0,
            "efficiency": 0.8,
            "synchronous_speed": speed / 0.8,  # the no-load speed, as printed
            "rated_speed": 0.9 * speed / 0.8,
            "rated_torque": random.uniform(2.0, 6.0),
        },
        "speed": {"speed": speed},
        "torque": {"constant": random.uniform(0.3, 1.0), "harmonics": wave, "nominal_speed": speed},
        "cycle": {
            "constant": speed,
            "harmonics": [
                row | {k: 5 * speed * row[k] for k in ("cosine", "sine") if k in row} for row in wave
            ],
            "frequency": random.uniform(1.3, 2.2) * speed,
        },
        "profile": {"start": speed, "end": random.uniform(1.3, 1.8) * speed, "time": 2.0 / speed},
        "servo": {
            "stiffness": random.uniform(10.0, 30.0),
            "damping": random.uniform(0.3, 0.8),
            "speed": speed,
            "harmonics": wave,
            "frequency": random.uniform(0.8, 1.5) * speed,
            "where": {"weight": "0.5*cos(angle) + 0.1*sin(2*angle + t)"},
            "feedforward": "weight + 1e-3*wanted_acceleration/100 - 1e-3*angular_velocity",
            "nominal_speed": speed,
        },
    }
    return of | rows[name]


def _loaded(made, layout: Layout, name: str, random, speed: float) -> dict[str, Any]:
    """One kind of load, of a size that is felt."""
    crank = made.crank
    link, at = layout.pulled
    course = {"constant": random.uniform(2, 8), "harmonics": [{"order": 1, "cosine": 4.0, "sine": -2.0}]}
    twist = {"constant": 0.1, "harmonics": [{"order": 2, "sine": random.uniform(0.05, 0.2)}]}
    timed, turned = {"frequency": random.uniform(0.7, 1.4) * speed}, {"angle": crank}
    pull = {
        "name": "pull",
        "kind": "force",
        "on": {"link": link, "at": at},
        "direction": random.uniform(-3, 3),
    }
    turn = {"name": "turn", "kind": "torque", "link": link}
    if name == "tilted":
        return {"gravity_direction": random.uniform(-3, 3)}
    if name == "weights":
        point = {"at": made.link(crank).length * random.uniform(0.2, 0.9), "mass": random.uniform(0.05, 0.2)}
        links = [altered(x, masses=(point,)) if x.name == crank else x for x in made.links]
        return {"links": tuple(links)}
    if name == "spring":
        ends = {"from": {"link": link, "at": at}, "to": {"link": "ground", "point": (-0.07, -0.05)}}
        own = {
            "stiffness": random.uniform(300, 2000),
            "damping": 3.0,
            "free_length": random.uniform(0.02, 0.1),
        }
        return {"springs": ({"name": "spring", "kind": "extension", **ends, **own},)}
    if name == "coil":
        ends = {"from": crank, "to": "ground", "stiffness": random.uniform(0.3, 1.5), "damping": 0.01}
        return {"springs": ({"name": "coil", "kind": "torsion", **ends, "angle": random.uniform(-1, 1)},)}
    if name == "force_time":
        return {"loads": (pull | course | timed,)}
    if name == "force_angle":
        return {"loads": (pull | course | turned | {"fixed": "link"},)}
    if name == "torque_time":
        return {"loads": (turn | twist | timed,)}
    if name == "torque_angle":
        return {"loads": (turn | twist | turned,)}
    return {}


SOFT = 100.0  # what stretches is softer, so that its waves are slow enough for a program with explicit steps
BENDS = {
    "sine": {"shapes": "sine", "modes": 2},
    "hermite": {"shapes": "hermite", "elements": 1},
    "stretching": {"shapes": "sine", "modes": 1, "axial": True},
}


def scene(choice: Choice, seed: int) -> Scene:
    """Put a mechanism together; `unfit` says nothing of the choice."""
    random = np.random.default_rng([2026, seed])
    layout = LAYOUTS[choice["joint"]]
    plain = layout.make(clearance=0) if layout.make is not _group else _group()
    speed = random.uniform(25, 35) if choice["joint"] == "group" else random.uniform(60, 90)
    crank = plain.crank
    links = []
    for link in plain.links:
        m, e = random.uniform(0.8, 1.25), choice["elastic"]
        data = dict(link) | {"mass": link.mass * m, "inertia": link.inertia * m * random.uniform(1.0, 1.1)}
        if e != "rigid" and link.name == layout.bends:
            modulus = random.uniform(0.5, 2.0) * 7e10
            beam = {"damping_ratio": 0.01, **BENDS[e]}
            reach = _reach(plain, link.name)  # a link that bends ends where its last joint is
            light, second = (0.5, 1e-10) if reach < 0.3 else (0.1, 1e-8)
            softer = SOFT if e == "stretching" else 1.0
            beam |= {"modulus": modulus / softer, "second_moment": second * softer}
            beam |= {"area": light * data["mass"] / (7800.0 * reach)}
            data |= {"elastic": True, "beam": beam, "length": reach}
        links.append(type(link)(**data))
    clearance = random.uniform(0.8, 2.0) * 1e-4
    joints = []
    for joint in plain.joints:
        data = {"contact": None, "friction": None, "clearance": 0.0}
        if joint.name in layout.loose:
            rubs = friction(choice["friction"], random)
            data = {"contact": contact(choice["law"], random), "friction": rubs}
            if rubs and choice["law"] in LAWS and LAWS[choice["law"]].rigid:
                data["friction"] = rubs.model_copy(update={"viscous": 0.0})
            data["clearance"] = clearance * random.uniform(0.8, 1.2)
            if joint.prismatic:
                data |= {
                    "half_length": random.uniform(0.015, 0.025),
                    "half_height": random.uniform(0.008, 0.012),
                }
            else:
                data["radius"] = random.uniform(0.008, 0.016)
        joints.append(altered(joint, **data))
    base = {
        "links": tuple(links),
        "joints": tuple(joints),
        "drive": _drive(choice["drive"], crank, random, speed),
    }
    base |= {"gravity": random.uniform(8.0, 12.0)}
    made = altered(plain, **base)
    made = altered(made, **_loaded(made, layout, choice["load"], random, speed))
    angle = 0.0 if choice["start"] == "zero" else random.uniform(0.2, 0.9)
    if choice["start"] == "lower":
        made = altered(made, branch="lower")
    initial = _start(made, choice, angle, speed, random)
    angle = initial["angle"][crank] if "angle" in initial else angle
    share = 0.03 if choice["joint"] == "group" else random.uniform(0.04, 0.07)
    return Scene(dict(choice), made, initial, share * math.tau / speed, speed, angle)


def _reach(plain, name: str) -> float:
    """How far from its origin a link's joints reach, m."""
    pins = (pin for joint in plain.joints for pin in (joint.journal, joint.bearing))
    return max(pin.at for pin in pins if pin.link == name)


def _start(made, choice, angle, speed, random) -> dict[str, Any]:
    """The start by keywords of `simulate`."""
    from jointplay.solver.mechanism.start import start

    if choice["drive"] == "none":
        initial = {"crank_angle": angle, "crank_speed": speed}
    else:
        initial = {"crank_angle": angle} if choice["start"] != "zero" else {}
    if choice["start"] not in ("off_centre", "pressed"):
        return initial
    loose = made.joint(LAYOUTS[choice["joint"]].loose[0])
    state = start(made, initial)
    # turning the journal's link, or of a pin at its origin the other one, moves the joint open
    pin = loose.journal if loose.journal.at else loose.bearing
    moved, arm = pin.link, pin.at
    depth = {"off_centre": -0.3 * loose.clearance, "pressed": random.uniform(1e-6, 3e-6)}[choice["start"]]
    far = (loose.clearance + depth) / arm
    angles = {k: float(v) for k, v in state.angles.items()}
    speeds = {k: float(v) for k, v in state.speeds.items()}
    if made.drive and made.drive.imposed_speed is not None:
        speeds[made.crank] = made.drive.imposed_speed
    angles[moved] += far * (1 if random.random() < 0.5 else -1)
    return {"angle": angles, "angular_velocity": speeds}


def fits(choice: Choice) -> bool:
    """Whether all levels of a choice go together."""
    return not unfit(choice)


@cache
def pairs() -> dict[frozenset, str]:
    """Every pair of levels of two features, with why it does not go together, or nothing."""
    found = {}
    for one, other in itertools.combinations(LEVELS, 2):
        for a, b in itertools.product(LEVELS[one], LEVELS[other]):
            found[frozenset([(one, a), (other, b)])] = unfit({one: a, other: b})
    return found


def of(choice: Choice) -> set[frozenset]:
    """The pairs of levels that a choice has."""
    return {frozenset(pair) for pair in itertools.combinations(choice.items(), 2)}


def covering(seed: int = 5, tries: int = 20) -> list[dict[str, str]]:
    """Choices in which every pair that goes together occurs: greedily, each the best of some random ones.

    Each begins with a pair that is left, and takes feature after feature in a random order, of each the level
    that brings the most pairs that are left (Cohen, Dalal, Fredman and Patton 1997).
    """
    levels = [(name, level) for name in LEVELS for level in LEVELS[name]]
    own = {name: np.array([i for i, (n, _) in enumerate(levels) if n == name]) for name in LEVELS}
    table = pairs()
    fit = np.array(
        [[n != m and not table[frozenset([(n, a), (m, b)])] for m, b in levels] for n, a in levels]
    )
    left, random, found = fit.copy(), np.random.default_rng(seed), []
    while left.any():
        first = np.argwhere(left)
        drawn = [
            _grown(first[random.integers(len(first))], own, levels, fit, left, random) for _ in range(tries)
        ]
        best = max(
            (each for each in drawn if each), key=lambda each: left[np.ix_(each, each)].sum(), default=None
        )
        if best is None:
            raise RuntimeError(f"no scene can have a pair as {[levels[i] for i in first[0]]}")
        left[np.ix_(best, best)] = False
        of_best = dict(levels[i] for i in best)
        found.append({name: of_best[name] for name in LEVELS})
    return found


def _grown(begun, own, levels, fit, left, random) -> list[int] | None:
    """A choice with these two levels; None where the others that it was given leave no level of one."""
    chosen = list(begun)
    names = [name for name in LEVELS if name not in {levels[i][0] for i in chosen}]
    random.shuffle(names)
    for name in names:
        fitting = own[name][fit[np.ix_(own[name], chosen)].all(axis=1)]
        if not len(fitting):
            return None
        gains = left[np.ix_(fitting, chosen)].sum(axis=1) + 0.5 * random.random(len(fitting))
        chosen.append(int(fitting[gains.argmax()]))
    return None if unfit(dict(levels[i] for i in chosen)) else chosen
