"""Ten linkages that no page shows, of steel bars and common sizes, as a machine builder would bring them."""

import numpy as np

import jointplay as jp
from jointplay.solver.mechanism.catalog import presets
from jointplay.solver.mechanism.catalog.presets import fixed, four_bar_pins, on

STEEL = 7850.0  # kg/m³
USUAL = {"stiffness": 2e7, "damping": 600.0}  # N/m, N s/m


def linkage(lengths, section, pins, rpm, clearance, guides="", tip=None, guess=None, gravity=9.81, **laws):
    """A linkage of uniform bars (section in mm), whose crank turns at a constant speed; `tip` in kg."""
    width, thickness = section
    links = presets.bars(lengths, STEEL * width * thickness * 1e-6)
    if tip:
        links += (jp.Link(name="slider", length=0.02, mass=tip, centre=0.0, inertia=1e-4 * tip),)
    given = USUAL | {"radius": 0.008, "friction": 0.1} | laws
    law = jp.Contact(**given.pop("contact", USUAL))
    joints = presets.joined(pins, guides, **given)
    joints = tuple(joint.model_copy(update={"contact": law}) for joint in joints)
    drive = jp.ConstantSpeed(link="crank", speed=rpm * np.pi / 30)
    made = jp.Mechanism(links=links, joints=joints, drive=drive, gravity=gravity, guess=guess or {})
    return made.replace(clearance=clearance)


def crank_rocker(crank, coupler, rocker, ground, section, rpm, clearance, **laws):
    """Lengths in m."""
    pins = four_bar_pins(crank, coupler, rocker, ground)
    lengths = {"crank": crank, "coupler": coupler, "rocker": rocker}
    return linkage(lengths, section, pins, rpm, clearance, **laws)


def slider(crank, rod, offset, section, tip, rpm, clearance, **laws):
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", crank), on("rod")),
        "B": (on("rod", rod), on("slider")),
        "G": (on("slider"), fixed(0.0, offset)),
    }
    guess = {"crank": 0.0, "rod": float(np.arcsin(offset / rod))}
    return linkage({"crank": crank, "rod": rod}, section, pins, rpm, clearance, "G", tip, guess, **laws)


def watt(rpm, clearance):
    sizes = {"crank": 0.03, "coupler": 0.14, "rocker": 0.08, "arm": 0.11, "rod": 0.16, "output": 0.1}
    place = {"ground": 0.14, "pivot": 0.27, "density": 0.75, "speed": rpm * np.pi / 30}
    return jp.catalog.watt(**sizes, **place).replace(clearance=clearance)


def stephenson(rpm, clearance):
    sizes = {"crank": 0.035, "coupler": 0.11, "arm": 0.16, "rocker": 0.09, "rod": 0.15, "output": 0.12}
    place = {"ground": 0.12, "pivot": 0.21, "density": 0.75, "speed": rpm * np.pi / 30}
    return jp.catalog.stephenson(**sizes, **place).replace(clearance=clearance)


HEAVY = {"section": (25, 8), "rpm": 300, "clearance": {"B": 2e-4}, "friction": 0.02}
DRY = {"stiffness": 1e7, "damping": 100.0}
BOUNCING = {"law": "restitution", "parameters": {"restitution": 0.5}}
TEN = {
    "quiet crank-rocker": lambda: crank_rocker(0.025, 0.12, 0.06, 0.115, (16, 5), 120, {"B": 4e-5}),
    "rattling crank-rocker": lambda: crank_rocker(0.05, 0.18, 0.13, 0.2, (20, 6), 700, {"B": 2e-4}),
    "chaotic crank-rocker": lambda: crank_rocker(0.06, 0.14, 0.1, 0.15, **HEAVY, contact=DRY),
    "crank-rocker without friction": lambda: crank_rocker(
        0.03, 0.2, 0.08, 0.19, (12, 4), 240, {"C": 2.5e-5}, friction=0.0
    ),
    "crank-rocker with two plays": lambda: crank_rocker(
        0.035, 0.15, 0.07, 0.14, (16, 6), 500, {"A": 2e-5, "B": 3.5e-5}
    ),
    "slider with two plays": lambda: slider(0.04, 0.15, 0.0, (20, 8), 0.6, 900, {"A": 4e-5, "B": 2.5e-5}),
    "offset slider without friction": lambda: slider(
        0.03, 0.11, 0.012, (16, 6), 0.35, 600, {"B": 1.5e-4}, friction=0.0
    ),
    "rigid slider": lambda: slider(0.035, 0.12, 0.0, (18, 6), 0.5, 240, {"B": 2e-4}, contact=BOUNCING),
    "Watt": lambda: watt(300, {"B": 8e-5}),
    "Stephenson": lambda: stephenson(90, {"C": 1.2e-4}),
}
