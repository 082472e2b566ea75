"""Assessments against direct runs: what they tell, each edge, and the band over contact data.

*Verdict and band.* A run from the usual start, its list of events and forces at many times give largest
forces, impact speeds, separations, the repeat, chaos (two motions that part), and the grade.

*Edges.* A sweep at rtol 1e-8 carries the motion from the present value outward over values 1 % apart, across
each edge in steps a tenth as long, and over both ends of its bracket; section points say whether it repeats.
The cells next to the edge on both sides, outside its error and where motions settle, must differ in the
trait. Where two motions enclose the edge, it is at their values that they must differ, and again in some cell
beyond: windows of the other motion lie there. No value looked at before the edge may differ from the present
one, nor any where no edge was met; other values before it, but in chaos and beyond the end of period 1, may
where a change has not lasted: over no more than the share of the page, of which it tells that narrower
windows may have been missed. Where the trait is said to be as at present again, it has to be. Where a motion
without a period loses contact now and then, some cell beside the edge has to.

A cell that repeats over 60 turns with the expected traits has settled. The others, and those that confirm an
edge, are followed 440 turns more from where they stand, and their exponent is measured. What has not settled
then is followed 6000 more, as at an edge of chaos, which may die out late: an orbit that repeats and is not
stable, and what has neither period nor chaos. So a window is seen whose multiplier passes -1 by 0.004. Where
a value said to be chaotic is not so in the sweep, chaos has to last there, 440 turns and those of its
exponent, from one of the `STARTS` nearest chaotic cells: the page says that it lasts so long, and when it
dies out is chance. Motions may coexist: a cell that differs is reached once more, in finer steps, and
followed from where the assessment says that its motion stands; beside an edge, and where a trait is as at
present again, the usual start counts, too. Where a window begins and ends is known to `ACCURACY`.
"""

import itertools
from functools import cache

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment.assess import ACCURACY, REACH
from jointplay.analysis.assessment.edges import HOW, SIDES
from jointplay.analysis.assessment.settled import CHANGES
from jointplay.analysis.assessment.settled import SLOW as SLOWLY
from jointplay.analysis.sweeps.attractor import Plan, settle_together
from tests.support.unshown import TEN

MECHANISMS = {
    "four-bar, 0.029 mm, slow": lambda: jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=15.0),
    "four-bar, 0.29 mm": lambda: jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0),
    "slider-crank": lambda: jp.catalog.slider_crank(clearance={"B": 1e-4}),
    "quick return": lambda: jp.catalog.quick_return(clearance={"D": 5e-5}),
    "Watt of the catalog": lambda: jp.catalog.watt(clearance={"D": 5e-5}),
}


SECTION, RTOL = jp.CrankAngle(), 1e-8
SWAYING = 1e-10  # rtol where a journal swings undamped: what it leaves behind is amplified 1 / (1 - ρ) times
POINTS, SEEN, ALIKE = ("journal_x", "journal_y", "angular_velocity"), 60, 2e-4
SHORT, LONG, LASTING = 100, 440, 6000  # turns before a cell is looked at, and before it is looked at again
SWAYS = 600  # the first of these without friction: less, and the swing carries motions off to others
BEFORE, SWINGING = 300, 4000  # turns before a run is recorded; without friction
TURNS, STRETCHES = 20, 10  # recorded in a stretch; of a motion that does not repeat
NEARLY = 5e-6  # relative: how near points come in the longest runs, but at an edge
STEADY = 0.98  # of a distance after some thirty turns: less is left of one that dies out
REPEATING, WANDERING, BAND = 0.01, 0.15, 0.05  # how near numbers lie, relative
SLOW = 1e-4  # of the parameter: so near an edge a motion does not settle in the turns that are followed
CLOSER = 12  # steps to a cell that differs, from the last one that does not: motions may coexist there
STARTS = 8  # chaotic motions from which it is tried again where chaos has died out
STEP, FINE, CELLS = 0.01, 0.1, 5  # relative step; of it the fine ones; their number on each side of an edge


def outward(looked, edges, others, even):
    """Ratios from 1 to the last value looked at, and which of them are values looked at.

    Of the latter about one in 1 %, where `even` values 1 % apart too, and all beside an edge, which lies in
    the middle of a fine step.
    """
    way = 1 if looked[-1] > 1 else -1
    fine = (1 + FINE * STEP) ** (np.arange(2 * CELLS) + 0.5 - CELLS)
    coarse, last = [], 0.0
    for ratio in looked:
        beside = np.abs(np.log(ratio / edges)) < CELLS * FINE * STEP
        if not last or abs(np.log(ratio / last)) > 0.9 * STEP or beside.any():
            coarse.append(last := ratio)
    if even:
        coarse += [*np.geomspace(1.0, looked[-1], round(abs(np.log(looked[-1])) / STEP) + 2)[:-1]]
    ratios = np.concatenate([coarse, others, *(edge * fine for edge in edges)])
    inside = (way * np.log(ratios) >= 0) & (way * np.log(ratios / looked[-1]) < 1e-9)
    ratios = np.unique(ratios[inside])[::way]
    return ratios, np.isin(ratios, looked)


def turns_to_repeat(found, alike=ALIKE):
    """Turns after which section points repeat, by journals' places in units of their reach, and by speeds."""
    points = section_points(found)
    for period in range(1, len(points) // 2 + 1):
        if np.max(np.abs(points[period:] - points[:-period])) < alike:
            return period
    return 0


def section_points(found):
    """Section points, each speed in units of its largest, each journal's place in units of the farthest.

    Shape (points, numbers).
    """
    x, y, speeds = (_numbers(found, name) for name in POINTS)
    reach = np.maximum(np.abs(x), np.abs(y)).max(axis=0)
    points = np.concatenate([x, y, speeds], axis=1)
    points = points / np.concatenate([reach, reach, np.abs(speeds).max(axis=0)]).clip(1e-300)
    return points[:, np.isfinite(points).all(axis=0)]


def nears(found):
    """Whether points one turn apart come nearer to each other, turn by turn."""
    apart = np.abs(np.diff(section_points(found), axis=0)).max(axis=1)
    first, last = np.array_split(apart, 2)
    return last.max() < STEADY * first.max()


def traits(found, alike=ALIKE):
    """Answers of `CHANGES` of a settled motion."""
    value, error, follows = (
        float(np.ravel(found.get(f"section_{name}", np.nan))[0])
        for name in ("exponent_per_turn", "standard_error_per_turn", "batch_correlation")
    )
    follows = np.clip(follows, 0.0, 0.99)  # of batch means, by which their error is too small
    period = turns_to_repeat(found, alike)
    chaotic = period == 0 and value > 3 * error * np.sqrt((1 + follows) / (1 - follows))
    return np.array([np.any(np.asarray(found["contact_fraction"]) < 1), period != 1, chaotic])


def _numbers(found, name):
    """Values of a quantity at section points; shape (points, whose)."""
    return np.asarray(found[name], dtype=float).reshape(len(found[name]), -1)


def swept(mechanism, key, values, present, judged, needed, told):
    """Answers of `CHANGES` over the values, in their order: of the `needed` cells from the longer runs.

    `judged`, over values and `CHANGES`, says which answers have to be the `present` ones; `needed` has cells
    of which the last are followed longest, since chaos may die out in them. `told` are states at or before
    the values.
    """
    way = "up" if abs(values[-1]) > abs(values[0]) else "down"
    short = SWAYS if frictionless(mechanism) else SHORT
    settings = {"transient": short, "turns": SEEN, "keep": SEEN, "record": POINTS}
    settings |= {"rtol": tolerance(mechanism), "section": SECTION, "n_jobs": 1}
    sweep = jp.bifurcation(mechanism, over={key: np.sort(values)}, direction=way, **settings)
    assert np.all(sweep["cell_status"] == 0)
    (dim,) = sweep["cell_status"].isel(direction=0).dims
    cells = [sweep.isel(direction=0).sel({dim: value}) for value in values]
    answers = np.array([traits(cell) for cell in cells])
    chaos = np.array([turns_to_repeat(cell) == 0 for cell in cells]) & judged[:, -1]  # perhaps
    open_yet = np.flatnonzero(chaos | (judged & (answers != present)).any(axis=1))
    lasting = np.unique(needed[-1])
    others = np.setdiff1d(np.concatenate([open_yet, *needed]), lasting)

    def followed(these, starts, *lengths):
        """Follow cells on from the ends of other cells, or of their own."""
        places = [mechanism.varied({key: float(values[i])}) for i in these]
        return followed_on(places, [cells[i]["end_state"].values for i in starts], *lengths)

    answers[others], settled = followed(others, others, LONG, 200)
    lasting = np.concatenate([lasting, others[~settled]])
    answers[lasting], _ = followed(lasting, lasting, LASTING, 800)
    chaotic = np.flatnonzero(answers[:, -1])
    died = judged[:, -1] & present[-1] & ~answers[:, -1]
    for i in np.setdiff1d(np.flatnonzero(died), needed[-1]):
        near = chaotic[np.argsort(np.abs(chaotic - i), kind="stable")[:STARTS]]
        tried, _ = followed(np.full(len(near), i), near, LONG, 200)
        answers[i] = max(answers[i], *tried, key=lambda answer: answer[-1])
    differ = (judged & (answers != present)).any(axis=1)
    differ[np.concatenate(needed)] = present[-1]
    for i in np.flatnonzero(differ & ~present[-1])[:STARTS]:
        same = np.flatnonzero(~differ[:i])
        if len(same):
            between = np.geomspace(values[same[-1]], values[i], CLOSER + 1)[1:]
            start = {"initial": cells[same[-1]]["end_state"].values}
            finer = jp.bifurcation(
                mechanism, over={key: np.sort(between)}, direction=way, **settings, **start
            )
            end = finer.isel(direction=0).sel({dim: between[-1]})["end_state"].values
            place = mechanism.varied({key: float(between[-1])})
            answers[i] = from_start(place, end)
            if np.any(answers[i] != present):  # an orbit may have doubled by very little
                (answers[i],), _ = followed_on([place], [end], LASTING, 800, NEARLY)
            if np.any(answers[i] != present):
                answers[i] = from_start(place, told[i])
    return answers


def followed_on(places, starts, turns, averaged, alike=ALIKE):
    """Answers of `CHANGES` of motions that are followed on; and whether these are settled.

    A period is where its orbit is stable, no period where the motion is chaotic. A slow swing about an orbit
    of period 1 repeats nearly, after some turns, before it has died out.
    """
    lengths = {"turns": SEEN, "transient": turns, "lyapunov_turns": averaged}
    rtol = tolerance(places[0]) if places else RTOL
    plan = Plan(SECTION, POINTS, keep=SEEN, exponents=1, rtol=rtol, **lengths)
    answers, settled = np.zeros((len(places), len(CHANGES)), dtype=bool), np.zeros(len(places), dtype=bool)
    for i, one in enumerate(settle_together(list(zip(places, starts, strict=True)), plan)):
        assert one["status"] == 0, one["trouble"]
        described = {name: each[1] for name, each in (one["points"] | one["values"]).items()}
        answers[i] = traits(described, alike)
        stable = np.ravel(described["section_exponent_per_turn"])[0] < 0
        period = turns_to_repeat(described, alike)
        settled[i] = stable and not (period > 1 and nears(described)) if period else answers[i, -1]
    return answers, settled


def from_start(mechanism, start=None):
    """Answers of `CHANGES` of the motion from a start, the usual one if left out, once it has settled."""
    (answer,), settled = followed_on([mechanism], [start], LONG, 200)
    if not settled:
        (answer,), _ = followed_on([mechanism], [start], LASTING, 800)
    return answer


def by_change(ratios, here, share):
    """Cells that confirm each change: of an edge the last before and the first beyond it, outside its error.

    Of one that two motions enclose, as chaos always is, their places, and then those beyond over the share
    that it has to last; of an irregular one those beside it. Also, over ratios and `CHANGES`, which lie
    before the edge.
    """
    cells, before = [], np.zeros((len(ratios), len(CHANGES)), dtype=bool)
    away = np.abs(np.log(ratios))
    for i, change in enumerate(CHANGES):
        one = here.sel(change=change)
        edge, error = float(one["edge_ratio"]), float(one["edge_ratio_error"])
        close = np.abs(ratios - edge) <= error + SLOW
        before[:, i] = ~close & ~(away >= abs(np.log(edge)))  # all of them where no edge was met
        if HOW[int(one["found_by"])] == "irregular":
            cells.append(np.flatnonzero(np.abs(np.log(ratios / edge)) < CELLS * FINE * STEP))
        elif np.isfinite(edge):
            beyond = np.flatnonzero(~close & (away > abs(np.log(edge))))
            last, first, more = np.flatnonzero(before[:, i])[-1], beyond[0], []
            if change == "chaos" or HOW[int(one["found_by"])] == "bracketed":
                ends = [float(one[f"bracket_{end}"]) for end in ("low", "high")]
                last, first = (
                    int(np.argmin(np.abs(ratios - end)))
                    for end in sorted(ends, key=lambda end: abs(np.log(end)))
                )
                more = [cell for cell in beyond if cell > first and away[cell] < away[first] + 1.5 * share]
            cells.append(np.unique([last, first, *more]))
        else:
            cells.append(np.zeros(0, dtype=int))
    return cells, before


def longest(ratios, same):
    """Largest share of the parameter over which neighbouring values differ, at least."""
    runs = (
        list(run) for differs, run in itertools.groupby(range(len(same)), lambda i: not same[i]) if differs
    )
    return max((np.expm1(abs(np.log(ratios[run[-1]] / ratios[run[0]]))) for run in runs), default=0.0)


def states_told(here, ratios):
    """States that an assessment tells of at ratios, or at the last value before; None where there is none."""
    looked = here["looked_ratio"].values
    away = np.abs(np.log(looked[np.isfinite(looked)])) * (1 - 1e-12)
    last = np.searchsorted(away, np.abs(np.log(ratios)), side="right") - 1
    return [None if i < 0 else here["looked_state"].values[i] for i in last]


def disagreements(mechanism, found, key, side, reach):
    """Changes on one side whose edge, or its absence, the sweep does not confirm."""
    here = found.sel(parameter=key, side=side)
    present, begin = found["present"].values == 1, float(here["present_value"])
    edges, backs = here["edge_ratio"].values, here["return_ratio"].values
    irregular = np.array([HOW[how] == "irregular" for how in here["found_by"].values])
    share = float(found["lasting_share"])
    farther = np.outer(edges, (1 + share) ** (SIDES[side] * np.linspace(0, 1, 21)[1:])).ravel()
    ends = np.concatenate([here["bracket_low"].values, here["bracket_high"].values, backs, farther])
    looked = here["looked_ratio"].values[np.isfinite(here["looked_ratio"].values)]
    looked = np.append(1.0, looked)
    ratios, looked = outward(looked, edges[np.isfinite(edges)], ends[np.isfinite(ends)], not present[-1])
    cells, judged = by_change(ratios, here, share)
    windows = here[["window_low", "window_high"]].to_array().values.T  # told of: no motion there is judged
    assert not np.any(windows[:, 1] / windows[:, 0] > 1 + share + 1e-9)
    about = windows * [1 - ACCURACY, 1 + ACCURACY]
    inside = np.any([(low <= ratios) & (ratios <= high) for low, high in about] + [ratios < 0], axis=0)
    left = abs(np.log(edges[CHANGES.index("doubling")]))  # beyond it single values are looked at
    beyond = np.abs(np.log(ratios)) > left
    judged &= ~irregular & ~inside[:, None] & (looked | ~(beyond | present[-1]))[:, None]
    again = [np.flatnonzero(ratios == back) for back in backs]
    needed = [np.concatenate(cells)]
    needed += [np.concatenate([each[:2], back]) for each, back in zip(cells, again, strict=True)]
    count = max([*np.flatnonzero(judged.any(axis=1)), *np.concatenate(needed)], default=0) + 1
    ratios, judged, looked = ratios[:count], judged[:count], looked[:count]
    told = states_told(here, ratios)
    answers = swept(mechanism, key, begin * ratios, present, judged, needed, told)

    def same_from(cell, i, starts):
        """Whether a trait is as at present in a cell, from one of some starts."""
        place = mechanism.varied({key: begin * ratios[cell]})
        return any(from_start(place, start)[i] == present[i] for start in starts)

    for i, (change, edge) in enumerate(zip(CHANGES, edges, strict=True)):
        same = answers[:, i] == present[i]
        for cell in again[i][~same[again[i]]]:  # motions may coexist
            same[cell] = same_from(cell, i, (None, told[cell]))
        bad = not same[judged[:, i] & looked].all() or not same[again[i]].all()
        bad |= longest(ratios, same | ~judged[:, i]) > share
        if irregular[i]:  # seen in some of the cells
            bad |= same[cells[i]].all()
        elif np.isfinite(edge):
            (last, first), more = cells[i][:2], cells[i][2:]
            for cell, as_now in ((last, True), (first, False)):
                if same[cell] != as_now:  # motions may coexist
                    same[cell] = same_from(cell, i, (None, told[cell]) if as_now else (None,))
            bad |= not same[last] or same[first] or (len(more) > 0 and same[more].all())
        if bad:
            yield key, side, change, edge, answers[:, i].tolist()


def recorded(mechanism, start=None, before=BEFORE, turns=TURNS):
    """A run after so many turns from a start, the usual one if left out; forces at many times of a turn."""
    quantities = ("normal_force", "tangential_force", "reaction", *POINTS)
    quantities = quantities if mechanism.clearance_joints else ("reaction",)
    settings = {"record": quantities, "samples_per_turn": 2**14, "section": SECTION, "rtol": RTOL}
    run = jp.words(jp.simulate(mechanism, initial=start, transient=before, turns=turns, **settings))
    assert run["status"] == "ok"
    return run


def largest_forces(run, begin=-np.inf, end=np.inf):
    """Largest force of each joint by name, between two times."""
    inside = (begin <= run["time"].values) & (run["time"].values < end)
    own = {str(pin): run["reaction"].sel(pin=pin).values[inside].max() for pin in run["pin"].values}
    for name in run["joint"].values if "normal_force" in run else ():
        each = [run[force].sel(joint=name).values[inside] for force in ("normal_force", "tangential_force")]
        own |= {str(name): np.hypot(*each).max()} if np.isfinite(each).any() else {}
    return own


def impacts(run, name, begin=-np.inf, end=np.inf):
    """Separations of a joint between two times, and its largest speed at contact, by the list of events."""
    inside = (begin <= run["event_time"].values) & (run["event_time"].values < end)
    inside &= run["event_joint"].values == name
    kinds, speeds = run["event_kind"].values[inside], run["event_normal_velocity"].values[inside]
    rebounds = np.sum(kinds == "impact") - np.sum(kinds == "rest")  # of a rigid bearing
    hits = np.isin(kinds, ("contact", "impact"))
    return np.sum(kinds == "separation") + rebounds, np.abs(speeds[hits]).max(initial=0.0)


def grows(mechanism, end, stretches=60, turns=2, apart=1e-8):
    """Whether two motions that begin close together part, by three errors of the growth in a turn.

    They are pulled together again after each stretch (Benettin and others, 1980).
    """
    moving = ~np.char.endswith(end["state"].values.astype(str), "crank")
    one, way, growth = end.values, np.where(moving, 1.0, 0.0), []
    for _ in range(stretches):
        starts = (one, one + apart * way / np.linalg.norm(way))
        settings = {"turns": turns, "samples_per_turn": 2, "rtol": 1e-11}
        one, other = (
            jp.simulate(mechanism, initial=end.copy(data=each), **settings)["end_state"].values
            for each in starts
        )
        way = other - one
        growth.append(np.log(np.linalg.norm(way) / apart) / turns)
    return np.mean(growth) > 3 * np.std(growth) / np.sqrt(stretches)


def graded(lost, ratio, speed):
    """The grade that the page defines in words."""
    if not lost:
        return "quiet"
    if speed >= 0.1 or ratio >= 3:
        return "hammers"
    return "touches" if speed < 0.01 and ratio < 1.5 else "rattles"


def numbers(mechanism, start, before, stretches):
    """Largest forces, impact speeds and separations a turn of a run, over stretches; its period; its end."""
    run = recorded(mechanism, start, before, TURNS * stretches)
    length = float(np.diff(run["section_time"])[-1]) * TURNS
    begins = float(run["time"][0]) + length * np.arange(stretches)
    found = {}
    for begin in begins:
        each = {("force", name): size for name, size in largest_forces(run, begin, begin + length).items()}
        for joint in mechanism.clearance_joints:
            lost, speed = impacts(run, joint.name, begin, begin + length)
            each |= {("separations", joint.name): lost / TURNS, ("speed", joint.name): speed}
        found = {key: [*found.get(key, ()), value] for key, value in each.items()}
    period = turns_to_repeat({name: run[f"section_{name}"].values for name in POINTS})
    end, turning = run["end_state"], np.char.startswith(run["state"].values.astype(str), "theta")
    return found, period, end - np.where(turning, 2 * np.pi * np.round(end / (2 * np.pi)), 0.0)


def frictionless(mechanism):
    """Whether a journal swings along its bearing with nothing that damps it."""
    return any(not joint.friction for joint in mechanism.clearance_joints)


def settling(mechanism):
    """Turns in which a motion settles."""
    return SWINGING if frictionless(mechanism) else BEFORE


def tolerance(mechanism):
    """Tolerance of a step."""
    return SWAYING if frictionless(mechanism) else RTOL


def verdict(mechanism, found):
    """Rows of what a verdict tells, what direct runs from the usual start tell, and whether these agree.

    A motion that repeats has the same numbers; of another one those of `TURNS` turns lie among those of other
    stretches as long, or near them.
    """
    period = int(found["period"])
    seen, repeats, end = numbers(mechanism, None, settling(mechanism), 1 if period else STRETCHES)
    told = {"force": "peak_force", "separations": "separations", "speed": "impact_speed"}
    for (what, name), values in seen.items():
        each = float(found[told[what]].sel(joint=name))
        if what == "separations" and mechanism.joint(name).contact.law == "restitution":
            each, values = float(each > 0), [float(value > 0) for value in values]  # rebounds go on for ever
        yield f"{what} {name}", each, values, near(each, values, REPEATING if period else WANDERING)
    yield "period", period, repeats, period == repeats
    chaos = not repeats and grows(mechanism, end)
    yield "chaos", bool(found["present"][-1] == 1), chaos, bool(found["present"][-1] == 1) == chaos
    ideal = largest_forces(recorded(mechanism.replace(clearance=0.0), before=0, turns=1))
    ratio = max(np.mean(seen["force", name]) / ideal[name] for name in ideal)
    top = {what: max(max(values) for key, values in seen.items() if key[0] == what) for what in told}
    grade, own = str(jp.words(found)["grade"].values), graded(top["separations"], ratio, top["speed"])
    yield "grade", grade, own, grade == own


def near(told, values, share):
    """Whether a number lies among others, or as near as a share of them."""
    return bool(min(values) * (1 - share) <= told <= max(values) * (1 + share))


def changed(joint, quantity, change):
    """A joint with other contact data."""
    factor = {"÷10": 0.1, "×10": 10.0, "÷3": 1 / 3, "×3": 3.0, "×2": 2.0}.get(change)
    if quantity == "friction":
        own = factor and joint.friction.model_copy(
            update={"coefficient": factor * joint.friction.coefficient}
        )
        return joint.model_copy(update={"friction": own})
    if quantity == "restitution":
        more = {"−0.2": -0.2, "+0.2": 0.2}[change]
        law = jp.Contact(law=quantity, parameters={quantity: joint.contact.parameters[quantity] + more})
    else:
        law = joint.contact.model_copy(update={quantity: factor * getattr(joint.contact, quantity)})
    return joint.model_copy(update={"contact": law})


def band(mechanism, found):
    """Rows of the band over contact data, as of `verdict`: of joints with clearance.

    A changed motion starts as usual; where several coexist, in the present motion's end. Of one that settles
    slowly one may not be known.
    """
    left = float(found["largest_multiplier"]) > SLOWLY
    for row in range(found.sizes["variant"]):
        here = found.isel(variant=row)
        if left and not np.isfinite(here["variant_peak_force"]).any():
            left = False
            continue
        what = [str(here[f"variant_{name}"].values) for name in ("quantity", "change")]
        joints = [changed(joint, *what) if joint.clearance else joint for joint in mechanism.joints]
        other = mechanism.model_copy(update={"joints": tuple(joints)})
        for begun in (False, True):
            start = numbers(mechanism, None, settling(mechanism), 1)[-1] if begun else None
            seen, repeats, _ = numbers(
                other, start, settling(other), 1 if here["variant_period"] else STRETCHES
            )
            share = BAND if repeats and here["variant_period"] else WANDERING
            names = {"force": "variant_peak_force", "speed": "variant_impact_speed"}
            rows = [
                (name, key[1], float(here[names[name]].sel(joint=key[1])), values)
                for name in names
                for key, values in seen.items()
                if key[0] == name and ("speed", key[1]) in seen
            ]
            agree = [near(told, values, share) for *_, told, values in rows]
            if all(agree):
                break
        for (name, joint, told, values), each in zip(rows, agree, strict=True):
            yield f"{' '.join(what)}: {name} {joint}", told, values, each


def every_edge(mechanism, found, reach=REACH):
    """Changes on any side that dense sweeps do not confirm."""
    pairs = itertools.product(map(str, found["parameter"].values), map(str, found["side"].values))
    return [wrong for pair in pairs for wrong in disagreements(mechanism, found, *pair, reach)]


@cache
def assessed(name):
    """The assessment of one of the linkages, looked at whole, or as far as there are derivatives."""
    found = jp.assess((MECHANISMS | TEN)[name](), budget=1e6)
    assert int(found["status"]) == 0
    assert np.isin(jp.words(found)["side_status"].values, ("ok", "no_derivative")).all()
    return found


@pytest.mark.nightly
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("name", MECHANISMS | TEN)
def test_edges_lie_between_neighbouring_cells_of_a_dense_sweep(name):
    assert every_edge((MECHANISMS | TEN)[name](), assessed(name)) == []


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("tell", [verdict, band])
@pytest.mark.parametrize("name", TEN)
def test_what_is_told_of_linkages_that_no_page_shows_is_so_in_direct_runs(name, tell):
    assert [row for row in tell(TEN[name](), assessed(name)) if not row[-1]] == []


@pytest.mark.nightly
def test_so_it_is_of_one_of_them_and_its_first_edge():
    linkage = TEN["rattling crank-rocker"]()
    found = jp.assess(linkage, along=["joints.B.clearance"], reach=1.13, budget=1e6, n_jobs=1)
    assert [row for row in verdict(linkage, found) if not row[-1]] == []
    assert found["edge_ratio"].sel(side="above", change="contact_loss") == pytest.approx(1.109, abs=1e-3)
    assert every_edge(linkage, found, 1.13) == []
