"""Attractors over a parameter: coexisting lasting motions, and their probabilities.

At every value starts drawn at random in a region are followed until it is known where they end
(`coexisting.lasting`). Then every motion found is carried to the neighbouring values, until that brings up
nothing new; so one with a basin too narrow for the starts is found where a neighbour has it. Motions at
neighbouring values are given one identity. Each is described as a point of a sweep.
Reference for seeding, carrying and matching: G. Datseris, K. Luiz Rossi and A. Wagemakers, Chaos 33 (2023)
073151. Fractions: Wilson's interval (`states.basin_uncertainty`).

Validity: what neither a start nor a neighbour leads to is missed: with n starts, a basin of more than 3/n of
the region is found with 95 % (the rule of three). Fractions are of the region, and of no other.

Identity: two motions at neighbouring values are one if their sets of section points are near: no point of one
farther than `reach` from the nearest of the other, in any coordinate; of motions without a period that holds
for nine points in ten. Nearest pairs go first, but before them pairs in which one, carried to the other's
value, ends on the other. Each motion has one partner at most on either side. An identity that has none begins
or ends there: it ends in a merger if it lies within reach of the motion to which it goes on, and begins in a
split likewise.

Identities are numbered by the value at which they begin, then as motions are sorted there.

Bifurcations: each periodic motion is followed as an orbit, stable or not, and so an identity is followed
(`analysis.orbits.continuation`) once for every period that it has, from the middle of the values where it has
it, to one value beyond them on either side. Beginnings and ends of identities are set beside what is found
between the same two values.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise, product
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.cells import first_bad, growing, handed_out, warm
from jointplay.analysis.coexisting import passes
from jointplay.analysis.coexisting.region import Region, one_parameter, region_fits
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.keywords import Moving, Names, Recognising, analysis
from jointplay.analysis.labels import PLANE, Out, ended, xr
from jointplay.analysis.orbits.branch_points import KINDS
from jointplay.analysis.orbits.continuation import continuation
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.states.basin_uncertainty import interval_outs, wilson
from jointplay.analysis.states.ends import Observation
from jointplay.analysis.sweeps import attractor, gather
from jointplay.analysis.sweeps.attractor import RTOL, Plan
from jointplay.analysis.sweeps.bifurcation import Over, lanes_fit, names, record_fits
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.vary import Axis, at_largest, checked_axes, largest
from jointplay.display import codes
from jointplay.display.errors import InputError
from jointplay.display.number_text import counted, measured, plain
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Flag, Natural, Positive, unit
from jointplay.solver.mechanism.records import ONCE_A_TURN
from jointplay.solver.motion.ensemble_runs import in_lanes
from jointplay.solver.motion.progress import part

TRANSIENT, STEP, MOST_POINTS = 20, 0.05, 200  # turns to the orbit; longest step, and points of a branch
NONE = len(KINDS)
# seen from a branch that ends at a branch point, that is a fold too
TOLD = ("branch_point", "period_doubling", "neimark_sacker", "fold", "grazing")


def stretches(
    axis: Axis, motions: Sequence[Sequence[Mapping[str, Any]]], numbers: Sequence[Sequence[int]]
) -> list[dict[str, Any]]:
    """Branches to follow: identity, period, value and state to start from, and the range of the parameter."""
    rows = [
        (n, each["period"], i, each)
        for i, row in enumerate(numbers)
        for n, each in zip(row, motions[i], strict=True)
    ]
    rows = sorted((row for row in rows if row[1]), key=lambda row: row[:3])
    found, last = [], len(axis.values) - 1
    for (number, period), some in groupby(rows, key=lambda row: row[:2]):
        those = list(some)
        places = [i for _, _, i, _ in those]
        low, high = axis.values[max(places[0] - 1, 0)], axis.values[min(places[-1] + 1, last)]
        _, _, middle, motion = those[len(those) // 2]
        if low < high:
            start = {"value": axis.values[middle], "state": motion["states"][-1].tolist()}
            found.append({"identity": number, "period": period, "range": (low, high)} | start)
    return found


def followed(
    mechanism, parameter: str, identity: int, period: int, range: tuple[float, float], value: float,
    state: list[float], section: Any, max_steps: int | None,
) -> Entry:  # fmt: skip
    """Special points of the branch of a periodic motion."""
    branch = continuation(
        mechanism,
        section,
        parameter=parameter,
        range=tuple(range),
        start=value,
        period=period,
        initial=state,
        transient=TRANSIENT,
        step=STEP,
        max_points=MOST_POINTS,
        branch_switching=False,
        record=(),
        max_steps=max_steps,
    )
    kinds = branch["special_kind"].values.astype(int)
    return {"status": int(branch["status"]), "kind": kinds, "parameter": branch["special_parameter"].values}


OUTS = {
    "special_parameter": Out("special", "parameter at a special point", "{units}", "with `bifurcations`"),
    "special_identity": Out("special", "motion on whose branch it lies"),
    "special_period": Out("special", "period of the orbit that was followed"),
    "branch_identity": Out("branch", "motion that was followed as an orbit"),
    "branch_period": Out("branch", "its period"),
    "branch_status": Out("branch", "how the search for the orbit ended", flags=STATUS),
    "special_kind": Out("special", "what changes there", flags=KINDS),
    "change_bifurcation": Out("change", "bifurcation found there", flags=(*KINDS, "none")),
}


def special_values(
    axis: Axis, cells: Sequence[Mapping[str, Any]], answers: Sequence[Entry], events: Sequence[Change]
) -> dict[str, Any]:
    """Special points by identity, and the kind of any between the values of a beginning or an end."""
    rows = [
        (int(kind), float(value), cell["identity"], cell["period"])
        for cell, answer in zip(cells, answers, strict=True)
        for kind, value in zip(answer.get("kind", ()), answer.get("parameter", ()), strict=True)
    ]
    rows = sorted(rows, key=lambda row: (row[2], row[1], row[3], row[0]))
    kind, value, identity, period = np.array(rows, dtype=float).reshape(-1, 4).T
    return {
        "special_parameter": value,
        "special_identity": identity.astype(int),
        "special_period": period.astype(int),
        "branch_identity": np.array([cell["identity"] for cell in cells], dtype=int),
        "branch_period": np.array([cell["period"] for cell in cells], dtype=int),
        "branch_status": [answer["status"] for answer in answers],
        "special_kind": kind,
        "change_bifurcation": [_between(axis, each, rows) for each in events],
    }


def _between(axis: Axis, change: Change, rows: Sequence[tuple[int, float, int, int]]) -> int:
    """Kind of the bifurcation between the values of a change, the first in the order of `TOLD`."""
    low, high = (axis.values[i] for i in change.between)
    those = (change.identity, change.other) if change.kind in ("split", "merger") else (change.identity,)
    found = [kind for kind, value, identity, _ in rows if identity in those and low <= value <= high]
    return min(found, key=lambda kind: TOLD.index(KINDS[kind]), default=NONE)


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
        directions = ((ended, i, j, EVENTS[2:]), (begun, j, i, EVENTS[:2]))
        for those, at, away, kinds in directions:
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


STARTS, LYAPUNOV_TURNS = 1000, 100


REACH = 0.2


LISTED = 3  # motions named in a line


NOT_RUN = STATUS.index("not_run")


ABSENT = -1  # period of a motion at a value where it is not there


MISSED = 0.05  # chance that a basin of `fraction_missed` has no start in it


ROUNDS = 200  # of carrying, at most


SHARES = (0.0, 0.7, 0.8, 1.0)  # of the progress: seeding, carrying, describing


def answer(result: xr.Dataset) -> str:
    """Number of motions, the most likely ones, and the places where some begin and end."""
    share = result["fraction"]
    name, _ = share.dims
    if not share.size:
        return "no attractor found"
    there = result["period"].values >= 0
    most = there.sum(axis=1)
    lines = [
        f"{counted(result.sizes['identity'], 'motion')}, of which at most {most.max()} coexist "
        f"({_at(result, name, int(most.argmax()))})"
    ]
    order = np.argsort(-np.nansum(share.values, axis=0), kind="stable")
    lines.append("; ".join(_motion(result, name, int(n), there[:, n]) for n in order[:LISTED]))
    kinds, counts = np.unique(codes.words(result["change_kind"]).values, return_counts=True)
    texts = [counted(int(n), str(kind)) for kind, n in zip(kinds, counts, strict=True)]
    unsettled = float(result["fraction_unsettled"].max())
    texts += [f"up to {plain(100 * unsettled, 3)} % of the starts did not settle"] if unsettled > 0 else []
    return "\n".join([*lines, *([", ".join(texts)] if texts else [])])


def _at(result: xr.Dataset, name: str, place: int) -> str:
    return f"{name} {measured(result[name][place], result[name])}"


def _motion(result: xr.Dataset, name: str, n: int, there: np.ndarray) -> str:
    """A motion with its periods, where it is, and its largest fraction."""
    one, places = result.isel(identity=n), np.flatnonzero(there)
    periods = np.unique(one["period"].values[places])
    text = ", ".join(str(p) if p else "none" for p in periods[:LISTED])
    ends = f"from {_at(result, name, places[0])} to {_at(result, name, places[-1])}"
    shares = one["fraction"].values[places]
    best = f"up to {plain(100 * float(np.nanmax(shares, initial=-1.0)), 3)} % of the starts"
    best = best if np.isfinite(shares).any() else "found from neighbouring values alone"
    return f"motion {int(one['identity'])}: period {text}, {ends}, {best}"


HERE = (PLANE, "identity")


OUTPUTS = Outputs(
    "attractors",
    {"identity": Out("identity", "number of the motion")} | attractor.NUMBERS,
    {
        "period": Out(HERE, "period in turns; 0: none found; -1: not there"),
        "count": Out(HERE, "starts that reach the motion"),
        "fraction": Out(HERE, "fraction of the starts that reach the motion"),
        **interval_outs(HERE),
        "carried": Out(HERE, "found from a neighbouring value alone"),
        "watched_turns": Out(HERE, "turns for which motions without a period were followed"),
        "section_distance": Out(HERE, "distance from the same motion at the value before"),
        "started": Out(PLANE, "number of starts"),
        "fraction_unsettled": Out(PLANE, "fraction of the starts that did not settle"),
        "fraction_unsettled_low": Out(PLANE, "lower end of its 95 % interval"),
        "fraction_unsettled_high": Out(PLANE, "upper end of its 95 % interval"),
        "fraction_failed": Out(PLANE, "fraction of the starts that failed"),
        "fraction_missed": Out(PLANE, "smallest basin that holds a start with a probability of 95 %"),
        "value_status": Out(PLANE, "how the search at the value ended", flags=STATUS),
        "value_trouble": Out(PLANE, "what went wrong in the search"),
        "change_identity": Out("change", "motion that begins or ends"),
        "change_other": Out("change", "motion that it comes from or changes into; 0: none"),
        "change_low": Out("change", "{name} below the change", "{units}"),
        "change_high": Out("change", "{name} above the change", "{units}"),
        "change_kind": Out("change", "kind of change", flags=EVENTS),
    }
    | OUTS
    | OUTCOME,
    answer,
)


@growing
@analysis(
    one_parameter,
    rules.each_alike,
    region_fits,
    record_fits,
    "model",
    lanes_fit,
    varied=at_largest,
    model=lambda varied, initial: rules.on_section(varied, initial),
    outputs=OUTPUTS,
    left_out=rules.both(rules.over(5), rules.INNER_DISC),
    usual={"rtol": RTOL},
)
def attractors(
    mechanism: Moving,
    *,
    over: Over,
    region: Region,
    starts: Annotated[Natural, Field(le=10**6)] = STARTS,
    seed: Count = 0,
    carry: Flag = True,
    reach: Annotated[Positive, unit("reach", "1")] = REACH,
    record: Names | None = None,
    exponents: Flag = True,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    bifurcations: Flag = False,
    **motion: Unpack[Recognising],
) -> xr.Dataset:
    """Follow coexisting motions over a parameter, with their fractions of the starts.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    over : mapping of str to sequence of float
        One parameter with its values, as in `bifurcation`; 5 clearances if left out.
    region : mapping of str to (float, float)
        Coordinates of the starts, those of a plane of `basins`, each with its lowest and highest value; the
        inner 0.7 of the clearance if left out.
    starts : int
        Number of starts at each value, drawn at random in the region.
    seed : int
        Seed of the random numbers from which the starts are drawn.
    carry : bool
        Whether motions are carried to neighbouring values, which finds those with narrow basins.
    turns : int
        As in `basins`. A start is left earlier where it has reached a motion that is known already, or where
        others show that it is bound for one.
    reach : float
        Largest distance between section points, in units of `tolerance`, at which motions at neighbouring
        values are the same motion.
    record : sequence of str, optional
        Quantities that are kept at section points, as in `bifurcation`.
    exponents : bool
        Whether the largest exponent of each motion is computed.
    lyapunov_turns : int
        Number of nominal turns over which the exponent is averaged.
    bifurcations : bool
        Whether periodic motions are followed as orbits, as by `continuation`, to find their bifurcations.
    initial : optional
        As in `lyapunov`: the start that the region goes through.

    Raises
    ------
    InputError
        If anything asked for makes no sense, listing all of it; numerical trouble is a status instead.

    Notes
    -----
    ``plane`` stands for the parameter. Of each motion there is also what `bifurcation` gives of a point,
    with ``attractor_status`` and ``trouble``.
    """
    began, (axis,) = time.perf_counter(), checked_axes(mechanism, over)
    varied = largest(mechanism, over)
    initial, joint, n_jobs = motion["initial"], motion["joint"], motion["n_jobs"]
    observation = Observation.of(motion, in_lanes(motion["ensemble"], varied, motion["rtol"], starts))
    looked = ONCE_A_TURN, names(record, varied), observation.turns, 0, observation.turns
    limits = {"rtol": observation.rtol, "max_steps": observation.max_steps}
    plan = Plan(*looked, exponents=int(exponents), lyapunov_turns=lyapunov_turns, **limits)
    changes = [{axis.key: value} for value in axis.values]
    shared = {"mechanism": mechanism, "initial": initial}
    tell = [part(motion["progress"], *pair) for pair in pairwise(SHARES)]
    seeds = {"region": region, "joint": joint, "starts": starts, "seed": seed, "observation": observation}
    cells = [shared | seeds | {"changes": each} for each in changes]
    ready = partial(_warm, mechanism, changes, initial, exponents, observation.ensemble)
    seeded = handed_out(passes.found, cells, tell[0], n_jobs, lasting=axis.name, ready=ready)
    motions, all_answers = [list(each.get("motions", ())) for each in seeded], list(seeded)
    lands: dict[tuple[int, int, int], int] = {}
    if carry:
        states = [each.get("names", ()) for each in seeded]
        parts = [shared | {"changes": each, "observation": observation} for each in changes]
        all_answers += _carried(parts, motions, states, lands, tell[1], n_jobs)
    numbers, events, apart = identities(motions, lands, reach)
    places = [(i, n) for i, each in enumerate(motions) for n in range(len(each))]
    cells = [shared | {"changes": changes[i], "motion": motions[i][n], "plan": plan} for i, n in places]
    answers = handed_out(passes.described, cells, tell[2], n_jobs, lasting="motion", ready=ready)
    table = _Table(axis, motions, numbers, apart, seeded, starts)
    found = table.dataset({(i, numbers[i][n]): a for (i, n), a in zip(places, answers, strict=True)})
    values = table.fractions() | table.changes(events)
    if bifurcations:
        following, branches = _followed(shared, axis, motions, numbers, observation.max_steps, n_jobs)
        values |= special_values(axis, following, branches, events)
    values |= ended(first_bad([*all_answers, *answers]), began)
    of = {"name": axis.long_name, "units": axis.units}
    return found.assign(OUTPUTS.variables_of(values, of, [axis.name])[0])


@dataclass(frozen=True)
class _Table:
    """Motions found at each value, by identity."""

    axis: Axis
    motions: Sequence[Sequence[Mapping[str, Any]]]
    numbers: Sequence[Sequence[int]]
    apart: Sequence[Sequence[float]]
    seeded: Sequence[Entry]
    starts: int

    @property
    def dims(self) -> tuple[str, str]:
        """Dimensions that identify a motion."""
        return self.axis.name, "identity"

    @property
    def shape(self) -> tuple[int, int]:
        """Number of values, and of identities."""
        return len(self.axis.values), max((n for each in self.numbers for n in each), default=0)

    @property
    def coordinates(self) -> dict[str, Any]:
        """Values of the parameter, and numbers of the motions."""
        own = OUTPUTS.coords["identity"].variable(np.arange(1, 1 + self.shape[1]))
        return {self.axis.name: self.axis.coordinate, "identity": own}

    def dataset(self, answers: Mapping[tuple[int, int], Entry]) -> xr.Dataset:
        """Dataset of the motions, by value and identity."""
        absent = {"status": NOT_RUN, "trouble": ""}
        places = [(i, n + 1) for i, n in np.ndindex(self.shape)]
        entries = [(f"{i} {n}", answers.get((i, n), absent)) for i, n in places]
        keys = [key for key, _ in entries]
        found = gather.dataset("attractors", self, keys, lambda: iter(entries))
        found = found.rename(cell_status="attractor_status").drop_vars("period", errors="ignore")
        found["attractor_status"].attrs["long_name"] = (
            "how the motion's description ended; not_run: not there"
        )
        return attractor.numbered(found)

    def fractions(self) -> dict[str, Any]:
        """Periods of motions, and fractions of the starts: of those of a value that could start."""
        started = self.starts - self._counted("no_start")
        count, low, high = self._filled("count", 0), *np.full((2, *self.shape), np.nan)
        for i, total in enumerate(started):
            low[i], high[i] = wilson(count[i], int(total))
        there = self._filled("period", ABSENT) > ABSENT
        share = {"fraction": _over(count, started[:, None]), "fraction_low": low, "fraction_high": high}
        found = {name: np.where(there, each, np.nan) for name, each in share.items()}
        found |= {"period": self._filled("period", ABSENT), "count": np.where(there, count, 0).astype(int)}
        found["carried"] = (there & (count == 0)).astype(np.int8)
        found |= {"watched_turns": self._filled("watched", 0), "section_distance": self._placed(self.apart)}
        return found | self._ends(started)

    def _ends(self, started: np.ndarray) -> dict[str, Any]:
        """Numbers of starts at each value that reach no motion, by how they ended."""
        unsettled = self._counted("unsettled")
        pairs = [wilson(n, int(total)) for n, total in zip(unsettled, started, strict=True)]
        low, high = np.array(pairs, dtype=float).reshape(-1, 2).T
        with np.errstate(divide="ignore"):
            missed = np.where(started > 0, 1 - MISSED ** (1 / np.maximum(started, 1)), 1.0)
        return {
            "started": started,
            "fraction_unsettled": _over(unsettled, started),
            "fraction_unsettled_low": low,
            "fraction_unsettled_high": high,
            "fraction_failed": _over(self._counted("failed"), started),
            "fraction_missed": missed,
            "value_status": [each["status"] for each in self.seeded],
            "value_trouble": np.array([each.get("trouble", "") for each in self.seeded], dtype=str),
        }

    def changes(self, events: Sequence[Change]) -> dict[str, Any]:
        """Values at which identities begin and end."""
        values = np.array(self.axis.values)
        between = np.array([each.between for each in events], dtype=int).reshape(-1, 2)
        return {
            "change_identity": np.array([each.identity for each in events], dtype=np.int32),
            "change_other": np.array([each.other for each in events], dtype=np.int32),
            "change_low": values[between[:, 0]],
            "change_high": values[between[:, 1]],
            "change_kind": [EVENTS.index(each.kind) for each in events],
        }

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


def _followed(shared, axis: Axis, motions, numbers, max_steps: int | None, n_jobs: int | None):
    """Follow periodic motions as orbits: the stretches followed, and the answers."""
    mechanism, section = shared["mechanism"], passes.section_at(shared["mechanism"], shared["initial"])
    following = stretches(axis, motions, numbers) if section is not None else []
    more = {"mechanism": mechanism, "parameter": axis.key, "section": section, "max_steps": max_steps}
    cells = [each | more for each in following]
    return following, handed_out(followed, cells, n_jobs=n_jobs, lasting="branch")


def _warm(mechanism, changes, initial, exponents: bool, ensemble: bool) -> None:
    """Compile the code that the first and the last value need."""
    for change in (changes[0], changes[-1]):
        try:
            here = mechanism.varied(change)
            model = assemble(here, initial, rules.section_of(here))
        except InputError:
            continue  # its cell says so
        warm([model], ensemble)
        if exponents:
            warm_tangents(model)


def _carried(
    parts: list[dict[str, Any]],
    motions: list[list[dict]],
    states: list[Sequence[str]],
    lands: dict[tuple[int, int, int], int],
    progress: Callable[[float], None] | None,
    n_jobs: int | None,
) -> list[Entry]:
    """Carry motions to the neighbouring values until nothing new comes up: the answers.

    What is new is added to `motions`, and to `lands` where (value, motion, other value) ends there.
    """
    fresh, ended = [(i, n) for i, each in enumerate(motions) for n in range(len(each))], []
    for _ in range(ROUNDS):
        into, cells = _neighbours(fresh, states), []
        for j, sources in into:
            given = [motions[i][n] | {"names": states[i], "changes": parts[i]["changes"]} for i, n in sources]
            cells.append(parts[j] | {"known": motions[j], "sources": given})
        if not cells:
            break
        answers = handed_out(passes.carried, cells, progress, n_jobs, lasting="value")
        fresh, ended = [], ended + answers
        for (j, sources), answer in zip(into, answers, strict=True):
            before = len(motions[j])
            motions[j] = [*motions[j], *answer.get("new", ())]
            fresh += [(j, n) for n in range(before, len(motions[j]))]
            for (i, n), ends in zip(sources, answer.get("lands", ()), strict=False):
                lands[i, n, j] = ends[0]
    return ended


def _neighbours(fresh: list[tuple[int, int]], states: list[Sequence[str]]):
    """Values to which motions are carried, ascending, each with its motions."""
    into: dict[int, list[tuple[int, int]]] = {}
    for i, n in fresh:
        for j in (i - 1, i + 1):
            if 0 <= j < len(states) and states[j]:
                into.setdefault(j, []).append((i, n))
    return sorted(into.items())
