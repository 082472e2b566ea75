"""Forms by which numbers follow parameters, found from samples and verified on others.

A number that a parameter x changes is, with v_0 and x_0 as they are stored,

    power        v = v_0 (x / x_0)^n
    polynomial   v = sum c_k z^k, z = x / x_0 - 1, of low degree

and one that several change, with d_i what each of them by itself adds to v_0,

    times        v = v_0 prod (1 + d_i / v_0)
    products     v = v_0 + sum d_i + sum k_ij d_i d_j + sum k_ijl d_i d_j d_l

What has none of these forms is refused, never approximated; tolerances may be off by `ROUGHLY`.
"""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

EXACT, ROUGHLY = 3e-14, 10.0  # what forms may leave: relative; a factor
HIGHEST = 6  # degree of a polynomial


def form(
    ratio: np.ndarray, series: np.ndarray, value: float, allowed: tuple[float, bool]
) -> tuple[str, list[float]] | None:
    """Form of a number that is `series` where the parameter is `ratio` times its stored value."""
    powers = bool(value) and bool(np.all(series / value > 0))
    if powers:
        n = round(2 * np.log(series[1] / value) / np.log(ratio[1])) / 2
        if close(value * ratio**n, series, allowed[0]):
            return "power", [n]
    z = ratio - 1
    for degree in range(1, HIGHEST + 1):
        basis = np.vander(z, degree + 1, increasing=True)[:, 1:]
        c = np.linalg.lstsq(basis, series - value, rcond=None)[0]
        if close(value + basis @ c, series, allowed[0]):
            return "polynomial", [value, *c.tolist()]
    if powers and allowed[1]:
        n = float(np.polyfit(np.log(ratio), np.log(series / value), 1)[0])
        return ("power", [n]) if near(value * ratio**n, series) else None
    return None


def close(found: Any, wanted: np.ndarray, allowed: float) -> bool:
    """Whether numbers are those wanted, to rounding or to what is allowed."""
    same = np.isinf(wanted) & (found == wanted)
    allowed = max(allowed, EXACT * np.max(np.abs(wanted[~same]), initial=0.0))
    with np.errstate(invalid="ignore"):
        return bool(np.all(same | (np.abs(found - wanted) <= allowed)))


def near(found: Any, wanted: np.ndarray) -> bool:
    """Whether they are those wanted, roughly."""
    return bool(np.all(np.abs(np.log(found / wanted)) <= np.log(ROUGHLY)))


def rule(added: np.ndarray, series: np.ndarray, value: float, allowed: tuple[float, bool]) -> Any:
    """How what each slider adds by itself, shape (points, sliders), goes together; None where it does not."""
    times = value * np.prod(1 + added / value, 1) if value else None
    if value and close(times, series, allowed[0]):
        return "times"
    plus, columns = value + np.sum(added, 1), range(added.shape[1])
    for most in (1, 2, 3):
        sets = [each for size in range(2, most + 1) for each in combinations(columns, size)]
        products = np.array([np.prod(added[:, each], 1) for each in sets]).reshape(-1, len(series))
        sizes = np.linalg.norm(products, axis=1)[:, None]
        if 2 * len(sets) > len(series) or not np.all(sizes > 0):
            break
        k = np.linalg.lstsq((products / sizes).T, series - plus, rcond=1e-12)[0] / sizes[:, 0]
        if close(plus + k @ products, series, allowed[0]):
            told = np.abs(k) * sizes[:, 0] > EXACT * np.linalg.norm(series)
            return [(k[n].item(), *sets[n]) for n in np.flatnonzero(told)]
    rough = allowed[1] and value and np.all(times / series > 0) and near(times, series)
    return "times" if rough else None
