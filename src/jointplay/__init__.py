"""jointplay: nonlinear dynamics of linkages whose joints have play.

    import jointplay as jp

`jp.catalog`, and the records `jp.Mechanism`, `jp.Link`, `jp.Joint`, … say what is simulated; `jp.simulate`
gives time histories and `jp.poincare` section points, each as an `xarray.Dataset`; `jp.open` reads a stored
result, `jp.figure` draws one; wrong input raises `jp.InputError`. SI units throughout; angles in rad.

Public names load on first use, so that the command line starts fast.
"""

from importlib import import_module

from jointplay.codegen.cache import activate

__version__ = "0.1.0"

_HOME = {
    "simulate": "analysis.simulate",
    "poincare": "analysis.poincare",
    "bifurcation": "analysis.sweeps.bifurcation",
    "lyapunov": "analysis.exponents.lyapunov",
    "sensitivity": "analysis.states.sensitivity",
    "basins": "analysis.states.basins",
    "chaos_test": "analysis.signals.chaos_test",
    "spectrum": "analysis.signals.spectrum",
    "dimension": "analysis.signals.dimension",
    "periodic_orbit": "analysis.orbits.periodic_orbit",
    "continuation": "analysis.orbits.continuation",
    "growth": "analysis.exponents.growth",
    "readings": "analysis.paper.readings",
    "claims": "analysis.paper.claims",
    "waveform": "analysis.scheme.waveform",
    "scheme_comparison": "analysis.scheme.scheme_comparison",
    "stress": "analysis.stress.stress",
    "work_precision": "analysis.precision.work_precision",
    "open": "study.store:open_result",
    "cell": "study.single",
    "figure": "figures:draw",
    "InputError": "errors",
    "catalog": "mechanism.catalog:",
    **dict.fromkeys(
        (
            *(
                "Mechanism",
                "Link",
                "Beam",
                "Joint",
                "Pin",
                "Contact",
                "Friction",
                "MotorLine",
                "ConstantSpeed",
                "TestSystem",
            ),
            *("CrankAngle", "ContactSection", "SeparationSection", "Plane"),
        ),
        "mechanism.records",
    ),
}
__all__ = ["__version__", *_HOME]

activate()


def __getattr__(name: str):
    if name not in _HOME:
        raise AttributeError(f"module 'jointplay' has no attribute {name!r}")
    home, _, attribute = _HOME[name].partition(":")
    module = import_module(f"jointplay.{home}")
    value = module if _HOME[name].endswith(":") else getattr(module, attribute or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
