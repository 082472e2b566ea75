"""Elastic links that stretch: the two modes along, their numbers in the equations, and where they may sit.

Source: a uniform bar held at x = 0, u(x, t) = 4 x (1 − x) q_1 + x (2 x − 1) q_2 over its unit length, the two
quadratic shape functions of its mid-point and end; q_2 moves the end. Mass-normalised modes of

    M = [[8, 1], [1, 2]]/15,    K = [[16, −8], [−8, 7]]/3          (of unit length, mass and stiffness EA),

whose frequencies are 0.3 % and 15 % above π/2 and 3 π/2 of the bar. Assumptions: small strains. Units: SI.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.display.errors import Problem
from jointplay.solver.equations.structure import Beam as Structure
from jointplay.solver.mechanism.parts.beam import Link, area, line_density, modal
from jointplay.solver.mechanism.records import Mechanism

MASS = np.array([[8.0, 1.0], [1.0, 2.0]]) / 15
STIFFNESS = np.array([[16.0, -8.0], [-8.0, 7.0]]) / 3
FORCE, LEVER = np.array([2 / 3, 1 / 6]), np.array([1 / 3, 1 / 6])  # ∫ψ dx, ∫x ψ dx


@dataclass(frozen=True)
class Along:
    """Coefficients of the modes ψ_a along a link; arrays of shape (2,), but for `coupling`.

    Parameters
    ----------
    frequency : numpy.ndarray
        Ω_a, rad/s.
    force, lever : numpy.ndarray
        A_a = ∫ρA ψ_a dx, √kg; B_a = ∫ρA x ψ_a dx, √kg m.
    stretch : numpy.ndarray
        ψ_a at the far end over the length, 1/(√kg m).
    coupling : numpy.ndarray, shape (modes across, 2)
        G_ia = ∫ρA φ_i ψ_a dx.
    """

    frequency: np.ndarray
    force: np.ndarray
    lever: np.ndarray
    stretch: np.ndarray
    coupling: np.ndarray


def along(link: Link) -> Along:
    """Give the modes along a link, which it has besides the modes across it."""
    from scipy.linalg import eigh  # takes long to import, and rigid mechanisms go without

    squares, v = eigh(STIFFNESS, MASS)
    v, length = v * np.sign(v[1]), link.length
    mass, across = line_density(link) * length, modal(link)
    x, x2 = across.moment / length, across.second / length**2
    crossed = np.array([4 * (x - x2), 2 * x2 - x]).T / np.sqrt(mass)
    return Along(
        frequency=np.sqrt(squares * link.beam.modulus * area(link) / (mass * length)),
        force=FORCE @ v * np.sqrt(mass),
        lever=LEVER @ v * np.sqrt(mass) * length,
        stretch=v[1] / (np.sqrt(mass) * length),
        coupling=crossed @ v,
    )


def named(link: Link, rows: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Give the numbers of a link's modes, rows by their words, their names in the equations."""
    return {f"{word}_{link.name}_{i}": float(v) for word, row in rows.items() for i, v in enumerate(row)}


def numbers(link: Link) -> dict[str, float]:
    """Give the numbers of the modes along a link in the equations, by name."""
    modes, xi = along(link), link.beam.damping_ratio
    rows = {
        "along": modes.force,
        "lever": modes.lever,
        "axial": modes.frequency**2,
        "axial_c": 2 * xi * modes.frequency,
        "stretch": modes.stretch,
    }
    return named(link, rows) | {
        f"G_{link.name}_{i}_{a}": float(G) for (i, a), G in np.ndenumerate(modes.coupling)
    }


def problems(
    mechanism: Mechanism, places: Mapping[str, Any], beams: tuple[Structure, ...], order: str
) -> Iterator[Problem]:
    """List the problems of links that stretch; keys are relative to the table that holds the mechanism.

    `places` are those of the links' origins (`kinematic_chains.Place`).
    """
    held = [place.sides for place in places.values() if place.parent is not None]
    ends = [end.pins.values() for end in (*mechanism.springs, *mechanism.loads)]
    for i, link in enumerate(mechanism.links):
        name, key = link.name, f"mechanism.links[{i}].beam.axial"
        if not any(beam.link == name and beam.axial for beam in beams):
            continue
        if order != "consistent":
            yield Problem(key, True, "false is accepted with order = 'paper', whose equations leave it out")
        wrong = {
            "the joint that holds it sits at its origin": any(o.link == name and o.at for _, o in held),
            "its far end holds no other link by an ideal joint": any(
                one.link == name and one.at for one, _ in held
            ),
            "no guide is on it": any(j.prismatic and name in j.links for j in mechanism.joints),
            "no spring or load acts on its far end": any(
                pin.link == name and pin.at for pins in ends for pin in pins
            ),
            "no point mass sits at its far end": any(point.at for point in link.masses),
        }
        for accepted, violated in wrong.items():
            if violated:
                yield Problem(key, True, f"an elastic link that stretches is accepted where {accepted}")
