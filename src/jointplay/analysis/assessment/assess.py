"""The assessment of a linkage with clearance: how hard it is worked, what that hangs on, what changes it.

The *present* motion is found first, as an orbit where it has one (`settled`). Its forces are held against
those of the same linkage with ideal joints (`forces`), and both give its grade (`page`). The same motion
with other contact data says what the answer hangs on (`alternatives`). Over each clearance and the drive's
speed follow largest forces and impact speeds (`curves`), and the values at which contact is first lost or
kept, the motion first leaves or reaches period 1, and chaos begins or ends (`edges`).
Validity: of the one motion that is followed, from the start given; where others coexist, each has its own.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis import rules
from jointplay.analysis.assessment.alternatives import hangs_on, variants
from jointplay.analysis.assessment.curves import END, NOT_RUN, VALUES, Scene, curve, either_side, ratios
from jointplay.analysis.assessment.edges import HOW, SIDES, Search, edges
from jointplay.analysis.assessment.forces import EXPONENT, PER_TURN, SHOWN, WORK, forces
from jointplay.analysis.assessment.page import (
    BY,
    GRADES,
    PLACES,
    UNKNOWN,
    answer,
    grade,
    largest,
    over_ideal,
    page,
)
from jointplay.analysis.assessment.settled import (
    CHANGES,
    LASTING,
    SLOW,
    Settled,
    Unsettled,
    followed,
    plan,
    present,
)
from jointplay.analysis.cells import first_bad, growing, handed_out, shown, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import RUN
from jointplay.analysis.keywords import HANDED, Divided, Moving, Names, Small, analysis
from jointplay.analysis.labels import Out, ended, xr
from jointplay.analysis.quantities import STATUS
from jointplay.analysis.starts import placed
from jointplay.analysis.states.ends import padded
from jointplay.analysis.tangents import warm_tangents
from jointplay.analysis.tolerances.spreads import OF_JOINT, Spreads, spreads_fit
from jointplay.display.errors import NOTHING, InputError, Problem, warn
from jointplay.solver.mechanism.base import Natural, Number, Positive, is_number, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import OutOfTime, limited, part, stands

TURNS, LYAPUNOV_TURNS, RTOL = 20, 200, 1e-7
REACH, STEP, ACCURACY, LASTS = 2.0, 0.005, 1e-3, 0.01
LOOKED_AT = 32  # turns in which a settled motion must repeat
BUDGET = 90.0  # s
SOON, SETTLING = 2.0, 6  # s; part of the budget: in which the present motion is to settle, at first and then
FEW = 5  # turns dropped, and again recorded, where it does not
LEAST, MOST = 1.0, 24  # s that a cell has at least, and how often it may go on
SHARES = {  # of the work, about, that is done before and after each round: of a motion that
    "keeps contact": (0.0, 0.07, 0.13, 0.35, 1.0),
    "loses contact": (0.0, 0.02, 0.04, 0.14, 1.0),
    "settles slowly": (0.0, 0.03, 0.04, 0.9, 1.0),
}
HOUR = 3600.0
NO_IDEAL = "with ideal joints the crank comes to no steady speed: there are no ideal forces to compare with"
OVER = ("parameter", "side", "change")
BALANCE = "equal to ``joint_work`` and ``drive_work`` where nothing else takes energy"
LENGTH = "where a bearing's length is given"
START = "accepted as ``initial``"
SHARES_OF = "lowest and highest of each 512th of the turn with the largest"
CHANGED = (*OVER[:2], "place")
GRADED = (*GRADES, UNKNOWN)
TOLD = ("no", "yes", UNKNOWN)
CONTACTS = {
    "separations": Out("joint", "separations in a turn"),
    "impacts": Out("joint", "contacts begun in a turn"),
    "contact_fraction": Out("joint", "share of time in contact"),
    **{name: Out("joint", *OF_JOINT[name]) for name in ("impact_speed", *PER_TURN)},
    **{f"{name}_error": Out("joint", f"error of: {OF_JOINT[name][0]}", "J") for name in PER_TURN},
}
OUTPUTS = Outputs(
    "assess",
    {
        "turn_share": Out("turn_share", "share of a turn"),
        "joint": Out("joint", "joint", ""),
        "parameter": Out("parameter", "what is varied", ""),
        "side": Out("side", "side of the present value", ""),
        "change": Out("change", "what changes", ""),
        "state": Out("state", "state", ""),
        "place": Out("place", "place, before or after a change of the grade", ""),
    },
    {
        "peak_force": Out("joint", "largest joint force", "N"),
        "peak_force_error": Out("joint", "error of the largest joint force", "N"),
        "ideal_peak_force": Out("joint", "largest joint force of the ideal mechanism", "N"),
        "ideal_peak_force_error": Out("joint", "error of the ideal one", "N"),
        "force_ratio": Out("joint", "largest joint force over the ideal mechanism's"),
        "joint_force": Out(("turn_share", "joint"), "joint force", "N", SHARES_OF),
        "ideal_joint_force": Out(("turn_share", "joint"), "joint force, ideal mechanism", "N", SHARES_OF),
        "clearance": Out("joint", "radial clearance", "m"),
        "contact_data": Out("joint", "contact law with its numbers, and friction", ""),
        "contact_sources": Out("joint", "where these numbers come from", ""),
        "stiffness_load": Out("joint", "force at which stiffness follows from pin and bush", "N"),
        "friction_coefficient": Out("joint", "coefficient of friction of a joint with clearance"),
    }
    | CONTACTS
    | {
        "sliding_work_per_hour": Out("joint", "normal force times sliding distance per hour", "J"),
        "contact_pressure": Out("joint", *OF_JOINT["pressure"], LENGTH),
        "grade": Out((), "grade of the present motion", flags=GRADED, missing=UNKNOWN),
        "period": Out((), "period in turns, 0 for none"),
        "section_exponent_per_turn": Out((), "largest exponent of the section's map, per turn"),
        "section_standard_error_per_turn": Out((), "its standard error"),
        "largest_multiplier": Out((), "largest modulus of the orbit's multipliers, per period"),
        "crank_speed": Out((), "mean speed of the crank", "rad s-1"),
        "drive_work": Out((), "work of the drive in a turn", "J"),
        "joint_work": Out((), "work taken in by the contacts in a turn", "J"),
        "joint_loss": Out((), "sum of the losses in normal contact and friction", "J", BALANCE),
        "joint_loss_error": Out((), "error of the sum of the losses", "J"),
        "present": Out("change", "present motion", flags=("no", "yes", "unknown")),
        "edge_ratio": Out(OVER, "where it changes, as a multiple of the present value"),
        "edge_ratio_error": Out(OVER, "its error"),
        "bracket_low": Out(OVER, "lower end of its bracket"),
        "bracket_high": Out(OVER, "upper end of its bracket"),
        "return_ratio": Out(OVER, "where it is first as at present again", about="NaN: not met"),
        "edge_speed": Out(OVER, "nominal speed of the crank there", "rad s-1"),
        "present_value": Out("parameter", "present value, in the units of parameter_units"),
        "parameter_units": Out("parameter", "units of the parameter"),
        "parameter_name": Out("parameter", "the parameter"),
        "limit_ratio": Out(OVER[:2], "last value looked at, as a multiple of the present one"),
        "values_looked_at": Out(OVER[:2], "values looked at, in even steps of the logarithm"),
        "looked_ratio": Out((*OVER[:2], "looked"), "value looked at, as a multiple of the present one"),
        "looked_period": Out((*OVER[:2], "looked"), "period of its motion in turns, 0 for none"),
        **{
            f"looked_{name}": Out((*OVER[:2], "looked"), text, flags=TOLD, missing=UNKNOWN)
            for name, text in (
                ("contact_loss", "whether contact is lost there"),
                ("chaos", "whether it is chaotic"),
            )
        },
        "looked_state": Out(
            (*OVER[:2], "looked", "state"), "its motion at crank angle 0, in SI units", about=START
        ),
        "window_low": Out((*OVER[:2], "window"), "low end of a narrow window, as a multiple of present"),
        "window_high": Out((*OVER[:2], "window"), "its upper end"),
        "window_period": Out((*OVER[:2], "window"), "period of the motion in the window, turns; 0 for none"),
        "variant_quantity": Out("variant", "contact data that is changed", ""),
        "variant_change": Out("variant", "how it is changed", ""),
        "variant_peak_force": Out(("variant", "joint"), "largest joint force with other contact data", "N"),
        "variant_separations": Out(("variant", "joint"), "separations in a turn with other contact data"),
        "variant_impact_speed": Out(
            ("variant", "joint"), "largest impact speed with other contact data", "m s-1"
        ),
        "variant_period": Out("variant", "period with other contact data in turns, 0 for none seen"),
        "variant_grade": Out("variant", "grade with other contact data", flags=GRADED, missing=UNKNOWN),
        "variant_status": Out("variant", "how the run with other contact data ended", flags=STATUS),
        "curve_ratio": Out(("parameter", "value"), "value, as a multiple of the present one"),
        "curve_peak_force": Out(("parameter", "value", "joint"), "largest joint force there", "N"),
        "curve_ideal_peak_force": Out(("parameter", "value", "joint"), "ideal joints' largest force", "N"),
        "curve_impact_speed": Out(("parameter", "value", "joint"), "largest impact speed there", "m s-1"),
        "curve_period": Out(("parameter", "value"), "period there in turns, 0 for none seen"),
        "curve_grade": Out(("parameter", "value"), "grade there", flags=GRADED, missing=UNKNOWN),
        "curve_status": Out(("parameter", "value"), "how the run there ended", flags=STATUS),
        "grade_change_ratio": Out(CHANGED, "value beside the change, as a multiple of the present one"),
        "grade_change_by": Out(CHANGED, "by what the grade's change is known", flags=BY, missing=UNKNOWN),
        "grade_change_grade": Out(CHANGED, "grade there", flags=GRADED, missing=UNKNOWN),
        "grade_change_joint": Out(CHANGED, "joint with the largest ratio there", ""),
        "grade_change_force": Out(CHANGED, "largest force there, of the joint with the largest ratio", "N"),
        "grade_change_force_ratio": Out(CHANGED, "its ratio to the ideal mechanism's"),
        "grade_change_impact_speed": Out(CHANGED, "largest impact speed there", "m s-1"),
        "found_by": Out(OVER, "how it was found", flags=HOW),
        "side_status": Out(OVER[:2], "why no further values were looked at", flags=STATUS),
        "preparation": Out((), "time to compile or load functions", "s"),
        "step": Out((), "relative distance of the values looked at first"),
        "lasting_share": Out((), "share of the parameter over which a change lasts"),
        "lasting_turns": Out((), "turns that chaos lasted, beside a chaotic motion"),
        "status": Out((), "how it ended", flags=STATUS),
        "wall_time": RUN["wall_time"],
    },
    answer,
    table=page,
)
Answer = Mapping[str, Any]


def _assessable(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    if not isinstance(mechanism, Mechanism):
        other = "kind = 'bifurcation' or 'continuation' tells where the motion of equations changes"
        yield Problem("mechanism", mechanism.name, f"a linkage with play in a joint is assessed; {other}")
        return
    if not mechanism.clearance_joints:
        yield Problem("mechanism.joints", "no clearance", "clearance in at least one joint is needed")
    for joint in mechanism.clearance_joints:
        if joint.kind == "prismatic":
            where = f"mechanism.joints.{joint.name}.clearance"
            yield Problem(where, joint.clearance, "0 is accepted of a guide: clearance in others is assessed")
    if mechanism.drive is None:
        yield Problem("mechanism.drive", NOTHING, "a drive that turns the crank is needed")


def _along_fits(mechanism: Mechanism | TestSystem, along: Sequence[str] | None) -> Iterator[Problem]:
    if along == () or len({*(along or ())}) < len(along or ()):
        yield Problem("along", along, "one parameter or several, each once, are accepted")
    yield from rules.alike_beside(mechanism, "along", along or ())
    several = isinstance(mechanism, Mechanism) and len(mechanism.clearance_joints) > 1
    for i, key in enumerate(along or ()):
        place = f"along[{i}]"
        value = Parameter.named(mechanism, key, place).value
        if not is_number(value) or value == 0:
            yield Problem(place, key, "a parameter whose value is a number other than 0 is accepted")
        elif key == "clearance" and several:
            expected = "one of several clearances is accepted by its path, joints.NAME.clearance"
            yield Problem(place, key, expected)


@growing
@analysis(
    *(_assessable, _along_fits, "model", rules.turns_alike, spreads_fit),
    usual={"rtol": RTOL},
    outputs=OUTPUTS,
)
def assess(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    along: Names | None = None,
    reach: Annotated[Number, Field(gt=1, le=100), unit("factor", "1")] = REACH,
    step: Annotated[Small, unit("relative step", "1")] = STEP,
    accuracy: Annotated[Small, unit("relative width", "1")] = ACCURACY,
    lasting: Annotated[Small, unit("relative width", "1")] = LASTS,
    turns: Annotated[Natural, Field(ge=2)] = TURNS,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    budget: Annotated[Positive, unit("duration", "s")] = BUDGET,
    spreads: Spreads | None = None,
    **motion: Unpack[Divided],
) -> xr.Dataset:
    """Assess a linkage with clearance: how hard it is worked, what that hangs on, and what changes it.

    Parameters
    ----------
    mechanism : Mechanism
        With clearance in a joint, and a drive.
    along : sequence of str, optional
        What is varied, each alone, as in `bifurcation`; every clearance, and the motor's gear ratio or the
        constant speed, if left out.
    reach : float
        Each is followed from its present value down to this fraction, and up to this multiple, of it.
    step : float
        Relative distance of the values looked at where contact is lost or nearly so; up to 8 times that
        where the orbit is far from any change, 5 times where the present motion is chaotic. What begins and
        ends within it may be missed.
    accuracy : float
        Relative distance of two settled motions that enclose a change in the end, where no orbit does; in
        chaos not below half of `step`.
    lasting : float
        Share of the parameter over which a change has to last. One that does not is a window.
    turns : int
        Turns over which forces are recorded, of a motion that does not repeat.
    lyapunov_turns : int
        Turns over which the present motion's exponent is averaged; 0.3 of them at other values.
    budget : float
        Time of the processors after which all but the present motion is cut short, s. What was not reached
        has the status ``not_run``; of a study, a later run goes on with it.
    spreads : dict of str to Spread, optional
        Those of `jointplay.tolerances`, to which the page then leads; they change nothing else.

    Raises
    ------
    InputError
        Listing everything that makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    how = plan(motion["transient"], LOOKED_AT, lyapunov_turns, motion["rtol"], motion["max_steps"])
    ideal = mechanism.replace(clearance=0.0)
    initial, lasted = motion["initial"], LASTING[0] * motion["transient"]
    warm([model, rules.model_for(mechanism, initial, None, WORK), placed(ideal, None)])
    warm_tangents(model)
    ready = time.perf_counter()
    keys, said = rules.usual_alike(mechanism, parameters_of(mechanism)) if along is None else (along, {})
    possible = 3 + 3 * len(keys)
    rounds = Rounds(budget, motion["progress"], motion["n_jobs"], possible)
    shared = {"mechanism": mechanism, "how": how, "turns": turns}
    first = shared | {"start": initial, "patience": SOON}
    now, like = rounds.answers(assessed, [first, first | {"mechanism": ideal}])
    if np.isnan(like.get("peak", 0.0)).all():
        said = {"warning": "; ".join([*said.values(), *warn(NO_IDEAL).values()])}
    known = [[{"status": NOT_RUN}] * count for count in (1, len(keys), len(SIDES) * len(keys))]

    def made() -> xr.Dataset:
        data = {"preparation": ready - began, "step": step, "lasting_share": lasting, "lasting_turns": lasted}
        data |= ended(first_bad([now, like]), began)
        (other,), over, sides = known
        found = assembled(mechanism, keys, now, like, other, over, sides)
        own = {"tolerances": len(spreads)} if spreads else {}
        return found.assign(OUTPUTS.variables_of(data)[0]).assign_attrs(own | said)

    shown(made, 0)
    if now.get("hurried"):
        rounds.number = 0
        (now,) = rounds.answers(assessed, [first | {"patience": max(budget, BUDGET) / SETTLING}])
        shown(made, 0)
    shared["motion"], search = now.get("motion"), Search(reach, step, accuracy, lasting)
    along = [shared | {"key": key, "start": initial} for key in keys]
    later = (
        (hung, [shared]),
        (curved, along),
        (sided, [each | {"side": side, "search": search} for each in along for side in SIDES]),
    )
    rounds.shares = SHARES[_kind(now)]
    for number, (function, cells) in enumerate(later):
        known[number] = rounds.answers(function, cells, now)
        if number == len(later) - 1:
            shown(made, number)  # once more: edges may be nearer than what is found by curves
        shown(made, number + 1)
    return made()


assess.bounds = {"budget"}  # type: ignore[attr-defined]  # what it leaves out, a later run adds


def _kind(now: Answer) -> str:
    """Words for a motion by which the shares of the work are known."""
    if "motion" in now and now["motion"]["radius"] > SLOW:
        return "settles slowly"
    return "loses contact" if now.get("traits", [1])[0] else "keeps contact"


class Rounds:
    """Rounds of cells, each of which needs answers of the one before, as long as the budget lasts.

    A cell has a share of what is left. What that cuts short goes on from what it `known`, in the same run
    where others leave some, or in a later one. What begins anew has twice as long in each, so that it ends.
    """

    def __init__(
        self, budget: float, progress: Callable[[float], None] | None, n_jobs: int | None, possible: int
    ):
        self.began, self.budget, self.spent = time.time(), budget, 0.0
        self.since = self.began
        self.progress, self.n_jobs, self.possible, self.number = progress, n_jobs, possible, 0
        self.shares = SHARES["keeps contact"]

    def answers(
        self, function: Callable[..., Answer], cells: Sequence[dict[str, Any]], needed: Answer | None = None
    ) -> list[Answer]:
        """Answers of a round; ``not_run`` where the budget is used up, or an answer that it needs failed."""
        tell = self.progress and part(self.told, *self.shares[self.number : self.number + 2])
        self.number, self.since = self.number + 1, time.time()
        found: list[Answer] = [{"status": NOT_RUN}] * len(cells)
        cut, left = 0, [] if needed is not None and needed["status"] else [*range(len(cells))]
        for low in (LEAST * 2**n for n in range(MOST)):
            if not left or self.spent >= self.budget:
                break
            limit = math.inf if needed is None else max(low, 2**cut * (self.budget - self.spent) / len(left))
            requests = [{"limit": limit, "known": found[i].get("known", {})} | cells[i] for i in left]
            given = handed_out(function, requests, tell, self.n_jobs, possible=self.possible)
            fresh = [each for each in given if each.get("at", 0.0) >= self.began]  # not of an earlier run
            self.spent += sum(each["cpu"] for each in fresh)
            cut += not fresh and not any("known" in each for each in given)  # such begin anew
            for i, request, each in zip(left, requests, given, strict=True):
                found[i] = {"known": request["known"]} | each
            left = [i for i in left if found[i]["status"] == NOT_RUN]
        return found

    def told(self, done: float) -> None:
        """Tell how much is done: of the work or, where that is more, of the budget at its pace so far."""
        before = self.since - self.began
        pace = self.spent / before if self.spent and before else 1.0  # in processors
        used = self.spent + pace * (time.time() - self.since)
        self.progress(max(done, min(used / self.budget, 1.0)))


def _timed(limit: float, function: Callable[..., Answer], *values: Any) -> Answer:
    """The answer of a function, with its time of the processor and the time of its end, s.

    ``not_run`` where it takes longer than `limit`.
    """
    began = time.thread_time()
    try:
        with limited(limit):
            found = {"status": 0, "trouble": ""} | function(*values)
    except OutOfTime:
        found = {"status": NOT_RUN, "trouble": ""}
    except Unsettled as error:
        found = {"status": error.status, "trouble": str(error)}
    return found | {"cpu": time.thread_time() - began, "at": time.time()}


def assessed(
    mechanism: Mechanism, start: Any, turns: int, how: Any, patience: float, limit: float = math.inf, **_: Any
) -> Answer:
    """Answer of a cell: the motion that a mechanism settles to, and its forces.

    Where it has not settled within `patience`, s of the processor, the motion is that after a few turns.
    """

    def found() -> Answer:
        stands(0.0, "the present motion" if mechanism.clearance_joints else "ideal joints")
        try:
            with limited(patience):
                motion = present(mechanism, start, how)
        except OutOfTime:
            motion = followed(mechanism, start, replace(how, transient=FEW, turns=2 * FEW))
            return forces(motion, FEW, how) | {"motion": motion.plain(), "hurried": True}
        return forces(motion, turns, how) | {"motion": motion.plain()}

    return _timed(limit, found)


def hung(mechanism: Mechanism, motion: Answer, turns: int, how: Any, limit: float, **_: Any) -> Answer:
    """Answer of a cell: the same motion with other contact data."""
    return _timed(limit, hangs_on, Settled.of(mechanism, motion), turns, how)


def curved(
    mechanism: Mechanism, motion: Any, key: str, start: Any, turns: int, how: Any, limit: float, **more: Any
) -> Answer:
    """Answer of a cell: forces over a parameter."""
    return _timed(limit, curve, Settled.of(mechanism, motion), key, start, turns, how, more["known"])


def sided(
    mechanism: Mechanism,
    motion: Answer,
    key: str,
    side: str,
    search: Search,
    turns: int,
    how: Any,
    limit: float,
    known: Answer,
    **_: Any,
) -> Answer:
    """Answer of a cell: changes on one side of a parameter, and the motions beside the edge of contact."""
    here = Settled.of(mechanism, motion)

    def found() -> Answer:
        answer = edges(here, key, side, search, how, known)
        edge = answer["edge"][CHANGES.index("contact_loss")]
        if answer["status"] or not math.isfinite(edge):
            return answer
        scene = Scene(here, key, here.end, turns, how)
        try:
            return answer | {"beside": either_side(scene, edge / scene.present, search.step)}
        except OutOfTime:  # what was found stands, until there is time for the whole
            return answer | {"status": NOT_RUN}

    return _timed(limit, found)


def assembled(
    mechanism: Mechanism,
    keys: Sequence[str],
    now: Answer,
    ideal: Answer,
    other: Answer,
    over: Sequence[Answer],
    sides: Sequence[Answer],
) -> xr.Dataset:
    """Make the dataset: of the present motion, of the ideal one, of other contact data, curves and sides."""
    joints = [joint.name for joint in mechanism.joints]
    values = _forces(joints, now, ideal) | _contacts(mechanism, joints, now) | _motion(now)
    values |= _graded(mechanism, values) | _variants(mechanism, joints, other, values["ideal_peak_force"])
    values |= _curves(joints, keys, over) | _grade_changes(now, over, sides)
    labels = {"joint": joints, "parameter": list(keys), "side": list(SIDES), "change": list(CHANGES)}
    labels |= {"place": list(PLACES), "state": [*now.get("motion", {}).get("end", ((),))[0]]}
    values |= _edges(mechanism, keys, sides, len(labels["state"]))
    values |= {name: np.array(each, dtype=str) for name, each in labels.items()}
    return OUTPUTS.dataset(values | {"turn_share": np.linspace(0, 1, 2 * SHOWN + 1)})


def _on(joints: list[str], answer: Answer, key: str, rows: int | None = None) -> np.ndarray:
    """Values of an answer in the order of the mechanism's joints; NaN where it has none."""
    result = np.full((len(joints),) if rows is None else (rows, len(joints)), np.nan)
    given = np.asarray(answer.get(key, np.zeros(0)))
    for i, name in enumerate(answer.get("names", ())[: given.shape[-1]]):
        result[..., joints.index(name)] = given[..., i]
    return result


def _forces(joints: list[str], now: Answer, ideal: Answer) -> dict[str, Any]:
    peak, like = _on(joints, now, "peak"), _on(joints, ideal, "peak")
    return {
        "peak_force": peak,
        "peak_force_error": _on(joints, now, "peak_error"),
        "ideal_peak_force": like,
        "ideal_peak_force_error": _on(joints, ideal, "peak_error"),
        "force_ratio": over_ideal(peak, like),
        "joint_force": _on(joints, now, "force", 2 * SHOWN + 1),
        "ideal_joint_force": _on(joints, ideal, "force", 2 * SHOWN + 1),
    }


def _contacts(mechanism: Mechanism, joints: list[str], now: Answer) -> dict[str, Any]:
    loose = [each if each.clearance > 0 and each.contact is not None else None for each in mechanism.joints]
    data = [_contact_data(joint) if joint else "" for joint in loose]
    friction = [getattr(joint.friction, "coefficient", 0.0) if joint else np.nan for joint in loose]
    found: dict[str, Any] = {"contact_data": np.array(data), "friction_coefficient": np.array(friction)}
    found["contact_sources"] = np.array([_sources(joint) if joint else "" for joint in loose])
    loads = [joint.data.load if joint and joint.data else np.nan for joint in loose]
    found["stiffness_load"] = np.array(loads)
    found["clearance"] = np.array([joint.clearance for joint in mechanism.joints])
    found |= {name: _on(joints, now, name) for name in CONTACTS}
    found["sliding_work_per_hour"] = found["sliding_work"] * HOUR / now.get("turn_period", np.nan)
    return found


def bearing_area(joint: Any) -> float:
    """Projected area of a joint's bearing, m²; NaN where it is not known."""
    return 2 * (joint.radius if joint.clearance and joint.radius else np.nan) * _length(joint)


def _length(joint: Any) -> float:
    """Length of a joint's bearing, m; NaN where it is not known."""
    if joint.data is not None:
        return joint.data.parts.length
    return joint.contact.parameters.get("length", np.nan) if joint.contact else np.nan


def _contact_data(joint: Any) -> str:
    """Law of contact and friction of a joint, in words."""
    friction = f"friction {joint.friction.description}" if joint.friction else "no friction"
    law, text = joint.contact.law.replace("_", " "), joint.contact.description
    text += f", that is {joint.data.secant}" if joint.data else ""
    return f"{text if text.startswith(law) else f'{law}, {text}'}; {friction}"


def _sources(joint: Any) -> str:
    """Sources of the numbers of a joint's contact and friction, in words."""
    places: dict[str, list[str]] = {}
    for name, place in joint.sources.items():
        places.setdefault(place, []).append(name.replace("_", " "))
    return "; ".join(f"{place}: {', '.join(names)}" for place, names in places.items())


def _motion(now: Answer) -> dict[str, Any]:
    taken = float(sum(np.sum(now.get(name, np.nan)) for name in PER_TURN[:2]))
    doubt = float(np.hypot(*(np.sum(now.get(f"{name}_error", np.nan)) for name in PER_TURN[:2])))
    exponent, error = (float(now.get(name, np.nan)) for name in EXPONENT)
    return {
        "period": float(now.get("period", np.nan)),
        "section_exponent_per_turn": exponent,
        "section_standard_error_per_turn": error,
        "largest_multiplier": float(now["motion"]["radius"]) if "motion" in now else np.nan,
        "crank_speed": 2 * np.pi / now.get("turn_period", np.nan),
        "drive_work": now.get("drive_work", np.nan),
        "joint_work": now.get("joint_work", np.nan),
        "joint_loss": taken,
        "joint_loss_error": doubt,
        "present": now.get("traits", np.full(len(CHANGES), 2)),
    }


def _graded(mechanism: Mechanism, values: Mapping[str, Any]) -> dict[str, Any]:
    """Grade of the present motion, and the pressure on bearings whose length is known."""
    pressure = values["peak_force"] / np.array([bearing_area(joint) for joint in mechanism.joints])
    known = values["present"][0] < TOLD.index(UNKNOWN)
    mark = _grade(values["present"][0] == 1, values["force_ratio"], values["impact_speed"]) if known else None
    return {"grade": GRADED.index(UNKNOWN) if mark is None else mark, "contact_pressure": pressure}


def _grade(lost: bool, ratio: np.ndarray, speed: np.ndarray) -> int:
    return grade(bool(lost), largest(ratio), float(np.nanmax(speed, initial=0.0)))


def _variants(mechanism: Mechanism, joints: list[str], other: Answer, ideal: np.ndarray) -> dict[str, Any]:
    """Forces with other contact data, in the order of `variants`."""
    made = list(variants(mechanism))
    rows = len(made)
    if "peak" not in other:
        other = {"names": [], "statuses": np.full(rows, other["status"])}
    names = {"peak_force": "peak", "separations": "separations", "impact_speed": "impact_speed"}
    found = {f"variant_{new}": _on(joints, other, old, rows) for new, old in names.items()}
    marks = np.full(rows, GRADED.index(UNKNOWN))
    lost = np.asarray(other.get("lost", np.full(rows, np.nan)), dtype=float)
    for i in np.flatnonzero(np.isfinite(lost)):
        speeds = found["variant_impact_speed"][i]
        marks[i] = _grade(lost[i] == 1, over_ideal(found["variant_peak_force"][i], ideal), speeds)
    return found | {
        "variant_quantity": np.array([each.quantity for each in made], dtype=str),
        "variant_change": np.array([each.change for each in made], dtype=str),
        "variant_period": np.asarray(other.get("period", np.full(rows, np.nan)), dtype=float),
        "variant_grade": marks,
        "variant_status": np.asarray(other["statuses"]),
    }


def _curves(joints: list[str], keys: Sequence[str], over: Sequence[Answer]) -> dict[str, Any]:
    """Forces over each parameter, and where the grade first changes."""
    shape = (len(keys), VALUES)
    found: dict[str, Any] = {"curve_ratio": np.array([ratios(key) for key in keys])}
    for new, old in (("peak_force", "peak"), ("ideal_peak_force", "ideal"), ("impact_speed", "impact_speed")):
        found[f"curve_{new}"] = np.array([_on(joints, each, old, VALUES) for each in over])
    period, marks = np.full(shape, np.nan), np.full(shape, GRADED.index(UNKNOWN))
    statuses = np.full(shape, NOT_RUN)
    for i, each in enumerate(over):
        if "statuses" not in each:
            statuses[i] = each["status"]
            continue
        statuses[i], period[i] = each["statuses"], each["period"]
        known = np.isfinite(np.asarray(each["grade"], dtype=float))
        marks[i, known] = np.asarray(each["grade"])[known]
    return found | {"curve_period": period, "curve_grade": marks, "curve_status": statuses}


def _grade_changes(now: Answer, over: Sequence[Answer], sides: Sequence[Answer]) -> dict[str, Any]:
    """First change of the grade on each side of each parameter, and the evidence for it."""
    none = np.full((len(SIDES), len(PLACES), len(END)), np.nan)
    coarse = np.concatenate([each.get("change", none) for each in over])
    nearest = [first_change(each, side.get("beside")) for each, side in zip(coarse, sides, strict=True)]
    columns = np.moveaxis(np.reshape(nearest, (len(over), *none.shape)), -1, 0)
    found = {f"grade_change_{name}": column for name, column in zip(END, columns, strict=True)}
    for name, words in (("grade_change_grade", GRADED), ("grade_change_by", BY)):
        found[name] = np.where(np.isnan(found[name]), words.index(UNKNOWN), found[name])
    names = np.array([*now.get("names", ()), ""])
    places = np.fmin(found["grade_change_joint"], len(names) - 1).astype(int)
    return found | {"grade_change_joint": names[places]}


def first_change(coarse: np.ndarray, edge: np.ndarray | None) -> np.ndarray:
    """The nearer one of a change of the grade among a curve's values and of the edge of contact.

    Both as the places before and after it. No farther apart than the former's two they are the same.
    """
    if edge is None:
        return coarse
    (before, far), (_, there) = (np.abs(np.log(each[:, END.index("ratio")])) for each in (coarse, edge))
    return coarse if far + (far - before) < there else edge


def _edges(mechanism: Mechanism, keys: Sequence[str], sides: Sequence[Answer], states: int) -> dict[str, Any]:
    shape = (len(keys), len(SIDES), len(CHANGES))

    def numbers(name: str, missing: Any) -> np.ndarray:
        """Numbers of each side, over parameters, sides, and whatever else."""
        given = np.array([each.get(name, missing) for each in sides])
        return given.reshape(*shape[:2], *given.shape[1:])

    def table(name: str, columns: int) -> np.ndarray:
        """Rows of each side of each parameter, NaN behind the last."""
        listed = [np.asarray(each.get(name, ()), dtype=float) for each in sides]
        given = [np.reshape(each, (len(each), columns)) for each in listed]
        rows = padded(given, columns)
        return rows.reshape(*shape[:2], *rows.shape[1:])

    along = [Parameter(mechanism, key) for key in keys]
    values = np.array([float(each.value) for each in along])
    found = {n: numbers(n, np.full(shape[2], np.nan)) for n in ("edge", "error", "low", "high", "back")}
    ratio = {name: each / values[:, None, None] for name, each in found.items()}
    speeds = [[_speed(mechanism, key, v) for v in found["edge"][i].flat] for i, key in enumerate(keys)]
    windows, looked, traits = table("windows", 3), table("looked", 1), table("traits", len(CHANGES))
    ends = np.sort(windows[..., :2] / values[:, None, None, None], axis=-1)
    traits = np.where(np.isnan(traits), TOLD.index(UNKNOWN), traits)
    return {
        "edge_ratio": ratio["edge"],
        "edge_ratio_error": np.abs(ratio["error"]),
        "bracket_low": np.minimum(ratio["low"], ratio["high"]),
        "bracket_high": np.maximum(ratio["low"], ratio["high"]),
        "return_ratio": ratio["back"],
        "edge_speed": np.reshape(speeds, shape),
        "present_value": values,
        "parameter_units": np.asarray([each.cf_units for each in along]),
        "parameter_name": np.asarray([each.noun for each in along]),
        "limit_ratio": numbers("limit", np.nan) / values[:, None],
        "values_looked_at": np.isfinite(looked).sum(axis=(2, 3)),
        "looked_ratio": looked[..., 0] / values[:, None, None],
        "looked_period": table("periods", 1)[..., 0],
        "looked_contact_loss": traits[..., CHANGES.index("contact_loss")],
        "looked_chaos": traits[..., CHANGES.index("chaos")],
        "looked_state": table("states", states),
        "window_low": ends[..., 0],
        "window_high": ends[..., 1],
        "window_period": windows[..., 2],
        "found_by": numbers("how", np.zeros(len(CHANGES))),
        "side_status": numbers("status", NOT_RUN),
    }


def _speed(mechanism: Mechanism, key: str, value: float) -> float:
    """Nominal speed of the drive where a parameter has a value, rad/s."""
    try:
        return float(mechanism.varied({key: float(value)}).drive.nominal_speed)
    except InputError:  # not met
        return float("nan")


def parameters_of(mechanism: Mechanism) -> tuple[str, ...]:
    """Parameters varied by default: every clearance, and the numbers that set the drive's speed."""
    loose = tuple(f"joints.{joint.name}.clearance" for joint in mechanism.joints if joint.clearance > 0)
    return (*loose, *(word for word in ("gear_ratio", "speed") if Parameter(mechanism, word).value))
