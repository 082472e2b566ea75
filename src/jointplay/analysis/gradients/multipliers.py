"""Derivatives of the multipliers of a periodic orbit in a parameter.

A multiplier mu is an eigenvalue of DP, the derivative of a section map at its fixed point x, which moves by
dx/dp = (I - DP)^-1 dP/dp (analysis.orbits.section_map). With both eigenvectors, DP v = mu v, w^H DP = mu w^H,

    dmu/dp = w^H (dDP/dp) v / (w^H v),    d(ln|mu|/T)/dp = Re(mu'/mu)/T - ln|mu| T'/T^2.

dDP/dp has second derivatives of the flow in it. It is the central difference of sixth order
(directions.slope) of DP, which is exact, along the tangent to the orbits, (x + h dx/dp, p + h); so is T'. Of
several steps h, each a third of the one before, that is taken whose quotient differs least from the one
before: by the error that is told. Validity: simple multipliers. Equal ones, as where a pair meets the real
axis, have no derivative; that of |mu| at 0 is one-sided. Reference: Magnus, Econometric Theory 1 (1985)
179-191.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import eig

from jointplay.analysis.orbits.floquet import descending, exponents
from jointplay.analysis.orbits.map_derivative import map_derivative
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.solver.mechanism.directions import AT_ZERO, SIDES, slope

MULTIPLIERS = {  # what is asked of one, by its number: units
    "multiplier": "1",
    "multiplier_imaginary": "1",
    "multiplier_modulus": "1",
    "exponent": "s-1",
}
LONGEST, SHORTER, STEPS = 2e-2, 1 / 3, 7  # first step, of the parameter; the next in each; how many
SHARPER, FINEST = 1e-2, 1e-13  # tolerance of the runs in that of the orbit's; the least
GROWN = 10.0  # errors, in the least of longer steps, at which no shorter one is tried


class Change(NamedTuple):
    """Derivatives of DP and of the duration T in a parameter, and their errors."""

    DP: np.ndarray
    T: float
    DP_error: np.ndarray
    T_error: float


def change(orbit: Orbit, maps: Callable[[float], SectionMap], value: float, key: str) -> Change:
    """Derivatives of DP and of the duration of periodic orbits in a parameter.

    Parameters
    ----------
    orbit : Orbit
        At the parameter's value.
    maps : callable
        A map of the section at a value of the parameter.
    value : float
        Where.
    key : str
        Name of the parameter in messages.

    Raises
    ------
    ArithmeticError
        With the status, if the orbit could not be followed.
    """
    like = replace(orbit.map, rtol=max(SHARPER * orbit.map.rtol, FINEST), units=orbit.map.scale)

    def at(p: float) -> SectionMap:
        return replace(like, model=maps(p).model)

    here = map_derivative(at, value, orbit.state, key=key)
    if here.status:
        raise ArithmeticError(here.status)
    moves = np.linalg.solve(np.eye(len(like.free)) - here.derivative, here.along[:, 0])
    x = like.unknowns(orbit.state)

    def listed(p: float) -> np.ndarray:
        image = at(p).image(like.state(x + (p - value) * moves))
        if image.status:
            return np.full(moves.size**2 + 1, np.nan)
        return np.append(image.derivative, image.time)

    found, error = _differentiated(listed, value)
    return Change(
        found[:-1].reshape(here.derivative.shape),
        found[-1],
        error[:-1].reshape(here.derivative.shape),
        error[-1],
    )


def _differentiated(listed: Callable[[float], np.ndarray], value: float) -> tuple[np.ndarray, np.ndarray]:
    """Quotient with the best of several steps, and its error; none is tried beyond where errors grow."""
    step = LONGEST * abs(value) or AT_ZERO
    about = listed(value), SIDES[:1]
    before, best, least = slope(listed, value, step, *about), (), np.inf
    for i in range(1, STEPS):
        now = slope(listed, value, step * SHORTER**i, *about)
        error = np.nan_to_num(np.abs(now - before), nan=np.inf)
        size = float(error[:-1].max())
        if not best or size < least:
            best, least = (now, error), size
        elif size > GROWN * least:
            break
        before = now
    return best


def derivatives(
    orbit: Orbit, changes: Sequence[Change], asked: Sequence[tuple[str, int]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
    """Numbers of multipliers, their derivatives and errors; whether a wanted one is not simple.

    Parameters
    ----------
    orbit : Orbit
        Whose multipliers.
    changes : sequence of Change
        Of each parameter.
    asked : sequence of (str, int)
        Word of `MULTIPLIERS`, and number of the multiplier, counted from 1 as the largest.
    """
    mu, left, right = eig(orbit.image.derivative, left=True, right=True)
    order, T = descending(mu), orbit.image.time
    mu, left, right = mu[order], left[:, order], right[:, order]
    across = np.einsum("ij,ij->j", left.conj(), right)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes, errors = (
            np.array([np.einsum("ij,ik,kj->j", w, each, v) / over for each in parts])
            for w, v, over, parts in (
                (left.conj(), right, across, [each.DP for each in changes]),
                (np.abs(left), np.abs(right), np.abs(across), [each.DP_error for each in changes]),
            )
        )
        size = np.abs(mu)
        turned = slopes * np.exp(-1j * np.angle(mu))  # real part: along the multiplier
        rate, times = exponents(mu, T), np.array([[each.T, each.T_error] for each in changes])
        parts = {
            "multiplier": (mu.real, slopes.real, errors),
            "multiplier_imaginary": (mu.imag, slopes.imag, errors),
            "multiplier_modulus": (size, np.where(size > 0, turned.real, np.abs(slopes)), errors),
            "exponent": (
                rate,
                turned.real / size / T - rate * times[:, :1] / T,
                errors / size / T + np.abs(rate) * times[:, 1:] / T,
            ),
        }
    columns = [tuple(part[..., number - 1] for part in parts[word]) for word, number in asked]
    values, found, error = (np.array(each) for each in zip(*columns, strict=True))
    # an error of DP parts two equal ones, and both their eigenvectors, by its root
    simple = all(abs(across[number - 1]) > np.sqrt(orbit.map.rtol) for _, number in asked)
    return values, found, error, not simple
