"""Bifurcation diagrams: the motions that a mechanism settles to, over one parameter or two.

At each value the motion is followed until it has settled, and then described. Upward and downward sweeps
start each point from where the motion of its neighbour stands, so that they stay on an attractor as long as
it exists: where they differ, motions coexist. A reset sweep starts each point from the same state. Period by
the spread of section points (analysis.period), contacts from located events, exponents by tangents with
saltation (analysis.exponents.lyapunov). Reference: Parker and Chua, Practical Numerical Algorithms for
Chaotic Systems (1989), chapter 8; Thompson and Stewart, Nonlinear Dynamics and Chaos (2002).

Validity: a sweep shows attractors only, those that its starts lead to, and a transient that dies out more
slowly than the turns dropped shows as no period.

Adaptive maps of settled motions: points of a reset sweep that are computed where their neighbours differ.

Two points differ where one failed, where their periods differ, where only one has an exponent, or where their
leading exponents per turn are apart by more than `contrast` and by more than three standard errors of the
difference; `subdivision` says what follows from that. Points have the keys that they have in the whole
sweep: a journal of the one is of use to the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, combinations, pairwise
from math import hypot, isfinite
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, Unpack

import numpy as np
from pydantic import BeforeValidator

from jointplay.analysis import rules
from jointplay.analysis.cells import Read, Work, answered
from jointplay.analysis.declared import Outputs
from jointplay.analysis.exponents.batch_means import CHAOTIC, judged
from jointplay.analysis.keywords import Batched, Moving, Names, Starts, analysis, as_list, as_several
from jointplay.analysis.labels import PLANE, Out, along, xr
from jointplay.analysis.quantities import recorded
from jointplay.analysis.rules import assembled_at, each_alike, quantity
from jointplay.analysis.starts import placed
from jointplay.analysis.sweeps import attractor, chains, gather, subdivision
from jointplay.analysis.sweeps.attractor import RTOL, Plan
from jointplay.analysis.sweeps.chains import BLOCK, DIRECTIONS, TOGETHER, Chain, Sweep
from jointplay.analysis.sweeps.subdivision import OUTS, Point, refined, representatives, variables
from jointplay.analysis.vary import at_largest, axes, checked_axes, largest
from jointplay.display import codes
from jointplay.display.errors import InputError, Problem, problems_of
from jointplay.display.number_text import listed, measured, plain
from jointplay.jobs.job import Entry
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural, NonNegative, Positive, accepts, unit
from jointplay.solver.mechanism.records import ONCE_A_TURN, Mechanism, Section, TestSystem
from jointplay.solver.motion.ensemble_runs import ensemble_fits

ERRORS = 3.0  # standard errors beyond which exponents differ
EXPONENTS = ("section_exponent_per_turn", "lyapunov_exponent_per_turn")  # the first that a point has


class Features(NamedTuple):
    """Status and period of a motion; its leading exponent per turn with its error, NaN where unknown."""

    status: int
    period: int
    exponent: float
    error: float


def refine_fits(refine: int, direction: tuple[str, ...]) -> Iterator[Problem]:
    """Yield a problem where points depend on their neighbours' ends, so that none can be left out."""
    if refine and {*direction} != {"reset"}:
        yield Problem("refine", refine, "0 is accepted unless the only direction is reset")
    if refine > 20:
        yield Problem("refine", refine, "at most 20 is accepted: boxes of 2^20 values")


def features_of(answer: Entry) -> Features:
    """Features of a point's answer that decide whether others are like it."""
    values = answer["dataset"].values if "dataset" in answer else []
    fields = answer["dataset"].layout.fields if "dataset" in answer else []
    found = {field.name: np.ravel(value) for field, value in zip(fields, values, strict=True)}
    numbers = [np.nan, np.nan]
    if name := next((each for each in EXPONENTS if each in found and found[each].size), None):
        numbers = [float(found[each][0]) for each in (name, name.replace("exponent", "standard_error"))]
    period = int(found["period"][0]) if "period" in found else -1
    return Features(int(answer["status"]), period, *numbers)


def alike(contrast: float) -> Callable[[list[tuple[Features, ...]]], bool]:
    """Whether motions with these features, one of each start, may stand for each other."""

    def same(one: Features, other: Features) -> bool:
        if one[:2] != other[:2] or isfinite(one.exponent) != isfinite(other.exponent):
            return False
        apart, error = abs(one.exponent - other.exponent), hypot(one.error, other.error)
        return not apart > contrast or apart <= ERRORS * error

    def equal(features: list[tuple[Features, ...]]) -> bool:
        pairs = combinations(dict.fromkeys(features), 2)
        return all(same(a, b) for one, other in pairs for a, b in zip(one, other, strict=True))

    return equal


def adaptive(
    sweep: Sweep, levels: int, contrast: float, progress: Callable[[float], None] | None, n_jobs: int | None
) -> tuple[list[str], Read, dict[str, Any]]:
    """Hand out the points of an adaptive map.

    Returns
    -------
    keys, read, variables
        Key of the computed point that stands for each point, the last dimension fastest; all answers; what
        the dataset says of the map.
    """
    shape, keys, reads = sweep.shape[: len(sweep.axes)], np.reshape(sweep.keys, sweep.shape), []

    def evaluated(
        points: list[Point], tell: Callable[[float], None] | None
    ) -> dict[Point, tuple[Features, ...]]:
        wanted = {key for point in points for key in keys[point].flat}
        size = {"of the grid, in this round": len(wanted)}
        work = Work(_jobs(sweep, wanted), size, tell, sweep.warm, possible=sweep.keys)
        reads.append(answered(work, n_jobs))
        seen = {key: features_of(answer) for key, answer in reads[-1]()}
        return {point: tuple(seen[key] for key in keys[point].flat) for point in points}

    boxes, computed = refined(shape, levels, alike(contrast), evaluated, progress)
    place, level = representatives(shape, boxes, computed)
    own = keys.reshape(-1, *keys.shape[len(shape) :])[place]
    dims = tuple(axis.name for axis in sweep.axes)
    found = {name: OUTS[name].variable(each, plane=dims) for name, each in variables(computed, level).items()}
    return list(own.flat), lambda: chain.from_iterable(read() for read in reads), found


def _jobs(sweep: Sweep, wanted: set[str]) -> list[Chain]:
    """Points with these keys, as many together as in the whole sweep."""
    known, jobs = {*sweep.keys} - wanted, []
    left = [rest for each, _ in sweep.chains if (rest := each.left(known, {})) is not None]
    size = TOGETHER if sweep.plan.ensemble else BLOCK
    for start in dict.fromkeys(id(each.start) for each in left):
        own = [each for each in left if id(each.start) == start]
        keys = [key for each in own for key in each.keys]
        changes = [change for each in own for change in each.changes]
        jobs += [
            replace(own[0], keys=tuple(keys[at : at + size]), changes=tuple(changes[at : at + size]))
            for at in range(0, len(keys), size)
        ]
    return jobs


USUAL = (
    *("journal_x", "journal_y", "eccentricity_ratio", "contact_angle", "normal_velocity"),
    *("tangential_velocity", "angular_velocity"),
)
TURNS, LYAPUNOV_TURNS, KEEP = 300, 200, 100
CONTRAST = 0.5  # per turn: a map of it shows less as one colour
LASTS = 0.01  # share of a parameter over which the end of chaos lasts; what is narrower is a window


def motions(dataset: xr.Dataset) -> xr.DataArray:
    """Period of each point; without one ``chaotic``, if the exponent says so by its error."""
    period = dataset["period"]
    none = codes.chosen(period == 0, "no period found", "not known")
    if "section_exponent_per_turn" in dataset or "lyapunov_exponent_per_turn" in dataset:
        none = codes.chosen((period == 0) & (judged(dataset) == CHAOTIC), CHAOTIC, none)
    known = [f"period {n}" if n > 0 else "" for n in range(int(max(period.max(), 0)) + 1)]
    named = period.copy(data=np.array(known)[np.maximum(period.values, 0)])
    return codes.chosen(dataset["cell_status"] == 0, codes.chosen(period > 0, named, none), codes.FAILED)


def answer(dataset: xr.Dataset) -> str:
    """Settled motions over the parameter, direction by direction where they differ."""
    if "period" not in dataset:
        every = [str(dim) for dim in dataset["cell_status"].dims if dim not in ("start", "direction")]
        return "\n".join(codes.failures(dataset, every))
    return "\n".join([*_lines(dataset), *_saved(dataset)])


def _saved(dataset: xr.Dataset) -> list[str]:
    """Line on the values that an adaptive map computed, and the rest."""
    if "computed" not in dataset:
        return []
    done, size = int(dataset["computed"].sum()), dataset["computed"].size
    share = plain(100 * done / size, 3)
    return [
        f"{done} of {size} values computed ({share} %); each of the others has the motion of the nearest one"
    ]


def _lines(dataset: xr.Dataset) -> list[str]:
    """Lines on the motions of all points."""
    words = motions(dataset)
    outer = [dim for dim in ("start", "direction") if dim in words.dims]
    dims = [str(dim) for dim in words.dims if dim not in outer]
    lines = codes.failures(dataset, dims)
    stacked = words.transpose(*outer, *dims).values.reshape(-1, *(dataset.sizes[dim] for dim in dims))
    names = _sweep_names(words, outer)
    axes = [dataset[dim] for dim in dims]
    if all(np.array_equal(stacked[0], other) for other in stacked[1:]):
        return [*lines, codes.tally(stacked[0], axes), *_windows(stacked[0], axes)]
    for name, each in zip(names, stacked, strict=True):
        lines += [f"{name}: {line}" for line in (codes.tally(each, axes), *_windows(each, axes))]
    if (differ := _differ(stacked)).any():
        at = f"at {np.count_nonzero(differ)} of {differ.size} values{codes.places(differ, axes)}"
        lines.append(f"motions coexist {at}")
    return lines


def _windows(words: np.ndarray, axes: Sequence[xr.DataArray]) -> list[str]:
    """A line on the stretches in chaos, along one parameter, that are too narrow to be an end of it."""
    if len(axes) != 1 or not np.issubdtype(axes[0].dtype, np.number):
        return []
    chaos, values = np.flatnonzero(words == CHAOTIC), axes[0].values
    pairs = [(a, b) for a, b in pairwise(chaos) if b > a + 1 and codes.FAILED not in words[a + 1 : b]]
    narrow = [(a, b) for a, b in pairs if abs(values[b] - values[a]) <= LASTS * abs(values[a])]
    each = []
    for a, b in narrow:
        ends = " to ".join(measured(values[i], axes[0], 5) for i in (a, b))
        each.append(f"{ends} ({', '.join(sorted({*words[a + 1 : b]}))})")
    what = f"windows within chaos, each narrower than {plain(100 * LASTS, 2)} % of the value"
    return [f"{what}: {listed(each, codes.NAMED)}"] if each else []


def _differ(words: np.ndarray) -> np.ndarray:
    """Mask of places at which two sweeps, along the first axis, have different motions, both known."""
    known = (words == CHAOTIC) | np.char.startswith(words, "period ")
    pairs = combinations(range(len(words)), 2)
    apart = ((words[a] != words[b]) & known[a] & known[b] for a, b in pairs)
    return np.logical_or.reduce([*apart, np.zeros(words.shape[1:], dtype=bool)])


def _sweep_names(words: xr.DataArray, outer: Sequence[str]) -> list[str]:
    """Names of the sweeps along directions and starts."""
    names = [""]
    for dim in outer:
        labels = words[dim].values if dim in words.coords else range(words.sizes[dim])
        named = [str(label) if dim == "direction" else f"start {label}" for label in labels]
        names = [f"{name} {each}".strip() for name in names for each in named]
    return names


def _each_once(given: Any) -> Any:
    directions = as_several(given)
    expected = f"one of {', '.join(DIRECTIONS)}, or several, each once, is accepted"
    wrong = [i for i, each in enumerate(directions) if each not in DIRECTIONS or each in directions[:i]]
    if wrong or not directions:
        place = "[{}]" if len(directions) > 1 else ""
        found = [Problem(place.format(i), directions[i], expected) for i in wrong]
        raise InputError(found or [Problem("", given, expected)])
    return directions


if TYPE_CHECKING:
    Direction = str | Sequence[str]  # one counts as several
else:
    Direction = Annotated[tuple[Literal[DIRECTIONS], ...], BeforeValidator(_each_once)]
Over = Annotated[
    dict[str, Annotated[Any, BeforeValidator(as_list)]],
    accepts("a table of parameters, each with its list of values,"),
]


def _over_fits(mechanism: Mechanism | TestSystem, over: Over) -> Iterator[Problem]:
    varied = axes(mechanism, over)
    if len(varied) > 2:
        yield Problem("over", [axis.key for axis in varied], "one parameter or two are accepted")


def _section_fits(varied: Mechanism | TestSystem, section: Section) -> None:
    quantity(section, varied)


def record_fits(varied: Mechanism | TestSystem, record: Sequence[str] | None) -> None:
    """Refuse quantities that the varied mechanism does not have."""
    names(record, varied)


def _one_kind_of_start(initial: Any, starts: Any) -> Iterator[Problem]:
    if starts == ():
        yield Problem("starts", starts, "a list of at least one is accepted")
    if starts is not None and initial is not None:
        yield Problem("initial", initial, "either starts or initial is accepted, not both")


def _starts_fit(varied: Mechanism | TestSystem, initial: Any, starts: Any) -> Iterator[Problem]:
    given = {"initial": initial} if starts is None else {f"starts[{i}]": x for i, x in enumerate(starts)}
    for key, start in given.items():
        yield from problems_of(assembled_at, varied, start, key, placed)


def _exponents_fit(varied: Mechanism | TestSystem, exponents: int) -> Iterator[Problem]:
    if exponents > 1 and exponents > (states := len(assemble(varied).state)):  # one there always is
        yield Problem("exponents", exponents, f"a whole number from 0 to {states} is accepted")


def lanes_fit(varied: Mechanism | TestSystem, ensemble: bool | None, rtol: float) -> list[Problem]:
    """Rule: motions of the varied mechanism can be followed eight at once, where `ensemble` wants it."""
    return ensemble_fits(varied, ensemble, rtol)


EACH = (PLANE, "direction")  # and start, where there are several


OUTPUTS = Outputs(
    "bifurcation",
    {"direction": chains.DIRECTION} | attractor.NUMBERS,
    {"QUANTITY": Out((*EACH, "point"), "what `record` asks for at the last section points", "", "else NaN")}
    | along(attractor.OUTS | gather.OF_CELL, *EACH)
    | subdivision.OUTS
    | {"period_tolerance": Out((), "spread of section points that count as one"), "status": gather.ENDED},
    answer,
)


@analysis(
    _over_fits,
    each_alike,
    _section_fits,
    record_fits,
    _one_kind_of_start,
    _starts_fit,
    _exponents_fit,
    refine_fits,
    lanes_fit,
    varied=at_largest,
    usual={"rtol": RTOL},
    outputs=OUTPUTS,
    left_out=rules.over(40),
)
def bifurcation(
    mechanism: Moving,
    *,
    over: Over,
    section: Section = ONCE_A_TURN,
    record: Names | None = None,
    turns: Natural = TURNS,
    direction: Direction = ("up",),
    starts: Starts | None = None,
    exponents: Count = 0,
    lyapunov_turns: Natural = LYAPUNOV_TURNS,
    tolerance: Annotated[Positive, unit("tolerance of a period", "1")] | None = None,
    keep: Natural = KEEP,
    refine: Count = 0,
    contrast: Annotated[NonNegative, unit("difference of exponents per turn", "1")] = CONTRAST,
    **motion: Unpack[Batched],
) -> xr.Dataset:
    """Describe the motions that a mechanism settles to, over one parameter or two.

    The result is over the varied parameters, each under the last part of its key, ``direction``, and
    ``start`` where there are several. A point that failed has NaN, its status and a reason; the next one of
    an up or down sweep then starts from the last good end. What is over ``joint`` is of a test system one
    number, over all its contacts. Grazing shows as a smallest impact speed or missed gap near 0.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    over : mapping of str to sequence of float
        One parameter or two with their values, in any order: changes of the mechanism (``clearance``,
        ``gear_ratio``, ``friction``, ...), parameters of a test system, or key paths into the record
        (``joints.B.contact.stiffness``, ``links.coupler.mass``). SI units. 40 clearances from half to twice
        the present one if left out.
    section : Section
        Where the motion is cut; once a turn at crank angle 0 if left out.
    record : sequence of str, optional
        Quantities that are kept at section points. If left out, places and speeds of the journals and speeds
        of the links; of a test system its state.
    turns : int
        Number of turns of the crank (nominal ones, where the section is no crank angle) or of periods of the
        forcing that are looked at, at each point.
    direction : {"up", "down", "reset"} or several of them
        How the last parameter is gone through: upward or downward, each point from its neighbour's end, or
        each point from the given start.
    starts : sequence, optional
        Several initial states, instead of `initial`.
    exponents : int
        Number of leading Lyapunov exponents that are computed at each point, from its end on.
    lyapunov_turns : int
        Number of nominal turns over which the exponents are averaged.
    tolerance : float, optional
        Spread within which section points count as one: of journals, as a fraction of the clearance; of a
        linkage without clearance, in radians (or longest links) and nominal speeds; of a test system, in its
        own units. If left out, 1e-4, or 1000 `rtol` where that is more.
    keep : int
        Number of section points that are stored of each point, the last ones.
    rtol : float
        Tolerated error of a step. The default, 1e-7, keeps section points of a periodic motion within 1e-5 of
        a clearance of each other, and costs four fifths of 1e-8.
    refine : int
        How many times boxes of the map are halved, in a reset sweep. Every 2^refine-th value of each
        parameter is computed first, and those between only where points around them differ: in period or
        status, or in the leading exponent (see `contrast`). 0: all values are computed.
    contrast : float
        Difference between the leading exponents per turn of two points that counts as one, if it is also more
        than three of its standard errors.
    ensemble : bool, optional
        Whether eight motions are followed at once: points of a reset sweep, or chains side by side. If left
        out, where there are sixteen or more and the structure allows it (rigid links and a motor, clearance
        in one to three joints, an rtol of 1e-8 or more). Two to three times as fast; by another method, whose
        numbers differ within the tolerance, and do not depend on which motions run beside each other.
        Exponents are measured so too. ``followed`` and ``exponents_followed`` say of each point how it went.
    n_jobs : int, optional
        Worker processes, 2 if left out. Sweeps up and down run one point after another, so that there are as
        many cells as directions, starts and values of the other parameter. The result does not depend on it.

    Raises
    ------
    InputError
        If anything asked for makes no sense, listing all of it; numerical trouble is a status instead.
    """
    varied = largest(mechanism, over)
    own = {"keep": min(keep, turns), "tolerance": tolerance, "exponents": exponents}
    own |= {key: motion[key] for key in ("transient", "rtol", "max_steps", "ensemble")}
    plan = Plan(section, names(record, varied), turns, lyapunov_turns=lyapunov_turns, **own)
    begun = (motion["initial"],) if starts is None else starts
    progress, n_jobs = motion["progress"], motion["n_jobs"]
    sweep = Sweep(mechanism, checked_axes(mechanism, over), direction, begun, plan)
    if not refine:
        return assembled(sweep, sweep.keys, answered(sweep.work(progress), n_jobs))
    keys, read, variables = adaptive(sweep, refine, contrast, progress, n_jobs)
    return assembled(sweep, keys, read).assign(variables)


def names(record: Sequence[str] | None, mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Names of the quantities kept at section points: the given ones, checked, or the usual ones.

    Raises
    ------
    InputError
        Naming every quantity that the mechanism cannot have.
    """
    if record is None and isinstance(mechanism, Mechanism):
        return tuple(name for name in USUAL if name in recorded(None, mechanism))
    return recorded(record, mechanism, integrals=False)


def assembled(sweep: Sweep, keys: Sequence[str], read: Read) -> xr.Dataset:
    """Make the dataset of `bifurcation` of the answers of its points, each under the key of one."""
    variables, _ = OUTPUTS.variables_of({"period_tolerance": float(sweep.plan.spread)})
    result = attractor.numbered(gather.dataset("bifurcation", sweep, keys, read).assign(variables))
    return result if len(sweep.starts) > 1 else result.isel(start=0, drop=True)
