"""Answers of assessments: one page of plain text, and its lines in short.

How hard a linkage with clearance is worked, in four grades.

quiet      contact is never lost
touches    it is lost, and begins again at less than `GENTLE` m/s, and forces stay below `LIGHT` times ideal
           ones
rattles    it is lost, and neither of the others holds
hammers    it hits at `HARD` m/s or more, or a force is `HEAVY` times that of ideal joints or more

They are conventions, by the largest speed with which contact begins, and by the largest ratio of a joint's
largest force to that of the same linkage with ideal joints.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from jointplay.analysis.assessment.edges import SIDES
from jointplay.analysis.assessment.settled import SLOW, log_distance
from jointplay.display import codes
from jointplay.display.accepted import article
from jointplay.display.number_text import counted, measure, measured, plain, shown, signed, with_error

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

BEGINS = {  # what the change is, where the present motion does not have the trait
    "contact_loss": "contact is lost",
    "doubling": "period 1 is lost",
    "chaos": "chaos begins",
}
JUMPS = "the motion ends in a fold and jumps to another"  # of period 1, where that was lost so
ENDS = {"contact_loss": "contact is kept", "doubling": "period 1 is reached", "chaos": "chaos ends"}
FOUND = {
    "bracketed": "settled motions",
    "fold": "fold of the orbit",
    "grazing": "grazing of the orbit",
    "irregular": "now and then, in a motion without a period",
}
NONE = "\N{EN DASH}"
UNEQUAL = 1e-3  # difference of works, over them, that is told
DIAGRAM = 41  # values of the diagram that shows a change by brute force
PLACES = ("before", "after")  # of a change of the grade
NOT_MET = "not met"
ALIKE = 1.01  # force ratio below which forces are those of ideal joints
COARSE = "{}: among the {} values of the curve and some more, not refined as edges are"
KNOWN_BY = {"edge": "{}", "values": "about {}", "unsettled": "about {}, not settled", "unknown": "{}"}
BY = tuple(KNOWN_BY)
DOWN = {"below": "down to", "above": "up to"}
OPPOSITE = {"below": "above", "above": "below"}
HELPS = 0.99  # of the force ratio: a change that leaves more of it helps nothing
LOADED = 3.0  # times the force, or a part of it, from which a contact's stiffness is another one
NOT_RUN = "not_run"
TRIED = {("damping", "×3"): "three times the damping", ("friction", "×2"): "twice the friction"}
OTHER = {
    "clearance": (0.5, "half the {}"),
    "": (0.9, "{share} % less {}"),
}  # single changes of parameters

GRADES = ("quiet", "touches", "rattles", "hammers")
UNKNOWN = "unknown"
GENTLE, HARD = 0.01, 0.1  # m/s
LIGHT, HEAVY = 1.5, 3.0
NEGLIGIBLE = 1e-6  # of the largest force of ideal joints: a joint that carries less there has no ratio
MEANING = {
    "quiet": "contact is never lost",
    "touches": f"contact is lost, at less than {1e3 * GENTLE:g} mm/s and {LIGHT:g} times the ideal forces",
    "rattles": "contact is lost, and harder than that",
    "hammers": f"contact is lost, at {1e3 * HARD:g} mm/s and more, or with {HEAVY:g} times the ideal forces",
}


def answer(dataset: Dataset) -> str:
    """Return the verdict, the present motion, what the verdict hangs on, where it changes, what to do."""
    if _grade(dataset) == UNKNOWN:
        return "no forces known"
    helps = " ".join(map(str.strip, _helps(dataset).splitlines()[:2]))
    lines = [_verdict(dataset), _motion(dataset), *_worn(dataset), _hangs_on(dataset)[-1].strip()]
    return "\n".join([*lines, _limits(dataset), helps])


def page(dataset: Dataset, source: str | None = None) -> str:
    """Return the whole assessment as a page of plain text; `source` is the file in its commands."""
    source = source or f"{dataset.attrs.get('study', 'STUDY')}.toml"
    return "\n".join(part(dataset, number, source) for number in range(len(PARTS)))


def part(dataset: Dataset, number: int, source: str) -> str:
    """Return a part of the page, which is known after the round of the assessment that has its number.

    What to do is final after the last one: edges say where the grade changes, among coarse values or nearer.
    """
    return "\n".join([*PARTS[number](dataset, source), ""])


def _at_once(dataset: Dataset, _: str) -> list[str]:
    """The title, the verdict, and the forces and contacts behind it."""
    name = str(dataset.attrs.get("title") or dataset.attrs.get("study") or "assessment")
    lines = [name, "=" * len(name), "", "Verdict", *(f"  {line}" for line in _lead(dataset)), *_slow(dataset)]
    return [*lines, "", *_forces(dataset), "", *_contacts(dataset), *(f"  {line}" for line in _worn(dataset))]


def _lead(dataset: Dataset) -> list[str]:
    """The leading sentences: the verdict, and how the motion repeats."""
    if _grade(dataset) == UNKNOWN:
        return ["No forces are known: the motion was not followed to its end."]
    return [f"{_verdict(dataset)}.", f"{_motion(dataset)}."]


def _in_the_end(dataset: Dataset, source: str) -> list[str]:
    """Lines on changes of the motion, on the meaning of grades, and commands."""
    lines = [*_changes(dataset), "", "Grades", *(f"  {grade}: {MEANING[grade]}" for grade in GRADES), ""]
    lines += ["Reproduce", f"  jointplay assess {source}"]
    if any(NOT_RUN in codes.words(dataset[f"{each}_status"]).values for each in ("variant", "curve", "side")):
        lines += ["  (the same command goes on with what was not looked at)"]
    if "tolerances" in dataset.attrs:
        lines += ["How many made by this drawing do so, by the tolerances that stand in the file"]
        lines += [f"  jointplay tolerances {source}"]
    given = commands(dataset, source)
    lines += ["Check by brute force: a diagram across each change"] * bool(given)
    return [*lines, *(f"  {command}" for command in given)]


PARTS: tuple[Callable[[Dataset, str], list[str]], ...] = (
    _at_once,
    lambda dataset, _: _hangs_on(dataset),
    lambda dataset, _: _to_do(dataset),
    _in_the_end,
)


def _grade(dataset: Dataset) -> str:
    return str(codes.words(dataset["grade"]).values)


def _hardest(dataset: Dataset, loose: bool = False) -> int:
    """Place of the joint whose largest force is the largest over that of the ideal mechanism."""
    those = dataset[["peak_force", "force_ratio"]].where(not loose or dataset["clearance"] > 0)
    force, ratio = those["peak_force"].values, those["force_ratio"].values
    return int(np.nanargmax(ratio if np.isfinite(ratio).any() else force))


def _verdict(dataset: Dataset) -> str:
    """The grade, how often contact is lost and how hard it hits, and the largest force."""
    i, joints = _hardest(dataset), _joints(dataset)
    ratio, force = float(dataset["force_ratio"][i]), measure(float(dataset["peak_force"][i]), "N", 3)
    most = f"joint {joints[i]} carries up to {force}"
    most += f", {plain(ratio, 3)} times as much as with ideal joints" * math.isfinite(ratio)
    if 1 / ALIKE < ratio < ALIKE:
        most = f"forces are those of ideal joints, within {plain(100 * (ALIKE - 1), 2)} %"
    word = _grade(dataset).capitalize()
    if word == "Quiet":
        return f"{word}: contact is never lost; {most}"
    counts, speeds = (dataset[name].values for name in ("separations", "impact_speed"))
    k = int(np.nanargmax(speeds))
    hits = f"hits at {measure(float(speeds[k]), 'm s-1', 3)}"
    lost = [f"joint {joints[k]} loses contact {_times(float(counts[k]))} and {hits}"]
    for j in np.flatnonzero((counts > 0) & (np.arange(len(joints)) != k)):
        at = f" and at {measure(float(speeds[j]), 'm s-1', 3)}" if speeds[j] > 0 else ""
        lost.append(f"joint {joints[j]} {_times(float(counts[j]))}{at}")
    return f"{word}: {', '.join(lost)}; {most}"


def _times(count: float) -> str:
    return {1.0: "once a turn", 2.0: "twice a turn"}.get(count, f"{plain(count, 3)} times a turn")


def _limits(dataset: Dataset) -> str:
    """Where contact is first lost, or kept again, on each side of each parameter."""
    lost = _present(dataset)["contact_loss"] == "yes"
    places = _places(dataset, _limit) or _places(dataset, _on_curve)
    if not places and not dataset["values_looked_at"].values.any():
        return "Where contact is first lost or kept was not looked at"
    if not places:
        return f"Contact is {'lost' if lost else 'kept'} at all values that were looked at"
    coarse = f" ({COARSE.format('about', _followed(dataset))})" if "about" in str(places) else ""
    return f"{'Loss of contact stops' if lost else 'Contact is first lost'} {', or '.join(places)}{coarse}"


def _places(dataset: Dataset, limit: Callable[..., tuple[float, str] | None]) -> list[str]:
    """Words for the limit on each side of each parameter, where there is one."""
    places = []
    for key in map(str, dataset["parameter"].values):
        limits = [(side, limit(dataset, key, side)) for side in SIDES]
        ends = [f"{_side(dataset, key, side)} {_at(dataset, key, *end)}" for side, end in limits if end]
        if ends:
            name = str(dataset["parameter_name"].sel(parameter=key).values)
            places.append(f"at {article(name)} {name} {' or '.join(ends)}")
    return places


def _limit(dataset: Dataset, key: str, side: str) -> tuple[float, str] | None:
    """Ratio at which contact is first lost or kept on a side, and the evidence for it (`BY`)."""
    after = dataset.sel(parameter=key, side=side, place="after")
    known = [(float(after["edge_ratio"].sel(change="contact_loss")), "edge")]
    if (_of(after["grade_change_grade"]) == "quiet") != (_grade(dataset) == "quiet"):
        known.append((float(after["grade_change_ratio"]), _known_by(after)))
    known = [each for each in known if math.isfinite(each[0])]
    return min(known, key=lambda each: log_distance(each[0]), default=None)


def _on_curve(dataset: Dataset, key: str, side: str) -> tuple[float, str] | None:
    """The nearest value of a curve at which contact is lost or kept, beyond other grades."""
    one = dataset.sel(parameter=key)
    ratios, grades = one["curve_ratio"].values, codes.words(one["curve_grade"]).values
    others = (grades != UNKNOWN) & ((grades == "quiet") != (_grade(dataset) == "quiet"))
    near = ratios[others & ((ratios > 1) == (side == "above"))]
    return (float(min(near, key=log_distance)), "values") if near.size else None


def _at(dataset: Dataset, key: str, ratio: float, by: str) -> str:
    """Words for a value at which something changes, and for the evidence."""
    return KNOWN_BY[by].format(_value(dataset, key, ratio, 4))


def _known_by(place: Dataset) -> str:
    """The evidence of a change of the grade; in results of 0.1.0 always by the values of a curve."""
    return _of(place["grade_change_by"]) if "grade_change_by" in place else "values"


def _of(code: DataArray) -> str:
    return str(codes.words(code).values)


def _slow(dataset: Dataset) -> Iterator[str]:
    """Words on a motion that settles slowly, and why."""
    radius, period = float(dataset["largest_multiplier"]), float(dataset["period"])
    if not (period > 0 and radius > SLOW):
        return
    turns = -period / math.log(radius)
    time = measure(turns * 2 * math.pi / abs(float(dataset["crank_speed"])), "s", 3)
    share = plain(100 * (1 - radius ** (1 / period)), 2)
    yield f"  It settles slowly: what disturbs it shrinks by {share} % a turn,"
    yield f"  to a third in {turns:.0f} turns ({time})."
    where = " and ".join(_joints(dataset.isel(joint=dataset["friction_coefficient"].values == 0)))
    if where:
        yield f"  There is no friction at joint {where}: only normal contact damps the swing of the journal"
        yield "  along its bearing. Forces are those of the settled motion."


def _hangs_on(dataset: Dataset) -> list[str]:
    """Contact data, and the same motion with other contact data."""
    if _grade(dataset) == UNKNOWN:
        return ["What it hangs on: not known"]
    lines, given = ["What it hangs on"], dataset["contact_data"].values
    sources = dataset["contact_sources"].values if "contact_sources" in dataset else [""] * len(given)
    for name, text, source in zip(_joints(dataset), given, sources, strict=True):
        lines += [f"  joint {name}: {text}"] if text else []
        lines += [f"  {source}"] if source else []
        lines += _loaded(dataset.sel(joint=name))
    if not dataset.sizes.get("variant"):
        return lines
    if _not_run(dataset["variant_status"]):
        return [*lines, "  other contact data: not looked at"]
    joint = _joints(dataset)[_hardest(dataset, loose=True)]
    head = ("contact data", "grade", f"force at {joint} (N)", "times ideal", "most of all joints")
    rows = [(*head, "separations", "impact speed", "period")]
    quantities = ("peak_force", "separations", "impact_speed")
    now = (float(dataset[n].sel(joint=joint)) for n in quantities)
    numbers = _numbers(*now, dataset["force_ratio"], joint)
    rows.append(("as given", _grade(dataset), *numbers, _repeat(float(dataset["period"]))))
    for i in range(dataset.sizes["variant"]):
        one = dataset.isel(variant=i)
        name = " ".join(str(one[f"variant_{each}"].values) for each in ("quantity", "change"))
        own = (float(one[f"variant_{n}"].sel(joint=joint)) for n in quantities)
        ratios = over_ideal(one["variant_peak_force"].values, dataset["ideal_peak_force"].values)
        numbers = _numbers(*own, dataset["force_ratio"].copy(data=ratios), joint)
        rows.append((name, _of(one["variant_grade"]), *numbers, _repeat(float(one["variant_period"]))))
    return [*lines, *_table(rows), f"  {_band(dataset, joint)}"]


def _loaded(joint: Dataset) -> Iterator[str]:
    """Words on a stiffness that was taken at another force than the joint carries."""
    load, carried = float(joint.get("stiffness_load", np.nan)), float(joint["ideal_peak_force"])
    if load > LOADED * carried or load < carried / LOADED:
        most, much = measure(carried, "N", 2), "stiff" if load > carried else "soft"
        taken = f"too {much}: that is its stiffness at {measure(load, 'N', 3)}"
        yield f'  {taken}, an ideal joint carries {most} at most; write load = "{most}" beside pin and bush'


def _numbers(force: float, separations: float, speed: float, ratios: DataArray, joint: str) -> Iterator[str]:
    """Words for the force at a joint, its ratio and the largest one of all, and for its impacts."""
    yield plain(force, 4)
    yield plain(float(ratios.sel(joint=joint)), 3)
    known = ratios.dropna("joint")
    yield f"{plain(float(known.max()), 3)} ({known.idxmax().item()})" if known.size else NONE
    yield plain(separations, 3)
    yield measure(speed, "m s-1", 3) if speed > 0 else NONE


def _repeat(period: float) -> str:
    return NONE if math.isnan(period) else (str(int(period)) if period > 0 else "none")


def _not_run(status: DataArray) -> bool:
    return bool(np.all(codes.words(status).values == NOT_RUN))


def _band(dataset: Dataset, joint: str) -> str:
    """Least and largest force over the variants, their grades, and which quantity matters most."""
    here = float(dataset["peak_force"].sel(joint=joint))
    there = dataset["variant_peak_force"].sel(joint=joint).values
    known = np.isfinite(there)
    if not known.any():
        return "nothing is known of other contact data"
    low, high = (measure(f([here, *there[known]]), "N", 3) for f in (min, max))
    marks = {_grade(dataset), *codes.words(dataset["variant_grade"]).values.tolist()} - {UNKNOWN}
    grades = [grade for grade in GRADES if grade in marks]
    grade = f"from {grades[0]} to {grades[-1]}" if len(grades) > 1 else f"{grades[0]} throughout"
    away = np.abs(np.log(there[known] / here))
    most = f"{dataset['variant_quantity'].values[known][np.argmax(away)]} matters most"
    if len(grades) == 1 and np.max(away) < math.log(ALIKE):
        most = "none of them matters"
    force = low if low == high else f"{low} to {high}"
    left = f"; {np.sum(~known)} of {known.size} are not known" if not known.all() else ""
    return (
        f"With other contact data the largest force at {joint} is {force} and the grade {grade}; {most}{left}"
    )


def _to_do(dataset: Dataset) -> list[str]:
    """Values at which the grade changes, with forces before and after, and the change that helps most."""
    if _grade(dataset) == UNKNOWN:
        return ["What to do: not known"]
    rows = [("", "grade changes at", "away", "grade", "joint", "its force", "times ideal", "impact speed")]
    notes, looked = [], []
    for key in map(str, dataset["parameter"].values):
        one = dataset.sel(parameter=key)
        (ended, *others) = {*codes.words(one["curve_status"]).values.tolist()}
        if not others and ended != "ok":
            why = "not looked at" if ended == NOT_RUN else f"stopped: {ended}"
            notes.append(f"{one['parameter_name'].values}: {why}")
            continue
        looked += [(key, side) for side in SIDES]
        notes += [note for side in SIDES for note in _beyond(dataset, key, side)]
    ratio = dataset["grade_change_ratio"].sel(place="after")
    rows += [_grade_change(dataset, *at) for at in _nearest_first(looked, ratio)]
    if coarse := [word for word in ("about", NOT_MET) if any(word in row[1] for row in rows)]:
        words = COARSE.format(", ".join(coarse), _followed(dataset))
        notes.append(f"{words}; a narrow range with another grade may lie nearer")
    lines = ["What to do", *(_table(rows) if len(rows) > 1 else []), *(f"  {note}" for note in notes)]
    return [*lines, f"  {_helps(dataset)}"]


def _followed(dataset: Dataset) -> str:
    """How many values of the curves were looked at, from least to most where that differs."""
    counts, whole = (codes.words(dataset["curve_status"]) != NOT_RUN).sum("value"), dataset.sizes["value"]
    least, most = (f(counts.values[counts.values > 0]) for f in (np.min, np.max))
    text = f"{most}" if least == most else f"{least} to {most}"
    return text if least == whole else f"{text} of {whole}"


def _nearest_first(sides: Iterable[tuple[str, str]], ratio: DataArray) -> list[tuple[str, str]]:
    """Parameters and sides by the distance of a change there; last where there is none."""
    away = np.abs(np.log(ratio)).fillna(np.inf)
    return sorted(sides, key=lambda at: float(away.sel(parameter=at[0], side=at[1])))


def _grade_change(dataset: Dataset, key: str, side: str) -> tuple[str, ...]:
    """A row on the first change of the grade on a side, with what is just before and just after it."""
    one = dataset.sel(parameter=key, side=side)
    before, after = (one.sel(place=place) for place in PLACES)
    side, ratio = _side(dataset, key, side), float(after["grade_change_ratio"])
    name = f"{one['parameter_name'].values}, {side}"
    if math.isnan(ratio):
        limit = _value(dataset, key, float(before["grade_change_ratio"]), 4)
        return name, f"{NOT_MET} {DOWN[side]} {limit}", *[""] * 6
    names = ("grade", "joint", "force", "force_ratio", "impact_speed")
    texts = (" → ".join(dict.fromkeys(map(_words_at, (before, after), (n, n)))) for n in names)
    value = _at(dataset, key, ratio, _known_by(after))
    away = 100 * abs(ratio - 1)
    return name, value, f"{plain(away, 3 if away < 1e3 else 4)} %", *texts


def _beyond(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on where a curve has a harder grade than the row of a side."""
    one = dataset.sel(parameter=key, side=side, place="after")
    marks, ratios = codes.words(one["curve_grade"]).values, one["curve_ratio"].values
    outward = np.argsort(np.abs(np.log(ratios)))
    outward = outward[(ratios[outward] > 1) == (side == "above")]
    hard = (UNKNOWN, *GRADES).index
    worst = max(outward, key=lambda i: hard(marks[i]))
    if hard(marks[worst]) > max(hard(_grade(dataset)), hard(_of(one["grade_change_grade"]))):
        seen = "" if one["curve_period"][worst] else ", not seen to repeat"
        value = _value(dataset, key, ratios[worst], 4)
        place = f"{one['parameter_name'].values}, {_side(dataset, key, side)}"
        yield f"{place}: {marks[worst]} at {value}{seen}"


def _words_at(place: Dataset, name: str) -> str:
    """Words for a number on one side of a change of the grade."""
    if name == "joint":
        return str(place["grade_change_joint"].values) if "grade_change_joint" in place else NONE
    given = place[f"grade_change_{name}"]
    if name == "grade":
        return _of(given)
    if name == "force_ratio":
        return plain(float(given), 3)
    if name == "impact_speed" and not float(given) > 0:
        return NONE
    return measure(float(given), "N" if name == "force" else "m s-1", 3)


def _helps(dataset: Dataset) -> str:
    """Which single change lowers the largest ratio of a joint's force to that with ideal joints most."""
    now, found = largest(dataset["force_ratio"].values), {}
    if math.isnan(now):
        return "Single changes: with ideal joints there are no forces to compare with"
    for i in range(dataset.sizes.get("variant", 0)):
        one = dataset.isel(variant=i)
        words = TRIED.get((str(one["variant_quantity"].values), str(one["variant_change"].values)))
        if words:
            force = one["variant_peak_force"].values
            found[words] = largest(over_ideal(force, dataset["ideal_peak_force"].values))
    for key in map(str, dataset["parameter"].values):
        one = dataset.sel(parameter=key)
        at, words = other(key)
        i = int(np.argmin(np.abs(np.log(one["curve_ratio"].values / at))))
        if codes.words(one["curve_grade"]).values[i] == UNKNOWN:  # it may still swing
            continue
        ratio = over_ideal(one["curve_peak_force"].values[i], one["curve_ideal_peak_force"].values[i])
        share = plain(100 * (1 - float(one["curve_ratio"][i])), 2)
        found[words.format(one["parameter_name"].values, share=share)] = largest(ratio)
    if not (found := {words: ratio for words, ratio in found.items() if math.isfinite(ratio)}):
        return "Single changes: not looked at"
    if 1 / ALIKE < now < ALIKE:
        return "Forces are those of ideal joints: there is nothing to lower"
    best, *_ = order = sorted(found, key=found.__getitem__)
    tried = "; ".join(f"{words}: {plain(found[words], 3)}" for words in order)
    if found[best] > HELPS * now:
        return f"No such single change lowers the largest ratio to ideal forces, {plain(now, 3)} ({tried})"
    lower = f"to ideal forces from {plain(now, 3)} to {plain(found[best], 3)}"
    return f"Of single changes, {best} helps most: it lowers the largest ratio\n  {lower}\n  ({tried})"


def _joints(dataset: Dataset) -> list[str]:
    return [str(name) for name in dataset["joint"].values]


def _motion(dataset: Dataset) -> str:
    """The present motion: its speed and period, or its exponent."""
    speed = float(dataset["crank_speed"])
    turning = f"The crank turns at {plain(speed, 4)} rad/s ({plain(speed * 30 / math.pi, 4)} rpm)"
    period = float(dataset["period"])
    if not period > 0:
        value, error = (float(dataset[f"section_{n}_per_turn"]) for n in ("exponent", "standard_error"))
        if math.isnan(value):
            return f"{turning}; the motion had no time to settle: numbers are of a few turns"
        chaotic = _present(dataset)["chaos"] == "yes"
        what = "chaotic" if chaotic else "without a period, and not known to be chaotic"
        size = f"largest exponent of the section map {signed(value, error)} per turn"
        return f"{turning}; the motion is {what}, {size}"
    lost = {"yes": "contact is lost in each", "no": "contact is never lost"}
    every = "turn" if period == 1 else f"{int(period)} turns"
    return f"{turning}; the motion repeats every {every}, {lost[_present(dataset)['contact_loss']]}"


def _present(dataset: Dataset) -> dict[str, str]:
    return dict(zip(dataset["change"].values, codes.words(dataset["present"]).values, strict=True))


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows in columns; the first on the left, numbers on the right."""
    first, *rest = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [f"  {'  '.join([row[0].ljust(first), *map(str.rjust, row[1:], rest)])}".rstrip() for row in rows]


def _number(value: float, error: float, factor: float = 1.0) -> str:
    """A number with its error; to four digits where that is smaller still."""
    value, error = factor * value, factor * error
    if not value:
        return "0"
    if math.isnan(value):
        return NONE
    return with_error(value, error) if error > 1e-4 * abs(value) else f"{plain(value, 5)} ± <0.01 %"


def _forces(dataset: Dataset) -> list[str]:
    rows = [("joint", "clearance", "largest force (N)", "ideal mechanism (N)", "ratio")]
    for name in _joints(dataset):
        one = dataset.sel(joint=name)
        pairs = [_number(float(one[n]), float(one[f"{n}_error"])) for n in ("peak_force", "ideal_peak_force")]
        loose = float(one["clearance"]) > 0
        clearance = measure(float(one["clearance"]), "m", 4) if loose else "ideal"
        rows.append((name, clearance, *pairs, plain(float(one["force_ratio"]), 3)))
    scatter = "" if float(dataset["period"]) > 0 else ", and scatter between turns"
    return [f"Largest joint forces (\N{PLUS-MINUS SIGN}: numerical error{scatter})", *_table(rows)]


def _contacts(dataset: Dataset) -> list[str]:
    loose = dataset.isel(joint=dataset["clearance"].values > 0)
    unit = shown(loose["sliding_work"].values, "J")
    factor, symbol = (1e3, "mJ") if np.nanmax(loose["sliding_work"].values, initial=0.0) < 1 else unit[1::-1]
    head = ("joint", "separations", "in contact", "impact speed", f"normal contact ({symbol})")
    rows = [(*head, f"friction ({symbol})", f"sliding work ({symbol})")]
    for name in _joints(loose):
        one = loose.sel(joint=name)
        share = f"{plain(100 * float(one['contact_fraction']), 4)} %"
        count, hit = plain(float(one["separations"]), 3), float(one["impact_speed"])
        speed = measure(hit, "m s-1", 3) if hit > 0 else NONE
        losses = ("impact_loss", "friction_loss", "sliding_work")
        each = (_number(float(one[n]), float(one[f"{n}_error"]), factor) for n in losses)
        rows.append((name, count, share, speed, *each))
    losses = _number(float(dataset["joint_loss"]), float(dataset["joint_loss_error"]), factor)
    taken, given = (float(dataset[name]) for name in ("joint_work", "drive_work"))
    check = f"  check: losses together {losses} {symbol}; the drive gives {plain(factor * given, 5)} {symbol}"
    if abs(given - taken) > UNEQUAL * abs(taken):
        check += " (the difference is stored, or goes elsewhere)"
    title = "Contact, per turn: separations, energy lost, and normal force times sliding distance"
    return [title, *_table(rows), check]


def _worn(dataset: Dataset) -> Iterator[str]:
    """Pressure and sliding work of each joint with clearance, as far as they are known."""
    names = {"contact_pressure": "pressure {} at the peak", "sliding_work": "sliding work {} a turn"}
    names |= {"sliding_work_per_hour": "{} an hour"}
    for joint in _joints(dataset.isel(joint=dataset["clearance"].values > 0)):
        known = [(dataset[name].sel(joint=joint), text) for name, text in names.items() if name in dataset]
        texts = [text.format(measured(one, one, 3)) for one, text in known if np.isfinite(one)]
        if texts:
            yield f"Joint {joint}: {', '.join(texts)}"


def _value(dataset: Dataset, key: str, ratio: float, digits: int = 6) -> str:
    one = dataset.sel(parameter=key)
    return measure(ratio * float(one["present_value"]), str(one["parameter_units"].values), digits)


def _changes(dataset: Dataset) -> list[str]:
    lines = ["Where the motion changes, outward from the present value of one parameter at a time"]
    lines += [f"  {_limits(dataset)}."] if _grade(dataset) != UNKNOWN else []
    keys = [str(key) for key in dataset["parameter"].values]
    sides = list(itertools.product(keys, SIDES))
    rows = [row for name in map(str, dataset["change"].values) for row in _met(dataset, sides, name)]
    lines += _table([("", "at", "away", "between motions at", "found by"), *rows]) if rows else []
    for key in keys:
        one, notes = dataset.sel(parameter=key), []
        for side, lines_of in itertools.product(SIDES, (_not_met, _missed, _shares, _windows)):
            notes += [f"{_side(dataset, key, side)}: {line}" for line in lines_of(dataset, key, side)]
        lines.append(f"  {one['parameter_name'].values}, now {_value(dataset, key, 1.0, 4)}")
        lines += [f"    {line}" for line in [*notes, _looked(dataset, key)]]
    return [*lines, "  What begins and ends between two neighbouring values is not seen."]


def _side(dataset: Dataset, key: str, side: str) -> str:
    """The word for a side; below in size is above, of a negative value."""
    return side if float(dataset["present_value"].sel(parameter=key)) > 0 else OPPOSITE[side]


def _looked(dataset: Dataset, key: str) -> str:
    """Words on the number of values of a parameter that were followed, and their relative distance."""
    parts = []
    for side in SIDES:
        here = dataset.sel(parameter=key, side=side)
        if count := int(here["values_looked_at"]):
            apart = plain(100 * log_distance(float(here["limit_ratio"])) / count, 2)  # in the logarithm
            parts.append(f"{counted(count, 'value')} {_side(dataset, key, side)}, {apart} % apart on average")
    return f"motions looked at: {'; '.join(parts) or 'none'}"


def _shares(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on the motions beyond the end of period 1, as shares of the values looked at."""
    one = dataset.sel(parameter=key, side=side)
    ratio = float(one["edge_ratio"].sel(change="doubling"))
    if not math.isfinite(ratio):
        return
    beyond = np.abs(np.log(one["looked_ratio"].values)) >= log_distance(ratio)
    total, period = int(beyond.sum()), one["looked_period"].values[beyond]
    chaotic = int((codes.words(one["looked_chaos"]).values[beyond] == "yes").sum())
    if total:
        end = _value(dataset, key, float(one["limit_ratio"]), 4)
        once = f"period 1 at {int((period == 1).sum())} of {total} values from there to {end}"
        yield f"{once}, chaos at {chaotic}"


def _windows(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on the changes that are taken back at once: others like them may have been missed."""
    known = dataset["window_low"].sel(parameter=key, side=side).values
    if count := int(np.isfinite(known).sum()):
        share = plain(100 * float(dataset["lasting_share"]), 2)
        known = f"{counted(count, 'window')} narrower than {share} % in the result"
        yield f"{known}; others may have been missed"


def _met(dataset: Dataset, sides: Sequence[tuple[str, str]], name: str) -> Iterator[tuple[str, ...]]:
    """Rows on where a change was found, the nearest first."""
    for key, side in _nearest_first(sides, dataset["edge_ratio"].sel(change=name)):
        found = dataset.sel(parameter=key, side=side, change=name)
        how, place = _of(found["found_by"]), f"{found['parameter_name'].values}, {_side(dataset, key, side)}"
        if how != "not_met":
            kind = FOUND.get(how, how.replace("_", " "))
            if math.isfinite(back := float(found["return_ratio"])):
                kind += f"; back to the present behaviour by {_value(dataset, key, back, 4)}"
            yield f"{_words(dataset, name, how)}: {place}", *_place(dataset, key, found), kind


def _not_met(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on the changes that were not met on one side, and on the reach of the search."""
    one = dataset.sel(parameter=key, side=side)
    if not int(one["values_looked_at"]) and _of(one["side_status"]) == NOT_RUN:
        yield "not looked at"
        return
    unmet = list(map(str, dataset["change"].values[one["found_by"].values == 0]))
    status = str(codes.words(one["side_status"]).values)
    why = {"ok": "", NOT_RUN: " (not looked at beyond)"}.get(status, f", where it stopped: {status}")
    end = f"{DOWN[_side(dataset, key, side)]} {_value(dataset, key, float(one['limit_ratio']), 4)}"
    if "chaos" in unmet and _present(dataset)["chaos"] == "yes":
        unmet.remove("chaos")
        count, turns = int(one["values_looked_at"]), int(dataset["lasting_turns"])
        windows = int(np.isfinite(one["window_period"]).sum()) if "window_period" in one else 0
        at = f"at {f'{count - windows} of the' if windows else 'each of the'} {counted(count, 'value')}"
        yield f"chaotic {at} {end}{why}, {turns} turns later too"
    if unmet:
        yield f"not met {end}{why}: {', '.join(_words(dataset, name) for name in unmet)}"


def _missed(dataset: Dataset, key: str, side: str) -> Iterator[str]:
    """A line on a motion of a curve that loses or keeps contact where the one followed does not."""
    limit, one = _limit(dataset, key, side), dataset.sel(parameter=key, side=side)
    if limit and limit[1] != "edge" and log_distance(limit[0]) < log_distance(float(one["limit_ratio"])):
        what, at = _words(dataset, "contact_loss"), _at(dataset, key, *limit)
        yield f"{what} at {at} in a motion begun anew: in a narrow range, or beside the one followed"


def _words(dataset: Dataset, name: str, how: str = "") -> str:
    """Words for a change, from the present motion."""
    if _present(dataset)[name] == "yes":
        return ENDS[name]
    return JUMPS if how == "fold" else BEGINS[name]


def _place(dataset: Dataset, key: str, found: Dataset) -> tuple[str, str, str]:
    """Value of an edge with its error, its distance, and its bracket."""
    ratio, error = float(found["edge_ratio"]), float(found["edge_ratio_error"])
    value = float(found["present_value"])
    unit = shown(ratio * value, str(found["parameter_units"].values))
    symbol = "" if unit.symbol == NONE else f" {unit.symbol}"
    text = f"{_sharp(ratio * value * unit.factor, error * abs(value) * unit.factor)}{symbol}"
    if key in ("gear_ratio", "speed"):
        text += f" ({plain(abs(float(found['edge_speed'])) * 30 / math.pi, 4)} rpm)"
    ends = (_value(dataset, key, float(found[f"bracket_{end}"]), 5) for end in ("low", "high"))
    return text, f"{plain(100 * abs(ratio - 1), 3)} %", " and ".join(dict.fromkeys(ends))


def _sharp(value: float, error: float) -> str:
    """An edge with its error, or to six digits where that is smaller."""
    return with_error(value, error) if error > 1e-6 * abs(value) else plain(value, 6)


def commands(dataset: Dataset, source: str) -> list[str]:
    """Commands that run a bifurcation diagram across the changes on each side, from the present value."""
    lines = []
    for key, side in itertools.product(map(str, dataset["parameter"].values), SIDES):
        ends = dataset["edge_ratio"].sel(parameter=key, side=side).values
        if np.isfinite(ends).any():
            farthest = float((np.nanmin if side == "below" else np.nanmax)(ends))
            lines.append(_command(dataset, key, side, farthest, source))
    return lines


def _command(dataset: Dataset, key: str, side: str, ratio: float, source: str) -> str:
    value = float(dataset["present_value"].sel(parameter=key))
    low, high = sorted((value, value * (1 + 1.1 * (ratio - 1))))
    span = f"{{start={low:.6g},stop={high:.6g},num={DIAGRAM}}}"
    direction = "down" if (side == "below") == (value > 0) else "up"
    named = f"name={key.replace('.', '_')}_{side} 'figure={{separations=true}}'"
    settings = f"kind=bifurcation {named} 'analysis={{direction=\"{direction}\",exponents=1}}'"
    return f"jointplay run {source} --set {settings} 'vary.{key}={span}'"


def other(key: str) -> tuple[float, str]:
    """The value of a parameter, over the present one, that is tried as a single change, and words for it."""
    return OTHER.get(key.rsplit(".", 1)[-1], OTHER[""])


def grade(lost: bool, ratio: float, speed: float) -> int:
    """Index into `GRADES`.

    Parameters
    ----------
    lost : bool
        Whether contact is lost in any joint.
    ratio : float
        Largest force of a joint over that of the same joint in the ideal linkage, the largest of all joints;
        NaN where none is known: then the speed decides.
    speed : float
        Largest speed with which contact begins, m/s.
    """
    if not lost:
        return 0
    if speed >= HARD or ratio >= HEAVY:
        return 3
    return 1 if speed < GENTLE and not ratio >= LIGHT else 2


def over_ideal(force: np.ndarray, ideal: np.ndarray) -> np.ndarray:
    """Forces over those of ideal joints, joints along the last axis; NaN where an ideal one is negligible."""
    least = NEGLIGIBLE * np.nanmax(ideal, axis=-1, keepdims=True, initial=0.0)
    return force / np.where(ideal > least, ideal, np.nan)


def largest(numbers: np.ndarray) -> float:
    """The largest of the numbers that are known; NaN where none is."""
    return float(np.nanmax(numbers)) if np.isfinite(numbers).any() else math.nan
