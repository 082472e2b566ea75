"""Stress: scenes far outside ordinary use, each run twice, and the judgement of the answers.

Ranges: stiffness 10⁴ … 10¹¹ N/m, damping 0 … 10⁵ N s/m, clearance 10⁻⁷ … 3·10⁻³ m, gear ratio 0.2 … 60,
friction 0 … 1.5, links from thin and long to thick and short, dead centres and change points, starts deep in
contact, at rest, or far from the nominal speed, with and without tension and an elastic coupler; other laws
of contact, and other mechanisms with springs, loads and a run-up (`jointplay_lab.stress.others`).

The verdict on a run follows from a second one with a tighter tolerance. ``ok``: both reached the end, their
energy balances closed, their states and contacts agree. ``sensitive``: likewise, but the states differ by
more, as errors of the size of the tolerance grow to in this motion (`growth`): it is chaotic, or stiff, or at
a dead centre. ``stopped``: both ended early with a status that names the reason. ``unconfirmed``: one of them
did. ``suspect``: energy is unaccounted for, or states or contacts differ by more than that; nothing told so
but this comparison. Runs that stopped are held to the same, as far as both came. Slipping and sticking are
not compared as events: where they matter the states tell.

One run of a model: its states, energy balance, events and cost; and the growth of small differences.

The largest growth is the measure of a disagreement of two runs. Each step adds an error of its own, and the
flow carries it on. So what counts are growths between any two times: with Phi_k the flow's derivative over
block k, jumps at events included, the norms of Phi_j ... Phi_i, i <= j: the largest, or if it is more a tenth
of their sum over i, since errors of that size in all blocks add up. The frame of unit tangents starts anew
with each block, so that none of it is lost to the fastest direction. What grows and is ended by an event (the
onset of sticking) within a block does not show: shorter blocks show it. Rest on rigid walls takes from the
derivatives what it does not take from the motion: there the difference of a twin tells.

At equal times two runs differ by a whole jump of the speeds where only one of them has met an impact yet. So
impacts are counted, on each rigid wall since something last came to rest there.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.evaluate import Quantities
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.labels import Out, along, columns
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.analysis.tangents import Bundle, scales, warm_tangents
from jointplay.display import codes
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural
from jointplay.solver.mechanism.model import SPEED_FLOOR, Model
from jointplay.solver.mechanism.records import GROUND, Mechanism
from jointplay.solver.method.codes import COUNTERS
from jointplay.solver.motion.trajectory import Records, Request, follow
from jointplay.study.toml_text import written
from jointplay_lab.stress.others import secant
from jointplay_lab.stress.ranges import GEOMETRIES
from jointplay_lab.stress.scenes import (
    FOUR_BARS,
    STARTS,
    VARIANTS,
    Case,
    draw,
    not_drawable,
    unknown_variants,
)

VERDICTS = ("ok", "sensitive", "stopped", "unconfirmed", "suspect")
CAUSES = ("none", "states", "energy", "contacts")
AGREE = 1e2  # disagreement of states that needs no explanation, in units of the tolerance
GROWN = 1.0  # error that grows, in units of the tolerance: some 0.01 of it is what steps are found to make
CLOSED = 1e2  # energy residual, relative to what flowed, in units of the tolerance
SLIGHT = 100.0  # speed of a contact that only one run has met, in units of the states' disagreement; or the
# square root of that: where a force or gap just touches zero, contacts appear with such a speed
# Of the growth: whether of the tighter run, which alone may show what the other steps over; and how many
# times shorter its blocks are, as is needed for growth that an event soon ends. Where bodies come to rest on
# rigid walls, derivatives lose what the motion keeps: what a twin of the tighter run shows (0) comes last
LOOKS = (*((tighter, closer) for tighter in (False, True) for closer in (1, 4, 16)), (True, 0))
SATURATED = 0.1  # grown errors beyond which the runs are two motions, with contacts of their own
LEVELS = np.concatenate([[0.0], np.logspace(-12, 0, 49)])  # of speeds
COMPARED = tuple(EVENTS.index(name) for name in ("contact", "separation"))  # reopenings are rounding's
TIGHTER = 1e-2  # tolerance of the second run, relative to the first's
PATIENCE = 4  # steps that the second run may take, relative to the first's
GROWING = 2  # likewise with differences, relative to that without
TURNS, MAX_STEPS, LISTED = 2, 100_000, 10
LOOKED = 500  # scenes that are looked through for structures to compile
JUDGED = {  # in the answers of cells; a scene that crashed is suspect
    "verdict": Out((), "what the two runs say", flags=VERDICTS, missing="suspect"),
    "cause": Out((), "what makes a scene suspect", flags=CAUSES, missing="none"),
    "scene_status": Out((), "how the run ended", flags=STATUS, missing="not_run"),
    "tight_status": Out((), "how the tighter run ended", flags=STATUS, missing="not_run"),
    "excess": Out((), "distance from what can be explained, over its bound"),
    "disagreement": Out((), "largest difference from the tighter run, in units of the states' sizes"),
    "growth": Out((), "largest growth of a small difference; NaN where it was not needed"),
    "energy_residual": Out((), "energy unaccounted for, over what flowed"),
    "tight_energy_residual": Out((), "energy unaccounted for in the tighter run, over what flowed"),
    "turns": Out((), "nominal turns reached"),
    "wall_time": Out((), "wall time of a nominal turn; NaN where none was reached", "s"),
    "cpu_time": Out(
        (), "processor time of a nominal turn, free of what else runs; NaN where none was reached", "s"
    ),
    **{name: Out((), text, missing=-1) for name, text in COUNTERS.items()},
    "tight_n_steps": Out((), "accepted steps of the tighter run", missing=-1),
    "trouble": Out((), "what went wrong, where something did", "", missing=""),
}
DRAWN = {
    "stiffness": Out((), "contact stiffness; of laws with a power that at a tenth of the clearance", "N m-1"),
    "damping": Out((), "contact damping", "N s m-1"),
    "clearance": Out((), "radial clearance", "m"),
    "gear_ratio": Out((), "gear ratio"),
    "friction": Out((), "friction coefficient"),
    "stiffness_number": Out((), "radians of contact vibration in a nominal turn"),
}
WORDS = {
    "variant": Out((), "what parts the scene has", flags=tuple(VARIANTS)),
    "geometry": Out((), "where its links lie at the start", flags=GEOMETRIES),
    "start": Out((), "where its journal lies at the start", flags=STARTS),
    "contact_law": Out((), "law of contact of its joints with clearance", flags=tuple(LAWS)),
    "friction_law": Out((), "law of friction of its joints with clearance", flags=("none", *FRICTIONS)),
}
LISTS = {"slowest": "cpu_time", "worst": "excess"}  # by which scenes are listed
ROW = "{:>8}  {:<12} {:<14} {:<19} {:<18} {:<7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>8}"
HEAD = ("scene", "verdict", "status", "variant", "geometry", "start")

SAMPLES = 48  # a nominal turn, at which runs are compared
FLOWS = ("energy_residual", "drive_work", "joint_work", "structural_work", "kinetic_energy")
OK = STATUS.index("ok")
IMPACT, REST = (EVENTS.index(name) for name in ("impact", "rest"))
BLOCKS = 24  # a nominal turn, and at least in a run
BEYOND = 1e12  # growth at which it is not followed further
ADDED = 0.1  # share of a growth that the errors of each block make, beside the one that makes all of it
SOLVED = 1e-6  # tolerance of the tangents' iteration: their size is wanted, not their digits

HEAD += ("K (N/m)", "C (N s/m)", "differ", "growth", "energy", "ms per turn", "excess")


CODES = ("verdict", "scene_status", "variant", "geometry", "start")


FIGURES = ("stiffness", "damping", "disagreement", "growth", "energy_residual", "cpu_time", "excess")


def answer(dataset: xr.Dataset) -> str:
    """Counts of verdicts and statuses of a stress study, its slowest and its worst scenes."""
    ok, times = dataset["scene_status"].values == 0, dataset["cpu_time"].values
    median = float(np.nanmedian(times)) if np.isfinite(times).any() else np.nan
    slow = int(np.count_nonzero(ok & (times > 100 * median)))
    lines = [f"{dataset.sizes['scene']} scenes: {_counts(dataset['verdict'])}"]
    lines.append(f"ended with {_counts(dataset['scene_status'])}")
    lines.append(
        f"processor time of a turn: median {1e3 * median:.3g} ms; {slow} that ended ok took over 100 times it"
    )
    for word in LISTS:
        rows = (_row(dataset.sel(scene=number)) for number in dataset[word].values)
        lines += ["", word, ROW.format(*HEAD), *rows]
    return "\n".join(line.rstrip() for line in lines) + "\n"


def table(dataset: xr.Dataset) -> str:
    """The same, and a study file of each scene listed."""
    listed = {
        int(number): str(text)
        for word in LISTS
        for number, text in zip(dataset[word].values, dataset[f"{word}_lines"].values, strict=True)
    }
    files = (f"# {'-' * 30} scene-{number}.toml\n{text}" for number, text in listed.items())
    return "\n".join([answer(dataset), *files])


def _counts(array: xr.DataArray) -> str:
    numbers = ((int(np.count_nonzero(array.values == i)), word) for i, word in codes.flags(array).items())
    return ", ".join(f"{number} {word}" for number, word in numbers if number)


def _row(one: xr.Dataset) -> str:
    words = (codes.words(one[name]).item() for name in CODES)
    scale = {"cpu_time": 1e3}
    figures = (_figure(float(one[name]) * scale.get(name, 1.0)) for name in FIGURES)
    return ROW.format(int(one["scene"]), *words, *figures)


def _figure(value: float) -> str:
    return f"{value:.1e}" if np.isfinite(value) else "-"


OUTPUTS = Outputs(
    "stress",
    {"scene": Out("scene", "number of the scene")},
    along(JUDGED | DRAWN | WORDS, "scene")
    | {
        f"{word}{end}": Out("rank", f"{what} of the {word} scenes", units)
        for word in LISTS
        for end, what, units in (("", "number", "1"), ("_lines", "study files", ""))
    }
    | {"status": Out((), "ok unless a scene crashed", flags=STATUS)},
    answer,
    table=table,
)


# Recorded by the study that runs a scene again
RECORD = ("mode", "penetration", "normal_velocity", "tangential_velocity", "normal_force", "energy_residual")


@analysis(not_drawable, unknown_variants, usual={"max_steps": MAX_STEPS}, outputs=OUTPUTS)
def stress(
    mechanism: Moving | None = None,
    *,
    scenes: Natural = 100,
    first: Count = 0,
    seed: Count = 0,
    variants: listed(str, f"a list of variants: {', '.join(VARIANTS)}") = FOUR_BARS,
    turns: Natural = TURNS,
    listed: Natural = LISTED,
    n_jobs: Natural | None = None,
    **motion: Unpack[Integration],
) -> xr.Dataset:
    """Run scenes drawn from wide ranges, each at two tolerances, and judge the first run by the second.

    Parameters
    ----------
    mechanism : Mechanism, optional
        A motor-driven four-bar whose numbers are changed; the catalog's `chunmei2002` if left out.
    scenes : int
        Number of scenes; the first 64 of a series are its corners.
    first : int
        Number of the first scene in the series.
    seed : int
        Seed of the random numbers from which a series is drawn.
    variants : sequence of str
        Variants of the mechanism, of which each scene has one; their names are those of `VARIANTS`.
    turns : int
        Number of nominal turns of each run.
    rtol : float
        Relative tolerance of the run that is judged; the second has a hundredth of it.
    max_steps : int, optional
        Number of attempted steps after which the first run stops; the second may take four times as many.
    listed : int
        How many of the slowest scenes, and of the worst, are listed with the lines of a study that run them
        again.
    n_jobs
        As in `readings`.

    Raises
    ------
    InputError
        Listing what does not fit.
    """
    printed = catalog.chunmei2002() if mechanism is None else mechanism
    limit = MAX_STEPS if motion["max_steps"] is None else motion["max_steps"]
    settings = {"seed": seed, "variants": tuple(variants), "turns": turns}
    settings |= {"rtol": motion["rtol"], "max_steps": limit}
    cells = [{"printed": printed, "number": first + k} | settings for k in range(scenes)]
    _warm(cells)
    answers = handed_out(cell, cells, motion["progress"], n_jobs)
    return dataset(printed, range(first, first + scenes), settings, answers, listed)


def cell(
    printed: Mechanism,
    number: int,
    seed: int,
    variants: tuple[str, ...],
    turns: int,
    rtol: float,
    max_steps: int,
) -> dict[str, Any]:
    """Draw one scene, run it twice, judge it."""
    case = draw(printed, number, seed, variants)
    scene = model_of(case)
    warm([scene])  # what that costs is no part of its time
    loose = move(scene, turns, rtol, max_steps)
    tight = move(scene, turns, TIGHTER * rtol, PATIENCE * max_steps)
    unit, common = sizes(scene, tight), min(loose.turns, tight.turns)

    def growth(tighter: bool, closer: int) -> float:
        if not closer:
            kicked = kick(scene, TIGHTER * rtol * unit)
            twin = move(kicked, turns, TIGHTER * rtol, PATIENCE * max_steps)
            return disagreement(upto(twin, loose), tight, unit) / (TIGHTER * rtol)
        steps, tolerance = (PATIENCE * max_steps, TIGHTER * rtol) if tighter else (max_steps, rtol)
        plain = assemble(case.mechanism, case.initial)
        return largest_growth(plain, unit, common, tolerance, GROWING * steps, closer)

    answer = asdict(judge(loose, tight, unit, (rtol, TIGHTER * rtol), growth))
    answer |= {"verdict": VERDICTS.index(answer["verdict"]), "cause": CAUSES.index(answer["cause"])}
    reached = loose.turns or math.nan
    answer |= {"status": loose.status, "turns": loose.turns} | loose.counts
    answer |= {"energy_residual": loose.residual if loose.turns else math.nan}
    answer |= {"wall_time": loose.wall_time / reached, "cpu_time": loose.cpu_time / reached}
    answer |= {"tight_energy_residual": tight.residual, "tight_status": tight.status}
    return answer | {"tight_n_steps": tight.counts["n_steps"]}


def model_of(case: Case) -> Model:
    """Assemble a scene, with the work of its parts."""
    return assemble(case.mechanism, case.initial, powers=True)


def _warm(cells: list[dict[str, Any]]) -> None:
    """Compile the scenes' structures, once each, so that workers find them on the disk."""
    drawn = (draw(*(one[key] for key in ("printed", "number", "seed", "variants"))) for one in cells[:LOOKED])
    cases = {model_of(case).structure: case for case in drawn}.values()
    warm(map(model_of, cases))
    for case in cases:
        warm_tangents(assemble(case.mechanism, case.initial))


def dataset(
    printed: Mechanism,
    numbers: Sequence[int],
    settings: dict[str, Any],
    answers: list[dict[str, Any]],
    listed: int,
) -> xr.Dataset:
    """Put a stress study together; `settings` are its cells' settings."""
    cases = [draw(printed, number, settings["seed"], settings["variants"]) for number in numbers]
    answers = [answer | {"scene_status": answer["status"]} for answer in answers]
    values = columns(JUDGED, answers) | columns(DRAWN, [_drawn(case) for case in cases])
    values |= {name: [out.flags.index(getattr(case, name)) for case in cases] for name, out in WORDS.items()}
    for word, key in LISTS.items():
        values |= _listing(word, cases, values[key], settings, listed)
    lost = [STATUS.index(word) for word in ("bad_parameters", "crashed")]
    values["status"] = next((answer["status"] for answer in answers if answer["status"] in lost), 0)
    return OUTPUTS.dataset(values | {"scene": np.array(numbers)}, seed=settings["seed"])


def _drawn(case: Case) -> dict[str, float]:
    """The numbers of a scene that distinguish it in a figure."""
    mechanism = case.mechanism
    joint, drive = mechanism.clearance_joints[0], mechanism.drive
    speed = drive.nominal_speed if drive else case.initial["crank_speed"]
    ends = {joint.journal.link, joint.bearing.link} - {GROUND}
    mass = min(mechanism.link(name).mass for name in ends)
    K, C = (math.nan if x is None else x for x in (joint.contact.stiffness, joint.contact.damping))
    if joint.contact.law != "kelvin_voigt":
        K *= secant(joint)
    return {
        "stiffness": K,
        "damping": C,
        "clearance": joint.clearance,
        "gear_ratio": getattr(mechanism.drive, "gear_ratio", math.nan),
        "friction": joint.friction.coefficient if joint.friction else 0.0,
        "stiffness_number": math.tau * math.sqrt(K / mass) / speed,
    }


def _listing(
    word: str, cases: list[Case], values: np.ndarray, settings: dict, listed: int
) -> dict[str, np.ndarray]:
    """Scenes of the largest values, and their study files; one without a value is the worst, not slow."""
    values = np.nan_to_num(values, nan=np.inf if word == "worst" else 0.0)
    order = np.argsort(-values, kind="stable")[:listed]
    shared = {name: settings[name] for name in ("seed", "turns", "rtol", "max_steps")}
    texts = np.array([study_text(cases[i], **shared) for i in order], dtype=object).astype(str)
    return {word: np.array([cases[i].number for i in order]), f"{word}_lines": texts}


def study_text(case: Case, seed: int, turns: int, rtol: float, max_steps: int) -> str:
    """Write a scene as a study file (TOML) of kind ``response``, with the settings of the stress study."""
    record = case.mechanism.model_dump(exclude_none=True)
    title = f"Scene {case.number} of seed {seed}: {case.variant}, {case.geometry}, {case.start}"
    parts = [_table("", {"kind": "response", "title": title})]
    own = {k: v for k, v in record.items() if not isinstance(v, tuple | dict)}
    own |= {"guess": record["guess"]} if record["guess"] else {}
    parts.append(_table("[mechanism]", own))
    several = ("links", "joints", "springs", "loads")
    parts += [_table(f"[[mechanism.{key}]]", one) for key in several for one in record[key]]
    parts += [_table("[mechanism.drive]", record["drive"])] if "drive" in record else []
    parts.append(_table("[integrator]", {"rtol": rtol, "max_steps": max_steps}))
    parts.append(_table("[analysis]", {"turns": turns, "record": RECORD, "initial": case.initial}))
    return "\n".join(parts)


def _table(head: str, values: Mapping[str, Any]) -> str:
    lines = [*[head] * bool(head), *(f"{key} = {written(value)}" for key, value in values.items())]
    return "".join(f"{line}\n" for line in lines)


@dataclass(frozen=True)
class Verdict:
    """A verdict on a scene.

    Parameters
    ----------
    verdict : str
        Of `VERDICTS`.
    cause : str
        Of `CAUSES`: what was farthest from what can be explained; ``none`` where that is within its bound.
    excess : float
        How far, in units of that bound.
    disagreement : float
        Largest difference of the states at equal times, in units of their sizes.
    growth : float
        Largest growth of a small difference; NaN where it was not needed.
    """

    verdict: str
    cause: str
    excess: float
    disagreement: float
    growth: float


def judge(
    loose: Motion,
    tight: Motion,
    unit: np.ndarray,
    tolerances: tuple[float, float],
    growth: Callable[[bool, int], float],
) -> Verdict:
    """Judge a run by one at a tighter tolerance; `unit` holds the size of each state.

    Where the states differ, `growth` is called for the largest growth of small differences, along this run
    or the tighter one, in blocks so many times shorter; again where that does not explain the difference,
    at last for that of a twin (see `LOOKS`).
    """
    rtol = tolerances[0]
    apart, grown, allowed = disagreement(loose, tight, unit), np.nan, AGREE * rtol
    for look in LOOKS:
        if apart <= allowed or not np.isfinite(apart):
            break
        grown = float(np.fmax(grown, growth(*look)))
        allowed = max(allowed, GROWN * rtol * np.nan_to_num(grown, nan=1.0))
    energy = max(m.residual / (CLOSED * t) for m, t in zip((loose, tight), tolerances, strict=True))
    found = {"states": apart / allowed, "energy": energy, "contacts": 0.0}
    whole = loose.status == tight.status == OK
    if whole and allowed < SATURATED:
        slight = max(SLIGHT * max(apart, AGREE * rtol), math.sqrt(apart))
        found["contacts"] = unmatched(loose, tight) / slight
    cause = max(found, key=lambda name: np.nan_to_num(found[name], nan=np.inf))
    excess = float(found[cause])
    suspect = not excess <= 1.0
    word = "suspect" if suspect else _calm(loose, tight, apart <= AGREE * rtol)
    return Verdict(word, cause if suspect else "none", excess, apart, float(grown))


def _calm(loose: Motion, tight: Motion, agreeing: bool) -> str:
    """The verdict where no difference is suspect."""
    if loose.status != OK and tight.status != OK:
        return "stopped"
    if loose.status != OK or tight.status != OK:
        return "unconfirmed"
    return "ok" if agreeing else "sensitive"


def disagreement(one: Motion, other: Motion, unit: np.ndarray) -> float:
    """Largest difference of the states at the samples that both reached, in units of their sizes.

    Of positions alone where only one run has met an impact on a rigid wall yet, which makes the speeds jump.
    """
    n = min(len(one.states), len(other.states))
    apart = np.abs(one.states[:n] - other.states[:n]) / unit
    between = np.any(one.met[:n] != other.met[:n], axis=1)
    return float(max(np.max(apart[:, : one.positions], initial=0.0), np.max(apart[~between], initial=0.0)))


def unmatched(one: Motion, other: Motion) -> float:
    """Normal speed up to which beginnings and ends of contact must be left out for two runs to have the same.

    In units of the largest met, or of the journal's surface speed if that is larger; 0 where none must. Each
    contact by itself: which of two comes first, where they touch together, is rounding's.
    """
    chosen = [motion.events[np.argsort(motion.events[:, 0], kind="stable")] for motion in (one, other)]
    chosen = [events[np.isin(events[:, 1], COMPARED)] for events in chosen]
    largest = max(1.0, float(np.max(np.abs(np.concatenate(chosen)[:, 2]), initial=0.0)))
    for level in LEVELS:
        kept = [events[np.abs(events[:, 2]) >= level * largest, :2] for events in chosen]
        if np.array_equal(*kept):
            return float(level)
    return 1.0


@dataclass(frozen=True)
class Motion:
    """A run of a model.

    Parameters
    ----------
    status : int
        How it ended, of `STATUS`.
    states : ndarray, shape (samples, states)
        Positions and speeds at the samples that it reached.
    positions : int
        How many of the states are positions.
    met : ndarray, shape (samples, joints)
        Impacts on each rigid wall since something last came to rest there.
    events : ndarray, shape (events, 3)
        Joint, kind and normal speed of each event, over that of the journal's surface at the nominal speed.
    residual : float
        Largest energy unaccounted for, over the energy that flowed.
    counts : dict
        Steps and evaluations.
    wall_time, cpu_time : float
        s.
    turns : float
        Nominal turns that it reached.
    """

    status: int
    states: np.ndarray
    positions: int
    met: np.ndarray
    events: np.ndarray
    residual: float
    counts: dict[str, int]
    wall_time: float
    cpu_time: float
    turns: float


def move(model: Model, turns: int, rtol: float, max_steps: int) -> Motion:
    """Follow a model, assembled with the work of its parts, over nominal turns."""
    end = turns * model.period
    times = np.linspace(0.0, end, turns * SAMPLES + 1)
    began = time.thread_time()
    records = follow(model, Request(end, rtol, at=times, log_from=0.0, events=True, max_steps=max_steps))
    rows, spent = records.samples, time.thread_time() - began
    return Motion(
        records.status,
        rows[:, 1 : 1 + len(model.state)],
        len(model.turning),
        _met(records, rows[:, 0], len(model.touching)),
        _events(model, records),
        residual(model, records),
        records.counts,
        records.wall_time,
        spent,
        float(rows[-1, 0] / model.period) if len(rows) else 0.0,
    )


def _met(records: Records, times: np.ndarray, joints: int) -> np.ndarray:
    """Impacts on each rigid wall up to these times, since something last came to rest there."""
    rows, found = records.events[np.argsort(records.events[:, 2], kind="stable")], []
    for joint in range(joints):
        kinds, at = rows[rows[:, 0] == joint][:, 1:3].T
        hits, rests = (np.concatenate([[0], np.cumsum(kinds == kind)]) for kind in (IMPACT, REST))
        since = hits - np.maximum.accumulate(np.where(np.diff(rests, prepend=0) > 0, hits, 0))
        found.append(since[np.searchsorted(at, times, side="right")])
    return np.reshape(found, (joints, len(times))).T


def _events(model: Model, records: Records) -> np.ndarray:
    """Joint, kind and normal speed of each event, that speed over the journal's at nominal speed."""
    rows = records.events
    if not len(rows):
        return np.zeros((0, 3))
    of = rows[:, 0].astype(int)
    speeds = Quantities(model, rows[:, 2:], records.start).variables(["normal_velocity"], "event")
    speed = speeds["normal_velocity"][1][np.arange(len(of)), of]
    return np.stack([of, rows[:, 1], speed * SPEED_FLOOR / model.creep], -1)


def sizes(model: Model, motion: Motion) -> np.ndarray:
    """Size of each state: its scale, or the largest that it grew to."""
    scale = scales(model)
    return np.maximum(scale, np.max(np.abs(motion.states), axis=0, initial=0.0))


def residual(model: Model, records: Records) -> float:
    """Largest energy residual at the samples, over the energy that flowed to and fro between them."""
    names = [name for name in FLOWS if name != "structural_work" or model.bending]
    history = Quantities(model, records.samples, records.start)
    found = {name: value for name, (_, value, _) in history.variables(names, "time").items()}
    works = (found[name] for name in names if name.endswith("_work"))
    flowed = sum(float(np.abs(np.diff(work)).sum()) for work in works)
    flowed += float(np.max(found["kinetic_energy"], initial=0.0))
    largest = float(np.max(np.abs(found["energy_residual"]), initial=0.0))
    return largest / flowed if flowed > 0.0 else largest


def kick(model: Model, difference: np.ndarray) -> Model:
    """The model with other speeds at its start, where the gaps and loops are as they were."""
    speeds = np.arange(len(model.state)) >= len(model.turning)
    return replace(model, state=model.state + np.where(speeds, difference, 0.0))


def upto(motion: Motion, other: Motion) -> Motion:
    """A motion as far as another one came."""
    n = len(other.states)
    return replace(motion, states=motion.states[:n], met=motion.met[:n])


def largest_growth(
    model: Model, unit: np.ndarray, turns: float, rtol: float, max_steps: int, closer: int = 1
) -> float:
    """Return the largest growth, at least 1, of a small difference between any two times of a run.

    Or, if it is more, what a tenth of one made in each block of usual length adds up to. Differences are in
    units of the states' sizes `unit`. Blocks are `closer` times shorter than usual: growth that an event soon
    ends shows in short ones only. If the run stops, the part before counts.
    """
    end, n_x, whole = turns * model.period, len(unit), np.eye(len(unit))
    request = Request(end, rtol, max_steps=max_steps)
    bundle = Bundle(model, request, np.diag(unit), tolerance=SOLVED, held=True)
    products, largest = np.zeros((0, n_x, n_x)), 1.0
    for until in np.linspace(0.0, end, closer * max(BLOCKS, round(turns * BLOCKS)) + 1)[1:]:
        bundle.tangents.d.reshape(n_x, -1)[:] = np.diag(unit, 1)[:n_x]
        status = bundle.advance(until)
        block = (bundle.vectors / unit).T
        if not np.all(np.isfinite(block)):
            return largest
        products = block @ np.concatenate([products, whole[None]])
        norms = np.linalg.norm(products, 2, axis=(1, 2))
        largest = max(largest, float(np.max(norms)), ADDED / closer * float(np.sum(norms)))
        if status or largest > BEYOND:
            return largest
    return largest
