"""jointplay: nonlinear dynamics of linkages whose joints have play.

    import jointplay as jp

`jp.catalog`, and the records `jp.Mechanism`, `jp.Link`, `jp.Joint`, … say what is simulated; `jp.simulate`
gives time histories and `jp.poincare` section points, each as an `xarray.Dataset`; `jp.open` reads a stored
result, `jp.figure` draws one; wrong input raises `jp.InputError`. SI units throughout; angles in rad.

Public names load on first use, so that the command line starts fast.
"""

import os
import sys
from functools import cache
from importlib import import_module

# `python -m jointplay` has put the current folder first on the path: what lies beside a study is no library
if sys.argv[:1] == ["-m"] and sys.orig_argv[-len(sys.argv)].removeprefix("-m") == __name__:
    try:
        sys.path.remove(here := os.getcwd())
        if os.path.samefile(here, os.path.dirname(__path__[0])):
            sys.path.insert(sys.path.index(os.path.dirname(os.__file__)) + 2, here)  # behind Python's own
    except (OSError, ValueError):  # the folder is gone, or was kept off the path
        pass

from jointplay.display.errors import no_attribute

__version__ = "0.1.0"

_RECORDS = (
    "Mechanism Link PointMass Beam Joint Pin Contact Friction Spring TorsionSpring Force Torque Harmonic "
    "MotorLine ConstantSpeed PrescribedTorque SpeedCycle SpeedProfile Servo TestSystem "
    "System Touch Rubbing Switch Impact Jump "
    "CrankAngle ContactSection SeparationSection Plane"
)
_HOME = {
    "growth": ".analysis.exponents.growth",
    "open": ".study.results.store:open_result",
    "summary": ".study.results.summary",
    "words": ".study.results.export",
    "export": ".study.results.export",
    "run": ".study.in_python",
    "cell": ".analysis.sweeps.gather",
    "figure": ".figures:draw",
    "animate": ".study.results.animate",
    "InputError": ".display.errors",
    "ModelWarning": ".display.errors",
    "catalog": ".solver.mechanism.catalog:",
    "fit": ".solver.mechanism.parts.fits",
    "contact_data": ".solver.mechanism.parts.contact_data",
    "contact_stiffness": ".solver.mechanism.parts.contact_data",
    **dict.fromkeys(_RECORDS.split(), ".solver.mechanism.records"),
}


@cache
def _homes() -> dict[str, str]:
    """Homes of the public names: those that packages publish, analyses by their kinds, and those above."""
    from jointplay.kinds import KINDS
    from jointplay.solver.extensions import published

    of_others = {point.name: point.value for point in published("jointplay.names")}
    return of_others | {row.home.partition(":")[2]: row.home for row in KINDS.values()} | _HOME


def __getattr__(name: str):
    if name == "__all__":
        return ["__version__", *_homes()]
    place = _HOME.get(name) or _homes().get(name)
    if place is None:
        raise no_attribute("module 'jointplay'", name, ["__version__", *_homes()])
    home, _, attribute = place.partition(":")
    module = import_module(home, __name__)
    value = module if place.endswith(":") else getattr(module, attribute or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(["__version__", *_homes()])
