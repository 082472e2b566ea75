"""Optimisation of numbers of a mechanism over exact derivatives of its motion.

    least f(p)  with  low <= q(p) <= high  and  l <= p <= u,

f and q quantities of `gradient` on a motion or on the periodic orbit that it settles to. Chaos has no useful
derivative: `ideal` begins with the mechanism whose joints have no play, whose motion is periodic, and opens
the play by and by. What is found is a local optimum, held against the motion followed
from the usual start at rtol 1e-10, which need not settle to the orbit that was optimised, and against the
designs beside it. Validity: as of `gradient`; where two places share a largest value, f has a kink, at which
the descent may stay: the designs beside say by how much.

Opening the play is a homotopy: descents with ever more of it, each from the design found with less. A design
that is best without play may rattle with it, and rattling has no useful derivative. So the clearance is
opened in steps, from none on: at each the design is found anew, from a motion that still keeps the
constraints. A step at which no design keeps them is tried again, shorter. Reference: Allgower and Georg,
Introduction to Numerical Continuation Methods (2003), chapter 1.

A descent is sequential quadratic programming (SciPy's SLSQP, with the exact derivatives) in boxes, drawn in
where a motion has no derivative. A design without a motion that can be differentiated (chaos where an orbit
is sought, a run that stopped) ends its pass: the next one begins at the best design so far, in a box of a
quarter of the size. A pass that ends at a side of its box goes on in one of twice the size. Reference: Kraft,
A software package for sequential quadratic programming, DFVLR-FB 88-28 (1988).

Trials of an optimisation: quantities and exact derivatives at a design, in scaled variables.

With the bounds l, u of the variables p, the scaled ones are x = (p - l) / (u - l), 0…1. Each design is tried
once; what was found is kept, in order, and is what the dataset shows as iterations. Where a periodic orbit
was found at one design, it is sought at the next ones from where its derivative leads: no transient is
followed, and the orbit is the same one, stable or not.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Annotated, Any, Literal, Unpack

import numpy as np
from pydantic import Field
from scipy.optimize import minimize

from jointplay.analysis.coexisting.region import Ends
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.gradients import gradient_dataset, selection
from jointplay.analysis.gradients.gradient import gradient, settling_fits, start_section
from jointplay.analysis.gradients.gradient_dataset import IN_PARAMETER, IN_QUANTITY, VERDICTS
from jointplay.analysis.gradients.selection import MULTIPLIERS
from jointplay.analysis.keywords import Moving, Quantity, Settling, Small, analysis
from jointplay.analysis.labels import Out, ended, xr
from jointplay.analysis.orbits.orbit_dataset import started
from jointplay.analysis.quantities import STATUS, WORDS
from jointplay.analysis.rules import alike_beside, turns_alike
from jointplay.analysis.simulate import simulate
from jointplay.analysis.vary import axes, repeated
from jointplay.display import codes
from jointplay.display.errors import NOTHING, InputError, ModelWarning, Problem, problems_of
from jointplay.display.number_text import measure, plain
from jointplay.solver.mechanism.base import Flag, Natural, Number, accepts, unit
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.paths import parts_of
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.motion.progress import tick

WHY = {  # a search ended so
    "converged": "",
    "no_descent": "the search stopped where no step improved the design",
    "infeasible": "no design was found that meets the constraints",
    "iterations": "the search stopped at its last iteration",
    "no_motion": "the first motion has no derivative; another start, or ideal = true, may help",
}
ENDS = tuple(WHY)
AGREED = 1e-4  # relative difference up to which two motions have the same value
LISTED = 6  # parameters of a design named in a line
INFINITE = (-math.inf, math.inf)
FIRST, WIDER = 0.1, 10**0.5  # share of the clearance in the first step; of the next in each
STAGES, TRIES = 4, 4  # steps to the whole clearance where none fails; steps that may fail
PARTLY = 1e-3  # tolerance with part of the play
IDEAL = "reaction:"
TIGHT, SHOWN = 1e-10, 20  # tolerance of the runs; turns of them
DRAWN, SAMPLES = 2, 2048  # turns that are drawn; samples of each
EXTREMES = ("largest", "smallest")
COURSE = {"name": "long_name", "units": "units"}
FORCE = "normal_force:"
SHORTER, LONGER, PASSES = 0.25, 2.0, 40
SMALLEST = 1e-6  # half width of a box, in the variables' ranges

INVALID = STATUS.index("not_converged")

_Limit = Annotated[float, Field(strict=True)]  # or infinite
_Pair = Annotated[tuple[_Limit, _Limit], accepts("a lowest value or -inf, and a highest value or inf,")]
Limits = Annotated[dict[str, _Pair], accepts("a table of quantities, each with its limits,")]
_WORDS = "a table of parameters, each with its lowest and highest value,"
Bounds = Annotated[dict[str, Ends], accepts(_WORDS)]


def answer(result: xr.Dataset) -> str:
    """The best design, its values before and after, and doubts about it."""
    end = str(codes.words(result["end"]).item())
    if end == "infeasible":
        return "\n".join([WHY[end] + _play(result), *_missed(result)])
    if int(result["status"]):
        return f"no optimum: {WHY[end] or 'no motion'}"
    lines = ["; ".join([*_before_and_after(result), _changes(result)])]
    doubts = [WHY[end]] if WHY[end] else []
    doubts += _missed(result)[: float(result["missed"]) > result.attrs["tolerance"]]
    followed = [name.partition(":")[0] not in MULTIPLIERS for name in result["quantity"].values]
    if result["confirmed_to"].fillna(1.0).values[followed].max(initial=0.0) > AGREED:
        doubts.append("the motion from the usual start does not settle to the orbit that was optimised")
    if float(result["neighbour_gain"]) > 0:
        gain = plain(float(result["neighbour_gain"]), 3)
        doubts.append(
            f"a design that differs by {plain(100 * result.attrs['neighbourhood'], 3)} % is better by {gain}"
        )
    return "\n".join([*lines, "; ".join(doubts)] if doubts else lines)


def _changes(result: xr.Dataset) -> str:
    columns = ("parameter_name", "first_value", "optimum", "parameter_units")
    rows = zip(*(result[name].values for name in columns), strict=True)
    texts = [
        f"{name} from {measure(float(first), units)} to {measure(float(last), units)}"
        for name, first, last, units in rows
    ]
    return ", ".join(texts[:LISTED]) + (" and others" if len(texts) > LISTED else "")


def _before_and_after(result: xr.Dataset) -> Iterator[str]:
    for i in range(result.sizes["quantity"]):
        one, unit = result.isel(quantity=i), str(result["quantity_units"].values[i])
        before, after = (measure(float(one[key]), unit) for key in ("before", "value"))
        before = before if np.isfinite(one["before"]) else "unknown"
        yield f"{one['quantity_name'].item()}: {before} before, {after} after"


def _play(result: xr.Dataset) -> str:
    """Up to which share of the clearance there are designs, where it is not all of it."""
    share = float(result["play_kept"])
    return "" if share == 1 else f"; with {plain(100 * share, 3)} % of the clearance there are such designs"


def _missed(result: xr.Dataset) -> list[str]:
    """Constraints that the best design misses, and the bounds that it stands at."""
    missed = []
    for one in (result.isel(quantity=i) for i in range(result.sizes["quantity"])):
        value, low, high = (float(one[name]) for name in ("value", "limit_low", "limit_high"))
        beyond = value > high or low == -math.inf
        units = one["quantity_units"].item()
        limit = f"at most {measure(high, units)}" if beyond else f"at least {measure(low, units)}"
        if not low <= value <= high and (low, high) != INFINITE:
            now = measure(value, units) if np.isfinite(value) else "unknown"
            missed.append(f"{one['quantity_name'].item()} is {now}, and {limit} is required")
    low, high, at = (result[name].values for name in ("low", "high", "optimum"))
    ends = ((at - low <= 1e-6 * (high - low), "lowest"), (high - at <= 1e-6 * (high - low), "highest"))
    names = result["parameter_name"].values
    bound = [f"{names[i]} at its {word} value" for there, word in ends for i in np.flatnonzero(there)]
    return ["; ".join(missed), ", ".join(bound)][: 1 + bool(bound)]


OUTPUTS = Outputs(
    "optimise",
    gradient_dataset.LABELS
    | {"side": Out("side", "side of the optimum", ""), "joint": Out("joint", "joint", "")},
    {
        "tried_value": Out(("iteration", "parameter"), f"value tried, {IN_PARAMETER}"),
        "tried_quantity": Out(("iteration", "quantity"), f"value, {IN_QUANTITY}"),
        "objective": Out("iteration", "what is made least or largest"),
        "tried_missed": Out("iteration", "relative amount by which the worst constraint is missed"),
        "tried_share": Out("iteration", "share of the clearance in this trial"),
        "tried_status": Out("iteration", "how the trial ended", flags=STATUS),
        "tried_derivative_status": Out("iteration", "whether there is a derivative", flags=VERDICTS),
        "first_value": Out("parameter", f"value at first, {IN_PARAMETER}"),
        "optimum": Out("parameter", f"value at the optimum, {IN_PARAMETER}"),
        "low": Out("parameter", f"lowest value, {IN_PARAMETER}"),
        "high": Out("parameter", f"highest value, {IN_PARAMETER}"),
        "neighbour_objective": Out(("parameter", "side"), "objective beside the optimum"),
        "neighbour_allowed": Out(("parameter", "side"), "whether the constraints are met there"),
        "neighbour_gain": Out((), "by how much the best allowed neighbour is better"),
        "value": Out("quantity", f"at the optimum, {IN_QUANTITY}"),
        "before": Out("quantity", f"of the motion at first, {IN_QUANTITY}"),
        "after": Out("quantity", f"of the motion at the optimum, followed from its start, {IN_QUANTITY}"),
        "confirmed_to": Out("quantity", "relative difference of value and after"),
        "force_before": Out("joint", "largest force before, of contacts the normal force", "N"),
        "force_after": Out("joint", "largest force after, of contacts the normal force", "N"),
        "course_before": Out("time_before", "{name}", "{units}", "at first"),
        "time_before": Out("time_before", "time", "s"),
        "course_after": Out("time_after", "{name}", "{units}", "at the optimum"),
        "time_after": Out("time_after", "time", "s"),
        "end": Out((), "how the search ended", flags=ENDS),
        "missed": Out((), "relative amount by which the worst constraint is missed"),
        "play_kept": Out((), "share of the clearance up to which designs were found to meet the constraints"),
        "limit_low": Out("quantity", f"lowest accepted value, {IN_QUANTITY}"),
        "limit_high": Out("quantity", f"highest accepted value, {IN_QUANTITY}"),
    }
    | OUTCOME,
    answer,
)


def bounds_fit(mechanism: Mechanism | TestSystem, by: Bounds, ideal: bool) -> Iterator[Problem]:
    """Yield the problems of variables and their bounds."""
    if not by:
        yield Problem("by", by, f"{_WORDS} is accepted")
    each = ((key, p) for key in by for p in selection.parameters_fit(mechanism, (key,), ()))
    unknown = (replace(problem, key=f"by.{key}") for key, problem in each)
    yield from (wrong := [*unknown, *repeated(by, "by")])
    for key, (low, high) in by.items() if not wrong else ():
        value = Parameter(mechanism, key).value
        if not low < high:
            yield Problem(f"by.{key}", [low, high], "a lowest value below the highest is accepted")
        elif not low <= value <= high:
            yield Problem(
                f"by.{key}", [low, high], f"bounds that hold the present value, {value:g}, are accepted"
            )
        elif ideal and any(part.rpartition(".")[2] == "clearance" for part in parts_of(key)):
            yield Problem(
                "by", key, "no clearance is accepted with ideal = true, which begins without clearance"
            )
        else:
            found = problems_of(axes, mechanism, {key: [low, high]}, "by")
            yield from (replace(each, key=f"by.{key}") for each in found)


def aim_fits(
    mechanism: Mechanism | TestSystem,
    least: str | None,
    most: str | None,
    keep: str | None,
    margin: float,
    subject: Any,
    orbit: bool,
) -> Iterator[Problem]:
    """Yield the problems of the aim and of constraints."""
    if least and most:
        yield Problem("most", most, "one of least and most is accepted")
    if not (least or most or keep or subject):
        yield Problem("least", NOTHING, 'a quantity, keep = "contact" or constraints in subject are accepted')
    named = tuple(name for name in (least, most, *(subject or ())) if name)
    yield from (
        replace(each, key="subject" if each.given in (subject or ()) else "least" if least else "most")
        for each in selection.quantities_fit(mechanism, named, orbit)
    )
    for name, (low, high) in (subject or {}).items():
        if not low < high:
            yield Problem(f"subject.{name}", [low, high], "a lowest value below the highest is accepted")
    if keep and not contacts(mechanism):
        yield Problem(
            "keep", keep, "accepted only of a mechanism whose joints have clearance and no rigid faces"
        )
    if margin and not keep:
        yield Problem("margin", margin, 'accepted only beside keep = "contact"')


def ideal_fits(mechanism: Mechanism | TestSystem, by: Bounds, ideal: bool, orbit: bool) -> Iterator[Problem]:
    """Yield the problems of beginning without play, and of periodic orbits."""
    if ideal and (isinstance(mechanism, TestSystem) or not mechanism.clearance_joints):
        yield Problem("ideal", ideal, "accepted only of a mechanism whose joints have clearance")
    elif ideal and any(joint.prismatic for joint in mechanism.clearance_joints):
        yield Problem("ideal", ideal, "accepted only where no slider has clearance")
    if orbit and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("orbit", orbit, "false is accepted for a system that nothing forces")
    elif orbit:
        yield from turns_alike(mechanism)
        yield from alike_beside(mechanism, "by", by)


def contacts(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the contacts whose force can be kept above a margin."""
    if isinstance(mechanism, TestSystem):
        return ()
    usual = selection.usual_quantities(mechanism)
    return tuple(name.removeprefix("largest:") for name in usual if name.startswith(f"largest:{FORCE}"))


@analysis(
    bounds_fit,
    aim_fits,
    ideal_fits,
    settling_fits,
    "model",
    usual={"rtol": 1e-10},
    outputs=OUTPUTS,
    model=started,
)
def optimise(
    mechanism: Moving,
    *,
    by: Bounds,
    least: Quantity | None = None,
    most: Quantity | None = None,
    keep: Literal["contact"] | None = None,
    margin: Annotated[Number, unit("margin", "N")] = 0.0,
    subject: Limits | None = None,
    ideal: Flag = False,
    turns: Natural = 1,
    orbit: Flag = True,
    tolerance: Small = 1e-8,
    max_iterations: Natural = 100,
    neighbourhood: Annotated[Small, Field(ge=1e-6)] = 0.01,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Find the numbers of a mechanism for which a quantity of its motion is least, within constraints.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        As it is first.
    by : dict of str to (float, float)
        Parameters that are varied, by name or key path as in `[vary]`, each with its lowest and highest
        value.
    least : str, optional
        Quantity of `gradient` that is made as small as possible, such as ``largest:normal_force:B``. Without
        it and `most`: the smallest change of the parameters, in their ranges, that keeps the constraints.
    most : str, optional
        Quantity of `gradient` that is made as large as possible; instead of `least`.
    keep : {'contact'}, optional
        With ``contact``, every contact force has to stay at `margin` or above throughout.
    margin : float
        Least contact force that `keep` allows, N.
    subject : dict of str to (float, float), optional
        Further constraints: quantities of `gradient`, each with its lowest and highest value; ``-inf`` or
        ``inf`` where it has none.
    ideal : bool
        Whether the search begins with ideal joints and their forces, and approaches the clearance in stages.
    turns, orbit
        As in `gradient`.
    tolerance : float
        Tolerance of the objective and of each limit, relative to their sizes: of the quantity there, of a
        limit its own where that is larger.
    max_iterations : int
        Number of designs after which no new pass of the search begins, in each stage.
    neighbourhood : float
        Fraction of its value by which each parameter of the optimum is changed to either side, to see how
        flat the optimum is.
    progress : callable, optional
        Called with the fraction done, of at most `max_iterations` designs in each stage.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    limits = {name: tuple(pair) for name, pair in (subject or {}).items()}
    for contact in contacts(mechanism) if keep else ():
        low, high = limits.get(f"smallest:{contact}", INFINITE)
        limits[f"smallest:{contact}"] = (max(low, margin), high)
    names = tuple(dict.fromkeys(([least or most] if least or most else []) + list(limits)))
    progress = motion["progress"]
    settings = {"turns": turns, "orbit": orbit} | {key: motion[key] for key in motion if key != "progress"}
    most_designs = max_iterations * (STAGES if ideal else 1)

    def tell(designs: int) -> None:
        if progress is not None:
            progress(designs / most_designs)

    trials = Trials(mechanism, names, by, settings, 1.0, [], tell)
    first = np.array([float(Parameter(mechanism, key).value) for key in by])
    x = (first - trials.low) / trials.width
    bounds = np.array([limits.get(name, INFINITE) for name in names])
    aim = Aim(0 if least or most else None, -1.0 if most else 1.0, bounds, x, np.ones(0))
    if ideal:
        end, found, kept = opened(trials, aim, x, tolerance, max_iterations)
    else:
        kept, (end, found) = 1.0, descended(trials, aim.sized(trials.at(x)), x, tolerance, max_iterations)
    aim = aim.sized(found, trials.made[0])
    if end == "converged" and aim.missed(found) > tolerance:  # what the first design was far larger than
        end, found = descended(trials, aim, found.x, tolerance, max_iterations)
    table = _designs_tried(trials, aim) | {"low": trials.low, "high": trials.low + trials.width}
    table |= {"first_value": first, "optimum": trials.low + trials.width * found.x}
    table |= neighbour_values(trials, aim, found, neighbourhood, tolerance)
    forces, designs = selection.largest_forces(mechanism), (mechanism, trials.design(found.x))
    runs = [followed(design, (*names, *forces.values()), by, settings) for design in designs]
    table |= _motions(runs, found) | ({"joint": np.array([*forces])} if forces else {})
    table |= {"end": ENDS.index(end), "missed": aim.missed(found), "play_kept": kept}
    table |= {"limit_low": aim.limits[:, 0], "limit_high": aim.limits[:, 1]} | ended(found.status, began)
    table |= gradient_dataset.labels([selection.quantity(name) for name in names], tuple(by), mechanism)
    table["side"] = np.array(["below", "above"])
    course = next((course for _, course in runs if course is not None), None)
    of = None if course is None else {key: course.attrs[word] for key, word in COURSE.items()}
    goal = f"least {least}" if least else f"largest {most}" if most else "smallest change of the parameters"
    return OUTPUTS.dataset(table, of=of, aim=goal, tolerance=tolerance, neighbourhood=neighbourhood)


def _designs_tried(trials: Trials, aim: Aim) -> dict[str, Any]:
    """The designs tried, in order."""
    made = trials.made
    whole = [each if each.share == 1 and not each.status else None for each in made]  # with all the play
    return {
        "tried_value": np.asarray([trials.low + trials.width * each.x for each in made]),
        "tried_quantity": np.array([each.values for each in made]),
        "objective": np.asarray([np.nan if each is None else aim.shown(each) for each in whole]),
        "tried_missed": np.asarray([np.nan if each is None else aim.missed(each) for each in whole]),
        "tried_share": np.asarray([each.share for each in made]),
        "tried_status": [each.status for each in made],
        "tried_derivative_status": [each.verdict for each in made],
    }


def _motions(runs: list, found: Trial) -> dict[str, Any]:
    """Values of the motions before and after, their forces, and their courses."""
    (before, first), (after, last) = runs
    count = len(found.values)
    (before, after), forces = (before[:count], after[:count]), (before[count:], after[count:])
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(after - found.values) / np.where(found.values != 0, np.abs(found.values), 1.0)
    table = {"value": found.values, "before": before, "after": after, "confirmed_to": apart}
    for name, course, force in (("before", first, forces[0]), ("after", last, forces[1])):
        if force.size:
            table[f"force_{name}"] = force
        if course is not None:
            table |= {f"course_{name}": course.values, f"time_{name}": course["time"].values}
    return table


def opened(trials: Trials, aim: Aim, x: np.ndarray, tolerance: float, most: int) -> tuple[str, Trial, float]:
    """Descend as play opens: the last end, the best trial, and the share of play that keeps the constraints.

    Parameters
    ----------
    trials : Trials
        With the whole clearance.
    aim : Aim
        Without units.
    x : ndarray
        Scaled variables of the first design.
    tolerance, most
        As `descended` takes them.
    """
    kept, share, wider, fails = -1.0, 0.0, WIDER, 0
    while fails < TRIES:
        part = trials if share == 1 else _with_share(trials, share)
        slack = tolerance if share in (0, 1) else max(tolerance, PARTLY)
        scaled = aim.sized(part.at(x))
        end, found = descended(part, scaled, x, slack, most)
        if not found.status and scaled.missed(found) <= slack:
            x, kept = found.x, share
            if share == 1:
                return end, found, kept
            share = min(1.0, share * wider or FIRST)
        elif share == 0:
            break
        else:
            fails, wider = fails + 1, wider**0.5
            share = kept * wider or share / WIDER
    return "infeasible", trials.at(x), max(kept, 0.0)


def _with_share(trials: Trials, share: float) -> Trials:
    """Trials of the mechanism with part of its clearances; without any, of its ideal joints' forces."""
    joints = trials.mechanism.clearance_joints
    clearance = {f"joints.{joint.name}.clearance": share * joint.clearance for joint in joints}
    names, settings = trials.quantities, trials.settings
    if not share:
        names = tuple(name.replace(f":{FORCE}", f":{IDEAL}") for name in names)
    if not isinstance(settings["initial"], dict):  # a state is one of the mechanism with all its play
        settings = {**settings, "initial": None}
    mechanism = trials.mechanism.varied(clearance)
    return replace(
        trials, mechanism=mechanism, quantities=names, settings=settings, share=share, known={}, near=None
    )


def neighbour_values(
    trials: Trials, aim: Aim, found: Trial, share: float, tolerance: float
) -> dict[str, Any]:
    """The optimum's neighbours: each variable changed by a share of its value, within its bounds."""
    value, allowed = np.full((len(trials.by), 2), np.nan), np.zeros((len(trials.by), 2), dtype=bool)
    at = trials.low + trials.width * found.x
    for i in range(len(at)) if not found.status else ():
        for side, sign in enumerate((-1, 1)):
            x = found.x.copy()
            x[i] = np.clip(x[i] + sign * share * (abs(at[i]) or trials.width[i]) / trials.width[i], 0, 1)
            other = trials.tried(x) if x[i] != found.x[i] else found
            if other is not found and not other.status:
                value[i, side] = aim.shown(other)
                allowed[i, side] = aim.missed(other) <= max(tolerance, aim.missed(found))
    best = aim.shown(found) if not found.status else np.nan
    gain = np.where(allowed, aim.sign * (best - value), np.nan)
    gain = np.max(gain, initial=0.0, where=np.isfinite(gain))
    return {"neighbour_objective": value, "neighbour_allowed": allowed, "neighbour_gain": gain}


def followed(
    mechanism: Mechanism | TestSystem,
    names: Sequence[str],
    by: Mapping[str, Any],
    settings: Mapping[str, Any],
) -> tuple[np.ndarray, xr.Dataset | None]:
    """Quantities of a motion from its start, after the transient, at rtol 1e-10; its course, if any.

    Extreme values are those of 20 turns, all else is of as many turns as asked for. Multipliers are NaN: an
    orbit alone has them.
    """
    run = {"initial": settings["initial"], "max_steps": settings["max_steps"], "rtol": TIGHT}
    values, words = np.full(len(names), np.nan), [name.partition(":")[0] for name in names]
    with warnings.catch_warnings(action="ignore", category=ModelWarning):
        state = _settled(mechanism, settings["transient"], run) if settings["orbit"] else run["initial"]
        if settings["orbit"] and state is None:
            return values, None
        for extreme in (True, False):
            places = [
                i for i, word in enumerate(words) if (word in EXTREMES) == extreme and word not in MULTIPLIERS
            ]
            turns = SHOWN if extreme and settings["orbit"] else settings["turns"]
            if places:
                request = {"of": [names[i] for i in places], "by": list(by), "turns": turns}
                values[places] = gradient(mechanism, **request, **run | {"initial": state})["value"].values
        return values, _course(mechanism, names, settings, run)


def _settled(mechanism: Mechanism | TestSystem, transient: int, run: Mapping[str, Any]) -> list[float] | None:
    """The state after the transient, None where the motion does not get there."""
    cut = start_section(mechanism, run["initial"], 1, run["rtol"], run["max_steps"])
    image = cut.image(cut.model.state, False, max(transient, 1))
    return None if image.status else [float(each) for each in image.state]


def _course(
    mechanism: Mechanism | TestSystem,
    names: Sequence[str],
    settings: Mapping[str, Any],
    run: Mapping[str, Any],
) -> xr.Dataset | None:
    """The first recorded quantity of the named ones, over the turns; of a motion that has settled, over few.

    They are those with its largest value in as many turns as extreme values are of.
    """
    keys = [name.partition(":")[2] for name in names]
    linkage = isinstance(mechanism, Mechanism)
    known = [key for key in keys if key.partition(":")[0] in (WORDS if linkage else ("state",))]
    whole = linkage and run["initial"] is not None and not isinstance(run["initial"], dict)
    if not known or whole:  # of a state written out there are no time histories
        return None
    word, _, label = known[0].partition(":")
    word = word if linkage else "state_value"
    turns, settled = settings["turns"], settings["orbit"]
    given = {"turns": max(turns, SHOWN), "transient": settings["transient"]} if settled else {"turns": turns}
    found = simulate(mechanism, **given, samples_per_turn=SAMPLES, record=[word], **run)[word]
    dims = [dim for dim in found.dims if dim != "time"]
    found = found.sel({dims[0]: label}) if dims else found
    if not settled:
        return found
    shown, peak = max(turns, DRAWN) * SAMPLES, int(np.abs(found.values).argmax())
    begin = max(min(peak // SAMPLES * SAMPLES, len(found) - 1 - shown), 0)
    return found[begin : begin + shown + 1]


def descended(trials: Trials, aim: Aim, x: np.ndarray, tolerance: float, most: int) -> tuple[str, Trial]:
    """Descend from x: the reason of the end (a word of `ENDS`), and the best trial."""
    made, reach = len(trials.made), 1.0
    start = trials.at(x)
    if start.status:
        return "no_motion", start
    for _ in range(PASSES):
        here = best([each for each in trials.made[made:] if not each.status] or [start], aim, tolerance)
        left = most - (len(trials.made) - made)
        if left <= 0:
            return "iterations", here
        done, stopped = _pass(trials, aim, here.x, reach, tolerance, left)
        now = best([start, *trials.made[made:]], aim, tolerance)
        if stopped:
            reach *= SHORTER
            if reach < SMALLEST:
                break
        elif reach < 1.0 and np.max(np.abs(now.x - here.x)) > 0.999 * reach:
            reach = min(1.0, LONGER * reach)
        elif aim.missed(now) > tolerance:
            return ("infeasible" if len(trials.made) - made < most else "iterations"), now
        elif np.max(np.abs(now.x - here.x)) > SMALLEST and aim.value(here) - aim.value(now) > tolerance:
            continue  # once more from there, with no memory of how it bent before
        else:
            return ("converged" if done else "no_descent"), now
    return "no_descent", best([start, *trials.made[made:]], aim, tolerance)


def _pass(
    trials: Trials, aim: Aim, x: np.ndarray, reach: float, tolerance: float, most: int
) -> tuple[bool, bool]:
    """One run of SLSQP in a box: whether it converged, and whether a design had no motion."""

    def at(point: np.ndarray) -> Trial:
        trial = trials.at(np.clip(point, 0.0, 1.0))
        if trial.status:
            raise NoMotion(trial.status)
        return trial

    limits = {"type": "ineq", "fun": lambda p: aim.margins(at(p)), "jac": lambda p: aim.margin_slopes(at(p))}
    box = list(zip(np.maximum(x - reach, 0.0), np.minimum(x + reach, 1.0), strict=True))
    try:
        # of points that it clips to the box
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
            found = minimize(
                lambda p: aim.value(at(p)),
                x,
                jac=lambda p: aim.slope(at(p)),
                bounds=box,
                constraints=[limits] if np.isfinite(aim.limits).any() else [],
                method="SLSQP",
                options={"ftol": 1e-2 * tolerance, "maxiter": most},
            )
    except NoMotion:
        return False, True
    return bool(found.success), False


@dataclass(frozen=True)
class Trial:
    """Evaluation of a design: its quantities and their derivatives in the scaled variables.

    `share` of the clearance, 0 with ideal joints. `status`: index into `STATUS`; all but 0: no motion to
    differentiate. `verdict`: index into `VERDICTS`. `orbit`, `moves`: where the periodic orbit starts, and
    the derivatives of that in the scaled variables.
    """

    x: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    status: int
    verdict: int
    share: float
    orbit: np.ndarray | None = None
    moves: np.ndarray | None = None


class NoMotion(ArithmeticError):
    """A design whose motion has no derivative: the step that led there was too long."""


@dataclass
class Trials:
    """Designs of a mechanism, each tried once.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        As it is first.
    quantities : tuple of str
        What is looked at.
    by : mapping of str to (float, float)
        Bounds of each variable.
    settings : mapping of str to object
        Keywords of `gradient`.
    share : float
        Of the clearance in these trials.
    made : list of Trial
        All so far, those with other clearance too.
    tell : callable
        Called with their number whenever there is one more.
    """

    mechanism: Mechanism | TestSystem
    quantities: tuple[str, ...]
    by: Mapping[str, tuple[float, float]]
    settings: Mapping[str, Any]
    share: float
    made: list[Trial]
    tell: Callable[[int], None]
    known: dict[bytes, Trial] = field(default_factory=dict)
    near: Trial | None = None

    @property
    def low(self) -> np.ndarray:
        """Lower bounds."""
        return np.array([low for low, _ in self.by.values()])

    @property
    def width(self) -> np.ndarray:
        """Upper less lower bounds."""
        return np.array([high - low for low, high in self.by.values()])

    def design(self, x: np.ndarray) -> Mechanism | TestSystem:
        """The mechanism at scaled variables."""
        return self.mechanism.varied(dict(zip(self.by, map(float, self.low + self.width * x), strict=True)))

    def at(self, x: np.ndarray) -> Trial:
        """Evaluate a design, once, and keep it in the list of trials."""
        key = np.asarray(x, dtype=float).tobytes()
        if key not in self.known:
            self.known[key] = self.tried(np.array(x, dtype=float))
            self.made.append(self.known[key])
            self.tell(len(self.made))
        return self.known[key]

    def tried(self, x: np.ndarray) -> Trial:
        """Evaluate a design."""
        tick()
        n, m = len(self.quantities), len(x)
        try:
            # the verdict is kept with the trial
            with warnings.catch_warnings(action="ignore", category=ModelWarning):
                given = {"of": self.quantities, "by": tuple(self.by), "progress": None}
                found = gradient(self.design(x), **given, **self.settings | self._start(x))
        except InputError:  # numbers that make no mechanism together, as links that do not reach
            nothing = np.full(n, np.nan), np.full((n, m), np.nan)
            return Trial(x, *nothing, INVALID, len(VERDICTS) - 1, self.share)
        slopes = found["derivative"].values * self.width
        status = int(found["status"])
        if not status and not (np.isfinite(slopes).all() and np.isfinite(found["value"].values).all()):
            status = INVALID
        trial = Trial(x, found["value"].values, slopes, status, int(found["derivative_status"]), self.share)
        if not status and "orbit_state" in found:
            moves = found["orbit_state_derivative"].values * self.width
            self.near = trial = replace(trial, orbit=found["orbit_state"].values, moves=moves)
        return trial

    def _start(self, x: np.ndarray) -> dict[str, Any]:
        """Keywords by which the orbit at a design is sought near the one found last."""
        if self.near is None:
            return {}
        state = self.near.orbit + self.near.moves @ (x - self.near.x)
        return {"initial": state.tolist(), "transient": 0}


@dataclass(frozen=True)
class Aim:
    """Aim and constraints on values q: f = q_least is to be least, with low <= q <= high.

    Parameters
    ----------
    least : int or None
        Index of the quantity that is made least; None: the change of the variables is.
    sign : float
        -1: it is made largest instead.
    limits : ndarray
        Low and high of each quantity, shape (quantities, 2); infinite where there is none.
    first : ndarray
        Scaled variables of the mechanism as it is.
    units : ndarray
        Size of low and of high and of each quantity, shape (quantities, 3).
    """

    least: int | None
    sign: float
    limits: np.ndarray
    first: np.ndarray
    units: np.ndarray

    def sized(self, trial: Trial, first: Trial | None = None) -> Aim:
        """The aim with its quantities' size at a design as their units, of a limit its own where larger.

        Beside a limit of 0 it is their size at the first design: at the limit there is none.
        """
        ends = np.where(np.isfinite(self.limits), np.abs(self.limits), 0.0)
        size, usual = (np.nan_to_num(np.abs(each.values))[:, None] for each in (trial, first or trial))
        units = np.hstack([np.maximum(np.where(ends > 0, size, usual), ends), size])
        return replace(self, units=np.where(units > 0, units, 1.0))

    def value(self, trial: Trial) -> float:
        """The objective, in units of its quantity."""
        if self.least is None:
            return float(np.sum((trial.x - self.first) ** 2))
        return float(self.sign * trial.values[self.least] / self.units[self.least, 2])

    def shown(self, trial: Trial) -> float:
        """Value of the aim, in its own units."""
        return self.value(trial) if self.least is None else float(trial.values[self.least])

    def slope(self, trial: Trial) -> np.ndarray:
        """Derivatives of the objective."""
        if self.least is None:
            return 2 * (trial.x - self.first)
        return self.sign * trial.slopes[self.least] / self.units[self.least, 2]

    def margins(self, trial: Trial) -> np.ndarray:
        """Margin of each constraint, negative where it is not kept, in units of its own."""
        rows, sides = np.nonzero(np.isfinite(self.limits))
        beyond = trial.values[rows] - self.limits[rows, sides]
        return np.where(sides == 0, beyond, -beyond) / self.units[rows, sides]

    def margin_slopes(self, trial: Trial) -> np.ndarray:
        """Derivatives of the margins."""
        rows, sides = np.nonzero(np.isfinite(self.limits))
        return trial.slopes[rows] * (np.where(sides == 0, 1.0, -1.0) / self.units[rows, sides])[:, None]

    def missed(self, trial: Trial) -> float:
        """Amount by which the worst constraint is not kept; infinite where there is no motion."""
        return float("inf") if trial.status else float(np.max(-self.margins(trial), initial=0.0))

    def better(self, one: Trial, other: Trial, slack: float) -> bool:
        """Whether a trial is better than another: constraints first, then the objective."""
        ours, theirs = self.missed(one), self.missed(other)
        return ours < theirs if max(ours, theirs) > slack else self.value(one) < self.value(other)


def best(trials: list[Trial], aim: Aim, slack: float) -> Trial:
    """The best of some trials."""
    return reduce(lambda found, each: each if aim.better(each, found, slack) else found, trials)
