"""Dataset of tipping: the motions, knocks and times to return, edge states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jointplay.analysis.coexisting.knocks import UNITS, Knock
from jointplay.analysis.coexisting.smallest import ABOVE, AT, BELOW
from jointplay.analysis.coexisting.smallest import SHARES as TRIED
from jointplay.analysis.labels import labelled, number
from jointplay.analysis.orbits.floquet import multipliers
from jointplay.analysis.orbits.orbit_search import at_phase
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.starts import state_names
from jointplay.analysis.states.basin_uncertainty import wilson
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.model import Model

PARTS, DIMS = ("real", "imaginary"), ("number", "knock")
Answers = Mapping[tuple[int, int], Entry]


def edge_entry(orbit: Orbit, base: Model) -> Entry:
    """Answer on an edge state: period, state at the section, multipliers, the largest first."""
    state, _ = at_phase(orbit, base.crank_angle)
    each = multipliers(orbit.image.derivative)
    table = np.stack([each.real, each.imag], -1)
    found = {"period": orbit.map.turns, "period_time": orbit.image.time, "residual": orbit.residual}
    return found | {"state": state, "multiplier": table}


@dataclass(frozen=True)
class Table:
    """The motions of a model, and kinds of knock."""

    base: Model
    motions: Sequence[Mapping[str, Any]]
    seeded: Entry
    kinds: Sequence[Knock]
    starts: int

    @property
    def shape(self) -> tuple[int, int]:
        """Number of motions, and of kinds of knock."""
        return len(self.motions), len(self.kinds)

    def coordinates(self, shares: Sequence[float]) -> dict[str, Any]:
        """Numbers of motions, names of knocks and states."""
        names = np.array([each.name for each in self.kinds], dtype=str)
        rows = {"number": (np.arange(1, len(self.motions) + 1), "1", "number of the motion")}
        states = np.array(state_names(self.base), dtype=str)
        return {
            **labelled(rows, "number"),
            "knock": ("knock", names, {"long_name": "kind of knock"}),
            "state": ("state", states, {"long_name": "state"}),
            "part": ("part", np.array(PARTS), {"long_name": "part of a complex number"}),
            "knock_share": number("knock_share", np.array(shares), "1", "share of the knock"),
            "tried_share": number("tried_share", np.array(TRIED), "1", "share of the knock that was tried"),
        }

    def motions_found(self, times: Entry) -> dict[str, Any]:
        """Periods, points and fractions of the motions; fractions of the starts that reach them in time."""
        started = self.starts - self.seeded.get("no_start", 0)
        count = np.array([each["count"] for each in self.motions], dtype=int)
        low, high = wilson(count, started)
        fraction = count / started if started else np.full(len(count), np.nan)
        longest = max((len(each["states"]) for each in self.motions), default=0)
        states = np.full((len(self.motions), longest, len(self.base.state)), np.nan)
        for row, each in zip(states, self.motions, strict=True):
            row[: len(each["states"])] = each["states"]
        rows = {
            "period": (
                np.array([each["period"] for each in self.motions], int),
                "1",
                "period in turns; 0: none",
            ),
            "count": (count, "1", "starts that reach the motion"),
            "fraction": (fraction, "1", "fraction of the starts that reach the motion"),
            "fraction_low": (low, "1", "lower end of the 95 % interval of the fraction"),
            "fraction_high": (high, "1", "upper end of the 95 % interval of the fraction"),
        }
        within = np.asarray(times.get("within", np.zeros(0)), dtype=int)
        counts = np.asarray(times.get("counts", np.zeros((len(self.motions), 0))))
        shares = counts / started if started else np.full(counts.shape, np.nan)
        reached = {
            "fraction_reached": (shares, "1", "fraction of the starts that are with the motion by then")
        }
        found = labelled(rows, "number") | labelled(reached, ("number", "within"))
        whole = {"section_state": (states, "1", "states at the section (SI)")}
        turns = {"within": (within, "1", "turns")}
        return found | labelled(whole, ("number", "point", "state")) | labelled(turns, "within")

    def knocks_found(self, answers: Answers, shares: Sequence[float]) -> dict[str, Any]:
        """Smallest knocks, where these and others near them lead, and turns to return."""
        place = self._filled(answers, "place", np.full(3, np.nan))
        size, safe, confirmed, share = (
            self._filled(answers, name, np.nan) for name in ("size", "safe", "confirmed", "share")
        )
        reaches = self._filled(answers, "ends", np.full(len(TRIED), -4.0)).astype(int) + 1
        reaches = np.where(reaches > 0, reaches, -1)
        below, above = reaches[..., BELOW], reaches[..., ABOVE]
        own = 1 + np.arange(len(self.motions))[:, None]
        right = np.isfinite(size) & (below == own) & (above != own) & (above > 0)
        rows = {
            "knock_size": (size, "1", "smallest knock that tips; see knock_units"),
            "knock_safe": (
                safe,
                "1",
                "largest knock there up to which each one tried returns; see knock_units",
            ),
            "knock_point": (place[..., 0], "1", "section point of the motion, from 0"),
            "knock_phase": (place[..., 1], "rad", "angle of a turn after it"),
            "knock_direction": (place[..., 2], "rad", "direction of the knock; 0 and pi are its two signs"),
            "confirmed_size": (
                confirmed,
                "1",
                "smallest knock there that is confirmed, up to 1.2 of knock_size; see knock_units",
            ),
            "tipping_share": (
                share,
                "1",
                "fraction that tips of sizes from knock_size to 1.2 of it; NaN if that is confirmed",
            ),
            "knock_reaches": (reaches[..., AT], "1", "motion that the knock leads to; -1: none"),
            "below_reaches": (below, "1", "motion that 0.99 of the knock leads to; -1: none"),
            "above_reaches": (above, "1", "motion that 1.01 of the knock leads to; -1: none"),
            "knock_confirmed": (
                right.astype(np.int8),
                "1",
                "1: the former is the motion itself, the latter another",
            ),
        }
        tried = {"tried_reaches": (reaches, "1", "motion that a share of the knock leads to; -1: none")}
        returns = self._filled(answers, "returns", np.full(len(shares), -1.0)).astype(int)
        turns = {"return_turns": (returns, "1", "turns to return; -1: not in time")}
        units = np.array([UNITS[each.kind] for each in self.kinds], dtype=str)
        return {
            **labelled(rows, DIMS),
            **labelled(tried, (*DIMS, "tried_share")),
            **labelled({"knock_units": (units, "1", "units of its size")}, "knock"),
            **labelled(turns, (*DIMS, "knock_share")),
        }

    def edges_found(self, answers: Answers) -> dict[str, Any]:
        """States on the boundaries that the smallest knocks cross."""
        period = self._filled(answers, "period", 0).astype(int)
        time, residual = (self._filled(answers, name, np.nan) for name in ("period_time", "residual"))
        rows = {
            "edge_period": (period, "1", "period in turns; 0: none found"),
            "edge_period_time": (
                time,
                "s",
                "time of a period of the edge state; of an equilibrium the nominal period",
            ),
            "edge_residual": (residual, "1", "change over a period, in scales"),
        }
        state = self._filled(answers, "state", np.full(len(self.base.state), np.nan))
        free = max((len(each["multiplier"]) for each in answers.values() if "multiplier" in each), default=0)
        multiplier = self._filled(answers, "multiplier", np.full((free, len(PARTS)), np.nan))
        states = {"edge_state": (state, "1", "edge state at the section (SI)")}
        pairs = {"edge_multiplier": (multiplier, "1", "multiplier of the edge state")}
        found = labelled(rows, DIMS) | labelled(states, (*DIMS, "state"))
        return found | labelled(pairs, (*DIMS, "multiplier", "part"))

    def _filled(self, answers: Answers, name: str, missing: Any) -> np.ndarray:
        table = np.empty((*self.shape, *np.shape(missing)))
        table[...] = missing
        for (own, kind), answer in answers.items():
            if name in answer:
                table[own, kind] = answer[name]
        return table
