"""When a motion has settled, when its chaos lasts, and how far its forces are known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment import branch_walk
from jointplay.analysis.assessment import edges as edges_module
from jointplay.analysis.assessment import settled as settled_module
from jointplay.analysis.assessment.alternatives import hangs_on
from jointplay.analysis.assessment.assess import assembled, assessed
from jointplay.analysis.assessment.branch_walk import Branch, Place, Walk
from jointplay.analysis.assessment.forces import SHOWN, _mean, _peak_error, _shown
from jointplay.analysis.assessment.settled import (
    CHANGES,
    LASTING,
    PATIENCE,
    SURE,
    Settled,
    lasting,
    plan,
    present,
    settled,
)
from jointplay.analysis.orbits.section_map import Image
from jointplay.analysis.orbits.shooting import Orbit, newton
from jointplay.analysis.starts import End
from jointplay.solver.mechanism.catalog import presets
from jointplay.solver.mechanism.catalog.presets import four_bar_pins
from jointplay.solver.method.codes import Status

HOW = plan(10, 8, 20, 1e-7, None)
STABLE, CHAOTIC, UNSURE = -1.0, 1.0, 0.1


def motion(period, exponent=STABLE):
    numbers = {"exponent_per_turn": exponent, "standard_error_per_turn": 0.1, "batch_correlation": 0.0}
    values = {f"section_{name}": (("multiplier",), [each]) for name, each in numbers.items()}
    values |= {"period": ((), period), "contact_fraction": (("joint",), [1.0])}
    return Settled(None, End((), np.zeros(0), 0.0), values)


@pytest.mark.parametrize(("exponent", "chaotic"), [(0.00227, False), (0.008, False), (0.009, True)])
def test_a_motion_whose_neighbours_part_no_faster_than_time_is_not_chaotic(exponent, chaotic):
    """An undamped swing, measured over 800 turns with an error of 0.00064: ln 800 / 800 is 0.00836."""
    own = {"exponent_per_turn": exponent, "standard_error_per_turn": 0.00064, "batch_correlation": 0.0}
    values = {f"section_{name}": (("multiplier",), [each]) for name, each in own.items()}
    values |= {"period": ((), 0), "exponent_turns": ((), 800.0)}
    assert Settled(None, End((), np.zeros(0), 0.0), values).traits["chaos"] is chaotic


@pytest.fixture
def followed(monkeypatch):
    """Motions found one after another; the settings of each."""
    answers, asked = [], []

    def next_one(mechanism, start, how):
        asked.append(how)
        return answers.pop(0)

    monkeypatch.setattr(settled_module, "followed", next_one)
    monkeypatch.setattr(settled_module, "_sought", lambda *_: (None, None))  # there is no orbit nearby
    return answers, asked


@pytest.mark.parametrize(
    ("periods", "last", "looks"),
    [([1], 1, 1), ([2, 1], 1, 2), ([2, 2], 2, 2), ([2, 4, 4], 4, 3), ([2, 4, 2, 1], 1, 4)],
)
def test_a_period_other_than_the_usual_counts_when_it_is_found_again(followed, periods, last, looks):
    """A motion that alternates as it decays seems to have period 2."""
    answers, asked = followed
    answers += [motion(period) for period in periods]
    assert settled(None, None, HOW).period == last
    assert [how.transient for how in asked[1:]] == [more * HOW.transient for more in PATIENCE[: looks - 1]]


def test_what_an_exponent_has_not_said_is_asked_for_over_more_turns(followed):
    answers, asked = followed
    answers += [motion(0, np.nan), motion(0, UNSURE), motion(0, UNSURE), motion(0, CHAOTIC)]
    assert settled(None, None, HOW).traits["chaos"]
    assert [how.lyapunov_turns // HOW.lyapunov_turns for how in asked[1:]] == [1, SURE, SURE]


def test_a_motion_stands_as_it_was_followed_where_the_search_of_its_orbit_ends_early(followed, monkeypatch):
    def ended(*_):
        raise settled_module.Unsettled(2)

    answers, _ = followed
    answers += [motion(3), motion(3)]
    monkeypatch.setattr(settled_module, "_sought", ended)
    assert settled(None, None, HOW).period == 3


@pytest.mark.parametrize(("exponent", "sought"), [(-1.0, 0), (-0.01, 1)])
def test_only_what_hardly_decays_is_taken_for_a_swing(followed, monkeypatch, exponent, sought):
    answers, _ = followed
    answers += [motion(2, exponent), motion(2, exponent)]
    orbits, orbit = [], motion(1)
    monkeypatch.setattr(settled_module, "_sought", lambda *_: (orbits.append(orbit) or orbit, None))
    assert settled(None, None, HOW).period == 2 - sought
    assert len(orbits) == sought


def test_chaos_that_dies_out_is_the_orbit_that_it_becomes(followed):
    answers, asked = followed
    answers += [motion(0, CHAOTIC), motion(3)]
    assert lasting(motion(0, CHAOTIC), HOW).period == 3
    assert [how.transient for how in asked] == [more * HOW.transient for more in LASTING[:2]]
    answers += [motion(0, CHAOTIC)] * 3
    assert lasting(begun := motion(0, CHAOTIC), HOW) is begun
    assert not answers


@pytest.mark.parametrize(("exponent", "waits"), [(UNSURE, 0), (CHAOTIC, len(LASTING))])
def test_what_has_neither_period_nor_chaos_is_asked_for_longer(followed, exponent, waits):
    answers, asked = followed
    answers += [motion(0, exponent)] + [motion(0, CHAOTIC)] * waits
    found = lasting(motion(0, UNSURE), HOW)
    assert found.traits["chaos"] == (exponent == CHAOTIC)
    assert asked[0] == replace(HOW, transient=0, exponents=1, lyapunov_turns=SURE * HOW.lyapunov_turns)
    assert len(asked) == 1 + waits
    assert lasting(periodic := motion(2), HOW) is periodic


def test_beside_a_chaotic_motion_each_is_watched_for_whether_its_chaos_lasts(monkeypatch):
    """Chaos all along, as it seems; from 1.2 times the present value on it dies out before long."""
    begun, met = motion(0, CHAOTIC), []

    def at(carried, value, before):
        met.append(motion(0, CHAOTIC))
        places[met[-1]] = value
        return met[-1]

    places = {begun: 1.0}
    ends = {"lasting": lambda each, *_: motion(1) if places.get(each, 1.0) >= 1.2 else each}
    ends |= {"Parameter": lambda *_: SimpleNamespace(value=1.0, noun="clearance")}
    ends["_halved"] = lambda side, carried, name, last, spot, _: side.change(
        name, spot[0], spot[0], "bracketed"
    )
    for name, each in ends.items():
        monkeypatch.setattr(edges_module, name, each)
    monkeypatch.setattr(edges_module.Carried, "at", at)
    monkeypatch.setattr(edges_module.Carried, "stretch", lambda *_: None)
    found = edges_module.edges(begun, "clearance", "above", edges_module.Search(2.0, 0.01, 1e-3), HOW)
    edge = dict(zip(CHANGES, found["edge"], strict=True))["chaos"]
    assert edge == places[next(each for each in met if places[each] >= 1.2)]


def test_behind_an_orbit_what_has_no_period_is_asked_whether_it_is_chaotic(monkeypatch):
    """Its exponent does not say so in the few turns that a motion is first followed."""
    monkeypatch.setattr(edges_module, "settled", lambda *_: motion(0, UNSURE))
    lasting = lambda given, *_: given if given.period else motion(0, CHAOTIC)  # noqa: E731
    monkeypatch.setattr(edges_module, "lasting", lasting)
    side = edges_module.Side(here := motion(1), 2e-4)
    how = edges_module.Remembering(**vars(HOW))
    carried = edges_module.Carried(jp.catalog.slider_crank(), "joints.B.clearance", how)
    edges_module._beyond(side, carried, edges_module.Search(2.0, 0.01, 1e-3), (2e-4, here), 1, 0.02)
    edge, *_, how = side.found["chaos"]
    assert edges_module.HOW[how] == "bracketed"
    assert edge == pytest.approx(2e-4, rel=2e-3)


def test_chaos_is_over_where_there_is_a_period_and_not_where_nothing_is_sure():
    side = edges_module.Side(motion(1), 1.0, 0.01, 1.0)
    side.change("chaos", 1.1, 1.1, "bracketed")
    for value, each in (
        (1.2, motion(0, CHAOTIC)),
        (1.3, motion(0, UNSURE)),
        (1.4, motion(3)),
        (1.5, motion(5)),
    ):
        side.motion_at((value, each))
    assert side.found["chaos"][-2] == 1.4


def test_contact_is_kept_again_where_there_is_a_period_and_not_where_its_loss_was_not_seen():
    """A motion without a period may lose it now and then."""
    side = edges_module.Side(motion(1), 1.0, 0.01, 1.0)
    side.change("contact_loss", 1.1, 1.1, "irregular")
    for value, each in ((1.2, motion(0, CHAOTIC)), (1.3, motion(4)), (1.4, motion(1))):
        side.motion_at((value, each))
    assert side.found["contact_loss"][-2] == 1.3


@pytest.mark.long
def test_forces_of_what_is_not_followed_to_its_end_are_a_status_and_a_word():
    linkage = jp.catalog.chunmei2002(clearance=2.9e-5)
    found = assessed(linkage, None, 1, replace(HOW, max_steps=5), np.inf)
    assert {name: found[name] for name in ("status", "trouble")} == {"status": 2, "trouble": "step_limit"}
    table = assembled(linkage, ["gear_ratio"], found, found, found, [found], 2 * [found])
    assert table["peak_force"].isnull().all()
    assert str(jp.words(table)["grade"].values) == "unknown"
    assert table["turn_share"].values == pytest.approx(
        np.arange(table.sizes["turn_share"]) * table["turn_share"][1].item()
    )
    assert table["turn_share"][-1] == 1.0


@pytest.fixture
def wiper():
    """Displaced journals lose 0.36 to 0.43 % of their swing a turn in runs of 400 turns, at any tolerance."""
    lengths, masses, inertias = (0.045, 0.31, 0.09), (0.18, 0.42, 0.35), (3.1e-5, 3.4e-3, 2.4e-4)
    rows = zip(("crank", "coupler", "rocker"), lengths, masses, inertias, strict=True)
    links = [jp.Link(name=n, length=x, mass=m, centre=x / 2, inertia_centre=i) for n, x, m, i in rows]
    pins = four_bar_pins(0.045, 0.31, 0.09, 0.3)
    joints = presets.joined(pins, "", radius=0.006, stiffness=1e7, damping=300.0, friction=0.0)
    drive = jp.ConstantSpeed(link="crank", speed=65 * np.pi / 30)
    return jp.Mechanism(links=links, joints=joints, drive=drive).replace(clearance={"B": 6e-5})


@pytest.mark.parametrize(("find", "how"), [(present, plan(100, 32, 200, 1e-7, None)), (settled, HOW)])
def test_a_journal_that_swings_without_friction_is_known_by_its_orbit(wiper, find, how):
    """The shorter settings wait for some 450 turns in all: a sixth of the swing is left then."""
    found = find(wiper, None, how)
    assert found.period == 1
    assert 0.9957 < found.radius < 0.9964
    assert found.traits == {"contact_loss": False, "doubling": False, "chaos": False}


def test_a_motion_with_other_contact_data_that_fails_is_a_status(wiper):
    how = plan(4, 4, 4, 1e-7, None)
    found = hangs_on(settled_module.followed(wiper, None, how), 2, replace(how, max_steps=3))
    assert (found["statuses"] == Status.STEP_LIMIT).all()
    assert np.isnan(found["peak"]).all()


def history(forces):
    return {"reaction": np.array(forces, dtype=float)[:, None], "time": np.arange(len(forces), dtype=float)}


@pytest.mark.parametrize(
    ("forces", "coarse", "error"),
    [
        ([1, 9, 1, 9, 3, 1], [1, 1, 3], 6.0),  # the halves agree, every second sample misses the largest
        ([9, 1, 2, 3, 5, 1], [9, 2, 5], 4.0),  # the samples agree, the halves do not
        ([9, 8, 2, 3, 9, 1], [9, 2, 9], 9e-12),  # nothing differs but by rounding
    ],
)
def test_the_error_of_a_largest_force_is_the_larger_of_two(forces, coarse, error):
    largest = lambda given: given["reaction"].max(axis=0)  # noqa: E731
    fine = history(forces)
    assert _peak_error(largest, largest(fine), fine, history(coarse), 2.5) == pytest.approx(error)


def test_what_is_shown_of_a_force_has_its_peak_and_its_lowest_values():
    """A spike of a thousandth of a turn, in the second of three turns; the rest is a sine."""
    times = np.sort(np.append(np.linspace(0.0, 3.0, 3 * 4096 + 1), 1.3 + np.array([0.0, 2e-4, 4e-4])))
    sizes = 2.0 + np.sin(2 * np.pi * times)
    sizes[np.searchsorted(times, 1.3 + 2e-4)] = 9.0
    shown, share = _shown(times, sizes, 9.5, np.arange(4.0)), np.linspace(0.0, 1.0, 2 * SHOWN + 1)
    assert share[np.argmax(shown)] == pytest.approx(0.3, abs=2 / SHOWN)
    assert (shown.max(), shown.min()) == pytest.approx((9.5, 1.0), abs=1e-5)
    usual = shown < 9.0
    np.testing.assert_allclose(shown[usual], 2.0 + np.sin(2 * np.pi * share[usual]), atol=0.02)


def test_the_error_of_a_mean_over_turns_is_that_of_its_scatter_and_of_its_samples():
    each, coarse = np.array([[1.0], [3.0], [1.0], [3.0]]), np.array([[1.5], [3.5], [1.5], [3.5]])
    scatter = np.sqrt(4 / 3) / 2
    assert _mean("loss", each, each)["loss_error"] == pytest.approx([scatter])
    assert _mean("loss", each, coarse)["loss_error"] == pytest.approx([np.hypot(scatter, 0.5)])
    assert _mean("loss", each, coarse)["loss"] == pytest.approx([2.0])


def carried():
    how = edges_module.Remembering(**vars(HOW))
    return edges_module.Carried(SimpleNamespace(varied=lambda given: given["clearance"]), "clearance", how)


@pytest.mark.parametrize(("lasts_from", "edge"), [(1.5, 1.5), (1.53, 1.53), (1.7, np.nan)])
def test_chaos_in_between_is_asked_for_less_long_than_that_of_the_edge(monkeypatch, lasts_from, edge):
    """From 1.5 times the present value on there is chaos, which is transient up to another value."""
    here, places, asked = motion(1), {}, []

    def made(value, *_):
        return places.setdefault(value, motion(0, CHAOTIC) if value >= 1.5 else motion(1))

    def lasting(given, how, waits):
        asked.append(waits)
        value = next((value for value, each in places.items() if each is given), 1.0)
        return motion(1) if waits == LASTING and 1.5 <= value < lasts_from else given

    monkeypatch.setattr(edges_module, "settled", made)
    monkeypatch.setattr(edges_module, "lasting", lasting)
    side, last, first = edges_module.Side(here, 1.0), (1.4, made(1.4)), (1.6, made(1.6))
    edges_module._halved(side, carried(), "chaos", last, first, edges_module.Search(2.0, 0.01, 1e-3))
    assert side.found["chaos"][0] == pytest.approx(edge, rel=1e-3, nan_ok=True)
    if lasts_from == 1.5:
        assert asked.count(LASTING) == 2


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_narrow_window_just_behind_where_chaos_begins_is_passed_over(monkeypatch, way):
    """Chaos begins at 1.4996 times the present value; the first halving falls into a window of period 1."""

    def made(value, *_):
        return motion(0, CHAOTIC) if abs(value) > 1.4996 and abs(abs(value) - 1.5) > 1e-4 else motion(1)

    monkeypatch.setattr(edges_module, "settled", made)
    monkeypatch.setattr(edges_module, "lasting", lambda given, *_: given)
    side, last, first = edges_module.Side(motion(1), way), (way * 1.4, made(1.4)), (way * 1.6, made(1.6))
    edges_module._halved(side, carried(), "chaos", last, first, edges_module.Search(2.0, 0.01, 1e-3))
    _, _, low, high, *_ = side.found["chaos"]
    assert min(abs(low), abs(high)) <= 1.4996 <= max(abs(low), abs(high))
    assert high - low <= 1.5e-3


@pytest.mark.parametrize(
    ("periods", "window"),
    [
        ((0, 2, 0, 1, 0), (1.0, 1.0075)),
        ((0, 1, 0, 0, 3), (1.0, 1.0025)),
        ((0, 2, 0, 0, 2), None),
        ((1,), None),
    ],
)
def test_behind_an_orbits_end_what_soon_has_its_period_again_ends_a_window(monkeypatch, periods, window):
    """The motion just beyond the end; then those of four parts of the share that a change has to last."""
    values = (1.0, 1.0025, 1.005, 1.0075, 1.01)
    by_value = dict(zip(values, periods + periods[-1:] * 4, strict=False))

    def made(value, *_):
        return motion(by_value[min(by_value, key=lambda each: abs(each - value))])

    monkeypatch.setattr(edges_module, "followed", made)
    monkeypatch.setattr(edges_module, "settled", made)
    monkeypatch.setattr(edges_module, "lasting", lambda given, *_: given)
    monkeypatch.setattr(edges_module, "Parameter", lambda *_: SimpleNamespace(value=0.9, noun="clearance"))
    side = edges_module.Side(here := motion(1), 1.0, 0.01, 0.9)
    search, end = edges_module.Search(2.0, 0.0025, 0.9e-3), ((1.0, here), 1.0, 1.0, "period_doubling")
    behind = edges_module._behind(side, carried(), search, end, 1)
    if window:
        ((low, high, period),) = side.windows.values()
        assert (low, high) == pytest.approx(window, rel=1e-3)
        assert period == 0
        assert (behind[0], behind[1].period) == (pytest.approx(window[1], rel=1e-3), 1)
    else:
        assert not side.windows
    edge = side.found["doubling"][0]
    assert edge == pytest.approx(1.0, rel=1e-3) if periods[-1] == 2 else np.isnan(edge)


def test_where_an_orbit_ends_is_known_as_well_as_its_tolerance_lets_it(monkeypatch):
    monkeypatch.setattr(edges_module, "followed", lambda *_: motion(2))
    monkeypatch.setattr(edges_module, "settled", lambda *_: motion(2))
    monkeypatch.setattr(edges_module, "Parameter", lambda *_: SimpleNamespace(value=0.9, noun="clearance"))
    side = edges_module.Side(here := motion(1), 1.0, 0.01, 0.9)
    end = ((1.0, here), 0.9999, 1.0001, edges_module.ENDED)
    edges_module._behind(side, carried(), edges_module.Search(2.0, 0.0025, 1e-3), end, 1)
    _, _, low, high, _, how = side.found["doubling"]
    assert (low, high) == (0.9999, 1.0001 * 1.001)
    assert edges_module.HOW[how] == "bracketed"


@pytest.mark.parametrize("begin", [20.0, -20.0])
def test_an_orbit_is_sure_up_to_shortly_before_its_end_but_in_no_window(begin):
    """By 10⁻⁴, or half of what lies between a window and the end."""
    side = edges_module.Side(motion(1), begin, 0.01, begin)
    assert edges_module._held(side, 0.9 * begin, -1) == pytest.approx(0.9 * begin * np.exp(1e-4), rel=1e-12)
    both = begin * np.array([[0.75634, 0.7579], [0.74, 0.75]])
    side.windows = {high: (low, high, 2) for low, high in both}
    assert edges_module._held(side, 0.75632 * begin, -1) == pytest.approx(0.75633 * begin, rel=1e-9)
    assert edges_module._held(side, 0.75634 * begin, -1) == pytest.approx(0.75634 * begin, rel=1e-12)


class Walked:
    """Places of one orbit, of which each is known; contact is lost from one value to another."""

    ended = None

    def __init__(self, low, high, values):
        self.low, self.high = low, high
        self.rest = [self.place(each) for each in values]
        self.places = [self.rest.pop(0)]

    def place(self, value):
        lost = self.low <= value < self.high
        return SimpleNamespace(value=value, stable=True, lost=lost, at_start=lambda: np.zeros(2))

    def onward(self):
        self.places.append(place := self.rest.pop(0) if self.rest else None)
        return place

    def enclosed(self, met):
        inner, outer = (each.value for each in self.places[-2:])
        while outer - inner > 1e-6:
            middle = (inner + outer) / 2
            inner, outer = (inner, middle) if met(self.place(middle)) else (middle, outer)
        return self.place(inner), self.place(outer)


@pytest.mark.parametrize(("high", "window"), [(1.108, True), (1.112, False)])
def test_contact_is_kept_again_from_the_exact_place_on(high, window):
    """Where it was lost for less than the share of 1 %, though the next value looked at is farther."""
    side = edges_module.Side(motion(1), 1.0, 0.01, 1.0)
    walk = Walked(1.1, high, [1.0, 1.05, 1.103, 1.115, 1.2])
    assert edges_module._along_branch(side, walk) is None
    edge, *_, back, _ = side.found["contact_loss"]
    if window:
        assert np.isnan(edge)
        (found,) = side.windows.values()
        assert found == pytest.approx((1.1, high, 1), abs=2e-6)
    else:
        assert (edge, back) == pytest.approx((1.1, high), abs=2e-6)
        assert not side.windows


@pytest.mark.parametrize(("wide", "halved"), [(1, False), (3, True)])
def test_beyond_an_orbit_what_is_known_to_be_taken_back_soon_is_not_halved(monkeypatch, wide, halved):
    """From the third motion on, of those 0.4 % apart, there is another period for so many of them."""
    step, tried = 0.004, []

    def made(calls, _):
        tried.extend(call.args[0] for call in calls)
        return [motion(2 if 2 <= number < 2 + wide else 1) for number in range(len(calls))]

    monkeypatch.setattr(edges_module, "batch", made)
    monkeypatch.setattr(edges_module, "settled", lambda value, *_: asked.append(value) or motion(1))
    side, asked = edges_module.Side(here := motion(1), 1.0, 0.01, 1.0), []
    edges_module._beyond(side, carried(), edges_module.Search(2.0, step, 1e-3), (1.0, here), 1, 10 * step)
    assert bool(asked) == halved
    edge = side.found["doubling"][0]
    if halved:
        assert edge == pytest.approx(tried[2], rel=1.1e-3)
        assert not side.windows
    else:
        assert np.isnan(edge)
        (found,) = side.windows.values()
        assert found == pytest.approx((np.sqrt(tried[1] * tried[2]), tried[3], 2), rel=1e-4)


def test_a_side_without_a_word_of_how_it_ended_was_not_looked_at():
    crank = jp.catalog.slider_crank(clearance={"B": 1e-4})
    found = {"status": 2, "trouble": "step_limit"}
    table = jp.words(assembled(crank, ["speed"], found, found, found, [found], [{}, found]))
    assert table["side_status"].values.tolist() == [["not_run", "step_limit"]]


class Squared:
    """A section on which a turn squares the one state, which is fixed at 0."""

    free, phase = np.array([0]), 0.0
    model = SimpleNamespace(turning=np.array([1.0]))

    def __init__(self):
        self.seen = []

    def image(self, state):
        self.seen.append(float(state[0]))
        return Image(0, state**2, 1.0, np.diag(2 * state))

    def differ(self, one, other):
        return one - other

    def unknowns(self, state):
        return state

    state = unknowns


def test_the_step_from_a_residual_that_is_small_is_not_looked_at():
    looked = newton(section := Squared(), np.array([0.1]))
    assert abs(looked.state[0]) < 1e-14
    assert looked.contraction == pytest.approx(abs(section.seen[1] ** 2 - section.seen[1]) / 0.09)
    orbit = newton(other := Squared(), np.array([0.1]), unseen=0.05)
    assert other.seen == section.seen[:2]
    assert orbit.state[0] == section.seen[2]
    assert orbit.image.state[0] == section.seen[1] ** 2
    assert (orbit.status, orbit.residual) == (0, pytest.approx(abs(section.seen[1] ** 2 - section.seen[1])))
    assert np.isnan(newton(Squared(), np.array([0.01]), unseen=0.05).contraction)


@pytest.mark.parametrize(
    ("radius", "met", "aside", "contraction", "tried", "found"),
    [
        (0.1, 0.1, 0.01, np.nan, [True], True),  # near the line
        (0.1, 0.1, 0.01, 1.0, [True, False], True),  # likewise, but Newton's method hesitates
        (0.1, 0.1, 0.5, 0.01, [True], True),  # off the line, but Newton's first step brought it there
        (0.1, 0.1, 0.5, 0.5, [True, False], False),
        (0.1, 0.8, 0.01, np.nan, [True, False], True),  # what is not strongly stable is always looked at
        (0.8, 0.8, 0.5, 0.01, [False], True),
        (0.8, 0.8, 0.5, 0.5, [False], False),
    ],
)
def test_an_orbit_off_the_line_is_of_the_branch_if_newtons_first_step_leads_there(
    monkeypatch, radius, met, aside, contraction, tried, found
):
    mechanism, asked = jp.catalog.slider_crank(clearance={"B": 1e-4}), []
    section = Squared()

    def place(value, state, radius):
        orbit = Orbit(0, section, np.array([state]), None, 0.0, 1, contraction)
        return Place(value, orbit, np.array([radius]), 0.0)

    def at(branch, value, like, guess, sharp, unseen):
        asked.append(unseen > 0)
        assert sharp == (radius > 0.7)
        return place(value, guess[0] + aside, met)

    monkeypatch.setattr(Branch, "at", at)
    places = [place(1.0, 1.0, radius), place(2.0, 1.1, radius)]
    walk = Walk(Branch(mechanism, "joints.B.clearance", 1), places, 1, 1.0, 0.1)
    walk.step = 0.1
    assert (walk.orbit_at(4.0, walk.places[-1]) is not None) == found
    assert asked == tried


@pytest.mark.parametrize(
    ("radii", "contraction", "phase", "asked"),
    [
        ((0.1, 0.2), np.nan, 0.0, [(1.1, True)]),
        ((0.2, 0.1), 0.01, 0.0, [(1.1, True)]),
        ((0.1, 0.2), 0.5, 0.0, [(1.1, True), (1.1, False)]),  # Newton's method hesitates
        ((0.1, 0.8), np.nan, 0.0, [(1.1, False)]),  # what is not strongly stable is always looked at
        ((0.1, 0.2), np.nan, 1.0, [(1.0, True)]),  # the other one is on another section
    ],
)
def test_between_two_places_an_orbit_is_sought_half_way(monkeypatch, radii, contraction, phase, asked):
    tried = []

    def place(value, state, radius, phase=0.0):
        section = Squared()
        section.phase = phase
        orbit = Orbit(0, section, np.array([state]), None, 0.0, 1, contraction)
        return Place(value, orbit, np.array([radius]), 0.0)

    def at(branch, value, like, guess, sharp, unseen=0.0):
        tried.append((pytest.approx(guess[0]), unseen > 0))
        return place(value, guess[0], max(radii))

    monkeypatch.setattr(Branch, "at", at)
    monkeypatch.setattr(branch_walk, "ENCLOSED", 0.5)
    places = [place(1.0, 1.0, radii[0]), place(2.0, 1.2, radii[1], phase)]
    mechanism = jp.catalog.slider_crank(clearance={"B": 1e-4})
    walk = Walk(Branch(mechanism, "joints.B.clearance", 1), places, 1, 1.0, 0.1)
    inner, outer = walk.enclosed(lambda place: place.value > 1.2)
    assert (inner.value, outer.value) == (1.0, pytest.approx(np.sqrt(2)))
    assert tried == asked
