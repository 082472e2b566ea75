"""What is simulated: validated, frozen records that a person can read. Names load when first asked for."""

from __future__ import annotations

import importlib
from typing import Any

_HOMES = {
    "records": (
        "Beam ConstantSpeed Contact ContactSection CrankAngle Friction Joint Link Mechanism MotorLine Pin "
        "Plane SeparationSection TestSystem"
    ),
    "assemble": "check_section",
    "closure": "four_bar ideal_state",
    "loop": "FourBar",
}
_WHERE = {name: home for home, names in _HOMES.items() for name in names.split()}
_MODULES = ("catalog", "closure", "records")
__all__ = sorted([*_WHERE, *_MODULES])


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"{__name__}.{name}")
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_WHERE[name]}"), name)


def __dir__() -> list[str]:
    return __all__
