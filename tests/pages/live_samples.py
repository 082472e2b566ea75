"""A page that computes, with a solver of a motion that is known in closed form."""

from pathlib import Path

from jointplay import catalog
from jointplay_page.script.solver import Solver

FAKE = Path(__file__).with_name("fake_solver.js").read_text(encoding="utf-8")


def parameter(key, label, unit, factor, value, least, most, scale="lin"):
    ends = {"value": value, "min": least, "max": most, "scale": scale}
    ends["refused"] = [False, key == "gear_ratio"]
    path = {"clearance": "joints.B.clearance", "damping": "joints.B.contact.damping"}.get(key.split(".")[0])
    named = {"key": key, "paths": [path or f"drive.{key}"], "label": label}
    return named | {"unit": unit, "factor": factor} | ends


def fake(mechanism, **_):
    """A solver of the known motion, with its sliders."""
    parameters = [
        parameter("gear_ratio", "gear ratio", "", 1, 2.8, 2.5, 4.0),
        parameter("damping.B", "damping at B", "N s/m", 1, 200.0, 0.0, 1000.0),
        parameter("moved", "a number of no great use", "s", 1, 1.0, 0.0, 2.0),
    ]
    if mechanism.clearance_joints:
        parameters.insert(0, parameter("clearance.B", "clearance of B", "µm", 1e6, 2.9e-4, 1e-5, 1e-3, "log"))
    lengths = [0.05, 0.14, 0.12, 0.15]
    still = {"label": "length of link crank", "value": 0.05, "factor": 1e3, "unit": "mm"}
    data = {
        "parameters": parameters,
        "fixed": [still | {"why": "where the motion begins is not known at other lengths"}],
        "state": ["s"],
        "joints": ["B"],
        "period": 0.075,
        "start": 0.3,
        "lengths": lengths,
    }
    return Solver(FAKE, data)


def linkage():
    """The paper's mechanism."""
    return catalog.chunmei2002(clearance=2.9e-4)
