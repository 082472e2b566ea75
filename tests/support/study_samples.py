"""Study texts that validate, and a result with next to nothing in it."""

from functools import partial, wraps

import numpy as np
import xarray as xr

from jointplay import kinds
from jointplay.solver.method.codes import Status

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

STRETCHED = BENT_WRITTEN_OUT.replace("modes = 3", 'shapes = "sine", modes = 3, axial = true').replace(
    "speed = 80.0", "constant = 80.0\nharmonics = [{ order = 1, cosine = 8.0 }]\nfrequency = 40.0"
)
STRETCHED = STRETCHED.replace('kind = "speed"', 'kind = "cycle"')

GUIDED = """\
kind = "response"

[mechanism]
name = "slider-crank"
gravity = 9.81
gravity_direction = 0.5
guess = { crank = 0.0, rod = 0.0 }

[[mechanism.links]]
name = "crank"
length = 0.05
mass = 0.3
inertia_centre = 1e-5
masses = [{ name = "weight", at = 0.02, mass = 0.1 }]

[[mechanism.links]]
name = "rod"
length = 0.12
mass = 0.21
inertia_centre = 2.5e-4

[[mechanism.links]]
name = "slider"
length = 0.02
mass = 0.14
inertia_centre = 1e-5
centre = 0.0

[[mechanism.joints]]
name = "O"
journal = { link = "crank" }
bearing = { link = "ground", point = [0, 0] }

[[mechanism.joints]]
name = "A"
journal = { link = "crank", at = 0.05 }
bearing = { link = "rod" }

[[mechanism.joints]]
name = "B"
journal = { link = "rod", at = 0.12 }
bearing = { link = "slider" }
clearance = "0.1 mm"
radius = 0.01
contact = { law = "flores", stiffness = 1e9, parameters = { restitution = 0.7, exponent = 1.5 } }
friction = { law = "stribeck", coefficient = 0.1, static_coefficient = 0.2, stribeck_velocity = 0.01 }

[[mechanism.joints]]
name = "G"
kind = "prismatic"
journal = { link = "slider" }
bearing = { link = "ground", point = [0, 0], direction = 0.0 }
clearance = 1e-4
half_length = 0.02
half_height = 0.01
contact = { stiffness = 1e7, damping = 200 }
friction = { law = "brown_mcphee", coefficient = 0.1, static_coefficient = 0.15, velocity = 0.01 }

[[mechanism.springs]]
name = "return"
from = { link = "slider" }
to = { link = "ground", point = [0.3, 0.0] }
stiffness = 100.0
damping = 0.1
free_length = 0.2

[[mechanism.loads]]
name = "gas"
kind = "force"
on = { link = "slider" }
direction = 3.14
harmonics = [{ order = 1, cosine = 20.0, sine = 4.0 }]
angle = "crank"

[[mechanism.loads]]
name = "cutting"
kind = "torque"
link = "rod"
table = [0, 0, 1, 4, 9, 11, 9, 4, 1, 0, 0, 0]
tolerance = 0.05
factor = 1.5
frequency = 50.0

[mechanism.drive]
kind = "profile"
link = "crank"
start = 10.0
end = 60.0
time = 0.1

[analysis]
turns = 1
section = { kind = "contact", joint = "G_upper_front" }
"""


def result(status=0):
    """A dataset such as an analysis gives, with next to nothing in it."""
    meanings = {"flag_values": np.arange(len(STATUS.split()), dtype=np.int8), "flag_meanings": STATUS}
    force = ("time", np.linspace(0, 1, 11), {"units": "N", "long_name": "normal force"})
    time = ("time", np.linspace(0, 0.1, 11), {"units": "s", "long_name": "time"})
    variables = {"normal_force": force, "status": ((), np.int8(status), meanings)}
    return xr.Dataset(variables, coords={"time": time}, attrs={"kind": "response"})


def stand_in(monkeypatch, kind, function):
    """Let another function run the studies of a kind."""
    row, load = kinds.KINDS[kind], kinds.load
    real = row.function
    own = wraps(real)(lambda *values, **keywords: function(*values, **keywords))
    vars(own).pop("steps", None)

    def validated(given, wrong=()):
        problems, _ = real.validated(given, wrong)
        others = {name: value for name, value in given.items() if name != "mechanism"}
        return problems, partial(own, given.get("mechanism"), **others)

    own.validated = validated
    monkeypatch.setattr(kinds, "load", lambda home: own if home == row.home else load(home))


SOFT = """
[mechanism]
catalog = "soft_impact_pair"
gap = 1.0
stiffness = 50.0
damping = 1.0

[analysis]
"""
