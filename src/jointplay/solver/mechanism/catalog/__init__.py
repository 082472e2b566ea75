"""Mechanisms and test systems by name: those of the files beside this one, and of `mechanism.own.systems`."""

# ruff: noqa: F401, I001  all entries are offered here, which `as` tells type checkers

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from jointplay.display.errors import no_attribute
from jointplay.solver.extensions import Table
from jointplay.solver.mechanism.catalog.presets import (
    quick_return as quick_return,
    slider_crank as slider_crank,
)
from jointplay.solver.mechanism.catalog.published import (
    chunmei2002 as chunmei2002,
    flores2010 as flores2010,
    ivp_crank as ivp_crank,
    siconos_four_bar as siconos_four_bar,
)
from jointplay.solver.mechanism.catalog.presets import stephenson as stephenson, watt as watt
from jointplay.solver.mechanism.own.own import CATALOG
from jointplay.solver.mechanism.own.systems import (
    SYSTEMS,
    TestSystem,
    bouncing_ball as bouncing_ball,
    cam_follower as cam_follower,
    duffing as duffing,
    gear_backlash as gear_backlash,
    impact_pair as impact_pair,
    jerk as jerk,
    lorenz as lorenz,
    relief_valve as relief_valve,
    rossler as rossler,
    soft_impact_pair as soft_impact_pair,
)
from jointplay.solver.mechanism.records import Mechanism

_OURS = (chunmei2002, slider_crank, watt, stephenson, quick_return, ivp_crank, flores2010, siconos_four_bar)
CATALOG.own = {each.__name__: each for each in _OURS} | CATALOG.own
NAMES: Table[Callable[..., Mechanism | TestSystem]] = CATALOG


def __getattr__(name: str) -> Any:
    if name[:1] != "_" and name in NAMES:
        return NAMES[name]
    raise no_attribute("the catalog", name, NAMES)


def __dir__() -> list[str]:
    return sorted(NAMES)
