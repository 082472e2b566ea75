"""Pages in a real browser: opened from a file, changed by clicks and keys, restored from their address."""

import json
import shlex
from time import monotonic, sleep

import numpy as np
import pytest

import jointplay as jp
from jointplay.cli import main
from tests.figures.support.synthetic import section
from tests.pages.browsing import complaints, opened, text, until
from tests.pages.samples import diagram, turning
from tests.support.sweep_samples import CELLS, loaded, ran

pytestmark = pytest.mark.timeout(240)
CHART = "return Bokeh.documents[0].get_model_by_name('chart0')"


def click(browser, x, y):
    """Click in the first chart at data coordinates, as with a mouse."""
    from selenium.webdriver.common.action_chains import ActionChains

    place = browser.execute_script(
        """const view = Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name('chart0'));
        view.el.scrollIntoView({block: 'center'});
        const box = view.el.getBoundingClientRect(), frame = view.frame;
        const [x, y] = [frame.x_scale.compute(arguments[0]), frame.y_scale.compute(arguments[1])];
        return [box.left + x, box.top + y]""",
        x,
        y,
    )
    action = ActionChains(browser)
    action.w3c_actions.pointer_action.move_to_location(*map(round, place))
    action.w3c_actions.pointer_action.click()
    action.perform()


def drag(browser, steps):
    """Drag the first chart to and fro, as with a mouse, a step in a fiftieth of a second."""
    from selenium.webdriver.common.action_chains import ActionChains

    x, y = browser.execute_script(
        f"""const box = Bokeh.index.find_one((() => {{ {CHART} }})()).el.getBoundingClientRect();
        return [box.left + box.width / 2, box.top + box.height / 2]"""
    )
    action = ActionChains(browser, duration=20)
    pointer = action.w3c_actions.pointer_action
    pointer.move_to_location(round(x), round(y)).pointer_down()
    for step in range(steps):
        pointer.move_to_location(round(x + 40 * (step % 2) - 20), round(y))
    pointer.pointer_up()
    action.perform()


def drawing(browser, chart="chart0"):
    """A chart as a picture, in text, and the colour of its corner."""
    return browser.execute_script(
        f"""const view = Bokeh.index.find_one(Bokeh.documents[0].get_model_by_name('{chart}'));
        const canvas = view.export('png', false).canvas;
        return [canvas.toDataURL(), Array.from(canvas.getContext('2d').getImageData(3, 3, 1, 1).data)]"""
    )


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return jp.report(diagram(), tmp_path_factory.mktemp("pages") / "sweep.html")[0]


def test_a_page_of_others_text_opens_from_a_file_without_a_word(chromium, page):
    opened(chromium, page)
    assert complaints(chromium) == []
    assert "broken in" in chromium.title
    assert chromium.title.startswith("</script>")  # it is the title, it was not run
    assert chromium.execute_script("return document.images.length") == 0
    assert "jointplay run sample.nc --out again" in text(chromium, "again")


def test_a_click_shows_the_point_that_is_nearest_and_how_to_compute_it_again(chromium, page):
    opened(chromium, page)
    before, _ = drawing(chromium)
    assert not chromium.execute_script("return document.getElementById('cell').checkVisibility()")
    data = diagram()
    wanted = data.isel(clearance=3)
    click(chromium, 0.97e6 * float(wanted.clearance), 20.0)
    until(chromium, "return location.hash === '#cell=3'")
    assert f"vary.clearance=[{float(wanted.clearance)!r}]" in text(chromium, "cell-command")
    assert "Radial clearance 292.201 µm" in text(chromium, "cell-title")
    shown = chromium.execute_script("return jointplay.model('cell0').data.y")
    np.testing.assert_allclose(shown, 1e6 * wanted.journal_x.values.ravel(), rtol=1e-6)
    rows = chromium.execute_script("return document.getElementById('cell-numbers').innerText").splitlines()
    assert rows[0].split() == ["up", "down"]
    assert "Period\t2\tnone found" in rows
    assert drawing(chromium)[0] != before  # a line stands at the point
    assert complaints(chromium) == []


def test_arrow_keys_move_the_point_and_stop_at_the_ends(chromium, page):
    opened(chromium, page, "#cell=3")
    body = chromium.switch_to.active_element
    body.send_keys("\ue014")  # right
    until(chromium, "return location.hash === '#cell=4'")
    body.send_keys("\ue014")
    body.send_keys("\ue012")  # left
    until(chromium, "return location.hash === '#cell=3'")


def test_the_view_is_in_the_address_and_comes_back(chromium, page):
    opened(chromium, page)
    chromium.execute_script(f"const c = (() => {{ {CHART} }})(); c.x_range.setv({{start: 20, end: 200}})")
    chromium.execute_script("jointplay.zoomed()")
    click(chromium, 100.0, 20.0)
    until(chromium, "return location.hash.includes('cell=2')")
    address = chromium.current_url
    opened(chromium, page, address[address.index("#") :])
    assert chromium.execute_script(
        f"const c = (() => {{ {CHART} }})(); return [c.x_range.start, c.x_range.end]"
    ) == [20, 200]
    assert "94.868" in text(chromium, "cell-title")
    chromium.execute_script("location.hash = '#cell=0&theme=dark'")
    until(chromium, "return document.documentElement.dataset.theme === 'dark'")
    assert "10 µm" in text(chromium, "cell-title")
    assert complaints(chromium) == []


def test_dark_and_light(chromium, page):
    opened(chromium, page, "#theme=light")
    assert drawing(chromium)[1] == [255, 255, 255, 255]
    chromium.execute_script("document.getElementById('theme').click()")
    assert "theme=dark" in chromium.current_url
    assert drawing(chromium)[1] == [22, 24, 27, 255]


@pytest.mark.long
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


@pytest.mark.long
def test_a_hundred_thousand_points_are_drawn_and_moved(chromium, tmp_path):
    path, _ = jp.report(section(100_000), tmp_path / "points.html")
    assert path.stat().st_size < 5e6
    opened(chromium, path)
    assert (
        chromium.execute_script(
            "return Math.max(...Bokeh.documents[0].get_model_by_name('chart0').renderers.map("
            "each => (each.data_source.get_column('x') || []).length))"
        )
        == 100_000
    )
    chromium.execute_script(
        f"""const chart = (() => {{ {CHART} }})();
        chart.toolbar.tools.find((tool) => tool.type === 'PanTool').active = true;
        let before = chart.x_range.start;
        window.frames_with_motion = 0;
        const look = () => {{
          frames_with_motion += chart.x_range.start !== before;
          before = chart.x_range.start;
          requestAnimationFrame(look);
        }};
        look();"""
    )
    begun = monotonic()
    drag(chromium, steps=40)
    frames, seconds = chromium.execute_script("return frames_with_motion"), monotonic() - begun
    print(json.dumps({"points": 100_000, "frames": frames, "per_second": round(frames / seconds, 1)}))
    assert frames > 5
    assert complaints(chromium) == []


def test_without_scripts_the_picture_is_there(page):
    html = page.read_text(encoding="utf-8")
    inside = html[html.index("<noscript>") : html.index("</noscript>")]
    assert 'src="data:image/png;base64,iVBOR' in inside


@pytest.mark.long
def test_the_command_of_a_point_computes_it_again(chromium, tmp_path, monkeypatch):
    whole = ran(loaded(CELLS), tmp_path / "out")
    path, _ = jp.report(whole, tmp_path / "cells.html")
    opened(chromium, path, "#cell=1 1")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cells.toml").write_text(text(chromium, "study"), encoding="utf-8")
    program, *words = shlex.split(text(chromium, "cell-command"))
    assert program == "jointplay"
    assert main(words) == 0
    again = jp.open("one_cell/cells.nc")
    wanted = whole.isel(gap=[1], restitution=[1])
    assert again.lyapunov_exponent.identical(wanted.lyapunov_exponent)


@pytest.mark.long
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
    shown = chromium.execute_script("return jointplay.model('cell0').data")
    one = jp.cell(histories, gap=3.1, restitution=0.7)
    np.testing.assert_allclose(shown["x"][:-1], one.time, rtol=1e-6)
    np.testing.assert_allclose(shown["y"][:-1], one.state_value.sel(state="y"), rtol=1e-6, atol=1e-6)
    assert complaints(chromium) == []
