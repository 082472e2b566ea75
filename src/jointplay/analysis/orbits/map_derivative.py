"""`map_derivative`: the end of a section map, its DP, and its dP/dp, exact through every event.

Of a test system and of a linkage alike, in any parameter that a branch can have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from jointplay.analysis.orbits.section_map import Image, SectionMap
from jointplay.solver.mechanism.directions import Directions, along


def direction(
    maps: Callable[[float], SectionMap], value: float, key: str = "parameter", precise: bool = True
) -> Directions:
    """Derivatives of the numbers behind section maps in a parameter.

    Parameters
    ----------
    maps : callable
        Section map at a value of the parameter, all of one section.
    value : float
        Where.
    key : str
        Name of the parameter in messages.
    precise : bool
        As in `mechanism.directions.along`.
    """
    own = maps(value)
    return along(
        lambda at: maps(at).model, value, key, lambda model: replace(own, model=model).begin, precise
    )


def map_derivative(
    maps: Callable[[float], SectionMap],
    value: float,
    state: np.ndarray,
    like: SectionMap | None = None,
    key: str = "parameter",
) -> Image:
    """Image of a state on a section, with the derivative in the state, and in the parameter.

    Parameters
    ----------
    maps, value, key
        As in `direction`.
    state : ndarray
        On the section, which does not move with the parameter.
    like : SectionMap, optional
        Whose phase, turns and units are taken; the map's own if left out.

    Returns
    -------
    Image
        With ``derivative`` DP, ``along`` dP/dp (one column, units of the scales), ``times`` dT/dp.
    """
    own = maps(value)
    if like is not None:
        own = replace(own, phase=like.phase, turns=like.turns, units=like.scale)
    found = direction(lambda at: replace(maps(at), phase=own.phase), value, key)
    return own.image(state, directions=found)
