"""Edges of assessments against dense sweeps at rtol 1e-8: each lies between neighbouring cells that differ.

A sweep carries the motion from the present value outward over values 1 % apart, across each edge in steps a
tenth as long, and over both ends of its bracket. The cells next to the edge on both sides, outside its
error, must differ in the trait. No cell before the edge may differ from the present one, nor any where no
edge was met; in chaos, beyond the end of period 1, and where the page tells of narrow windows, no value
looked at. Where the trait is said to be as at present again, it has to be. Where a motion without a period
loses contact now and then, some cell beside the edge has to.

A cell that repeats over 60 turns with the expected traits has settled. The others, and those that confirm an
edge, are followed 440 turns more from where they stand, and their exponent is measured. What has not settled
then is followed 6000 more, as at an edge of chaos, which may die out late: an orbit that repeats and is not
stable, and what has neither period nor chaos. So a window is seen whose multiplier passes -1 by 0.004. Where
a value said to be chaotic is not so in the sweep, chaos has to last there, 440 turns and those of its
exponent, from one of the `STARTS` nearest chaotic cells: the page says that it lasts so long, and when it
dies out is chance.
"""

import itertools

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment.assess import REACH
from jointplay.analysis.assessment.edges import HOW
from jointplay.analysis.assessment.settled import CHANGES
from jointplay.analysis.sweeps.attractor import Plan, settle_together
from jointplay.solver.mechanism.catalog import preset_parts
from jointplay.solver.mechanism.catalog.preset_parts import fixed, on

MECHANISMS = {
    "four-bar, 0.029 mm, slow": lambda: jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=15.0),
    "four-bar, 0.29 mm": lambda: jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0),
    "slider-crank": lambda: jp.catalog.slider_crank(clearance={"B": 1e-4}),
    "quick return": lambda: jp.catalog.quick_return(clearance={"D": 5e-5}),
    "Watt": lambda: jp.catalog.watt(clearance={"D": 5e-5}),
}


def bars(lengths, pins, guides="", **more):
    """A linkage of uniform bars of 2 kg/m, with contact data at every joint."""
    laws = {"radius": 0.008, "stiffness": 8e6, "damping": 250.0, "friction": 0.08}
    joints = preset_parts.joined(pins, guides, **laws)
    return jp.Mechanism(links=preset_parts.bars(lengths, 2.0), joints=joints, **more)


def with_two_plays():
    """A four-bar whose rocker a spring draws back, with play at the crank's pin and at the ground."""
    ends = {"from": {"link": "rocker", "at": 0.07}, "to": {"link": "ground", "point": (0.2, 0.0)}}
    spring = jp.Spring(name="return", **ends, stiffness=300.0, free_length=0.05)
    drive = jp.ConstantSpeed(link="crank", speed=70.0)
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", 0.03), on("coupler")),
        "B": (on("coupler", 0.1), on("rocker", 0.07)),
        "C": (on("rocker"), fixed(0.1, 0.0)),
    }
    lengths = {"crank": 0.03, "coupler": 0.1, "rocker": 0.07}
    made = bars(lengths, pins, springs=(spring,), drive=drive)
    return made.replace(clearance={"A": 5e-5, "C": 8e-5})


def with_a_swinging_guide():
    """A crank's pin carries a rod that slides in a cylinder, which swings about C."""
    pins = {
        "O": (on("crank"), fixed(0.0, 0.0)),
        "A": (on("crank", 0.04), on("rod")),
        "S": (on("rod", 0.12), on("cylinder")),
        "C": (on("cylinder"), fixed(0.15, 0.0)),
    }
    drive = jp.ConstantSpeed(link="crank", speed=30.0)
    guess = {"crank": 0.0, "cylinder": np.pi}
    lengths = {"crank": 0.04, "rod": 0.12, "cylinder": 0.1}
    return bars(lengths, pins, "S", drive=drive, guess=guess).replace(clearance={"C": 1e-4})


OFFSET = {"crank": 0.03, "rod": 0.11, "offset": 0.008, "gravity": 9.8, "clearance": {"A": 1e-4}}
UNSHOWN = {  # by what no page shows: the linkage, what is varied, and how far
    "crank's pin": (lambda: jp.catalog.slider_crank(**OFFSET, speed=62.0), "speed", 1.2),
    "Stephenson": (lambda: jp.catalog.stephenson(clearance={"D": 1e-4}, speed=26.0), "speed", 1.2),
    "two plays": (with_two_plays, "joints.A.clearance", 1.5),
    "swinging guide": (with_a_swinging_guide, "speed", 1.3),
}
SECTION, RTOL = jp.CrankAngle(), 1e-8
SHORT, LONG, LASTING = 100, 440, 6000  # turns before a cell is looked at, and before it is looked at again
STARTS = 8  # chaotic motions from which it is tried again where chaos has died out
STEP, FINE, CELLS = 0.01, 0.1, 5  # relative step; of it the fine ones; their number on each side of an edge


def outward(looked, edges, others, even):
    """Ratios from 1 to the last value looked at, and which of them are values looked at.

    They are 1 % apart where `even`, else values looked at, about one in 1 %; and all beside an edge, which
    lies in the middle of a fine step.
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


def traits(found):
    """Answers of `CHANGES` of a settled motion."""
    value, error, follows = (
        float(np.ravel(found.get(f"section_{name}", np.nan))[0])
        for name in ("exponent_per_turn", "standard_error_per_turn", "batch_correlation")
    )
    follows = np.clip(follows, 0.0, 0.99)  # of batch means, by which their error is too small
    chaotic = int(found["period"]) == 0 and value > 3 * error * np.sqrt((1 + follows) / (1 - follows))
    return np.array([np.any(np.asarray(found["contact_fraction"]) < 1), int(found["period"]) != 1, chaotic])


def swept(mechanism, key, values, present, judged, needed):
    """Answers of `CHANGES` over the values, in their order: of the `needed` cells from the longer runs.

    `judged`, over values and `CHANGES`, says which answers have to be the `present` ones; `needed` has cells
    by change, those of chaos last.
    """
    way = "up" if abs(values[-1]) > abs(values[0]) else "down"
    settings = {"transient": SHORT, "turns": 60, "rtol": RTOL, "section": SECTION, "record": (), "n_jobs": 1}
    sweep = jp.bifurcation(mechanism, over={key: np.sort(values)}, direction=way, **settings)
    assert np.all(sweep["cell_status"] == 0)
    (dim,) = sweep["cell_status"].isel(direction=0).dims
    cells = [sweep.isel(direction=0).sel({dim: value}) for value in values]
    answers = np.array([traits(cell) for cell in cells])
    chaos = np.array([cell["period"].item() == 0 for cell in cells]) & judged[:, -1]  # perhaps
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
    return answers


def followed_on(places, starts, turns, averaged):
    """Answers of `CHANGES` of motions that are followed on; and whether these are settled.

    A period is where its orbit is stable, no period where the motion is chaotic.
    """
    lengths = {"turns": 60, "transient": turns, "lyapunov_turns": averaged}
    plan = Plan(SECTION, (), keep=1, exponents=1, rtol=RTOL, **lengths)
    answers, settled = np.zeros((len(places), len(CHANGES)), dtype=bool), np.zeros(len(places), dtype=bool)
    for i, one in enumerate(settle_together(list(zip(places, starts, strict=True)), plan)):
        assert one["status"] == 0, one["trouble"]
        described = {name: value for name, (_, value) in one["values"].items()}
        answers[i] = traits(described)
        stable = np.ravel(described["section_exponent_per_turn"])[0] < 0
        settled[i] = stable if described["period"] else answers[i, -1]
    return answers, settled


def by_change(ratios, here):
    """Cells that confirm each change: of an edge the last before and the first beyond it, outside its error.

    Of an irregular one those beside it. Also, over ratios and `CHANGES`, which lie before the edge.
    """
    cells, before = [], np.zeros((len(ratios), len(CHANGES)), dtype=bool)
    away = np.abs(np.log(ratios))
    for i, change in enumerate(CHANGES):
        one = here.sel(change=change)
        edge, error = float(one["edge_ratio"]), float(one["edge_ratio_error"])
        close = np.abs(ratios - edge) <= max((1 - 1e-9) * error, 1e-6)
        before[:, i] = ~close & ~(away >= abs(np.log(edge)))  # all of them where no edge was met
        if HOW[int(one["found_by"])] == "irregular":
            cells.append(np.flatnonzero(np.abs(np.log(ratios / edge)) < CELLS * FINE * STEP))
        elif np.isfinite(edge):
            beyond = ~close & (away > abs(np.log(edge)))
            cells.append(np.array([np.flatnonzero(before[:, i])[-1], np.flatnonzero(beyond)[0]]))
        else:
            cells.append(np.zeros(0, dtype=int))
    return cells, before


def disagreements(mechanism, found, key, side, reach):
    """Changes on one side whose edge, or its absence, the sweep does not confirm."""
    here = found.sel(parameter=key, side=side)
    present, begin = found["present"].values == 1, float(here["present_value"])
    edges, backs = here["edge_ratio"].values, here["return_ratio"].values
    irregular = np.array([HOW[how] == "irregular" for how in here["found_by"].values])
    ends = np.concatenate([here["bracket_low"].values, here["bracket_high"].values, backs])
    looked = here["looked_ratio"].values[np.isfinite(here["looked_ratio"].values)]
    looked = np.append(1.0, looked)
    told = (
        present[-1] or np.isfinite(here["window_low"].values).any()
    )  # of windows between the values looked at
    ratios, looked = outward(looked, edges[np.isfinite(edges)], ends[np.isfinite(ends)], not told)
    cells, judged = by_change(ratios, here)
    windows = here[["window_low", "window_high"]].to_array().values.T  # told of: no motion there is judged
    assert not np.any(windows[:, 1] / windows[:, 0] > 1 + float(found["lasting_share"]) + 1e-9)
    judged &= ~np.any([(low <= ratios) & (ratios <= high) for low, high in windows] + [ratios < 0], 0)[
        :, None
    ]
    judged &= ~irregular & (looked[:, None] | ~told)
    left = abs(np.log(edges[CHANGES.index("doubling")]))  # beyond it single values are looked at
    judged &= looked[:, None] | ~(np.abs(np.log(ratios)) > left)[:, None]
    again = [np.flatnonzero(ratios == back) for back in backs]
    needed = [np.concatenate(each) for each in zip(cells, again, strict=True)]
    last = max([*np.flatnonzero(judged.any(axis=1)), *np.concatenate(needed)], default=0) + 1
    ratios, judged = ratios[:last], judged[:last]
    answers = swept(mechanism, key, begin * ratios, present, judged, needed)
    for i, (change, edge) in enumerate(zip(CHANGES, edges, strict=True)):
        same = answers[:, i] == present[i]
        bad = not same[judged[:, i]].all() or not same[again[i]].all()
        if irregular[i]:  # seen in some of the cells
            bad |= same[cells[i]].all()
        elif np.isfinite(edge):
            bad |= same[cells[i]].tolist() != [True, False]
        if bad:
            yield key, side, change, edge, answers[:, i].tolist()


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", MECHANISMS)
def test_edges_lie_between_neighbouring_cells_of_a_dense_sweep(name):
    agrees_with_sweeps(MECHANISMS[name]())


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", UNSHOWN)
def test_so_do_edges_of_linkages_that_no_page_shows(name):
    make, along, reach = UNSHOWN[name]
    agrees_with_sweeps(make(), reach, along=[along])


def agrees_with_sweeps(mechanism, reach=REACH, **keywords):
    """Check every edge that is told, and that there is one."""
    found = jp.assess(mechanism, reach=reach, budget=1e6, **keywords)
    assert int(found["status"]) == 0
    assert np.all(found["side_status"] == 0)
    assert np.isfinite(found["edge_ratio"]).any()
    pairs = itertools.product(map(str, found["parameter"].values), map(str, found["side"].values))
    assert [wrong for pair in pairs for wrong in disagreements(mechanism, found, *pair, reach)] == []
