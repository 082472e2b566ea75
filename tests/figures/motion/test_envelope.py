"""Extremes between samples are drawn, and a vibration of few samples a cycle as its envelope."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import jointplay as jp
from jointplay import figures
from jointplay.display.number_text import measure
from jointplay.figures.drawing import envelope
from jointplay.figures.linkage.scene import scene
from jointplay.study.results.animate import _mechanism
from jointplay.study.results.places import places
from tests.figures.support.synthetic import PERIOD, response


def vibrating(cycles: float, samples: int = 720, recorded: bool = True):
    """A response whose force is 100 N and vibrates by 20 N, so many cycles a turn, with its extremes."""
    data = response()
    turns = data.time.values / PERIOD
    fine = turns[:-1, None] + np.diff(turns)[:, None] * np.linspace(0, 1, 41)
    force, every = (100 + 20 * np.sin(2 * np.pi * cycles * each) for each in (turns, fine))
    data["normal_force"] = data["normal_force"].copy(data=force[:, None])
    for word, end in (("lowest", np.min), ("highest", np.max)):
        if recorded:
            data[f"{word}_normal_force"] = data["normal_force"].copy(
                data=np.r_[force[0], end(every, 1)][:, None]
            )
    return data.isel(time=slice(None, None, 720 // samples))


def panel(data, **options):
    return figures.draw(data, {"kind": "time_history", **options}).axes[0]


def notes(ax):
    return [text.get_text() for text in ax.texts]


@pytest.mark.parametrize("turns", [1, 6])
def test_a_vibration_of_few_samples_a_cycle_is_its_envelope(turns):
    ax = panel(vibrating(200.3), turns=turns)
    (band,) = ax.collections
    x, y = band.get_paths()[0].vertices.T
    middle = (x > np.quantile(x, 0.1)) & (x < np.quantile(x, 0.9))
    assert np.abs(np.abs(y[middle] - 100) - 20).max() < 0.1  # no beat: the edges are straight
    assert np.isnan(ax.lines[0].get_ydata()).all()
    assert notes(ax) == []
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [envelope.BAND]


def test_the_envelope_of_each_of_several_joints_has_its_name():
    two = vibrating(200.3).isel(joint=[0, 0]).assign_coords(joint=["A", "B"])
    ax = panel(two)
    handles, names = ax.get_legend_handles_labels()
    assert names == ["A", "A: lowest\nto highest", "B", "B: lowest\nto highest"]
    for line, band in (handles[:2], handles[2:]):
        assert tuple(band.get_facecolor()[0][:3]) == to_rgb(line.get_color())


def test_what_the_samples_miss_is_told():
    zoomed = panel(vibrating(200.3), turns=0.2)  # wide enough on the paper for cycles to be looked for
    assert notes(zoomed) == [envelope.NO_CYCLES]
    alone = panel(vibrating(200.3, recorded=False))
    assert notes(alone) == [envelope.NO_PEAKS]
    top = max(line.get_ydata()[np.isfinite(line.get_ydata())].max(initial=0) for line in alone.lines)
    (text,) = alone.texts
    box = text.get_window_extent().transformed(alone.transData.inverted())
    assert box.y0 > top  # beside the curve


def test_a_vibration_of_many_samples_a_cycle_is_its_curve():
    data = vibrating(40)
    early = data["highest_normal_force"].copy()
    early[0] = 1e6  # of the time before the first sample, which is not shown
    ax = panel(data.assign(highest_normal_force=early))
    assert not ax.collections
    assert ax.get_legend() is None
    assert notes(ax) == []
    x, y = ax.lines[0].get_data()
    there = np.isin(x, 1e3 * data.time.values)
    np.testing.assert_array_equal(y[there], data.normal_force.values[:, 0])
    assert y.max() == data.highest_normal_force.max()


def test_an_envelope_fills_valleys_between_near_peaks_and_widens_no_single_one():
    high = np.zeros(100)
    high[[20, 60, 66]] = 1.0, 2.0, 3.0
    filled = high.copy()
    filled[60:66] = 2.0
    np.testing.assert_array_equal(envelope.widest(high), filled)


def test_what_lies_beyond_two_samples_stands_between_them():
    x, y = np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 2.0, 1.0, 1.0])
    low, high = np.array([0.0, -1.0, 1.0, 0.5]), np.array([0.0, 2.0, 4.0, 1.0])
    places, xs, ys = envelope.joined(x, y, low, high)
    assert xs.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]
    assert ys.tolist() == [0.0, -1.0, 2.0, 4.0, 1.0, 0.5, 1.0]
    assert places.tolist() == [0, 1, 1, 2, 2, 3, 3]
    low, high = np.array([0.0, -1, -1, -1]), np.array([0.0, 2, 2, 2])
    _, _, both = envelope.joined(np.arange(4.0), np.array([0.0, 1, 0, 0]), low, high)
    assert both.tolist() == [
        0,
        -1,
        2,
        1,
        2,
        -1,
        0,
        -1,
        2,
        0,
    ]  # what is nearer to the sample before comes first


@pytest.fixture(scope="module")
def motion():
    """A stiff joint whose contacts are shorter than the distance of its samples."""
    mechanism = jp.catalog.slider_crank(stiffness=1e9, damping=200.0)
    return jp.simulate(mechanism, turns=1, rtol=1e-7)


@pytest.mark.long
def test_the_top_of_the_curve_is_the_force_that_is_printed(motion):
    largest = float(motion.largest_normal_force.sel(joint="B"))
    assert float(motion.normal_force.sel(joint="B").max()) < 0.95 * largest  # the samples miss it
    for kind in ("time_history", "overview"):
        ax = figures.draw(motion, {"kind": kind} | ({"turns": 1} if kind == "overview" else {})).axes[0]
        drawn = [line.get_ydata() for line in ax.lines]
        top = max(np.max(y[np.isfinite(y)], initial=0.0) for y in drawn)
        assert top == largest
        names = ax.get_legend_handles_labels()[1]
        assert {*names} <= {envelope.BAND}  # the ideal guide G has no normal force, and is no gap
        assert not ax.patches
    mechanism = _mechanism(motion)
    shown = scene(mechanism, places(mechanism, motion), None)
    (loose,) = shown.enlarged
    assert loose.peak == largest
    assert loose.felt(shown.struck) == pytest.approx(largest, rel=0.2)  # of the hardest impact
    assert loose.force[shown.struck].max() < 0.9 * loose.felt(shown.struck)
    said = jp.summary(motion).lines[0]
    assert measure(largest, "N", 3) in said  # "normal" beside the resultant, where they differ


@pytest.mark.long
@pytest.mark.parametrize("kind", ["journal_orbit", "phase_portrait"])
def test_a_path_says_how_many_contacts_lie_between_its_samples(motion, kind):
    told = jp.words(motion[["event_kind", "event_joint", "event_time"]])
    told = told.isel(event=told["event_joint"].values == "B")
    times, kinds = told["event_time"].values, told["event_kind"].values
    begun, ended = (times[kinds == each] for each in ("contact", "separation"))
    held = np.array([[begin, ended[ended > begin].min(initial=np.inf)] for begin in begun])
    samples = motion["time"].values
    missed = np.sum(np.searchsorted(samples, held[:, 0]) == np.searchsorted(samples, held[:, 1]))
    assert missed > 1
    (ax,) = figures.draw(motion, {"kind": kind}).axes
    assert ax.get_title(loc="left").replace("\n", " ") == f"{missed} contacts between samples not drawn"
