"""Tipping of motions into others: smallest knocks, times to return, basins in finite time, edge states.

The motions are found from starts at random, as in `attractors`. Each is knocked (`coexisting.knocks`) until
it ends elsewhere (`coexisting.smallest`). The boundary that the smallest knock just crosses is followed to
the state that is on it (`coexisting.edge`). Finite-time basin stability is the fraction of the starts that
come within the tolerance of a motion in so many turns; of periodic motions alone. Reference: P. Schultz,
P. J. Menck, J. Heitzig and J. Kurths, New J. Phys. 19 (2017) 023005.

Validity: as of the parts. Of systems that nothing forces, knocks are at section points alone. With a
prescribed speed of the crank, knocks are at the section alone.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import left_out, rules
from jointplay.analysis.cells import first_bad, growing, handed_out, warm
from jointplay.analysis.coexisting import passes
from jointplay.analysis.coexisting.edge import Boundary, edge_state
from jointplay.analysis.coexisting.knocks import UNITS, Knock, knocks
from jointplay.analysis.coexisting.lasting import STRETCH, Motions
from jointplay.analysis.coexisting.point_impulses import Impulse, impulses_fit
from jointplay.analysis.coexisting.recognition import Lasting
from jointplay.analysis.coexisting.region import Region, coordinate_rules, drawn
from jointplay.analysis.coexisting.smallest import ABOVE, AT, BELOW, Knocked, smallest
from jointplay.analysis.coexisting.smallest import SHARES as TRIED
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.keywords import HANDED, JointName, Moving, Settling, analysis
from jointplay.analysis.labels import Out, ended
from jointplay.analysis.orbits.floquet import multipliers
from jointplay.analysis.orbits.orbit_search import at_phase
from jointplay.analysis.orbits.section_map import section_map
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.period import REPEATS
from jointplay.analysis.starts import crank_place, state_names
from jointplay.analysis.states.basin_uncertainty import wilson
from jointplay.analysis.states.ends import Observation, features, section_states
from jointplay.analysis.states.start_plane import Starts
from jointplay.analysis.tangents import warm_tangents
from jointplay.display.number_text import counted, plain
from jointplay.display.units import measure
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Few, Flag, Natural, Positive, accepts, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle
from jointplay.solver.motion.ensemble_runs import ensemble_fits, in_lanes
from jointplay.solver.motion.progress import part

if TYPE_CHECKING:
    import xarray as xr

STARTS, PHASES, DIRECTIONS, STEPS, EDGE_TURNS = 200, 8, 8, 16, 60
TURNS, PATIENCE, TOLERANCE = 64, 4, 1e-3
SHARES = (0.5, 0.9, 0.99)  # of the smallest knock, after which the time to return is measured
CLOUD = 4  # section points of a motion without period that are knocked
EDGE_RTOL = 1e-11
LISTED = 3  # motions named in a line
CLOSE = 0.99  # of a knock: up to there it is as good as safe
PARTS, DIMS = ("real", "imaginary"), ("number", "knock")
Answers = Mapping[tuple[int, int], Entry]


def answer(result: xr.Dataset) -> str:
    """The smallest knock that throws each motion into another, and the edge states."""
    count = result.sizes["number"]
    if count < 2:
        return f"{counted(count, 'motion')}, and no other to tip into"
    lines = [_knock(result.isel(number=n)) for n in range(min(count, LISTED))]
    lines += [counted(count - LISTED, "more motion")] if count > LISTED else []
    return "\n".join(lines)


def _knock(one: xr.Dataset) -> str:
    """The smallest knock of each kind of a motion."""
    parts = []
    for k, name in enumerate(one["knock"].values.tolist()):
        size, end = float(one["knock_size"].values[k]), int(one["knock_reaches"].values[k])
        if np.isfinite(size):
            units = str(one["knock_units"].values[k])
            sure = "" if int(one["knock_confirmed"].values[k]) else _unsure(one, k, units)
            other = f"motion {end}" if end > 0 else "no settled motion"
            parts.append(f"{name} of {measure(size, units, 3)} leads to {other}{sure}")
    found = sorted({int(p) for p in one["edge_period"].values if p > 0})
    edges = f"; on the boundary lies a state of period {', '.join(map(str, found))}" if found else ""
    told = ", ".join(parts) or "no knock that was tried tips it"
    return f"motion {int(one['number'])} (period {int(one['period']) or 'none'}): {told}{edges}"


def _unsure(one: xr.Dataset, k: int, units: str) -> str:
    """Sentence on a knock that is not confirmed."""
    names = ("knock_size", "knock_safe", "confirmed_size", "tipping_share")
    size, safe, sure, share = (float(one[name].values[k]) for name in names)
    below = "all smaller ones" if safe >= CLOSE * size else f"those up to {measure(safe, units, 3)}"
    told = [f"{below} that were tried return"] if safe > 0 else []
    why = ", as at a fractal boundary" if share < 1 else ""  # else what it leads to has not settled
    told.append(f"{plain(100 * share, 3)} % of those up to 1.2 times its size tip{why}")
    told.append(f"{measure(sure, units, 3) if np.isfinite(sure) else 'none'} is confirmed")
    return f" (not confirmed: {', '.join(told)})"


OUTPUTS = Outputs(
    "tipping",
    {
        "number": Out("number", "number of the motion"),
        "knock": Out("knock", "kind of knock", ""),
        "state": Out("state", "state", ""),
        "part": Out("part", "part of a complex number", ""),
        "knock_share": Out("knock_share", "share of the knock"),
        "tried_share": Out("tried_share", "share of the knock that was tried"),
    },
    {
        "period": Out("number", "period in turns; 0: none"),
        "count": Out("number", "starts that reach the motion"),
        "fraction": Out("number", "fraction of the starts that reach the motion", at={"number": "largest"}),
        "fraction_low": Out("number", "lower end of the 95 % interval of the fraction"),
        "fraction_high": Out("number", "upper end of the 95 % interval of the fraction"),
        "fraction_reached": Out(
            ("number", "within"), "fraction of the starts that are with the motion by then"
        ),
        "section_state": Out(("number", "point", "state"), "states at the section (SI)"),
        "within": Out("within", "turns"),
        "knock_size": Out(
            DIMS, "smallest knock that tips; see knock_units", about="NaN: none up to the largest tips"
        ),
        "knock_safe": Out(DIMS, "largest knock there up to which each one tried returns; see knock_units"),
        "knock_point": Out(DIMS, "section point of the motion, from 0"),
        "knock_phase": Out(DIMS, "angle of a turn after it", "rad"),
        "knock_direction": Out(DIMS, "direction of the knock; 0 and pi are its two signs", "rad"),
        "confirmed_size": Out(
            DIMS, "smallest knock there that is confirmed, up to 1.2 of knock_size; see knock_units"
        ),
        "tipping_share": Out(
            DIMS, "fraction that tips of sizes from knock_size to 1.2 of it; NaN if that is confirmed"
        ),
        "knock_reaches": Out(DIMS, "motion that the knock leads to; -1: none"),
        "below_reaches": Out(DIMS, "motion that 0.99 of the knock leads to; -1: none"),
        "above_reaches": Out(DIMS, "motion that 1.01 of the knock leads to; -1: none"),
        "knock_confirmed": Out(DIMS, "1: the former is the motion itself, the latter another"),
        "tried_reaches": Out((*DIMS, "tried_share"), "motion that a share of the knock leads to; -1: none"),
        "knock_units": Out("knock", "units of its size"),
        "return_turns": Out((*DIMS, "knock_share"), "turns to return; -1: not in time"),
        "edge_period": Out(
            DIMS, "period in turns; 0: none found", about="of the state on the boundary that it crosses"
        ),
        "edge_period_time": Out(
            DIMS, "time of a period of the edge state; of an equilibrium the nominal period", "s"
        ),
        "edge_residual": Out(DIMS, "change over a period, in scales"),
        "edge_state": Out((*DIMS, "state"), "edge state at the section (SI)"),
        "edge_multiplier": Out((*DIMS, "multiplier", "part"), "multiplier of the edge state"),
    }
    | OUTCOME,
    answer,
    shown={"fraction": "fraction of the starts with the most frequent motion"},
)


@growing
@analysis(
    coordinate_rules,
    impulses_fit,
    "model",
    rules.turns_alike,
    ensemble_fits,
    outputs=OUTPUTS,
    left_out=left_out.INNER_DISC,
    model=rules.on_section,
)
def tipping(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    region: Region,
    joint: JointName | None = None,
    starts: Annotated[Natural, Field(le=10**6)] = STARTS,
    seed: Count = 0,
    impulses: Annotated[Few[Impulse], accepts("a list of impulses, each a table,")] = (),
    largest: Annotated[Positive, unit("largest knock", "1")] = 1.0,
    steps: Natural = STEPS,
    phases: Natural = PHASES,
    directions: Annotated[Natural, Field(ge=2)] = DIRECTIONS,
    edge: Flag = True,
    edge_turns: Natural = EDGE_TURNS,
    turns: Annotated[Natural, Field(ge=REPEATS)] = TURNS,
    patience: Count = PATIENCE,
    tolerance: Annotated[Positive, unit("tolerance", "1")] = TOLERANCE,
    ensemble: Flag | None = None,
    n_jobs: Natural | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Find the smallest knocks that throw motions into others, and the states between them.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    region, joint, starts, seed
        As in `attractors`, where the motions are sought.
    impulses : sequence of Impulse
        Impulses on points of links that are tried too. Each is a table of ``name``, ``on`` (a table of
        ``link`` and ``at``, m from its origin), ``direction`` (rad; several are tried if left out) and
        ``fixed``, in which the direction is fixed: ``"ground"`` or ``"link"``.
    largest : float
        Largest knock that is tried: of a moment, the change of the link's speed over its nominal speed; of an
        impulse on a point, the change of the point's speed over the nominal speed times the mechanism's
        reach; of a shift of the journal, in clearances; of a test system's state, in its own units.
    steps : int
        Number of evenly spaced sizes, up to `largest`, that are tried before the smallest one that tips is
        refined by bisection.
    phases : int
        Number of evenly spaced instants in a turn at which knocks are tried.
    directions : int
        Number of evenly spaced directions in which knocks are tried.
    edge : bool
        Whether the edge states between the motions are sought.
    edge_turns : int
        Number of turns for which the boundary between two motions is followed.
    turns, patience, tolerance, ensemble, n_jobs
        As in `basins`.
    initial : optional
        As in `lyapunov`: the start that the region goes through.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    initial, progress, limits = motion["initial"], motion["progress"], (motion["rtol"], motion["max_steps"])
    ensemble = in_lanes(ensemble, mechanism, motion["rtol"], starts)
    observation = Observation(motion["transient"], turns, patience, tolerance, *limits, ensemble)
    warm([model], ensemble)
    if edge:
        warm_tangents(model)
    shared = {"mechanism": mechanism, "initial": initial, "observation": observation}
    seeds = {"region": region, "joint": joint, "starts": starts, "seed": seed}
    cells = [shared | seeds | {"changes": {}}]
    (seeded,) = handed_out(passes.found, cells, part(progress, 0.0, 0.3), n_jobs)
    motions = list(seeded.get("motions", ()))
    kinds = knocks(model, mechanism, impulses) if len(motions) > 0 else []
    known = [{key: each[key] for key in ("period", "states", "points")} for each in motions]
    cells = [shared | seeds | {"known": known}] if motions else []
    (times,) = handed_out(reached, cells, part(progress, 0.3, 0.4), n_jobs) or [{}]
    places = [(own, k) for own in range(len(motions)) for k in range(len(kinds))] if len(motions) > 1 else []
    search = {"known": known, "largest": largest, "steps": steps, "phases": phases, "directions": directions}
    search |= {"edge_turns": edge_turns if edge else 0, "impulses": impulses}
    cells = [shared | search | {"own": own, "knock": k} for own, k in places]
    answers = handed_out(knocked, cells, part(progress, 0.4, 1.0), n_jobs)
    table = _Table(model, motions, seeded, kinds, starts)
    by_place = dict(zip(places, answers, strict=True))
    found = table.motions_found(times) | table.knocks_found(by_place) | table.edges_found(by_place)
    found |= table.coordinates() | ended(first_bad([seeded, times, *answers]), began)
    return OUTPUTS.dataset(found)


def _edge_entry(orbit: Orbit, base: Model) -> Entry:
    """Entry of an edge state: period, state at the section, multipliers, the largest first."""
    state, _ = at_phase(orbit, base.crank_angle)
    each = multipliers(orbit.image.derivative)
    table = np.stack([each.real, each.imag], -1)
    found = {"period": orbit.map.turns, "period_time": orbit.image.time, "residual": orbit.residual}
    return found | {"state": state, "multiplier": table}


@dataclass(frozen=True)
class _Table:
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

    def coordinates(self) -> dict[str, Any]:
        """Numbers of motions, names of knocks and states."""
        return {
            "number": np.arange(1, len(self.motions) + 1),
            "knock": np.array([each.name for each in self.kinds], dtype=str),
            "state": np.array(state_names(self.base), dtype=str),
            "part": np.array(PARTS),
            "knock_share": np.array(SHARES),
            "tried_share": np.array(TRIED),
        }

    def motions_found(self, times: Entry) -> dict[str, Any]:
        """Periods, points and fractions of the motions; fractions of the starts that reach them in time."""
        started = self.starts - self.seeded.get("no_start", 0)
        count = np.array([each["count"] for each in self.motions], dtype=int)
        low, high = wilson(count, started)
        longest = max((len(each["states"]) for each in self.motions), default=0)
        states = np.full((len(self.motions), longest, len(self.base.state)), np.nan)
        for row, each in zip(states, self.motions, strict=True):
            row[: len(each["states"])] = each["states"]
        counts = np.asarray(times.get("counts", np.zeros((len(self.motions), 0))))
        return {
            "period": np.array([each["period"] for each in self.motions], int),
            "count": count,
            "fraction": count / started if started else np.full(len(count), np.nan),
            "fraction_low": low,
            "fraction_high": high,
            "fraction_reached": counts / started if started else np.full(counts.shape, np.nan),
            "section_state": states,
            "within": np.asarray(times.get("within", np.zeros(0)), dtype=int),
        }

    def knocks_found(self, answers: Answers) -> dict[str, Any]:
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
        return {
            "knock_size": size,
            "knock_safe": safe,
            "knock_point": place[..., 0],
            "knock_phase": place[..., 1],
            "knock_direction": place[..., 2],
            "confirmed_size": confirmed,
            "tipping_share": share,
            "knock_reaches": reaches[..., AT],
            "below_reaches": below,
            "above_reaches": above,
            "knock_confirmed": right.astype(np.int8),
            "tried_reaches": reaches,
            "knock_units": np.array([UNITS[each.kind] for each in self.kinds], dtype=str),
            "return_turns": self._filled(answers, "returns", np.full(len(SHARES), -1.0)).astype(int),
        }

    def edges_found(self, answers: Answers) -> dict[str, Any]:
        """States on the boundaries that the smallest knocks cross."""
        free = max((len(each["multiplier"]) for each in answers.values() if "multiplier" in each), default=0)
        return {
            "edge_period": self._filled(answers, "period", 0).astype(int),
            "edge_period_time": self._filled(answers, "period_time", np.nan),
            "edge_residual": self._filled(answers, "residual", np.nan),
            "edge_state": self._filled(answers, "state", np.full(len(self.base.state), np.nan)),
            "edge_multiplier": self._filled(answers, "multiplier", np.full((free, len(PARTS)), np.nan)),
        }

    def _filled(self, answers: Answers, name: str, missing: Any) -> np.ndarray:
        table = np.empty((*self.shape, *np.shape(missing)))
        table[...] = missing
        for (own, kind), answer in answers.items():
            if name in answer:
                table[own, kind] = answer[name]
        return table


def _motions(mechanism, initial, known: Sequence[Mapping[str, Any]], observation: Observation) -> Motions:
    base = rules.on_section(mechanism, initial)
    return Motions(base, observation, [Lasting(**each) for each in known])


def reached(mechanism, initial, observation, known, region, joint, starts: int, seed: int) -> Entry:
    """Numbers of starts that are with each motion after so many turns."""
    place, motions = (
        Starts(mechanism, initial, tuple(region), joint),
        _motions(mechanism, initial, known, observation),
    )
    labels = motions.sort(place.all(drawn(region, starts, seed, 0.0)))
    within = np.arange(STRETCH, observation.transient + 1, STRETCH)
    there = (motions.turns[:, None] >= 0) & (motions.turns[:, None] <= within[None])
    counts = [(there & (labels == n)[:, None]).sum(axis=0) for n in range(len(known))]
    return {"status": 0, "within": within, "counts": np.array(counts)}


def knocked(
    mechanism, initial, observation, known, own: int, knock: int, largest: float, steps: int, phases: int,
    directions: int, edge_turns: int, impulses: Sequence[Impulse],
) -> Entry:  # fmt: skip
    """The smallest knock of a kind that tips a motion, times to return from less, and the edge state."""
    motions = _motions(mechanism, initial, known, observation)
    base, states = motions.base, known[own]["states"]
    points = states if known[own]["period"] else states[:: max(1, len(states) // CLOUD)][:CLOUD]
    forced, angle = rules.section_of(mechanism) is not None, CrankAngle(angle=base.crank_angle)
    turning = forced and not (base.links and crank_place(base) is None)
    clock = base if forced else replace(base, crank_speed=math.tau / base.period)  # its phase is time
    section = section_map(clock, angle, 1, min(observation.rtol, EDGE_RTOL), observation.max_steps)
    cut = None if forced else partial(assemble, mechanism, initial)
    kind = knocks(base, mechanism, impulses)[knock]
    case = Knocked(motions, own, points, section if turning else None, kind)
    sizes = largest * np.arange(1, steps + 1) / steps
    found = smallest(case, phases, directions, sizes)
    if found is None:
        return {"status": 0}
    answer = {
        "status": 0,
        "size": found.high * kind.unit,
        "safe": found.safe * kind.unit,
        "confirmed": found.confirmed * kind.unit,
        "share": found.share,
        "place": list(found.place),
        "ends": list(found.ends),
    }
    answer["returns"] = [returned(case, found.place, share * found.high) for share in SHARES]
    if edge_turns and (orbit := _edge(case, found, section, edge_turns, cut)) is not None:
        answer |= _edge_entry(orbit, base)
    return answer


def _edge(case: Knocked, found, section, turns: int, cut):
    """The edge state on the boundary that a knock crosses."""
    pair = [case.start(found.place, size) for size in (found.low, found.high)]
    if any(each is None for each in pair):
        return None
    inside, outside = (each.state for each in pair)
    return edge_state(Boundary(case.motions, case.own, section, inside, outside, cut), turns)


def returned(case: Knocked, place, size: float) -> int:
    """Turns after a knock until a motion is with its periodic self again, to stay; -1: not in time."""
    motion, motions, start = case.motions.known[case.own], case.motions, case.start(place, size)
    if start is None or not motion.period:
        return -1
    how = motions.observation
    how = Observation(0, how.transient + how.turns, 0, how.tolerance, how.rtol, how.max_steps)
    ((states, status, _),) = section_states(motions.base, [start], 0, how)
    if status:
        return -1
    apart = np.abs(features(motions.base, states)[:, None, :] - motion.points[None]).max(axis=-1).min(axis=1)
    away = np.flatnonzero(apart > how.tolerance)
    last = int(away[-1]) + 1 if len(away) else 0
    return -1 if last == len(apart) else last + 1
