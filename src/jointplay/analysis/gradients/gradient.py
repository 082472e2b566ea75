"""Derivatives of numbers of a motion in the numbers of its mechanism, exact through contact.

Lengths, masses, clearances, stiffness, friction, the motor's line and the start enter the equations, and
with them forces, works and states: their derivatives are carried along with the motion, and jump at its
events (method.tangents.tangent, method.tangents.saltation). Nothing is a difference of two motions.
Reference: Hiskens and Pai, IEEE Trans. Circuits Syst. I 47 (2000) 204-220. Validity: of one motion from its
start, or of a periodic orbit; in chaos derivatives grow without bound, as neighbours part. There is none
where the motion grazes a guard, nor where events of two contacts come at one instant, nor of a start at rest
on a wall off which neighbours start: `derivative_status` says so. Of an orbit's multipliers:
gradients.selection.

All directions are taken at once: the motion is followed with tangents that the directions drive
(method.tangents.tangent), stopping where quantities are looked at. With F the rate of the state and t' the
derivative of the time at which that is,

    end                 dq = q_x (y + F t') + q_t t' + q_p
    largest, smallest   the same with t' = 0 within a piece; at an event t' = -(h_x y + h_p) / (h_t + h_x F)
    work                dW = the tangents' own, + P t'
    time                t' of the end: by the crank's angle -y_c / F_c, by a phase that of the period

and where impacts take energy, the joints' work is what the others leave over of the change of energy.

A largest value lies within a smooth piece, on one side of an event, or at an end. To find it, the motion is
followed again, sampled closer about the largest value so far: motions are the same each time,
samples do not change steps. Within a piece the place is the top of a polynomial through many samples of a
more exact run, since the derivative of a largest value is exact only there.

At a point, derivatives are taken by the complex step: a quantity's program (codegen.outputs) is arithmetic,
and run on x + i eps dx it gives value + i eps derivative, without a difference's cancellation. Reference:
Squire and Trapp, SIAM Review 40 (1998) 110-112.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Unpack

import numpy as np

from jointplay.analysis import rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import OUTCOME, Quantities, in_order
from jointplay.analysis.gradients import gradient_dataset, selection
from jointplay.analysis.gradients.gradient_dataset import IN_PARAMETER, IN_QUANTITY, VERDICTS, WHY
from jointplay.analysis.gradients.selection import Quantity
from jointplay.analysis.keywords import SETTLING, Moving, Names, Settling, analysis
from jointplay.analysis.labels import Out, ended, xr
from jointplay.analysis.orbits.orbit_dataset import STABILITY, section_fits, stability, started
from jointplay.analysis.orbits.section_map import (
    BEGINS,
    KIND,
    PLACE,
    SectionMap,
    approach_speeds,
    section_map,
)
from jointplay.analysis.orbits.shooting import Orbit, Search, at_phase, multipliers, search
from jointplay.analysis.quantities import WORK
from jointplay.analysis.starts import free_states, moved, placed, state_names
from jointplay.analysis.tangents import TIGHT, Bundle
from jointplay.display import codes
from jointplay.display.errors import NOTHING, InputError, Problem, refuse, warn
from jointplay.display.number_text import plain
from jointplay.solver.codegen import cache, outputs
from jointplay.solver.equations.structure import powers
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Flag, Natural
from jointplay.solver.mechanism.directions import Directions, of_start, stacked
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.parameters import Parameter
from jointplay.solver.mechanism.records import CrankAngle, Mechanism, Plane, TestSystem
from jointplay.solver.method.codes import Event, Mode, Status
from jointplay.solver.motion.guard_tolerances import clearances_squared
from jointplay.solver.motion.progress import part
from jointplay.solver.motion.trajectory import Records, Request, follow

LEADING = 3  # quantities, and parameters of each, whose derivatives are named
LOOSER = 10.0  # tolerance of the second run, in that of the first: their distance is the error

ENERGIES = ("kinetic_energy", "potential_energy")
SOLVED = 0.1  # tolerance of the tangents' iteration, in those of a step
ASIDE, ROOM = 1e-9, 10.0  # of the period, and tolerances: so far from an event a run stops on both sides
SAMPLES, CLOSER, ROUNDS = 4096, 33, 2  # of a turn; about the largest; how often
DEGREE, SHARPER, LEAST = 6, 1e-2, 1e-13  # of the polynomial; tolerance of its run in that of the motion's
UNLIKE = 1e-2  # relative difference of a largest value between the two runs
ALIKE = 1e-13  # of the period: nearer times are one
STEP = 1e-40  # of the complex step


def _by_fits(mechanism: Mechanism | TestSystem, by: tuple[str, ...] | None, orbit: bool) -> Iterator[Problem]:
    starts = [key for key in by or () if key.startswith(selection.INITIAL)]
    states = free_states(assemble(mechanism)) if starts and not orbit else ()
    if orbit and starts:
        yield Problem("by", starts[0], "a parameter is accepted: a periodic orbit has no start")
    else:
        yield from selection.parameters_fit(mechanism, by, states)
        yield from rules.alike_beside(mechanism, "by", by or () if orbit else ())


def settling_fits(orbit: bool, transient: int) -> Iterator[Problem]:
    """Yield the problem of a transient where no orbit is sought: a motion is taken from its start on."""
    if not orbit and transient not in (0, SETTLING):
        expected = "0 is accepted without orbit = true: what is differentiated begins at the start"
        yield Problem("transient", transient, expected)


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
        why = "no orbit was found" if "trouble" in result.attrs else WHY.get(verdict, verdict)
        return f"no derivative: {why}"
    lines = [_quantity(result.isel(quantity=i)) for i in range(min(LEADING, result.sizes["quantity"]))]
    if verdict != "ok":
        lines.append(f"a derivative hardly exists here: {WHY.get(verdict, verdict)}")
    if "stable" in result and codes.words(result["stable"]).item() == "unstable":
        lines.append("the orbit is unstable: the motion does not settle to it")
    return "\n".join(lines)


def _quantity(one: xr.Dataset) -> str:
    sizes = np.nan_to_num(one["relative_sensitivity"].values)
    order = np.argsort(-np.abs(sizes), kind="stable")[:LEADING]
    parts = [f"{plain(float(sizes[i]), 3)} to {one['parameter'].values[i]}" for i in order if sizes[i]]
    name, units = str(one["quantity"].item()), str(one["quantity_units"].item())
    value = f"{name} = {plain(float(one['value']), 6)}" + (f" {units}" if units != "1" else "")
    return value + (f": relative sensitivity {', '.join(parts)}" if parts else " depends on none of them")


STATE = "in rad, m and their rates, or a system's own units"


BOTH = ("quantity", "parameter")


OUTPUTS = Outputs(
    "gradient",
    gradient_dataset.LABELS | {"state": Out("state", "state", "")},
    {
        "value": Out("quantity", f"value, {IN_QUANTITY}"),
        "derivative": Out(BOTH, f"derivative, {IN_QUANTITY} over parameter_units"),
        "error": Out(BOTH, f"error of the derivative, {IN_QUANTITY} over parameter_units"),
        "relative_sensitivity": Out(
            BOTH,
            "relative change over that of the parameter",
            about="(p/q) dq/dp",
            at={"quantity": "largest", "parameter": "largest"},
        ),
        "parameter_value": Out("parameter", f"value, {IN_PARAMETER}"),
        "derivative_status": Out((), "whether there is a derivative", flags=VERDICTS),
        "grazing": Out((), "slowest event: of a guard relative to its terms, of a gap to the fastest"),
        "nearest_events": Out((), "shortest time between events of two contacts, over the period"),
        "closest_approach": Out((), "smallest gap left in flight, over the clearance"),
        "orbit_state": Out("state", f"state where the orbit starts, {STATE}"),
        "orbit_state_derivative": Out(
            ("state", "parameter"), f"derivative of that state, {STATE}, over parameter_units"
        ),
        "stable": Out((), "stability of the orbit", flags=STABILITY, missing="unknown"),
    }
    | OUTCOME,
    answer,
    shown={"relative_sensitivity": ""},
)


@analysis(
    *(selection.quantities_fit, _by_fits, _orbit_fits, settling_fits, "model"),
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
        Whether the derivatives are those of the periodic orbit over so many turns that is found where the
        motion has settled, and which moves with the parameters, instead of the motion from the start. It may
        be an unstable one, to which no motion settles: ``stable`` says so.
    section : Plane, optional
        Plane of a state of a system that nothing forces, at whose last passage the turns end.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    began = time.perf_counter()
    quantities = [selection.quantity(name) for name in of or selection.usual_quantities(mechanism)]
    usual = selection.usual_parameters(mechanism)
    keys, attributes = rules.usual_alike(mechanism, usual) if orbit and not by else (by or usual, {})
    orbits = np.array([each.how in selection.MULTIPLIERS for each in quantities])
    inside = [each for each, of_orbit in zip(quantities, orbits, strict=True) if not of_orbit]
    powers = any(each.how == "work" for each in quantities)
    limit, shape = rules.steps(motion["max_steps"]), (len(quantities), len(keys))
    initial, rtol = motion["initial"], motion["rtol"]
    values, slopes, error = np.full(shape[0], np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    status, near, equal, run, neutral, found = 0, (np.nan, np.nan, np.nan), False, None, False, None
    try:
        start = _start(mechanism, initial)
        cut = start_section(mechanism, start, turns, rtol, limit, section)
        settling = Search(motion["transient"]), part(motion["progress"], 0.0, 0.5)
        found = search(cut, *settling) if orbit else None
        start = None if orbit and isinstance(mechanism, TestSystem) else start  # an orbit has none
        run = _run(mechanism, start, keys, cut, found and selection.reached(found), powers)
        values[~orbits], slopes[~orbits], grazing = run.quantities(inside)
        looser = replace(run, rtol=min(LOOSER * rtol, 1e-4)).quantities(inside)[1]
        error[~orbits], (slowest, *others) = np.abs(slopes[~orbits] - looser), nearness(run)
        near = (min(grazing, slowest), *others)
        if orbits.any():
            numbered = [(each.how, int(each.key)) for each in quantities if each.how in selection.MULTIPLIERS]
            maps = _maps(start, (turns, rtol, limit, section))
            moved_by = [Parameter(mechanism, key) for key in keys]
            changes = [selection.change(found, maps(each), each.value, each.key) for each in moved_by]
            changed_orbit = selection.derivatives(found, changes, numbered)
            values[orbits], slopes[orbits], error[orbits], equal = changed_orbit
    except ArithmeticError as stop:
        status, neutral = int(stop.args[0]), isinstance(stop, selection.Neutral)
    opened = run is not None and not status and bool(np.isnan(slopes[~orbits]).any())
    present = np.array([_present(mechanism, key, initial) for key in keys])
    parting = gradient_dataset.sensitive(values[~orbits], present, slopes[~orbits], error[~orbits])
    verdict = gradient_dataset.verdict(near, equal, opened, parting)
    through = status == Status.NO_DERIVATIVE or (run is not None and status == Status.CHATTER)
    if through or neutral:  # the motion goes on, its derivatives do not
        status, verdict = 0, VERDICTS.index("neutral" if neutral else "simultaneous_events")
    if verdict and not status:
        warn(f"a derivative hardly exists here: {WHY[VERDICTS[verdict]]}")
    with np.errstate(invalid="ignore", divide="ignore"):
        relative = slopes * present / values[:, None]
    table = gradient_dataset.labels(quantities, keys, mechanism) | ended(status, began)
    table |= {"value": values, "derivative": slopes, "error": error, "relative_sensitivity": relative}
    table |= {"parameter_value": present, "derivative_status": verdict}
    table |= dict(zip(("grazing", "nearest_events", "closest_approach"), near, strict=True))
    if found and run is not None:
        table["stable"] = stability(multipliers(found.image.derivative))
        table |= {"orbit_state": run.model.state, "orbit_state_derivative": run.directions.starts.T}
        table["state"] = np.array(state_names(run.model))
    return OUTPUTS.dataset(table, **attributes, **(found.trouble if found else {}))


def _start(mechanism: Mechanism | TestSystem, initial: Any) -> Any:
    """The start, which a test system's own is where it was changed: `replace` would give its usual one."""
    own = mechanism.initial if isinstance(mechanism, TestSystem) and initial is None else None
    return initial if own is None or own == mechanism.replace().initial else own


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
    model = cut.model
    parts = [
        of_start(model, state_names(model).index(key.removeprefix(selection.INITIAL)))
        if key.startswith(selection.INITIAL)
        else _direction(Parameter(mechanism, key), start)
        for key in keys
    ]
    directions = stacked(parts)
    if orbit:
        model, directions = _moving(orbit, cut, directions)
    image = selection.reached(cut.image(model.state, False))
    model, limit = moved(placed(mechanism, start, powers=powers), model.state), rules.steps(cut.max_steps)
    return Run(model, directions, image.time, cut.turns, cut.place, cut.rtol, limit)


def _direction(parameter: Parameter, start: Any) -> Directions:
    try:
        return parameter.directions(lambda there: placed(there, start))
    except InputError as error:
        reasons = "; ".join(each.expected for each in error.problems)
        accepted = "a parameter that can change to both sides is accepted"
        raise refuse(parameter.key, f"{accepted}: {reasons}", "by") from None


def _moving(orbit: Orbit, cut: SectionMap, directions: Directions) -> tuple[Model, Directions]:
    """The orbit's model at its start, and the derivative of its state there."""
    state, _ = at_phase(orbit, cut.phase)
    section = replace(orbit.map, phase=cut.phase)
    image = selection.reached(section.image(state, directions=directions))
    starts = np.zeros_like(directions.starts)
    starts[:, section.free] = selection.moves_of(image).T * section.scale[section.free]
    return moved(section.model, state), replace(directions, starts=starts)


def _present(mechanism: Mechanism | TestSystem, key: str, initial: Any) -> float:
    if not key.startswith(selection.INITIAL):
        return float(Parameter(mechanism, key).value)
    model = placed(mechanism, _start(mechanism, initial))
    return float(model.state[state_names(model).index(key.removeprefix(selection.INITIAL))])


@dataclass(frozen=True)
class Run:
    """A motion from the model's start, over a time that may depend on the parameters.

    Parameters
    ----------
    model : Model
        At its start; with powers where works are wanted, without a section.
    directions : Directions
        With the start's derivatives.
    end : float
        Time at which it ends, s.
    turns : float
        How many that are.
    place : int or None
        Index of the state that is the same at the end, whatever the time; None where time is as `directions`
        say.
    rtol : float
        Relative tolerance of a step.
    limit : int
        Attempted steps after which a run stops.
    """

    model: Model
    directions: Directions
    end: float
    turns: float
    place: int | None
    rtol: float
    limit: int

    def quantities(self, wanted: list[Quantity]) -> tuple[np.ndarray, np.ndarray, float]:
        """Values, derivatives (quantities, directions), and the nearest approach of an event to grazing.

        Raises
        ------
        ArithmeticError
            With the status, if the motion did not get to its end.
        """
        stops = [(self._peak(each), each) for each in wanted if each.how in ("largest", "smallest")]
        bundle, found, events = self._bundle(), {}, {}
        begin, opened = bundle.recorded, self._opened()
        for at, each in sorted(stops, key=lambda stop: stop[0].time):
            if at.where != "end":
                found[each] = self._at(bundle, at, each.key, events)
        self._advance(bundle, self.end)
        found |= self._at_end(bundle, begin, [each for each in wanted if each not in found])
        both = [found[each] for each in wanted]
        slopes = np.array([d for _, d in both]).reshape(len(wanted), len(self.directions))
        slopes[:, opened] = np.nan
        return np.array([v for v, _ in both]), slopes, bundle.grazing

    def _opened(self) -> np.ndarray:
        """Whether neighbours along each direction start off a wall on which the body starts at rest."""
        bundle = self._bundle()
        self._advance(bundle, 0.0)
        return bundle.opened()

    def _bundle(self) -> Bundle:
        none = np.zeros((0, len(self.model.state)))
        request = Request(self.end, self.rtol, max_steps=self.limit)
        tolerance = max(TIGHT, SOLVED * self.rtol)
        return Bundle(self.model, request, none, tolerance, directions=self.directions)

    def _advance(self, bundle: Bundle, until: float) -> None:
        if bundle.time > 0 and until - bundle.time < ALIKE * self.model.period:
            return
        if status := bundle.advance(until):
            raise ArithmeticError(status)

    def _peak(self, wanted: Quantity) -> Peak:
        sign = 1.0 if wanted.how == "largest" else -1.0
        return peak(self.model, wanted.key, sign, self.end, self.turns, self.rtol, self.limit)

    def _at(self, bundle: Bundle, at: Peak, key: str, events: dict) -> tuple[float, np.ndarray]:
        """Value and derivatives of a quantity at an extreme value; `events` keeps both sides of events."""
        if at.where in ("within", "start"):
            self._advance(bundle, at.time)
            still = np.zeros(len(self.directions))
            return at.value, self._here(bundle.recorded, key, bundle.vectors, still)[1]
        if at.time not in events:
            events[at.time] = self._sides(bundle, at.time)
        y, row, rate, times = events[at.time][at.where]
        return at.value, self._here(row, key, y + np.outer(times, rate), times)[1]

    def _sides(self, bundle: Bundle, time: float) -> dict[str, tuple]:
        """Tangents, row and rate of the state on both sides of an event, and derivatives of its time.

        The run with tangents meets it at the same time to within the tolerance: each side is continued to
        there from two places, by a line.
        """
        aside, sides = max(ASIDE, ROOM * self.rtol) * self.model.period, {}
        for side, places in (("before", (-2, -1)), ("after", (2, 1))):
            looked = {}
            for place in sorted(places):
                self._advance(bundle, min(max(time + place * aside, bundle.time), self.end))
                looked[place] = bundle.vectors, bundle.recorded, bundle.rate()
            far, near = (looked[place] for place in places)
            sides[side] = tuple(2 * b - a for a, b in zip(far, near, strict=True))
        y, _, rate = sides["before"]
        n_x, h = len(rate), bundle.tangents.gradient
        times = -(y @ h[1 : 1 + n_x] + h[1 + n_x :]) / (h[0] + h[1 : 1 + n_x] @ bundle.tangents.before)
        return {side: (*found, times) for side, found in sides.items()}

    def _here(self, row: np.ndarray, key: str, dx: np.ndarray, dt: np.ndarray) -> tuple[float, np.ndarray]:
        value = float(values(self.model, row[None, :], key)[0])
        return value, derivatives(self.model, row, key, dx, dt, self.directions)

    def _at_end(self, bundle: Bundle, begin: np.ndarray, wanted: list[Quantity]) -> dict[Quantity, tuple]:
        rate, y = bundle.rate(), bundle.vectors
        times = self.turns * self.directions.periods
        if self.place is not None:
            times = -y[:, self.place] / rate[self.place]
        dx, row, found = y + np.outer(times, rate), bundle.recorded, {}
        names = powers(self.model.structure)[: len(bundle.motion.work)]
        works = dict(zip(names, zip(bundle.motion.work, _works(bundle, times).T, strict=True), strict=True))
        if self.model.links and self.model.walls and works:  # impacts are no power's integral
            ends = (row, dx, times), (begin, self.directions.starts, 0 * times)
            works["joints"] = works["joints"][0], self._by_balance(works, *ends)
        for each in wanted:
            if each.how == "time":
                found[each] = self.end, times
            elif each.how == "work":
                found[each] = works[each.key]
            else:
                found[each] = self._here(row, each.key, dx, times)
        return found

    def _by_balance(self, works: dict[str, tuple], after: tuple, before: tuple) -> np.ndarray:
        """Derivatives of the joints' work: the remainder of the energy balance."""
        slope = sum(WORK[word][1] * rates for word, (_, rates) in works.items() if word != "joints")
        for sign, (row, dx, dt) in ((-1, after), (1, before)):
            slope = slope + sign * sum(self._here(row, key, dx, dt)[1] for key in ENERGIES)
        return slope


def _works(bundle: Bundle, times: np.ndarray) -> np.ndarray:
    if not len(bundle.motion.work):
        return np.zeros((len(times), 0))
    return bundle.works + np.outer(times, bundle.powers())


def nearness(run: Run) -> tuple[float, float, float]:
    """Slowest beginning of a contact, time between events of two contacts, gap left in flight.

    The smallest over the fastest, the period, and the clearance (of a test system 1); infinite where there
    are none. Events that can change places without a difference do not count, nor do those that others
    have brought about.
    """
    model = run.model
    request = Request(run.end, run.rtol, events=True, misses=True, log_from=0.0, max_steps=run.limit)
    records = follow(model, request)
    events, misses = records.events, records.misses
    order = events[np.argsort(events[:, 2], kind="stable")]
    free = _exchangeable(model, order)
    apart = np.sort(np.diff(order[:, 2])[(np.diff(order[:, 0]) != 0) & ~(free[1:] & free[:-1])])
    apart = apart[min(records.followed, np.sum(apart == 0.0)) :]
    units = np.array(model.clearances or np.ones(len(model.joints) + len(model.resets)))
    soft = len(model.structure.soft_joints if model.links else model.joints)
    centred = np.isfinite(clearances_squared(model, soft))
    units[:soft] *= np.where(centred, 2 * units[:soft], 1.0)  # r^2 - e^2 is watched
    shares = np.abs(misses[:, 1]) / units[misses[:, 0].astype(int)]
    speeds = approach_speeds(model, np.insert(events, PLACE, 0.0, axis=1))[np.isin(events[:, KIND], BEGINS)]
    slowest = float(np.nanmin(speeds / np.nanmax(speeds, initial=0.0), initial=np.inf))
    nearest, closest = (float(np.min(each, initial=np.inf)) for each in (apart / model.period, shares))
    return slowest, nearest, closest


def _exchangeable(model: Model, events: np.ndarray) -> np.ndarray:
    """Whether each event is that of a gap alone, at which a force begins or ends that adds to the others.

    Two of these have one saltation matrix in either order: that of both is I plus both jumps of the rate, as
    a gap does not depend on speeds, and no force on what another contact does unless something sticks.
    """
    from jointplay.solver.method.modes import PULLS

    if not model.links:
        return np.zeros(len(events), dtype=bool)
    flags = np.array([*cache.structure_module(model.structure).CONTACTS.values()], dtype=int)
    pulls = np.append(flags & PULLS > 0, np.zeros(len(model.walls), dtype=bool))[events[:, 0].astype(int)]
    modes = events[:, 3 + len(model.state) :][:, : len(flags)]
    gap = np.isin(events[:, KIND], (Event.CONTACT, Event.SEPARATION))
    return pulls & gap & ~np.any(modes == Mode.STICK, axis=1)


class Peak(NamedTuple):
    """Time of an extreme value, its place (``within`` a piece, ``before`` an event, …), and its size."""

    time: float
    where: str
    value: float


def peak(model: Model, key: str, sign: float, end: float, turns: float, rtol: float, limit: int) -> Peak:
    """The largest value of sign times a quantity from time 0 to `end`.

    Raises
    ------
    ArithmeticError
        With the status, if the motion did not get there.
    """
    times = np.linspace(0.0, end, max(int(turns * SAMPLES), CLOSER))
    for _ in range(ROUNDS):
        records = _followed(model, end, rtol, times, limit)
        rows = in_order(records.steps[:, 2:], records.samples)
        found = sign * values(model, rows, key)
        top = int(np.nanargmax(found))
        at = float(rows[top, 0])
        margin = (times[-1] - times[0]) / len(times) / 2  # where a sample or a step does not bound the top
        samples, events = records.samples[:, 0], records.events[:, 2]
        marks = np.concatenate([samples[abs(samples - at) > margin], events])
        low, high = marks[marks < at].max(initial=0.0), marks[marks > at].min(initial=end)
        times = np.unique(np.append(np.linspace(low, high, CLOSER), at))
    if np.any(records.events[:, 2] == at):
        sides = sign * values(model, records.steps[records.steps[:, 2] == at, 2:], key)
        first, last = np.abs(sides[[0, -1]] - found[top])
        return Peak(at, "before" if first <= last else "after", sign * float(found[top]))
    if at in (0.0, end):
        return Peak(at, "start" if at == 0.0 else "end", sign * float(found[top]))
    samples = _followed(model, end, max(SHARPER * rtol, LEAST), times, limit).samples
    place, most = _top(samples[:, 0], sign * values(model, samples, key), at)
    if abs(most - found[top]) > UNLIKE * abs(found[top]):  # another motion: this one depends on the tolerance
        place, most = at, found[top]
    return Peak(place, "within", sign * most)


def _followed(model: Model, end: float, rtol: float, times: np.ndarray, limit: int) -> Records:
    fields = {"steps": True, "events": True, "log_from": 0.0, "max_steps": limit}
    return selection.reached(follow(model, Request(end, rtol, at=times, **fields)))


def _top(times: np.ndarray, found: np.ndarray, guess: float) -> tuple[float, float]:
    """Time and size of the largest value of the polynomial through the samples; the guess's if outside."""
    middle, half = (times[0] + times[-1]) / 2, (times[-1] - times[0]) / 2
    fit = np.polynomial.Polynomial.fit(times, found, DEGREE)
    roots = fit.deriv().roots()
    inside = np.real(roots[(abs(roots.imag) < 1e-6 * half) & (abs(roots.real - middle) <= half)])
    place = float(max(inside, key=fit, default=guess))
    return place, float(fit(place))


def values(model: Model, rows: np.ndarray, key: str) -> np.ndarray:
    """A quantity at rows (time, positions, speeds, modes)."""
    quantities = Quantities(model, rows, rows[0])
    found = outputs.evaluate(quantities.module, [key], quantities.given(rows))[key]
    return np.broadcast_to(found, len(rows))


def derivatives(
    model: Model, row: np.ndarray, key: str, dx: np.ndarray, dt: np.ndarray, directions: Directions
) -> np.ndarray:
    """Derivatives of a quantity at a row, as the state moves by dx (directions, states) and time by dt."""
    quantities = Quantities(model, row[None, :], row)
    module, given = quantities.module, dict(quantities.given(row[None, :]))
    for name, moves in zip(module.STATE, np.column_stack([dt, dx]).T, strict=True):
        given[name] = given[name] + 1j * STEP * moves
    for j, (names, rates) in enumerate(zip(directions.names, directions.rates_of, strict=True)):
        unit = 1j * STEP * (np.arange(len(dx)) == j)
        given |= {name: given[name] + unit * rate for name, rate in zip(names, rates, strict=True)}
    given |= {"atan2": _atan2, "copysign": lambda size, of: np.copysign(size, np.real(of))}
    found = outputs.evaluate(module, [key], given)[key]
    return np.broadcast_to(np.imag(found) / STEP, len(dx))


def _atan2(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    a, b = np.real(x), np.real(y)
    return np.arctan2(b, a) + 1j * (a * np.imag(y) - b * np.imag(x)) / (a * a + b * b)
