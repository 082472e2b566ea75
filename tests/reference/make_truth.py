"""Make truth.json and flexible_truth.json: motions of the stored scenes, each by several integrators.

Run as ``python -m tests.reference.make_truth [scene ...]`` from the root of the repository; without names for
all, an hour or two. Origin of every number of the rigid scenes, in truth.json:

- angles, speeds, joints (r and its rate) and events: ``taylor.Series``, equations by virtual work in minimal
  coordinates, Taylor series in 80-bit numbers at their own rounding, events at roots of the series; stored
  as the nearest double.
- differs.taylor: how far the same series at a tolerance of 1e-17 ends from it.
- differs.DOP853: the bodies of ``four_bar.py`` in all coordinates, scipy's DOP853 at rtol 1e-13.
- differs.CVODE: their free coordinates through SUNDIALS' BDF at rtol 1e-13.
- growth: end difference over start difference, for a start moved by 1e-12 (1 rad, a/b) in a random direction.

Differences are maxima over the whole state in units of (1 rad, 1 m, a/b rad/s, a/b m/s).

Of those with links that bend, in flexible_truth.json:

- times (s), and at each of them angle, angular_velocity, angular_acceleration, deflection (of the links'
  middles, m), by link in the order crank, coupler, rocker; journal (r, m, by joint with play), reaction
  (force on the bearing, N, x and y, by joint), energy (J); event (time, joint, kind, v_n, v_t): the bodies of
  ``four_bar.py`` with rows of particles, by scipy's DOP853, events located by integration up to them. Its
  rtol is 1e-13 where nothing bends, 1e-11 where no joint has play, 1e-10 elsewhere: there the rounding of a
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
from scipy.integrate import DOP853, solve_ivp

from tests.support.multibody import Now

from .cvode import bdf
from .four_bar import LINKS
from .motion import follow, tolerances
from .scenes import BENT, SCENES
from .taylor import Series

HERE = Path(__file__).parent
KEYS = ("angle", "angular_velocity", "angular_acceleration", "deflection", "journal", "reaction", "energy")


def changes(record):
    """The fields that differ from the record's defaults."""
    default = vars(type(record)())
    return {name: value for name, value in vars(record).items() if value != default[name]}


def shortly(value):
    """Two digits."""
    return float(f"{value:.1e}")


def alike(motions, truth):
    """Raise where another motion has other events."""
    for name, other in motions.items():
        if other.kinds != truth.kinds:
            raise RuntimeError(f"{name} finds other events")


def rigid(scene):
    """Everything stored of a rigid scene."""
    system, p = scene.system, scene.parameters
    scale = np.repeat([1.0, p.w0], system.half)
    series = Series(system)
    truth = follow(scene, series)
    others = {
        "taylor": follow(scene, Series(system, tol=1e-17)),
        "DOP853": follow(scene, DOP853, 1e-13),
        "CVODE": follow(scene, bdf, 1e-13),
    }
    alike(others, truth)

    def apart(other):
        return np.max(np.abs(other.end - truth.end) / scale)

    move = 1e-12 * np.random.default_rng(1).standard_normal(2 * system.half) * scale
    moved = follow(scene, series, start=system.start() + move)
    now = Now(system, 0.0, truth.states[-1].y)
    gaps = {joint.name: now.between(joint.journal, joint.bearing) for joint in system.loose}
    angles, speeds = (half[:3].tolist() for half in np.split(truth.end, 2))
    return {
        "parameters": changes(p),
        "clearance": scene.clearance,
        "turns": scene.turns[-1],
        "t_end": truth.states[-1].t,
        "angles": dict(zip(LINKS, angles, strict=True)),
        "speeds": dict(zip(LINKS, speeds, strict=True)),
        "joints": {name: [gap[0].tolist(), gap[2].tolist()] for name, gap in gaps.items()},
        "differs": {name: shortly(apart(other)) for name, other in others.items()},
        "growth": shortly(apart(moved) / np.max(np.abs(move / scale))),
        "events": truth.events,
    }


def lsoda(system, now, stop, rtol):
    """Go on by LSODA, where there are no events."""
    options = {"method": "LSODA", "rtol": rtol, "atol": tolerances(system, rtol, free=True)}
    found = solve_ivp(lambda t, y: system.rate(y, {}), (now.t, stop), system.reduced(now.y), **options)
    return stop, system.full(found.y[:, -1]), None


def ways(scene):
    """Method and rtol of the stored motion, of a looser one and of another integrator."""
    if any(beam.xi >= 1 for beam in scene.beams.values()):
        return {"truth": (bdf, 1e-12), "loose": (bdf, 1e-10), "LSODA": (lsoda, 1e-10)}
    rtol = 1e-10 if scene.clearance else 1e-11 if scene.beams else 1e-13
    return {"truth": (DOP853, rtol), "loose": (DOP853, 100 * rtol), "CVODE": (bdf, 1e-11)}


def column(motion):
    """Samples of a motion, one list over time a quantity (and joint)."""
    rows, found = motion.samples(), {}
    for key in KEYS:
        values = [row[key] for row in rows]
        by_joint = isinstance(values[0], dict)
        found[key] = {joint: [v[joint] for v in values] for joint in values[0]} if by_joint else values
    return found


def series_of(values):
    """Values over time of every link or joint."""
    return np.array(list(values.values())) if isinstance(values, dict) else np.transpose(values)


def distances(mine, other, w0, motions):
    """Largest differences of two sets of samples."""

    def largest(key, scale=None):
        pairs = zip(series_of(mine[key]), series_of(other[key]), strict=True)
        return max(np.max(np.abs(a - b)) / (scale or np.max(np.abs(a)) or 1.0) for a, b in pairs)

    times = ([event[0] for event in motion.events] for motion in motions)
    late = np.max(np.abs(np.subtract(*times)), initial=0.0) * w0 / (2 * np.pi)
    found = {
        "angle": largest("angle", 1.0),
        "speed": largest("angular_velocity", w0),
        "deflection": largest("deflection"),
        "reaction": largest("reaction"),
        "event": late,
    }
    return {key: shortly(value) for key, value in found.items()}


def bent(scene):
    """Everything stored of a scene of links that bend."""
    p = scene.parameters
    motions = {name: follow(scene, *way) for name, way in ways(scene).items()}
    truth = motions.pop("truth")
    alike(motions, truth)
    stored = column(truth)
    differs = {k: distances(stored, column(other), p.w0, (truth, other)) for k, other in motions.items()}
    return {
        "parameters": changes(p),
        "clearance": scene.clearance,
        "beams": {link: vars(beam) for link, beam in scene.beams.items()},
        "order": scene.order,
        "differs": differs,
        "times": scene.times,
        **stored,
        "events": truth.events,
    }


def write(path, truth):
    """One line a field, so that a change shows in a diff."""
    scenes = []
    for name, fields in truth.items():
        lines = ",\n".join(f'  "{key}": {json.dumps(value)}' for key, value in fields.items())
        scenes.append(f'"{name}": {{\n{lines}\n}}')
    origin = '{\n"origin": "made by make_truth.py, which says where each number comes from",\n'
    path.write_text(origin + ",\n".join(scenes) + "\n}\n")


def main(names):
    """Make the named scenes, or all, keeping what is stored of the others."""
    for file, made, scenes in (("truth.json", rigid, SCENES), ("flexible_truth.json", bent, BENT)):
        for name in [name for name in names if name in scenes] if names else scenes:
            found = made(scenes[name])
            print(name, found["differs"], len(found["events"]), "events", flush=True)
            stored = json.loads((HERE / file).read_text()) | {name: found}
            write(HERE / file, {name: stored[name] for name in scenes if name in stored})


if __name__ == "__main__":
    main(sys.argv[1:])
