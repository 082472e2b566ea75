"""Stiffness of a contact, from materials and radii.

Reference: Hertz (1882), of balls: F = K u^(3/2) with K = 4/3 E* sqrt(R), 1/E* = (1 - nu_1^2)/E_1 +
(1 - nu_2^2)/E_2 and 1/R = 1/R_1 + 1/R_2, the radius of a hollow ball being negative. Valid where the contact
is small beside both radii; a journal in its bearing conforms more than that, and its K is an estimate.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any

from jointplay.display.errors import Problem
from jointplay.solver.mechanism.base import Positive, is_number, unit
from jointplay.solver.mechanism.signature import checked

Pair = float | tuple[float, float]


def _pair(given: Any) -> tuple[Any, ...]:
    """One number for each body."""
    return tuple(given) if isinstance(given, tuple | list) else (given, given)


def _pairs_fit(modulus: Any, poisson_ratio: Any) -> Iterator[Problem]:
    """Yield a problem where there are not two moduli, or not two ratios, that a material can have."""
    fits = {
        "modulus": (modulus, lambda E: E > 0, "greater than 0 Pa"),
        "poisson_ratio": (poisson_ratio, lambda nu: -1 < nu <= 0.5, "above -1, up to 0.5"),
    }
    for name, (given, fit, accepted) in fits.items():
        pair = _pair(given)
        if len(pair) != 2 or not all(is_number(each) and fit(each) for each in pair):
            yield Problem(name, given, f"a number {accepted}, or a pair of them, is accepted")


@checked(_pairs_fit)
def contact_stiffness(
    radius: Annotated[Positive, unit("radius", "m")],
    clearance: Annotated[Positive, unit("clearance", "m")],
    modulus: Pair = 2.07e11,
    poisson_ratio: Pair = 0.3,
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
    materials = zip(_pair(modulus), _pair(poisson_ratio), strict=True)
    compliance = sum((1 - nu**2) / E for E, nu in materials)
    return 4 / (3 * compliance) * math.sqrt(radius * (radius + clearance) / clearance)
