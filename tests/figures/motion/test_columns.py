"""Runs recorded in windows: a column each, the same numbers, no line across what was not recorded."""

import numpy as np
import pytest

from jointplay import figures
from jointplay.figures.drawing import style, timebase
from tests.figures.support.synthetic import PERIOD, response


def windowed(*pairs: tuple[float, float], data=None, late: float = 0.0):
    """A response of which only these turns are kept; `late` turns lie between the first and the others."""
    data = response(section=False) if data is None else data
    turns, kept, number = data.time.values / PERIOD, [], []
    for index, (first, last) in enumerate(pairs):
        here = np.flatnonzero((turns >= first - 1e-9) & (turns <= last + 1e-9))
        kept, number = kept + list(here), number + [index] * here.size
    found = data.isel(time=kept).assign(window=("time", np.array(number, np.int8)))
    shift = np.where(found.window.values > 0, late, 0.0)
    crank = np.array([1.0, 0.0, 0.0])
    found["angle"] = found.angle.copy(data=found.angle.values + 2 * np.pi * shift[:, None] * crank)
    return found.assign_coords(time=found.time + PERIOD * shift)


@pytest.fixture
def pair():
    """Turn 1, and turns 2 to 6 of the motion told as 21 to 25."""
    return windowed((0, 1), (1, 6), late=19)


def grow(data, name, factor):
    """Make a variable larger in the first window."""
    first = data.window.values[:, None] == 0
    data[name] = data[name].copy(data=data[name].values * np.where(first, factor, 1.0))


def history(dataset, **options):
    return figures.draw(dataset, {"kind": "time_history", **options})


def titles(figure):
    return [ax.get_title(loc="left").replace("\n", " ") for ax in figure.axes]


def test_each_window_has_a_column_with_its_own_samples(pair):
    start, steady = history(pair).axes
    for ax, number in ((start, 0), (steady, 1)):
        (line,) = ax.lines
        here = pair.window.values == number
        np.testing.assert_array_equal(line.get_ydata(), pair.normal_force.values[here, 0])
    assert titles(history(pair)) == ["start-up, turn 1", "steady, turns 21\N{EN DASH}25"]


def test_below_are_crank_angle_and_turns_and_above_is_time(pair):
    start, steady = history(pair).axes
    assert [ax.get_xlabel() for ax in (start, steady)] == ["Crank angle (deg)", "Crank turns"]
    assert start.get_xlim() == pytest.approx((0, 360), abs=0.5)
    assert steady.get_xlim() == pytest.approx((20, 25), abs=2e-3)
    for ax, ends in ((start, (0, 75)), (steady, (1500, 1875))):
        (above,) = ax.child_axes
        assert above.get_xlabel() == "Time (ms)"
        assert above.get_xlim() == pytest.approx(ends, abs=0.5)


def test_an_axis_ends_at_a_whole_turn_that_is_near():
    base = timebase.Base("Crank turns", np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    assert timebase.limits(base, np.array([19.9999, 24.9999])) == (19.9999, 25.0)
    assert timebase.limits(base, np.array([0.5, 1.4])) == (0.5, 1.4)


def test_windows_of_one_size_share_a_scale_and_others_do_not(pair):
    start, steady = history(pair, variables="angular_velocity").axes
    assert start.get_ylim() == steady.get_ylim()
    assert not any(label.get_visible() for label in steady.get_yticklabels())
    grow(pair, "normal_force", 100.0)
    start, steady = history(pair).axes
    assert start.get_ylim()[1] > 5 * steady.get_ylim()[1]
    assert steady.get_yticklabels()[0].get_visible()


def test_units_are_the_same_in_all_columns(pair):
    grow(pair, "eccentricity", 1000.0)
    start, steady = history(pair, variables="eccentricity").axes
    here = pair.window.values == 1
    np.testing.assert_allclose(steady.lines[0].get_ydata(), 1e3 * pair.eccentricity.values[here, 0])
    assert "(mm)" in start.get_ylabel()
    assert steady.get_ylabel() == ""


def test_rows_have_letters_and_events_lie_in_their_window(pair):
    times = pair.event_time.values
    pair["event_time"] = pair.event_time.copy(data=times + 19 * PERIOD * (times > PERIOD))
    figure = history(pair, variables=["normal_force", "eccentricity"], events=True)
    assert len(figure.axes) == 6
    assert titles(figure)[0] == "(a) start-up, turn 1"
    assert titles(figure)[2:] == ["(c)", "(d)", "(e)", "(f)"]
    start, steady = figure.axes[-2:]
    drawn = [sum(line.get_xdata().size for line in ax.lines) for ax in (start, steady)]
    first = int((pair.event_time.values <= PERIOD).sum())
    assert drawn == [first, pair.sizes["event"] - first]
    assert all(0 <= x <= 361 for line in start.lines for x in line.get_xdata())


def test_one_window_can_be_asked_for(pair):
    (ax,) = history(pair, turns=[0, 1]).axes
    assert ax.get_xlabel() == "Crank angle (deg)"
    (ax,) = history(pair, turns=3, axis="time").axes
    assert ax.get_xlabel() == "Time (ms)"


@pytest.mark.parametrize(
    ("kind", "option", "number"), [("journal_orbit", {}, 1), ("phase_portrait", {"turns": [0, 1]}, 0)]
)
def test_a_path_is_that_of_one_window(pair, kind, option, number):
    ax = figures.draw(pair, {"kind": kind, **option}).axes[0]
    orbit, portrait = pair.journal_x[:, 0] / pair.clearance[0], 1e6 * pair.eccentricity[:, 0]
    samples = (orbit if kind == "journal_orbit" else portrait).values[pair.window.values == number]
    assert np.isin(samples, ax.lines[1].get_xdata()).all()
    assert tuple(ax.lines[1].get_xdata()[[0, -1]]) == (samples[0], samples[-1])


def test_columns_fill_the_page_of_a_journal(pair):
    assert history(pair).get_size_inches()[0] * 25.4 == pytest.approx(180)
    assert history(pair, column="single").get_size_inches()[0] * 25.4 == pytest.approx(88)


@pytest.mark.parametrize(
    ("first", "last", "words"),
    [
        (0, 1, "turn 1"),
        (20, 25, "turns 21\N{EN DASH}25"),
        (5, 6, "turn 6"),
        (0.5, 1.25, "from 0.5 to 1.25 turns"),
        (3, 3.0000001, "from 3 to 3 turns"),
    ],
)
def test_turns_are_counted_from_1(first, last, words):
    assert timebase.turn_words(first, last) == words


def test_only_the_last_window_is_called_steady():
    figure = history(windowed((0, 1), (2, 3), (4, 6)))
    assert titles(figure) == ["start-up, turn 1", "turn 3", "steady, turns 5\N{EN DASH}6"]


def test_a_plain_run_stays_one_column():
    figure = history(response(section=False))
    assert titles(figure) == [""]


def test_a_pin_is_chosen_and_named():
    data = response(section=False)
    force = np.abs(data.normal_force.values) + np.array([1.0, 2.0, 3.0])
    words = {"units": "N", "long_name": "force at an ideal joint"}
    data = data.assign(reaction=(("time", "pin"), force, words)).assign_coords(pin=["O", "A", "C"])
    (ax,) = history(data, variables="reaction", pin="C").axes
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), force[:, 2])
    assert ax.get_ylabel().replace("\n", " ") == "Force at ideal joint C (N)"
    (ax,) = history(data, variables="reaction").axes
    assert [line.get_label() for line in ax.lines] == ["O", "A", "C"]
    with pytest.raises(figures.drawing.select.InputError, match="accepted: O, A, C"):
        history(data, variables="reaction", pin="B")


def test_deflections_are_of_all_links_that_bend_or_of_one():
    data = response(section=False)
    words = {"units": "m", "long_name": "deflection of a link"}
    bent = 1e-6 * np.sin(data.time.values[:, None] * [300.0, 500.0])
    data = data.drop_dims("link").assign(deflection=(("time", "link"), bent, words))
    data = data.assign_coords(link=["coupler", "rocker"])
    (ax,) = history(data, variables="deflection").axes
    assert [line.get_label() for line in ax.lines] == ["coupler", "rocker"]
    (ax,) = history(data, variables="deflection", link="rocker").axes
    assert ax.get_ylabel().replace("\n", " ") == "Deflection of the rocker (µm)"


def test_curves_of_one_panel_differ_without_colour():
    dashes = [str(dash) for dash in style.RC["axes.prop_cycle"].by_key()["linestyle"]]
    assert len(set(dashes)) == len(dashes) == 8
