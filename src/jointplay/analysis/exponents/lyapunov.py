"""Lyapunov exponents of a motion through its contacts, each with an error bar and an independent check.

Tangents are carried along in the same steps, through every event by its saltation matrix, and made
orthonormal after each step; the mean rates at which they grow are the exponents. Reference: G. Benettin, L.
Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9-20. Error bars, and how far to trust them:
`exponents`; the check without Jacobians: `second_estimate`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis import request as asked
from jointplay.analysis.checks import refused, together, whole
from jointplay.analysis.exponents import exponents as means
from jointplay.analysis.exponents import second_estimate
from jointplay.analysis.exponents.stretching import follow, framed, turn_period
from jointplay.analysis.quantities import dataset, scalars
from jointplay.analysis.run import Request
from jointplay.analysis.tangents import Bundle
from jointplay.errors import Problem
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.records import CrankAngle, Mechanism, TestSystem
from jointplay.mechanism.scene import Scene

TRACE = ("lyapunov_trace", "lyapunov_trace_error", "block_time")  # what a run that failed still tells


def lyapunov(
    mechanism: Mechanism | TestSystem,
    *,
    exponents: int | str = 1,
    turns: float | None = None,
    duration: float | None = None,
    transient: float = 0,
    rtol: float = 1e-8,
    error: float | None = None,
    twin_turns: int = 0,
    initial: Any = None,
    saltation: bool = True,
    max_steps: int | None = None,
    progress: Callable[[float], None] | None = None,
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
    rtol : float
        Tolerated error of a step.
    error : float, optional
        Standard error of the largest exponent, 1/s, at which the run stops, if the batches that it comes from
        do not follow one another.
    twin_turns : int
        Turns over which the largest exponent is estimated a second time, from the same start, by renormalised
        twin trajectories; 0: not.
    initial, max_steps, progress
        As in `simulate`.
    saltation : bool
        False leaves the tangents' jumps at events out, as a comparison: the result is then wrong wherever a
        force jumps.

    Returns
    -------
    xarray.Dataset
        ``lyapunov_exponent`` and ``lyapunov_standard_error`` (1/s), both also ``…_per_turn`` where something
        turns, over
        ``exponent``, with ``batch_correlation`` and ``effective_blocks``; ``lyapunov_trace`` (running means)
        and ``lyapunov_trace_error`` over ``block`` and ``exponent``, at ``block_time``; ``turn_period``;
        ``sum_residual`` (1/s; of a whole spectrum), ``mean_divergence`` and ``volume_share``: see Notes;
        ``grazing`` and ``status``. With `twin_turns`: ``growth`` a turn, ``growth_standard_error``,
        ``map_exponent``, what the first estimate says of the same, and ``growth_difference`` in combined
        standard errors; ``growth_status``. Of a run that failed, only the trace up to there.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.

    Notes
    -----
    The error bar is that of means over 40 batches; it says how much the mean would differ on another stretch
    of the same length, if the batches are long compared to the motion's memory. They are if
    ``batch_correlation`` is within 0.32 of 0; of a periodic motion, means converge as 1/T and the bar
    exaggerates.

    The sum of all exponents is the mean divergence: trace of the Jacobian, and ln|det S| of the jumps.
    ``sum_residual`` is the difference. A direction that shrinks by more than a factor 50 within a step is
    followed to zero, but not at its true rate; there the last exponent of a whole spectrum is what the volume
    leaves for it, and ``volume_share`` is the share of time in which that was so. An exponent is minus
    infinity where sticking loses a dimension. ``grazing`` is the smallest approach speed of a guard at an
    event relative to the terms that it is a sum of: near 0, exponents are uncertain.
    """
    together(
        lambda: asked.check(mechanism, turns, duration, transient, rtol, max_steps),
        lambda: wrong(mechanism, exponents, error, twin_turns, saltation),
    )
    scene = assemble(mechanism, initial)
    count = len(scene.state) if exponents == "all" else int(exponents)
    begin = transient * scene.period
    span = duration if turns is None else turns * scene.period
    request = Request(begin + span, rtol, max_steps=asked.steps(max_steps))
    bundle = framed(scene, request, count, saltation)
    share = 0.5 if twin_turns else 1.0
    rows, ended = follow(bundle, begin, error, _part(progress, 0.0, share))
    variables = _variables(scene, bundle, rows, ended)
    if twin_turns:
        cut = assemble(mechanism, initial, asked.quantity(CrankAngle(), mechanism))
        reach = math.ceil(transient)
        found = second_estimate.twin(cut, twin_turns, reach, max_steps, _part(progress, share, 1.0))
        values, errors = (
            variables[f"lyapunov_{name}_per_turn"][1] for name in ("exponent", "standard_error")
        )
        variables |= second_estimate.variables(values, errors, found)
    if isinstance(mechanism, TestSystem) and mechanism.period is None:  # nothing turns
        variables = {
            key: each for key, each in variables.items() if not key.endswith(("_turn", "turn_period"))
        }
    return _dataset(scene, variables)


def wrong(
    mechanism: Mechanism | TestSystem,
    exponents: Any = 1,
    error: Any = None,
    twin_turns: Any = 0,
    saltation: Any = True,
    **_: Any,
) -> None:
    """Refuse keywords of `lyapunov` that make no sense for this mechanism.

    Raises
    ------
    InputError
        Listing every problem.
    """
    refused(_problems(mechanism, exponents, error, twin_turns, saltation))


def _problems(mechanism, exponents: Any, error: Any, twin_turns: Any, saltation: Any) -> Iterator[Problem]:
    number = isinstance(exponents, int) and not isinstance(exponents, bool)
    states = len(assemble(mechanism).state) if isinstance(mechanism, Mechanism | TestSystem) else math.inf
    if exponents != "all" and not (number and 1 <= exponents <= states):
        yield Problem("exponents", exponents, f'a whole number from 1 to {states}, or "all", is accepted')
    if error is not None and not (isinstance(error, int | float) and 0 < error < math.inf):
        yield Problem("error", error, "a standard error greater than 0 (1/s) is accepted")
    yield from whole("twin_turns", twin_turns, 0)
    if twin_turns and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("twin_turns", twin_turns, "0 is accepted for a system that nothing forces")
    if not isinstance(saltation, bool):
        yield Problem("saltation", saltation, "true or false is accepted")


def _part(progress: Callable[[float], None] | None, first: float, last: float) -> Callable | None:
    """The progress of a part of the work."""
    return None if progress is None else lambda done: progress(first + (last - first) * done)


def _variables(scene: Scene, bundle: Bundle, rows: np.ndarray, ended: dict[str, Any]) -> dict[str, Any]:
    turn = turn_period(scene, rows)
    told = {
        "turn_period": (turn, "s", "mean period of a turn"),
        "grazing": (bundle.grazing, "1", "smallest relative approach to a guard"),
    }
    found = means.variables(rows, bundle.logs, turn, len(scene.state))
    if ended["status"]:
        found = {name: each if name in TRACE else _lost(each) for name, each in found.items()}
    found |= {key: ((), v, {"units": u, "long_name": text}) for key, (v, u, text) in told.items()}
    return found | scalars(scene, SimpleNamespace(**ended))


def _lost(variable: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
    """A variable without its values."""
    dims, values, attributes = variable
    return dims, np.full(np.shape(values), np.nan), attributes


def _dataset(scene: Scene, variables: dict[str, Any]) -> xr.Dataset:
    number = np.arange(1, len(variables["lyapunov_exponent"][1]) + 1)
    over = ("exponent", number, {"units": "1", "long_name": "number of the exponent"})
    return dataset(scene, variables, {"exponent": over}, "lyapunov")
