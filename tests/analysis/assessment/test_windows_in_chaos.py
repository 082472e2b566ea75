"""The end of chaos lasts: windows in it, however they are met, are told as windows with their two ends."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import jointplay as jp
from jointplay.analysis.assessment import edges as edges_module
from jointplay.analysis.assessment.edges import HOW, Search, edges
from jointplay.analysis.assessment.settled import CHANGES, Settled, plan, present
from jointplay.analysis.starts import End

KEY, PRESENT = "joints.B.clearance", 1e-4
LOOSE = jp.catalog.slider_crank(clearance={"B": PRESENT})
BRIEF = plan(60, 40, 60, 1e-7, None)


def scene(monkeypatch, windows, end):
    """A linkage that is chaotic above `end`, but in the windows (low, high, period), and of period 1 below.

    Motions are made here of the clearance alone; what is tested is where they are looked at and what is said.
    """

    def motion(mechanism, *_):
        """The settled motion of a clearance."""
        value = mechanism.joint("B").clearance
        period = next((period for low, high, period in windows if low <= value <= high), 0)
        period = 1 if value < end else period
        numbers = {"exponent_per_turn": 1.0, "standard_error_per_turn": 0.1, "batch_correlation": 0.0}
        values = {f"section_{name}": (("multiplier",), [each]) for name, each in numbers.items()}
        values |= {"period": ((), period), "contact_fraction": (("joint",), [0.9])}
        return Settled(mechanism, End((), np.zeros(0), 0.0), values)

    monkeypatch.setattr(edges_module, "settled", motion)
    monkeypatch.setattr(edges_module, "lasting", lambda motion, *_: motion)
    return motion(LOOSE)


def values(reach=1.3, step=0.005):
    return Search(reach, 5 * step, 0.0025).values(PRESENT, -1)


def found(here, reach=1.3, **more):
    answer = edges(here, KEY, "below", replace(Search(reach, 0.005, 1e-3), **more), BRIEF)
    assert answer["status"] == 0, answer["trouble"]
    return answer


def test_a_pinprick_window_is_no_end_of_chaos(monkeypatch):
    """20 nm wide, about the third value that is looked at; chaos goes on to the last one."""
    at = values()[2]
    here = scene(monkeypatch, [(at - 6e-9, at + 14e-9, 6)], 0.0)
    answer = found(here)
    assert np.isnan(answer["edge"]).all()
    assert len(answer["looked"]) == len(values())
    ((low, high, period),) = answer["windows"]
    assert (low, high) == pytest.approx((at - 6e-9, at + 14e-9), abs=4e-9)
    assert period == 6


def test_an_end_that_lasts_is_an_end_though_a_window_comes_first(monkeypatch):
    at = values()[2]
    end = values()[5] * 1.005
    here = scene(monkeypatch, [(at - 6e-9, at + 14e-9, 6), (end * 1.005, end * 1.007, 3)], end)
    answer = found(here)
    edge, how = answer["edge"][CHANGES.index("chaos")], answer["how"][CHANGES.index("chaos")]
    assert edge == pytest.approx(end, rel=0.003)
    assert HOW[int(how)] == "bracketed"
    assert answer["edge"][CHANGES.index("doubling")] == pytest.approx(end, rel=0.003)
    assert len(answer["windows"]) == 1


@pytest.mark.parametrize(
    ("low", "high", "share", "windows"),
    [
        (0.985, 1.002, 0.01, 0),
        (0.985, 1.002, 0.03, 1),
        (0.994, 1.010, 0.01, 0),  # chaos is back soon beyond the value that is looked at
        (0.997, 1.004, 0.01, 1),
        (0.960, 1.002, 0.05, 1),  # two values that are looked at lie in it
    ],
)
def test_how_long_an_end_lasts_is_a_setting(monkeypatch, low, high, share, windows):
    """From where chaos ends to where it is back, wherever between the motion was looked at."""
    at = values()[2]
    here = scene(monkeypatch, [(at * low, at * high, 2)], 0.0)
    answer = found(here, lasting=share)
    assert len(answer["windows"]) == windows
    edge = answer["edge"][CHANGES.index("chaos")]
    assert np.isnan(edge) if windows else edge == pytest.approx(at * high, rel=0.003)


def test_a_window_is_one_though_the_chaos_before_it_is_too_short_to_be_met_from_it(monkeypatch):
    """Another window lies before that chaos; together they are longer than an end of chaos has to last."""
    at = values()[2]
    here = scene(monkeypatch, [(at * 0.9985, at * 1.003, 1), (at * 1.004, at * 1.012, 2)], 0.0)
    halved, names = edges_module._halved, []
    monkeypatch.setattr(edges_module, "_halved", lambda *each: names.append(each[2]) or halved(*each))
    answer = found(here)
    assert names == ["doubling"]  # chaos, which has changed there too, is part of the window
    assert np.isnan(answer["edge"]).all()
    ((low, high, period),) = answer["windows"]
    assert (low, high) == pytest.approx((at * 0.9985, at * 1.003), rel=3e-4)
    assert period == 1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_place_is_found_in_a_window_whichever_way_the_crank_turns(monkeypatch, sign):
    chaotic = scene(monkeypatch, [], 0.0)
    still = scene(monkeypatch, [], 1.0)
    window = edges_module.Stretch(sign * 1.001, sign * 1.03, 1, (sign * 1.031, chaotic))
    carried = SimpleNamespace(at=lambda *_: still, lasting=lambda spot, *_: spot, stretch=lambda *_: window)
    side = edges_module.Side(chaotic, sign)
    last, first = (sign, chaotic), (sign * 1.02, still)
    assert edges_module._halved(side, carried, "chaos", last, first, Search(2.0, 0.01, 1e-3)) is window
    assert np.isnan(side.found["chaos"][0])


def test_an_edge_is_that_of_the_motion_which_is_followed_where_a_long_step_goes_over_to_another(monkeypatch):
    """The quiet motion ends at 0.99; from 0.997 on a chaotic one coexists, to which steps over 0.4 % lead."""
    chaotic, still = scene(monkeypatch, [], 0.0), scene(monkeypatch, [], 1.0)
    stood = {}

    def at(value, before):
        left = value < 0.99 or (value < 0.997 and stood[before] / value > 1.004)
        motion = replace(chaotic if left or before.traits["chaos"] else still)
        stood[motion] = value
        return motion

    carried = SimpleNamespace(at=at, lasting=lambda spot, *_: spot, begun=lambda *_: None)
    side, last, first = edges_module.Side(still, 1.0), replace(still), replace(chaotic)
    stood |= {last: 1.0, first: 0.98}
    search = Search(2.0, 0.01, 1e-3)
    assert edges_module._halved(side, carried, "doubling", (1.0, last), (0.98, first), search) is None
    edge, error = side.found["doubling"][:2]
    assert abs(edge - 0.99) <= error <= 1e-3


def test_beyond_the_end_of_chaos_each_change_is_an_edge(monkeypatch):
    """Period 1 that doubles again soon beyond the end of chaos has been reached there all the same."""
    at = values()[2]
    here = scene(monkeypatch, [(at * 0.995, at * 1.01, 1), (at * 0.8, at * 0.995, 2)], 0.0)
    answer = found(here)
    for name in ("doubling", "chaos"):
        assert answer["edge"][CHANGES.index(name)] == pytest.approx(at * 1.01, rel=0.003)
    assert values()[3] <= answer["back"][CHANGES.index("doubling")] < at * 0.995
    assert len(answer["windows"]) == 0


@pytest.mark.nightly
def test_the_windows_of_a_slider_crank_are_not_the_end_of_its_chaos():
    """A dense sweep finds windows narrower than 0.1 µm from 92 to 100 µm, and chaos between them."""
    mass = {"crank": 0.3, "rod": 0.25, "slider": 0.4}
    gear = jp.catalog.slider_crank(
        crank=0.05, rod=0.15, mass=mass, clearance={"B": 1e-4}, speed=20.0, gravity=9.8
    )
    how, search = plan(100, 32, 200, 1e-7, None), Search(1.12, 0.0025, 1e-3)
    answer = edges(present(gear, None, how), KEY, "below", search, how)
    assert np.isnan(answer["edge"]).all()
    ((low, high, period),) = answer["windows"]
    assert 0 < high - low < 0.01 * PRESENT
    inside = jp.bifurcation(gear.replace(clearance={"B": (low + high) / 2}), over={KEY: [(low + high) / 2]},
                            transient=600, turns=32, n_jobs=1)  # fmt: skip
    assert period in np.ravel(inside["period"])
