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
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Unpack

import numpy as np
from pydantic import Field

from jointplay.analysis.coexisting.region import Region
from jointplay.analysis.gradients import gradient_dataset, wanted
from jointplay.analysis.gradients.gradient import gradient, start_section
from jointplay.analysis.gradients.multipliers import MULTIPLIERS
from jointplay.analysis.keywords import Moving, Quantity, Settling, Small, analysis
from jointplay.analysis.labels import coded, number, outcome
from jointplay.analysis.optima.asked import FORCE, aim_fits, bounds_fit, contacts, ideal_fits
from jointplay.analysis.optima.descent import descended
from jointplay.analysis.optima.trials import Aim, Trial, Trials
from jointplay.analysis.orbits.orbit_request import start_fits
from jointplay.analysis.quantities import WORDS
from jointplay.analysis.simulate import simulate
from jointplay.display.errors import ModelWarning
from jointplay.solver.mechanism.base import Flag, Natural, Number, unit
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import Mechanism, TestSystem

if TYPE_CHECKING:
    import xarray as xr

ENDS = ("converged", "no_descent", "infeasible", "iterations", "no_motion")
INFINITE = (-math.inf, math.inf)
FIRST, WIDER = 0.1, 10**0.5  # share of the clearance in the first step; of the next in each
STAGES, TRIES = 4, 4  # steps to the whole clearance where none fails; steps that may fail
PARTLY = 1e-3  # tolerance with part of the play
IDEAL = "reaction:"
TIGHT, SHOWN = 1e-10, 20  # tolerance of the runs; turns of them
DRAWN, SAMPLES = 2, 720  # turns that are drawn; samples of each
EXTREMES = ("largest", "smallest")


@analysis(bounds_fit, aim_fits, ideal_fits, start_fits, usual={"rtol": 1e-10})
def optimise(
    mechanism: Moving,
    *,
    by: Region,
    least: Quantity | None = None,
    most: Quantity | None = None,
    keep: Literal["contact"] | None = None,
    margin: Annotated[Number, unit("margin", "N")] = 0.0,
    subject: Region | None = None,
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
        What is varied, each with its lowest and highest value: names and key paths as in `[vary]`.
    least, most : str, optional
        The quantity of `gradient` that is made least, or largest, such as ``largest:normal_force:B``. Left
        out: the smallest change of the parameters, in their ranges, that keeps the constraints.
    keep : {'contact'}, optional
        Every contact force stays at `margin` or above all the while.
    margin : float
        N.
    subject : dict of str to (float, float), optional
        Lowest and highest value of other quantities.
    ideal : bool
        True: first without play, with the forces of the ideal joints, then with ever more of it.
    turns, orbit
        As in `gradient`.
    tolerance : float
        Of the objective and the constraints, each relative to its size.
    max_iterations : int
        Designs after which no new pass of the search begins, in each stage.
    neighbourhood : float
        By what share of its value each parameter of the optimum is changed, to both sides.
    progress : callable, optional
        Called with the fraction done, of at most `max_iterations` designs in each stage.

    Returns
    -------
    xarray.Dataset
        Over ``iteration`` and ``parameter``: the designs tried; ``optimum`` and ``first_value``; over
        ``quantity``: values at the optimum, and of the motions before and after, followed at rtol 1e-10;
        ``neighbour_objective``; ``end``, how the search ended; ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    import xarray as xr

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
    sign = -1.0 if most else 1.0
    aim = Aim(
        0 if least or most else None, sign, np.array([limits.get(n, INFINITE) for n in names]), x, np.ones(0)
    )
    if ideal:
        end, found, kept = opened(trials, aim, x, tolerance, max_iterations)
    else:
        end, found = descended(trials, aim.sized(trials.at(x)), x, tolerance, max_iterations)
        kept = 1.0
    aim = aim.sized(found)
    table = _way(trials, aim) | _optimum(trials, found, first)
    table |= beside(trials, aim, found, neighbourhood, tolerance)
    runs = [followed(design, names, by, settings) for design in (mechanism, trials.design(found.x))]
    table |= _motions(runs, found)
    table["end"] = coded((), ENDS.index(end), "how the search ended", ENDS)
    table["missed"] = number(
        (), aim.missed(found), "1", "by how much the worst constraint is not kept, relative"
    )
    told = "share of the clearance up to which designs that keep the constraints were found"
    table["play_kept"] = number((), kept, "1", told)
    for name, word, limit in zip(("low", "high"), ("lowest", "highest"), aim.limits.T, strict=True):
        told = f"{word} accepted value, in the units of quantity_units"
        table[f"limit_{name}"] = number("quantity", limit, "1", told)
    labels = gradient_dataset.labels([wanted.quantity(name) for name in names], tuple(by), mechanism)
    labels["side"] = "side", np.array(["below", "above"]), {"long_name": "side of the optimum"}
    attributes = {"Conventions": "CF-1.11", "kind": "optimise", "aim": _told(least, most)}
    attributes |= {"tolerance": tolerance, "neighbourhood": neighbourhood}
    return xr.Dataset(table | outcome(found.status, began), labels, attributes)


def _way(trials: Trials, aim: Aim) -> dict[str, Any]:
    """The designs tried, in order."""
    made = trials.made
    with_play = [each.share == 1 and not each.status for each in made]
    objective = [aim.shown(each) if there else np.nan for each, there in zip(made, with_play, strict=True)]
    each_missed = [aim.missed(each) if there else np.nan for each, there in zip(made, with_play, strict=True)]
    variables = [trials.low + trials.width * each.x for each in made]
    units, steps = "in the units of", ("iteration",)
    return {
        "tried_value": number((*steps, "parameter"), variables, "1", f"value tried, {units} parameter_units"),
        "tried_quantity": number(
            (*steps, "quantity"),
            np.array([each.values for each in made]),
            "1",
            f"value, {units} quantity_units",
        ),
        "objective": number(steps, objective, "1", "what is made least or largest"),
        "tried_missed": number(
            steps, each_missed, "1", "by how much the worst constraint is not kept, relative"
        ),
        "tried_share": number(
            steps, [each.share for each in made], "1", "share of the clearance in this trial"
        ),
        "tried_status": coded(steps, [each.status for each in made], "how the trial ended"),
        "tried_derivative_status": coded(
            steps, [each.verdict for each in made], "whether there is a derivative", gradient_dataset.VERDICTS
        ),
    }


def _optimum(trials: Trials, found: Trial, first: np.ndarray) -> dict[str, Any]:
    units = "in the units of parameter_units"
    rows = {"first_value": (first, "value at first")}
    rows |= {"optimum": (trials.low + trials.width * found.x, "value at the optimum")}
    rows |= {"low": (trials.low, "lowest value"), "high": (trials.low + trials.width, "highest value")}
    return {name: number("parameter", value, "1", f"{text}, {units}") for name, (value, text) in rows.items()}


def _motions(runs: list, found: Trial) -> dict[str, Any]:
    """Values of the motions before and after, and their courses."""
    units = "in the units of quantity_units"
    (before, first), (after, last) = runs
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(after - found.values) / np.where(found.values != 0, np.abs(found.values), 1.0)
    rows = {"value": (found.values, "at the optimum"), "before": (before, "of the motion at first")}
    rows |= {"after": (after, "of the motion at the optimum, followed from its start")}
    table = {name: number("quantity", value, "1", f"{text}, {units}") for name, (value, text) in rows.items()}
    table["confirmed_to"] = number("quantity", apart, "1", "relative difference of value and after")
    for name, course in (("before", first), ("after", last)):
        if course is not None:
            told = {"units": course.attrs["units"], "long_name": course.attrs["long_name"]}
            table[f"course_{name}"] = f"time_{name}", course.values, told
            table[f"time_{name}"] = number(f"time_{name}", course["time"].values, "s", "time")
    return table


def _told(least: str | None, most: str | None) -> str:
    """The aim in words."""
    if least is None and most is None:
        return "smallest change of the parameters"
    return f"least {least}" if least else f"largest {most}"


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


def beside(trials: Trials, aim: Aim, found: Trial, share: float, tolerance: float) -> dict[str, Any]:
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
    most = np.max(gain, initial=-np.inf, where=np.isfinite(gain)) if np.isfinite(gain).any() else 0.0
    both = ("parameter", "side")
    return {
        "neighbour_objective": number(both, value, "1", "objective beside the optimum"),
        "neighbour_allowed": number(both, allowed, "1", "whether the constraints are kept there"),
        "neighbour_gain": number((), max(most, 0.0), "1", "by how much the best allowed neighbour is better"),
    }


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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        state = _settled(mechanism, settings["transient"], run) if settings["orbit"] else run["initial"]
        if settings["orbit"] and state is None:
            return values, None
        for extreme in (True, False):
            places = [
                i for i, word in enumerate(words) if (word in EXTREMES) == extreme and word not in MULTIPLIERS
            ]
            turns = SHOWN if extreme and settings["orbit"] else settings["turns"]
            if places:
                asked = {"of": [names[i] for i in places], "by": list(by), "turns": turns}
                values[places] = gradient(mechanism, **asked, **run | {"initial": state})["value"].values
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
    """The first recorded quantity of the named ones, over the turns."""
    keys = [name.partition(":")[2] for name in names]
    linkage = isinstance(mechanism, Mechanism)
    known = [key for key in keys if key.partition(":")[0] in (WORDS if linkage else ("state",))]
    whole = linkage and run["initial"] is not None and not isinstance(run["initial"], dict)
    if not known or whole:  # of a state written out there are no time histories
        return None
    word, _, label = known[0].partition(":")
    word = word if linkage else "state_value"
    turns = {"turns": max(settings["turns"], DRAWN), "transient": settings["transient"]}
    turns = turns if settings["orbit"] else {"turns": settings["turns"]}
    found = simulate(mechanism, **turns, samples_per_turn=SAMPLES, record=[word], **run)[word]
    dims = [dim for dim in found.dims if dim != "time"]
    return found.sel({dims[0]: label}) if dims else found
