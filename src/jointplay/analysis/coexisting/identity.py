"""Identity of motions over a parameter: which motion at one value is the same as one at the next.

Two motions at neighbouring values are one if their sets of section points are near: no point of one farther
than `reach` from the nearest of the other, in any coordinate; of motions without a period that holds for nine
points in ten. Nearest pairs go first, but before them pairs in which one, carried to the other's value, ends
on the other. Each motion has one partner at most on either side. An identity that has none begins or ends
there: it ends in a merger if it lies within reach of the motion to which it goes on, and begins in a split
likewise.

Identities are numbered by the value at which they begin, then as motions are sorted there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

MOST = 0.9  # share of the points of a motion without a period that must be near
EVENTS = ("birth", "split", "death", "merger")
Landing = Mapping[tuple[int, int, int], int]  # (value, motion, other value): the motion there


@dataclass(frozen=True)
class Change:
    """Beginning or end of an identity between two values; `other`: where it comes from, or 0."""

    kind: str
    identity: int
    other: int
    between: tuple[int, int]


def distance(one: Mapping[str, Any], other: Mapping[str, Any]) -> tuple[float, float]:
    """Distance of one motion's points from another's, and the other way round."""
    apart = np.abs(one["points"][:, None, :] - other["points"][None, :, :]).max(axis=-1)
    share = 1.0 if one["period"] and other["period"] else MOST
    return float(np.quantile(apart.min(axis=1), share)), float(np.quantile(apart.min(axis=0), share))


def identities(
    motions: Sequence[Sequence[Mapping[str, Any]]], lands: Landing, reach: float
) -> tuple[list[list[int]], list[Change], list[list[float]]]:
    """Give every motion its identity.

    Parameters
    ----------
    motions : sequence of sequence
        Of each value, its motions.
    lands : mapping
        Where motions end that are carried to a neighbouring value.
    reach : float
        Largest distance of neighbours that are one.

    Returns
    -------
    list of list of int, list of Change, list of list of float
        Identities, from 1; where they begin and end; distances from the same at the value before, or NaN.
    """
    numbers = [list(range(1, 1 + len(motions[0])))] if motions else []
    apart, changes, last = [[np.nan] * len(each) for each in motions], [], len(motions[0]) if motions else 0
    for j in range(1, len(motions)):
        i, pairs = j - 1, _pairs(motions[j - 1], motions[j], _supported(lands, j - 1, j), reach)
        here = {b: numbers[i][a] for a, b, _ in pairs}
        for _, b, far in pairs:
            apart[j][b] = far
        for b in range(len(motions[j])):
            if b not in here:
                here[b] = last = last + 1
        numbers.append([here[b] for b in range(len(motions[j]))])
        ended = set(range(len(motions[i]))) - {a for a, _, _ in pairs}
        begun = set(range(len(motions[j]))) - {b for _, b, _ in pairs}
        ways = ((ended, i, j, EVENTS[2:]), (begun, j, i, EVENTS[:2]))
        for those, at, away, kinds in ways:
            for n in sorted(those):
                to = lands.get((at, n, away), -1)
                near = to >= 0 and distance(motions[at][n], motions[away][to])[0] <= reach
                other = numbers[away][to] if to >= 0 else 0
                changes.append(Change(kinds[near], numbers[at][n], other, (i, j)))
    return numbers, changes, apart


def _supported(lands: Landing, i: int, j: int) -> set[tuple[int, int]]:
    """Pairs of which one ends on the other when it is carried there."""
    up = {(a, to) for (at, a, away), to in lands.items() if (at, away) == (i, j) and to >= 0}
    return up | {(to, b) for (at, b, away), to in lands.items() if (at, away) == (j, i) and to >= 0}


def _pairs(
    before: Sequence[Mapping[str, Any]],
    after: Sequence[Mapping[str, Any]],
    supported: set[tuple[int, int]],
    reach: float,
) -> list[tuple[int, int, float]]:
    """Motions at neighbouring values that are one, with their distances."""
    far = {
        (a, b): max(distance(before[a], after[b])) for a, b in product(range(len(before)), range(len(after)))
    }
    order = sorted(
        (pair for pair in far if far[pair] <= reach), key=lambda p: (p not in supported, far[p], p)
    )
    found, taken = [], (set(), set())
    for a, b in order:
        if a not in taken[0] and b not in taken[1]:
            taken[0].add(a)
            taken[1].add(b)
            found.append((a, b, far[a, b]))
    return found
