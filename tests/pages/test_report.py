"""Pages of all kinds of result: what is in them, what is said of what is not, and what is refused."""

import json
import re
from base64 import b64decode
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import jointplay as jp
from jointplay import figures
from jointplay.analysis.declared import Outputs
from jointplay.analysis.keywords import Moving, analysis
from jointplay.cli import main
from jointplay.kinds import Kind
from jointplay.study.file import validate
from jointplay.study.results.store import write_result
from jointplay.study.toml_text import parse
from jointplay_page import moving, packed, report, sweep_points, texts
from tests.figures.support.synthetic import response, section
from tests.figures.support.synthetic_assessment import assessment
from tests.figures.support.synthetic_linkages import corners_led, loose_guide
from tests.figures.test_pictures import PICTURES
from tests.pages.samples import diagram, turning, with_study

NAMESPACE = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return jp.report(diagram(), tmp_path_factory.mktemp("page") / "sweep.html")


def stored(path):
    """The data inside a page."""
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.S)[1])


def values(array):
    return np.frombuffer(b64decode(array["bytes"]), array["type"]).reshape(array["shape"])


@pytest.mark.nightly
@pytest.mark.parametrize("name", PICTURES)
def test_every_kind_of_figure_is_one_well_formed_element_with_its_panels_inside(name):
    dataset, options = PICTURES[name]()
    figure = figures.draw(dataset, options)
    element = fromstring(report.svg_text(figure, "f7"))
    _, _, width, height = map(float, element.get("viewBox").split())
    assert (width, height) == pytest.approx(72 * figure.get_size_inches(), abs=0.01)
    named = [each.get("id") for each in element.iter() if each.get("id")]
    assert all(name.startswith("f7-") for name in named)
    assert len(named) == len(set(named))
    texts = " ".join(text for each in element.iter() for text in each.attrib.values())
    used = set(re.findall(r"#([\w-]+)", texts)) - set(re.findall(r"#([0-9a-f]{6})\b", texts))  # no colours
    assert used <= set(named)
    for panel in report.panels(figure, dataset, []):
        left, top, wide, high = panel["box"]
        assert 0 <= left < left + wide <= width + 0.01
        assert 0 <= top < top + high <= height + 0.01


def test_values_stand_where_the_picture_has_them():
    dataset = response()
    figure = figures.draw(dataset, kind="time_history")
    element = fromstring(report.svg_text(figure, "f0"))
    (panel,) = report.panels(figure, dataset, ["time"])
    (line,) = figure.axes[0].lines
    (group,) = (
        each
        for each in element.iter()
        if str(each.get("id")).startswith("f0-line2d") and each[0].get("clip-path")
    )
    drawn = np.array(re.findall(r"[ML] (\S+) (\S+)", group[0].get("d")), dtype=float)
    left, top, wide, high = panel["box"]
    (x0, x1), (y0, y1) = panel["stops"]
    places = [
        (line.get_xdata() - x0) / (x1 - x0) * wide + left,
        top + (y1 - line.get_ydata()) / (y1 - y0) * high,
    ]
    np.testing.assert_allclose(drawn[[0, -1]], np.transpose(places)[[0, -1]], atol=1e-3)
    assert panel["over"] == ("time", None)
    assert panel["factors"][0] == 1e3
    assert panel["labels"][0] == figure.axes[0].get_xlabel()


def test_axes_of_other_scales_have_values_at_even_distances():
    dataset, options = PICTURES["parameter_map"]()
    found = report.panels(figures.draw(dataset, options), dataset, ["clearance", "gear_ratio"])
    assert [panel["over"] for panel in found] == [("gear_ratio", "clearance")] * 3
    ax = Figure().subplots()
    ax.set_yscale("symlog", linthresh=0.1)
    ax.set_ylim(-10, 100)
    stops = report.stops(ax.yaxis)
    assert len(stops) == report.STOPS
    assert stops[0] == pytest.approx(-10)
    assert stops[-1] == pytest.approx(100)
    np.testing.assert_allclose(
        np.diff(ax.transScale.transform([(0, value) for value in stops])[:, 1], 2), 0, atol=1e-9
    )
    ax.set_yscale("log")
    assert len(report.stops(ax.yaxis)) == 2


def test_many_marks_are_an_image_and_few_are_not():
    def images(count):
        figure = figures.draw(section(count), kind="poincare_section")
        return fromstring(report.svg_text(figure, "f0")).findall(f".//{NAMESPACE}image")

    assert not images(report.MARKS)
    assert images(report.MARKS + 1)


def test_cells_hold_what_is_stored_of_each():
    data = diagram()
    found = sweep_points.cells(data, {"name": "s", "vary": {"joints.B.clearance": [1.0]}}, 10**6)
    (axis,) = found["parameters"]
    assert axis["stored"] == data.clearance.values.tolist()
    assert axis["key"] == "joints.B.clearance"
    assert axis["log"]
    assert found["ways"] == ["up", "down"]
    rows = {row["label"]: row for row in found["rows"]}
    np.testing.assert_array_equal(values(rows["Period"]), data.period.values)
    (chart,) = found["charts"]
    np.testing.assert_allclose(values(chart["y"]), 1e6 * data.journal_x.values[..., 0], rtol=1e-6)
    strange = {"vary": {"a'; rm -rf . #.clearance": [1.0]}}
    assert sweep_points.cells(data, strange, 10**6)["parameters"][0]["key"] == ""


def test_without_room_points_are_thinned_to_the_last_ones_and_numbers_left_out():
    data = diagram()
    found = sweep_points.cells(data, {}, 8 * 2 * 10 * 2)
    np.testing.assert_allclose(values(found["charts"][0]["y"]), 1e6 * data.journal_x.values[..., 2:, 0])
    assert found["note"].startswith(
        "2 of 4 section points of each point of the sweep are drawn here; in the result"
    )
    assert [row["label"] for row in found["rows"]] == ["Cell status", "Period", "Contacts begun per turn"]
    assert found["note"].endswith("in the result only: Smallest gap, Exponent a turn, Standard error")


def test_the_motion_is_that_of_the_mechanism_and_another_s_is_refused():
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-4)
    found, why = moving.moving(turning(mechanism), mechanism)
    assert why == ""
    crank, coupler, _ = (values(link["frames"]) for link in found["links"])
    np.testing.assert_allclose(crank[:, :2], 0.0, atol=1e-9)
    length = mechanism.links[0].length
    end = length * np.stack([np.cos(crank[:, 2]), np.sin(crank[:, 2])], -1)
    np.testing.assert_allclose(coupler[:, :2], end, atol=1e-7)
    wrong, why = moving.moving(turning(mechanism), jp.catalog.chunmei2002(clearance=2.9e-4, branch="lower"))
    assert wrong is not None  # the branch is a start alone
    other = jp.catalog.slider_crank()
    assert "angles of rod, slider are needed" in moving.moving(turning(mechanism), other)[1]
    bent = turning(mechanism)
    bent["angle"] = bent["angle"] + 0.2 * np.arange(3)
    assert "joints of this one are" in moving.moving(bent, mechanism)[1]
    assert "does not hold it" in moving.moving(bent, None)[1]


def test_a_sweep_of_motions_has_a_page_without_a_moving_picture(tmp_path):
    table = {"catalog": "chunmei2002", "clearance": 2.9e-4}
    cells = xr.concat([turning()] * 2, "clearance_of_B", data_vars="all").rename(status="cell_status")
    cells.attrs["swept"] = "clearance_of_B"
    swept = with_study(cells, mechanism=table, vary={"joints.B.clearance": [1e-4, 2e-4]})
    path, *_ = jp.report(swept, tmp_path / "cells.html")
    assert stored(path)["motion"] is None
    assert "not shown in motion: one motion is shown, not those of a sweep" in path.read_text(
        encoding="utf-8"
    )


def test_a_page_is_one_small_file_without_an_address_outside(page):
    path, picture = page
    text = path.read_text(encoding="utf-8")
    assert path.stat().st_size < 5e6
    assert picture.read_bytes()[:4] == b"\x89PNG"
    outside = re.sub(r"<script.*?</script>", "", text, flags=re.S)  # the browser tests see what scripts do
    assert not re.findall(r'(?:src|href)\s*=\s*["\']?(?:https?:|//)', outside)
    assert "<script>document.title" not in text
    assert stored(path)["cells"]["ways"] == ["up", "down"]
    assert len(stored(path)["cells"]["rows"]) == 6  # there is room for all


def test_in_all_numbers_parameters_have_their_names():
    """Key paths are for programs."""
    dataset = assessment()
    table = texts.numbers(dataset, [])
    for key, name in zip(dataset["parameter"].values, dataset["parameter_name"].values, strict=True):
        assert f", {key}" not in table
        assert f", {name}" in table


def test_numbers_that_are_none_and_closing_tags_are_safe_in_json():
    text = packed.text({"a": [np.nan, np.float32(1.5)], "</script>": "<!--"})
    assert "<" not in text
    assert json.loads(text) == {"a": [None, 1.5], "</script>": "<!--"}


def test_a_result_of_a_kind_without_figures_gets_a_page(tmp_path, monkeypatch):
    monkeypatch.setitem(jp.kinds.KINDS, "verdicts", Kind("verdicts", "tests.pages.test_report:verdicts"))
    status = {"flag_values": np.arange(1), "flag_meanings": "ok"}
    data = {"peak": ("joint", [5.0, 7.0], {"units": "N", "long_name": "peak force"})}
    data = xr.Dataset(data | {"status": ((), 0, status)}, {"joint": ["A", "B"]}, {"kind": "verdicts"})
    (path,) = jp.report(data, tmp_path / "v.html")
    text = path.read_text(encoding="utf-8")
    assert "all is well" in text
    assert "<th>Peak force, B</th><td>7 N</td>" in text


@analysis(outputs=Outputs("verdicts", {}, {}, lambda dataset: "all is well"))
def verdicts(mechanism: Moving):
    """Give no result: they are made by hand."""


def test_what_cannot_be_done_is_told(tmp_path):
    with pytest.raises(jp.InputError, match=r"ends in \.html"):
        jp.report(diagram(), tmp_path / "page.pdf")
    with pytest.raises(jp.InputError, match="kind"):
        jp.report(xr.Dataset(), tmp_path / "page.html")
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_the_page_beside_the_result(tmp_path, capsys):
    result = write_result(section(50), tmp_path / "one.nc")
    assert main(["report", str(result)]) == 0
    written = [tmp_path / "one.html", tmp_path / "one_report.png"]
    assert capsys.readouterr().out.splitlines() == [f"written {path}" for path in written]
    assert all(path.exists() for path in written)
    assert main(["report", str(result), "--out", str(tmp_path / "one.txt")]) == 2


def test_a_run_that_changed_its_study_is_told_with_the_values_that_it_had():
    text = 'kind = "response"\n[mechanism]\ncatalog = "duffing"\namplitude = 0.3\n[analysis]\nturns = 4\n'
    study = validate({"name": "s"} | parse(text)).model_dump(mode="json")
    record = {"study": study, "study_text": text, "software": {}, "environment": {}}
    assert texts.changes(record) == []
    for words in (
        "Save the study as <code>s_page.toml</code>",
        "jointplay run s_page.toml",
    ):  # not over its own file
        assert words in texts.again(record)
    study["analysis"]["turns"] = 6
    assert texts.changes(record) == ["analysis.turns = 6"]
    assert "jointplay run s.nc --out again" in texts.again(record)
    assert "analysis.turns = 6" in texts.again(record)
    assert texts.changes(record | {"study_text": "kind = "}) is None


def test_a_run_of_a_mechanism_alone_is_computed_again_as_its_kind():
    text = '[mechanism]\ncatalog = "chunmei2002"\n'
    study = validate({"name": "s_assess", "kind": "assess"} | parse(text)).model_dump(mode="json")
    record = {"study": study, "study_text": text, "software": {}, "environment": {}}
    assert texts.changes(record) == []
    assert "jointplay run s_assess_page.toml --set kind=assess" in texts.again(record)


def test_a_run_too_short_for_its_picture_has_a_page_that_says_so(tmp_path):
    short = section(0)
    short.attrs["provenance"] = json.dumps({"study": {"figure": {"kind": "poincare_section", "x": "none"}}})
    (path, _) = jp.report(short, tmp_path / "short.html")
    assert "The usual picture cannot be drawn: figure.x" in path.read_text(encoding="utf-8")


def test_a_slider_with_play_is_shown_by_its_corners():
    mechanism, data = loose_guide()
    found, _ = moving.moving(data, mechanism)
    assert [each["name"] for each in found["bearings"]] == ["B"]
    (guide,) = found["guides"]
    place = np.stack([data["true_x"].sel(link="slider"), data["true_y"].sel(link="slider")], -1)
    ways, forces = corners_led(mechanism, data["angle"].sel(link="slider").values, place)
    numbers = {name: values(guide[name]).reshape(ways.shape) for name in ("ways", "touch", "force")}
    np.testing.assert_allclose(numbers["ways"], ways / mechanism.joint("G").clearance, atol=1e-5)
    np.testing.assert_allclose(numbers["force"], forces, atol=1e-5)
    assert (numbers["touch"] == (forces > 0)).all()
    unknown = moving.moving(data.drop_vars("mode"), mechanism)[0]["guides"][0]
    assert "touch" not in unknown  # as a film leaves its corners hollow
    assert "corners in contact are filled" in report.guide_inset(0, guide)
    assert "corners in contact" not in report.guide_inset(0, unknown)
