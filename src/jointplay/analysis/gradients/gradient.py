"""Derivatives of numbers of a motion in the numbers of its mechanism, exact through contact.

Lengths, masses, clearances, stiffness, friction, the motor's line and the start enter the equations, and
with them forces, works and states: their derivatives are carried along with the motion, and jump at its
events (numerics.tangent, numerics.saltation). Nothing is a difference of two motions. Reference: Hiskens and
Pai, IEEE Trans. Circuits Syst. I 47 (2000) 204-220. Validity: of one motion from its start, or of a periodic
orbit; in chaos derivatives grow without bound, as neighbours part. There is none where the motion grazes a
guard, nor where events of two contacts come at one instant: `differentiable` says so.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from jointplay.analysis import rules
from jointplay.analysis.gradients import wanted
from jointplay.analysis.gradients.directions import Directions, along, of_start, stacked
from jointplay.analysis.gradients.evaluated import Run, nearness
from jointplay.analysis.keywords import Moving, Names, Progress, Rtol, Start, analysis
from jointplay.analysis.labels import coded, labelled, number, outcome
from jointplay.analysis.looks import part
from jointplay.analysis.orbits.orbit_request import start_fits
from jointplay.analysis.orbits.orbit_search import Search, at_phase, search
from jointplay.analysis.orbits.section_map import SectionMap, section_map
from jointplay.analysis.starts import moved, placed, state_names
from jointplay.analysis.vary import changed
from jointplay.errors import InputError, Problem, refuse, warn
from jointplay.mechanism.assemble import assemble
from jointplay.mechanism.base import Count, Flag, Natural
from jointplay.mechanism.model import Model
from jointplay.mechanism.records import CrankAngle, Mechanism, TestSystem

TRANSIENT = 100
LOOSER = 10.0  # tolerance of the second run, in that of the first: their distance is the error
VERDICTS = ("yes", "grazing", "simultaneous_events", "nearly_touching", "rests_on_a_wall", "no_motion")
GRAZING, TOGETHER, TOUCHING = 1e-6, 1e-9, 1e-6  # up to which there is hardly a derivative


def _by_fits(mechanism: Mechanism | TestSystem, by: tuple[str, ...] | None, orbit: bool) -> Iterator[Problem]:
    starts = [key for key in by or () if key.startswith(wanted.INITIAL)]
    states = state_names(assemble(mechanism)) if starts and not orbit else ()
    if orbit and starts:
        yield Problem("by", starts[0], "a parameter is accepted: a periodic orbit has no start")
    else:
        yield from wanted.parameters_fit(mechanism, by, states)


def _orbit_fits(mechanism: Mechanism | TestSystem, orbit: bool) -> Iterator[Problem]:
    if orbit and isinstance(mechanism, TestSystem) and mechanism.period is None:
        yield Problem("orbit", orbit, "false is accepted for a system that nothing forces")
    elif orbit:
        yield from rules.turns_alike(mechanism)


@analysis(wanted.quantities_fit, _by_fits, _orbit_fits, start_fits)
def gradient(
    mechanism: Moving,
    *,
    of: Names | None = None,
    by: Names | None = None,
    turns: Natural = 1,
    orbit: Flag = False,
    transient: Count = TRANSIENT,
    rtol: Rtol = 1e-10,
    initial: Start | None = None,
    max_steps: Natural | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Differentiate forces, works and states of a motion in parameters of its mechanism.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    of : sequence of str, optional
        What is differentiated: ``end:angle:rocker`` (any recorded quantity where the turns end; of a test
        system ``end:state:y``), ``largest:normal_force:B`` and ``smallest:…`` over the turns,
        ``work:drive``, ``work:joints`` (impacts among it), …, ``time`` of the turns.
        Left out: largest contact forces, work of the drive, time; of a test system the states at the end.
    by : sequence of str, optional
        In which parameters: names and key paths as in `[vary]`, ``initial.STATE`` of a state at the start,
        and several that change alike, as ``links.coupler.length + joints.B.journal.at``. Left out:
        clearances, contacts, friction, masses and the drive; of a test system all parameters.
    turns : int
        Whole turns of the crank from the start, periods of the forcing, or units of time.
    orbit : bool
        True: of the periodic orbit over so many turns that the motion settles to, which moves with the
        parameters, instead of the motion from the start.
    transient : int
        Turns followed before the orbit is sought.
    rtol, initial, max_steps, progress
        As in `periodic_orbit`.

    Returns
    -------
    xarray.Dataset
        Over ``quantity``: ``value``; over ``quantity`` and ``parameter``: ``derivative``, its ``error``, and
        ``relative_sensitivity``, (p/q) dq/dp; ``differentiable``, and how near the motion is to grazing and
        to simultaneous events; ``status``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    quantities = [wanted.quantity(name) for name in of or wanted.usual_quantities(mechanism)]
    keys = by or wanted.usual_parameters(mechanism)
    powers = any(each.how == "work" for each in quantities)
    limit, shape = rules.steps(max_steps), (len(quantities), len(keys))
    values, slopes, error = np.full(shape[0], np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    status, near, rests = 0, (np.nan, np.nan, np.nan), 0
    try:
        run = _run(mechanism, initial, keys, turns, orbit, transient, powers, rtol, limit, progress)
        values, slopes, grazing = run.quantities(quantities)
        looser = replace(run, rtol=min(LOOSER * rtol, 1e-4)).quantities(quantities)[1]
        error, (slowest, *others, rests) = np.abs(slopes - looser), nearness(run)
        near = (min(grazing, slowest), *others)
    except ArithmeticError as stop:
        status = int(stop.args[0])
    verdict = _verdict(near, rests)
    if verdict and not status:
        warn(f"there is hardly a derivative here: {VERDICTS[verdict].replace('_', ' ')} in this motion")
    present = np.array([_present(mechanism, key, initial) for key in keys])
    table = _variables(values, slopes, error, present)
    table |= {"differentiable": coded((), verdict, "whether there is a derivative", VERDICTS)} | _nearness(
        near
    )
    attributes = {"Conventions": "CF-1.11", "kind": "gradient"}
    labels = _labels(quantities, keys, mechanism)
    return xr.Dataset(table | outcome(status, began), labels, attributes)


def _start(mechanism: Mechanism | TestSystem, initial: Any) -> Any:
    """The start, which a test system's own is where it was changed: `replace` would give its usual one."""
    if (
        initial is None
        and isinstance(mechanism, TestSystem)
        and mechanism.initial != mechanism.replace().initial
    ):
        return mechanism.initial
    return initial


def _changed(mechanism: Mechanism | TestSystem, key: str, value: float) -> Mechanism | TestSystem:
    """The mechanism with a parameter changed, or several of one value in the order in which they fit."""
    keys = [each.strip() for each in key.split(wanted.TOGETHER)]
    try:
        return changed(mechanism, dict.fromkeys(keys, value))
    except InputError:
        if len(keys) == 1:
            raise
        return changed(mechanism, dict.fromkeys(reversed(keys), value))


def start_section(
    mechanism: Mechanism | TestSystem, start: Any, turns: int, rtol: float, limit: int | None
) -> SectionMap:
    """The map over so many turns of the section on which a motion starts."""
    section = CrankAngle() if isinstance(mechanism, Mechanism) or mechanism.period else None
    model = placed(mechanism, start, section)
    if section is None:
        return SectionMap(model, turns, model.crank_angle, None, rtol=rtol, max_steps=limit)
    return replace(section_map(model, section, turns, rtol, limit), phase=model.crank_angle)


def _run(
    mechanism: Mechanism | TestSystem,
    initial: Any,
    keys: tuple[str, ...],
    turns: int,
    orbit: bool,
    transient: int,
    powers: bool,
    rtol: float,
    limit: int,
    progress: Any,
) -> Run:
    """The motion that is differentiated; ArithmeticError with a status if there is none."""
    start = _start(mechanism, initial)

    def models(key: str) -> Any:
        return lambda value: placed(_changed(mechanism, key, value), start)

    cut = start_section(mechanism, start, turns, rtol, limit)
    model = cut.model
    parts = [
        of_start(model, key.removeprefix(wanted.INITIAL))
        if key.startswith(wanted.INITIAL)
        else _direction(models(key), wanted.value_of(mechanism, key), key)
        for key in keys
    ]
    directions = stacked(parts)
    if orbit:
        cut, model, directions = _settled(cut, directions, transient, progress)
    image = cut.image(model.state, False)
    if image.status:
        raise ArithmeticError(image.status)
    whole = not (start is None or isinstance(start, dict))  # a state, and no table
    plain = assemble(mechanism, None if whole else start, powers=True) if powers else placed(mechanism, start)
    return Run(moved(plain, model.state), directions, image.time, turns, cut.place, rtol, limit)


def _direction(models: Any, value: float, key: str) -> Directions:
    try:
        return along(models, value, key)
    except InputError as error:
        told = "; ".join(each.expected for each in error.problems)
        raise refuse(key, f"a parameter that can change to both sides is accepted: {told}", "by") from None


def _settled(
    cut: SectionMap, directions: Directions, transient: int, progress: Any
) -> tuple[SectionMap, Model, Directions]:
    """The periodic orbit, and how its state on the section moves: dx = (I - DP)^-1 dP/dp."""
    found = search(cut, Search(transient), part(progress, 0.0, 0.5))
    if found.status:
        raise ArithmeticError(found.status)
    state, _ = at_phase(found, cut.phase)
    section = replace(found.map, phase=cut.phase)
    image = section.image(state, directions=directions)
    if image.status:
        raise ArithmeticError(image.status)
    moves = np.linalg.solve(np.eye(len(section.free)) - image.derivative, image.along)
    starts = np.zeros_like(directions.starts)
    starts[:, section.free] = moves.T * section.scale[section.free]
    return section, moved(section.model, state), replace(directions, starts=starts)


def _present(mechanism: Mechanism | TestSystem, key: str, initial: Any) -> float:
    if not key.startswith(wanted.INITIAL):
        return wanted.value_of(mechanism, key)
    model = placed(mechanism, _start(mechanism, initial))
    return float(model.state[state_names(model).index(key.removeprefix(wanted.INITIAL))])


def _verdict(near: tuple[float, float, float], rests: int) -> int:
    """Code of whether there is a derivative."""
    if np.isnan(near[0]):
        return len(VERDICTS) - 1
    limits = (GRAZING, TOGETHER, TOUCHING)
    close = (i for i, (v, limit) in enumerate(zip(near, limits, strict=True), 1) if v < limit)
    return next(close, VERDICTS.index("rests_on_a_wall") if rests else 0)


def _variables(
    values: np.ndarray, slopes: np.ndarray, error: np.ndarray, present: np.ndarray
) -> dict[str, Any]:
    both, units = ("quantity", "parameter"), "in the units of quantity_units"
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = slopes * present / values[:, None]
    return {
        "value": number("quantity", values, "1", f"value, {units}"),
        "derivative": number(both, slopes, "1", f"derivative, {units} over parameter_units"),
        "error": number(both, error, "1", f"error of the derivative, {units} over parameter_units"),
        "relative_sensitivity": number(both, relative, "1", "relative change over that of the parameter"),
        "parameter_value": number("parameter", present, "1", "value, in the units of parameter_units"),
    }


def _nearness(near: tuple[float, float, float]) -> dict[str, Any]:
    words = {
        "grazing": "slowest event: of a guard relative to its terms, of a gap to the fastest",
        "nearest_events": "shortest time between events of two contacts, over the period",
        "closest_approach": "smallest gap left in flight, over the clearance",
    }
    return labelled({name: (v, "1", text) for (name, text), v in zip(words.items(), near, strict=True)})


def _labels(quantities: list, keys: tuple[str, ...], mechanism: Mechanism | TestSystem) -> dict[str, Any]:
    def named(dim: str, texts: list[str], text: str) -> tuple:
        return dim, np.array(texts), {"long_name": text}

    units = ["1" if key.startswith(wanted.INITIAL) else wanted.units(mechanism, key) for key in keys]
    return {
        "quantity": named("quantity", [each.name for each in quantities], "quantity"),
        "quantity_units": named("quantity", [each.units for each in quantities], "units of the quantity"),
        "parameter": named("parameter", list(keys), "parameter"),
        "parameter_units": named("parameter", units, "units of the parameter"),
    }
