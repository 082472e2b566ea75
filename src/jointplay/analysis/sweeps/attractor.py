"""One point of a sweep: the motion that a mechanism settles to from a start, and where it stands at the end.

A first run drops the transient, a second one from there on is evaluated: section points, period, contacts,
the word of the turn, near misses; and, where asked for, Lyapunov exponents from its end on. With a section
at a crank angle both runs end on the section, after whole turns. With another section, or where a forcing's
phase is no state and the section is at another phase than the start, they last whole nominal periods.

Variables of a point of a bifurcation diagram.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from jointplay.analysis import contacts, evaluate, rules
from jointplay.analysis.cells import guarded
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.exponents import batch_means, frame_growth
from jointplay.analysis.exponents.frame_growth import Stretch, followed_together, grown
from jointplay.analysis.labels import Out, units, xr
from jointplay.analysis.period import REPEATS, period
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import crank_place, end_of, moved, placed
from jointplay.analysis.tangents import scales
from jointplay.jobs.columns import Plain, shared
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Section, TestSystem
from jointplay.solver.motion.eligibility import ROUTES, batch, joined_route
from jointplay.solver.motion.trajectory import Records, Request

RTOL = 1e-7  # periodic section points then lie within 1e-5 of a clearance; a fifth faster than 1e-8
TOLERANCE = 1e-4  # of a clearance, or of a test system's unit: spread of section points that count as one
SPREAD = 1000  # times rtol: what they spread over at most; more than TOLERANCE where rtol is looser than RTOL
ALIGN = 20  # turns in which the tangents find their directions
UNKNOWN = -1  # a period, or another whole number, that could not be looked for
ROW = contacts.ROW


@dataclass(frozen=True)
class Plan:
    """Settings of every point of a sweep; the fields are the keywords of `bifurcation`.

    `ensemble` None: the sweep's chains choose.
    """

    section: Section
    record: tuple[str, ...]
    turns: int
    transient: int
    keep: int
    tolerance: float | None = None
    exponents: int = 0
    lyapunov_turns: int = 200
    rtol: float = RTOL
    max_steps: int | None = None
    ensemble: bool | None = False

    @property
    def spread(self) -> float:
        """Spread of section points that count as one: the given tolerance, or the resolution of `rtol`."""
        return max(TOLERANCE, SPREAD * self.rtol) if self.tolerance is None else self.tolerance


def settle(mechanism: Mechanism | TestSystem, start: Any, plan: Plan) -> dict[str, Any]:
    """Follow a motion until it has settled, and describe it.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    start : optional
        As in `placed`; or the model, assembled there.
    plan : Plan
        Settings of the sweep.

    Returns
    -------
    dict
        ``status``, ``trouble`` (text) and ``n_steps``. Where the motion was followed to the end, also ``end``
        (an `End`), ``end_dim`` (its dimension), ``labels`` (coordinates of parts), ``points`` (variables over
        ``point``) and ``values`` (by name, as (dims, value): a number, or a list over joints or exponents).

    Raises
    ------
    InputError
        If the start or the section does not fit the mechanism; numerical trouble is a status instead.
    """
    model = start if isinstance(start, Model) else placed(mechanism, start, plan.section)
    steps, route = 0, 1
    if plan.transient:
        dropped = _run(model, plan, plan.transient, watched=False)
        if dropped.status:
            return _failed(dropped, f"in the {plan.transient} turns dropped", 0)
        model = moved(model, _state(model, plan, _last(model, plan, dropped)))
        steps, route = dropped.counts["n_steps"], dropped.route
    records = _run(model, plan, plan.turns, watched=True)
    records = replace(records, route=joined_route(route, records.route))
    if records.status:
        return _failed(records, f"in the {plan.turns} turns looked at", steps)
    result = _described(model, plan, records)
    result["n_steps"] += steps
    return result | _exponents(mechanism, result, plan) if plan.exponents else result


def settle_together(points: Sequence[tuple[Mechanism | TestSystem, Any]], plan: Plan) -> list[dict[str, Any]]:
    """Settle from several starts, each of a mechanism of its own, eight at once where that can be.

    As `settle`, one by one; a point whose input is refused has only a ``status`` and ``trouble``.
    """
    given = ({"mechanism": mechanism, "start": start, "plan": plan} for mechanism, start in points)
    return batch([partial(guarded, settle, each) for each in given], followed_together)


def _failed(records: Records, where: str, steps: int) -> dict[str, Any]:
    done = steps + records.counts["n_steps"]
    return {"status": records.status, "trouble": f"{STATUS[records.status]} {where}", "n_steps": done}


def counted(model: Model, section: Section) -> bool:
    """Whether runs end at a section point, which can be a start."""
    if not isinstance(section, CrankAngle):
        return False
    off = (section.angle - model.crank_angle) / math.tau
    return crank_place(model) is not None or abs(off - round(off)) < 1e-12


def _run(model: Model, plan: Plan, turns: int, watched: bool) -> Records:
    """Follow some turns of the model; watched: with events and section points."""
    whole, fields = counted(model, plan.section), rules.section_fields(plan.section, model, 0)
    end = turns * model.period
    if whole:
        fields |= {"duration": rules.SLACK * end, "stop_after": turns, "skip": 0 if watched else turns - 1}
    else:
        fields |= {"duration": end, "at": np.array([end]), "skip": 0 if watched else 10**9}
    looked = {"events": watched, "misses": watched, "log_from": 0.0}
    looked["rates"] = watched and evaluate.needed(model, plan.record)
    limit = {"rtol": plan.rtol, "max_steps": rules.steps(plan.max_steps)}
    return rules.to_the_section(model, Request(**limit, **looked, **fields))


def _last(model: Model, plan: Plan, records: Records) -> np.ndarray:
    """The row at the end of a run: time, positions, speeds, modes."""
    return records.sections[-1, ROW:] if counted(model, plan.section) else records.samples[-1]


def _state(model: Model, plan: Plan, row: np.ndarray) -> np.ndarray:
    """The state at a row as a start: angles without whole turns, on the section to the last bit."""
    state, crank = row[1 : 1 + len(model.state)].copy(), crank_place(model)
    turning = np.flatnonzero(model.fold)
    state[turning] -= math.tau * np.round(state[turning] / math.tau)
    if crank is not None and counted(model, plan.section):
        state[crank] = plan.section.angle
    return state


def _described(model: Model, plan: Plan, records: Records) -> dict[str, Any]:
    last, rows = _last(model, plan, records), records.sections[:, ROW:]
    whole, crank, turns = counted(model, plan.section), crank_place(model), plan.turns
    if crank is not None:
        turns = round(abs(last[1 + crank] - model.state[crank]) / math.tau, 9)
    evenly = last[0] - last[0] / turns * np.arange(math.floor(turns + 1e-9), -1, -1)  # back from the end
    bounds = np.concatenate([[0.0], rows[:, 0]]) if whole else evenly
    repeats = _period(model, records, plan.spread)
    values = {"period": ((), repeats), "turn_period": ((), last[0] / turns)}
    if model.joints or model.resets:
        words = contacts.words(model, records, last, bounds, repeats if whole else 0)
        values |= _contacts(model, records, last, turns) if model.gaps else {}
        values["mode_word"] = (("joint",), words) if model.links else ((), words[0])
    points = evaluate.quantities(model, plan.rtol, records, rows[-plan.keep :])
    return {
        "status": 0,
        "trouble": "",
        "n_steps": records.counts["n_steps"],
        "end": end_of(model, _state(model, plan, last)),
        "end_dim": "end" if model.outputs else "state",  # as of `simulate`
        "labels": evaluate.coordinates(model),
        "points": points.variables(plan.record, "point"),
        "values": values | {"followed": ((), np.int8(records.route))},
    }


def _contacts(model: Model, records: Records, last: np.ndarray, turns: float) -> dict[str, Any]:
    """Counts and near misses: over joints; of a test system, of all its contacts together."""
    close = {
        "smallest_impact_speed": contacts.smallest_impact_speed(model, records),
        "smallest_missed_gap": contacts.smallest_missed_gap(model, records),
    }
    closed, end = contacts.closed(model, records, last), last[0]
    if not model.links:
        events = contacts.of_gaps(model, records.events)
        counts = contacts.counts(events, end, turns, bool(closed[model.gaps].any()))
        counts |= {name: _least(values[model.gaps]) for name, values in close.items()}
        return {name: ((), value) for name, value in counts.items()}
    each = [contacts.counts(records.events, end, turns, shut, j) for j, shut in enumerate(closed)]
    counts = {name: [one[name] for one in each] for name in each[0]}
    return {name: (("joint",), values) for name, values in (counts | close).items()}


def _least(values: np.ndarray) -> float:
    there = values[np.isfinite(values)]
    return float(there.min()) if len(there) else math.nan


def _period(model: Model, records: Records, tolerance: float) -> int:
    """Period in section points: of the journals over their clearances, else of the state over its scales."""
    rows = records.sections[:, ROW:]
    if len(rows) < REPEATS:
        return UNKNOWN
    if model.clearances:
        journals = Quantities(model, rows, records.start).variables(("journal_x", "journal_y"), "point")
        return period(np.hstack([each[1] / model.clearances for each in journals.values()]), tolerance)
    states = rows[:, 1 : 1 + len(model.state)]
    if not model.links:
        return period(states, tolerance)
    crank = crank_place(model)
    states = states / scales(model)
    return period(states if crank is None else np.delete(states, crank, axis=1), tolerance)


def _exponents(mechanism: Mechanism | TestSystem, result: Mapping[str, Any], plan: Plan) -> dict[str, Any]:
    """Leading Lyapunov exponents from the end of a motion on, or the failure of their run."""
    section = plan.section if plan.ensemble else None  # lanes have compiled that structure already
    model = placed(mechanism, result["end"], section)
    begin, count = ALIGN * model.period, min(plan.exponents, len(model.state))
    limits = {"rtol": plan.rtol, "max_steps": rules.steps(plan.max_steps)}
    request = Request(begin + plan.lyapunov_turns * model.period, **limits)
    run = grown(model, Stretch(request, count, begin))
    done = {"n_steps": result["n_steps"] + run.counts["n_steps"]}
    if run.status:
        return done | {"status": run.status, "trouble": f"{STATUS[run.status]} while exponents were measured"}
    measured = run.leading(count)
    exponents = {name: (out.axes, measured[name]) for name, out in EXPONENTS.items()}
    exponents["exponents_followed"] = ((), np.int8(run.route))
    return done | {"values": result["values"] | exponents}


EXPONENTS = {name: out for name, out in batch_means.ESTIMATES.items() if name.startswith("lyapunov")}


EXPONENTS |= {name: out for name, out in frame_growth.OUTS.items() if out.units == "1"}  # per turn


OUTS = {  # of a test system those along joints are of all its contacts
    "period": Out(
        (),
        "period in section points",
        comment="turns, where the section is a crank angle; 0: none within period_tolerance; -1: not known",
    ),
    "turn_period": Out((), "mean period of a turn", "s"),
    "impacts": Out("joint", "contacts begun per turn"),
    "separations": Out("joint", "contacts lost per turn"),
    "contact_fraction": Out("joint", "fraction of time in contact"),
    "smallest_impact_speed": Out("joint", "smallest speed at which a contact began", "{speed}"),
    "smallest_missed_gap": Out("joint", "smallest gap of an approach that missed contact", "{length}"),
    "mode_word": Out(
        "joint",
        "contact modes of the turn, one after another",
        comment="f free, r released, + - slip, s stick, c contact; of a test system the walls met",
    ),
    "followed": Out((), "how the motion was followed", flags=ROUTES),
    "exponents_followed": Out((), "how the motion was followed while exponents were measured", flags=ROUTES),
    "n_steps": Out((), "accepted steps"),
    "end_state": Out(
        "state", "positions and speeds at the end", comment="rad, m, rad/s, m/s; accepted as a start"
    ),
    **EXPONENTS,
}


NUMBERS = {
    "point": Out("point", "section point"),
    "exponent": Out("exponent", "number of the exponent"),
    "multiplier": Out("multiplier", frame_growth.NUMBER),
}


def numbered(found: xr.Dataset) -> xr.Dataset:
    """The dataset of all points, with `NUMBERS`: section points from 0 on, exponents from 1."""
    found.attrs.pop("swept")  # its dimensions are no study's `[vary]`
    own = {dim: out for dim, out in NUMBERS.items() if dim in found.dims}
    numbers = {dim: np.arange(found.sizes[dim]) + (dim != "point") for dim in own}
    return found.assign_coords({dim: out.variable(numbers[dim]) for dim, out in own.items()})


def labelled(motion: Entry, keep: int) -> Entry:
    """Answer of a cell from a result of `attractor.settle`, with `keep` section points.

    A motion that failed has the number of its steps alone.
    """
    labels, values = motion.get("labels", {}), motion.get("values", {})
    values = values | {"n_steps": ((), motion.get("n_steps", 0))}
    if "end" in motion:
        names, state, *_ = motion["end"]
        dim = motion["end_dim"]
        labels = labels | {dim: ((dim,), np.array(names, dtype=str), {"long_name": "state"})}
        values["end_state"] = ((dim,), state)
    rows = motion.get("points", {}).items()
    of = units("link" in labels)
    parts = {name: (dims, _padded(dims, each, keep), own) for name, (dims, each, own) in rows}
    parts |= {name: (*pair, OUTS[name].attributes(of)) for name, pair in values.items()}
    used = {dim for dims, *_ in parts.values() for dim in dims}
    labels = {dim: each for dim, each in labels.items() if dim in used}
    fields = [
        (part, name, dims, own)
        for part, each in (("variables", parts), ("coords", labels))
        for name, (dims, _, own) in each.items()
    ]
    arrays = [np.asarray(each) for _, each, _ in (*parts.values(), *labels.values())]
    kept = {key: motion[key] for key in ("status", "trouble", "end") if key in motion}
    return kept | {"dataset": Plain(shared(fields, {}), arrays)}


def _padded(dims: tuple[str, ...], values: Any, keep: int) -> np.ndarray:
    """Values of section points, filled up to `keep` points."""
    values = np.asarray(values)
    missing = [(0, keep - n if dim == "point" else 0) for dim, n in zip(dims, values.shape, strict=True)]
    none = UNKNOWN if values.dtype.kind == "i" else np.nan
    return np.pad(values, missing, constant_values=none) if np.any(missing) else values
