"""Derivatives of numbers of a motion in the numbers of its mechanism, exact through contact.

Lengths, masses, clearances, stiffness, friction, the motor's line and the start enter the equations, and
with them forces, works and states: their derivatives are carried along with the motion, and jump at its
events (method.tangents.tangent, method.tangents.saltation). Nothing is a difference of two motions.
Reference: Hiskens and Pai, IEEE Trans. Circuits Syst. I 47 (2000) 204-220. Validity: of one motion from its
start, or of a periodic orbit; in chaos derivatives grow without bound, as neighbours part. There is none
where the motion grazes a guard, nor where events of two contacts come at one instant, nor of a start at rest
on a wall off which neighbours start: `derivative_status` says so. Of an orbit's multipliers:
gradients.multipliers.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.gradients import gradient_dataset, multipliers, selection
from jointplay.analysis.gradients.evaluated import Run, nearness
from jointplay.analysis.gradients.gradient_dataset import VERDICTS, WHY
from jointplay.analysis.keywords import Moving, Names, Settling, analysis
from jointplay.analysis.labels import Out, ended
from jointplay.analysis.orbits.orbit_request import section_fits, started
from jointplay.analysis.orbits.orbit_search import Search, at_phase, search
from jointplay.analysis.orbits.section_map import SectionMap, section_map
from jointplay.analysis.orbits.shooting import Orbit
from jointplay.analysis.starts import free_states, moved, placed, state_names
from jointplay.display import codes
from jointplay.display.errors import NOTHING, InputError, Problem, refuse, warn
from jointplay.display.number_text import plain
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Flag, Natural
from jointplay.solver.mechanism.directions import Directions, of_start, stacked
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Plane, TestSystem
from jointplay.solver.method.codes import Status
from jointplay.solver.motion.progress import part

if TYPE_CHECKING:
    import xarray as xr

LEADING = 3  # quantities, and parameters of each, whose derivatives are named
LOOSER = 10.0  # tolerance of the second run, in that of the first: their distance is the error


def _by_fits(mechanism: Mechanism | TestSystem, by: tuple[str, ...] | None, orbit: bool) -> Iterator[Problem]:
    starts = [key for key in by or () if key.startswith(selection.INITIAL)]
    states = free_states(assemble(mechanism)) if starts and not orbit else ()
    if orbit and starts:
        yield Problem("by", starts[0], "a parameter is accepted: a periodic orbit has no start")
    else:
        yield from selection.parameters_fit(mechanism, by, states)


def _orbit_fits(mechanism: Mechanism | TestSystem, orbit: bool, section: Plane | None) -> Iterator[Problem]:
    if orbit and section is None and isinstance(mechanism, TestSystem) and mechanism.period is None:
        expected = "a plane of a state is needed for the orbit of a system that nothing forces"
        yield Problem("section", NOTHING, expected)
    elif orbit:
        yield from rules.turns_alike(mechanism)
    if section is not None:
        yield from section_fits(mechanism, section)


def answer(result: xr.Dataset) -> str:
    """The largest relative sensitivity of each quantity, and whether there is a derivative."""
    verdict = str(codes.words(result["derivative_status"]).item())
    if not np.isfinite(result["derivative"].values).any():
        return f"no derivative: {WHY.get(verdict, verdict)}"
    lines = [_quantity(result.isel(quantity=i)) for i in range(min(LEADING, result.sizes["quantity"]))]
    if verdict != "ok":
        lines.append(f"a derivative hardly exists here: {WHY.get(verdict, verdict)}")
    return "\n".join(lines)


def _quantity(one: xr.Dataset) -> str:
    sizes = np.nan_to_num(one["relative_sensitivity"].values)
    order = np.argsort(-np.abs(sizes), kind="stable")[:LEADING]
    parts = [f"{plain(float(sizes[i]), 3)} to {one['parameter'].values[i]}" for i in order if sizes[i]]
    name, units = str(one["quantity"].item()), str(one["quantity_units"].item())
    value = f"{name} = {plain(float(one['value']), 6)}" + (f" {units}" if units != "1" else "")
    return (
        f"{value}: relative sensitivity {', '.join(parts)}" if parts else f"{value} depends on none of them"
    )


UNITS = "in the units of quantity_units"
STATE = "in rad, m and their rates, or a system's own units"
BOTH = ("quantity", "parameter")
OUTPUTS = Outputs(
    "gradient",
    gradient_dataset.LABELS | {"state": Out("state", "state", "")},
    {
        "value": Out("quantity", f"value, {UNITS}"),
        "derivative": Out(BOTH, f"derivative, {UNITS} over parameter_units"),
        "error": Out(BOTH, f"error of the derivative, {UNITS} over parameter_units"),
        "relative_sensitivity": Out(
            BOTH,
            "relative change over that of the parameter",
            about="(p/q) dq/dp",
            at={"quantity": "largest", "parameter": "largest"},
        ),
        "parameter_value": Out("parameter", "value, in the units of parameter_units"),
        "derivative_status": Out((), "whether there is a derivative", flags=VERDICTS),
        "grazing": Out((), "slowest event: of a guard relative to its terms, of a gap to the fastest"),
        "nearest_events": Out((), "shortest time between events of two contacts, over the period"),
        "closest_approach": Out((), "smallest gap left in flight, over the clearance"),
        "orbit_state": Out("state", f"state where the orbit starts, {STATE}"),
        "orbit_state_derivative": Out(
            ("state", "parameter"), f"derivative of that state, {STATE}, over parameter_units"
        ),
    }
    | OUTCOME,
    answer,
    shown={"relative_sensitivity": ""},
)


@analysis(
    *(selection.quantities_fit, _by_fits, _orbit_fits, "model"),
    usual={"rtol": 1e-10},
    outputs=OUTPUTS,
    model=started,
)
def gradient(
    mechanism: Moving,
    *,
    of: Names | None = None,
    by: Names | None = None,
    turns: Natural = 1,
    orbit: Flag = False,
    section: Plane | None = None,
    **motion: Unpack[Settling],
) -> xr.Dataset:
    """Differentiate forces, works and states of a motion in parameters of its mechanism.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    of : sequence of str, optional
        Quantities that are differentiated: ``end:angle:rocker`` (any recorded quantity where the turns end;
        of a test system ``end:state:y``), ``largest:normal_force:B`` and ``smallest:…`` over the turns,
        ``work:drive``, ``work:joints`` (impacts included), …, ``time`` of the turns. Of an orbit
        ``multiplier:1`` (the largest; its real part), ``multiplier_imaginary:1``, ``multiplier_modulus:1``,
        ``exponent:1``. Left out: largest contact forces, work of the drive, time; of a test system the states
        at the end.
    by : sequence of str, optional
        Parameters in which they are differentiated: names and key paths as in `[vary]`, ``initial.STATE`` of
        a state at the start, and several that change alike, as ``links.coupler.length +
        joints.B.journal.at``. Left out: clearances, contacts, friction, masses and the drive; of a test
        system all parameters.
    turns : int
        Number of whole turns of the crank from the start, of periods of the forcing, of passages of the
        `section`, or of units of time.
    orbit : bool
        Whether the derivatives are those of the periodic orbit over so many turns to which the motion
        settles, and which moves with the parameters, instead of the motion from the start.
    section : Plane, optional
        Plane of a state of a system that nothing forces, at whose last passage the turns end.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    quantities = [selection.quantity(name) for name in of or selection.usual_quantities(mechanism)]
    keys = by or selection.usual_parameters(mechanism)
    orbits = np.array([each.how in multipliers.MULTIPLIERS for each in quantities])
    inside = [each for each, of_orbit in zip(quantities, orbits, strict=True) if not of_orbit]
    powers = any(each.how == "work" for each in quantities)
    limit, shape = rules.steps(motion["max_steps"]), (len(quantities), len(keys))
    initial, rtol = motion["initial"], motion["rtol"]
    values, slopes, error = np.full(shape[0], np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    status, near, equal, run = 0, (np.nan, np.nan, np.nan), False, None
    try:
        start = _start(mechanism, initial)
        cut = start_section(mechanism, start, turns, rtol, limit, section)
        found = _orbit(cut, motion["transient"], motion["progress"]) if orbit else None
        start = None if orbit and isinstance(mechanism, TestSystem) else start  # an orbit has none
        run = _run(mechanism, start, keys, cut, found, powers)
        values[~orbits], slopes[~orbits], grazing = run.quantities(inside)
        looser = replace(run, rtol=min(LOOSER * rtol, 1e-4)).quantities(inside)[1]
        error[~orbits], (slowest, *others) = np.abs(slopes[~orbits] - looser), nearness(run)
        near = (min(grazing, slowest), *others)
        if orbits.any():
            asked = [(each.how, int(each.key)) for each in quantities if each.how in multipliers.MULTIPLIERS]
            maps = _maps(start, (turns, rtol, limit, section))
            moved_by = [Parameter(mechanism, key) for key in keys]
            changes = [multipliers.change(found, maps(each), each.value, each.key) for each in moved_by]
            changed_orbit = multipliers.derivatives(found, changes, asked)
            values[orbits], slopes[orbits], error[orbits], equal = changed_orbit
    except ArithmeticError as stop:
        status = int(stop.args[0])
    opened = run is not None and not status and bool(np.isnan(slopes[~orbits]).any())
    present = np.array([_present(mechanism, key, initial) for key in keys])
    parting = gradient_dataset.sensitive(values[~orbits], present, slopes[~orbits], error[~orbits])
    verdict = gradient_dataset.verdict(near, equal, opened, parting)
    through = status == Status.NO_DERIVATIVE or (run is not None and status == Status.CHATTER)
    if through:  # the motion goes on, its derivatives do not
        status, verdict = 0, VERDICTS.index("simultaneous_events")
    if verdict and not status:
        warn(f"a derivative hardly exists here: {WHY[VERDICTS[verdict]]}")
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = slopes * present / values[:, None]
    table = gradient_dataset.labels(quantities, keys, mechanism) | ended(status, began)
    table |= {"value": values, "derivative": slopes, "error": error, "relative_sensitivity": relative}
    table |= {"parameter_value": present, "derivative_status": verdict}
    table |= dict(zip(("grazing", "nearest_events", "closest_approach"), near, strict=True))
    if orbit and run is not None:
        table |= {"orbit_state": run.model.state, "orbit_state_derivative": run.directions.starts.T}
        table["state"] = np.array(state_names(run.model))
    return OUTPUTS.dataset(table)


def _start(mechanism: Mechanism | TestSystem, initial: Any) -> Any:
    """The start, which a test system's own is where it was changed: `replace` would give its usual one."""
    if (
        initial is None
        and isinstance(mechanism, TestSystem)
        and mechanism.initial != mechanism.replace().initial
    ):
        return mechanism.initial
    return initial


def start_section(
    mechanism: Mechanism | TestSystem,
    start: Any,
    turns: int,
    rtol: float,
    limit: int | None,
    section: Plane | None = None,
) -> SectionMap:
    """The map over so many turns of the section on which a motion starts, or of a plane."""
    once = CrankAngle() if isinstance(mechanism, Mechanism) or mechanism.period else None
    model = placed(mechanism, start, section or once)
    if section:
        return section_map(model, section, turns, rtol, limit)
    if once is None:
        return SectionMap(model, turns, model.crank_angle, None, rtol=rtol, max_steps=limit)
    return replace(section_map(model, once, turns, rtol, limit), phase=model.crank_angle)


def _maps(start: Any, settings: tuple) -> Any:
    """Maps of a section over a parameter; `settings` as `start_section` takes them."""
    return lambda parameter: lambda value: start_section(parameter.at(value), start, *settings)


def _run(
    mechanism: Mechanism | TestSystem,
    start: Any,
    keys: tuple[str, ...],
    cut: SectionMap,
    orbit: Orbit | None,
    powers: bool,
) -> Run:
    """The motion that is differentiated; ArithmeticError with a status if there is none."""
    model, turns = cut.model, cut.turns
    parts = [
        of_start(model, state_names(model).index(key.removeprefix(selection.INITIAL)))
        if key.startswith(selection.INITIAL)
        else _direction(Parameter(mechanism, key), start)
        for key in keys
    ]
    directions = stacked(parts)
    if orbit:
        model, directions = _moving(orbit, cut, directions)
    image = cut.image(model.state, False)
    if image.status:
        raise ArithmeticError(image.status)
    return Run(
        moved(placed(mechanism, start, powers=powers), model.state),
        directions,
        image.time,
        turns,
        cut.place,
        cut.rtol,
        rules.steps(cut.max_steps),
    )


def _direction(parameter: Parameter, start: Any) -> Directions:
    try:
        return parameter.directions(lambda there: placed(there, start))
    except InputError as error:
        told = "; ".join(each.expected for each in error.problems)
        accepted = "a parameter that can change to both sides is accepted"
        raise refuse(parameter.key, f"{accepted}: {told}", "by") from None


def _orbit(cut: SectionMap, transient: int, progress: Any) -> Orbit:
    """The periodic orbit that the motion settles to."""
    found = search(cut, Search(transient), part(progress, 0.0, 0.5))
    if found.status:
        raise ArithmeticError(found.status)
    return found


def _moving(orbit: Orbit, cut: SectionMap, directions: Directions) -> tuple[Model, Directions]:
    """The orbit's model at its start, and the derivative of its state there: dx = (I - DP)^-1 dP/dp."""
    state, _ = at_phase(orbit, cut.phase)
    section = replace(orbit.map, phase=cut.phase)
    image = section.image(state, directions=directions)
    if image.status:
        raise ArithmeticError(image.status)
    moves = np.linalg.solve(np.eye(len(section.free)) - image.derivative, image.along)
    starts = np.zeros_like(directions.starts)
    starts[:, section.free] = moves.T * section.scale[section.free]
    return moved(section.model, state), replace(directions, starts=starts)


def _present(mechanism: Mechanism | TestSystem, key: str, initial: Any) -> float:
    if not key.startswith(selection.INITIAL):
        return float(Parameter(mechanism, key).value)
    model = placed(mechanism, _start(mechanism, initial))
    return float(model.state[state_names(model).index(key.removeprefix(selection.INITIAL))])
