"""A hundred scenes for derivatives in parameters: every law, drive, kind of joint and of own equations.

Each is a mechanism or a system, its start, and how long it is followed: turns of a linkage, time of a system.
Scenes of one structure differ in numbers and starts, and share compiled code.
"""

from __future__ import annotations

import tomllib
from functools import partial
from pathlib import Path

import jointplay as jp
from jointplay import catalog
from jointplay.solver.mechanism.catalog.presets import four_bar_pins
from jointplay.solver.mechanism.records import (
    Force,
    Harmonic,
    Link,
    Pin,
    PointMass,
    PrescribedTorque,
    SpeedCycle,
    SpeedProfile,
    Spring,
    Torque,
    TorsionSpring,
)
from jointplay.study.models import build_mechanism
from tests.analysis.test_rigid_bearing import rigid
from tests.equations.test_groups import beside_a_group
from tests.support.laws_grid import BEAM, FRICTION, NORMAL, PAIRS, mechanism
from tests.support.linkages import altered, bending, jointed

STUDIES = Path(__file__).parents[2] / "studies" / "own"
PLAY = {"clearance": 2.9e-4, "gear_ratio": 3.0}
FOUR_BAR, CRANK = catalog.chunmei2002, catalog.slider_crank


def written(name, **changes):
    """The system of a shipped study."""
    table = tomllib.loads((STUDIES / f"{name}.toml").read_text())["mechanism"]
    return build_mechanism(table).replace(**changes)


def own(**tables):
    """A system written here."""
    return jp.System(**tables)


OSCILLATOR = {"states": {"x": 1.0, "v": 0.0}, "parameters": {"k": 4.0, "c": 0.1}}
FORCED = {"states": {"x": 0.0, "v": 0.3}, "forcing": "2*pi/w"}
LAMP = {  # conducts from above on, until below off
    "states": {"u": 0.2, "i": 0.0},
    "parameters": {"source": 1.0, "above": 0.8, "below": 0.3, "draw": 2.0, "coil": 0.5},
    "rates": {"u": "source - i - draw*u*lit", "i": "(u - i)/coil"},
    "switches": [{"name": "lit", "on": "u - above", "off": "below - u"}],
}
CORNER = {  # a jump of the rate alone, at a line
    **OSCILLATOR,
    "parameters": {"k": 4.0, "c": 0.1, "edge": 0.2, "more": 3.0},
    "rates": {"x": "v", "v": "-k*x - c*v - more*beyond"},
    "switches": [{"name": "beyond", "on": "x - edge"}],
}
TWO_MASSES = {  # that meet each other and two stops, in a mass matrix that couples them
    "states": {"x": 0.1, "y": 0.5, "v": 1.0, "w": 0.2},
    "parameters": {"m": 1.3, "n": 0.7, "j": 0.2, "k": 20.0, "stop": 1.0, "r": 0.8},
    "rates": {"x": "v", "y": "w", "v": "-k*x", "w": "-k*y/2"},
    "mass": {"v": {"v": "m", "w": "j"}, "w": {"w": "n"}},
    "impacts": [
        {"name": "right", "gap": "stop - y", "restitution": "r"},
        {"name": "left", "gap": "x + stop/3", "restitution": "r"},
    ],
}
RESTING = {  # on a floor that a mixture of two coupled masses meets; they go on along it, and leave it
    **FORCED,
    "states": {"y": 0.5, "x": 0.2, "v": 0.0, "u": 0.3},
    "parameters": {"w": 1.0, "r": 0.5, "k": 3.0, "weight": 1.0, "floor": 0.05},
    "rates": {"y": "v", "x": "u", "v": "sin(w*t) - weight + k*(x - y)", "u": "k*(y - x) - u/5 - x"},
    "mass": {"v": {"v": 2, "u": "1/2"}, "u": {"u": 1}},
    "impacts": [{"name": "floor", "gap": "y + x/2 - floor", "restitution": "r"}],
}
PRESSED = {  # a contact whose force is a power, and depends on the time
    **FORCED,
    "parameters": {"w": 2.0, "k": 30.0, "c": 1.5, "at": 0.1, "reach": 0.02},
    "rates": {"x": "v", "v": "cos(w*t)"},
    "contacts": [
        {
            "name": "wall",
            "depth": "x - at - reach*sin(w*t)",
            "force": "k*depth*sqrt(depth**2 + 0.01) + c*speed",
        }
    ],
}
JUMP = {  # a kick at each passage, of a size that depends on the state
    "states": {"a": 0.0, "b": 1.0},
    "parameters": {"rate": 1.0, "gain": 0.4, "top": 1.1, "leak": 0.2},
    "rates": {"a": "rate + 0.1*b", "b": "-leak*b"},
    "jumps": [{"name": "fire", "guard": "top - a", "jump": {"a": "a - top + gain*b/10", "b": "b + gain*a"}}],
}
RUBBED = {  # dry friction with a normal force that depends on the state
    **FORCED,
    "parameters": {"w": 1.7, "f": 0.4, "g": 0.55, "load": 1.0, "k": 1.0},
    "rates": {"x": "v", "v": "1.5*cos(w*t) - k*x"},
    "friction": [
        {"name": "floor", "speed": "v", "normal": "load + 0.1*x**2", "coefficient": "f", "static": "g"}
    ],
}
SYSTEMS = {  # system, start, duration
    "pair_upper": (catalog.impact_pair(0.5, 0.8), (0.1, 0.3), 4.0),
    "pair_slow": (catalog.impact_pair(3.6, 0.8), (-1.8, 0.5), 12.0),
    "pair_dense": (catalog.impact_pair(0.2, 0.9), (0.05, 0.9), 2.0),
    "pair_dead": (catalog.impact_pair(1.4, 0.3), (0.3, 1.1), 5.0),
    "ball": (catalog.bouncing_ball(1.3, 0.5), (1.3, -1.0), 9.0),
    "ball_high": (catalog.bouncing_ball(3.0, 0.9), (4.0, 1.0), 30.0),
    "ball_low": (catalog.bouncing_ball(1.05, 0.5), (1.6, -1.5), 12.0),
    "soft": (catalog.soft_impact_pair(0.5, 50.0, 2.0), (0.1, 0.3), 4.0),
    "soft_hard": (catalog.soft_impact_pair(1.5, 5e3, 5.0), (0.1, 0.9), 5.0),
    "soft_undamped": (catalog.soft_impact_pair(0.8, 80.0, 1e-3), (0.0, 1.1), 6.0),
    "soft_pushes": (catalog.soft_impact_pair(0.5, 50.0, 2.0, tension=False), (0.1, 0.3), 4.0),
    "soft_pushes_hard": (catalog.soft_impact_pair(1.5, 5e3, 40.0, tension=False), (0.1, 0.9), 5.0),
    "gears": (catalog.gear_backlash(0.1, 0.2, 1.6, 0.05), (0.5, 0.1), 6.0),
    "gears_slow": (catalog.gear_backlash(0.1, 0.2, 0.9, 0.05), (1.2, -0.3), 12.0),
    "valve_open": (catalog.relief_valve(5.0), None, 3.0),
    "valve_chatters": (catalog.relief_valve(3.0), (0.5, 0.2, 10.0), 4.0),
    "lorenz": (catalog.lorenz(), None, 2.0),
    "rossler": (catalog.rossler(), None, 8.0),
    "jerk": (catalog.jerk(), None, 8.0),
    "duffing": (catalog.duffing(), None, 9.0),
    "block_on_belt": (written("stick_slip"), None, 4.0),
    "block_on_fast_belt": (written("stick_slip", belt=0.4, load=30.0), (0.02, 0.4), 5.0),
    "friction_chain": (written("friction_chain"), None, 1.0),
    "wheel": (written("rimless_wheel"), None, 6.0),
    "rocking": (written("rocking_block"), None, 3.0),
    "buck": (written("buck_converter"), None, 1.9e-3),
    "buck_chaotic": (written("buck_converter", source=32.0), None, 1.9e-3),
    "chua": (written("chua"), None, 6.0),
    "oscillator_stop": (written("impact_oscillator", distance=0.1), None, 9.0),
    "own_ball": (written("bouncing_ball"), (1.3, -0.5), 9.0),
    "own_gears": (written("gear_backlash"), None, 9.0),
    "own_valve": (written("relief_valve", flow=2.5), (0.1, -1.0, 10.0), 3.0),
    "lamp": (own(**LAMP), None, 6.0),
    "corner": (own(**CORNER), None, 5.0),
    "two_masses": (own(**TWO_MASSES), None, 3.0),
    "pressed": (own(**PRESSED), None, 6.0),
    "kicks": (own(**JUMP), None, 4.0),
    "rubbed": (own(**RUBBED), None, 8.0),
    "plastic_table": (catalog.bouncing_ball(1.5, 0.0), (1.5, 0.0), 9.0),
    "plastic_pair": (catalog.impact_pair(0.4, 0.0), (0.0, 1.3), 9.0),
    "rests": (own(**RESTING), None, 5.0),
    "rests_at_once": (own(**RESTING).replace(r=0.0), None, 5.0),
    "close_events": (own(**TWO_MASSES).replace(stop=0.999), (0.0, 0.6661, 0.5, 0.6), 3.0),
}


def remade(plain, contact=None, friction=None):
    """A mechanism with another law and friction in every joint."""
    return jointed(plain, friction=friction, **({"contact": contact} if contact else {}))


def bent(plain, **beams):
    """A mechanism with elastic links."""
    return bending(plain, beams, plain.order)


GENTLE = jp.Friction(law="tanh", coefficient=0.2, velocity=0.5)
WAVES = (Harmonic(order=1, cosine=8.0, sine=-3.0), Harmonic(order=3, sine=2.0))
SPRINGS = (
    Spring(
        name="long",
        **{"from": Pin(link="coupler", at=0.07)},
        to=Pin(link="ground", point=(0.1, -0.05)),
        stiffness=2000.0,
        damping=5.0,
        free_length=0.03,
    ),
    TorsionSpring(name="coil", **{"from": "rocker"}, to="coupler", stiffness=4.0, damping=0.02, angle=0.4),
)
LOADS = (
    Force(
        name="pull",
        on=Pin(link="coupler", at=0.1),
        direction=0.5,
        constant=4.0,
        harmonics=WAVES,
        frequency=90.0,
    ),
    Force(
        name="push",
        on=Pin(link="rocker", at=0.03),
        direction=1.2,
        fixed="link",
        harmonics=WAVES,
        angle="crank",
    ),
    Torque(name="twist", link="rocker", constant=0.2, harmonics=WAVES[1:], factor=0.3, angle="crank"),
)
TORQUE = PrescribedTorque(
    link="crank", constant=1.5, harmonics=(Harmonic(order=2, cosine=2.0),), nominal_speed=60.0
)
PROFILE = SpeedProfile(link="crank", start=20.0, end=90.0, time=0.05)
CYCLE = SpeedCycle(link="crank", constant=40.0, harmonics=(Harmonic(order=1, sine=6.0),), frequency=30.0)
SERVO = jp.Servo(
    link="crank",
    stiffness=20.0,
    damping=0.5,
    speed=40.0,
    harmonics=(Harmonic(order=2, cosine=0.1, sine=-0.05),),
    frequency=25.0,
    where={"weight": "1.5*cos(angle) + 0.2*sin(2*angle + t)"},
    feedforward="weight + 2e-3*wanted_acceleration - 1e-3*angular_velocity*tanh(wanted_angle - angle)",
    nominal_speed=40.0,
)
SOFT = jp.Beam(modulus=1e10, damping_ratio=0.01, shapes="sine", modes=2)
WEIGHTS = {"crank": (PointMass(at=-0.02, mass=0.3),), "rocker": (PointMass(at=0.05, mass=0.2),)}


def weighted(plain):
    """Point masses on crank and rocker."""
    links = (Link(**dict(link) | {"masses": WEIGHTS.get(link.name, ())}) for link in plain.links)
    return altered(plain, links=tuple(links))


def pinned(restitution, friction=0.0, speed=30.0, clearances=None):
    """A four-bar of bars of 1 kg, its bearings rigid: the journal at B comes to rest in a quarter turn."""
    lengths = {"crank": 0.04, "coupler": 0.12, "rocker": 0.08}
    links = [Link(name=k, length=v, mass=1.0, centre=v / 2, inertia=v * v / 3) for k, v in lengths.items()]
    pins = four_bar_pins(0.04, 0.12, 0.08, 0.12)
    rigid_law = jp.Contact(law="restitution", parameters={"restitution": restitution})
    rub = {"friction": jp.Friction(coefficient=friction)} if friction else {"friction": None}
    play = {"B": 1e-4} if clearances is None else clearances
    joints = [
        jp.Joint(
            name=k, journal=a, bearing=b, radius=0.01, contact=rigid_law, clearance=play.get(k, 0.0), **rub
        )
        for k, (a, b) in pins.items()
    ]
    drive = jp.ConstantSpeed(link="crank", speed=speed)
    return jp.Mechanism(name="pinned", links=links, joints=joints, drive=drive, gravity=9.8)


def law(normal, friction, **changes):
    """The four-bar under a normal law and a law of friction."""
    return lambda: mechanism("four_bar", normal, friction, False).replace(**changes)


FAST, SLOW = {"crank_angle": 0.3}, {"crank_angle": 2.0}
LINKAGES = {  # how it is made, start, turns
    **{f"{n}_{f}": (law(n, f), None, 0.07 if n == "restitution" else 0.3) for n, f in PAIRS},
    **{
        f"{n}_{f}_later": (law(n, f, clearance=1e-4), SLOW, 0.2)
        for n, f in PAIRS
        if n not in ("restitution", "liu")
    },
    "sticking": (partial(FOUR_BAR, friction=0.3, **PLAY), None, 0.4),
    "sticking_wide": (partial(FOUR_BAR, friction=0.1, clearance=1e-3, gear_ratio=3.0), FAST, 0.3),
    "sticking_fast": (partial(FOUR_BAR, friction=0.3, clearance=5e-5, gear_ratio=2.0), SLOW, 0.2),
    "pushes": (partial(FOUR_BAR, tension=False, **PLAY), None, 0.4),
    "pushes_later": (partial(FOUR_BAR, tension=False, clearance=1e-4, gear_ratio=5.0), SLOW, 0.2),
    "two_joints": (partial(FOUR_BAR, clearance={"B": 1e-4, "C": 2e-4}, gear_ratio=3.0), None, 0.3),
    "two_joints_later": (partial(FOUR_BAR, clearance={"B": 3e-4, "C": 5e-5}, gear_ratio=4.0), SLOW, 0.2),
    "three_joints": (partial(FOUR_BAR, clearance=dict.fromkeys("ABC", 1e-4), gear_ratio=3.0), None, 0.2),
    "constant_speed": (partial(FOUR_BAR, clearance=2.9e-4, speed=80.0), None, 0.5),
    "backwards": (partial(FOUR_BAR, clearance=2.9e-4, speed=-80.0), FAST, 0.4),
    "elastic": (lambda: bent(FOUR_BAR(**PLAY), coupler=BEAM), None, 0.15),
    "elastic_soft": (lambda: bent(FOUR_BAR(clearance=1e-4, gear_ratio=4.0), coupler=BEAM), SLOW, 0.1),
    "elastic_two": (
        lambda: bent(FOUR_BAR(clearance=2.9e-4, speed=80.0), coupler=SOFT, rocker=BEAM),
        None,
        0.1,
    ),
    "elastic_ideal": (lambda: bent(FOUR_BAR(clearance=0, speed=80.0), coupler=SOFT), None, 0.15),
    "stretching": (catalog.ivp_crank, None, 0.05),
    "rigid_bearing": (partial(rigid, 0.8), None, 0.12),
    "rigid_bearing_lossy": (partial(rigid, 0.5, 5e-4), FAST, 0.0665),
    "ideal": (partial(FOUR_BAR, clearance=0), None, 0.5),
    "watt": (catalog.watt, None, 0.3),
    "stephenson_play": (partial(catalog.stephenson, clearance={"B": 1e-4}), None, 0.2),
    "slider_crank": (partial(CRANK, clearance=1e-4), None, 0.3),
    "slider_crank_offset": (partial(CRANK, clearance=1e-4, offset=0.02, gravity=9.8), SLOW, 0.3),
    "slider_crank_two": (partial(CRANK, clearance={"A": 1e-4, "B": 5e-5}, gravity=9.8), None, 0.2),
    "guide": (lambda: remade(CRANK(clearance={"G": 1e-4}, gravity=9.8), friction=GENTLE), FAST, 0.2),
    "guide_turned": (
        *(lambda: remade(CRANK(clearance={"G": 2e-4}, gravity=9.8, offset=0.01), friction=GENTLE), SLOW, 0.2),
    ),
    "moving_guide": (
        *(lambda: remade(catalog.quick_return(clearance={"S": 1e-4}), friction=GENTLE), FAST, 0.1),
    ),
    "springs": (lambda: FOUR_BAR(springs=SPRINGS, gravity_direction=0.4, **PLAY), None, 0.3),
    "springs_later": (lambda: FOUR_BAR(springs=SPRINGS, clearance=1e-4, gear_ratio=4.0), SLOW, 0.2),
    "loads": (lambda: FOUR_BAR(loads=LOADS, **PLAY), None, 0.3),
    "torque": (lambda: FOUR_BAR(clearance=2.9e-4, drive=TORQUE), None, 0.3),
    "profile": (lambda: FOUR_BAR(clearance=2.9e-4, drive=PROFILE), None, 0.4),
    "cycle": (lambda: FOUR_BAR(clearance=2.9e-4, drive=CYCLE), None, 0.4),
    "servo": (
        lambda: FOUR_BAR(clearance=2.9e-4, drive=SERVO),
        {"crank_angle": 0.2, "crank_speed": 45.0},
        0.4,
    ),
    "group": (lambda: beside_a_group({"kind": "speed", "link": "crank", "speed": 30.0}), None, 0.3),
    "weights": (lambda: weighted(FOUR_BAR(gravity_direction=0.4, **PLAY)), None, 0.3),
    "siconos": (
        partial(catalog.siconos_four_bar, clearance=5e-3, restitution=None, drive=None),
        {"crank_angle": 0.2, "crank_speed": 10.0},
        0.2,
    ),
    **{
        f"rod_{n}_{f}": (
            lambda n=n, f=f: remade(CRANK(clearance=1e-4, gravity=9.81), NORMAL[n], FRICTION[f]),
            *(None, turns),
        )
        for n, f, turns in (
            ("hertz", "ambrosio", 0.12),  # without damping, each impact enlarges what rounding leaves
            ("flores", "coulomb", 0.25),
            ("hunt_crossley", "brown_mcphee", 0.25),
        )
    },
}
