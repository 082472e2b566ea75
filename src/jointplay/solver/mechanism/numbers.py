"""Values of every parameter of a structure: the tables of its chains, joints, beams, loops and drive."""

from __future__ import annotations

import math

from jointplay.solver.equations.structure import Linkage
from jointplay.solver.mechanism.loops.bases import Bases
from jointplay.solver.mechanism.loops.kinematic_chains import Forest, Place
from jointplay.solver.mechanism.loops.loop_numbers import loop_numbers
from jointplay.solver.mechanism.parts import actions, stretch
from jointplay.solver.mechanism.parts.beam import Link, modal
from jointplay.solver.mechanism.records import Joint, Mechanism


def numbers(mechanism: Mechanism, forest: Forest, structure: Linkage, bases: Bases) -> dict[str, float]:
    """Give the value of every parameter of a linkage's equations.

    Parameters
    ----------
    mechanism : Mechanism
        The linkage.
    forest : Forest
        The same, cut at its clearance joints.
    structure : Linkage
        Its structure.
    bases : Bases
        Its start.

    Returns
    -------
    dict of str to float
        By name, SI units; what is given from outside is 0.
    """
    links = forest.links
    values = {f"H_{k}_{m}": forest.inertia(k, m) for k, m in structure.couplings}
    values |= {f"mu_{k}": forest.moment(k, links) for k in links}
    values |= {f"m_{f}": sum(links[k].mass for k in chain) for f, chain in enumerate(structure.floats)}
    values |= {"g": mechanism.gravity} | actions.numbers(mechanism, forest)
    values |= {"up_x": -math.cos(mechanism.gravity_direction), "up_y": -math.sin(mechanism.gravity_direction)}
    for joint in mechanism.clearance_joints:
        values |= _joint(joint, forest)
    for pin in structure.pins:
        values[f"m_{pin.name}"] = sum(links[k].mass for k in pin.links)
        for chain, name in pin.bases:
            values[name] = sum(links[k].mass for k in pin.links if forest.places[k].chain == chain)
        values |= {f"mu_{pin.name}_{k}": forest.moment(k, pin.links) for k in pin.arms}
    for beam in structure.beams:
        values |= _beam(links[beam.link], forest.places[beam.link])
        values |= stretch.numbers(links[beam.link]) if beam.axial else {}
    values |= loop_numbers(forest, bases)
    angles = bases.state.angles
    return values | (mechanism.drive.numbers(angles[mechanism.drive.link]) if mechanism.drive else {})


def _joint(joint: Joint, forest: Forest) -> dict[str, float]:
    apart = forest.separation(joint)
    values = joint.numbers | dict(zip(("rx0", "ry0"), apart.fixed, strict=True))
    arms = {f"D_{joint.name}_{k}": arm for k, arm in apart.arms.items()}
    return {f"{word}_{joint.name}": value for word, value in values.items()} | arms


def _beam(link: Link, place: Place) -> dict[str, float]:
    """Modal numbers S, I, omega^2, 2 xi omega, end slopes, gauge; arms of the origin."""
    modes, xi = modal(link), link.beam.damping_ratio
    rows = {
        "S": modes.force,
        "I": modes.moment,
        "k": modes.frequency**2,
        "c": 2 * xi * modes.frequency,
        "start": modes.slope_start,
        "end": modes.slope_end,
        "gauge": modes.gauge,
        "rate": 0 * modes.frequency,
        "acc": 0 * modes.frequency,
    }
    values = {f"{word}_{link.name}_{i}": float(v) for word, row in rows.items() for i, v in enumerate(row)}
    return values | {f"L_{link.name}_{k}": arm for k, arm in place.arms.items()}
