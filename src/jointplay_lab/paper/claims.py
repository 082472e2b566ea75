"""The four conclusions of a paper, graded by stated rules on computed numbers.

The paper is Chunmei, Yang, Ling and Ling, J. Sound Vib. (2002), section 5. First the numbers, then the rules.

Peaks: of each turn of a window the largest value (of deflections also the root mean square) is taken, and
these are averaged over the turns, with a standard error: an irregular motion has no one peak.

Rules: every conclusion is taken apart into checks. A ratio of two means is above 1 if it exceeds 1 by more
than `MARGIN` and its error of `ERRORS` standard errors, is not above 1 if it stays below that margin by as
much, and else is undecided. All decided checks hold: ``reproduced``; some: ``partly``; none: ``not``. Where
a run failed, or no check is decided: ``undecidable``.

peaks        with rigid links: in every panel and window, joint force and the accelerations of coupler and
             crank have larger peaks with clearance than with ideal joints
impacts      an elastic coupler lowers the peak of the joint force wherever there are impacts, at every
             damping ratio; and with ideal joints, where elasticity acts alone, it raises it
deflection   a damping ratio of 0.01 instead of 0 lowers the coupler's deflection, largest and root mean
             square, and its fast part, in both windows, with ideal joints and with clearance; and in steady
             motion its change from turn to turn
chaos        some panel is periodic from every start, and every start ends on the same points; some panel is
             chaotic from every start; and, as section 4.4 has it, those that keep contact are the periodic
             ones and those that lose it the chaotic ones

What is periodic and what chaotic is decided in `jointplay_lab.paper.character`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from textwrap import wrap
from typing import Any, NamedTuple, Unpack

import numpy as np
import xarray as xr

from jointplay.analysis.cells import handed_out, warm
from jointplay.analysis.declared import Outputs
from jointplay.analysis.keywords import Integration, Moving, analysis, listed
from jointplay.analysis.labels import Out, along, columns
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.analysis.rules import quantity
from jointplay.analysis.simulate import simulate
from jointplay.display import codes
from jointplay.display.number_text import plain
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.base import Count, Natural
from jointplay.solver.mechanism.parts.beam import DampingRatio, modal
from jointplay.solver.mechanism.records import CrankAngle, Mechanism
from jointplay_lab.paper.character import MOTIONS, NUMBERS, character
from jointplay_lab.paper.reading_list import PANELS
from jointplay_lab.paper.readings import OF_PANEL, of_panels, printed_fits

DAMPING_RATIOS = (0.0, 0.005, 0.01, 0.02, 0.05)
JOINTS = ("ideal", "clearance")
STEADY = {"a": 10, "b": 10, "c": 60}  # turns of the steady window: panel c's motion is irregular
LAST = 50  # section points by which the ends of two starts are compared

PEAKS = {  # means over the turns of a window
    "peak_force": Out((), "largest force in joint B", "N"),
    "peak_coupler_acceleration": Out((), "largest angular acceleration of the coupler", "rad s-2"),
    "peak_crank_acceleration": Out((), "largest angular acceleration of the crank", "rad s-2"),
    "impacts": Out((), "contacts begun in a turn"),
    "peak_deflection": Out((), "largest mid-point deflection of the coupler", "m"),
    "rms_deflection": Out((), "root mean square of the mid-point deflection of the coupler", "m"),
    "vibration": Out((), "fast part of the deflection over the whole"),
    "irregularity": Out((), "change of the deflection from turn to turn over the whole"),
}
MEANS = {
    name + end: replace(out, long_name=head + out.long_name)
    for name, out in PEAKS.items()
    for end, head in (("", ""), ("_error", "standard error: "))
}
MOTION = {name: out for name, out in NUMBERS.items() if name not in ("impacts", "extent")}
GRADES = ("undecidable", "not", "partly", "reproduced")
CLAIMS = {
    "peaks": "clearance raises the peaks of acceleration and joint force",
    "impacts": "elasticity alone raises the joint force, but lowers the impact peaks with clearance",
    "deflection": "structural damping reduces the deflection and makes it more regular",
    "chaos": "motion with clearance is partly periodic, partly chaotic and sensitive to the start",
}
MARGIN = 0.01  # smaller differences count as none
REGULAR = 1e-3  # a change from turn to turn below this is none: two of them are equal
ERRORS = 3
SAME = 1e-3  # clearances: two starts whose section points lie closer end on the same points
# Turns; the motor takes up its load in the first 0.005, before the first contact and with ideal joints too
START_UP = (0.005, 1.0)
DROPPED = 100  # turns before the steady window: a slow swing of the contact's direction dies over some 50
INTERVAL = 1e-5  # s between samples: some 30 in one half-wave of the contact force
WINDOWS = ("start_up", "steady")
Pair = tuple[float, float]
CASE, RUN = ("panel", "joints", "links"), ("panel", "start")
STANDS = {"not": "not reproduced", "partly": "partly reproduced"}  # the other grades stand for themselves
WIDTHS = (44, 12, 110)  # characters of conclusion, grade, evidence


def table(dataset: xr.Dataset) -> str:
    """The paper's conclusions, their grades and the numbers behind these, as text in three columns."""
    grades = codes.words(dataset["grade"]).values
    rows = [("conclusion of the paper", "grade", "numbers"), tuple("-" * (width - 2) for width in WIDTHS)]
    for number, claim in enumerate(dataset.claim.values):
        one = dataset.sel(claim=claim)
        rows.append((f"{number + 1} {one.claim_text.item()}", grades[number], str(one.evidence.item())))
    return "".join(_lines(row) for row in rows)


def _lines(row: tuple[str, ...]) -> str:
    """A row of cells, each broken to the width of its column."""
    cells = [wrap(text, width - 2) or [""] for text, width in zip(row, WIDTHS, strict=True)]
    height = max(map(len, cells))
    padded = [cell + [""] * (height - len(cell)) for cell in cells]
    lines = zip(*padded, strict=True)
    return "".join("".join(map(str.ljust, line, WIDTHS)).rstrip() + "\n" for line in lines)


def answer(dataset: xr.Dataset) -> str:
    """The number of the paper's conclusions with each grade."""
    grades = np.array([STANDS.get(grade, grade) for grade in codes.words(dataset["grade"]).values])
    return f"conclusions of the paper: {codes.counted(grades)}"


OUTPUTS = Outputs(
    "claims",
    {
        "panel": Out("panel", "panel of Figure 12", ""),
        "joints": Out("joints", "joint B", ""),
        "links": Out("links", "coupler", ""),
        "window": Out("window", "turns looked at", ""),
        "start": Out("start", "initial state", ""),
        "claim": Out("claim", "conclusion of the paper", ""),
        "damping_ratio": Out("links", "structural damping ratio of the coupler"),
        "claim_text": Out("claim", "what the paper concludes", ""),
    }
    | OF_PANEL,
    along(MEANS, *CASE, "window")
    | {"peak_status": Out(CASE, "how the run ended", flags=STATUS)}
    | along(MOTION, *RUN)
    | {
        "distance": Out(RUN, "farthest of the last section points from the first start's, over clearance"),
        "motion_status": Out(RUN, "how the run ended", flags=STATUS),
        "grade": Out("claim", "how the conclusion stands", flags=GRADES),
        "evidence": Out("claim", "the numbers behind the grade", ""),
        "ratio": Out(("comparison", "pair"), "ratio of two numbers that are compared"),
        "ratio_error": Out(("comparison", "pair"), "standard error of the ratio"),
        "ratio_holds": Out(("comparison", "pair"), "1: as concluded; 0: not; missing: undecided"),
        "compared": Out("comparison", "what is compared", ""),
        "compared_for": Out("comparison", "for which conclusion", ""),
        "compared_grade": Out("comparison", "how the comparison stands", flags=GRADES),
        "status": Out((), "ok, or how the first run that failed ended", flags=STATUS),
    },
    answer,
    table=table,
)


@analysis(printed_fits, outputs=OUTPUTS)
def claims(
    mechanism: Moving | None = None,
    *,
    damping_ratios: listed(DampingRatio, "a list of damping ratios, 0 to 1") = DAMPING_RATIOS,
    turns: Natural = 300,
    transient: Count = 400,
    growth_turns: Natural = 200,
    n_jobs: Natural | None = None,
    **motion: Unpack[Integration],
) -> xr.Dataset:
    """Compute the evidence for the paper's conclusions, and grade them.

    Peaks are means over the turns of a window, with standard errors, 0 for the single turn of start-up.

    Parameters
    ----------
    mechanism : Mechanism, optional
        As printed; the catalog's `chunmei2002` if left out. Each panel of Figure 12 sets clearance and gear
        ratio, and each case which links bend, whatever bends in what is given.
    damping_ratios : sequence of float
        Damping ratios of the elastic coupler; 0 and 0.01 are always among them.
    turns, transient, growth_turns : int
        As in `readings`, for the fourth conclusion.
    rtol : float
        Relative tolerance of a step of the time histories; the fourth conclusion's motions have their own.
    n_jobs
        As in `readings`.

    Raises
    ------
    InputError
        If the mechanism is no motor-driven linkage with a coupler and contact data at B, or a damping ratio
        is not between 0 and 1.
    """
    printed = catalog.chunmei2002() if mechanism is None else mechanism
    ratios = sorted({0.0, 0.01, *damping_ratios})
    elastic = {"elastic": ("coupler",), "elements": 2}
    bodies: list[dict[str, Any]] = [{"elastic": ()}, *(elastic | {"damping_ratio": r} for r in ratios)]
    limits = {key: motion[key] for key in ("rtol", "max_steps")}
    histories = [
        {"mechanism": _panel(printed, p, joints).replace(**body), "turns": STEADY[p]} | limits
        for p in PANELS
        for joints in JOINTS
        for body in bodies
    ]
    lengths = {"turns": turns, "transient": transient, "growth_turns": growth_turns}
    motions = [
        {"mechanism": one, "initial": start, "max_steps": motion["max_steps"]} | lengths
        for one in (_panel(printed, p, "clearance") for p in PANELS)
        for start in starts(one).values()
    ]
    warm(assemble(one["mechanism"]) for one in histories)
    warm(assemble(one["mechanism"], None, quantity(CrankAngle(), one["mechanism"])) for one in motions)
    cells = [{"kind": "peaks", "keywords": one} for one in histories]
    cells += [{"kind": "character", "keywords": one} for one in motions]
    answers = handed_out(cell, cells, motion["progress"], n_jobs)
    numbers = _peaks(answers[: len(histories)], ratios) | _motions(answers[len(histories) :])
    return _finished(OUTPUTS.dataset(numbers | _coordinates(ratios)))


def cell(kind: str, keywords: dict[str, Any]) -> dict[str, Any]:
    """Evaluate one run: the `peaks` of a time history, or the `character` of a motion."""
    return {"peaks": peaks, "character": character}[kind](**keywords)


def _panel(printed: Mechanism, panel: str, joints: str) -> Mechanism:
    clearance, ratio = PANELS[panel]
    rigid = {"gear_ratio": ratio, "elastic": ()}
    return printed.replace(clearance=clearance if joints == "clearance" else 0.0, **rigid)


def starts(mechanism: Mechanism) -> dict[str, dict[str, Any] | None]:
    """Initial states at crank angle 0: the usual one, two other crank speeds, a journal set aside.

    The last lets the coupler's end lie nine tenths of the clearance beside the bearing's centre.
    """
    model, drive = assemble(mechanism), mechanism.drive
    names = [link.name for link in mechanism.links]
    angles = dict(zip(names, model.state[: len(names)].tolist(), strict=True))
    speeds = dict(zip(names, model.state[len(names) :].tolist(), strict=True))
    angles["coupler"] -= 0.9 * model.clearances[0] / mechanism.link("coupler").length
    slow, fast = ({"crank_speed": factor * drive.nominal_speed} for factor in (0.8, 1.2))
    return {
        "ideal": None,
        "slower_crank": slow,
        "faster_crank": fast,
        "journal_aside": {"angle": angles, "angular_velocity": speeds},
    }


START_NAMES = ("ideal", "slower_crank", "faster_crank", "journal_aside")


def _peaks(answers: list[dict[str, Any]], ratios: list[float]) -> dict[str, Any]:
    shape, found = (len(PANELS), len(JOINTS), 1 + len(ratios)), {}
    missing = [(math.nan, math.nan)] * len(WINDOWS)
    for name in PEAKS:
        rows = np.array([answer.get(name, missing) for answer in answers], dtype=float)
        values = rows.reshape(*shape, len(WINDOWS), 2)
        found |= {name: values[..., 0], f"{name}_error": values[..., 1]}
    return found | {"peak_status": np.reshape([answer["status"] for answer in answers], shape)}


def _motions(answers: list[dict[str, Any]]) -> dict[str, Any]:
    shape = (len(PANELS), len(START_NAMES))
    rows = [answers[i : i + shape[1]] for i in range(0, len(answers), shape[1])]
    distances = np.array([[_distance(row[0], one) for one in row] for row in rows])
    statuses = np.reshape([answer["status"] for answer in answers], shape)
    return columns(MOTION, answers, shape) | {"distance": distances, "motion_status": statuses}


def _distance(first: dict[str, Any], other: dict[str, Any]) -> float:
    """Largest distance of the last points of one motion from the nearest of another's."""
    if "points" not in first or "points" not in other:
        return math.nan
    a, b = other["points"][-LAST:], first["points"][-LAST:]
    return float(np.linalg.norm(a[:, None] - b[None], axis=-1).min(axis=1).max())


def _coordinates(ratios: list[float]) -> dict[str, Any]:
    links = ["rigid", *(f"elastic {ratio:g}" for ratio in ratios)]
    found = {"panel": list(PANELS), "joints": list(JOINTS), "links": links, "window": list(WINDOWS)}
    found |= {"start": list(START_NAMES), "claim": list(CLAIMS), "claim_text": list(CLAIMS.values())}
    return found | {"damping_ratio": [math.nan, *ratios]} | of_panels(PANELS)


def _finished(numbers: xr.Dataset) -> xr.Dataset:
    """Add grades, evidence and an overall status."""
    grades, texts = zip(*(graded(claim, numbers) for claim in CLAIMS), strict=True)
    rows = [(claim, one) for claim in CLAIMS for one in comparisons(claim, numbers)]
    shape = (len(rows), max(one.ratio.value.size for _, one in rows))
    of = {name: np.full(shape, np.nan) for name in ("ratio", "ratio_error", "ratio_holds")}
    for n, (_, one) in enumerate(rows):
        for name, values in zip(of, (one.ratio.value, one.ratio.error, one.checks), strict=True):
            of[name][n, : values.size] = values.ravel()
    statuses = np.concatenate([numbers[f"{name}_status"].values.ravel() for name in ("peak", "motion")])
    values = {"grade": [GRADES.index(grade) for grade in grades], "evidence": list(texts)}
    values["status"] = next(iter(statuses[statuses != 0]), 0)
    values |= of | {
        "compared": [f"{one.text}, {one.window}" for _, one in rows],
        "compared_for": [claim for claim, _ in rows],
        "compared_grade": [GRADES.index(grade(one.checks)) for _, one in rows],
    }
    return numbers.assign(OUTPUTS.variables_of(values)[0])


@dataclass(frozen=True)
class Ratio:
    """Ratios of means with their standard errors, arrays of one shape; NaN: nothing to compare."""

    value: np.ndarray
    error: np.ndarray

    def above(self) -> np.ndarray:
        """1 where above 1, 0 where not, NaN where undecided."""
        low, high = self.value - ERRORS * self.error, self.value + ERRORS * self.error
        return np.where(low > 1 + MARGIN, 1.0, np.where(high <= 1 + MARGIN, 0.0, np.nan))

    def below(self) -> np.ndarray:
        """1 where below 1, 0 where not, NaN where undecided."""
        low, high = self.value - ERRORS * self.error, self.value + ERRORS * self.error
        return np.where(high < 1 - MARGIN, 1.0, np.where(low >= 1 - MARGIN, 0.0, np.nan))

    def __getitem__(self, rows: Any) -> Ratio:
        return Ratio(self.value[rows], self.error[rows])

    def __str__(self) -> str:
        values = self.value[np.isfinite(self.value)]
        return f"{plain(values.min(), 3)} to {plain(values.max(), 3)}" if len(values) else "none"


def graded(claim: str, numbers: xr.Dataset) -> tuple[str, str]:
    """Grade of a conclusion (one of `GRADES`) and its evidence in one line."""
    failed = numbers["motion_status" if claim == "chaos" else "peak_status"].values.any()
    checks, evidence = _RULES[claim](numbers)
    return ("undecidable", f"a run failed; {evidence}") if failed else (grade(checks), evidence)


def grade(checks: Iterable[float]) -> str:
    """Grade from checks: 1 holds, 0 does not, NaN is undecided."""
    decided = np.array([check for check in checks if not np.isnan(check)])
    if not len(decided):
        return "undecidable"
    return "reproduced" if decided.all() else "partly" if decided.any() else "not"


def _count(checks: np.ndarray, word: str) -> str:
    decided = int(np.sum(~np.isnan(checks)))
    rest = np.size(checks) - decided
    return f"{int(np.nansum(checks))} of {decided} {word}" + (f", {rest} undecided" if rest else "")


def _ratio(numbers: xr.Dataset, name: str, over: dict[str, str], under: dict[str, str]) -> Ratio:
    """Ratios of a quantity between two selections."""
    (a, b), (da, db) = (
        [numbers[word].sel(place) for place in (over, under)] for word in (name, f"{name}_error")
    )
    if name == "irregularity":
        a, b = a.clip(min=REGULAR), b.clip(min=REGULAR)
    relative = np.hypot(*xr.broadcast(da / a, db / b))
    value, error = xr.broadcast(a / b, relative * (a / b))
    return Ratio(value.values, error.values)


class Comparison(NamedTuple):
    """Ratios of one quantity in one window: what they are of, and on which side of 1 the paper has them."""

    text: str
    window: str
    ratio: Ratio
    side: str

    @property
    def checks(self) -> np.ndarray:
        """1 where the ratio is on that side, 0 where it is not, NaN where undecided."""
        return (self.ratio.above() if self.side == "above" else self.ratio.below()).ravel()

    @property
    def counted(self) -> str:
        """How many are on that side."""
        return _count(self.checks, f"{self.side} 1")


def comparisons(claim: str, numbers: xr.Dataset) -> list[Comparison]:
    """The comparisons that a conclusion is taken apart into; none of one that is no comparison."""
    return list(_COMPARISONS[claim](numbers)) if claim in _COMPARISONS else []


def _of_peaks(numbers: xr.Dataset) -> Iterator[Comparison]:
    texts = {"peak_force": "force at B", "peak_coupler_acceleration": "coupler acceleration"}
    texts |= {"peak_crank_acceleration": "crank acceleration"}
    rigid = numbers.sel(links="rigid").transpose("window", "panel", ...)
    for name, text in texts.items():
        ratio = _ratio(rigid, name, {"joints": "clearance"}, {"joints": "ideal"})
        for number, window in enumerate(rigid.window.values):
            yield Comparison(text, _plain(window), ratio[number], "above")


def _of_impacts(numbers: xr.Dataset) -> Iterator[Comparison]:
    elastic = {"links": numbers.links.values[1:]}
    texts = {
        "clearance": ("with clearance, where there are impacts", "below"),
        "ideal": ("ideal joints", "above"),
    }
    for joints, (text, side) in texts.items():
        for window in numbers.window.values:
            one = numbers.sel(joints=joints, window=window).transpose("panel", ...)
            ratio = _ratio(one, "peak_force", elastic, {"links": "rigid"})
            if joints == "clearance":
                ratio = ratio[one.impacts.sel(links="rigid").values > 0]
            yield Comparison(text, _plain(window), ratio, side)


def _of_deflection(numbers: xr.Dataset) -> Iterator[Comparison]:
    free, damped = ({"links": f"elastic {ratio:g}"} for ratio in (0.0, 0.01))
    texts = {"peak_deflection": "largest", "rms_deflection": "root mean square", "vibration": "fast part"}
    texts |= {"irregularity": "turn-to-turn change"}
    for name, text in texts.items():
        for window in numbers.window.values if name != "irregularity" else ["steady"]:
            yield Comparison(
                text, _plain(window), _ratio(numbers.sel(window=window), name, damped, free), "below"
            )


_COMPARISONS = {"peaks": _of_peaks, "impacts": _of_impacts, "deflection": _of_deflection}


def _plain(word: str) -> str:
    return str(word).replace("_", "-")


def _graded_peaks(numbers: xr.Dataset) -> tuple[np.ndarray, str]:
    rows, parts = comparisons("peaks", numbers), {}
    for one in rows:
        parts.setdefault(one.text, []).append(
            f"{one.window} {', '.join(plain(v, 3) for v in one.ratio.value)}"
        )
    values = np.concatenate([one.checks for one in rows])
    panels = ", ".join(map(str, numbers.panel.values))
    ratios = "; ".join(f"{text} {', '.join(windows)}" for text, windows in parts.items())
    return values, f"clearance over ideal, panels {panels}: {ratios} ({_count(values, 'above 1')})"


def _graded_by_comparison(claim: str, head: str, numbers: xr.Dataset) -> tuple[np.ndarray, str]:
    rows = comparisons(claim, numbers)
    parts = [f"{one.text}, {one.window} {one.ratio} ({one.counted})" for one in rows]
    return np.concatenate([one.checks for one in rows]), f"{head}: {'; '.join(parts)}"


def _graded_chaos(numbers: xr.Dataset) -> tuple[list[float], str]:
    motion, apart = numbers.motion.values, numbers.distance.values
    periodic, chaotic = ((motion == MOTIONS.index(word)).all(axis=1) for word in ("periodic", "chaotic"))
    kept = (numbers.separations.values == 0).all(axis=1)
    checks = [
        (periodic & (apart < SAME).all(axis=1)).any(),
        chaotic.any(),
        np.where(kept, periodic, chaotic).all(),
    ]
    evidence = "; ".join(_in_words(str(panel), numbers.sel(panel=panel)) for panel in numbers.panel.values)
    return [float(check) for check in checks], evidence


def _in_words(name: str, one: xr.Dataset) -> str:
    words = "/".join(sorted({MOTIONS[code] for code in one.motion.values}))
    periods = "/".join(str(p) if p else "none" for p in sorted(set(one.period.values.tolist())))
    error, apart = (plain(float(one[key].max()), 1) for key in ("growth_standard_error", "distance"))
    return (
        f"{name} {words}: losses of contact per turn {_span(one.separations)}, period {periods}, growth"
        f" per turn {_span(one.growth)} (standard error {error}), starts end {apart} clearances apart"
    )


def _span(values: xr.DataArray) -> str:
    """Smallest and largest of the starts, as one number where they do not differ."""
    return " to ".join(dict.fromkeys(plain(float(value), 3) for value in (values.min(), values.max())))


_RULES = {
    "peaks": _graded_peaks,
    "impacts": partial(_graded_by_comparison, "impacts", "peak force, elastic over rigid"),
    "deflection": partial(_graded_by_comparison, "deflection", "deflection, damping ratio 0.01 over 0"),
    "chaos": _graded_chaos,
}


def peaks(
    mechanism: Mechanism, *, turns: int = 10, rtol: float = 1e-8, max_steps: int | None = None
) -> dict[str, Any]:
    """Follow a motor-driven linkage and take the peaks of its response, at joint B and in the coupler.

    Parameters
    ----------
    mechanism : Mechanism
        With a joint B, ideal or with clearance, and links coupler and crank.
    turns : int
        Length of the steady window, turns.
    rtol : float
        Relative tolerance of a step.
    max_steps : int, optional
        Attempted steps after which the run stops.

    Returns
    -------
    dict
        ``status``; as lists of (mean over the turns, its standard error), one a window: ``peak_force`` (N),
        ``peak_coupler_acceleration`` and ``peak_crank_acceleration`` (rad/s²), ``impacts`` (1 a turn), and
        of an elastic coupler ``peak_deflection``, ``rms_deflection`` (m), ``vibration`` and ``irregularity``
        (1), the last NaN in the window of one turn. The standard error in a window of one turn is 0.
    """
    clear, elastic = mechanism.joint("B").clearance > 0, mechanism.link("coupler").elastic
    force = ["normal_force", "tangential_force"] if clear else ["reaction"]
    record = ["angle", "angular_acceleration", *force] + ["deflection"] * elastic
    windows, limits = (START_UP, (DROPPED, DROPPED + turns)), {"rtol": rtol, "max_steps": max_steps}
    period = math.tau / abs(mechanism.drive.nominal_speed)
    rate = round(period / INTERVAL)
    sampled = simulate(mechanism, windows=windows, samples_per_turn=rate, record=record, **limits)
    # A jump of the contact force shakes the crank for microseconds only: take both sides of every event too
    own = simulate(mechanism, turns=DROPPED + turns, steps=True, record=record, **limits)
    if sampled.status or own.status:
        return {"status": int(sampled.status or own.status)}
    answer: dict[str, Any] = {"status": 0, "impacts": [_impacts_between(own, window) for window in windows]}
    for name in (name for name in _QUANTITIES if elastic or name != "deflection"):
        sources = [(_turns(found), np.abs(_QUANTITIES[name](found))) for found in (sampled, own)]
        answer[f"peak_{name}"] = [_peak(sources, window) for window in windows]
    return answer | (_of_beam(sampled, mechanism, windows) if elastic else {})


def _force(found: xr.Dataset) -> np.ndarray:
    """Magnitude of the force in joint B, N."""
    if "reaction" in found:
        return found.reaction.sel(pin="B").values
    return np.hypot(*(found[name].sel(joint="B").values for name in ("normal_force", "tangential_force")))


# From a result to the quantities that have peaks
_QUANTITIES: dict[str, Callable[[xr.Dataset], np.ndarray]] = {
    "force": _force,
    "coupler_acceleration": lambda found: found.angular_acceleration.sel(link="coupler").values,
    "crank_acceleration": lambda found: found.angular_acceleration.sel(link="crank").values,
    "deflection": lambda found: found.deflection.sel(link="coupler").values,
}


def _turns(found: xr.Dataset) -> np.ndarray:
    """Times in nominal turns; a sample at the end of a turn belongs to the next."""
    return found.time.values / float(found.turn_period_nominal) + 1e-9


def _each(turns: np.ndarray, window: Pair) -> list[np.ndarray]:
    """Rows of each turn of a window."""
    first, last = window
    whole = range(math.floor(first), round(last))
    return [np.flatnonzero((turns >= max(n, first)) & (turns < n + 1)) for n in whole]


def _peak(sources: list[tuple[np.ndarray, np.ndarray]], window: Pair) -> Pair:
    """Mean over turns of the largest value that any source holds in a turn, and its standard error."""
    each = [[value[rows].max() for rows in _each(turns, window)] for turns, value in sources]
    return mean(np.max(each, axis=0))


def mean(values: np.ndarray) -> Pair:
    """Mean and standard error, 0 for a single value."""
    values = np.asarray(values)
    error = values.std(ddof=1) / math.sqrt(len(values)) if len(values) > 1 else 0.0
    return float(values.mean()), float(error)


def rms(value: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(value**2)))


def _impacts_between(found: xr.Dataset, window: Pair) -> Pair:
    """Contacts begun per turn; without an error, as it only says whether there are any."""
    contacts = found.event_time.values[found.event_kind.values == EVENTS.index("contact")]
    turns = contacts / float(found.turn_period_nominal)
    first, last = window
    return float(np.sum((turns >= first) & (turns <= last)) / (last - first)), 0.0


def _of_beam(found: xr.Dataset, mechanism: Mechanism, windows: tuple[Pair, ...]) -> dict[str, Any]:
    value, angle = found.deflection.sel(link="coupler").values, found.angle.sel(link="crank").values
    natural = math.tau / modal(mechanism.link("coupler")).frequency[0]
    width = max(1, round(natural / float(found.time[1] - found.time[0])))
    each = [_each(_turns(found), window) for window in windows]
    whole = [np.concatenate(rows) for rows in each]
    return {
        "rms_deflection": [mean([rms(value[rows]) for rows in one]) for one in each],
        "vibration": [mean([vibration(value[rows], width) for rows in one]) for one in each],
        "irregularity": [irregularity(angle[rows], value[rows]) for rows in whole],
    }


def vibration(value: np.ndarray, width: int) -> float:
    """Part of a deflection faster than the first natural vibration, over the whole: root mean squares.

    Parameters
    ----------
    value : ndarray, shape (samples,)
        Even samples.
    width : int
        Samples in a period of that vibration: its mean over a period is what is slow.
    """
    slow = np.convolve(value, np.ones(width) / width, "valid")
    left = (width - 1) // 2
    return rms(value[left : left + len(slow)] - slow) / rms(value)


def irregularity(angle: np.ndarray, value: np.ndarray) -> Pair:
    """Change from one turn to the next at equal crank angle, over the whole: root mean squares.

    Parameters
    ----------
    angle : ndarray, shape (samples,)
        Crank angle, monotonic, rad.
    value : ndarray, shape (samples,)
        What should repeat.

    Returns
    -------
    (float, float)
        Mean over the changes and its standard error. 0: the same every turn; sqrt(2): turns that have
        nothing in common. NaN for less than two turns.
    """
    turns = np.abs(angle - angle[0]) / math.tau
    whole = math.floor(turns[-1])
    if whole < 2:
        return math.nan, math.nan
    per_turn = len(value) // (whole + 1)
    table = np.interp(np.arange(whole * per_turn) / per_turn, turns, value).reshape(whole, per_turn)
    return mean(np.sqrt(np.mean(np.diff(table, axis=0) ** 2, axis=1)) / rms(table))
