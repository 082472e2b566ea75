"""Pages in a real browser: opened from a file, changed by clicks and keys, restored from their address."""

import shlex
from time import monotonic, sleep

import numpy as np
import pytest

import jointplay as jp
from jointplay.cli import main
from jointplay_page import report
from tests.figures.support.synthetic import section
from tests.figures.test_pictures import PICTURES
from tests.pages.browsing import canvas, click, complaints, drag, opened, text, until
from tests.pages.samples import diagram, turning
from tests.support.sweep_samples import CELLS, loaded, ran

pytestmark = pytest.mark.timeout(240)


def marked(browser):
    """Where a line stands in the first panel, in data coordinates; none where there is no line."""
    return browser.execute_script(
        """const line = jointplay.charts.svgs[0].querySelector('line.selected');
        return line && jointplay.charts.scales[0][0][1](Number(line.getAttribute('x1')))"""
    )


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return jp.report(diagram(), tmp_path_factory.mktemp("pages") / "sweep.html")[0]


@pytest.mark.nightly
def test_a_page_of_others_text_opens_from_a_file_without_a_word(chromium, page):
    opened(chromium, page)
    assert complaints(chromium) == []
    assert "broken in" in chromium.title
    assert chromium.title.startswith("</script>")  # it is the title, it was not run
    assert chromium.execute_script("return document.images.length") == 0  # neither the text's nor a still one
    assert "jointplay run sample.nc --out again" in text(chromium, "again")


@pytest.mark.long
def test_a_click_shows_the_point_that_is_nearest_and_how_to_compute_it_again(chromium, page):
    opened(chromium, page)
    assert marked(chromium) is None
    empty = canvas(chromium, "cell-chart0")
    assert not chromium.execute_script("return document.getElementById('cell').checkVisibility()")
    data = diagram()
    wanted = data.isel(clearance=3)
    click(chromium, 0.97e6 * float(wanted.clearance), 20.0)
    until(chromium, "return location.hash === '#cell=3'")
    assert f"vary.clearance=[{float(wanted.clearance)!r}]" in text(chromium, "cell-command")
    assert "Radial clearance 292.201 µm" in text(chromium, "cell-title")
    assert canvas(chromium, "cell-chart0") != empty
    rows = chromium.execute_script("return document.getElementById('cell-numbers').innerText").splitlines()
    assert rows[0].split() == ["up", "down"]
    assert "Period\t2\tnone found" in rows
    assert marked(chromium) == pytest.approx(1e6 * float(wanted.clearance), rel=1e-6)
    assert "Radial clearance (µm): 28" in text(chromium, "at0")  # of 283.4, where the pointer is
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_arrow_keys_move_the_point_and_stop_at_the_ends(chromium, page):
    opened(chromium, page, "#cell=3")
    body = chromium.switch_to.active_element
    body.send_keys("\ue014")  # right
    until(chromium, "return location.hash === '#cell=4'")
    body.send_keys("\ue014")
    body.send_keys("\ue012")  # left
    until(chromium, "return location.hash === '#cell=3'")


def test_a_dragged_part_is_looked_at_and_stands_in_the_address(chromium, page):
    opened(chromium, page)
    whole = chromium.execute_script("return jointplay.charts.svgs[0].getAttribute('viewBox')")
    drag(chromium, (20.0, 30.0), (200.0, 10.0))
    until(chromium, "return location.hash.includes('zoom0')")
    ends = [float(end) for end in chromium.execute_script("return jointplay.view.get('zoom0')").split(" ")]
    np.testing.assert_allclose(ends, [20, 200, 10, 30], rtol=0.02)
    click(chromium, 100.0, 20.0)
    until(chromium, "return location.hash.includes('cell=2')")
    address = chromium.current_url
    opened(chromium, page, address[address.index("#") :])
    seen = chromium.execute_script(
        """const svg = jointplay.charts.svgs[0], [x, y] = jointplay.charts.scales[0];
        const [left, top, width, height] = svg.getAttribute('viewBox').split(' ').map(Number);
        return [x[1](left), x[1](left + width), y[1](top + height), y[1](top)]"""
    )
    np.testing.assert_allclose(seen, ends, rtol=1e-6)
    assert "94.868" in text(chromium, "cell-title")
    chromium.execute_script("document.getElementById('whole0').click()")
    assert "zoom0" not in chromium.current_url
    assert chromium.execute_script("return jointplay.charts.svgs[0].getAttribute('viewBox')") == whole
    chromium.execute_script("location.hash = '#cell=0&theme=dark'")
    until(chromium, "return document.documentElement.dataset.theme === 'dark'")
    assert "10 µm" in text(chromium, "cell-title")
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_places_on_an_axis_of_another_scale_lie_between_its_values(chromium, tmp_path):
    dataset, _ = PICTURES["lyapunov"]()
    opened(chromium, jp.report(dataset, tmp_path / "exponents.html")[0])
    (ax, *_) = report.with_data(jp.figure(dataset))
    assert ax.get_yscale() == "symlog"
    low, high = np.sort(ax.get_ylim())
    values = [0.9 * low, 0.5 * low, 0.1 * low, 0.0, 0.5 * high]
    height = (
        "const [, [place]] = jointplay.charts.scales[0]; return arguments[0].map((value) => place(value))"
    )
    shares = np.array(chromium.execute_script(height, values))
    top, high = (chromium.execute_script(f"return jointplay.data.panels[0].box[{i}]") for i in (1, 3))
    drawn = ax.transAxes.inverted().transform(ax.transData.transform([(0, value) for value in values]))[:, 1]
    np.testing.assert_allclose(1 - (shares - top) / high, drawn, atol=2e-3)
    back = "const [, [place, value]] = jointplay.charts.scales[0]; return value(place(arguments[0]))"
    assert chromium.execute_script(back, values[2]) == pytest.approx(values[2])


def test_dark_and_light(chromium, page):
    opened(chromium, page, "#theme=light")
    look = "return getComputedStyle(document.querySelector('.picture')).filter"
    assert chromium.execute_script(look) == "none"
    chromium.execute_script("document.getElementById('theme').click()")
    assert "theme=dark" in chromium.current_url
    assert "invert" in chromium.execute_script(look)


@pytest.mark.nightly
def test_the_mechanism_moves_where_its_angles_say(chromium, tmp_path):
    path, _ = jp.report(
        turning(), tmp_path / "motion.html", mechanism=jp.catalog.chunmei2002(clearance=2.9e-4)
    )
    opened(chromium, path, "#frame=12")
    assert "18.75 ms" in text(chromium, "moment")

    def still():
        return chromium.execute_script("return document.getElementById('linkage').toDataURL()")

    first = still()
    body = chromium.switch_to.active_element
    body.send_keys(".")
    until(chromium, "return location.hash === '#frame=13'")
    assert still() != first
    body.send_keys(" ")
    until(chromium, "return document.getElementById('play').textContent === 'Pause'")
    begun = still()
    end = monotonic() + 30
    while still() == begun and monotonic() < end:
        sleep(0.05)
    assert still() != begun
    body.send_keys(" ")
    until(chromium, "return document.getElementById('play').textContent === 'Play'")
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_a_hundred_thousand_points_are_an_image_in_a_small_page(chromium, tmp_path):
    path, _ = jp.report(section(100_000), tmp_path / "points.html")
    assert path.stat().st_size < 2e6
    opened(chromium, path)
    assert chromium.execute_script("return jointplay.charts.svgs[0].querySelectorAll('image').length") > 0
    assert complaints(chromium) == []


def test_a_table_of_147_characters_is_seen_whole(chromium, page):
    opened(chromium, page)
    widths = chromium.execute_script(
        """const it = document.createElement("pre");
        it.textContent = "0".repeat(147);
        document.getElementById("numbers").append(it);
        return [it.scrollWidth, it.clientWidth]"""
    )
    assert widths[0] == widths[1]


def test_without_scripts_the_picture_is_there(page):
    html = page.read_text(encoding="utf-8")
    inside = html[html.index("<noscript>") : html.index("</noscript>")]
    assert 'src="data:image/png;base64,iVBOR' in inside


@pytest.mark.nightly
def test_the_command_of_a_point_computes_it_again(chromium, tmp_path, monkeypatch):
    whole = ran(loaded(CELLS), tmp_path / "out")
    path, _ = jp.report(whole, tmp_path / "cells.html")
    opened(chromium, path, "#cell=1 1")
    monkeypatch.chdir(tmp_path)
    program, *words = shlex.split(text(chromium, "cell-command"))
    assert [program, *words[:2]] == ["jointplay", "run", "cells_page.toml"]
    (tmp_path / words[1]).write_text(text(chromium, "study"), encoding="utf-8")
    assert main(words) == 0
    again = jp.open("one_cell/cells.nc")
    wanted = whole.isel(gap=[1], restitution=[1])
    assert again.lyapunov_exponent.identical(wanted.lyapunov_exponent)


@pytest.mark.nightly
def test_a_sweep_that_has_no_diagram_is_gone_through_by_its_slider(chromium, tmp_path):
    histories = ran(
        loaded(CELLS.replace("lyapunov", "response"), "analysis.samples_per_turn=20"), tmp_path / "out"
    )
    (path,) = jp.report(histories, tmp_path / "cells.html")
    opened(chromium, path)
    assert text(chromium, "cell-title") == "Gap 2.9, Restitution 0.7"
    chromium.execute_script(
        "const s = document.getElementById('slider0'); s.value = 2; s.dispatchEvent(new Event('input'))"
    )
    assert text(chromium, "cell-title") == "Gap 3.1, Restitution 0.7"
    assert canvas(chromium, "cell-chart0") > 0
    assert complaints(chromium) == []
