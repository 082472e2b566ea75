"""Stiffness of a contact, from materials and radii.

Reference: Hertz (1882), of balls: F = K u^(3/2) with K = 4/3 E* sqrt(R), 1/E* = (1 - nu_1^2)/E_1 +
(1 - nu_2^2)/E_2 and 1/R = 1/R_1 + 1/R_2, the radius of a hollow ball being negative. Valid where the contact
is small beside both radii; a journal in its bearing conforms more than that, and its K is an estimate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from jointplay.errors import InputError, Problem
from jointplay.mechanism.base import is_number

Pair = float | tuple[float, float]


def contact_stiffness(
    radius: float, clearance: float, modulus: Pair = 2.07e11, poisson_ratio: Pair = 0.3
) -> float:
    """Give Hertz's stiffness of a ball of a journal's radius in a hollow ball of its bearing's.

    Parameters
    ----------
    radius : float
        Radius of the journal, m.
    clearance : float
        How much larger the bearing's radius is, m.
    modulus : float or pair of float
        Young's modulus, of both or of each, Pa; that of steel if left out.
    poisson_ratio : float or pair of float
        Poisson's ratio, of both or of each.

    Returns
    -------
    float
        K, N/m^1.5: the ``stiffness`` of ``hertz`` and of the laws with the same exponent.

    Raises
    ------
    InputError
        Listing what makes no sense.
    """
    problems = [
        Problem(name, value, f"a {name} greater than 0 m is accepted")
        for name, value in (("radius", radius), ("clearance", clearance))
        if not (is_number(value) and value > 0)
    ]
    moduli = _pair("modulus", modulus, lambda E: E > 0, "greater than 0 Pa", problems)
    ratios = _pair("poisson_ratio", poisson_ratio, lambda nu: -1 < nu <= 0.5, "above -1, up to 0.5", problems)
    if problems:
        raise InputError(problems)
    compliance = sum((1 - nu**2) / E for E, nu in zip(moduli, ratios, strict=True))
    return 4 / (3 * compliance) * math.sqrt(radius * (radius + clearance) / clearance)


def _pair(
    name: str, given: Any, fits: Callable[[float], bool], accepted: str, problems: list[Problem]
) -> tuple[Any, ...]:
    """One number for each body; what is wrong with them goes to `problems`."""
    pair = tuple(given) if isinstance(given, tuple | list) else (given, given)
    if len(pair) != 2 or not all(is_number(each) and fits(each) for each in pair):
        problems.append(Problem(name, given, f"a number {accepted}, or a pair of them, is accepted"))
    return pair
