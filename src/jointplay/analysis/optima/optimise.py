"""Optimisation of numbers of a mechanism over exact derivatives of its motion.

    least f(p)  with  low <= q(p) <= high  and  l <= p <= u,

f and q quantities of `gradient` on a motion or on the periodic orbit that it settles to. Chaos has no useful
derivative: `ideal` begins with the mechanism whose joints have no play, whose motion is periodic, and opens
the play by and by (optima.opening). What is found is a local optimum, held against the motion followed
from the usual start at rtol 1e-10, which need not settle to the orbit that was optimised, and against the
designs beside it. Validity: as of `gradient`; where two places share a largest value, f has a kink, at which
the descent may stay: the designs beside say by how much.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from jointplay.analysis.coexisting.region import Region
from jointplay.analysis.gradients import gradient_dataset, wanted
from jointplay.analysis.gradients.gradient import TRANSIENT
from jointplay.analysis.keywords import Moving, Progress, Quantity, Rtol, Small, Start, analysis
from jointplay.analysis.labels import coded, number, outcome
from jointplay.analysis.optima.asked import aim_fits, bounds_fit, contacts, ideal_fits
from jointplay.analysis.optima.confirmed import beside, followed
from jointplay.analysis.optima.descent import descended
from jointplay.analysis.optima.opening import STAGES, opened
from jointplay.analysis.optima.trials import Aim, Trial, Trials
from jointplay.analysis.orbits.orbit_request import start_fits
from jointplay.solver.mechanism.base import Count, Flag, Natural, Number, unit

if TYPE_CHECKING:
    import xarray as xr

ENDS = ("converged", "no_descent", "infeasible", "iterations", "no_motion")
INFINITE = (-math.inf, math.inf)


@analysis(bounds_fit, aim_fits, ideal_fits, start_fits)
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
    transient: Count = TRANSIENT,
    tolerance: Small = 1e-8,
    max_iterations: Natural = 100,
    neighbourhood: Annotated[Small, Field(ge=1e-6)] = 0.01,
    rtol: Rtol = 1e-10,
    initial: Start | None = None,
    max_steps: Natural | None = None,
    progress: Progress = None,
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
    turns, orbit, transient
        As in `gradient`.
    tolerance : float
        Of the objective and the constraints, each relative to its size.
    max_iterations : int
        Designs after which no new pass of the search begins, in each stage.
    neighbourhood : float
        By what share of its value each parameter of the optimum is changed, to both sides.
    rtol, initial, max_steps
        As in `gradient`.
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
    settings = {"turns": turns, "orbit": orbit, "transient": transient, "rtol": rtol}
    settings |= {"initial": initial, "max_steps": max_steps}
    most_designs = max_iterations * (STAGES if ideal else 1)

    def tell(designs: int) -> None:
        if progress is not None:
            progress(designs / most_designs)

    trials = Trials(mechanism, names, by, settings, 1.0, [], tell)
    first = np.array([wanted.value_of(mechanism, key) for key in by])
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
