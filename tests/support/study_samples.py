"""Study texts that validate, and a result with next to nothing in it."""

from functools import wraps

import numpy as np
import xarray as xr

from jointplay import kinds
from jointplay.numerics.codes import Status

STATUS = " ".join(Status.words())

TEXT = """\
kind = "response"
title = "A test"

[mechanism]
catalog = "chunmei2002"
clearance = 2.9e-4
gear_ratio = 3.0

[integrator]
rtol = 1e-9

[analysis]
turns = 2
transient = 1
section = { kind = "crank_angle", angle = 0.5 }

[figure]
kind = "overview"
joint = "B"
"""

WRITTEN_OUT = """\
kind = "section"

[mechanism]
name = "written out"
branch = "upper"

[[mechanism.links]]
name = "crank"
length = 0.03
mass = 0.4489
inertia = 1.5e-4
beam = { shapes = "sine", damping_ratio = 0.01 }

[[mechanism.links]]
name = "coupler"
length = 0.181
mass = 0.1743
inertia = 2.7e-3
beam = { shapes = "sine", damping_ratio = 0.01 }

[[mechanism.links]]
name = "rocker"
length = 0.1175
mass = 0.2916
inertia = 1.34e-3
beam = { shapes = "sine", damping_ratio = 0.01 }

[[mechanism.joints]]
name = "O"
journal = { link = "crank" }
bearing = { link = "ground", point = [0, 0] }

[[mechanism.joints]]
name = "A"
journal = { link = "crank", at = 0.03 }
bearing = { link = "coupler" }

[[mechanism.joints]]
name = "B"
journal = { link = "coupler", at = 0.181 }
bearing = { link = "rocker", at = 0.1175 }
clearance = 2.9e-5
radius = 0.015
contact = { stiffness = 7.15e6, damping = 228 }
friction = { coefficient = 0.01 }

[[mechanism.joints]]
name = "C"
journal = { link = "rocker" }
bearing = { link = "ground", point = [0.2, 0] }

[mechanism.drive]
kind = "speed"
link = "crank"
speed = 80.0

[analysis]
turns = 3
"""

BENT = TEXT.replace(
    "gear_ratio = 3.0\n",
    """\
gear_ratio = 3.0
elastic = ["coupler"]
elements = 3
damping_ratio = 0.02
order = "paper"
""",
)

BENT_WRITTEN_OUT = WRITTEN_OUT.replace(
    'inertia = 2.7e-3\nbeam = { shapes = "sine", ',
    "inertia = 2.7e-3\nelastic = true\nbeam = { modes = 3, area = 1.2e-4, ",
)


def result(status=0):
    """A dataset such as an analysis gives, with next to nothing in it."""
    meanings = {"flag_values": np.arange(9, dtype=np.int8), "flag_meanings": STATUS}
    force = ("time", np.linspace(0, 1, 11), {"units": "N", "long_name": "normal force"})
    time = ("time", np.linspace(0, 0.1, 11), {"units": "s", "long_name": "time"})
    variables = {"normal_force": force, "status": ((), np.int8(status), meanings)}
    return xr.Dataset(variables, coords={"time": time}, attrs={"kind": "response"})


def stand_in(monkeypatch, kind, function):
    """Let another function run the studies of a kind."""
    row, load = kinds.KINDS[kind], kinds.load
    own = wraps(row.function)(lambda *values, **keywords: function(*values, **keywords))
    vars(own).pop("steps", None)
    monkeypatch.setattr(kinds, "load", lambda home: own if home == row.home else load(home))
