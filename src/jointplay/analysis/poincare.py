"""Poincaré sections: the states in which a motion passes a surface, each located on the method itself."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Unpack

import numpy as np

from jointplay.analysis import evaluate, rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OF_A_MODEL, beyond_the_model, evaluated, joint_flags, run_values
from jointplay.analysis.exponents.frame_growth import followed_together
from jointplay.analysis.keywords import HANDED, Lasting, Moving, Names, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.period import period
from jointplay.analysis.quantities import EVENTS
from jointplay.display.number_text import plain
from jointplay.solver.mechanism.base import Flag
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import ONCE_A_TURN, CrankAngle, Mechanism, Section, TestSystem
from jointplay.solver.motion.eligibility import FOLLOWED, ROUTES, batchable, batched
from jointplay.solver.motion.ensemble_runs import ensemble_fits
from jointplay.solver.motion.trajectory import Records, Request, follow

TOLERANCE = 1e-4  # of a clearance, or of a coordinate's size: spread of section points that count as one
ROUNDING = 1e-12


def answer(dataset: xr.Dataset) -> str:
    """Period of the section points, or that they show none."""
    count, points = dataset.sizes["turn"], _points(dataset)
    if points is None or count < 4:
        return f"{count} section points"
    found = period(points, TOLERANCE)
    if not found:
        why = "it is longer, the motion has not settled, or it is not periodic"
        return f"no period was found in {count} section points: {why}"
    spread = max(float(np.ptp(points[rest::found], axis=0).max()) for rest in range(found))
    near = "rounding" if spread < ROUNDING else plain(spread, 1)
    of = "of the clearance" if "journal_x" in dataset else "of each coordinate's size"
    return f"period {found}: {count} section points, which repeat to {near} {of}"


def _points(dataset: xr.Dataset) -> np.ndarray | None:
    """Section points by coordinates: journals over their clearances, else states or speeds over sizes."""
    if {"clearance", "journal_x", "journal_y"} <= {*dataset.variables}:
        loose = dataset.isel(joint=dataset["clearance"].values > 0)  # an ideal guide has no journal
        return np.hstack([loose[f"journal_{axis}"].values / loose["clearance"].values for axis in "xy"])
    name = next((name for name in ("state_value", "angular_velocity") if name in dataset), None)
    if name is None:
        return None
    values = dataset[name].transpose("turn", ...).values
    return values / np.maximum(np.nanmax(np.abs(values), axis=0, initial=0.0), 1e-300)


OUTPUTS = Outputs(
    "section",
    {"turn": Out("turn", "section point", about="counted from 0")},
    {"QUANTITY": Out("turn", "what `record` asks for", "")}
    | OF_A_MODEL
    | {
        "followed": Out((), FOLLOWED, flags=ROUTES),
        "time": Out("turn", "time of the section point", "s"),
        "section_joint": Out("turn", "joint of the point; -1: none"),
        "section_event": Out("turn", "kind of event", flags=EVENTS),
    },
    answer,
)


def _started(mechanism: Mechanism | TestSystem, initial: Any, section: Any, names: Any = ()) -> Model:
    return rules.recorded_from(mechanism, initial, section, names)


@batchable()
@analysis(
    *(rules.length_fits, rules.section_fits, "names", ensemble_fits),
    model=_started,
    outputs=OUTPUTS,
    left_out=rules.lasting(50, 200),
)
def poincare(  # noqa: D417 (nobody gives it the model and names)
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    model: Model = HANDED,
    names: tuple[str, ...] = HANDED,
    record: Names | None = None,
    ensemble: Flag | None = None,
    **motion: Unpack[Lasting],
) -> xr.Dataset:
    """Cut a motion with a surface.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    section : Section
        Where the motion is cut: at a crank angle (of a forced test system, a phase of the forcing), at
        contacts, at separations, or by a plane of a recorded quantity.
    transient : float
        Number of turns that are followed first and left out; they take no memory.
    record : sequence of str, optional
        As in `simulate`.
    ensemble : bool, optional
        Whether the motion is followed beside those of other cells of a `[vary]`, in an ensemble. If left out,
        wherever sixteen or more go side by side and the structure allows it.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    counted = isinstance(section, CrankAngle) and motion["turns"] is not None
    begin, end = rules.span(model, motion)
    before = math.ceil(motion["transient"])
    fields = rules.section_fields(section, model, before if counted else 0)
    if counted:
        fields["stop_after"] = before + math.ceil(motion["turns"])
        end *= rules.SLACK
    limit = rules.steps(motion["max_steps"])
    request = Request(end, motion["rtol"], max_steps=limit, rates=evaluate.needed(model, names), **fields)
    records = batched(ensemble, partial(follow, model, request, motion["progress"]), followed_together)
    first = -math.inf if counted else begin
    return evaluated(
        records, len(records.sections), "turn", partial(_dataset, model, motion["rtol"], names, first)
    )


def _dataset(
    model: Model, rtol: float, names: tuple[str, ...], begin: float, records: Records, step: int
) -> xr.Dataset:
    """The dataset of the section points from a time on, every so many-th."""
    rows = records.sections[records.sections[:, 2] >= begin][::step]
    points = evaluate.quantities(model, rtol, records, rows[:, 2:])
    values = {"turn": np.arange(len(rows)), "time": points.time, "followed": records.route}
    values |= {"section_joint": rows[:, 0].astype(np.int16), "section_event": rows[:, 1]}
    groups, warning = {"QUANTITY": points.variables(names, "turn")}, beyond_the_model(points)
    found = OUTPUTS.dataset(values | run_values(model, records), model=model, groups=groups, **warning)
    found["section_joint"].attrs |= joint_flags(model)
    return found
