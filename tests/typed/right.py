"""Typed use of what the package offers: a type checker finds nothing wrong."""

from pathlib import Path
from typing import assert_type

import xarray as xr
from matplotlib.figure import Figure

import jointplay as jp

mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
assert_type(mechanism, jp.Mechanism)
assert_type(mechanism.replace(clearance={"B": 1e-4, "C": 1e-4}), jp.Mechanism)
assert_type(jp.catalog.impact_pair(gap=3.6, restitution=0.8), jp.System)

motion = jp.simulate(mechanism, turns=10, section=jp.CrankAngle(), rtol=1e-9, record=["normal_force"])
assert_type(motion, xr.Dataset)
assert_type(jp.simulate(mechanism, at=[0.0, 0.1], initial={"crank_angle": 0.1}), xr.Dataset)
assert_type(jp.poincare(mechanism, turns=20, transient=5), xr.Dataset)
assert_type(jp.lyapunov(mechanism, exponents=2, turns=300, progress=False), xr.Dataset)
assert_type(jp.bifurcation(mechanism, over={"clearance": [1e-5, 2e-5]}, direction=("up", "down")), xr.Dataset)
assert_type(jp.bifurcation(mechanism, over={"clearance": [1e-5, 2e-5]}, direction="up"), xr.Dataset)
assert_type(jp.continuation(mechanism, parameter="speed", range=(100.0, 200.0)), xr.Dataset)
assert_type(
    jp.basins(mechanism, plane={"angle": [0.0, 0.1], "velocity": {"start": 0, "stop": 1, "num": 3}}),
    xr.Dataset,
)
assert_type(jp.assess(mechanism), xr.Dataset)
assert_type(jp.stress(scenes=1), xr.Dataset)
assert_type(jp.figure(motion, kind="journal_orbit"), Figure)
assert_type(jp.run("study.toml", jobs=2), xr.Dataset)
assert_type(jp.open(Path("results") / "study.nc"), xr.Dataset)
assert_type(jp.report(motion, "page.html"), list[Path])
print(jp.summary(motion), jp.__version__)

crank = jp.Link(name="crank", length=0.03, mass=0.4, inertia=1.5e-4, beam=jp.Beam(shapes="sine"))
joint = jp.Joint(
    name="O",
    journal=jp.Pin(link="crank"),
    bearing=jp.Pin(link="ground", point=(0.0, 0.0)),
    contact=jp.Contact(law="hertz", stiffness=1e7, damping=200.0),
)
assert_type(
    jp.Mechanism(links=(crank,), joints=(joint,), drive=jp.ConstantSpeed(link="crank", speed=10.0)),
    jp.Mechanism,
)
try:
    crank.model_copy()
except jp.InputError as error:
    assert_type(error.count, int)
