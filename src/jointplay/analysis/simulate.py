"""Time histories of a motion, with its events and, if wanted, its section points."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, Unpack

import numpy as np
from pydantic import AfterValidator

from jointplay.analysis import evaluate, recorded_spans, rules
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import (
    MOST,
    OF_A_MODEL,
    Quantities,
    beyond_the_model,
    evaluated,
    joint_flags,
    run_values,
)
from jointplay.analysis.keywords import HANDED, Lasting, Moving, Names, analysis, listed
from jointplay.analysis.labels import Out, xr
from jointplay.analysis.quantities import EVENTS, WORDS
from jointplay.analysis.starts import moved, placed, whole_names
from jointplay.display.errors import Problem, refuse
from jointplay.solver.mechanism.base import FAR, Flag, Natural, NonNegative, Number
from jointplay.solver.mechanism.model import Model
from jointplay.solver.mechanism.records import Mechanism, Section, TestSystem
from jointplay.solver.motion.trajectory import INTERRUPTED, Records, Request, advance, follow, memory

SAMPLES_PER_TURN = 720
WHOLE = 1e-9  # of a period of the forcing, up to which it is over
MOST_WINDOWS = 100
ACCEPTED = f"a list of 1 to {MOST_WINDOWS} pairs of turns, [first, last], from 0 on, ascending and apart,"


def _ascending(times: tuple[float, ...]) -> tuple[float, ...]:
    if any(a > b for a, b in pairwise(times)):
        raise refuse(times, "times in s, ascending, 0 or later, are accepted")
    return times


Times = Annotated[listed(NonNegative, "a list of times in s", units="s"), AfterValidator(_ascending)]


def _apart(windows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    edges = [edge for pair in windows for edge in pair]
    if not 1 <= len(windows) <= MOST_WINDOWS or edges[0] < 0 or any(a >= b for a, b in pairwise(edges)):
        raise refuse(windows, f"{ACCEPTED} is accepted")
    return windows


Windows = Annotated[listed(tuple[Number, Number], ACCEPTED), AfterValidator(_apart)]


def _long_enough(windows: Windows | None, turns: float | None) -> Iterator[Problem]:
    if windows is not None and turns is not None and turns < windows[-1][1]:
        expected = f"at least {windows[-1][1]:g}, where the last window ends, is accepted"
        yield Problem("turns", turns, expected)


def _excluded_by_windows(windows: Windows | None, **other: Any) -> Iterator[Problem]:
    for key, given in other.items():
        if windows is not None and given is not None and given != 0:
            yield Problem(key, given, f"either windows or {key} is accepted, not both")


WINDOW = Out("time", "window of the sample, counted from 0")
WINDOW_RULES = (  # rules of which keywords of `simulate` are accepted beside windows
    _long_enough,
    lambda windows, duration: _excluded_by_windows(windows, duration=duration),
    lambda windows, transient: _excluded_by_windows(windows, transient=transient),
    lambda windows, at: _excluded_by_windows(windows, at=at),
    lambda windows, steps: _excluded_by_windows(windows, steps=steps),
    lambda windows, section: _excluded_by_windows(windows, section=section),
)


def sample_times(windows: Windows, period: float, samples_per_turn: int) -> tuple[np.ndarray, np.ndarray]:
    """Times of evenly spaced samples, s, from end to end of each window, and the number of its window."""
    counts = [max(1, math.ceil((last - first) * samples_per_turn - 1e-9)) for first, last in windows]
    times = [period * np.linspace(*window, count + 1) for window, count in zip(windows, counts, strict=True)]
    number = np.repeat(np.arange(len(windows), dtype=np.int8), [count + 1 for count in counts])
    return np.concatenate(times), number


def marked(dataset: xr.Dataset, number: np.ndarray, windows: Windows, period: float) -> xr.Dataset:
    """The dataset with the window of each sample, and without the events outside of all windows.

    A run that stopped early has fewer samples than `number`, which holds the window of each requested one.
    """
    times = dataset["event_time"].values
    inside = np.any([(a * period <= times) & (times <= b * period) for a, b in windows], axis=0)
    window = WINDOW.variable(number[: dataset.sizes["time"]])
    return dataset.isel(event=np.flatnonzero(inside)).assign(window=window)


def _length_fits(turns: float | None, duration: float | None, windows: Windows | None) -> Iterator[Problem]:
    return rules.length_fits(turns, duration) if windows is None else iter(())


def _within_the_run(
    mechanism: Mechanism | TestSystem, turns: float | None, duration: float | None, transient: float, at: Any
) -> Iterator[Problem]:
    """Yield a problem for the first sample after the end of the run."""
    if at is None or (turns is None) == (duration is None):
        return
    period = rules.nominal_period(mechanism)
    end = transient * period + (turns * period if duration is None else duration)
    late = next((i for i, time in enumerate(at) if time > end * (1 + 1e-12)), None)
    if late is not None:
        yield Problem(f"at[{late}]", at[late], f"at most {end:.9g} s, where the run ends, is accepted")


def _one_way(at: Any, steps: bool, samples_per_turn: int | None) -> Iterator[Problem]:
    """Yield a problem where samples are given in two ways."""
    given = {"at": at, "steps": steps, "samples_per_turn": samples_per_turn}
    choices = [name for name, value in given.items() if value]
    if len(choices) > 1:
        yield Problem(choices[-1], given[choices[-1]], f"only one of {', '.join(choices)} is accepted")


def _samples_fit(
    mechanism: Mechanism | TestSystem,
    turns: float | None,
    duration: float | None,
    windows: Windows | None,
    at: Any,
    steps: bool,
    samples_per_turn: int | None,
) -> Iterator[Problem]:
    if windows is not None:
        turns, duration = turns or windows[-1][1], None
    if at is None and not steps:
        yield from rules.samples_fit(mechanism, turns, duration, samples_per_turn or SAMPLES_PER_TURN)


SPEEDS = ("normal_velocity", "tangential_velocity")
OUTPUTS = Outputs(
    "response",
    {"time": Out("time", "time", "s"), "state": Out("state", "state", "")},
    {"QUANTITY": Out("time", "what `record` asks for", "")}
    | recorded_spans.OUTS
    | {
        "event_time": Out("event", "time of the event", "s"),
        "event_joint": Out("event", "joint of the event, counted from 0"),
        "event_kind": Out("event", "kind of event", flags=EVENTS),
        **{f"event_{name}": Out("event", WORDS[name].long_name, WORDS[name].units) for name in SPEEDS},
        **OF_A_MODEL,
        "section_time": Out("turn", "time of the section point", "s"),
        "section_QUANTITY": Out("turn", "the same at section points", ""),
        "end_state": Out(
            "state",
            "positions and speeds at the end, in rad, m, rad/s, m/s or a system's own units",
            about="as `initial` takes it, over ``end`` where a system has outputs beside its states; NaN "
            "where what starts there would go on otherwise, since time counts, or a switch is as none starts",
        ),
        "window": WINDOW,
    },
    recorded_spans.answer,
    own_states="end",
)


def _started(mechanism: Mechanism | TestSystem, initial: Any, section: Any, names: Any = ()) -> Model:
    return rules.recorded_from(mechanism, initial, section, names, placed)


@analysis(
    _length_fits,
    *WINDOW_RULES,
    _one_way,
    _within_the_run,
    _samples_fit,
    rules.section_fits,
    "names",
    outputs=OUTPUTS,
    left_out=rules.lasting(20, 5),
    model=_started,
)
def simulate(  # noqa: D417 (nobody gives it the model and names)
    mechanism: Moving,
    *,
    model: Model = HANDED,
    names: tuple[str, ...] = HANDED,
    record: Names | None = None,
    samples_per_turn: Natural | None = None,
    windows: Windows | None = None,
    at: Times | None = None,
    steps: Flag = False,
    section: Section | None = None,
    **motion: Unpack[Lasting],
) -> xr.Dataset:
    """Follow a motion and record its time histories.

    Contacts and largest sizes are of the whole time after the transient, or of the windows, whatever is
    sampled. Beyond 2700 turns largest sizes, and forces' extremes between samples, are left out, and where a
    long run was interrupted.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    transient : float
        Number of turns that are followed first and not recorded.
    record : sequence of str, optional
        Names of the quantities to record; the usual ones if left out.
    samples_per_turn : int, optional
        Number of evenly spaced samples in a nominal turn; 720 unless `at` or `steps` is given.
    windows : sequence of pairs of float, optional
        Stretches, each from its first to its last nominal turn counted from the start, of which samples and
        events are kept; the motion ends with the last, or after `turns`. Not beside `transient`, `section`,
        `at`, `steps`.
    at : sequence of float, optional
        Times at which to sample instead, s, counted from the start of the motion; none after its end.
    steps : bool
        Whether to record at the integrator's own points instead, on both sides of every event.
    section : Section, optional
        Where the motion is cut; the points are recorded beside the time histories as ``section_…``.

    Raises
    ------
    InputError
        If anything asked for makes no sense; numerical trouble is a status instead.
    """
    if windows is not None and motion["turns"] is None:
        motion["turns"] = windows[-1][1]
    begin, end = rules.span(model, motion)
    begin = windows[0][0] * model.period if windows else begin
    many = SAMPLES_PER_TURN if samples_per_turn is None else samples_per_turn
    times, number = _times(at, steps, many, begin, end, model.period), None
    spans = [(begin, end)]
    if windows is not None:
        times, number = sample_times(windows, model.period, many)
        spans = [(a * model.period, b * model.period) for a, b in windows]
    even, sized = recorded_spans.even_times(spans, model.period), recorded_spans.sized(names)
    shared = even is not None and np.array_equal(times, even)
    every = times if even is None or shared else np.concatenate([times, even])
    order = np.argsort(every, kind="stable")
    request = Request(
        duration=end,
        rtol=motion["rtol"],
        at=every[order],
        log_from=begin,
        steps=steps or even is not None,
        events=True,
        max_steps=rules.steps(motion["max_steps"]),
        rates=evaluate.needed(model, [*names, *sized]),
        **rules.section_fields(section, model, 0),
    )

    records = follow(model, request, motion["progress"])
    sampled = order[: len(records.samples)] < len(times)
    every_row = records.steps[:, 2:] if steps else records.samples[sampled]

    def labelled_every(records: Records, step: int) -> xr.Dataset:
        rows, parts = every_row[::step], []
        reached = recorded_spans.reached(spans, records)
        hurried = records.status == INTERRUPTED and len(records.samples) + len(records.steps) > MOST
        sought = even is not None and not hurried
        if sought:
            parts = [records.steps[recorded_spans.between(records.steps, model.period), 2:]]
            parts += [] if shared else [records.samples[~sampled]]
        history, *looked = evaluate.together(model, motion["rtol"], records, rows, *parts)
        groups = {"QUANTITY": history.variables(names, "time")}
        if sought:
            own, at_even = looked if len(looked) > 1 else (*looked, history)
            drawn = history.time, groups["QUANTITY"]
            groups |= recorded_spans.extremes(own, at_even, sized, reached, drawn, shared)
        values = {"time": history.time} | recorded_spans.contacts(model, records, reached)
        if section:
            points = records.sections[records.sections[:, 2] >= begin, 2:]
            cut = evaluate.quantities(model, motion["rtol"], records, points)
            values["section_time"] = cut.time
            groups["section_QUANTITY"] = cut.variables(names, "turn", prefix="section_")
        result = _dataset(model, records, history, values, groups)
        return result if number is None else marked(result, number[::step], windows, model.period)

    return evaluated(records, len(every_row), "time", labelled_every)


def _times(at, steps: bool, samples_per_turn: int, begin: float, end: float, period: float) -> np.ndarray:
    """Sample times, s."""
    if steps:
        return np.zeros(0)
    if at is None:
        return recorded_spans.evenly(begin, end, round((end - begin) / period * samples_per_turn))
    return np.minimum(np.asarray(at, dtype=float), end)


def _dataset(
    model: Model, records: Records, history: Quantities, values: dict[str, Any], groups: dict[str, Any]
) -> xr.Dataset:
    """The dataset of a motion."""
    values |= {"end_state": end_state(model, records), "state": np.array(whole_names(model), dtype=str)}
    values |= _events(model, records) | run_values(model, records)
    deepest = history if not len(records.samples) else Quantities(model, records.samples, records.start)
    found = OUTPUTS.dataset(values, model=model, groups=groups, **beyond_the_model(deepest))
    found["event_joint"].attrs |= joint_flags(model)
    return found


def _events(model: Model, records: Records) -> dict[str, Any]:
    """Time, joint and kind of the events, and the speeds at the contact of a linkage."""
    rows = records.events
    joint = rows[:, 0].astype(np.int16)
    values = {"event_time": rows[:, 2], "event_joint": joint, "event_kind": rows[:, 1]}
    if model.links and model.joints:
        speeds = Quantities(model, rows[:, 2:], records.start).variables(SPEEDS, "event")
        for name in SPEEDS:
            values[f"event_{name}"] = speeds[name][1][np.arange(len(joint)), joint]
    return values


def end_state(model: Model, records: Records) -> np.ndarray:
    """State at the end, as `starts.placed` takes it; NaN where a run that starts there would go on otherwise.

    So it is where the time counts (of a forced system unless periods are over), and where a contact or a
    switch is in a mode that no start has there. Whole turns beyond what a start may have are taken off.
    """
    n_x, time = len(model.state), records.end[0]
    state, angle = records.end[1 : 1 + n_x], model.crank_angle + model.crank_speed * time
    found = np.append(state, angle)[: len(whole_names(model))]
    foldable = np.zeros(len(found), dtype=bool)
    foldable[: len(model.fold)] = model.fold
    foldable[n_x:] = model.links and not model.structure.springs  # which may be wound up
    far = foldable & (np.abs(found) > FAR)
    found[far] -= math.tau * np.round(found[far] / math.tau)
    goes_on = np.isfinite(found).all() and _starts_anew(model, time) and _alike(model, records)
    return found if goes_on else np.full_like(found, np.nan)


def _starts_anew(model: Model, time: float) -> bool:
    """Whether the time that has passed is of no account."""
    from jointplay.analysis.exponents.frame_growth import has_no_clock  # no exponents are needed before

    if has_no_clock(model):
        return True
    if not model.links:
        return math.isclose(time / model.period, round(time / model.period), abs_tol=WHOLE)
    structure = model.structure
    return structure.drive == "speed" and not any(load.course.timed for load in structure.loads)


def _alike(model: Model, records: Records) -> bool:
    """Whether contacts and switches begin there in the modes in which they are."""
    n_x, time = len(model.state), float(records.end[0])
    work, motion, options = memory(moved(model, records.end[1 : 1 + n_x]), Request(time))
    motion.s[0] = time
    advance(model.structure, work, motion, options)
    return bool(np.all(motion.modes == records.end[1 + n_x :][: len(motion.modes)]))
