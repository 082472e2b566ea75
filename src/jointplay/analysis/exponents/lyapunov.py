"""Lyapunov exponents of a motion through its contacts, each with an error bar and an independent check.

Tangents are carried along in the same steps, through every event by its saltation matrix, and made
orthonormal after each step; the mean rates at which they grow are the exponents. Reference: G. Benettin, L.
Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9-20. Error bars, and how far to trust them:
`batch_means`; the check without Jacobians: `growth`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Unpack

import numpy as np
from pydantic import BeforeValidator

from jointplay.analysis import rules
from jointplay.analysis.evaluate import dataset, scalars
from jointplay.analysis.exponents import batch_means, growth, section_exponents
from jointplay.analysis.exponents.frame_growth import (
    USABLE,
    Stretch,
    Stretched,
    followed_together,
    grown,
    of_the_flow,
    of_the_section,
)
from jointplay.analysis.keywords import Lasting, Moving, analysis
from jointplay.analysis.labels import coded, described
from jointplay.display.errors import Problem, refuse
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Flag, Positive, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, TestSystem
from jointplay.solver.motion.company import beside, in_company
from jointplay.solver.motion.ensemble_runs import ensemble_fits
from jointplay.solver.motion.looks import part
from jointplay.solver.motion.trajectory import INTERRUPTED, Request, prepare
from jointplay.solver.motion.ways import FOLLOWED, WAYS

if TYPE_CHECKING:
    import xarray as xr

TRACE = ("lyapunov_trace", "lyapunov_trace_error", "block_time")  # what a run that failed still tells


def number_or_all(given: Any) -> Any:
    """Refuse what is no number of exponents."""
    if given == "all" or (isinstance(given, int) and not isinstance(given, bool) and given >= 1):
        return given
    raise refuse(given, 'a whole number greater than 0, or "all", is accepted')


def exponents_fit(mechanism: Mechanism | TestSystem, exponents: int | str) -> Iterator[Problem]:
    """Yield a problem where more exponents are asked for than there are."""
    if exponents in (1, "all"):
        return
    if exponents > (states := directions(assemble(mechanism))):
        yield Problem("exponents", exponents, f'a whole number from 1 to {states}, or "all", is accepted')


def directions(model: Model) -> int:
    """How many exponents there are: what laws of contact remember is no direction of its own."""
    return len(model.state) - model.memories


def steady(mechanism: Mechanism | TestSystem) -> Iterator[Problem]:
    """Yield a problem where the drive follows a course over time, which the tangents know nothing of."""
    if isinstance(mechanism, Mechanism) and mechanism.drive and mechanism.drive.transient:
        expected = "exponents are given of a motor, a constant speed or a torque: no profile, cycle or servo"
        yield Problem("mechanism.drive.kind", mechanism.drive.kind, expected)


def _twins_fit(mechanism: Mechanism | TestSystem, twin_turns: int) -> Iterator[Problem]:
    if twin_turns and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("twin_turns", twin_turns, "0 is accepted for a system that nothing forces")
    if twin_turns:
        yield from rules.turns_alike(mechanism)


def _ensemble_fits(
    exponents: int | str, error: float | None, saltation: bool, ensemble: bool | None
) -> Iterator[Problem]:
    if ensemble and (exponents, error, saltation) != (1, None, True):
        expected = "true is accepted for one exponent, with saltation and without a wanted error"
        yield Problem("ensemble", ensemble, expected)


@beside(exponents=1, error=None, saltation=True, twin_turns=0)
@analysis(
    rules.length_fits,
    exponents_fit,
    steady,
    _twins_fit,
    ensemble_fits,
    _ensemble_fits,
    deferred=[rules.start_fits],
)
def lyapunov(
    mechanism: Moving,
    *,
    exponents: Annotated[int | str, BeforeValidator(number_or_all)] = 1,
    error: Annotated[Positive, unit("standard error", "1/s")] | None = None,
    twin_turns: Count = 0,
    saltation: Flag = True,
    ensemble: Flag | None = None,
    **motion: Unpack[Lasting],
) -> xr.Dataset:
    """Give the leading Lyapunov exponents of a motion.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    exponents : int or "all"
        How many, the largest first.
    turns, duration : float
        Length after the transient: nominal turns of the crank (or forcing periods), or s. One of them. The
        budget, where `error` is given.
    transient : float
        Turns that motion and tangents are followed first.
    error : float, optional
        Standard error of the largest exponent of the section's map, 1/s, at which the run stops, if the
        batches that it comes from do not follow one another.
    twin_turns : int
        Turns over which the largest exponent is estimated a second time, from the same start, by renormalised
        twin trajectories; 0: not.
    saltation : bool
        False leaves the tangents' jumps at events out, as a comparison: the result is then wrong wherever a
        force jumps.
    ensemble : bool, optional
        Whether to follow the motion as an ensemble does, beside those of other cells of a `[vary]`: one
        exponent, without `error`. If left out, there where sixteen or more go side by side and the structure
        allows it.

    Returns
    -------
    xarray.Dataset
        Of the flow: ``lyapunov_exponent`` and ``lyapunov_standard_error`` (1/s), both also ``…_per_turn``
        where something turns, over ``exponent``, with ``batch_correlation`` and ``effective_blocks``. Of the
        section's map, without the flow's zero: ``section_exponent`` and ``section_standard_error``, likewise,
        over ``multiplier``, with ``section_batch_correlation``. Further ``lyapunov_trace``
        (running means) and ``lyapunov_trace_error`` over ``block`` and ``exponent``, at ``block_time``;
        ``turn_period``; ``followed`` (in lanes or one by one); ``sum_residual`` (1/s; of a whole spectrum),
        ``mean_divergence`` and ``volume_share``: see Notes; ``grazing`` and ``status``. With `twin_turns`:
        ``growth`` per turn, ``growth_standard_error``, ``growth_difference`` from the section map's largest
        exponent in combined standard errors; ``growth_status``. Of a run that failed, only the trace up to
        there; of one that was interrupted and kept (`jointplay run`), the estimates up to there.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.

    Notes
    -----
    Where nothing outside keeps the time, as with a motor, one exponent of the flow is 0, that along the
    motion, and the largest of a periodic motion tells nothing of its stability. Those of the section's map
    are the others: per turn, of a periodic motion, ln|multiplier|.

    The error bar is that of means over 40 batches; it says how much the mean would differ on another stretch
    of the same length, if the batches are long compared to the motion's memory. They are if
    ``batch_correlation`` is within 0.32 of 0; of a periodic motion, means converge as 1/T and the bar
    exaggerates.

    The sum of all exponents is the mean divergence: trace of the Jacobian, and ln|det S| of the jumps.
    ``sum_residual`` is the difference. A direction that shrinks by more than a factor 50 within a step is
    followed to zero, but not at its true rate; there the last exponent of a whole spectrum is what the volume
    leaves for it, and ``volume_share`` is the share of time in which that was so. An exponent is minus
    infinity where sticking loses a dimension. A law of contact that remembers the speed at entry adds a
    state, whose exponent is minus infinity too and is left out; then there is no whole spectrum, no
    ``sum_residual``, and the last of "all" may be too large. ``grazing`` is the smallest approach speed of a
    guard at an event relative to the terms that it is a sum of: near 0, exponents are uncertain.
    """
    model = rules.model_for(mechanism, motion["initial"])
    count = directions(model) if exponents == "all" else int(exponents)
    begin, end = rules.span(model, motion)
    request = Request(end, motion["rtol"], max_steps=rules.steps(motion["max_steps"]))
    share = 0.5 if twin_turns else 1.0
    if twin_turns:
        cut = rules.model_for(mechanism, motion["initial"], CrankAngle())
        prepare(model.structure, "tangents.tangent_flow")
        prepare(cut.structure)  # beside the other, which takes longer
    asked = Stretch(request, count, begin), error, saltation, part(motion["progress"], 0.0, share)
    run = in_company(ensemble, partial(grown, model, *asked), followed_together)
    variables = _variables(run, count)
    if twin_turns and run.status != INTERRUPTED:
        rest = part(motion["progress"], share, 1.0)
        twin = growth.twin(cut, twin_turns, math.ceil(motion["transient"]), motion["max_steps"], rest)
        leading = (variables[f"section_{name}_per_turn"][1][0] for name in ("exponent", "standard_error"))
        variables |= growth.beside(*map(float, leading), twin)
        if twin["status"] == INTERRUPTED:
            variables["status"] = coded((), INTERRUPTED)
    if isinstance(mechanism, TestSystem) and mechanism.period is None:  # nothing turns
        variables = {
            key: each for key, each in variables.items() if not key.endswith(("_turn", "turn_period"))
        }
    return _dataset(model, variables)


def _variables(run: Stretched, count: int) -> dict[str, Any]:
    turn, model = run.turn_period, run.model
    variables = batch_means.variables(*of_the_flow(run, count), turn, len(model.state))
    section = of_the_section(run, turn)
    variables |= described({key: ("multiplier", *each) for key, each in section.items()})
    if run.status not in USABLE:
        variables = {name: each if name in TRACE else _missing(each) for name, each in variables.items()}
    variables |= described(
        {
            "turn_period": ((), turn, "s", "mean period of a turn"),
            "grazing": ((), run.grazing, "1", "smallest relative approach to a guard"),
        }
    )
    variables["followed"] = coded((), run.way, FOLLOWED, WAYS)
    return variables | scalars(model, run)


def _missing(variable: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
    """A variable with NaN for all of its values."""
    dims, values, attributes = variable
    return dims, np.full(np.shape(values), np.nan), attributes


def _dataset(model: Model, variables: dict[str, Any]) -> xr.Dataset:
    numbers = {"exponent": ("lyapunov_exponent", "number of the exponent")}
    numbers |= {"multiplier": ("section_exponent", section_exponents.NUMBER)}
    coords = {
        dim: (dim, np.arange(1, len(variables[name][1]) + 1), "1", text)
        for dim, (name, text) in numbers.items()
    }
    return dataset(model, variables, described(coords), "lyapunov")
