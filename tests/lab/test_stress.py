"""Stress: sound runs pass, planted faults are found, and the answers come as one dataset."""

import math
import tomllib
from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay import catalog
from jointplay.analysis.quantities import EVENTS, STATUS
from jointplay.analysis.starts import moved
from jointplay.display.errors import InputError
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.motion.trajectory import Request, follow
from jointplay_lab.stress import stress
from jointplay_lab.stress.stress import VERDICTS, cell, disagreement, judge, kick, move, residual, sizes, upto
from tests.support.tangent_map import tangent_map

TOLERANCES = (1e-8, 1e-10)
STUDY = Path(__file__).parents[2] / "studies/stress/stress_others.toml"
VARIANTS = tuple(tomllib.loads(STUDY.read_text())["analysis"]["variants"])


def never(*_) -> float:
    raise AssertionError("no growth was needed")


def scene_of(turning=3.0, clearance=2.9e-5):
    return assemble(catalog.chunmei2002(clearance, turning), None, powers=True)


@pytest.fixture(scope="module")
def sound():
    """The motion of Figure 12b: scene, the run in question, the tighter one."""
    scene = scene_of()
    loose, tight = (move(scene, 3, rtol, 10**5) for rtol in TOLERANCES)
    return scene, loose, tight, sizes(scene, tight)


def verdict(loose, tight, unit, grows=lambda *_: 30.0):
    found = judge(loose, tight, unit, TOLERANCES, grows)
    return found.verdict, found.cause


def test_a_sound_run_is_ok(sound):
    _, loose, tight, unit = sound
    assert verdict(loose, tight, unit, never) == ("ok", "none")
    assert loose.counts["n_events"] > 10
    assert judge(loose, tight, unit, TOLERANCES, never).excess < 0.1


def test_a_loose_run_passed_off_as_a_tight_one_is_suspect():
    mechanism = catalog.chunmei2002(2.9e-4, 3.0)
    scene = assemble(mechanism, None, powers=True)
    true, tight, false = (move(scene, 3, rtol, 10**5) for rtol in (*TOLERANCES, 2e-4))
    unit = sizes(scene, tight)
    own = stress.largest_growth(assemble(mechanism), unit, 3, 1e-8, 10**5)
    assert verdict(true, tight, unit, lambda *_: own) == ("ok", "none")
    assert verdict(false, tight, unit, lambda *_: own) == ("suspect", "states")
    assert verdict(true, false, unit, lambda *_: own)[0] == "suspect"
    twin = disagreement(move(kick(scene, 1e-10 * unit), 3, 1e-10, 10**5), tight, unit) / 1e-10
    assert 1.0 < twin < own
    assert verdict(false, tight, unit, lambda *_: twin) == ("suspect", "states")


def test_a_broken_energy_balance_is_suspect(sound):
    scene, loose, tight, unit = sound
    coupling = parameter_names(scene.structure).index("H_crank_coupler")
    heavier = scene.numbers * np.where(np.arange(len(scene.numbers)) == coupling, 1 + 1e-4, 1.0)
    records = follow(scene, Request(3 * scene.period, 1e-8, at=np.linspace(0, 3 * scene.period, 145)))
    broken = residual(replace(scene, numbers=heavier), records)
    assert residual(scene, records) == pytest.approx(loose.residual)
    assert verdict(replace(loose, residual=broken), tight, unit) == ("suspect", "energy")
    assert verdict(loose, replace(tight, residual=broken), unit) == ("suspect", "energy")


@pytest.mark.parametrize("kind", ["contact", "separation"])
def test_a_missed_event_is_suspect(sound, kind):
    _, loose, tight, unit = sound
    first = int(np.flatnonzero(loose.events[:, 1] == EVENTS.index(kind))[0])
    missing = replace(loose, events=np.delete(loose.events, first, axis=0))
    assert verdict(missing, tight, unit) == ("suspect", "contacts")


def test_a_touch_as_slight_as_the_tolerance_may_be_missed(sound):
    _, loose, tight, unit = sound
    slight = np.array([[0, EVENTS.index("contact"), 1e-6], [0, EVENTS.index("separation"), -1e-6]])
    touched = replace(loose, events=np.concatenate([loose.events, slight]))
    assert verdict(touched, tight, unit) == ("ok", "none")


def test_contacts_that_touch_together_may_do_so_in_either_order(sound):
    _, loose, tight, unit = sound
    corner = np.where(np.arange(3) == 0, 1.0, 0.0)
    first, *others = loose.events
    beside = np.concatenate([[first, first + corner], others])
    swapped = np.concatenate([[first + corner, first], others])
    assert verdict(replace(loose, events=swapped), replace(tight, events=beside), unit) == ("ok", "none")
    late = np.concatenate([[first + corner], others, [first]])
    assert verdict(replace(loose, events=late), replace(tight, events=beside), unit) == (
        "suspect",
        "contacts",
    )


def test_lost_values_are_suspect(sound):
    _, loose, tight, unit = sound
    assert verdict(replace(loose, states=loose.states * np.nan), tight, unit)[0] == "suspect"
    assert verdict(replace(loose, residual=math.nan), tight, unit) == ("suspect", "energy")


def test_runs_that_stop_are_told_apart(sound):
    _, loose, tight, unit = sound
    stopped = [
        replace(one, status=STATUS.index("step_limit"), states=one.states[:50]) for one in (loose, tight)
    ]
    assert verdict(stopped[0], stopped[1], unit)[0] == "stopped"
    assert verdict(stopped[0], tight, unit)[0] == "unconfirmed"
    assert verdict(loose, stopped[1], unit)[0] == "unconfirmed"
    off = replace(stopped[0], states=stopped[0].states * 1.01)
    assert verdict(off, stopped[1], unit) == ("suspect", "states")


def test_chaos_is_sensitive_and_nothing_worse():
    """The motion of Figure 12c: errors grow about fourfold a turn."""
    mechanism, turns = catalog.chunmei2002(2.9e-4, 3.0), 12
    scene = assemble(mechanism, None, powers=True)
    loose, tight = (move(scene, turns, rtol, 10**5) for rtol in TOLERANCES)
    unit = sizes(scene, tight)
    own = stress.largest_growth(assemble(mechanism), unit, turns, 1e-8, 10**5)
    assert 4**8 < own < 1e12
    assert verdict(loose, tight, unit, lambda *_: own) == ("sensitive", "none")
    assert verdict(loose, tight, unit, lambda *_: 1.0) == ("suspect", "states")


def test_a_twin_starts_with_other_speeds_and_counts_as_far_as_the_run_came(sound):
    scene, loose, tight, unit = sound
    kicked = kick(scene, 1e-3 * unit)
    assert np.flatnonzero(kicked.state != scene.state).tolist() == [*range(len(scene.turning), len(unit))]
    short = replace(loose, states=loose.states[:9])
    assert len(upto(tight, short).states) == len(upto(tight, short).met) == 9


@pytest.mark.nightly
def test_bodies_that_rattle_and_rest_are_sensitive_by_a_twin():
    """Three rough rigid bearings: derivatives explain a thirteenth of what two tolerances differ by."""
    found = cell(catalog.chunmei2002(), 2566, 0, VARIANTS, 1, 1e-8, 10**5)
    assert VERDICTS[found["verdict"]] == "sensitive"
    assert found["disagreement"] > 1e-4
    assert found["growth"] > 1e6


@pytest.mark.nightly
def test_growth_is_the_largest_between_any_two_times_or_adds_up(monkeypatch):
    """Lorenz's system in three blocks, against derivatives of the flow over each of them.

    From this start it is the last two blocks together, neither the whole nor one of them.
    """
    scene = assemble(catalog.lorenz(), (5.0, 8.0, 15.0))
    monkeypatch.setattr(stress, "BLOCKS", 3)
    unit, third = np.array([1.0, 3.0, 0.5]), scene.period / 3
    places = follow(scene, Request(scene.period, 1e-11, at=third * np.arange(3))).samples[:, 1:4]
    maps = [tangent_map(moved(scene, place), third) * unit / unit[:, None] for place in places]
    found = stress.largest_growth(scene, unit, 1, 1e-9, 10**5)
    norms = [[np.linalg.norm(reduce(np.matmul, reversed(maps[i:j])), 2) for i in range(j)] for j in (1, 2, 3)]
    assert found == pytest.approx(max(map(max, norms)), rel=1e-5)
    assert found > 2 * max(np.linalg.norm(each, 2) for each in (*maps, reduce(np.matmul, reversed(maps))))
    monkeypatch.setattr(stress, "ADDED", 0.9)
    added = stress.largest_growth(scene, unit, 1, 1e-9, 10**5)
    assert added == pytest.approx(0.9 * max(map(sum, norms)), rel=1e-5)
    assert added > 1.1 * found


@pytest.mark.nightly
def test_growth_is_looked_at_more_closely(monkeypatch):
    scene, unit = assemble(catalog.lorenz(), (5.0, 8.0, 15.0)), np.array([1.0, 3.0, 0.5])
    found = []
    for blocks, closer in ((6, 1), (3, 2), (3, 1)):
        monkeypatch.setattr(stress, "BLOCKS", blocks)
        found.append(stress.largest_growth(scene, unit, 1, 1e-9, 10**5, closer))
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert found[0] > 1.01 * found[2]


def test_growth_within_a_block_explains_only_what_it_reaches(sound):
    _, loose, tight, unit = sound
    off, asked = replace(loose, states=loose.states + 3e-6 * unit), []

    def grows(tighter: bool, closer: int, most: float = 1e4) -> float:
        asked.append((tighter, closer))
        return min(100.0 * closer**2, most)

    assert verdict(off, tight, unit, grows)[0] == "sensitive"
    assert asked == [(False, 1), (False, 4)]
    asked.clear()
    assert verdict(off, tight, unit, lambda *look: grows(*look, 100.0)) == ("suspect", "states")
    assert asked == [*((tighter, closer) for tighter in (False, True) for closer in (1, 4, 16)), (True, 0)]


def test_a_bounce_that_just_happens_is_as_fast_as_the_root_of_what_made_it(sound):
    _, loose, tight, unit = sound
    off = replace(loose, states=loose.states + 1e-6 * unit)

    def bounced(speed: float):
        bounce = np.array([[0, EVENTS.index("separation"), -speed], [0, EVENTS.index("contact"), speed]])
        return replace(off, events=np.concatenate([loose.events, bounce]))

    def found(motion) -> tuple[str, str]:
        return verdict(motion, tight, unit, lambda *_: 1e3)

    largest = max(1.0, np.abs(loose.events[:, 2]).max())
    assert found(bounced(0.5e-3 * largest)) == ("sensitive", "none")
    assert found(bounced(5e-3 * largest)) == ("suspect", "contacts")
    assert found(replace(bounced(0.5e-3 * largest), states=tight.states)) == ("suspect", "contacts")


@pytest.fixture(scope="module")
def few():
    return jp.stress(scenes=5, first=70, variants=("rigid",), listed=2, n_jobs=1)


def test_a_small_study(few):
    assert few.sizes == {"scene": 5, "rank": 2}
    assert few.scene.values.tolist() == [70, 71, 72, 73, 74]
    assert set(few.verdict.values) <= {VERDICTS.index(word) for word in ("ok", "sensitive")}
    assert STATUS[int(few.status)] == "ok"
    assert float(few.energy_residual.max()) < 1e-6
    for name, variable in few.variables.items():
        assert variable.attrs["long_name"], name
        assert "units" in variable.attrs or variable.dtype.kind in "iUT", name


def test_scenes_do_not_depend_on_how_many_there_are(few):
    part = jp.stress(scenes=2, first=72, variants=("rigid",), listed=2, n_jobs=1)
    shared = [name for name in few.data_vars if few[name].dims == ("scene",) and not name.endswith("_time")]
    xr.testing.assert_identical(part[shared], few[shared].isel(scene=slice(2, 4)))


def test_the_lists_are_in_order(few):
    slowest, worst = (few.sel(scene=few[word].values) for word in ("slowest", "worst"))
    assert float(slowest.cpu_time[0]) == float(few.cpu_time.max())
    assert float(worst.excess[0]) == float(few.excess.max())
    assert float(worst.excess[0]) >= float(worst.excess[1])


def test_a_scene_that_crashes_is_suspect(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(stress, "_warm", lambda *_: None)
    monkeypatch.setattr(stress, "move", broken)
    found = jp.stress(scenes=2, first=70, variants=("rigid",), n_jobs=1)
    assert [VERDICTS[code] for code in found.verdict.values] == ["suspect", "suspect"]
    assert STATUS[int(found.status)] == STATUS[int(found.scene_status[0])] == "crashed"
    assert "oh" in str(found.trouble[0].values)


def test_one_scene_that_crashes_is_told_by_the_status(monkeypatch):
    left = [ZeroDivisionError("oh")]

    def broken_once(*given):
        if left:
            raise left.pop()
        return move(*given)

    monkeypatch.setattr(stress, "move", broken_once)
    found = jp.stress(scenes=2, first=70, variants=("rigid",), n_jobs=1, max_steps=200)
    assert STATUS[int(found.status)] == STATUS[int(found.scene_status[0])] == "crashed"
    assert STATUS[int(found.scene_status[1])] != "crashed"


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"variants": ("rigit",)}, r"variants\[0\].*did you mean 'rigid'"),
        ({"variants": ()}, "variants: .*at least one"),
        ({"scenes": 0}, "scenes: .*at least 1"),
        ({"rtol": 1.0}, "rtol"),
        ({"mechanism": catalog.duffing()}, "mechanism.*motor-driven"),
        ({"mechanism": catalog.chunmei2002(speed=80.0)}, "mechanism.*motor-driven"),
    ],
)
def test_wrong_input(options, word):
    with pytest.raises(InputError, match=word):
        jp.stress(**{"scenes": 1} | options)
