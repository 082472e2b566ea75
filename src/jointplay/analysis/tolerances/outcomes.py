"""The outcome of each sample: does it lose contact, leave period 1, become chaotic; what are its forces.

A motion is followed until it repeats itself. One without a period is followed on, some transients more, and
its exponent measured (`assessment.settled`): it is chaotic where that is above 0 by more than three standard
errors. What has neither a period nor such an exponent is undecided, in all that is asked of it, since its
transient may not be over. Quantities are over the turns that are looked at, of a periodic motion over two of
its periods.
Validity: as of `bifurcation`; motions of a block share lanes where they can, and none depends on another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

import numpy as np

from jointplay.analysis import evaluate, rules
from jointplay.analysis.assessment.assess import bearing_area
from jointplay.analysis.assessment.forces import forces
from jointplay.analysis.assessment.settled import CHANGES, Settled, Unsettled
from jointplay.analysis.cells import guarded
from jointplay.analysis.gradients import selection
from jointplay.analysis.quantities import WORDS
from jointplay.analysis.recorded_spans import peaks
from jointplay.analysis.starts import End, placed, state_names
from jointplay.analysis.sweeps.attractor import Plan, settle, settle_together
from jointplay.analysis.tolerances.spreads import COUNTED, OF_JOINT, PLAIN, joint_of
from jointplay.solver.mechanism.parameters import INITIAL
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.trajectory import Request, follow

OUTCOMES = ("no", "yes", "undecided", "failed")
NO, YES, UNDECIDED, FAILED = range(4)
LONGER = (1, 4, 16)  # transients more, one after another, of a motion without a period
PATIENT = 4  # from so many on its exponent is measured
LOOKED = 2  # periods over which quantities of a periodic motion are
SAMPLES = 720  # of a turn
POINTS = {"largest": np.max, "smallest": np.min, "end": itemgetter(-1)}
SHARP = ("sliding_work", "impact_loss", "friction_loss")  # integrals, which need many samples


@dataclass(frozen=True)
class Questions:
    """Questions about each sample.

    Parameters
    ----------
    plan : Plan
        How its motion is followed.
    events : tuple of str
        Of `settled.CHANGES`.
    quantities : tuple of str
        As `spreads.known_quantities` has them.
    """

    plan: Plan
    events: tuple[str, ...]
    quantities: tuple[str, ...]


def usual_events(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Events that a mechanism can have."""
    loose = isinstance(mechanism, Mechanism) and mechanism.clearance_joints
    return CHANGES if loose else CHANGES[1:]


def rounds(plan: Plan) -> Iterator[Plan]:
    """How samples are followed, and how those that are still open are followed on, round by round."""
    yield plan
    for more in LONGER:
        longer = {"transient": more * max(plan.transient, 1), "turns": math.isqrt(more) * plan.turns}
        longer |= {"exponents": int(more >= PATIENT), "lyapunov_turns": more // PATIENT * plan.lyapunov_turns}
        yield replace(plan, **longer)


def outcomes(
    mechanism: Mechanism | TestSystem,
    changes: Sequence[Mapping[str, float]],
    initial: Any,
    questions: Questions,
    ends: Sequence[Sequence[Any]] | None = None,
) -> dict[str, Any]:
    """Answers of some samples, each with its changes of the mechanism and of the start.

    Parameters
    ----------
    mechanism, changes, initial
        What moves, what each sample changes, and where it starts.
    questions : Questions
        What is asked; of a round, with its plan.
    ends : sequence, optional
        Where motions that are followed on stand, as ``open`` has them.

    Returns
    -------
    dict
        ``status`` 0, and over samples ``ended`` (status), ``trouble`` (texts), ``period``, ``event``
        (of `OUTCOMES`, over events too) and ``quantity`` (over quantities too); ``open`` has where motions
        stand that have neither a period nor chaos, by the sample's number as a text.
    """
    shared = {"mechanism": mechanism, "initial": initial, "section": questions.plan.section}
    made = [guarded(_made, shared | {"changes": each}) for each in changes]
    ready = [i for i, each in enumerate(made) if not each["status"]]
    if ends is not None:
        for i in ready:
            made[i]["point"] = (made[i]["point"][0], End.read(ends[i]))
    motions = dict(zip(ready, _settled([made[i]["point"] for i in ready], questions.plan), strict=True))
    rows = [_answer(motions.get(i, made[i]), made[i], questions) for i in range(len(changes))]
    return {
        "status": 0,
        "ended": np.array([row["status"] for row in rows], dtype=np.int8),
        "trouble": [row.get("trouble", "") for row in rows],
        "period": np.array([row.get("period", -1) for row in rows], dtype=np.int32),
        "event": np.array([row["event"] for row in rows], dtype=np.int8).reshape(len(rows), -1),
        "quantity": np.array([row["quantity"] for row in rows], dtype=float).reshape(len(rows), -1),
        "open": {str(i): row["end"] for i, row in enumerate(rows) if "end" in row},
    }


def _made(mechanism: Any, changes: Mapping[str, float], initial: Any, section: Any) -> dict[str, Any]:
    """The mechanism of a sample, and its start."""
    starts = {key.removeprefix(INITIAL): v for key, v in changes.items() if key.startswith(INITIAL)}
    own = {key: value for key, value in changes.items() if not key.startswith(INITIAL)}
    varied = rules.varied(mechanism, own)
    if starts:
        model = placed(varied, initial)
        names, state = state_names(model), model.state.copy()
        for name, value in starts.items():
            state[names.index(name)] = value
        initial = state.tolist()
    return {"status": 0, "point": (varied, placed(varied, initial, section))}


def _settled(points: Sequence[tuple[Any, Any]], plan: Plan) -> list[dict[str, Any]]:
    """Motions from points, in lanes where these are wanted."""
    if plan.ensemble:
        return settle_together(points, plan)
    return [guarded(settle, {"mechanism": m, "start": start, "plan": plan}) for m, start in points]


def _answer(found: Mapping[str, Any], made: Mapping[str, Any], questions: Questions) -> dict[str, Any]:
    """Outcome of each event and value of each quantity of a sample."""
    none = {"event": [FAILED] * len(questions.events), "quantity": [np.nan] * len(questions.quantities)}
    if found["status"]:
        return {"status": found["status"], "trouble": found.get("trouble", "")} | none
    mechanism, start = made["point"]
    motion = Settled(mechanism, found["end"], found["values"])
    period = {"status": 0, "period": int(motion.value("period"))}
    if period["period"] == 0 and not motion.traits["chaos"]:  # what was looked for was not found
        return none | period | {"event": [UNDECIDED] * len(questions.events), "end": motion.end}
    try:
        if not questions.plan.transient:  # what is looked at begins with the start
            motion = replace(motion, end=End(state_names(start), start.state, start.crank_angle))
        values = _quantities(motion, questions)
    except Unsettled as error:
        return none | {"status": error.status, "trouble": f"{error} while quantities were looked at"}
    events = [int(motion.traits[name]) for name in questions.events]
    return period | {"event": events, "quantity": [values[name] for name in questions.quantities]}


def _quantities(motion: Settled, questions: Questions) -> dict[str, float]:
    """Values of the wanted quantities of a motion."""
    values: dict[str, float] = {}
    joints = motion.mechanism.contacts if isinstance(motion.mechanism, Mechanism) else ()
    split = {name: name.partition(":")[::2] for name in questions.quantities}
    for name, (head, label) in split.items():
        if head in (*PLAIN, *COUNTED):
            given = motion.value(head)
            values[name] = float(np.asarray(given)[joints.index(label)] if label else given)
    turns = min(questions.plan.turns, LOOKED * motion.period) if motion.period else questions.plan.turns
    if {head for head, _ in split.values()} & {*OF_JOINT}:
        values |= _of_joints(motion, turns, questions, split)
    if course := {n: (h, k) for n, (h, k) in split.items() if h in selection.POINTS}:
        values |= _of_course(motion, turns, questions.plan, course)
    return values


def _of_joints(
    motion: Settled, turns: int, questions: Questions, split: Mapping[str, tuple[str, str]]
) -> dict[str, float]:
    """Forces, speeds of impacts, pressures and losses."""
    wanted = {name: pair for name, pair in split.items() if pair[0] in OF_JOINT}
    brief = not any(head in SHARP for head, _ in wanted.values())
    turns = turns if brief else max(turns, 2)  # whose scatter is looked at
    found = forces(motion, turns, questions.plan, brief=brief, **({"per_turn": SAMPLES} if brief else {}))
    names, values = list(found["names"]), {}
    for name, (head, label) in wanted.items():
        if head == "pressure":
            area = bearing_area(joint_of(motion.mechanism, name))
            values[name] = float(found["peak"][names.index(label)]) / area
        else:
            key = "peak" if head == "force" else head
            values[name] = float(found[key][names.index(label)])
    return values


def _of_course(
    motion: Settled, turns: int, plan: Plan, wanted: Mapping[str, tuple[str, str]]
) -> dict[str, float]:
    """Largest and smallest values of quantities over some turns, and those at their end."""
    model = placed(motion.mechanism, motion.end)
    end = turns * float(motion.value("turn_period"))
    times = np.linspace(0.0, end, turns * SAMPLES + 1)
    limit = {"rtol": plan.rtol, "max_steps": rules.steps(plan.max_steps), "log_from": 0.0}
    records = follow(model, Request(end, at=times, steps=True, events=True, rates=True, **limit))
    if records.status:
        raise Unsettled(records.status)
    rows = evaluate.in_order(records.steps[:, 2:], records.samples)
    given = evaluate.quantities(model, plan.rtol, records, rows)
    courses = given.series([key for _, key in wanted.values()])
    found = {name: float(POINTS[how](courses[key])) for name, (how, key) in wanted.items()}
    largest = {key.partition(":")[0] for how, key in wanted.values() if how == "largest"}
    sizes = given.variables([word for word in ("normal_force", "reaction") if word in largest], "time")
    tops = peaks(given, rows, {word: np.abs(each) for word, (_, each, _) in sizes.items()})[0]
    for word, most in tops.items():  # between points, too
        each = zip(given.labels(WORDS[word].of), most.tolist(), strict=True)
        found |= {name: size for label, size in each if (name := f"largest:{word}:{label}") in found}
    return found
