"""Point masses on links, and the mass, mass centre and inertia of a link together with them."""

from __future__ import annotations

from collections.abc import Sequence

from jointplay.solver.mechanism.base import Name, Place, Positive, Record, measured


class PointMass(Record):
    """A mass at a point of a link's line, such as a counterweight.

    Parameters
    ----------
    at : float
        Distance from the link's origin along the link, m; negative behind the origin.
    mass : float
        Mass, kg.
    name : str, optional
        By which a sweep finds it: ``links.crank.masses.counterweight.mass``.
    """

    at: Place = measured("distance along the link", "m")
    mass: Positive = measured("point mass", "kg")
    name: Name | None = None


def together(
    mass: float, centre: float, inertia: float, masses: Sequence[PointMass]
) -> tuple[float, float, float]:
    """Give mass (kg), mass centre (m) and inertia about the origin (kg m²) of a link with its point masses.

    Parameters
    ----------
    mass, centre, inertia : float
        Those of the link alone; the inertia about its origin.
    masses : sequence of PointMass
        What sits on it.
    """
    total = mass + sum(point.mass for point in masses)
    moment = mass * centre + sum(point.mass * point.at for point in masses)
    return total, moment / total, inertia + sum(point.mass * point.at**2 for point in masses)
