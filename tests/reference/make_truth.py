"""Make truth.json: end states of the stored scenes, from three integrations of two derivations.

Run as ``python -m tests.reference.make_truth [scene ...]`` from the root of the repository; about six
minutes for all. Origin of every number:

- angles, speeds, joints (r and its rate) and events: ``taylor.Series``, equations by virtual work in minimal
  coordinates, Taylor series in 80-bit numbers at their own rounding, events at roots of the series; stored
  as the nearest double.
- differs.taylor: how far the same series at a tolerance of 1e-17 ends from it.
- differs.DOP853: the free bodies of ``bodies.py`` in doubles, scipy's DOP853 at rtol 1e-13.
- differs.CVODE: the same free bodies through SUNDIALS' BDF at rtol 1e-13.
- growth: end difference over start difference, for a start moved by 1e-12 (1 rad, a/b) in a random direction.

Differences are maxima over the whole state in units of (1 rad, 1 m, a/b rad/s, a/b m/s).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from .bodies import Bodies, Parameters
from .cvode import run_cvode
from .scenes import SCENES
from .taylor import Series
from .twin import run

PATH = Path(__file__).with_name("truth.json")


def changes(parameters):
    """The parameters that differ from Table 1's."""
    default = vars(Parameters())
    return {name: value for name, value in vars(parameters).items() if value != default[name]}


def sequence(result):
    """Joint and kind of every event."""
    return [(event.joint, event.kind) for event in result.events]


def record(scene):
    """Everything stored of one scene."""
    p, joints = scene.parameters, scene.clearance
    system = Bodies(p, joints)
    scale = np.repeat([1.0, p.w0], system.n)
    series, options = Series(system), {"clearance": joints, "turns": scene.turns}
    truth = run(p, method=series, **options)
    others = {
        "taylor": run(p, method=Series(system, tol=1e-17), **options),
        "DOP853": run(p, rtol=1e-13, **options),
        "CVODE": run_cvode(p, rtol=1e-13, **options),
    }
    for name, other in others.items():
        if sequence(other) != sequence(truth):
            raise RuntimeError(f"{name} finds other events")

    def apart(other):
        return float(np.max(np.abs(other.y - truth.y) / scale))

    move = 1e-12 * np.random.default_rng(1).standard_normal(2 * system.n) * scale
    moved = run(p, method=series, start=system.start() + move, **options)
    return {
        "parameters": changes(p),
        "clearance": joints,
        "turns": scene.turns,
        "t_end": truth.t,
        "angles": truth.angles,
        "speeds": truth.speeds,
        "joints": truth.joints,
        "differs": {name: float(f"{apart(other):.1e}") for name, other in others.items()},
        "growth": float(f"{apart(moved) / np.max(np.abs(move / scale)):.1e}"),
        "events": [[e.time, e.joint, e.kind, e.v_n, e.v_t] for e in truth.events],
    }


def write(truth):
    """One line a field, so that a change shows in a diff."""
    scenes = []
    for name, fields in truth.items():
        lines = ",\n".join(f'  "{key}": {json.dumps(value)}' for key, value in fields.items())
        scenes.append(f'"{name}": {{\n{lines}\n}}')
    PATH.write_text('{\n"origin": "made by make_truth.py, which says where each number comes from",\n')
    with PATH.open("a") as file:
        file.write(",\n".join(scenes) + "\n}\n")


def main(names):
    """Make the named scenes, or all, keeping what is stored of the others."""
    stored = json.loads(PATH.read_text()) if PATH.exists() else {}
    truth = {name: stored[name] for name in SCENES if name in stored}
    for name in names or SCENES:
        truth[name] = record(SCENES[name])
        print(name, truth[name]["differs"], "growth", truth[name]["growth"], flush=True)
        write({name: truth[name] for name in SCENES if name in truth})


if __name__ == "__main__":
    main(sys.argv[1:])
