"""This process compiles a structure's functions while others compile the loop; only then it waits."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

SCRIPT = """
import json
import numpy as np
from jointplay import catalog
from jointplay.solver.motion.ensemble_runs import Tangent, carry, follow_ensemble
from jointplay.analysis.tangents import Bundle
from jointplay.solver.motion.trajectory import Request, follow
from jointplay.solver.codegen import cache
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.method import interface

said = []

def told(home, name):
    function = getattr(home, name)

    def call(*given, **named):
        said.append([name, given[0] if name != "pointers" else ""])
        return function(*given, **named)

    setattr(home, name, call)

for home, name in ((cache, "prepare"), (cache, "method"), (interface, "pointers")):
    told(home, name)
brief = Request(1e-6, max_steps=1)
lanes = Request(1e-6, max_steps=1, misses=True)
{scene}
print(json.dumps(said))
"""
SMOOTH = "model = assemble(catalog.duffing())"
WALLED = "model = assemble(catalog.bouncing_ball(acceleration=9.81, restitution=0.5))"
FALLING = {"law": "stribeck", "coefficient": 0.1, "static_coefficient": 0.2, "stribeck_velocity": 0.01}
SCENES = {
    "a motion": f"{SMOOTH}; follow(model, brief)",
    "with a rigid wall": f"{WALLED}; follow(model, brief)",
    "with falling friction": "change = {'joints.B.friction': " + repr(FALLING) + "}; "
    "follow(assemble(catalog.chunmei2002().replace(**change)), brief)",
    "with tangents": f"{SMOOTH}; bundle = Bundle(model, brief, np.eye(2)); bundle.full; bundle.advance()",
    "in lanes": f"{WALLED}; follow_ensemble([model], [lanes])",
    "tangents in lanes": "model = assemble(catalog.chunmei2002()); "
    "carry([model], [lanes], [Tangent(*np.ones((2, len(model.state))), 0.0, 1.0, 1e-6, 1.0)])",
}


@pytest.mark.nightly
@pytest.mark.parametrize("scene", SCENES)
def test_what_this_process_compiles_is_asked_for_before_it_waits(scene):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT.format(scene=SCENES[scene])],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    waits = [name for what, name in said if what == "method"]
    before = said[: said.index(["method", waits[0]])]
    assert {name for what, name in before if what == "prepare"} == set(waits)
    assert sum(what == "pointers" for what, _ in before) == sum(what == "pointers" for what, _ in said) > 0
