"""Tipping of motions into others: smallest knocks, times to return, basins in finite time, edge states.

The motions are found from starts at random, as in `attractors`. Each is knocked until it ends elsewhere
(`coexisting.knocks`). The boundary that the smallest knock just crosses is followed to the state that is on
it. Finite-time basin stability is the fraction of the starts that come within the tolerance of a motion in so
many turns; of periodic motions alone. Reference: P. Schultz, P. J. Menck, J. Heitzig and J. Kurths, New J.
Phys. 19 (2017) 023005.

Validity: as of the parts. Of systems that nothing forces, knocks are at section points alone. With a
prescribed speed of the crank, knocks are at the section alone.

The edge state between two motions attracts on the boundary of their basins. A start that leads to one motion
and a near one that does not enclose the boundary. Both are followed turn by turn, and where they have moved
apart, halved in again along the line between them; so the pair stays on the boundary and comes to what
attracts there (J. D. Skufca, J. A. Yorke and B. Eckhardt, Phys. Rev. Lett. 96 (2006) 174101). Once the pair
comes back to where it was a few turns before, Newton's method on the section map makes of it a periodic orbit
with its multipliers. What nothing forces stays in an equilibrium, or in a cycle of a period of its own; that
is sought on the plane through the pair that it crosses fastest. Validity: an edge state that is not periodic
is not refined; a boundary that is no thin surface, such as one of riddled basins, has none.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.cells import first_bad, growing, handed_out, warm
from jointplay.analysis.coexisting import passes
from jointplay.analysis.coexisting.knocks import (
    ABOVE,
    AT,
    BELOW,
    UNITS,
    Impulse,
    Knock,
    Knocked,
    impulses_fit,
    knocks,
    smallest,
)
from jointplay.analysis.coexisting.knocks import SHARES as TRIED
from jointplay.analysis.coexisting.lasting import STRETCH, Lasting, Motions
from jointplay.analysis.coexisting.region import Region, coordinate_rules, drawn
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.keywords import HANDED, Moving, Recognising, analysis
from jointplay.analysis.labels import Out, ended, xr
from jointplay.analysis.orbits.orbit_dataset import largest_multiplier, told_neutral
from jointplay.analysis.orbits.section_map import AT_REST, SectionMap, section_map
from jointplay.analysis.orbits.shooting import Orbit, Search, at_phase, multipliers, shortest, solved
from jointplay.analysis.starts import crank_place, state_names
from jointplay.analysis.states.basin_uncertainty import fractions, interval_outs
from jointplay.analysis.states.ends import Observation, features, on_section, padded, section_states
from jointplay.analysis.states.start_plane import Starts
from jointplay.analysis.tangents import warm_tangents
from jointplay.display.number_text import counted, measure, plain
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Few, Flag, Natural, Positive, accepts, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Plane
from jointplay.solver.motion.ensemble_runs import ensemble_fits, in_lanes
from jointplay.solver.motion.progress import part

STARTS, PHASES, DIRECTIONS, STEPS, EDGE_TURNS = 200, 8, 8, 16, 60
SHARES = (0.5, 0.9, 0.99)  # of the smallest knock, after which the time to return is measured
CLOUD = 4  # section points of a motion without period that are knocked
EDGE_RTOL = 1e-11
LISTED = 3  # motions named in a line
CLOSE = 0.99  # of a knock: up to there it is as good as safe
PARTS, DIMS = ("real", "imaginary"), ("number", "knock")
Answers = Mapping[tuple[int, int], Entry]

PAIRED, APART = 1e-9, 1e-5  # distances, in units of the scales, to which and from which a pair is halved in
CUTS = 8  # into which the line between a pair is cut at once
LONGEST = 12  # period of an edge state, turns
NEAR = 3e-2  # distance of two passages from which Newton's method starts
ITERATIONS = 40
MOMENT = 1e-3  # phase of a nominal period, rad, in which one sees how states change


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
    text = ", ".join(parts) or "no knock that was tried tips it"
    return f"motion {int(one['number'])} (period {int(one['period']) or 'none'}): {text}{edges}"


def _unsure(one: xr.Dataset, k: int, units: str) -> str:
    """Sentence on a knock that is not confirmed."""
    names = ("knock_size", "knock_safe", "confirmed_size", "tipping_share")
    size, safe, sure, share = (float(one[name].values[k]) for name in names)
    below = "all smaller ones" if safe >= CLOSE * size else f"those up to {measure(safe, units, 3)}"
    reasons = [f"{below} that were tried return"] if safe > 0 else []
    why = ", as at a fractal boundary" if share < 1 else ""  # else what it leads to has not settled
    reasons.append(f"{plain(100 * share, 3)} % of those up to 1.2 times its size tip{why}")
    reasons.append(f"{measure(sure, units, 3) if np.isfinite(sure) else 'none'} is confirmed")
    return f" (not confirmed: {', '.join(reasons)})"


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
        **interval_outs("number"),
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
    left_out=rules.INNER_DISC,
    model=rules.on_section,
)
def tipping(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    region: Region,
    starts: Annotated[Natural, Field(le=10**6)] = STARTS,
    seed: Count = 0,
    impulses: Annotated[Few[Impulse], accepts("a list of impulses, each a table,")] = (),
    largest: Annotated[Positive, unit("largest knock", "1")] = 1.0,
    steps: Natural = STEPS,
    phases: Natural = PHASES,
    directions: Annotated[Natural, Field(ge=2)] = DIRECTIONS,
    edge: Flag = True,
    edge_turns: Natural = EDGE_TURNS,
    **motion: Unpack[Recognising],
) -> xr.Dataset:
    """Find the smallest knocks that throw motions into others, and the states between them.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    region, starts, seed
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
    initial : optional
        As in `lyapunov`: the start that the region goes through.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    initial, progress, n_jobs = motion["initial"], motion["progress"], motion["n_jobs"]
    together = in_lanes(motion["ensemble"], mechanism, motion["rtol"], starts)
    observation = Observation.of(motion, together)
    warm([model], together)
    if edge:
        warm_tangents(model)
    shared = {"mechanism": mechanism, "initial": initial, "observation": observation}
    seeds = {"region": region, "joint": motion["joint"], "starts": starts, "seed": seed}
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
    each = [largest_multiplier(model, one["period"], one["states"][-1], observation) for one in motions]
    return OUTPUTS.dataset(found, **told_neutral(each))


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
        states = padded([each["states"] for each in self.motions], len(self.base.state))
        counts = np.asarray(times.get("counts", np.zeros((len(self.motions), 0))))
        return fractions(count, started) | {
            "period": np.array([each["period"] for each in self.motions], int),
            "count": count,
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
    place = Starts(mechanism, initial, tuple(region), joint)
    motions = _motions(mechanism, initial, known, observation)
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
        answer |= {"period": orbit.map.turns, "period_time": orbit.image.time, "residual": orbit.residual}
        each, state = multipliers(orbit.image.derivative), at_phase(orbit, base.crank_angle)[0]
        answer |= {"state": state, "multiplier": np.stack([each.real, each.imag], -1)}
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


@dataclass
class Boundary:
    """A pair of states at the section on either side of the boundary of a motion's basin.

    `cut` makes the model for sections by a state, where nothing forces the motion; else it is None.
    """

    motions: Motions
    own: int
    section: SectionMap
    inside: np.ndarray
    outside: np.ndarray
    cut: Callable[[str], Model] | None = None

    @property
    def width(self) -> float:
        """Largest difference of the two states in a coordinate, in units of its scale."""
        return float(np.max(np.abs(self.section.differ(self.outside, self.inside))))

    def close(self) -> None:
        """Halve the pair in until it is close, or as close as rounding allows."""
        shares = np.arange(1, CUTS) / CUTS
        for _ in range(ITERATIONS):
            if self.width <= PAIRED:
                return
            line = self.inside + shares[:, None] * (self.outside - self.inside)
            own = self.motions.sort([replace(self.motions.base, state=state) for state in line]) == self.own
            first = int(np.argmin(own)) if not own.all() else len(own)
            whole = np.concatenate([self.inside[None], line, self.outside[None]])
            self.inside, self.outside = whole[first], whole[first + 1]

    def turn(self) -> bool:
        """Follow the pair for a turn; false where that fails."""
        ends = [self.section.image(state, False) for state in (self.inside, self.outside)]
        if any(end.status for end in ends):
            return False
        base, place = self.motions.base, self.section.place
        self.inside, self.outside = (on_section(base, end.state, place) for end in ends)
        if self.width > APART:
            self.close()
        return True

    def plane(self, state: np.ndarray) -> SectionMap | None:
        """The section through a state where one coordinate changes fastest; None at rest, or if forced."""
        image = self.section.moved(state, MOMENT)[1] if self.cut else None
        if image is None or image.status:
            return None
        change = self.section.differ(image.state, state)
        fastest = int(np.argmax(np.abs(change)))
        if abs(change[fastest]) <= AT_REST * MOMENT:
            return None
        name, direction = state_names(self.section.model)[fastest], "up" if change[fastest] > 0 else "down"
        plane = Plane(quantity=name, value=float(state[fastest]), direction=direction)
        return section_map(self.cut(name), plane, 1, self.section.rtol, self.section.max_steps)


def edge_state(boundary: Boundary, turns: int) -> Orbit | None:
    """The periodic orbit to which a boundary leads in some turns; None where it leads to none.

    Only orbits are taken that leave the boundary in one direction alone: with one multiplier beyond 1.
    """
    boundary.close()
    seen = [boundary.inside]
    for _ in range(turns):
        if not boundary.turn():
            return None
        seen.append(boundary.inside)
        if (orbit := _refined(boundary, seen)) is not None:
            return orbit
    return None


def _refined(boundary: Boundary, seen: list[np.ndarray]) -> Orbit | None:
    """A periodic orbit near the last states, if they come back and it leaves in one direction alone."""
    section, last = boundary.section, seen[-1]
    for period in range(1, min(LONGEST, len(seen) - 1) + 1):
        if np.max(np.abs(section.differ(last, seen[-1 - period]))) <= NEAR:
            orbit = _solved(section, last, period)
            if orbit is not None and boundary.plane(orbit.state) is None:
                return orbit
    plane, state = boundary.plane(last), last
    for period in range(1, LONGEST + 1) if plane else ():
        image = plane.image(state, False)
        if image.status:
            break
        state = image.state
        if np.max(np.abs(plane.differ(state, last))) <= NEAR:
            return _solved(plane, state, period)
    return None


def _solved(section: SectionMap, state: np.ndarray, period: int) -> Orbit | None:
    """The periodic orbit that Newton's method comes to, if it leaves in one direction alone."""
    orbit = solved(replace(section, turns=period), state, settings := Search())
    if orbit.status:
        return None
    orbit = shortest(orbit, settings)
    return orbit if np.sum(np.abs(multipliers(orbit.image.derivative)) > 1) == 1 else None
