"""Poincaré sections: the states in which a motion passes a surface, each located on the method itself."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from jointplay.analysis import rates, rules
from jointplay.analysis.evaluate import beyond_the_model, dataset, joint_flags, scalars
from jointplay.analysis.exponents.frame_growth import followed_together
from jointplay.analysis.keywords import Lasting, Moving, Names, analysis
from jointplay.analysis.labels import coded, described
from jointplay.analysis.partial import evaluated
from jointplay.analysis.quantities import EVENTS, recorded
from jointplay.solver.mechanism.base import Flag
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Section, TestSystem
from jointplay.solver.motion.company import beside, in_company
from jointplay.solver.motion.ensemble_runs import ensemble_fits
from jointplay.solver.motion.trajectory import Records, Request, follow
from jointplay.solver.motion.ways import FOLLOWED, WAYS

if TYPE_CHECKING:
    import xarray as xr

ONCE_A_TURN = CrankAngle()


def _started(mechanism: Mechanism | TestSystem, initial: Any, section: Any, record: Any) -> Model:
    return rules.recorded_from(mechanism, initial, section, record)


@beside()
@analysis(rules.length_fits, rules.section_fits, rules.record_fits, ensemble_fits, model=_started)
def poincare(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    section: Section = ONCE_A_TURN,
    *,
    model: Model,
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
        Crank angle (of a forced test system, phase of the forcing), contact, separation, or a plane of a
        recorded quantity.
    transient : float
        Turns that are followed first; they take no memory.
    record : sequence of str, optional
        As in `simulate`.
    ensemble : bool, optional
        Whether to follow the motion as an ensemble does, beside those of other cells of a `[vary]`. If left
        out, there where sixteen or more go side by side and the structure allows it.

    Returns
    -------
    xarray.Dataset
        Quantities over ``turn`` (the section points, counted from 0), their ``time``, ``followed`` (in lanes
        or one by one), and ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    names = recorded(record, mechanism)
    counted = isinstance(section, CrankAngle) and motion["turns"] is not None
    begin, end = rules.span(model, motion)
    before = math.ceil(motion["transient"])
    fields = rules.section_fields(section, model, before if counted else 0)
    if counted:
        fields["stop_after"] = before + math.ceil(motion["turns"])
        end *= rules.SLACK
    limit = rules.steps(motion["max_steps"])
    request = Request(end, motion["rtol"], max_steps=limit, rates=rates.needed(model, names), **fields)
    run = partial(follow, model, request, motion["progress"])
    records = in_company(ensemble, run, followed_together)
    first = -math.inf if counted else begin
    return evaluated(
        records, len(records.sections), "turn", partial(_dataset, model, motion["rtol"], names, first)
    )


def _dataset(
    model: Model, rtol: float, names: tuple[str, ...], begin: float, records: Records, step: int
) -> xr.Dataset:
    """The dataset of the section points from a time on, every so many-th."""
    rows = records.sections[records.sections[:, 2] >= begin][::step]
    points = rates.quantities(model, rtol, records, rows[:, 2:])
    variables = points.variables(names, "turn") | scalars(model, records)
    variables["followed"] = coded((), records.way, FOLLOWED, WAYS)
    variables |= described(
        {
            "time": ("turn", points.time, "s", "time of the section point"),
            "section_joint": ("turn", rows[:, 0].astype(np.int16), "1", "joint of the point; -1: none"),
        }
    )
    variables["section_joint"][2].update(joint_flags(model))
    variables["section_event"] = coded("turn", rows[:, 1], "kind of event", EVENTS)
    coords = described({"turn": ("turn", np.arange(len(rows)), "1", "section point")})
    return dataset(model, variables, coords, "section", **beyond_the_model(points))
