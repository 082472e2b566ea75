"""Elastic links that the tests of beams share, and their mode shapes, sampled through the gauge."""

import math

import numpy as np

from jointplay.solver.mechanism.parts.beam import Beam, Link, modal

COUPLER = {"name": "coupler", "length": 0.181, "mass": 0.1743, "inertia": 2.7e-3}
ROCKER = {"name": "rocker", "length": 0.1175, "mass": 0.2916, "inertia": 1.34e-3}
CRANK = {"name": "crank", "length": 0.03, "mass": 0.4489, "inertia": 1.5e-4}
BARS = [COUPLER, ROCKER, CRANK]


def bar(data=COUPLER, **beam):
    """Give an elastic link."""
    return Link(**data, elastic=True, beam=Beam(**beam))


def frequency(data, n, modulus=2.1e11, density=7800.0):
    """Give (nπ/l)² √(EI/ρA) of a round bar that has all of the link's mass, rad/s."""
    length = data["length"]
    area = data["mass"] / (density * length)
    second_moment = area**2 / (4 * math.pi)
    return (n * math.pi / length) ** 2 * math.sqrt(modulus * second_moment / (density * area))


def sampled(data, fractions, **beam):
    """Give φ_i at fractions of the length, shape (fractions, modes)."""
    return np.array([modal(bar(data, **beam, gauge=float(x))).gauge for x in fractions])


class Integrals:
    """∫ρA f dx of mode shapes, with four Gauss points an element: exact for products of two cubics.

    Parameters
    ----------
    data : dict
        The link.
    elements : int
        Of its beam.
    """

    def __init__(self, data, elements):
        points, weights = np.polynomial.legendre.leggauss(4)
        start = np.arange(elements)[:, None] / elements
        fractions = (start + (points + 1) / (2 * elements)).ravel()
        self.x = fractions * data["length"]
        self.shapes = sampled(data, fractions, elements=elements)
        self.weights = np.tile(weights, elements) * data["mass"] / (2 * elements)

    def of(self, left, right):
        """Give ∫ρA left right dx of samples, each of shape (points, ...)."""
        return left.T @ (self.weights[:, None] * right)
