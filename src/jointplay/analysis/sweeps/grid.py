"""From what was found at the points of a sweep to arrays over the whole: what a point lacks is filled in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.analysis.quantities import flags
from jointplay.analysis.words import STATUS

NOT_KNOWN = -1  # of whole numbers, as a period
LABELLED = {"link": "link", "joint": "joint with clearance", "pin": "ideal joint", "state": "state"}
ATTRIBUTES = {
    "period": ("1", "period in section points"),
    "turn_period": ("s", "mean period of a turn"),
    "impacts": ("1", "contacts begun a turn"),
    "separations": ("1", "contacts lost a turn"),
    "contact_fraction": ("1", "fraction of time in contact"),
    "smallest_impact_speed": ("m s-1", "smallest speed at which a contact began"),
    "smallest_missed_gap": ("m", "smallest gap of an approach that missed contact"),
    "mode_word": ("1", "contact modes of the turn, one after another"),
    "lyapunov_exponent": ("s-1", "Lyapunov exponent"),
    "lyapunov_standard_error": ("s-1", "standard error of the Lyapunov exponent"),
    "lyapunov_exponent_per_turn": ("1", "Lyapunov exponent a turn"),
    "lyapunov_standard_error_per_turn": ("1", "standard error of the Lyapunov exponent a turn"),
    "end_state": ("1", "positions and speeds at the end"),
    "n_steps": ("1", "accepted steps"),
    "trouble": ("1", "what went wrong"),
}
COMMENTS = {
    "period": "turns, where the section is a crank angle; 0: none within period_tolerance; -1: not known",
    "mode_word": "f free, r released, + - slip, s stick, c contact; of a test system the walls met",
    "end_state": "rad, m, rad/s, m/s; accepted as a start",
}
LENGTHS = ("smallest_impact_speed", "smallest_missed_gap")  # a test system's have no units


@dataclass(frozen=True)
class Grid:
    """The points of a sweep.

    Parameters
    ----------
    dims : tuple of str
        Their dimensions.
    shape : tuple of int
        Their numbers along these.
    keep : int
        Section points of each.
    answers : mapping of index to dict
        What was found at each (`attractor.settle`); a point that failed has ``status`` and ``trouble`` only.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    keep: int
    answers: Mapping[tuple[int, ...], dict[str, Any]]

    @property
    def labels(self) -> dict[str, list[str]]:
        """Names along link, joint, pin and state, of all points together."""
        found: dict[str, dict[str, None]] = {dim: {} for dim in LABELLED}
        for answer in self.answers.values():
            for dim in LABELLED:
                found[dim] |= dict.fromkeys(_own(answer, dim))
        return {dim: list(names) for dim, names in found.items()}

    @property
    def variables(self) -> dict[str, Any]:
        """Every variable, as (dims, values, attributes)."""
        labels, found = self.labels, {}
        for index, answer in self.answers.items():
            for name, (dims, values, told) in _parts(answer).items():
                values = np.asarray(values)
                if name not in found:
                    found[name] = ((*self.dims, *dims), self._empty(dims, values, labels), told)
                places = [
                    [labels[dim].index(label) for label in _own(answer, dim)] if dim in labels else range(n)
                    for dim, n in zip(dims, values.shape, strict=True)
                ]
                found[name][1][(*index, *np.ix_(*places))] = values
        written = {name: (dims, _text(values), told) for name, (dims, values, told) in found.items()}
        return written | self._ends()

    def _empty(self, dims: tuple[str, ...], values: np.ndarray, labels: dict[str, list[str]]) -> np.ndarray:
        """An array over the grid and further dimensions, without values."""
        sizes = {"point": self.keep} | {dim: len(names) for dim, names in labels.items()}
        own = [sizes.get(dim, n) for dim, n in zip(dims, values.shape, strict=True)]
        fill = {"i": np.array(NOT_KNOWN, values.dtype), "U": np.array("", object)}
        return np.full((*self.shape, *own), fill.get(values.dtype.kind, np.array(np.nan)))

    def _ends(self) -> dict[str, Any]:
        """How each point ended."""
        status = np.full(self.shape, STATUS.index("not_run"), dtype=np.int8)
        steps, trouble = np.zeros(self.shape, dtype=np.int64), np.full(self.shape, "", dtype=object)
        for index, answer in self.answers.items():
            status[index], trouble[index] = answer["status"], answer.get("trouble", "")
            steps[index] = answer.get("n_steps", 0)
        bad, told = status[status != 0], flags(STATUS)
        return {
            "status": ((), np.int8(bad[0] if len(bad) else 0), {"long_name": "how the sweep ended"} | told),
            "cell_status": (self.dims, status, {"long_name": "how the point ended"} | told),
            "trouble": (self.dims, _text(trouble), attributes("trouble")),
            "n_steps": (self.dims, steps, attributes("n_steps")),
        }


def _own(answer: Mapping[str, Any], dim: str) -> tuple[str, ...]:
    """Names that a point has along a dimension."""
    if dim == "state":
        return answer["end"].names if "end" in answer else ()
    return answer.get("labels", {}).get(dim, ())


def _parts(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What was found at a point, as (dims, values, attributes)."""
    found = dict(answer.get("values", {}))
    if "end" in answer:
        found["end_state"] = (("state",), answer["end"].state)
    si = bool(_own(answer, "link"))
    return dict(answer.get("points", {})) | {
        name: (*pair, attributes(name, si or name not in LENGTHS)) for name, pair in found.items()
    }


def attributes(name: str, si: bool = True) -> dict[str, str]:
    """Attributes of a variable of a sweep; without units, as a test system's lengths, unless `si`."""
    units, text = ATTRIBUTES[name]
    comment = {"comment": COMMENTS[name]} if name in COMMENTS else {}
    return {"units": units if si else "1", "long_name": text} | comment


def _text(values: np.ndarray) -> np.ndarray:
    return values.astype(str) if values.dtype == object else values
