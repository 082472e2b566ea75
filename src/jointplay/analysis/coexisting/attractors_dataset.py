"""Dataset of attractors over a parameter: motions by identity, fractions, where identities change."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from jointplay.analysis.coexisting.identity import EVENTS, Change
from jointplay.analysis.exponents import section_exponents
from jointplay.analysis.labels import coded, labelled
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states.basin_uncertainty import wilson
from jointplay.analysis.sweeps import gather
from jointplay.analysis.sweeps.attractor import Plan
from jointplay.analysis.sweeps.chains import numbered
from jointplay.analysis.vary import Axis
from jointplay.jobs.job import Entry

if TYPE_CHECKING:
    import xarray as xr

NOT_RUN = STATUS.index("not_run")
ABSENT = -1  # period of a motion at a value where it is not there
MISSED = 0.05  # chance that a basin of `fraction_missed` has no start in it


@dataclass(frozen=True)
class Table:
    """Motions found at each value, with their identities."""

    axis: Axis
    motions: Sequence[Sequence[Mapping[str, Any]]]
    numbers: Sequence[Sequence[int]]
    apart: Sequence[Sequence[float]]
    seeded: Sequence[Entry]
    starts: int

    @property
    def dims(self) -> tuple[str, str]:
        """Dimensions that identify a motion: value and identity."""
        return self.axis.name, "identity"

    @property
    def shape(self) -> tuple[int, int]:
        """Number of values, and of identities."""
        return len(self.axis.values), max((n for each in self.numbers for n in each), default=0)

    @property
    def coordinates(self) -> dict[str, Any]:
        """Values of the parameter, and numbers of the motions."""
        own = numbered("identity", self.shape[1], "number of the motion", 1)
        return {self.axis.name: self.axis.coordinate} | own

    def dataset(self, answers: Mapping[tuple[int, int], Entry], plan: Plan) -> xr.Dataset:
        """Dataset of the descriptions of all motions, by (value, identity)."""
        absent = {"status": NOT_RUN, "trouble": ""}
        places = [(i, n + 1) for i, n in np.ndindex(self.shape)]
        entries = [(f"{i} {n}", answers.get((i, n), absent)) for i, n in places]
        keys = [key for key, _ in entries]
        found = gather.dataset("attractors", self, keys, lambda: iter(entries))
        found = found.rename(cell_status="attractor_status").drop_vars("period", errors="ignore")
        found["attractor_status"].attrs["long_name"] = (
            "how the motion's description ended; not_run: not there"
        )
        counts = numbered("point", plan.keep, "section point")
        counts |= numbered("exponent", plan.exponents, "number of the exponent", 1)
        counts |= numbered("multiplier", found.sizes.get("multiplier", 0), section_exponents.NUMBER, 1)
        found.attrs.pop("swept")
        return found.assign_coords({dim: each for dim, each in counts.items() if dim in found.dims})

    def fractions(self) -> dict[str, Any]:
        """Periods of motions, and their fractions of the starts that could begin."""
        started = self.starts - self._counted("no_start")
        count, low, high = self._filled("count", 0), *np.full((2, *self.shape), np.nan)
        for i, total in enumerate(started):
            low[i], high[i] = wilson(count[i], int(total))
        there = self._filled("period", ABSENT) > ABSENT
        share = {"count": count, "fraction": _over(count, started[:, None]), "fraction_low": low}
        share |= {"fraction_high": high}
        share = {
            name: np.where(there, each, 0 if name == "count" else np.nan) for name, each in share.items()
        }
        rows = {
            "period": (self._filled("period", ABSENT), "1", "period in turns; 0: none found; -1: not there"),
            "count": (share["count"].astype(int), "1", "starts that reach the motion"),
            "fraction": (share["fraction"], "1", "fraction of the starts that reach the motion"),
            "fraction_low": (share["fraction_low"], "1", "lower end of the 95 % interval of the fraction"),
            "fraction_high": (share["fraction_high"], "1", "upper end of the 95 % interval of the fraction"),
            "carried": ((there & (count == 0)).astype(np.int8), "1", "found from a neighbouring value alone"),
            "watched_turns": (
                self._filled("watched", 0),
                "1",
                "turns that motions without period were watched",
            ),
            "section_distance": (self._placed(self.apart), "1", "distance from the same at the value before"),
        }
        return labelled(rows, self.dims) | self._ends(started)

    def _ends(self, started: np.ndarray) -> dict[str, Any]:
        """Variables on the starts at each value, such as the fraction that did not settle."""
        unsettled = self._counted("unsettled")
        pairs = [wilson(n, int(total)) for n, total in zip(unsettled, started, strict=True)]
        low, high = np.array(pairs, dtype=float).reshape(-1, 2).T
        with np.errstate(divide="ignore"):
            missed = np.where(started > 0, 1 - MISSED ** (1 / np.maximum(started, 1)), 1.0)
        rows = {
            "started": (started, "1", "starts that there are"),
            "fraction_unsettled": (
                _over(unsettled, started),
                "1",
                "fraction of the starts that did not settle",
            ),
            "fraction_unsettled_low": (low, "1", "lower end of its 95 % interval"),
            "fraction_unsettled_high": (high, "1", "upper end of its 95 % interval"),
            "fraction_failed": (
                _over(self._counted("failed"), started),
                "1",
                "fraction of the starts that failed",
            ),
            "fraction_missed": (missed, "1", "fraction from which on a basin has a start in it with 95 %"),
        }
        status = [each["status"] for each in self.seeded]
        codes = coded(self.dims[0], status, "how the search at the value ended")
        trouble = np.array([each.get("trouble", "") for each in self.seeded], dtype=str)
        told = labelled({"value_trouble": (trouble, "1", "what went wrong in the search")}, self.dims[0])
        return labelled(rows, self.dims[0]) | {"value_status": codes} | told

    def changes(self, events: Sequence[Change]) -> dict[str, Any]:
        """Variables on the beginnings and ends of identities."""
        values = np.array(self.axis.values)
        between = np.array([each.between for each in events], dtype=int).reshape(-1, 2)
        units, name = self.axis.units, self.axis.long_name
        rows = {
            "change_identity": (
                self._whole(each.identity for each in events),
                "1",
                "motion that begins or ends",
            ),
            "change_other": (
                self._whole(each.other for each in events),
                "1",
                "where it comes from, or goes; 0: nowhere",
            ),
            "change_low": (values[between[:, 0]], units, f"{name} below the change"),
            "change_high": (values[between[:, 1]], units, f"{name} above the change"),
        }
        codes = [EVENTS.index(each.kind) for each in events]
        return labelled(rows, "change") | {"change_kind": coded("change", codes, "kind of change", EVENTS)}

    @staticmethod
    def _whole(each: Iterable[int]) -> np.ndarray:
        return np.array([*each], dtype=np.int32)

    def _filled(self, name: str, missing: int) -> np.ndarray:
        return self._placed([[each[name] for each in row] for row in self.motions], missing).astype(np.int32)

    def _placed(self, rows: Sequence[Sequence[float]], missing: float = np.nan) -> np.ndarray:
        """Numbers of motions, by value and identity."""
        table = np.full(self.shape, missing, dtype=float)
        for i, (numbers, row) in enumerate(zip(self.numbers, rows, strict=True)):
            table[i, np.array(numbers, dtype=int) - 1] = row
        return table

    def _counted(self, name: str) -> np.ndarray:
        """Starts of each value that ended in a way; all of a value that could not be searched failed."""
        missing = self.starts if name == "failed" else 0
        return np.array([each.get(name, missing) for each in self.seeded], dtype=int)


def _over(count: np.ndarray, total: np.ndarray) -> np.ndarray:
    """Fractions; NaN of nothing."""
    return np.where(total > 0, count / np.maximum(total, 1), np.nan)
