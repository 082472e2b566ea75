"""The closed four-bar: one freedom beside the modes, against free bodies."""

from __future__ import annotations

import numpy as np
import pytest

from jointplay.solver.codegen import outputs
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay.solver.mechanism.parts.joints import Pin
from tests.support.linkages import mechanism
from tests.support.plain import plain

from ..reference.four_bar import ANGLES, LINKS, Parameters, scattered
from .both import accelerations, pair, point
from .test_bending import check_energies, check_reactions
from .test_outputs import evaluated

SCENES = [  # links that bend, drive, order
    ("", "motor", "consistent"),
    ("", "speed", "consistent"),
    ("coupler", "motor", "consistent"),
    ("crank coupler rocker", "motor", "consistent"),
    ("coupler rocker", "speed", "consistent"),
    ("crank rocker", "none", "consistent"),
    ("coupler rocker", "motor", "paper"),
]
IDS = ["_".join(model).replace(" ", "_").strip("_") for model in SCENES]
every_scene = pytest.mark.parametrize("model", SCENES, ids=IDS)


@every_scene
def test_accelerations(model):
    system, ours = pair("", *model)
    for seed in range(4):
        y = scattered(system, seed)
        theirs, found = accelerations(system, y, {}), point(system, ours, y, []).rate()
        assert np.abs(found - theirs[:, None]).max() < 1e-10 * max(1.0, np.abs(theirs).max())


@every_scene
def test_outputs(model):
    """Angles are those of the closed loop; reactions at all four pins, and the torque, the multipliers."""
    system, ours = pair("", *model)
    for seed in range(3):
        y = scattered(system, seed)
        solved, found = system.at_modes(y, {}), evaluated(system, ours, y, [])
        for word, values in (("angle", solved.now.q), ("angular_velocity", solved.now.v)):
            assert [found[f"{word}:{k}"] for k in LINKS[1:]] == pytest.approx(values[ANGLES[1:]], rel=1e-12)
        turning = solved.acceleration[ANGLES]
        scale = np.abs(turning).max()
        assert [found[f"angular_acceleration:{k}"] for k in LINKS] == pytest.approx(
            turning, abs=1e-10 * scale
        )
        check_reactions(system, y, solved, found)
        check_energies(system, y, found)


def seen(ideal, angle, speed):
    """Outputs at a crank angle and speed, links straight."""
    model = assemble(ideal, {"crank_angle": angle, "crank_speed": speed})
    functions = plain(model.structure)
    given = dict(zip(functions.STATE, [0.0, *model.state], strict=True))
    given |= dict(zip(functions.PARAMETERS, model.numbers, strict=True))
    return {k: float(v) for k, v in outputs.evaluate(functions, functions.OUTPUTS, given).items()}


def ideal(branch="upper", turned=(), bearings=False, origin=(0.0, 0.0)):
    """The table's mechanism, told in another way: links from their other end, journal and bearing exchanged.

    Mass centres are halfway, so that the moments of inertia are the same about either end.
    """
    plain_one = mechanism(Parameters(i=3.0), {}).replace(branch=branch)
    fields = {name: getattr(plain_one, name) for name in type(plain_one).model_fields}
    lengths = {link.name: link.length for link in plain_one.links}

    def pin(given):
        if given.link == "ground":
            return Pin(link="ground", point=origin) if given.point == (0.0, 0.0) else given
        return Pin(link=given.link, at=lengths[given.link] - given.at) if given.link in turned else given

    joints = []
    for joint in plain_one.joints:
        pair = (
            (pin(joint.bearing), pin(joint.journal)) if bearings else (pin(joint.journal), pin(joint.bearing))
        )
        joints.append(joint.model_copy(update=dict(zip(("journal", "bearing"), pair, strict=True))))
    return type(plain_one)(**fields | {"joints": tuple(joints)})


@pytest.mark.parametrize("turned", [(), ("coupler",), ("coupler", "rocker"), ("crank", "coupler", "rocker")])
@pytest.mark.parametrize("bearings", [False, True])
def test_the_same_mechanism_told_in_another_way(turned, bearings):
    """Half a turn more in the angles of turned links; forces on exchanged bearings the other way."""
    here, there = (
        seen(ideal(), 0.7, 60.0),
        seen(ideal(turned=turned, bearings=bearings), 0.7 + np.pi * ("crank" in turned), 60.0),
    )
    for k in LINKS:
        apart = there[f"angle:{k}"] - here[f"angle:{k}"] - np.pi * (k in turned)
        assert np.exp(1j * apart) == pytest.approx(1.0, abs=1e-12)
        for word in ("angular_velocity", "angular_acceleration"):
            assert there[f"{word}:{k}"] == pytest.approx(here[f"{word}:{k}"], rel=1e-11)
    for name in "OABC":
        for axis in "xy":
            expected = here[f"reaction_{axis}:{name}"] * (-1.0 if bearings else 1.0)
            assert there[f"reaction_{axis}:{name}"] == pytest.approx(expected, rel=1e-9)
    assert there["drive_torque"] == here["drive_torque"]
    for energy in ("kinetic_energy", "potential_energy"):
        assert there[energy] == pytest.approx(here[energy], rel=1e-12)


@pytest.mark.parametrize("branch", ["upper", "lower"])
@pytest.mark.parametrize("origin", [(0.0, 0.0), (0.05, -0.02)])
def test_the_motion_is_the_closure_s(branch, origin):
    """Against the mechanism's own closure, and the differences of its speeds."""
    four_bar = ideal(branch, origin=origin)
    for angle, speed in ((0.3, 70.0), (2.0, -30.0), (-1.2, 90.0)):
        found, acceleration = seen(four_bar, angle, speed), None
        angles, speeds, _ = ideal_state(four_bar, angle, speed)
        acceleration, step = found["angular_acceleration:crank"], 1e-6
        ahead, behind = (
            ideal_state(four_bar, angle + h * speed, speed + h * acceleration)[1] for h in (step, -step)
        )
        for k in LINKS:
            assert found[f"angle:{k}"] == pytest.approx(angles[k], abs=1e-13)
            assert found[f"angular_velocity:{k}"] == pytest.approx(speeds[k], rel=1e-12)
            assert found[f"angular_acceleration:{k}"] == pytest.approx(
                (ahead[k] - behind[k]) / (2 * step), rel=1e-6
            )
