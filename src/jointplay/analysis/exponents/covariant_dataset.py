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
from jointplay.analysis.labels import labelled, number
from jointplay.analysis.starts import crank_place, state_names
from jointplay.solver.mechanism.model import Model

KEYS = {"covariant": "exponent of the covariant vector", "lyapunov": "Lyapunov exponent, by the frame"}


class Vectors(NamedTuple):
    """Vectors over a block: columns of C at its end, and the ln of their growth over it."""

    block: Block
    C: np.ndarray
    growth: np.ndarray


class Point(NamedTuple):
    """What is known at a section point: its block, C, and the vectors' shares of parts (rows)."""

    block: Block
    C: np.ndarray
    shares: np.ndarray

    @property
    def vectors(self) -> np.ndarray:
        """Columns of unit length, in units of the states' scales."""
        return self.block.frame[:, : len(self.C)] @ self.C


class Findings:
    """What the vectors of a motion, block by block, come to.

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
        """Add those of the next blocks, and how far from settled they are where these end."""
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
        """How many vectors there are all the way."""
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
        """Coordinates of the dataset."""
        numbers = {"vector": (self.count, "number of the vector, that of the largest exponent first")}
        numbers["splitting"] = (self.count - 1, "number of vectors before the splitting")
        numbers["turn"] = (len(self.points), "section point")
        names = {
            "part": (self.participation.parts, "what moves"),
            "component": (state_names(self.model), "state"),
        }
        first = {"turn": 0}
        coords = {
            dim: number(dim, np.arange(size) + first.get(dim, 1), "1", text)
            for dim, (size, text) in numbers.items()
        }
        return coords | {
            dim: (dim, np.array(labels, dtype=str), {"long_name": text})
            for dim, (labels, text) in names.items()
        }

    def variables(self, turning: bool) -> dict[str, Any]:
        """Variables of the dataset; those per turn where something turns."""
        count, variables = self.count, self._exponents(turning)
        residual = np.max([each[:count] for each in self.residuals], axis=0)
        text = "largest angle between vectors from two beginnings of the backward pass, or two first frames"
        variables |= labelled({"settling_residual": (residual, "rad", text)}, "vector")
        return variables | self._at_points() if self.points else variables

    def _exponents(self, turning: bool) -> dict[str, Any]:
        count, times = self.count, np.array([time for time, _ in self.rows])
        sums = np.array([each[:, :count] for _, each in self.rows])
        columns, table = slice(1, 1 + count), {}
        for place, (key, name) in enumerate(KEYS.items()):
            rows = np.column_stack([times, sums[:, place]])
            values, errors = batch_means.growth(rows, columns), batch_means.standard_error(rows, columns)
            table |= {f"{key}_exponent": (values, "s-1", name)}
            table |= {f"{key}_standard_error": (errors, "s-1", f"standard error of the {name}")}
        if turning:
            turn, said = self.turn, dict(table)
            table |= {
                f"{name}_per_turn": (v * turn, "1", f"{text}, per turn")
                for name, (v, _, text) in said.items()
            }
        rows = np.column_stack([times, sums[:, 0]])
        correlation = batch_means.batch_correlation(rows, columns)
        table["covariant_batch_correlation"] = (correlation, "1", "correlation of a batch mean with the next")
        variables = labelled(table, "vector")
        return variables | (
            labelled({"turn_period": (turn, "s", "mean period of a turn")}) if turning else {}
        )

    def _at_points(self) -> dict[str, Any]:
        count, points = self.count, self.points
        vectors = np.array([point.vectors[:, :count].T for point in points])
        shares = np.array([point.shares[:, :count].T for point in points])
        angles = np.array([splittings(point.C[:count, :count]) for point in points])
        times = np.array([point.block.time for point in points])
        errors = np.apply_along_axis(standard_error, 0, shares)
        share = number(("turn", "vector", "part"), shares, "1", "share of a part in a vector")
        share[2]["norm"] = self.participation.norm
        between = "smallest angle between the first vectors and all others"
        variables = {"share": share, "time": number("turn", times, "s", "time of the section point")}
        states = np.array([point.block.state for point in points])
        variables["section_state"] = number(("turn", "component"), states, "1", "state, in SI units")
        text = "vector of unit length, in units of the states' scales"
        variables["covariant_vector"] = number(("turn", "vector", "component"), vectors, "1", text)
        means = {"mean_share": (shares.mean(axis=0), "1", "mean share of a part in a vector")}
        means["mean_share_standard_error"] = (errors, "1", "standard error of the mean share")
        variables |= labelled(means, ("vector", "part"))
        variables["splitting_angle"] = number(("turn", "splitting"), angles, "rad", between)
        variables["smallest_angle"] = number(
            "splitting", angles.min(axis=0), "rad", f"{between}, of all points"
        )
        return variables | (self._along(vectors) if section_exponents.timeless(self.model) else {})

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
        text = "angle of the neutral vector with the rate of the state"
        variables = labelled({"neutral_vector": (np.int64(best + 1), "1", "vector along the motion")})
        return variables | labelled({"neutral_angle": (angles[:, best], "rad", text)}, "turn")
