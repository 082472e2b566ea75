"""Make flexible_truth.json: motions of the stored scenes of bending links, with what each is worth.

Run as ``python -m tests.reference.make_flexible_truth [scene ...]`` from the root of the repository; fifteen
to twenty minutes for all on an idle core. Origin of every number:

- times (s), and at each of them angle, angular_velocity, angular_acceleration, deflection (of the links'
  middles, m), by link in the order crank, coupler, rocker; journal (r, m, by joint with play), reaction
  (force on the bearing, N, x and y, by joint), energy (J); event (time, joint, kind, v_n, v_t): the particles
  of ``flexible.py`` integrated by scipy's DOP853, events located by integration up to them. Its rtol is
  1e-13 where nothing bends, 1e-11 where no joint has play, 1e-10 elsewhere: there the rounding of a
  penetration, times K, shakes the slopes at the journal above what less would ask for. Where a mode is
  damped critically, which is stiff: SUNDIALS' BDF at rtol 1e-12.
- differs.loose: how far the same at 100 times the tolerance is from it.
- differs.CVODE: how far SUNDIALS' BDF at rtol 1e-11 is from it; differs.LSODA: scipy's LSODA at 1e-10.

Differences are maxima over all times: of deflections and reactions relative to the largest of the same link
or joint, of angles in rad, of speeds in units of a/b, of event times in nominal turns. Only those stored
for ``ideal_all`` are relative to the largest of all links or joints, so they say nothing of its crank, whose
deflection is the smallest by far; there CVODE at rtol 1e-11 takes longer than eight minutes.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from .flexible_scenes import SCENES
from .flexible_twin import bdf, follow, sample

PATH = Path(__file__).with_name("flexible_truth.json")
KEYS = ("angle", "angular_velocity", "angular_acceleration", "deflection", "journal", "reaction", "energy")


def changes(record):
    """The fields that differ from the record's defaults."""
    default = vars(type(record)())
    return {name: value for name, value in vars(record).items() if value != default[name]}


def column(scene, motion):
    """Samples of a motion, one list over time a quantity (and joint)."""
    rows = [sample(motion, t, y) for t, y in zip(scene.times, motion.states, strict=True)]
    found = {}
    for key in KEYS:
        values = [row[key] for row in rows]
        by_joint = isinstance(values[0], dict)
        found[key] = {joint: [v[joint] for v in values] for joint in values[0]} if by_joint else values
    return found


def series(values):
    """Values over time of every link or joint."""
    return np.array(list(values.values())) if isinstance(values, dict) else np.transpose(values)


def apart(mine, other, w0, motions):
    """Largest differences of two sets of samples."""

    def largest(key, scale=None):
        pairs = zip(series(mine[key]), series(other[key]), strict=True)
        return float(max(np.max(np.abs(a - b)) / (scale or np.max(np.abs(a)) or 1.0) for a, b in pairs))

    times = ([event.time for event in motion.events] for motion in motions)
    late = np.max(np.abs(np.subtract(*times)), initial=0.0) * w0 / (2 * np.pi)
    found = {
        "angle": largest("angle", 1.0),
        "speed": largest("angular_velocity", w0),
        "deflection": largest("deflection"),
        "reaction": largest("reaction"),
        "event": float(late),
    }
    return {key: float(f"{value:.1e}") for key, value in found.items()}


def ways(scene):
    """Method and rtol of the stored motion, of a looser one and of another integrator."""
    if any(beam.xi >= 1 for beam in scene.beams.values()):
        return {"truth": (bdf, 1e-12), "loose": (bdf, 1e-10), "LSODA": ("LSODA", 1e-10)}
    rtol = 1e-10 if scene.clearance else 1e-11 if scene.beams else 1e-13
    return {"truth": ("DOP853", rtol), "loose": ("DOP853", 100 * rtol), "CVODE": (bdf, 1e-11)}


def record(scene):
    """Everything stored of one scene."""
    p = scene.parameters
    motions = {name: follow(scene, *way) for name, way in ways(scene).items()}
    truth = motions.pop("truth")
    stored = column(scene, truth)
    differs = {}
    for name, other in motions.items():
        if [(e.joint, e.kind) for e in other.events] != [(e.joint, e.kind) for e in truth.events]:
            raise RuntimeError(f"{name} finds other events")
        differs[name] = apart(stored, column(scene, other), p.w0, (truth, other))
    return {
        "parameters": changes(p),
        "clearance": scene.clearance,
        "beams": {link: vars(beam) for link, beam in scene.beams.items()},
        "order": scene.order,
        "differs": differs,
        "times": scene.times,
        **stored,
        "events": [[e.time, e.joint, e.kind, e.v_n, e.v_t] for e in truth.events],
    }


def write(truth):
    """One line a field, so that a change shows in a diff."""
    scenes = []
    for name, fields in truth.items():
        lines = ",\n".join(f'  "{key}": {json.dumps(value)}' for key, value in fields.items())
        scenes.append(f'"{name}": {{\n{lines}\n}}')
    origin = '{\n"origin": "made by make_flexible_truth.py, which says where each number comes from",\n'
    PATH.write_text(origin + ",\n".join(scenes) + "\n}\n")


def main(names):
    """Make the named scenes, or all, keeping what is stored of the others."""
    for name in names or SCENES:
        made = record(SCENES[name])
        print(name, made["differs"], len(made["events"]), "events", flush=True)
        stored = json.loads(PATH.read_text()) if PATH.exists() else {}
        stored[name] = made
        write({name: stored[name] for name in SCENES if name in stored})


if __name__ == "__main__":
    main(sys.argv[1:])
