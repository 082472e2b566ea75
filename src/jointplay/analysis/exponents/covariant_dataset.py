"""Covariant vectors as a dataset: exponents with errors; vectors, angles and shares at section points."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from jointplay.analysis.exponents import batch_means, section_exponents
from jointplay.analysis.exponents.covariant_record import Block
from jointplay.analysis.exponents.covariant_vectors import angles_between, splittings
from jointplay.analysis.exponents.growth import standard_error
from jointplay.analysis.exponents.participation import Participation
from jointplay.analysis.starts import crank_place, state_names
from jointplay.solver.mechanism.model import Model


class Vectors(NamedTuple):
    """Vectors over a block: columns of C at its end, and the ln of their growth over it."""

    block: Block
    C: np.ndarray
    growth: np.ndarray


class Point(NamedTuple):
    """A section point: its block, C, and the vectors' shares of parts (rows)."""

    block: Block
    C: np.ndarray
    shares: np.ndarray

    @property
    def vectors(self) -> np.ndarray:
        """Columns of unit length, in units of the states' scales."""
        return self.block.frame[:, : len(self.C)] @ self.C


class Findings:
    """Findings on the vectors of a motion, gathered block by block.

    Parameters
    ----------
    model : Model
        What moves.
    begin, until : float
        Ends of the stretch, s.
    """

    def __init__(self, model: Model, begin: float, until: float):
        self.model, self.participation = model, Participation(model)
        self.points: list[Point] = []
        self.residuals: list[np.ndarray] = []
        self.sums: np.ndarray | None = None
        self.rows: list[tuple[float, np.ndarray]] = []
        self.begin, self.row = begin, (until - begin) / batch_means.BLOCKS

    def add(self, vectors: list[Vectors], residual: np.ndarray) -> None:
        """Add the vectors of the next blocks, and their distance from settled ones at the end."""
        self.residuals.append(residual)
        for block, C, grown in vectors:
            growth = np.array([grown, block.growth])
            if self.sums is None:
                self.sums = np.zeros_like(growth)
                self.rows.append((self.begin, self.sums))
            self.sums = self.sums[:, : growth.shape[1]] + growth
            if block.time >= self.begin + len(self.rows) * self.row:
                self.rows.append((block.time, self.sums))
            if block.state is not None:
                shares = self.participation(block.time, block.state, block.frame[:, : len(C)] @ C)
                self.points.append(Point(block, C, shares))

    @property
    def count(self) -> int:
        """Number of vectors that last all the way."""
        return min(self.sums.shape[1], *(len(each) for each in self.residuals))

    @property
    def turn(self) -> float:
        """Mean length of a turn, s."""
        crank, blocks = crank_place(self.model), [point.block for point in self.points]
        if crank is None or len(blocks) < 2:
            return self.model.period
        angle = blocks[-1].state[crank] - blocks[0].state[crank]
        return math.tau * (blocks[-1].time - blocks[0].time) / abs(angle)

    def coordinates(self) -> dict[str, Any]:
        """Values of the coordinates."""
        return {
            "vector": np.arange(1, self.count + 1),
            "splitting": np.arange(1, self.count),
            "turn": np.arange(len(self.points)),
            "part": np.array(self.participation.parts, dtype=str),
            "component": np.array(state_names(self.model), dtype=str),
        }

    def values(self, turning: bool) -> dict[str, Any]:
        """Values of the variables; also per turn where something turns."""
        found = self._exponents(turning)
        found["settling_residual"] = np.max([each[: self.count] for each in self.residuals], axis=0)
        return found | self._at_points() if self.points else found

    def _exponents(self, turning: bool) -> dict[str, Any]:
        count, times = self.count, np.array([time for time, _ in self.rows])
        sums = np.array([each[:, :count] for _, each in self.rows])
        columns, found = slice(1, 1 + count), {}
        for place, key in enumerate(("covariant", "lyapunov")):
            rows = np.column_stack([times, sums[:, place]])
            found[f"{key}_exponent"] = batch_means.growth(rows, columns)
            found[f"{key}_standard_error"] = batch_means.standard_error(rows, columns)
        if turning:
            found |= {f"{name}_per_turn": each * self.turn for name, each in found.items()}
            found["turn_period"] = self.turn
        rows = np.column_stack([times, sums[:, 0]])
        return found | {"covariant_batch_correlation": batch_means.batch_correlation(rows, columns)}

    def _at_points(self) -> dict[str, Any]:
        count, points = self.count, self.points
        vectors = np.array([point.vectors[:, :count].T for point in points])
        shares = np.array([point.shares[:, :count].T for point in points])
        angles = np.array([splittings(point.C[:count, :count]) for point in points])
        found = {
            "share": shares,
            "time": np.array([point.block.time for point in points]),
            "section_state": np.array([point.block.state for point in points]),
            "covariant_vector": vectors,
            "mean_share": shares.mean(axis=0),
            "mean_share_standard_error": np.apply_along_axis(standard_error, 0, shares),
            "splitting_angle": angles,
            "smallest_angle": angles.min(axis=0),
        }
        return found | (self._along(vectors) if section_exponents.timeless(self.model) else {})

    def _along(self, vectors: np.ndarray) -> dict[str, Any]:
        """The vector that is the motion's own direction, and its angle with that."""
        rates = np.array([point.block.rate for point in self.points])
        sizes = np.linalg.norm(rates, axis=1)
        if not np.all(sizes > 0):
            return {}
        angles = np.array(
            [angles_between(V.T, (F / s)[:, None]) for V, F, s in zip(vectors, rates, sizes, strict=True)]
        )
        best = int(np.argmin(np.median(angles, axis=0)))
        return {"neutral_vector": np.int64(best + 1), "neutral_angle": angles[:, best]}
