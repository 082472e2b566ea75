"""Films and sheets of frames: what a frame shows, how many there are, and what is said where none can be."""

import re
import warnings
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from PIL import Image

import jointplay as jp
from jointplay import cli
from jointplay.display.errors import InputError
from jointplay.figures.drawing import style
from jointplay.figures.linkage import bearing, film, guide
from jointplay.figures.linkage.film import film_sheet
from jointplay.figures.linkage.scene import scene, spread
from jointplay.study.results import animate
from jointplay.study.results.places import places
from tests.figures.support.synthetic_linkages import corners_led, four_bar, loose_guide, slides


@pytest.fixture(scope="module")
def motion():
    return four_bar()


@pytest.fixture(scope="module")
def shown(motion):
    return scene(motion[0], places(*motion), None)


def test_frames_take_the_nearest_samples_evenly():
    times = np.array([0.0, 0.1, 0.11, 0.12, 0.5, 1.0])
    assert spread(times, 5).tolist() == [0, 3, 4, 5, 5]  # 0.25 is nearer to 0.12
    assert spread(times, 2).tolist() == [0, 5]


def test_a_frame_shows_links_journal_and_force_of_its_moment(motion, shown):
    mechanism, data = motion
    _, axes = film.stage(shown)
    drawn = film.moment(shown, axes, 10)
    ends = {tuple(np.round(p, 6)) for each in drawn if hasattr(each, "get_xydata") for p in each.get_xydata()}
    A = 1e3 * mechanism.link("crank").length * np.array([np.cos(np.pi / 2), np.sin(np.pi / 2)])
    assert tuple(np.round(A, 6)) in ends
    journal = np.array([data["journal_x"][10, 0], data["journal_y"][10, 0]]) / mechanism.joint("B").clearance
    assert tuple(np.round(journal, 6)) in ends
    words = [each.get_text() for each in drawn if hasattr(each, "get_text")]
    assert words == ["crank 90°, 25 ms", "100 N (largest 100 N)"]


def test_frames_are_even_sized_and_differ(shown):
    first, *_, last = pictures = list(film.film_frames(shown, [0, 20, 40]))
    assert len(pictures) == 3
    assert all(size % 2 == 0 for size in first.shape[:2])
    assert first.shape[2] == 3
    assert 0.001 < np.mean(first != pictures[1]) < 0.2  # what moves, and nothing else
    assert np.mean(first != last) < np.mean(first != pictures[1])  # after a turn the linkage is back


@pytest.mark.nightly
def test_a_film_has_the_frames_of_its_length(motion, tmp_path):
    from imageio_ffmpeg import count_frames_and_secs

    told = []
    path = jp.animate(motion[1], tmp_path / "m.mp4", seconds=0.8, rate=10, progress=told.append)
    assert count_frames_and_secs(str(path))[0] == 9
    assert told == pytest.approx(np.arange(1, 10) / 9)  # and none of the frames that are drawn to try
    with Image.open(jp.animate(motion[1], tmp_path / "m.gif", turns=0.5, seconds=1, rate=10)) as gif:
        assert gif.n_frames == 6
        assert gif.info["duration"] == 100
    assert [each.name for each in sorted(tmp_path.iterdir())] == ["m.gif", "m.mp4"]


@pytest.mark.nightly
def test_a_sheet_has_a_panel_and_a_bearing_a_frame(motion, shown):
    assert len(film_sheet(shown, 5).axes) == 10
    mechanism = jp.catalog.slider_crank(clearance=0)
    ideal = scene(mechanism, places(mechanism, slides(mechanism)), None)
    titles = [ax.get_title(loc="left") for ax in film_sheet(ideal, 3).axes]
    assert titles == ["(1) crank 0°, 0 s", "(2) crank 180°, 50 ms", "(3) crank 0°, 100 ms"]
    guided = scene(loose_guide()[0], places(*loose_guide()), None)  # whose corners have a legend
    inches = [film_sheet(*each).get_figheight() for each in ((shown, 4), (shown, 5), (guided, 4))]
    assert np.array(inches) * 25.4 == pytest.approx([63, 126, 98])  # mm: 34, 29 a joint, a legend of 6
    whole = scene(motion[0], places(*motion), None, turns=1)  # evenly, as it was asked for
    titles = [ax.get_title(loc="left") for ax in film_sheet(whole, 3).axes[::2]]
    assert titles == ["(1) crank 0°, 0 s", "(2) crank 180°, 50 ms", "(3) crank 0°, 100 ms"]


def struck(turns: int = 3):
    """The four-bar's motion, repeated, with two impacts in the second turn, the harder one at 0.13 s."""
    mechanism, data = four_bar(201)
    parts = [data.isel(time=slice(0 if n == 0 else 1, None)) for n in range(turns)]
    later = [part.assign_coords(time=part["time"] + 0.1 * n) for n, part in enumerate(parts)]
    for n, part in enumerate(later):
        part["angle"] = part["angle"] + 2 * np.pi * n * (part["link"] == "crank")
    whole = xr.concat(later, "time", data_vars="minimal")
    kinds = {"flag_values": [0, 1], "flag_meanings": "contact separation"}
    events = {
        "event_time": ("event", [0.122, 0.13, 0.134, 0.138, 0.15]),
        "event_kind": ("event", np.array([1, 0, 1, 0, 1], dtype=np.int8), kinds),
        "event_joint": ("event", np.zeros(5, dtype=np.int16)),
        "event_normal_velocity": ("event", [-0.9, 0.5, -0.4, 0.3, -0.1]),
    }
    return mechanism, whole.assign(events)


def test_a_film_is_of_the_turn_around_the_hardest_impact():
    mechanism, data = struck()
    shown = scene(mechanism, places(mechanism, data), None)
    assert shown.hit.time == 0.13  # separations are faster, and hit nothing
    assert shown.times[[0, -1]] == pytest.approx([0.08, 0.18])
    assert shown.times[shown.struck] == pytest.approx(0.13, abs=1e-9)
    assert shown.struck in shown.frames(4)
    alone = scene(mechanism, places(mechanism, data.drop_vars("event_normal_velocity")), None)
    assert alone.hit.time == pytest.approx(0.025)  # where the force is largest, for the first time
    assert alone.times[[0, -1]] == pytest.approx([0.0, 0.1])
    assert scene(mechanism, places(mechanism, data), None, turns=2).hit is None
    early = data.isel(time=slice(0, 201))  # no sample is later than the impact
    assert scene(mechanism, places(mechanism, early), None).struck == 200


def test_a_sheet_shows_the_moments_around_the_impact():
    mechanism, data = struck()
    shown = scene(mechanism, places(mechanism, data), None)
    samples = shown.close(8)
    times = shown.times[samples]
    assert times[[0, 3, 7]] == pytest.approx([0.122, 0.13, 0.138])  # flight, contact, and the next flight
    assert np.all(np.diff(samples) > 0)
    titles = [ax.get_title(loc="left") for ax in film_sheet(shown, 8).axes[::2]]
    assert titles[0] == "(1) 8 ms before\ncrank 79°"
    assert titles[3] == "(4) B hits at 0.5 m/s\ncrank 108°, 130 ms"
    assert titles[7] == "(8) 8 ms after\ncrank 137°"
    late = data.isel(time=slice(260, 264))  # fewer samples than frames
    assert scene(mechanism, places(mechanism, late), None).close(8).tolist() == [0, 1, 2, 3]


MOTIONS = {
    "four-bar": lambda: (jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0), 1.2),
    "slider-crank": lambda: (jp.catalog.slider_crank(clearance={"B": 1e-4}), 1.2),
    "guide": lambda: (jp.catalog.flores2010(), 1.0),
    "six-bar": lambda: (jp.catalog.watt(clearance={"D": 5e-5}), 1.2),
    "impacts": lambda: (jp.catalog.siconos_four_bar(restitution=0.5), 1.0),
    "elastic": lambda: (jp.catalog.chunmei2002(clearance=2.9e-4, elastic=["coupler"]), 1.0),
}


@pytest.fixture(scope="module", params=MOTIONS)
def moved(request):
    mechanism, turns = MOTIONS[request.param]()
    return jp.simulate(mechanism, turns=turns, rtol=1e-6, samples_per_turn=360)


@pytest.mark.nightly
@pytest.mark.parametrize("moved", MOTIONS, indirect=True)
def test_a_film_by_default_is_small_and_tells_its_size_before(moved, tmp_path, caplog):
    with caplog.at_level("INFO", logger="jointplay"), warnings.catch_warnings():
        warnings.simplefilter("error")
        size = jp.animate(moved, tmp_path / "m.gif").stat().st_size
    assert size < 3_000_000
    told = re.fullmatch(
        r"a film of 97 frames of 7\d\d × \d+ pixels has about (.+) MB and takes .+", caplog.messages[-1]
    )
    assert float(told[1]) * 1e6 == pytest.approx(size, rel=0.5)


@pytest.mark.nightly
def test_labels_of_a_sheet_stand_apart_and_nothing_is_warned_of(moved):
    mechanism = animate._mechanism(moved)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sheet = film_sheet(scene(mechanism, places(mechanism, moved), None), 8)
    draw = FigureCanvasAgg(sheet).get_renderer()
    titles = [
        text for ax in sheet.axes for text in ax.findobj(Text) if text.get_text() == ax.get_title("left")
    ]
    texts = [*titles, *(text for ax in sheet.axes for text in ax.texts)]
    texts += [text for legend in sheet.legends for text in legend.get_texts()]
    boxes = [each.get_window_extent(draw) for each in texts if each.get_text()]
    assert len(boxes) > 16
    assert not [
        pair for pair in combinations(range(len(boxes)), 2) if boxes[pair[0]].overlaps(boxes[pair[1]])
    ]
    for box in boxes:
        assert sheet.bbox.x0 <= box.x0 < box.x1 <= sheet.bbox.x1


def test_without_the_encoder_the_way_to_install_it_is_told(motion, tmp_path, monkeypatch):
    monkeypatch.setattr(animate, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install 'jointplay\[animation\]'"):
        animate.animate(motion[1], tmp_path / "m.mp4")


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"joint": "b"}, "did you mean 'B'"),
        ({"turns": -1}, "greater than 0"),
        ({"seconds": 1e6}, "frames is accepted"),
        ({"rate": 0}, "rate"),
        ({"time": [0.0001, 0.0002]}, "window"),
    ],
)
def test_what_makes_no_film_is_told(motion, tmp_path, options, told):
    with pytest.raises(InputError, match=told):
        jp.animate(motion[1], tmp_path / "m.gif", **options)
    assert not list(tmp_path.iterdir())


def test_a_result_that_names_no_mechanism_needs_it(motion, tmp_path):
    mechanism, data = motion
    data = data.drop_attrs()
    with pytest.raises(InputError, match="the Mechanism that moved is needed"):
        jp.animate(data, tmp_path / "m.png")
    assert jp.animate(data, tmp_path / "m.png", mechanism=mechanism, frames=2).exists()


def test_of_equations_there_is_nothing_to_show(tmp_path):
    motion = jp.simulate(jp.catalog.duffing(), turns=1)
    with pytest.raises(InputError) as told:
        jp.animate(motion, tmp_path / "m.png")
    assert str(told.value) == "mechanism: got 'duffing'; a linkage is accepted, no system of equations"


@pytest.mark.nightly
def test_the_command_makes_a_film_of_a_stored_motion(motion, tmp_path, capsys):
    stored, out = tmp_path / "m.nc", tmp_path / "m.gif"
    motion[1].to_netcdf(stored)
    words = ["animate", str(stored), "--out", str(out), "--set", "seconds=0.5", "rate=4"]
    assert cli.main(words) == 0
    assert capsys.readouterr().out == f"written {out}, {out.stat().st_size / 1e6:.2g} MB\n"
    with Image.open(out) as gif:
        assert gif.n_frames == 3
    assert cli.main([*words, "speed=2"]) == 2
    assert cli.main(["animate", str(stored), "--out", str(tmp_path / "film")]) == 2
    assert "ends in .mp4" in capsys.readouterr().err


def test_a_motion_names_its_mechanism():
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-5)
    motion = jp.simulate(mechanism, turns=0.02)
    assert animate._mechanism(motion) == mechanism


@pytest.mark.long
def test_a_sliders_corners_stand_where_its_tilt_and_rise_put_them():
    mechanism, data = loose_guide()
    shown = scene(mechanism, places(mechanism, data), None)
    assert [joint.name for joint in shown.joints] == ["B", "G"]
    _, axes = film.stage(shown)
    tilt, e = data["angle"].sel(link="slider").values, mechanism.joint("G").clearance
    place = np.stack([data["true_x"].sel(link="slider"), data["true_y"].sel(link="slider")], -1)
    ways, forces = (each[4] for each in corners_led(mechanism, tilt, place))
    drawn = film.moment(shown, axes, 4)
    marks = [
        each
        for each in drawn
        if each.axes is axes["b:G"] and getattr(each, "get_marker", str)() in ("o", ">")
    ]
    corners = np.array([each.get_xydata()[0] for each in marks])
    sides = np.array([(1, 1), (-1, 1), (1, -1), (-1, -1)])
    assert corners == pytest.approx(sides * np.stack([np.full(4, guide.LONG), guide.TALL + ways / e], -1))
    assert [each.get_marker() for each in marks] == [">" if force > 0 else "o" for force in forces]
    faces = [line.get_ydata()[0] for line in axes["b:G"].lines if np.ptp(line.get_ydata()) == 0]
    assert {guide.TALL + 1.0, -guide.TALL - 1.0} <= {*faces}  # where the way is the clearance
    a, b = mechanism.joint("G").half_length, mechanism.joint("G").half_height
    turned = [(np.cos(tilt[4]), np.sin(tilt[4])), (-np.sin(tilt[4]), np.cos(tilt[4]))]
    whole = 1e3 * (place[4] + sides * (a, b) @ np.array(turned))
    blocks = [each.get_xy() for each in drawn if each.axes is axes["l"] and hasattr(each, "get_xy")]
    assert any({*map(tuple, np.round(xy, 6))} == {*map(tuple, np.round(whole, 6))} for xy in blocks)
    words = [each.get_text() for each in drawn if hasattr(each, "get_text")]
    assert len(words) == 3
    assert words[2].startswith(f"{forces.max():.3g} N (largest ")


def test_the_number_at_a_guide_is_that_of_the_curve_below():
    mechanism, data = loose_guide()
    strength = data["normal_force"].values.copy()
    strength[4, 1:], strength[6, 1:] = (
        (10.0, 20.0, 3.0, 4.0),
        (0.0, 5.0, 40.0, 30.0),
    )  # upper, then lower face
    shown = scene(mechanism, places(mechanism, data.assign(normal_force=(("time", "joint"), strength))), "G")
    _, axes = film.stage(shown)
    words = [each.get_text() for each in film.moment(shown, axes, 4) if hasattr(each, "get_text")]
    assert words[1] == "30 N (largest 70 N)"
    curves = {line.get_label(): line.get_ydata() for line in axes["f"].lines}
    assert max(curves["G, upper face"]) == 30.0
    assert max(curves["G, lower face"]) == 70.0


@pytest.mark.parametrize("clearance", [0, {"G": 1e-4}])
def test_a_slide_that_was_not_recorded_follows_from_the_links(clearance):
    mechanism = jp.catalog.slider_crank(clearance=clearance)
    record = (
        ["angle", "journal_x", "journal_y", "slide_position"] if clearance else ["angle", "slide_position"]
    )
    whole = jp.simulate(mechanism, turns=1, record=record)
    reach = [
        scene(mechanism, places(mechanism, motion), None).sketch.reach["G"]
        for motion in (whole, whole.drop_vars("slide_position"))
    ]
    assert reach[1] == pytest.approx(reach[0], abs=1e-6)
    ways = whole["slide_position"].values
    assert reach[0] == pytest.approx((ways.min(), ways.max()), abs=1e-6)


def test_contact_is_not_claimed_where_modes_were_not_recorded(shown):
    mechanism, data = loose_guide()
    unknown = scene(mechanism, places(mechanism, data.drop_vars("mode")), None)
    told = [each.get_text() for each in film_sheet(unknown, 2).legends[0].get_texts()]
    assert told == ["corner (modes not recorded)"]
    _, axes = film.stage(shown)  # of the four-bar, whose modes were not recorded either
    trail, *_ = bearing.moment(axes["b:B"], shown.enlarged[0], 20, 0)
    assert (trail.get_color(), trail.get_xdata().size) == (style.BLACK, 21)


def test_titles_of_a_tall_mechanism_have_the_width_of_their_column():
    table = jp.catalog.slider_crank(clearance=0, crank=0.02, rod=0.14).model_dump(exclude_none=True)
    for side in ("journal", "bearing"):
        table["joints"][-1][side]["direction"] = np.pi / 2
    mechanism = jp.Mechanism.model_validate(table | {"guess": {"crank": 1.5, "rod": 1.5}})
    sheet = film_sheet(scene(mechanism, places(mechanism, slides(mechanism)), None), 4)
    assert all(ax.get_window_extent().width > 35 / 45 * sheet.bbox.width / 4 for ax in sheet.axes)


def test_every_loose_joint_is_shown_or_the_one_that_is_asked_for():
    mechanism, data = loose_guide()
    motion = places(mechanism, data)
    sheet = film_sheet(scene(mechanism, motion, None), 3)
    assert len(sheet.axes) == 9
    assert [each.get_text() for each in sheet.legends[0].get_texts()] == ["free", "slips forward"]
    assert len(film_sheet(scene(mechanism, motion, "G"), 3).axes) == 6
