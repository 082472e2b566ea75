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
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import BeforeValidator

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OF_A_MODEL, run_values
from jointplay.analysis.exponents import batch_means, frame_growth, growth
from jointplay.analysis.exponents.batch_means import ERRORS, UNDECIDED, evidence, judged, parting
from jointplay.analysis.exponents.frame_growth import (
    USABLE,
    Stretch,
    Stretched,
    followed_together,
    grown,
    of_the_flow,
    of_the_section,
)
from jointplay.analysis.keywords import HANDED, Lasting, Moving, analysis
from jointplay.analysis.labels import Out, xr
from jointplay.display import codes
from jointplay.display.errors import Problem, refuse
from jointplay.display.number_text import plain, signed
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Flag, Positive, unit
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, TestSystem
from jointplay.solver.motion.eligibility import FOLLOWED, ROUTES, batchable, batched
from jointplay.solver.motion.ensemble_runs import ensemble_fits
from jointplay.solver.motion.progress import part
from jointplay.solver.motion.trajectory import INTERRUPTED, Request, prepare


def number_or_all(given: Any) -> Any:
    """Refuse all but a number of exponents, or `all`."""
    if given == "all" or (isinstance(given, int) and not isinstance(given, bool) and given >= 1):
        return given
    raise refuse(given, 'a whole number greater than 0, or "all", is accepted')


def exponents_fit(mechanism: Mechanism | TestSystem, exponents: Any, model: Any = None) -> Iterator[Problem]:
    """Yield a problem where more exponents are wanted than there are."""
    if exponents in (1, "all"):
        return
    if exponents > (states := directions(model or assemble(mechanism))):
        yield Problem("exponents", exponents, f'a whole number from 1 to {states}, or "all", is accepted')


def directions(model: Model) -> int:
    """Number of exponents: one a state, without the memories of contact laws and without modes."""
    return len(model.state) - model.followers


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


def _ensemble_fits(error: float | None, saltation: bool, ensemble: bool | None) -> Iterator[Problem]:
    if ensemble and (error, saltation) != (None, True):
        yield Problem("ensemble", ensemble, "true is accepted with saltation and without a wanted error")


def verdict(result: xr.Dataset) -> xr.DataArray:
    """The word ``chaotic``, ``stable`` or ``undecided`` of each run."""
    *_, name, _ = batch_means.largest_exponent(result)
    words = judged(result)
    return codes.chosen(words == "stable", "comes to rest", words) if "flow" in name else words


def answer(result: xr.Dataset) -> str:
    """The largest exponent and its verdict; a second line on the checks."""
    value, error, name, per = batch_means.largest_exponent(result)
    word = str(verdict(result).item())
    if math.isnan(float(value)):
        return _at_rest(result) or f"{name}: not known"
    lines = [f"{name} {signed(float(value), float(error))} {per}: {word}"]
    if word == UNDECIDED:
        lines.append(_why(result, float(value), float(error)))
    if "growth" in result and math.isfinite(float(result["growth"])):
        twin = signed(float(result["growth"]), float(result["growth_standard_error"]))
        apart = abs(float(result["growth_difference"]))
        away = f", {plain(apart, 2)} standard errors from it" if math.isfinite(apart) else ""
        lines.append(f"by twin trajectories, without Jacobians: {twin} per turn{away}")
    return "\n".join(lines)


def _at_rest(result: xr.Dataset) -> str:
    """The answer of a motion without a section; empty where the flow's exponent is not known either."""
    if "lyapunov_exponent" not in result:
        return ""
    value, error = (result[f"lyapunov_{each}"].isel(exponent=0) for each in ("exponent", "standard_error"))
    if math.isnan(float(value)):
        return ""
    said = f"largest exponent of the flow {signed(float(value), float(error))} per second"
    return f"{said}; the motion is at rest or comes to rest, so that it has no section"


def _why(result: xr.Dataset, value: float, error: float) -> str:
    if ERRORS * error < value <= parting(evidence(result).get("turns", 0.0)):
        return "neighbours of a motion that is not chaotic may part as fast in so few turns: take more turns"
    if math.isfinite(error) and abs(value) > ERRORS * error:
        return (
            "successive batches of the record are correlated, so that its error is too small: take more turns"
        )
    return f"it does not differ from 0 by {ERRORS} standard errors: take more turns"


OUTPUTS = Outputs(
    "lyapunov",
    {
        "exponent": Out("exponent", "number of the exponent"),
        "multiplier": Out("multiplier", frame_growth.NUMBER),
    },
    batch_means.ESTIMATES
    | batch_means.TRACE
    | batch_means.SUM_RULE
    | frame_growth.OUTS
    | {
        "turn_period": Out((), "mean period of a turn", "s"),
        "grazing": Out((), "smallest relative approach to a guard"),
        "followed": Out((), FOLLOWED, about="in lanes or one by one", flags=ROUTES),
    }
    | OF_A_MODEL
    | growth.CHECK,
    answer,
    verdict,
    shown={
        "section_exponent_per_turn": "largest exponent of the section's map, per turn",
        "section_exponent": "largest exponent of the section's map",
        "lyapunov_exponent_per_turn": "largest Lyapunov exponent per turn",
        "lyapunov_exponent": "largest Lyapunov exponent",
    },
)


@batchable(error=None, saltation=True, twin_turns=0)
@analysis(
    rules.length_fits,
    exponents_fit,
    steady,
    _twins_fit,
    ensemble_fits,
    _ensemble_fits,
    outputs=OUTPUTS,
    left_out=rules.lasting(20, 300),
)
def lyapunov(  # noqa: D417 (nobody gives it the model)
    mechanism: Moving,
    *,
    model: Model = HANDED,
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
        Number of exponents, the largest first, or ``all``.
    turns : float
        Length after the transient, in nominal turns of the crank or periods of the forcing; instead of
        `duration`. The most that is followed, where `error` is given.
    duration : float
        Length after the transient, s; instead of `turns`.
    transient : float
        Number of turns for which the motion and its tangents are followed first and left out.
    error : float, optional
        Standard error of the largest exponent of the section's map, 1/s, at which the run stops, provided
        that the batches from which it is estimated are uncorrelated.
    twin_turns : int
        Number of turns over which the largest exponent is estimated a second time, from the same start, by
        renormalised twin trajectories; 0 leaves this out.
    saltation : bool
        Whether tangents jump at events. False leaves the jumps out, for comparison: the result is then wrong
        wherever a force jumps.
    ensemble : bool, optional
        Whether the motion is followed beside those of other cells of a `[vary]`, in an ensemble, without
        `error`. If left out, wherever sixteen or more go side by side and the structure allows it.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.

    Notes
    -----
    Of a run that failed there is only the trace up to there; of one that was interrupted and kept (`jointplay
    run`), the estimates up to there. What is of a second estimate by twins is there with `twin_turns`.

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
    count = directions(model) if exponents == "all" else int(exponents)
    begin, end = rules.span(model, motion)
    request = Request(end, motion["rtol"], max_steps=rules.steps(motion["max_steps"]))
    share = 0.5 if twin_turns else 1.0
    if twin_turns:
        cut = rules.model_for(mechanism, motion["initial"], CrankAngle())
        prepare(model.structure, "tangents.tangent_flow")
        prepare(cut.structure)  # beside the other, which takes longer
    settings = Stretch(request, count, begin), error, saltation, part(motion["progress"], 0.0, share)
    run = batched(ensemble, partial(grown, model, *settings), followed_together)
    values = _values(run, count)
    if twin_turns and run.status != INTERRUPTED:
        rest = part(motion["progress"], share, 1.0)
        twin = growth.twin(cut, twin_turns, math.ceil(motion["transient"]), motion["max_steps"], rest)
        leading = (values[f"section_{name}_per_turn"][0] for name in ("exponent", "standard_error"))
        values |= growth.check_values(*map(float, leading), twin)
        if twin["status"] == INTERRUPTED:
            values["status"] = INTERRUPTED
    if isinstance(mechanism, TestSystem) and mechanism.period is None:  # nothing turns
        values = {key: each for key, each in values.items() if not key.endswith(("_turn", "turn_period"))}
    return OUTPUTS.dataset(values, model=model)


def _values(run: Stretched, count: int) -> dict[str, Any]:
    turn, model = run.turn_period, run.model
    found = batch_means.values(*of_the_flow(run, count), turn, len(model.state)) | of_the_section(run, turn)
    found = found if run.status in USABLE else OUTPUTS.failed(found)
    for dim, name in (("exponent", "lyapunov_exponent"), ("multiplier", "section_exponent")):
        found[dim] = np.arange(1, len(found[name]) + 1)
    found |= {"turn_period": turn, "grazing": run.grazing, "followed": run.route}
    return found | run_values(model, run)
